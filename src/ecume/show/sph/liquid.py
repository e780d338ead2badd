"""The liquid as a continuous region: the sum of smooth kernels around its particles on a grid, and its drawing by
Matplotlib in 2D.

Each particle is spread over a Gaussian of standard deviation `SMOOTHING` spacings, in 2D and 3D. The sum of volume
times kernel is 1 inside the liquid, 0 outside, and 1/2 at its edge: a lattice with a flat edge ends half a spacing
beyond its last row. The sum is mirrored at walls, continued at periodic sides, and near solids divided by the part that
is not solid, so that no gap remains between liquid and solid. A particle far from all others is a disc (a ball) of the
particle's volume.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from contourpy import FillType, LineType, contour_generator
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.path import Path
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, map_coordinates

from ecume.engine.shapes import Flags
from ecume.laws import wall_forces
from ecume.show.sph.solids import body_lines, outline
from ecume.show.style import RIM
from ecume.show.tank import Round, Shape
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.sph import SphScene


SMOOTHING = wall_forces.SPREAD
"""The standard deviation of the kernel in spacings, as used by gauges to distinguish liquid and air."""
SUPPORT = 4.0
"""The range of the kernel, in standard deviations."""
SLOPE = 1.0 / (SMOOTHING * math.sqrt(2.0 * math.pi))
"""The slope of the sum at a flat edge, per spacing."""
LONELY, TOGETHER = 0.36, 0.50
"""The sum at a particle below which it is drawn as a disc of its full size, and above which it is
not drawn as a disc.
"""
BURIED = 0.95
"""The solid fraction of a cell above which it counts as solid."""

Counts = NDArray[np.int64]
Inside = Callable[[Array], NDArray[np.bool_]]
"""A function that flags the points (N, d) inside a solid."""


class Grid(NamedTuple):
    """Cells that fill a box; on each axis they are repeated periodically, or mirrored at both ends."""

    low: Array
    """(d,) m"""
    high: Array
    """(d,) m"""
    shape: tuple[int, ...]
    periodic: tuple[bool, ...]

    @property
    def cell(self) -> Array:
        """The size of a cell, (d,) m."""
        size: Array = (self.high - self.low) / np.array(self.shape)
        return size

    def centers(self, axis: int) -> Array:
        """The centers of the cells along an axis (m)."""
        middle: Array = self.low[axis] + self.cell[axis] * (np.arange(self.shape[axis]) + 0.5)
        return middle

    def points(self) -> Array:
        """The centers of all cells, (cells, d)."""
        axes = np.meshgrid(*(self.centers(axis) for axis in range(len(self.shape))), indexing="ij")
        return np.stack([axis.ravel() for axis in axes], axis=1)


def grid_in(low: Array, high: Array, size: float, periodic: Sequence[bool]) -> Grid:
    """Cells of about this size (m) between two corners."""
    counts = tuple(max(2, round(float(length) / size)) for length in high - low)
    return Grid(np.asarray(low, float), np.asarray(high, float), counts, tuple(periodic))


class Liquid(NamedTuple):
    """The particles of a liquid."""

    position: Array
    """(N, d) m"""
    volume: Array
    """(N,) m^d"""
    values: Array
    """(N, k) the quantities that are interpolated"""


class Region(NamedTuple):
    """A liquid on a grid."""

    level: Array
    """above 0 inside the liquid, 0 at its edge, in parts of the kernel sum"""
    values: Array
    """(*shape, k) Shepard's means of the quantities; 0 far from all particles"""


def region_of(liquid: Liquid, grid: Grid, spacing: float, solid: Inside | None = None) -> Region:
    """The region of the liquid and its mean quantities; `solid` flags the points inside solids."""
    inside = np.all((liquid.position >= grid.low) & (liquid.position <= grid.high), axis=1)
    liquid = Liquid(*(part[inside] for part in liquid))
    widths = SMOOTHING * spacing / grid.cell
    weights = np.column_stack([liquid.volume, liquid.volume[:, None] * liquid.values])
    sums = [smoothed(deposited(liquid.position, column, grid), widths, grid, linear=True) for column in weights.T]
    filled = sums[0] / float(np.prod(grid.cell))
    least = 1e-9 * max(float(sums[0].max(initial=0.0)), 1e-300)
    seen = sums[0] > least
    values = [np.divide(one, sums[0], out=np.zeros_like(one), where=seen) for one in sums[1:]]
    level = beside_solids(filled, grid, widths, solid) - 0.5 if solid is not None else filled - 0.5
    alone = lonely_part(read(filled, liquid.position, grid))
    add_discs(level, grid, liquid, alone, spacing)
    stacked = np.stack(values, axis=-1) if values else np.zeros((*grid.shape, 0))
    return Region(level, stacked)


