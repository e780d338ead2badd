"""Enclosures of floats: 2D walls as compiled loops read them, and the region inside.

An enclosure is convex and contains the origin: a circle around the origin, straight lines, or both. The distance from a
wall is positive inside; the normal points inward and is the gradient of the distance.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled_inside
from ecume.engine.walls.surfaces import INSIDE, PLANE, Surfaces
from ecume.errors import BadInput
from ecume.units import Array

ARCS = 360
"""Points of the outline of a circle."""


class Walls(NamedTuple):
    """The walls of an enclosure. `disc_radius` is infinite without a circle; lines are n.x = offset with n inward."""

    disc_radius: float
    normal: Array
    """(K, 2) inward unit normals of the lines"""
    offset: Array
    """(K,) m"""


def no_walls() -> Walls:
    """The open surface."""
    return Walls(math.inf, np.zeros((0, 2)), np.zeros(0))


def enclosed_by(surfaces: Surfaces) -> Walls:
    """The walls of a 2D shape. Raises BadInput if it is not convex, or does not contain the origin.

    >>> from ecume.engine.walls import box
    >>> enclosed_by(box((-2.0, -1.0), (2.0, 1.0))).offset.tolist()
    [-2.0, -1.0, -2.0, -1.0]
    """
    flat, round_ones = surfaces.kind == PLANE, surfaces.kind == INSIDE
    if surfaces.dimension != 2 or np.any(surfaces.face) or not np.all(flat | round_ones):
        raise BadInput("enclosure: expected a convex 2D shape")
    if np.any(surfaces.place[round_ones]) or np.any(surfaces.size[flat] > 0.0):
        raise BadInput("enclosure: expected a shape around the origin")
    radius = float(surfaces.size[round_ones].min(initial=math.inf))
    return Walls(radius, np.ascontiguousarray(surfaces.place[flat, :2]), surfaces.size[flat].copy())


@compiled_inside
def wall_count(walls: Walls) -> int:
    """The number of walls: the circle, if there is one, is number 0; the lines follow."""
    return len(walls.offset) + (1 if walls.disc_radius < np.inf else 0)


@compiled_inside
def is_circle(walls: Walls, number: int) -> bool:
    """Whether a wall is the circle."""
    return number == 0 and walls.disc_radius < np.inf


@compiled_inside
def wall_distance(walls: Walls, number: int, x: float, y: float) -> tuple[float, float, float]:
    """The distance of the point (x, y) from wall `number`, positive inside, and the wall's inward normal there.

    At the very center of a circle every direction leads to the wall; the first axis is taken.
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


def clearances(walls: Walls, place: Any) -> list[float]:
    """The distances of a point from all walls (m)."""
    x, y = float(place[0]), float(place[1])
    return [float(wall_distance(walls, number, x, y)[0]) for number in range(wall_count(walls))]


def shrunk(walls: Walls, by: float) -> Walls:
    """The enclosure of the centers of discs of this radius (m)."""
    return Walls(walls.disc_radius - by, walls.normal, walls.offset + by)


def corners(walls: Walls) -> Array:
    """The corners of an enclosure by lines alone, counterclockwise, (K, 2) m. Raises BadInput without corners."""
    if walls.disc_radius < math.inf or len(walls.offset) < 3:
        raise BadInput("corners: expected an enclosure by three or more lines")
    order = np.argsort(np.arctan2(-walls.normal[:, 1], -walls.normal[:, 0]), kind="stable")
    one, after = order, np.roll(order, -1)
    (a, b), (c, d) = walls.normal[one].T, walls.normal[after].T
    first, second, turn = walls.offset[one], walls.offset[after], a * d - b * c
    return np.stack([(first * d - second * b) / turn, (a * second - c * first) / turn], axis=1)


def outline(walls: Walls) -> Array:
    """The edge of the region inside, counterclockwise, as points of a polygon (m). Raises BadInput if it is open."""
    if walls.disc_radius == math.inf:
        return corners(walls)
    angle = np.linspace(0.0, 2.0 * np.pi, ARCS, endpoint=False)
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    outward = -unit @ walls.normal.T
    with np.errstate(divide="ignore"):
        lines = np.where(outward > 0.0, -walls.offset / outward, np.inf)
    reach = np.minimum(walls.disc_radius, lines.min(axis=1, initial=np.inf))
    around: Array = reach[:, None] * unit
    return around


def farthest(walls: Walls) -> float:
    """The distance of the farthest point inside from the origin (m)."""
    return min(walls.disc_radius, max((math.hypot(*corner) for corner in _lines_corners(walls)), default=math.inf))


def bounds(walls: Walls) -> tuple[tuple[float, float], tuple[float, float]]:
    """The lower and the upper corner of the rectangle around an enclosure (m)."""
    around, r = _lines_corners(walls), walls.disc_radius
    low, high = around.min(axis=0, initial=np.inf), around.max(axis=0, initial=-np.inf)
    if not len(around):
        low, high = np.full(2, -np.inf), np.full(2, np.inf)
    low, high = np.maximum(low, -r), np.minimum(high, r)
    return (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))


def area(walls: Walls) -> float:
    """The area inside (m^2), infinite if it is open."""
    if not len(walls.offset):
        return math.pi * walls.disc_radius**2
    x, y = outline(walls).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def _lines_corners(walls: Walls) -> Array:
    return corners(walls._replace(disc_radius=math.inf)) if len(walls.offset) > 2 else np.zeros((0, 2))
