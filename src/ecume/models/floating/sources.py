"""The laws behind a scene of floats, whose docstrings cite the papers."""

from __future__ import annotations

from typing import Any

from ecume.laws import (
    brownian,
    capillarity,
    contact,
    dipoles,
    drag,
    ellipsoids,
    ewald,
    flotation,
    images,
    lines,
    meniscus,
    multipole,
    pair_laws,
    quadrupoles,
)
from ecume.models.model import Source


def laws_of(scene: Any) -> list[Source]:
    """Where floats sit, how they attract, what the dish does, drag and collisions."""
    charge = flotation.CHARGES.get(str(scene.interaction.charge))
    laws: list[Source] = [charge] if charge else []
    row = pair_laws.PAIR_LAWS.get(str(scene.interaction.law))
    laws += row.papers if row is not None else ()
    laws += [multipole.solve] if scene.interaction.method != "superposition" else []
    laws += [ewald.short_energy, ewald.smooth_wave, ewald.grid_error] if scene.interaction.sum == "grid" else []
    magnets = any(given.magnetic_moment for given in (*scene.floats, *scene.rows))
    laws += [dipoles.dipole_force] if magnets else []
    if scene.dish is not None:
        laws += capillarity.WALLS.get(str(scene.dish.law), ())
        laws += [meniscus.dish_height, *([images.plane_image_force] if scene.dish.image != "none" else [])]
    laws += [drag.immersion_factor, drag.stokes_friction] if scene.motion.drag else []
    if scene.shaped:
        laws += [ellipsoids.ellipsoid_undulation, lines.spread_charges, quadrupoles.quadrupole_energy]
        laws += [ellipsoids.ellipsoid_friction, ellipsoids.ellipsoid_turning_friction] if scene.motion.drag else []
    laws += [brownian.diffusivity] if scene.motion.temperature else []
    soft = scene.contacts.law == "spring-dashpot"
    return [*laws, *([contact.spring_push, contact.dashpot_restitution] if soft else [contact.impulse])]
