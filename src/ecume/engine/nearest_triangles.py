"""Search for the nearest of many triangles, in a tree of bounding boxes.

The boxes are in preorder, and each stores the next box outside of it, so that the traversal needs no stack. It starts
with an upper bound from the triangle with the nearest center. The nearest point of a triangle is that of Ericson,
"Real-Time Collision Detection" (2005), section 5.1.5.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume.engine.cells import Integers
from ecume.engine.walls.sheets import Vector, axpy, dot
from ecume.units import Array

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

LEAF = 4
"""The largest number of triangles in a box that is not divided."""
Corners = tuple[Vector, Vector, Vector]


class Boxes(NamedTuple):
    """A tree of bounding boxes, whose leaves contain neighboring triangles."""

    corner: Array
    """(T, 9) of the triangles, in the order of the leaves"""
    triangle: Integers
    """(T,) their indices in the mesh"""
    bound: Array
    """(M, 6) the lowest and the highest corner of each box"""
    after: Integers
    """(M,) the next box that is not inside of this one"""
    first: Integers
    """(M,) the first triangle of a leaf; -1 of a box that is divided"""
    end: Integers
    """(M,)"""


def tree_of(triangles: Array) -> tuple[Boxes, cKDTree]:
    """The tree of triangles (T, 3, 3), and that of their centers; cached for the meshes in use."""
    return _tree(np.ascontiguousarray(triangles, np.float64).tobytes())


@functools.lru_cache(maxsize=16)
def _tree(data: bytes) -> tuple[Boxes, cKDTree]:
    corner = np.frombuffer(data).reshape(-1, 9)
    points = corner.reshape(-1, 3, 3)
    low, high, center = points.min(axis=1), points.max(axis=1), points.mean(axis=1)
    order = np.arange(len(points))
    bounds: list[Array] = []
    after, first, end = list[int](), list[int](), list[int]()
    # A stack of parts of `order` that are not divided yet; None marks the end of a divided box.
    waiting: list[tuple[int, int] | int] = [(0, len(order))]
    while waiting:
        part = waiting.pop()
        if isinstance(part, int):
            after[part] = len(bounds)
            continue
        start, stop = part
        mine = order[start:stop]
        number = len(bounds)
        bounds.append(np.concatenate([low[mine].min(axis=0), high[mine].max(axis=0)]))
        after.append(number + 1)
        leaf = stop - start <= LEAF
        first.append(start if leaf else -1)
        end.append(stop)
        if not leaf:
            axis, middle = int(np.argmax(np.ptp(center[mine], axis=0))), (stop - start) // 2
            order[start:stop] = mine[np.argpartition(center[mine, axis], middle)]
            waiting += [number, (start + middle, stop), (start, start + middle)]
    boxes = Boxes(
        corner[order].copy(), order, np.array(bounds), np.array(after), np.array(first), np.array(end),
    )  # fmt: skip
    from scipy.spatial import cKDTree

    return boxes, cKDTree(center)


@compiled_inside
def nearest_in(point: Vector, corners: Corners) -> Vector:
    """The point of a triangle that is nearest to a point: at a corner, on an edge, or inside."""
    a, b, c = corners
    along, across, away = axpy(b, -1.0, a), axpy(c, -1.0, a), axpy(point, -1.0, a)
    d1, d2 = dot(along, away), dot(across, away)
    if d1 <= 0.0 and d2 <= 0.0:
        return a
    from_b = axpy(point, -1.0, b)
    d3, d4 = dot(along, from_b), dot(across, from_b)
    if d3 >= 0.0 and d4 <= d3:
        return b
    beside_c = d1 * d4 - d3 * d2
    if beside_c <= 0.0 and d1 >= 0.0 and d3 <= 0.0 and d1 > d3:
        return axpy(a, d1 / (d1 - d3), along)
    from_c = axpy(point, -1.0, c)
    d5, d6 = dot(along, from_c), dot(across, from_c)
    if d6 >= 0.0 and d5 <= d6:
        return c
    beside_b = d5 * d2 - d1 * d6
    if beside_b <= 0.0 and d2 >= 0.0 and d6 <= 0.0 and d2 > d6:
        return axpy(a, d2 / (d2 - d6), across)
    beside_a = d3 * d6 - d5 * d4
    if beside_a <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0 and (d4 - d3) + (d5 - d6) > 0.0:
        return axpy(b, (d4 - d3) / ((d4 - d3) + (d5 - d6)), axpy(c, -1.0, b))
    whole = beside_a + beside_b + beside_c
    if whole == 0.0:  # degenerate triangle
        return a
    return axpy(axpy(a, beside_b / whole, along), beside_c / whole, across)


@compiled_inside
def square_beyond(bound: Array, k: int, point: Vector) -> float:
    """The square of the distance of a point from box k; zero inside."""
    total = 0.0
    for axis in range(3):
        out = max(bound[k, axis] - point[axis], point[axis] - bound[k, 3 + axis], 0.0)
        total += out * out
    return total


@compiled_inside
def corners_of(corner: Array, k: int) -> Corners:
    """The corners of triangle k."""
    return (
        (corner[k, 0], corner[k, 1], corner[k, 2]),
        (corner[k, 3], corner[k, 4], corner[k, 5]),
        (corner[k, 6], corner[k, 7], corner[k, 8]),
    )


@compiled
def find_nearest(points: Array, boxes: Boxes, guess: Integers, which: Integers, place: Array) -> None:
    """Write the nearest triangle (an index of `boxes.corner`) of each point (N, 3) and its nearest point; `guess` is
    any near triangle.
    """
    for i in range(points.shape[0]):
        point = points[i, 0], points[i, 1], points[i, 2]
        best, spot = guess[i], nearest_in(point, corners_of(boxes.corner, guess[i]))
        away = axpy(point, -1.0, spot)
        least = dot(away, away)
        k = 0
        while k < len(boxes.after):
            if square_beyond(boxes.bound, k, point) >= least:
                k = boxes.after[k]
                continue
            if boxes.first[k] >= 0:
                for own in range(boxes.first[k], boxes.end[k]):
                    near = nearest_in(point, corners_of(boxes.corner, own))
                    away = axpy(point, -1.0, near)
                    square = dot(away, away)
                    if square < least:
                        least, best, spot = square, own, near
            k += 1
        which[i] = best
        place[i, 0], place[i, 1], place[i, 2] = spot


def nearest_triangles(triangles: Array, points: Array) -> tuple[Integers, Array]:
    """The index of the nearest triangle of each point (N, 3), and the nearest point on it (N, 3)."""
    boxes, centers = tree_of(triangles)
    which, place = np.zeros(len(points), np.int64), np.zeros((len(points), 3))
    if len(points):
        rank = np.empty_like(boxes.triangle)
        rank[boxes.triangle] = np.arange(len(rank))
        guess = rank[centers.query(points)[1]]
        find_nearest(np.ascontiguousarray(points, np.float64), boxes, guess, which, place)
    return boxes.triangle[which], place
