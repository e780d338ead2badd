"""The laws behind a scene of floats, whose docstrings cite the papers."""

from __future__ import annotations

from typing import Any

from ecume.laws import (
    brownian,
    capillarity,
    drag,
    ellipsoids,
    flotation,
    images,
    meniscus,
    pair_laws,
)
from ecume.models.floating.choices import chosen_by
from ecume.models.model import Source


def laws_of(scene: Any) -> list[Source]:
    """Where floats sit, how they attract, what the dish does, drag and collisions."""
    charge = flotation.CHARGES.get(str(scene.interaction.charge))
    laws: list[Source] = [charge] if charge else []
    row = pair_laws.PAIR_LAWS.get(str(scene.interaction.law))
    laws += row.papers if row is not None else ()
    chosen = chosen_by(scene)
    laws += [law for row in chosen.interactions for law in row.laws]
    if scene.dish is not None:
        laws += capillarity.WALLS.get(str(scene.dish.law), ())
        laws += [meniscus.dish_height, *([images.plane_image_force] if scene.dish.image != "none" else [])]
    laws += [drag.immersion_factor, drag.stokes_friction] if scene.hydrodynamics.resists else []
    if scene.shaped:
        laws += (
            [ellipsoids.ellipsoid_friction, ellipsoids.ellipsoid_turning_friction]
            if scene.hydrodynamics.resists
            else []
        )
    laws += [brownian.diffusivity] if scene.hydrodynamics.brownian else []
    return [*laws, *chosen.contacts.laws]
