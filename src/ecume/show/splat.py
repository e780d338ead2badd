"""Very many particles: discs painted into pixels, as no collection of patches could do as fast.

In 3D they are balls, lit from the viewer's side; nearer ones hide farther ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from ecume.show.style import INK
from ecume.units import Array

FARTHEST = 0.45
"""How bright the farthest ball is, the nearest being 1."""
MANY = 1500
"""So many circles are painted sooner than drawn one by one."""
POINT = 1.0 / 72.0
"""In inches."""


class Splat(Artist):
    """Particles in axes, painted with as many pixels as the figure has there when it is drawn. `radius` is (N,) or
    one for all (m); `rim` is how wide the line around each is (points). `room` are the corners beyond which nothing is
    painted (m); infinite where there is no wall.
    """

    def __init__(
        self, radius: Array | float, *, balls: bool = False, rim: float = 0.0, room: tuple[Array, Array] | None = None
    ) -> None:
        super().__init__()
        self.radius, self.balls, self.rim, self.room = radius, balls, rim, room
        self.places, self.shades = np.zeros((0, 2)), np.zeros((0, 3))
        self.order: Any = slice(None)

    def put(self, places: Array, depth: Array | None, colors: Array) -> None:
        """Draw discs: positions (N, 2) in m, how near to the eye each is, and colors (N, 3 or 4) from 0 to 1."""
        self.places, self.shades, self.order = places, 255.0 * colors[:, :3], slice(None)
        if depth is not None and len(depth):
            self.order = np.argsort(depth, kind="stable")
            near = (depth - depth.min()) / max(float(np.ptp(depth)), 1e-300)
            self.shades = self.shades * (FARTHEST + (1.0 - FARTHEST) * near)[:, None]

    def set_offsets(self, places: Array) -> None:
        """Move them."""
        self.places = places

    def _pixel(self, corner: Array) -> Array:
        """A corner in pixels of the figure; infinite where it is."""
        axes: Any = self.axes
        shown: Array = axes.transData.transform(np.where(np.isfinite(corner), corner, 0.0))
        return np.where(np.isfinite(corner), shown, corner)

    def draw(self, renderer: Any) -> None:
        """Paint them, and lay that over what is there."""
        from ecume.engine.rendering import Dots, Look, splat

        axes: Any = self.axes
        if not self.get_visible() or not len(self.places):
            return
        box, per_meter = axes.bbox, axes.transData.transform
        left, bottom = round(box.x0), round(box.y0)
        pixels = np.zeros((max(1, round(box.y1) - bottom), max(1, round(box.x1) - left), 4), np.uint8)
        across, up = per_meter(self.places).T
        zoom = float(np.ptp(per_meter([(0.0, 0.0), (1.0, 0.0)])[:, 0]))
        radius = np.broadcast_to(zoom * np.asarray(self.radius, dtype=np.float64), len(across))
        columns = (across - left, len(pixels) - (up - bottom), radius)
        dots = Dots(*(np.ascontiguousarray(column[self.order]) for column in (*columns, self.shades)))
        rim = self.rim * POINT * axes.figure.dpi
        splat(pixels, dots, Look(self.balls, rim, 255.0 * np.array(to_rgb(INK))))
        if self.room is not None:
            cut(pixels, [self._pixel(corner) - (left, bottom) for corner in self.room])
        context = renderer.new_gc()
        renderer.draw_image(context, left, bottom, pixels[::-1])
        context.restore()


def cut(pixels: NDArray[np.uint8], corners: Sequence[Array]) -> None:
    """Clear the pixels (rows from the top) that are left of or below the first corner, or right of or above the second
    one, counted in pixels from the lower left.
    """
    rows, columns = pixels.shape[:2]
    (left, bottom), (right, top) = corners
    across, up = np.arange(columns) + 0.5, rows - np.arange(rows) - 0.5
    pixels[:, (across < left) | (across > right)] = 0
    pixels[(up < bottom) | (up > top)] = 0


def splat_in(axes: Axes, splat: Splat, zorder: float) -> Splat:
    """Put it into axes."""
    splat.set_zorder(zorder)
    axes.add_artist(splat)
    return splat
