"""The liquid as a continuous region: the sum of smooth kernels around its particles, on a grid, in 2D and 3D.

Each particle is spread over a Gaussian of standard deviation `SMOOTHING` spacings. The sum of volume times kernel is
1 inside the liquid, 0 outside, and 1/2 at its edge: a lattice with a flat edge ends half a spacing beyond its last row.
At walls the sum is mirrored, at periodic sides continued, and beside solids divided by the part that is not solid, so
that the liquid ends at them without a gap. A particle far from all others is a disc (a ball) of the particle's volume.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, map_coordinates

from ecume.units import Array

SMOOTHING = math.sqrt(0.5)
"""Of the kernel: its standard deviation in spacings. The sum over a square lattice ripples by 2 exp(-pi^2), 1e-4."""
SUPPORT = 4.0
"""Of the kernel, in standard deviations."""
SLOPE = 1.0 / (SMOOTHING * math.sqrt(2.0 * math.pi))
"""Of the sum at a flat edge, per spacing."""
LONELY, TOGETHER = 0.36, 0.50
"""The sum at a particle below which it is drawn as a disc of its full size, and above which not at all."""
BURIED = 0.95
"""The solid part of a place beyond which it counts as solid."""

Counts = NDArray[np.int64]
Inside = Callable[[Array], NDArray[np.bool_]]
"""Which of points (N, d) are inside a solid."""


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
        """(d,) the size of a cell (m)."""
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
    """The liquid's region and the means of its quantities; `solid` says which points are inside solids."""
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
    """Indices of cells beyond an end are those of the mirrored or the repeated cell."""
    count = grid.shape[axis]
    if grid.periodic[axis]:
        return np.asarray(index % count)
    return np.clip(index, 0, count - 1)


def smoothed(field: Array, widths: Array, grid: Grid, *, linear: bool) -> Array:
    """The convolution with the kernel; `linear` deposition has smoothed by a part of it already."""
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
    """A field at points, linear between the centers of the cells."""
    place = ((position - grid.low) / grid.cell - 0.5).T
    found = np.zeros(len(position))
    map_coordinates(field, place, output=found, order=1, mode="grid-wrap" if all(grid.periodic) else "nearest")
    return found


def lonely_part(filled: Array) -> Array:
    """How much of its disc a particle keeps whose surroundings are filled to this part: 1 alone, 0 inside a liquid."""
    part: Array = np.clip((TOGETHER - filled) / (TOGETHER - LONELY), 0.0, 1.0)
    return part


def add_discs(level: Array, grid: Grid, liquid: Liquid, part: Array, spacing: float) -> None:
    """Raise the level to that of a disc (a ball) of the particle's volume around each particle that is alone."""
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