def deposited(position: Array, weight: Array, grid: Grid) -> Array:
    """Each particle's weight on the nearest cells, linear between their centers, mirrored or repeated at the ends."""
    place = (position - grid.low) / grid.cell - 0.5
    first = np.floor(place).astype(np.int64)
    part = place - first
    total = np.zeros(int(np.prod(grid.shape)))
    for corner in itertools.product((0, 1), repeat=len(grid.shape)):
        share = weight * np.prod(np.where(corner, part, 1.0 - part), axis=1)
        cells = [_folded(first[:, axis] + step, grid, axis) for axis, step in enumerate(corner)]
        total += np.bincount(np.ravel_multi_index(cells, grid.shape), share, len(total))
    return total.reshape(grid.shape)


def _folded(index: Counts, grid: Grid, axis: int) -> Counts:
    """Indices of cells beyond an end, replaced by those of the mirrored or repeated cells."""
    count = grid.shape[axis]
    if grid.periodic[axis]:
        return np.asarray(index % count)
    return np.clip(index, 0, count - 1)


def smoothed(field: Array, widths: Array, grid: Grid, *, linear: bool) -> Array:
    """The convolution with the kernel, without the smoothing that the `linear` deposition has already caused."""
    for axis, width in enumerate(widths):
        own = math.sqrt(max(float(width) ** 2 - (1.0 / 6.0 if linear else 0.0), 1e-6))
        ends: Literal["wrap", "reflect"] = "wrap" if grid.periodic[axis] else "reflect"
        field = gaussian_filter1d(field, own, axis, mode=ends, truncate=SUPPORT)
    return field


def beside_solids(filled: Array, grid: Grid, widths: Array, solid: Inside) -> Array:
    """The sum over the part of the kernel that is not inside a solid."""
    covered = solid(grid.points()).reshape(grid.shape).astype(float)
    if not covered.any():
        return filled
    part = smoothed(covered, widths, grid, linear=False)
    return np.where(part < BURIED, filled / np.maximum(1.0 - part, 1.0 - BURIED), 0.0)


def read(field: Array, position: Array, grid: Grid) -> Array:
    """The values of a field at points, linear between the centers of the cells."""
    place = ((position - grid.low) / grid.cell - 0.5).T
    found = np.zeros(len(position))
    map_coordinates(field, place, output=found, order=1, mode="grid-wrap" if all(grid.periodic) else "nearest")
    return found


def lonely_part(filled: Array) -> Array:
    """The size of a particle's disc over its full size, for this filling of its surroundings: 1 for an isolated
    particle, 0 inside a liquid.
    """
    part: Array = np.clip((TOGETHER - filled) / (TOGETHER - LONELY), 0.0, 1.0)
    return part


def add_discs(level: Array, grid: Grid, liquid: Liquid, part: Array, spacing: float) -> None:
    """Raise the level around each isolated particle to that of a disc (a ball) with the volume of the particle."""
    chosen = part > 0.0
    if not chosen.any():
        return
    dimension = len(grid.shape)
    ball = math.pi if dimension == 2 else 4.0 / 3.0 * math.pi
    radius = part[chosen] * (liquid.volume[chosen] / ball) ** (1.0 / dimension)
    place = (liquid.position[chosen] - grid.low) / grid.cell - 0.5
    reach = [math.ceil(float(radius.max()) / float(size) + 1.0) for size in grid.cell]
    window = np.stack(np.meshgrid(*(np.arange(-n, n + 1) for n in reach), indexing="ij"), -1).reshape(-1, dimension)
    cells = np.rint(place).astype(np.int64)[:, None, :] + window[None]
    away = np.linalg.norm((cells - place[:, None, :]) * grid.cell, axis=2)
    height = (radius[:, None] - away) * (SLOPE / spacing)
    kept = np.all((cells >= 0) & (cells < np.array(grid.shape)), axis=2) & (height > -0.5)
    flat = np.ravel_multi_index(tuple(cells[kept].T), grid.shape)
    np.maximum.at(level.reshape(-1), flat, height[kept])


CELL = 4.0
"""The size of a cell in pixels, if that is finer than half a spacing."""
FINEST, COARSEST = 10.0, 2.0
"""The largest and the smallest number of cells per spacing."""
MOST_CELLS = 400_000
OPEN = ("open",)


class Surface(NamedTuple):
    """The region of a liquid and its grid."""

    region: Region
    grid: Grid

    def padded(self) -> tuple[Array, Array, Array]:
        """The level extended to the sides of the grid by the adjacent cells: x, y, level (y, x)."""
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
        """The free surface, (K, 2) each in m; it ends at walls and does not run along them."""
        x, y, level = self.padded()
        lines: Any = contour_generator(x, y, level, line_type=LineType.Separate).lines(0.0)
        return list(lines)


def surface_of(
    scene: SphScene, frame: Frame, values: Array, fine: float = COARSEST, window: tuple[Array, Array] | None = None
) -> Surface:
    """The region of the liquid in a frame with the means of (N, k) values, on a grid with `fine` cells per spacing.

    `window` contains the corners of the visible region, where open sides end.
    """
    liquid = liquid_in(frame, scene.spacing, values)
    low, high = room_of(scene, frame, liquid.position, window)
    size = max(scene.spacing / fine, math.sqrt(float(np.prod(high - low)) / MOST_CELLS))
    kinds = [getattr(scene.tank, side).kind for side in scene.sides]
    grid = grid_in(low, high, size, (kinds[0] == "periodic", kinds[2] == "periodic"))
    return Surface(region_of(liquid, grid, scene.spacing, solids_in(scene, frame)), grid)


