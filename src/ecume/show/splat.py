"""Very many particles of one size: discs painted into pixels, as no collection of patches could do as fast.

In space they are balls, lit from the eye's side; who is nearer hides who is farther.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from ecume.show.picture import Pixels, View
from ecume.units import Array

SHARPER = 2
"""Pixels that are painted for each one that is shown, along each axis: without it, discs have steps."""
LEAST_RADIUS = 0.75
"""In painted pixels: what would be smaller is drawn so large."""
MOST_DOTS = 2_000_000
"""Painted at once."""
FARTHEST = 0.45
"""How bright the farthest ball is, the nearest being 1; and the rim of a ball, its middle being 1."""


class Stamp(NamedTuple):
    """The pixels of one disc about its middle, and how bright each is."""

    row: NDArray[np.int64]
    column: NDArray[np.int64]
    light: Array


def stamp_of(radius: float, *, ball: bool) -> Stamp:
    """A disc of this radius in pixels."""
    radius = max(radius, LEAST_RADIUS)
    reach = int(np.ceil(radius))
    row, column = (axis.ravel() for axis in np.mgrid[-reach : reach + 1, -reach : reach + 1])
    square = (row**2 + column**2) / radius**2
    inside = square <= 1.0
    light = FARTHEST + (1.0 - FARTHEST) * np.sqrt(np.maximum(1.0 - square, 0.0)) if ball else np.ones(len(row))
    return Stamp(row[inside], column[inside], light[inside])


class Canvas(NamedTuple):
    """Pixels to be painted, with room around what is seen, so that no stamp ends in the middle of a disc."""

    pixels: NDArray[np.uint32]
    room: int


def canvas_of(height: int, width: int, stamp: Stamp) -> Canvas:
    """An empty one, for discs of one size."""
    room = int(stamp.row.max()) + 1
    return Canvas(np.zeros((height + 2 * room, width + 2 * room), np.uint32), room)


def paint(canvas: Canvas, places: Array, colors: Array, stamp: Stamp) -> None:
    """Put a stamp on each place (row, column), (N, 2), in its color (N, 3) from 0 to 255: later ones lie on earlier."""
    height, width = canvas.pixels.shape
    middle = np.floor(places).astype(np.int64) + canvas.room
    reach = canvas.room - 1
    seen = ((middle >= reach) & (middle < [height - reach, width - reach])).all(axis=1)
    middle, colors = middle[seen], colors[seen]
    flat, around = canvas.pixels.reshape(-1), stamp.row * width + stamp.column
    chunk = max(1, MOST_DOTS // len(around))
    for first in range(0, len(middle), chunk):
        here = middle[first : first + chunk] @ [width, 1]
        flat[here[:, None] + around] = _lit(colors[first : first + chunk], stamp.light)


def _lit(colors: Array, light: Array) -> NDArray[np.uint32]:
    """Each color as bright as each pixel of the stamp; one column where all are equally bright."""
    levels = np.unique(light)
    rows = np.full((len(colors), len(levels), 4), 255, np.uint8)
    rows[..., :3] = colors[:, None, :] * levels[None, :, None]
    return rows.view(np.uint32)[..., 0][:, np.searchsorted(levels, light) if len(levels) > 1 else [0]]


def shown(canvas: Canvas) -> Pixels:
    """What is seen, with `SHARPER` times fewer pixels along each axis; edges become half transparent."""
    inner = slice(canvas.room, -canvas.room)
    fine = np.ascontiguousarray(canvas.pixels[inner, inner]).view(np.uint8)
    fine = fine.reshape(fine.shape[0] // SHARPER, SHARPER, -1, SHARPER, 4)
    places = [(row, column) for row in range(SHARPER) for column in range(SHARPER)]
    total = np.zeros((fine.shape[0], fine.shape[2], 4), np.uint16)
    for row, column in places:
        total += fine[:, row, :, column]
    covered = (total[..., 3] + len(places)) >> 8
    pixels: Pixels = (total // np.maximum(covered, 1)[..., None]).astype(np.uint8)
    pixels[..., 3] = total[..., 3] // len(places)
    return pixels


class Splat:
    """Particles as an image that fills the axes. `radius` is theirs (m)."""

    def __init__(self, axes: Axes, view: View, radius: float, *, balls: bool) -> None:
        figure: Any = axes.figure
        left, right, bottom, top = view
        box = axes.get_position()
        inches = np.array([box.width, box.height]) * figure.get_size_inches()
        width, height = (max(1, round(side)) for side in inches * figure.dpi)
        self.view, self.balls = view, balls
        self._per_meter = SHARPER * width / view.width
        self._stamp = stamp_of(radius * self._per_meter, ball=balls)
        self._canvas = canvas_of(SHARPER * height, SHARPER * width, self._stamp)
        nothing = shown(self._canvas)
        self.artist = axes.imshow(
            nothing, extent=(left, right, bottom, top), interpolation="nearest", aspect="auto", zorder=3
        )

    def put(self, places: Array, depth: Array | None, colors: Array) -> None:
        """Where they are seen (N, 2) in m, how near to the eye each is, and their colors (N, 4) from 0 to 1."""
        shades = 255.0 * colors[:, :3]
        if depth is not None:
            order = np.argsort(depth, kind="stable")
            span = max(float(np.ptp(depth)), 1e-300)
            near = FARTHEST + (1.0 - FARTHEST) * (depth - depth.min()) / span
            places, shades = places[order], (shades * near[:, None])[order]
        pixels = np.column_stack([self.view.top - places[:, 1], places[:, 0] - self.view.left]) * self._per_meter
        self._canvas.pixels[...] = 0
        paint(self._canvas, pixels, shades, self._stamp)
        self.artist.set_data(shown(self._canvas))
