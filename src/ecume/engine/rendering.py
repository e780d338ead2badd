"""Rendering of pictures: discs and shaded balls painted in order, and parallel rays through fields
on a grid.

Discs and lit balls are painted into pixels one after the other, later ones over earlier ones. Pixels on an edge are
covered partly. Bands of rows are painted in parallel, each by one thread, so that the pixels do not depend on the
number of threads.

Parallel rays through fields on a grid of cells record where they meet a liquid and a solid, and the length of their
path in the liquid. A field is positive inside. Between the centers of cells it is linear along each axis; beyond the
outermost centers it is constant.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import compiled_inside, prange, threaded
from ecume.units import Array

Pixels = NDArray[np.uint8]
Color = tuple[float, float, float]
Disc = tuple[float, float, float]
"""The coordinates of the center across and down, and the radius."""
BANDS = 16
"""The number of bands of rows that are painted in parallel."""
LEAST_RADIUS = 0.75
"""The smallest painted radius, in pixels."""
DIMMEST = 0.45
"""The brightness of the rim of a ball over that of its middle: it is lit from the observer."""


class Dots(NamedTuple):
    """The discs to paint, in pixels from the upper left corner."""

    across: Array
    """(N,)"""
    down: Array
    """(N,)"""
    radius: Array
    """(N,)"""
    color: Array
    """(N, 3) from 0 to 255"""


class Look(NamedTuple):
    """The appearance of all discs."""

    ball: bool
    """whether they are shaded as balls, or flat"""
    rim: float
    """the width of the line around each, in pixels; 0 without a line"""
    ink: Array
    """(3,) of that line, from 0 to 255"""


@threaded
def splat(pixels: Pixels, dots: Dots, look: Look) -> None:
    """Paint all discs into pixels (height, width, 4) with the opacity as the fourth component."""
    rows = pixels.shape[0]
    for band in prange(BANDS):
        _paint_rows(pixels, dots, look, (band * rows // BANDS, (band + 1) * rows // BANDS))


@compiled_inside
def _paint_rows(pixels: Pixels, dots: Dots, look: Look, rows: tuple[int, int]) -> None:
    ink = (look.ink[0], look.ink[1], look.ink[2])
    for one in range(len(dots.across)):
        radius, middle = max(dots.radius[one], LEAST_RADIUS), dots.down[one]
        if middle + radius + 1.0 < rows[0] or middle - radius - 1.0 > rows[1]:
            continue
        disc = (dots.across[one], middle, radius)
        color = (dots.color[one, 0], dots.color[one, 1], dots.color[one, 2])
        first, last = _span(middle, 0.0, radius + 0.5, rows)
        for row in range(first, last):
            _paint_row(pixels, row, disc, (color, ink), (look.ball, look.rim))


@compiled_inside
def _paint_row(pixels: Pixels, row: int, disc: Disc, colors: tuple[Color, Color], look: tuple[bool, float]) -> None:
    """Paint one row of one disc: left edge, inside, right edge."""
    across, up, radius = disc[0], row + 0.5 - disc[1], disc[2]
    ball, rim = look
    start, stop = _span(across, up, radius + 0.5, (0, pixels.shape[1]))
    inside = radius - 0.5 - (rim + 0.5 if rim > 0.0 else 0.0)
    for column in range(start, stop):
        square = (column + 0.5 - across) ** 2 + up * up
        cover, edge = 1.0, 0.0
        if inside <= 0.0 or square > inside * inside:
            away = math.sqrt(square)
            cover = min(max(radius - away + 0.5, 0.0), 1.0)
            edge = min(max(away - radius + rim + 0.5, 0.0), 1.0) * min(rim, 1.0)
        light = DIMMEST + (1.0 - DIMMEST) * math.sqrt(max(1.0 - square / (radius * radius), 0.0)) if ball else 1.0
        _blend(pixels, (row, column), cover, mixed(colors[0], colors[1], light, edge))


@compiled_inside
def mixed(color: Color, ink: Color, light: float, edge: float) -> Color:
    """The color in this light, mixed with a fraction of the line's color."""
    own = (1.0 - edge) * light
    return (own * color[0] + edge * ink[0], own * color[1] + edge * ink[1], own * color[2] + edge * ink[2])