def free_lines(scene: SphScene, frame: Frame) -> list[Array]:
    """The free surface of a frame in 2D as lines, (K, 2) each in m, which end at walls and solids."""
    lines = surface_of(scene, frame, np.zeros((len(frame.arrays["position"]), 0))).lines()
    solid = solids_in(scene, frame)
    return lines if solid is None else [piece for line in lines for piece in outside_of(solid, line)]


def outside_of(solid: Inside, line: Array) -> list[Array]:
    """The pieces of a line (K, 2) outside of solids."""
    inside = solid(line)
    ends = np.flatnonzero(inside[1:] != inside[:-1]) + 1
    pieces = np.split(line, ends)
    return [piece for piece, hidden in zip(pieces, inside[[0, *ends]], strict=True) if not hidden and len(piece) > 1]


def liquid_in(frame: Frame, spacing: float, values: Array) -> Liquid:
    """The particles of a frame with values (N, k) and volumes."""
    position = frame.arrays["position"]
    if {"mass", "density"} <= frame.arrays.keys():
        return Liquid(position, frame.arrays["mass"] / frame.arrays["density"], values)
    return Liquid(position, np.full(len(position), spacing ** position.shape[1]), values)


def room_of(
    scene: SphScene, frame: Frame, position: Array, window: tuple[Array, Array] | None = None
) -> tuple[Array, Array]:
    """The corners of the tank at the present positions of its walls; at open sides, those of the liquid."""
    low, high = walls_at(scene, frame)
    reach = SUPPORT * SMOOTHING * scene.spacing
    for number, side in enumerate(scene.sides):
        axis, first = number // 2, number % 2 == 0
        corner = low if first else high
        if getattr(scene.tank, side).kind not in OPEN or not len(position):
            continue
        end = float(position[:, axis].min() if first else position[:, axis].max()) + (-reach if first else reach)
        if window is not None:
            end = max(end, window[0][axis] - reach) if first else min(end, window[1][axis] + reach)
        corner[axis] = end
    return low, np.maximum(high, low + scene.spacing)


def walls_at(scene: SphScene, frame: Frame) -> tuple[Array, Array]:
    """The corners of the tank at the positions of its sides in a frame."""
    low, high = (np.array(corner, dtype=float) for corner in (scene.tank.low, scene.tank.high))
    for number, side in enumerate(scene.sides):
        (low, high)[number % 2][number // 2] += frame.numbers.get(f"{side}_position", 0.0)
    return low, high


def solids_in(scene: SphScene, frame: Frame) -> Inside | None:
    """A function that flags the points inside obstacles and bodies of this frame; None without any."""
    shapes: list[Shape] = [outline(solid, scene.tank) for solid in scene.obstacles]
    for name, body in zip(scene.body_names, scene.bodies, strict=True):
        shapes += [line[:-1] if body.radius is not None else line for line in body_lines(body, name, frame, None)]
    return (lambda points: inside_any(shapes, points)) if shapes else None


def inside_any(shapes: Sequence[Shape], points: Array) -> Flags:
    """Flags (N,) of the points (N, 2) inside one of the shapes."""
    found = np.zeros(len(points), bool)
    for shape in shapes:
        if isinstance(shape, Round):
            found |= np.hypot(points[:, 0] - shape.x, points[:, 1] - shape.y) < shape.radius
            continue
        near = np.flatnonzero(np.all((points >= shape.min(axis=0)) & (points <= shape.max(axis=0)), axis=1))
        found[near] |= Path(np.vstack([shape, shape[:1]])).contains_points(points[near])
    return found


class Water:
    """The artists of a liquid, to which `put` passes the region of a frame."""

    def __init__(self, axes: Axes, scene: SphScene, color: str = RIM) -> None:
        self.axes, self.scene = axes, scene
        self.image = axes.imshow(np.zeros((2, 2, 4)), origin="lower", interpolation="bilinear", aspect="auto", zorder=1)
        self.line = LineCollection([], colors=color, linewidths=0.9, alpha=0.75, zorder=1.5)
        axes.add_collection(self.line, autolim=False)

    @property
    def artists(self) -> list[Artist]:
        """The artists, from the lowest up."""
        return [self.image, self.line]

    def put(self, frame: Frame, values: Array, colors: Callable[[Array], Array]) -> None:
        """Draw a frame; `colors` makes (..., 4) colors of means (..., k) of the values (N, k)."""
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
        """The number of cells per spacing that suits the pixels of the axes."""
        (left, _), (right, _) = self.axes.transData.transform([(0.0, 0.0), (self.scene.spacing, 0.0)])
        return min(max(float(right - left) / CELL, COARSEST), FINEST)
