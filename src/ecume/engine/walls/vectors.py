"""Three numbers at a time: a vector as a tuple, which compiled code keeps in registers. In two dimensions z is 0."""

from __future__ import annotations

import math

from ecume._jit import compiled_inside
from ecume.units import Array

Vector = tuple[float, float, float]


@compiled_inside
def dot(a: Vector, b: Vector) -> float:
    """A . b"""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled_inside
def cross(a: Vector, b: Vector) -> Vector:
    """A x b"""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled_inside
def length(a: Vector) -> float:
    """|a|"""
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@compiled_inside
def plus(a: Vector, factor: float, b: Vector) -> Vector:
    """A + factor b"""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


@compiled_inside
def scaled(factor: float, a: Vector) -> Vector:
    """Factor a"""
    return factor * a[0], factor * a[1], factor * a[2]


@compiled_inside
def flown(position: Vector, velocity: Vector, acceleration: Vector, time: float) -> Vector:
    """X + v t + a t^2 / 2"""
    return plus(plus(position, time, velocity), 0.5 * time * time, acceleration)


@compiled_inside
def row(array: Array, i: int) -> Vector:
    """Row i of an (N, 2) or (N, 3) array."""
    return array[i, 0], array[i, 1], array[i, 2] if array.shape[1] > 2 else 0.0


@compiled_inside
def put(array: Array, i: int, vector: Vector) -> None:
    """Write row i."""
    array[i, 0], array[i, 1] = vector[0], vector[1]
    if array.shape[1] > 2:
        array[i, 2] = vector[2]


@compiled_inside
def eased(vector: Vector, first: Vector, second: Vector, third: Vector) -> Vector:
    """The nearest vector that leads into none of three supports; a support that is absent has the normal 0.

    It is the vector itself, or its projection on a face, on an edge, or nothing of it: the projection on the cone
    w.n >= 0, found by trying.
    """
    normals = (first, second, third)
    slack = -1e-12 * length(vector)
    if allowed(vector, normals, 0.0):
        return vector
    for k in range(3):
        pressed = dot(vector, normals[k])
        if pressed < 0.0:
            on_face = plus(vector, -pressed, normals[k])
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
    """Whether it leads into none of the supports."""
    return dot(vector, normals[0]) >= least and dot(vector, normals[1]) >= least and dot(vector, normals[2]) >= least
