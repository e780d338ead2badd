"""Surfaces in compiled loops: vectors as tuples, gaps and normals at a given time, and times at which a flight meets a
surface.

A vector is a tuple of three numbers, which compiled code keeps in registers. In 2D z is 0.

The times at which a flight meets a surface are roots in a form without cancellation. The flight is x + v t + a t^2/2
relative to the surface.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled_inside
from ecume.engine.cells import Integers
from ecume.engine.walls.surfaces import PLANE, Surfaces
from ecume.errors import BadInput
from ecume.units import Array

Vector = tuple[float, float, float]


@compiled_inside
def dot(a: Vector, b: Vector) -> float:
    """The scalar product a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled_inside
def cross(a: Vector, b: Vector) -> Vector:
    """The cross product a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled_inside
def length(a: Vector) -> float:
    """The length |a|."""
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@compiled_inside
def axpy(a: Vector, factor: float, b: Vector) -> Vector:
    """The sum a + factor b."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


@compiled_inside
def scaled(factor: float, a: Vector) -> Vector:
    """The product of a factor and a vector."""
    return factor * a[0], factor * a[1], factor * a[2]


@compiled_inside
def ballistic(position: Vector, velocity: Vector, acceleration: Vector, time: float) -> Vector:
    """The position x + v t + a t^2 / 2."""
    return axpy(axpy(position, time, velocity), 0.5 * time * time, acceleration)


@compiled_inside
def load(array: Array, i: int) -> Vector:
    """Row i of an (N, 2) or (N, 3) array as a vector."""
    return array[i, 0], array[i, 1], array[i, 2] if array.shape[1] > 2 else 0.0


@compiled_inside
def store(array: Array, i: int, vector: Vector) -> None:
    """Write a vector to row i of an array."""
    array[i, 0], array[i, 1] = vector[0], vector[1]
    if array.shape[1] > 2:
        array[i, 2] = vector[2]


@compiled_inside
def projected_on_cone(vector: Vector, first: Vector, second: Vector, third: Vector) -> Vector:
    """The nearest vector that does not point into any of three supports; an absent support has the
    normal 0.

    This is the projection on the cone w.n >= 0: the first allowed one of the vector itself, its projections on a face
    or an edge, and zero.
    """
    normals = (first, second, third)
    slack = -1e-12 * length(vector)
    if allowed(vector, normals, 0.0):
        return vector
    for k in range(3):
        pressed = dot(vector, normals[k])
        if pressed < 0.0:
            on_face = axpy(vector, -pressed, normals[k])
            if allowed(on_face, normals, slack):
                return on_face
    best = (0.0, 0.0, 0.0)
    for k in range(3):
        edge = cross(normals[k], normals[(k + 1) % 3])
        square = dot(edge, edge)
        if square > 1e-24:
            on_edge = scaled(dot(vector, edge) / square, edge)
            if length(on_edge) > length(best) and allowed(on_edge, normals, slack):
                best = on_edge
    return best


@compiled_inside
def allowed(vector: Vector, normals: tuple[Vector, Vector, Vector], least: float) -> bool:
    """Whether a vector does not point into any of the supports."""
    return dot(vector, normals[0]) >= least and dot(vector, normals[1]) >= least and dot(vector, normals[2]) >= least


SIZE, SPEED, RESTITUTION, TANGENTIAL, SCALE = 3, 4, 7, 8, 9
"""Columns of `Sheet.number`; the first three are the position."""
RELATIVE_ROUNDING = 1e-12
"""The relative rounding error of gaps: a point outside by less than this fraction of the lengths involved is on the
surface.
"""


class Sheet(NamedTuple):
    """Surfaces with their coefficients, as a few arrays; see `Surfaces`."""

    kind: Integers
    """(K, 3): kind, and the range of an obstacle's planes"""
    number: Array
    """(K, 10): position, size, velocity, restitution, tangential factor, the extent of all surfaces"""
    hole: Integers
    """(M,)"""
    part: Array
    """(M, 6): the two corners of each opening"""


