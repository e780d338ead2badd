"""The motion of a float released near the wall of a round dish, beside an integration of order 8."""

from __future__ import annotations

import math
from itertools import product

from ecume.models.liquids import liquid_of
from ecume.validation import float_motion
from ecume.validation.rows import Row, within
from ecume.validation.runner import floating_scene, frames_of

FLOATS = {"heavy": 1300.0, "light": 200.0}
"""Densities, kg/m^3."""
GLASSES = {"wetting": 45.0, "non-wetting": 120.0}
"""Contact angles, deg."""
DISHES = (10.0, 25.0)
"""Radii, mm."""
FROM_WALL = 4.0
"""Of the center at the start, mm."""
WAY = 2.0
"""How far it may go, mm: a float that climbs has not touched the wall by then."""
TOLERANCE = 1e-3
"""Over the way."""


def rows() -> list[Row]:
    """The drift of each float at each wall of each dish, with and without drag."""
    return [drift(*choice) for choice in product(FLOATS, GLASSES, DISHES, (False, True))]


def drift(kind: str, glass: str, dish: float, drag: bool) -> Row:
    """Compare the displacement of a float that should have moved 2 mm (mm); towards the wall is positive."""
    start = 1e-3 * (dish - FROM_WALL)
    changes = [
        f"particles[0].density={FLOATS[kind]}",
        f"particles[0].positions=[[{start!r}, 0.0]]",
        f"dish.radius={dish} mm",
        f"dish.contact_angle={GLASSES[glass]} deg",
        f"hydrodynamics.drag={'stokes' if drag else 'none'}",
    ]
    scene = floating_scene("walls", changes)
    bowl = float_motion.Bowl(1e-3 * dish, math.radians(GLASSES[glass]), liquid_of(scene))
    (body,) = float_motion.bodies_of(scene)
    time = float_motion.time_in_bowl(body, start, 1e-3 * WAY, bowl)
    expected = 1e3 * (float_motion.place_in_bowl(body, start, time, bowl) - start)
    (*_, last) = frames_of("walls", [*changes, f"duration={time!r}", f"frame_every={time!r}"])
    computed = 1e3 * (float(last.arrays["position"][0, 0]) - start)
    name = f"{kind}, {glass} wall, dish of {dish:g} mm, {'drag' if drag else 'no drag'}, {time:.3g} s: drift (mm)"
    return within(name, computed, expected, TOLERANCE * WAY)
