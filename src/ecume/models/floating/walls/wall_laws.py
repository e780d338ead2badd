"""The forces and energies of walls on floats in compiled code: the only place that reads `Parameters.wall_law`."""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import admit, compiled_inside
from ecume.engine.walls import wall_distance
from ecume.laws import capillarity, special
from ecume.laws.capillarity import (
    dish_energy,
    dish_force,
    plane_wall_energy,
    plane_wall_force,
    two_point_legacy_energy,
    two_point_legacy_force,
)
from ecume.models.floating.parameters import CAPILLARY_LENGTH, Parameters
from ecume.units import Array

admit(special, capillarity)

NO_WALL_LAW, DISH, LEGACY_DISH, PLANE, TABLED = range(5)
"""Laws of walls in compiled code: of `meniscus` and `linear` the far field in a dish or at a plane wall, of
`two-point-legacy`, and of exact profiles and images a table.
"""
HEIGHT, IMAGE = 2, 4
"""Rows of a table: each of these two, and its slope over ln(d) below it. Row 0 starts with ln(d) of the first node and
the step; row 1 holds the distances.
"""


@compiled_inside
def acts(parameters: Parameters) -> bool:
    """Whether the walls act on floats from afar."""
    return parameters.wall_law != NO_WALL_LAW


def is_far_field(wall_law: int) -> bool:
    """Whether the walls have the meniscus of superposition, without images, or none: what other methods refine."""
    return wall_law in (NO_WALL_LAW, DISH, PLANE)


def wall_stiffness(parameters: Parameters) -> float:
    """|dF/dd| of the walls for the float on which they act most (N/m), as near as the smallest float comes."""
    strongest = float(np.max(np.abs(parameters.wall_strength), initial=0.0))
    if parameters.wall_law != TABLED:
        return strongest / float(parameters.pair[CAPILLARY_LENGTH]) ** 2
    floats, distance = parameters.floats, parameters.wall_table[1]
    near = distance >= float(np.min(floats.radius))
    stiffness = 0.0
    for row, strength in ((HEIGHT, strongest), (IMAGE, parameters.image_strength * float(np.max(floats.charge**2)))):
        force = parameters.wall_table[row + 1] / distance
        stiffness += strength * float(np.max(np.abs(np.gradient(force, distance)[near])))
    return stiffness


@compiled_inside
def wall_force(
    parameters: Parameters, number: int, place: tuple[float, float], strength: float, charge: float
) -> tuple[float, float, float]:
    """The force of wall `number` on a charge at a place (N), positive away from the wall, and the wall's normal."""
    walls, length, (x, y) = parameters.walls, parameters.pair[CAPILLARY_LENGTH], place
    distance, inward_x, inward_y = wall_distance(walls, number, x, y)
    if parameters.wall_law == PLANE:
        away = plane_wall_force(distance, strength, length)
    elif parameters.wall_law == DISH:
        away = dish_force(math.sqrt(x * x + y * y), strength, length, walls.disc_radius)
    elif parameters.wall_law == TABLED:
        mirrored = parameters.image_strength * charge * charge
        away = -strength * tabled(parameters.wall_table, HEIGHT, distance)[1]
        away -= mirrored * tabled(parameters.wall_table, IMAGE, distance)[1]
    else:
        away = two_point_legacy_force(math.sqrt(x * x + y * y), strength, length, walls.disc_radius)
    return away, inward_x, inward_y


@compiled_inside
def wall_energy(
    parameters: Parameters, number: int, place: tuple[float, float], strength: float, charge: float
) -> tuple[float, float]:
    """The energy of a charge at a place beside wall `number` (J): in the meniscus, and in its mirror image."""
    walls, length, (x, y) = parameters.walls, parameters.pair[CAPILLARY_LENGTH], place
    if parameters.wall_law == PLANE:
        return plane_wall_energy(wall_distance(walls, number, x, y)[0], strength, length), 0.0
    if parameters.wall_law == DISH:
        return dish_energy(math.sqrt(x * x + y * y), strength, length, walls.disc_radius), 0.0
    if parameters.wall_law == TABLED:
        distance = wall_distance(walls, number, x, y)[0]
        mirrored = parameters.image_strength * charge * charge
        height, image = tabled(parameters.wall_table, HEIGHT, distance), tabled(parameters.wall_table, IMAGE, distance)
        return strength * height[0], mirrored * image[0]
    return two_point_legacy_energy(math.sqrt(x * x + y * y), strength, length, walls.disc_radius), 0.0


@compiled_inside
def tabled(table: Array, row: int, distance: float) -> tuple[float, float]:
    """A tabled quantity and its slope over the distance; beyond the ends as at the ends."""
    start, step = table[0, 0], table[0, 1]
    last = table.shape[1] - 1
    within = min(max(distance, table[1, 0]), table[1, last])
    place = min(max((math.log(within) - start) / step, 0.0), float(last))
    left = min(int(place), last - 1)
    t = place - left
    u = 1.0 - t
    rise = table[row, left + 1] - table[row, left]
    before, after = step * table[row + 1, left] - rise, rise - step * table[row + 1, left + 1]
    value = u * table[row, left] + t * table[row, left + 1] + t * u * (u * before + t * after)
    slope = rise + (1.0 - 2.0 * t) * (u * before + t * after) + t * u * (after - before)
    return value, slope / (step * within)
