"""The laws behind a scene of soft spheres, whose docstrings cite the papers."""

from __future__ import annotations

from typing import Any

from ecume.laws import elasticity, friction, interfaces, long_range, lubrication, surfaces
from ecume.models.model import Source
from ecume.models.soft import schemes


def laws_of(scene: Any) -> list[Source]:
    """Films, surfaces, what acts across."""
    films = scene.films
    laws: list[Source] = [lubrication.squeeze_friction, lubrication.shear_friction]
    laws += [elasticity.contact_size, *surfaces.SURFACES[films.surface]]
    laws += [interfaces.INTERFACES[films.interface]] if films.interface != "rigid" else []
    laws += [friction.holding_force] if films.friction != "none" else []
    return [*laws, *long_range.REMOTE[scene.remote.law], *SCHEME_LAWS[scene.stepping.scheme]]


SCHEME_LAWS: dict[str, list[Source]] = {"esdirk4": [schemes.esdirk4], "tr-bdf2": [schemes.tr_bdf2]}
