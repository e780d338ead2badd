"""Discs and lit balls painted into pixels, one after the other: later ones lie on earlier ones.

Edges cover the pixels that they cross in part. Bands of rows are painted side by side, each by one thread, so that the
pixels do not depend on how many there are.
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
"""Across, down, radius."""
BANDS = 16
"""Of rows, painted side by side."""
LEAST_RADIUS = 0.75
"""In pixels: what would be smaller is painted so large."""
DIMMEST = 0.45
"""How bright the rim of a ball is, its middle being 1: it is lit from where the eye is."""


class Dots(NamedTuple):
    """What is painted, in pixels from the upper left corner."""

    across: Array
    """(N,)"""
    down: Array
    """(N,)"""
    radius: Array
    """(N,)"""
    color: Array
    """(N, 3) from 0 to 255"""


class Look(NamedTuple):
    """How all of them look."""

    ball: bool
    """lit as balls are, or flat"""
    rim: float
    """how wide the line around each is, in pixels; 0 for none"""
    ink: Array
    """(3,) of that line, from 0 to 255"""


@threaded
def splat(pixels: Pixels, dots: Dots, look: Look) -> None:
    """Paint all dots into pixels (height, width, 4), whose fourth is how opaque they are."""
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
    """One row of one dot: edge, inside, edge."""
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
        _lay(pixels, (row, column), cover, mixed(colors[0], colors[1], light, edge))


@compiled_inside
def mixed(color: Color, ink: Color, light: float, edge: float) -> Color:
    """A color in this light, of which a part is the line's."""
    own = (1.0 - edge) * light
    return (own * color[0] + edge * ink[0], own * color[1] + edge * ink[1], own * color[2] + edge * ink[2])


@compiled_inside
def _span(middle: float, aside: float, radius: float, within: tuple[int, int]) -> tuple[int, int]:
    """The columns (or rows) whose middles a circle reaches in a row (or column) beside its own."""
    half = math.sqrt(max(radius * radius - aside * aside, 0.0))
    return max(within[0], math.ceil(middle - half - 0.5)), min(within[1], math.floor(middle + half - 0.5) + 1)


@compiled_inside
def _lay(pixels: Pixels, at: tuple[int, int], cover: float, color: Color) -> None:
    """Lay a color over a pixel that may be transparent: Porter and Duff's "over" (porter1984)."""
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