@compiled_inside
def _span(middle: float, aside: float, radius: float, within: tuple[int, int]) -> tuple[int, int]:
    """The range of columns (or rows) whose centers a circle contains, in a row (or column) at this distance from its
    center.
    """
    half = math.sqrt(max(radius * radius - aside * aside, 0.0))
    return max(within[0], math.ceil(middle - half - 0.5)), min(within[1], math.floor(middle + half - 0.5) + 1)


@compiled_inside
def _blend(pixels: Pixels, at: tuple[int, int], cover: float, color: Color) -> None:
    """Paint a color over a pixel that may be transparent: Porter and Duff's "over" (porter1984)."""
    row, column = at
    if cover >= 1.0:
        _put(pixels, at, color)
        return
    below = pixels[row, column, 3] * ((1.0 - cover) / 255.0)
    opaque = cover + below
    if opaque <= 0.0:
        return
    own = cover / opaque if opaque < 1.0 else cover
    red, green, blue = pixels[row, column, 0], pixels[row, column, 1], pixels[row, column, 2]
    mix = (red + own * (color[0] - red), green + own * (color[1] - green), blue + own * (color[2] - blue))
    _put(pixels, at, mix)
    pixels[row, column, 3] = np.uint8(255.0 * opaque + 0.5)


@compiled_inside
def _put(pixels: Pixels, at: tuple[int, int], color: Color) -> None:
    pixels[at[0], at[1], 0] = np.uint8(color[0] + 0.5)
    pixels[at[0], at[1], 1] = np.uint8(color[1] + 0.5)
    pixels[at[0], at[1], 2] = np.uint8(color[2] + 0.5)
    pixels[at[0], at[1], 3] = np.uint8(255)


STRIDE = 0.6
"""The length of a step along a ray, in cells."""
HALVINGS = 4
"""The number of bisections of the step in which a ray reaches a surface."""
MET = 8
"""The length of the record of a ray: the distances from the plane of the observer to the liquid and to the solid
(infinite if it misses), the path in liquid before the solid, and the outward gradients of both fields there: the first
two components of the liquid's, its third, and the solid's angle to the ray.
"""

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
    """The image plane from which rays start, and the direction of the rays."""

    across: Array
    """(columns,) to the right of the origin (m)"""
    up: Array
    """(rows,) above the origin (m)"""
    camera: Array
    """(3, 3) the directions right, up, and toward the eye"""
    nearest: float
    """the distance of the plane from the origin, toward the observer (m)"""


@threaded
def cast(block: Block, eye: Eye, met: Array) -> None:
    """Follow a ray for each pixel; write the record of each ray into `met`, (rows, columns, MET)."""
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
    """The outward normal of the liquid where the ray enters it; at a side of the block, that of the side."""
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
    """The distances along a ray at which it enters and leaves the block."""
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
    """The distance along a ray at which a field is zero, by bisection."""
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
    """The gradient of a field by central differences over two cells, up to a factor."""
    x, y, z = block.cell[0], block.cell[1], block.cell[2]
    along = _read(field, block, (at[0] + x, at[1], at[2])) - _read(field, block, (at[0] - x, at[1], at[2]))
    up = _read(field, block, (at[0], at[1] + y, at[2])) - _read(field, block, (at[0], at[1] - y, at[2]))
    deep = _read(field, block, (at[0], at[1], at[2] + z)) - _read(field, block, (at[0], at[1], at[2] - z))
    return along / x, up / y, deep / z


@compiled_inside
def _read(field: Fields, block: Block, at: tuple[float, float, float]) -> float:
    """The value of a field at a point, linear along each axis between the centers of the cells."""
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
    """The cell below a coordinate, and the fraction of the distance to the next."""
    inside = min(max(place, 0.0), count - 1.0)
    first = min(int(inside), count - 2)
    return first, inside - first
