"""Parallel rays through fields on a grid of cells: where they meet a liquid and a solid, and their way in the liquid.

A field is above 0 inside. Between the centers of cells it is linear along each axis; beyond the outer ones constant.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import compiled_inside, prange, threaded
from ecume.units import Array

STRIDE = 0.6
"""Of a step along a ray, in cells."""
HALVINGS = 4
"""Of the step in which a surface is met."""
MET = 8
"""Numbers of a ray: how far it goes from the plane of the eye to the liquid and to the solid (infinite if it misses),
how far it goes in liquid before the solid, and the outward slopes of both fields there, the liquid's first two
components and the third, and the solid's angle to the ray."""

Fields = NDArray[np.float32]


class Block(NamedTuple):
    """Two fields on the same cells."""

    liquid: Fields
    """(nx, ny, nz)"""
    solid: Fields
    """(nx, ny, nz), or empty without solids"""
    low: Array
    """(3,) the corner of the block (m)"""
    high: Array
    cell: Array
    """(3,) m"""


class Eye(NamedTuple):
    """The plane from which rays start, and their direction."""

    across: Array
    """(columns,) to the right of the origin (m)"""
    up: Array
    """(rows,) above the origin (m)"""
    camera: Array
    """(3, 3) the directions right, up, and toward the eye"""
    nearest: float
    """how far the plane is from the origin, toward the eye (m)"""


@threaded
def cast(block: Block, eye: Eye, met: Array) -> None:
    """Follow a ray for each pixel; `met` is (rows, columns, MET)."""
    for row in prange(len(eye.up)):
        for column in range(len(eye.across)):
            _follow(block, eye, (eye.across[column], eye.up[row]), met[row, column])


@compiled_inside
def _follow(block: Block, eye: Eye, place: tuple[float, float], met: Array) -> None:
    camera = eye.camera
    x = place[0] * camera[0, 0] + place[1] * camera[1, 0] + eye.nearest * camera[2, 0]
    y = place[0] * camera[0, 1] + place[1] * camera[1, 1] + eye.nearest * camera[2, 1]
    z = place[0] * camera[0, 2] + place[1] * camera[1, 2] + eye.nearest * camera[2, 2]
    first, last = _through(block, camera, (x, y, z))
    met[0] = met[1] = math.inf
    met[2] = 0.0
    step = STRIDE * min(block.cell[0], block.cell[1], block.cell[2])
    way, before = first, first
    while way < last + step and first < last:
        at = min(way, last)
        here = (x - at * camera[2, 0], y - at * camera[2, 1], z - at * camera[2, 2])
        if block.solid.size > 0 and _read(block.solid, block, here) > 0.0:
            met[1] = _between(block.solid, block, camera, (x, y, z), before, at)
            there = (x - met[1] * camera[2, 0], y - met[1] * camera[2, 1], z - met[1] * camera[2, 2])
            slope = _slope(block.solid, block, there)
            size = math.sqrt(slope[0] ** 2 + slope[1] ** 2 + slope[2] ** 2) + 1e-300
            met[6] = -(slope[0] * camera[2, 0] + slope[1] * camera[2, 1] + slope[2] * camera[2, 2]) / size
            return
        if _read(block.liquid, block, here) > 0.0:
            met[2] += step
            if met[0] == math.inf:
                met[0] = _between(block.liquid, block, camera, (x, y, z), before, at)
                _outward(block, camera, (x, y, z), met, met[0] <= first + 1e-3 * step)
        before = at
        way += step


@compiled_inside
def _outward(block: Block, camera: Array, start: tuple[float, float, float], met: Array, wall: bool) -> None:
    """The outward normal of the liquid where the ray meets it: that of the block where it enters through its side."""
    there = (start[0] - met[0] * camera[2, 0], start[1] - met[0] * camera[2, 1], start[2] - met[0] * camera[2, 2])
    if wall:
        best, axis, sign = math.inf, 0, 1.0
        for k in range(3):
            for end in range(2):
                gap = abs(there[k] - (block.high[k] if end else block.low[k])) / block.cell[k]
                if gap < best:
                    best, axis, sign = gap, k, 1.0 if end else -1.0
        for k in range(3):
            met[3 + k] = sign if k == axis else 0.0
        return
    slope = _slope(block.liquid, block, there)
    size = math.sqrt(slope[0] ** 2 + slope[1] ** 2 + slope[2] ** 2) + 1e-300
    for k in range(3):
        met[3 + k] = -slope[k] / size


@compiled_inside
def _through(block: Block, camera: Array, start: tuple[float, float, float]) -> tuple[float, float]:
    """How far a ray goes until it enters the block, and until it leaves it."""
    first, last = 0.0, math.inf
    for k in range(3):
        speed = -camera[2, k]
        if abs(speed) < 1e-12:
            if start[k] < block.low[k] or start[k] > block.high[k]:
                return 1.0, 0.0
            continue
        one, other = (block.low[k] - start[k]) / speed, (block.high[k] - start[k]) / speed
        first, last = max(first, min(one, other)), min(last, max(one, other))
    return first, last


@compiled_inside
def _between(
    field: Fields, block: Block, camera: Array, start: tuple[float, float, float], outside: float, inside: float
) -> float:
    """Where along a ray a field passes through 0, by bisection."""
    if outside == inside:
        return inside
    for _ in range(HALVINGS):
        middle = 0.5 * (outside + inside)
        there = (start[0] - middle * camera[2, 0], start[1] - middle * camera[2, 1], start[2] - middle * camera[2, 2])
        if _read(field, block, there) > 0.0:
            inside = middle
        else:
            outside = middle
    return 0.5 * (outside + inside)


@compiled_inside
def _slope(field: Fields, block: Block, at: tuple[float, float, float]) -> tuple[float, float, float]:
    """The slope of a field by central differences over two cells, up to a factor."""
    x, y, z = block.cell[0], block.cell[1], block.cell[2]
    along = _read(field, block, (at[0] + x, at[1], at[2])) - _read(field, block, (at[0] - x, at[1], at[2]))
    up = _read(field, block, (at[0], at[1] + y, at[2])) - _read(field, block, (at[0], at[1] - y, at[2]))
    deep = _read(field, block, (at[0], at[1], at[2] + z)) - _read(field, block, (at[0], at[1], at[2] - z))
    return along / x, up / y, deep / z


@compiled_inside
def _read(field: Fields, block: Block, at: tuple[float, float, float]) -> float:
    """A field at a point, linear along each axis between the centers of the cells."""
    i, a = _cell((at[0] - block.low[0]) / block.cell[0] - 0.5, field.shape[0])
    j, b = _cell((at[1] - block.low[1]) / block.cell[1] - 0.5, field.shape[1])
    k, c = _cell((at[2] - block.low[2]) / block.cell[2] - 0.5, field.shape[2])
    near = (1.0 - b) * ((1.0 - c) * field[i, j, k] + c * field[i, j, k + 1]) + b * (
        (1.0 - c) * field[i, j + 1, k] + c * field[i, j + 1, k + 1]
    )
    far = (1.0 - b) * ((1.0 - c) * field[i + 1, j, k] + c * field[i + 1, j, k + 1]) + b * (
        (1.0 - c) * field[i + 1, j + 1, k] + c * field[i + 1, j + 1, k + 1]
    )
    found: float = (1.0 - a) * near + a * far
    return found


@compiled_inside
def _cell(place: float, count: int) -> tuple[int, float]:
    """The cell before a place, and the part of the way to the next."""
    inside = min(max(place, 0.0), count - 1.0)
    first = min(int(inside), count - 2)
    return first, inside - first
