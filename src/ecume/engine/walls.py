"""Walls a particle's center may not pass: a disc (or ball) seen from inside, and planes.

Distance is positive inside; the normal points inward and is the slope of the distance.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.units import Array


class Walls(NamedTuple):
    """All walls of a scene. `disc_radius` is infinite where there is no disc, planes are n.x = offset with n inward."""

    disc_radius: float
    normal: Array
    """(K, d) inward unit normals of the planes"""
    offset: Array
    """(K,)"""


def no_walls(dimension: int = 2) -> Walls:
    """The open surface."""
    return Walls(math.inf, np.zeros((0, dimension)), np.zeros(0))


def disc(radius: float, dimension: int = 2) -> Walls:
    """The inside of a disc around the origin."""
    return Walls(radius, np.zeros((0, dimension)), np.zeros(0))


def box(low: Array, high: Array) -> Walls:
    """The inside of a rectangle or a cuboid."""
    dimension = len(low)
    normal = np.concatenate([np.eye(dimension), -np.eye(dimension)])
    return Walls(math.inf, normal, np.concatenate([low, -np.asarray(high)]))


@compiled
def wall_count(walls: Walls) -> int:
    """How many walls there are: the disc, if any, is number 0; the planes follow."""
    return len(walls.offset) + (1 if walls.disc_radius < np.inf else 0)


@compiled
def wall_distance(walls: Walls, number: int, position: Array, normal: Array) -> float:
    """How far inside wall `number` the point is; its inward normal is written to `normal`.

    At the very center of a disc no direction leads to the wall; any will do, since every wall is equally far.
    """
    dimension = len(position)
    if walls.disc_radius < np.inf:
        if number == 0:
            square = 0.0
            for axis in range(dimension):
                square += position[axis] * position[axis]
            radius = math.sqrt(square)
            for axis in range(dimension):
                normal[axis] = -position[axis] / radius if radius > 0.0 else (1.0 if axis == 0 else 0.0)
            return walls.disc_radius - radius
        number -= 1
    distance = -walls.offset[number]
    for axis in range(dimension):
        normal[axis] = walls.normal[number, axis]
        distance += walls.normal[number, axis] * position[axis]
    return distance
