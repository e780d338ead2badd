"""The laws behind a scene of soft spheres, whose docstrings cite the papers."""

from __future__ import annotations

from typing import Any

from ecume.laws import elasticity, interfaces, lubrication, remote, rubbing, surfaces
from ecume.models.model import Source
from ecume.models.soft import schemes


def laws_of(scene: Any) -> list[Source]:
    """Films, surfaces, what acts across."""
    films = scene.films
    laws: list[Source] = [lubrication.squeeze_friction, lubrication.shear_friction, elasticity.contact_size]
    laws += [*surfaces.SURFACES[films.surface].papers, interfaces.INTERFACES[films.interface]]
    laws += rubbing.FRICTIONS[films.friction].papers
    row = remote.REMOTE[scene.remote.law]
    return [*laws, row.energy, row.force, row.slope, schemes.SCHEMES[scene.stepping.scheme].paper]
