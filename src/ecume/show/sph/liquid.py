"""A liquid in 2D as Matplotlib draws it: the region that its particles fill, colored, with a line along its surface."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from contourpy import FillType, LineType, contour_generator
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.path import Path

from ecume.engine.shapes import Flags
from ecume.scenes.sph import SIDES
from ecume.show.scenery import Round, Shape
from ecume.show.sph.kernel_sum import SMOOTHING, SUPPORT, Grid, Inside, Liquid, Region, grid_in, region_of
from ecume.show.style import RIM
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.sph import SphScene

CELL = 4.0
"""Of the grid, in pixels, as long as it is finer than half a spacing."""
FINEST, COARSEST = 10.0, 2.0
"""Cells per spacing."""
MOST_CELLS = 400_000
OPEN = ("open",)


class Surface(NamedTuple):
    """The region of a liquid and the grid on which it is known."""

    region: Region
    grid: Grid

    def padded(self) -> tuple[Array, Array, Array]:
        """The level with the sides of the grid added, where it is as in the cells beside them: x, y, level (y, x)."""
        axes = [
            np.concatenate([[self.grid.low[axis]], self.grid.centers(axis), [self.grid.high[axis]]]) for axis in (0, 1)
        ]
        return axes[0], axes[1], np.pad(self.region.level, 1, mode="edge").T

    def outline(self) -> Path:
        """The liquid as filled polygons, with holes (m)."""
        x, y, level = self.padded()
        generator = contour_generator(x, y, level, fill_type=FillType.ChunkCombinedCode)
        found: Any = generator.filled(0.0, np.inf)
        (points,), (codes,) = found
        return Path(np.zeros((0, 2))) if points is None else Path(points, codes)

    def lines(self) -> list[Array]:
        """The free surface, (K, 2) each: it ends at walls and does not run along them (m)."""
        x, y, level = self.padded()
        lines: Any = contour_generator(x, y, level, line_type=LineType.Separate).lines(0.0)
        return list(lines)


def surface_of(
    scene: SphScene, frame: Frame, values: Array, fine: float = COARSEST, window: tuple[Array, Array] | None = None
) -> Surface:
    """The region of a frame's liquid with the means of (N, k) values, with so many cells per spacing.

    `window` are the corners of what is to be seen: open sides end there.
    """
    liquid = liquid_in(frame, scene.spacing, values)
    low, high = room_of(scene, frame, liquid.position, window)
    size = max(scene.spacing / fine, math.sqrt(float(np.prod(high - low)) / MOST_CELLS))
    kinds = [getattr(scene.tank, side).kind for side in SIDES[:4]]
    grid = grid_in(low, high, size, (kinds[0] == "periodic", kinds[2] == "periodic"))
    return Surface(region_of(liquid, grid, scene.spacing, solids_in(scene, frame)), grid)


def liquid_in(frame: Frame, spacing: float, values: Array) -> Liquid:
    """The particles of a frame with values of (N, k), each with its volume."""
    position = frame.arrays["position"]
    if {"mass", "density"} <= frame.arrays.keys():
        return Liquid(position, frame.arrays["mass"] / frame.arrays["density"], values)
    return Liquid(position, np.full(len(position), spacing ** position.shape[1]), values)


def room_of(
    scene: SphScene, frame: Frame, position: Array, window: tuple[Array, Array] | None = None
) -> tuple[Array, Array]:
    """The corners of the tank where its walls are now; at open sides as far as the liquid reaches."""
    low, high = (np.array(corner, dtype=float) for corner in (scene.tank.low, scene.tank.high))
    reach = SUPPORT * SMOOTHING * scene.spacing
    for number, side in enumerate(SIDES[: 2 * len(low)]):
        axis, first = number // 2, number % 2 == 0
        corner = low if first else high
        corner[axis] += frame.numbers.get(f"{side}_position", 0.0)
        if getattr(scene.tank, side).kind not in OPEN or not len(position):
            continue
        end = float(position[:, axis].min() if first else position[:, axis].max()) + (-reach if first else reach)
        if window is not None:
            end = max(end, window[0][axis] - reach) if first else min(end, window[1][axis] + reach)
        corner[axis] = end
    return low, np.maximum(high, low + scene.spacing)


def solids_in(scene: SphScene, frame: Frame) -> Inside | None:
    """Which points are inside obstacles and bodies of this frame; None without any."""
    from ecume.show.sph.picture import outline
    from ecume.show.sph.solids import body_lines

    shapes: list[Shape] = [outline(solid) for solid in scene.obstacles]
    for number, body in enumerate(scene.bodies):
        shapes += [line[:-1] if body.radius is not None else line for line in body_lines(body, number, frame, None)]
    return (lambda points: inside_any(shapes, points)) if shapes else None


def inside_any(shapes: Sequence[Shape], points: Array) -> Flags:
    """(N,) which points (N, 2) are inside one of the shapes."""
    found = np.zeros(len(points), bool)
    for shape in shapes:
        if isinstance(shape, Round):
            found |= np.hypot(points[:, 0] - shape.x, points[:, 1] - shape.y) < shape.radius
            continue
        near = np.flatnonzero(np.all((points >= shape.min(axis=0)) & (points <= shape.max(axis=0)), axis=1))
        found[near] |= Path(np.vstack([shape, shape[:1]])).contains_points(points[near])
    return found


class Water:
    """The artists of a liquid: `put` gives them the region of a frame."""

    def __init__(self, axes: Axes, scene: SphScene, color: str = RIM) -> None:
        self.axes, self.scene = axes, scene
        self.image = axes.imshow(np.zeros((2, 2, 4)), origin="lower", interpolation="bilinear", aspect="auto", zorder=1)
        self.line = LineCollection([], colors=color, linewidths=0.9, alpha=0.75, zorder=1.5)
        axes.add_collection(self.line, autolim=False)

    @property
    def artists(self) -> list[Artist]:
        """From the lowest up."""
        return [self.image, self.line]

    def put(self, frame: Frame, values: Array, colors: Callable[[Array], Array]) -> None:
        """Show a frame; `colors` makes (..., 4) colors of means (..., k) of the values (N, k)."""
        view: Any = (self.axes.get_xlim(), self.axes.get_ylim())
        surface = surface_of(self.scene, frame, values, self._fine(), tuple(np.array(view).T))
        grid, shown = surface.grid, np.asarray(colors(surface.region.values), float)
        self.image.set_data(np.clip(shown.swapaxes(0, 1), 0.0, 1.0))
        self.image.set_extent((grid.low[0], grid.high[0], grid.low[1], grid.high[1]))
        self.axes.set(xlim=view[0], ylim=view[1])
        self.image.set_clip_path(surface.outline(), self.axes.transData)
        self.image.set_visible(bool((surface.region.level > 0.0).any()))
        self.line.set_segments(surface.lines())

    def _fine(self) -> float:
        """Cells per spacing, for the pixels that the axes have."""
        (left, _), (right, _) = self.axes.transData.transform([(0.0, 0.0), (self.scene.spacing, 0.0)])
        return min(max(float(right - left) / CELL, COARSEST), FINEST)
