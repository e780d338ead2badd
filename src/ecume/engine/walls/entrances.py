"""Openings as entrances: where particles come in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume.engine.walls.surfaces import PLANE, Surfaces, described
from ecume.errors import BadInput
from ecume.units import Array


class Entrance(NamedTuple):
    """The part of a flat wall that an opening is."""

    normal: Array
    """(d,) unit, to the inside"""
    middle: Array
    """(d,) m, on the wall"""
    along: Array
    """(d - 1, d) unit vectors in the wall"""
    half: Array
    """(d - 1,) m: how far it reaches along each, at most"""
    low: Array
    """(d,) m: the corners of the opening's box"""
    high: Array

    def at(self, shares: Array) -> Array:
        """(n, d) places on the wall, of shares (n, d - 1) in (0, 1)."""
        places: Array = self.middle + ((2.0 * shares - 1.0) * self.half) @ self.along
        return places

    def holds(self, places: Array) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """(n,) whether places on the wall are in the opening."""
        slack = 1e-9 * np.linalg.norm(self.high - self.low)
        within = (places >= self.low - slack) & (places <= self.high + slack)
        return np.asarray(within.all(axis=1))

    def area(self) -> float:
        """m^2 in 3D, m in 2D; of an axis-parallel wall, or in 2D of any wall."""
        return float(np.prod(2.0 * self.half))


def entrance(walls: Surfaces, hole: int) -> Entrance:
    """An opening as an entrance. Raises BadInput in a curved wall, and where the wall is not in the opening's box.

    >>> from ecume.engine.walls import box, opening
    >>> door = entrance(opening(box((0, 0), (2, 1)), 0, (0.0, 0.2), (0.0, 0.6)), 0)
    >>> door.normal.tolist(), round(door.area(), 12)
    ([1.0, 0.0], 0.4)
    """
    d, wall = walls.dimension, int(walls.hole[hole])
    if walls.kind[wall] != PLANE:
        raise BadInput(f"entrance: got an opening in {described(walls, wall)}; expected one in a flat wall")
    normal, low, high = walls.place[wall, :d], walls.low[hole, :d], walls.high[hole, :d]
    along = np.linalg.svd(normal[None])[2][1:]
    edge = _border(normal, float(walls.size[wall]), low, high)
    if not len(edge):
        raise BadInput(
            f"entrance: {described(walls, wall)} does not go through the box {low.tolist()}, {high.tolist()}"
        )
    reach = edge @ along.T
    first, last = reach.min(axis=0), reach.max(axis=0)
    middle = walls.size[wall] * normal + 0.5 * (first + last) @ along
    return Entrance(normal, middle, along, 0.5 * (last - first), low, high)


def _border(normal: Array, size: float, low: Array, high: Array) -> Array:
    """The intersections of a plane with the edges of a box, (n, d)."""
    d, found = len(normal), []
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(d, -1).T
    slack = 1e-9 * (np.abs(corners).max() + abs(size))
    for axis in range(d):
        for corner in corners[corners[:, axis] == low[axis]]:
            end = np.where(np.arange(d) == axis, high, corner)
            here, there = normal @ corner - size, normal @ end - size
            if abs(here) <= slack:
                found.append(corner)
            if abs(there) <= slack:
                found.append(end)
            if here * there < 0.0:
                found.append(corner + here / (here - there) * (end - corner))
    return np.array(found).reshape(-1, d)
