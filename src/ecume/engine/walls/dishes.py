"""The walls of a floating raft, which a center may not pass: a disc seen from inside, and straight lines.

Distance is positive inside; the normal points inward and is the slope of the distance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled_inside
from ecume.units import Array


class Walls(NamedTuple):
    """All walls of a scene. `disc_radius` is infinite where there is no disc; lines are n.x = offset with n inward."""

    disc_radius: float
    normal: Array
    """(K, 2) inward unit normals of the lines"""
    offset: Array
    """(K,)"""


def no_walls() -> Walls:
    """The open surface."""
    return Walls(math.inf, np.zeros((0, 2)), np.zeros(0))


def disc(radius: float) -> Walls:
    """The inside of a disc around the origin."""
    return Walls(radius, np.zeros((0, 2)), np.zeros(0))


def box(low: Sequence[float], high: Sequence[float]) -> Walls:
    """The inside of a rectangle."""
    normal = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    return Walls(math.inf, normal, np.array([low[0], low[1], -high[0], -high[1]]))


@compiled_inside
def wall_count(walls: Walls) -> int:
    """How many walls there are: the disc, if any, is number 0; the lines follow."""
    return len(walls.offset) + (1 if walls.disc_radius < np.inf else 0)


@compiled_inside
def wall_distance(walls: Walls, number: int, x: float, y: float) -> tuple[float, float, float]:
    """How far inside wall `number` the point (x, y) is, and the wall's inward normal there.

    At the very center of a disc every direction leads to the wall; the first axis is taken.
    """
    if walls.disc_radius < np.inf:
        if number == 0:
            radius = math.sqrt(x * x + y * y)
            if radius == 0.0:
                return walls.disc_radius, -1.0, 0.0
            return walls.disc_radius - radius, -x / radius, -y / radius
        number -= 1
    normal_x, normal_y = walls.normal[number, 0], walls.normal[number, 1]
    return normal_x * x + normal_y * y - walls.offset[number], normal_x, normal_y
