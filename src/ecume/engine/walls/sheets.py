"""Surfaces packed for compiled loops: where they are at a time, and how far inside a point is."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled_inside
from ecume.engine.cells import Integers
from ecume.engine.walls.surfaces import PLANE, Surfaces
from ecume.engine.walls.vectors import Vector, dot, length, plus, scaled
from ecume.errors import BadInput
from ecume.units import Array

SIZE, SPEED, RESTITUTION, TANGENTIAL, SCALE = 3, 4, 7, 8, 9
"""Columns of `Sheet.number`; the first three are the place."""
GRAIN = 1e-12
"""A point that is outside by less than this part of the lengths it is computed from is on the surface."""


class Sheet(NamedTuple):
    """Surfaces with their coefficients, as few arrays: `Surfaces` explains the numbers."""

    kind: Integers
    """(K, 3): kind, and the range of an obstacle's planes"""
    number: Array
    """(K, 10): place, size, velocity, restitution, tangential factor, the length of the whole"""
    hole: Integers
    """(M,)"""
    part: Array
    """(M, 6): the two corners of each opening"""


def sheet(walls: Surfaces, restitution: Any = 1.0, tangential: Any = 1.0) -> Sheet:
    """Pack them. The coefficients, in [0, 1], are one number for all surfaces, or one for each."""
    number = np.zeros((len(walls.kind), 10))
    number[:, :3], number[:, SIZE], number[:, SPEED : SPEED + 3] = walls.place, walls.size, walls.velocity
    number[:, RESTITUTION] = _proportion(restitution, "restitution", len(walls.kind))
    number[:, TANGENTIAL] = _proportion(tangential, "tangential", len(walls.kind))
    centers = walls.place * (walls.kind != PLANE)[:, None]
    number[:, SCALE] = max((float(np.abs(part).max()) for part in (centers, walls.size) if part.size), default=0.0)
    kind = np.column_stack([walls.kind, walls.face])
    # An opening is flat, and a point of its surface is there only up to rounding.
    slack = 1e-9 * np.linalg.norm(walls.high - walls.low, axis=1)[:, None]
    return Sheet(kind, number, walls.hole.copy(), np.hstack([walls.low - slack, walls.high + slack]))


def _proportion(given: Any, name: str, count: int) -> Array:
    array = np.asarray(given, np.float64)
    if array.shape not in ((), (count,)) or not np.all((array >= 0.0) & (array <= 1.0)):
        raise BadInput(f"{name}: got {given!r}; expected a number from 0 to 1, or one for each of {count} surfaces")
    return array


@compiled_inside
def place_of(number: Array, k: int) -> Vector:
    """The normal of plane k, the center of sphere k."""
    return number[k, 0], number[k, 1], number[k, 2]


@compiled_inside
def wall_velocity(number: Array, k: int) -> Vector:
    """The velocity of surface k."""
    return number[k, SPEED], number[k, SPEED + 1], number[k, SPEED + 2]


@compiled_inside
def from_center(number: Array, k: int, x: Vector, time: float) -> Vector:
    """The vector from the center of sphere k, at that time, to x."""
    return plus(plus(x, -1.0, place_of(number, k)), -time, wall_velocity(number, k))


@compiled_inside
def inward_normal(kind: Integers, number: Array, k: int, x: Vector, time: float) -> Vector:
    """The slope of the gap. At the very center of a circle every direction leads to it; the first axis is taken."""
    if kind[k, 0] == PLANE:
        return place_of(number, k)
    out = from_center(number, k, x, time)
    away = length(out)
    return scaled(-kind[k, 0] / away, out) if away > 0.0 else (-1.0 * kind[k, 0], 0.0, 0.0)


@compiled_inside
def gap_to(kind: Integers, number: Array, k: int, x: Vector, time: float) -> float:
    """The distance of the point from surface k, positive inside."""
    if kind[k, 0] == PLANE:
        normal = place_of(number, k)
        return dot(normal, x) - float(number[k, SIZE]) - time * dot(normal, wall_velocity(number, k))
    return float(kind[k, 0] * (number[k, SIZE] - length(from_center(number, k, x, time))))


@compiled_inside
def piece_gap(kind: Integers, number: Array, k: int, x: Vector, time: float) -> tuple[float, int, int]:
    """The gap to the wall or obstacle that begins with surface k, the surface that sets it, and where the next begins.

    An obstacle's gap is that of its farthest face.
    """
    gap, nearest, stop = gap_to(kind, number, k, x, time), k, max(int(kind[k, 2]), k + 1)
    for other in range(k + 1, stop):
        its = gap_to(kind, number, other, x, time)
        if its > gap:
            gap, nearest = its, other
    return gap, nearest, stop


@compiled_inside
def worst_gap(kind: Integers, number: Array, x: Vector, time: float) -> tuple[float, int]:
    """The smallest gap, and its surface."""
    worst, which, k = np.inf, -1, 0
    while k < kind.shape[0]:
        gap, nearest, k = piece_gap(kind, number, k, x, time)
        if gap < worst:
            worst, which = gap, nearest
    return worst, which


@compiled_inside
def grain_at(number: Array, k: int, x: Vector) -> float:
    """The distance below which a gap to surface k counts as zero: rounding."""
    return GRAIN * (float(number[k, SCALE]) + length(x))


@compiled_inside
def hole_at(hole: Integers, part: Array, number: Array, k: int, moment: tuple[Vector, float]) -> int:
    """The opening of surface k that is there, or -1."""
    x, time = moment
    y = plus(x, -time, wall_velocity(number, k))
    for m in range(hole.shape[0]):
        within = part[m, 0] <= y[0] <= part[m, 3] and part[m, 1] <= y[1] <= part[m, 4]
        if hole[m] == k and within and part[m, 2] <= y[2] <= part[m, 5]:
            return m
    return -1