def sheet(walls: Surfaces, restitution: Any = 1.0, tangential: Any = 1.0) -> Sheet:
    """Pack surfaces into arrays. The coefficients, in [0, 1], are one number for all surfaces, or one for each."""
    number = np.zeros((len(walls.kind), 10))
    number[:, :3], number[:, SIZE], number[:, SPEED : SPEED + 3] = walls.place, walls.size, walls.velocity
    number[:, RESTITUTION] = _proportion(restitution, "restitution", len(walls.kind))
    number[:, TANGENTIAL] = _proportion(tangential, "tangential", len(walls.kind))
    centers = walls.place * (walls.kind != PLANE)[:, None]
    number[:, SCALE] = max((float(np.abs(part).max()) for part in (centers, walls.size) if part.size), default=0.0)
    kind = np.column_stack([walls.kind, walls.face])
    # An opening is a flat part of a surface; flatness is compared up to rounding.
    slack = 1e-9 * np.linalg.norm(walls.high - walls.low, axis=1)[:, None]
    return Sheet(kind, number, walls.hole.copy(), np.hstack([walls.low - slack, walls.high + slack]))


def _proportion(given: Any, name: str, count: int) -> Array:
    array = np.asarray(given, np.float64)
    if array.shape not in ((), (count,)) or not np.all((array >= 0.0) & (array <= 1.0)):
        raise BadInput(f"{name}: got {given!r}; expected a number from 0 to 1, or one for each of {count} surfaces")
    return array


@compiled_inside
def place_of(number: Array, k: int) -> Vector:
    """The normal of plane k, or the center of sphere k."""
    return number[k, 0], number[k, 1], number[k, 2]


@compiled_inside
def wall_velocity(number: Array, k: int) -> Vector:
    """The velocity of surface k."""
    return number[k, SPEED], number[k, SPEED + 1], number[k, SPEED + 2]


@compiled_inside
def from_center(number: Array, k: int, x: Vector, time: float) -> Vector:
    """The vector from the center of sphere k, at that time, to x."""
    return axpy(axpy(x, -1.0, place_of(number, k)), -time, wall_velocity(number, k))


@compiled_inside
def inward_normal(kind: Integers, number: Array, k: int, x: Vector, time: float) -> Vector:
    """The gradient of the gap. At the center of a circle it is undefined, and the first axis is used."""
    if kind[k, 0] == PLANE:
        return place_of(number, k)
    out = from_center(number, k, x, time)
    away = length(out)
    return scaled(-kind[k, 0] / away, out) if away > 0.0 else (-1.0 * kind[k, 0], 0.0, 0.0)


@compiled_inside
def gap_to(kind: Integers, number: Array, k: int, x: Vector, time: float) -> float:
    """The distance of a point from surface k, positive inside."""
    if kind[k, 0] == PLANE:
        normal = place_of(number, k)
        return dot(normal, x) - float(number[k, SIZE]) - time * dot(normal, wall_velocity(number, k))
    return float(kind[k, 0] * (number[k, SIZE] - length(from_center(number, k, x, time))))


