"""Rings: enclosures with a round inner wall around the origin, which floats touch from outside.

Among the lines of `Walls` the inner wall is the last one, with its radius as the offset. Its normal is stored as zero,
since it differs from place to place. The functions here stand for those of `surfaces` wherever there may be an inner
wall; without one they are the same.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume._jit import compiled_inside
from ecume.engine.walls import surfaces
from ecume.engine.walls.surfaces import Walls, wall_count
from ecume.errors import BadInput
from ecume.units import Array


def ring(outer: Walls, inner_radius: float) -> Walls:
    """An enclosure with an inner wall of this radius (m). Raises BadInput if the inner wall reaches the outer one.

    >>> walls = ring(surfaces.enclosed_by(surfaces.disc((0.0, 0.0), 2.0)), 0.5)
    >>> clearances(walls, (0.0, 0.75)), round(area(walls) / math.pi, 12)
    ([1.25, 0.25], 3.75)
    """
    room = min(surfaces.clearances(outer, (0.0, 0.0)))
    if not 0.0 < inner_radius < room:
        raise BadInput(f"ring: got an inner radius of {inner_radius:g} m; expected one between 0 and {room:g} m")
    return Walls(outer.disc_radius, np.vstack([outer.normal, np.zeros((1, 2))]), np.append(outer.offset, inner_radius))


def inner_radius_of(walls: Walls) -> float:
    """The radius of the inner wall (m); zero without one."""
    return float(walls.offset[-1]) if len(walls.offset) and not walls.normal[-1].any() else 0.0


def outer_walls(walls: Walls) -> Walls:
    """The enclosure without its inner wall."""
    if inner_radius_of(walls) == 0.0:
        return walls
    return Walls(walls.disc_radius, np.ascontiguousarray(walls.normal[:-1]), walls.offset[:-1].copy())


@compiled_inside
def wall_distance(walls: Walls, number: int, x: float, y: float) -> tuple[float, float, float]:
    """The distance of the point (x, y) from wall `number`, positive on the side of the liquid, and the wall's normal
    there, which points into the liquid. At the center of circles, where the direction is undefined, it is the first
    axis.
    """
    distance, normal_x, normal_y = surfaces.wall_distance(walls, number, x, y)
    if normal_x != 0.0 or normal_y != 0.0:
        return distance, normal_x, normal_y
    radius = math.sqrt(x * x + y * y)  # of the inner wall, `distance` is minus its radius
    if radius == 0.0:
        return distance, 1.0, 0.0
    return distance + radius, x / radius, y / radius


@compiled_inside
def is_inner(walls: Walls, number: int) -> bool:
    """Whether a wall is the inner one."""
    line = number - (1 if walls.disc_radius < np.inf else 0)
    return line >= 0 and walls.normal[line, 0] == 0.0 and walls.normal[line, 1] == 0.0


def clearances(walls: Walls, place: Any) -> list[float]:
    """The distances of a point from all walls (m)."""
    x, y = float(place[0]), float(place[1])
    return [float(wall_distance(walls, number, x, y)[0]) for number in range(wall_count(walls))]


def bounds(walls: Walls) -> tuple[tuple[float, float], tuple[float, float]]:
    """The lower and the upper corner of the rectangle around an enclosure (m)."""
    return surfaces.bounds(outer_walls(walls))


def area(walls: Walls) -> float:
    """The area between the walls (m^2), infinite if it is open."""
    return surfaces.area(outer_walls(walls)) - math.pi * inner_radius_of(walls) ** 2


def outline(walls: Walls) -> Array:
    """The outer edge, counterclockwise, as points of a polygon (m)."""
    return surfaces.outline(outer_walls(walls))


def inner_outline(walls: Walls) -> list[Array]:
    """The edge of the inner wall, counterclockwise, as points of a polygon (m); none without an inner wall."""
    radius = inner_radius_of(walls)
    return [surfaces.outline(Walls(radius, np.zeros((0, 2)), np.zeros(0)))] if radius > 0.0 else []


def shrunk(walls: Walls, by: float) -> Walls:
    """The enclosure for the centers of discs of this radius (m)."""
    outer, inner = surfaces.shrunk(outer_walls(walls), by), inner_radius_of(walls)
    return outer if inner == 0.0 else ring(outer, inner + by)