@compiled_inside
def piece_gap(kind: Integers, number: Array, k: int, x: Vector, time: float) -> tuple[float, int, int]:
    """The gap to the wall or obstacle whose first surface is k, the surface that determines it, and the first surface
    of the next.

    The gap of an obstacle is the largest among its faces.
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
def rounding_at(number: Array, k: int, x: Vector) -> float:
    """The rounding error of a gap to surface k."""
    return RELATIVE_ROUNDING * (float(number[k, SCALE]) + length(x))


@compiled_inside
def hole_at(hole: Integers, part: Array, number: Array, k: int, moment: tuple[Vector, float]) -> int:
    """The opening of surface k at this point, or -1."""
    x, time = moment
    y = axpy(x, -time, wall_velocity(number, k))
    for m in range(hole.shape[0]):
        within = part[m, 0] <= y[0] <= part[m, 3] and part[m, 1] <= y[1] <= part[m, 4]
        if hole[m] == k and within and part[m, 2] <= y[2] <= part[m, 5]:
            return m
    return -1


NEVER = math.inf
Quartic = tuple[float, float, float, float, float]


@compiled_inside
def time_to_plane(gap: float, speed: float, push: float) -> float:
    """The first t >= 0 at which gap + speed t + push t^2/2 becomes negative, coming from positive values.

    The form of the root avoids cancellation. If the gap is negative at the start, as next to the face of an obstacle,
    it must first become positive.
    """
    if gap < 0.0 and not (speed > 0.0 and push < 0.0 and speed * speed > 2.0 * push * gap):
        return NEVER
    if push == 0.0:
        return gap / -speed if speed < 0.0 else NEVER
    square = speed * speed - 2.0 * push * gap
    if speed < 0.0:
        return 2.0 * gap / (-speed + math.sqrt(square)) if square > 0.0 else NEVER
    return (speed + math.sqrt(square)) / -push if push < 0.0 else NEVER


@compiled_inside
def time_to_chord_end(gap: float, inward: float, square: float) -> float:
    """The first t >= 0 at which gap - 2 inward t - square t^2 becomes negative, for a straight flight inside a sphere.

    gap = R^2 - p^2 >= 0, inward = p.v, square = v^2. For a start on the sphere it is the time along the chord, -2 p.v /
    v^2.
    """
    if square == 0.0:
        return NEVER
    root = math.sqrt(inward * inward + square * gap)
    return gap / (inward + root) if inward > 0.0 else (root - inward) / square


@compiled_inside
def time_to_ball(gap: float, inward: float, square: float) -> float:
    """The first t >= 0 at which gap + 2 inward t + square t^2 becomes negative, for a straight flight outside a sphere.

    gap = p^2 - R^2 >= 0.
    """
    under = inward * inward - square * gap
    return gap / (math.sqrt(under) - inward) if inward < 0.0 and under > 0.0 else NEVER


@compiled_inside
def time_to_sphere(
    position: Vector, velocity: Vector, acceleration: Vector, shape: tuple[float, float, float]
) -> float:
    """The time at which a flight from one side of a sphere around the origin crosses it; shape = (radius, side, the
    longest time).

    The side is 1 inside, -1 outside.
    """
    radius, side, longest = shape
    away = length(position)
    gap = side * (radius - away)
    push = dot(acceleration, acceleration)
    reach = longest * length(velocity) + 0.5 * longest * longest * math.sqrt(push)
    if gap > reach:
        return NEVER
    gap = max(gap, 0.0) * (radius + away)
    inward, square = dot(position, velocity), dot(velocity, velocity)
    if push == 0.0:
        return time_to_chord_end(gap, inward, square) if side > 0.0 else time_to_ball(gap, inward, square)
    bend = -side * (square + dot(position, acceleration))
    return first_crossing(
        (gap, -2.0 * side * inward, bend, -side * dot(velocity, acceleration), -0.25 * side * push), longest
    )


@compiled_inside
def first_crossing(quartic: Quartic, longest: float) -> float:
    """The first t in [0, longest] at which c0 + c1 t + ... + c4 t^4 becomes negative; c0 >= 0.

    Between the turning points, which lie between the points of inflection, a quartic is monotone: no root is missed.
    """
    c0, c1, c2, c3, c4 = quartic
    if c0 <= 0.0 and (c1 < 0.0 or (c1 == 0.0 and c2 < 0.0)):
        return 0.0
    slope = (c1, 2.0 * c2, 3.0 * c3, 4.0 * c4, 0.0)
    first, second = inflections(12.0 * c4, 6.0 * c3, 2.0 * c2, longest)
    ends = (first, second, longest)
    low, before = 0.0, 0.0
    for k in range(3):
        if value(slope, low) * value(slope, ends[k]) < 0.0:
            turn = bracketed(slope, low, ends[k])
            if value(quartic, turn) < 0.0:
                return bracketed(quartic, before, turn)
            before = turn
        low = ends[k]
    return bracketed(quartic, before, longest) if value(quartic, longest) < 0.0 else NEVER


@compiled_inside
def inflections(a: float, b: float, c: float, longest: float) -> tuple[float, float]:
    """The roots of a t^2 + b t + c, in order, moved into [0, longest]."""
    under = b * b - 4.0 * a * c
    if under <= 0.0 or a == 0.0:
        return 0.0, 0.0
    big = -0.5 * (b + math.copysign(math.sqrt(under), b))
    one, other = big / a, c / big if big != 0.0 else 0.0
    low, high = min(one, other), max(one, other)
    return min(max(low, 0.0), longest), min(max(high, 0.0), longest)


@compiled_inside
def value(c: Quartic, t: float) -> float:
    """The value of the polynomial c0 + c1 t + ... + c4 t^4."""
    return c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * c[4])))


@compiled_inside
def bracketed(c: Quartic, low: float, high: float) -> float:
    """The root in an interval with a change of sign, by Newton's method, with bisection where it would leave the
    interval.
    """
    rising = value(c, high) > value(c, low)
    t = 0.5 * (low + high)
    for _ in range(100):
        height = value(c, t)
        if (height > 0.0) == rising:
            high = t
        else:
            low = t
        slope = c[1] + t * (2.0 * c[2] + t * (3.0 * c[3] + t * 4.0 * c[4]))
        new = t - height / slope if slope != 0.0 else low
        if not low < new < high:
            new = 0.5 * (low + high)
        if new == t or high - low <= 1e-16 * high:
            break
        t = new
    return t
