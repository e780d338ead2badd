"""Full neighbor lists for dense systems with a reach of a few spacings: all neighbors of each particle, in cell order.

Arrays of many particles are stored axis by axis, (d, N), so that a loop over neighbors reads along one contiguous row.
Lists are made by threads and are the same for any number of threads.

Cells are as wide as the reach, but only a quarter of it along the last axis: a row of cells is one run of sorted
particles, and in each neighboring row only the part inside a sphere around the particle is searched.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import FEW, compiled_inside, prange, spread
from ecume.engine.cells import Integers
from ecume.units import Array

Slots = NDArray[np.int32]
"""The type of indices in lists. They are signed, so that sums can use eight of them as offsets without conversion; read
as `INDEX`, they are never negative.
"""
INDEX = np.uint64
CHUNK = 128
"""The number of particles that one thread processes at a time."""
BLOCKS = 16
"""Blocks of particles that are counted separately; their number must not depend on the number of threads."""
SLICES = 4
"""The number of cells per reach along the last axis."""
STRIDE = 8
"""Rows of neighbors are padded to a multiple of this with the particle itself, so that whole vectors can be read."""
BEFORE, DOWN = INDEX(STRIDE - 1), INDEX(2**64 - STRIDE)
ROOMIER = 1.25
OUTLIERS = 0.02


class Grid(NamedTuple):
    """A grid of cells. Particles outside belong to the nearest cell."""

    low: Array
    """(d,)"""
    edge: Array
    """(d,) at least the reach, along the last axis a quarter of it"""
    shape: Integers
    """(d,) cells along each axis"""


class Lists(NamedTuple):
    """The neighbors of the first `len(counts)` particles, row after row."""

    counts: NDArray[np.int32]
    """(n,)"""
    start: Integers
    """(n + 1,) where each row begins, a multiple of STRIDE, and the end of the last"""
    neighbor: Slots
    """flat, with room beyond the end, which is no memory until it is written"""


def empty_lists(centers: int) -> Lists:
    """Lists without neighbors."""
    return Lists(np.zeros(centers, np.int32), np.zeros(centers + 1, np.int64), np.empty(0, np.int32))


def pairs_in(lists: Lists, count: int) -> tuple[Integers, Integers]:
    """The pairs of the first `count` particles with their neighbors, without padding: the particle of each pair, and
    the index of its neighbor in the list.

    >>> mine, place = pairs_in(Lists(np.ones(2, np.int32), np.array([0, 8, 16]), np.zeros(16, np.int32)), 2)
    >>> mine.tolist(), place.tolist()
    ([0, 1], [0, 8])
    """
    mine = np.repeat(np.arange(count), np.diff(lists.start[: count + 1]))
    place = np.flatnonzero(np.arange(len(mine)) - lists.start[mine] < lists.counts[mine])
    return mine[place], place


@compiled_inside
def whole(count: int) -> np.uint64:
    """The length of a row, rounded up to whole vectors; the row is padded with the index of the particle."""
    return (INDEX(count) + BEFORE) & DOWN


def grid_around(position: Array, reach: float) -> Grid:
    """The grid of cells for positions (d, N).

    The number of cells does not much exceed that of particles: the grid excludes outliers, and cells are larger in
    sparse systems.
    """
    most = 2.0 * position.shape[1] + 64.0
    low, high = position.min(axis=1), position.max(axis=1)
    if not np.isfinite(high - low).all() or np.prod((high - low) / reach + 1.0) > most:
        known = np.where(np.isfinite(position), position, 0.0)
        low, high = (np.quantile(known, part, axis=1) for part in (OUTLIERS, 1.0 - OUTLIERS))
    size = reach
    while np.prod((high - low) / size + 1.0) > most:
        size *= 1.25
    edge = np.full(len(low), size)
    edge[-1] /= SLICES
    return Grid(low, edge, ((high - low) / edge).astype(np.int64) + 1)


class Sorted(NamedTuple):
    """Particles sorted by cell, ascending inside a cell."""

    position: Array
    """(d, N)"""
    order: Slots
    """(N,) the index of the particle at each place"""
    start: Integers
    """(cells + 1,) the first place of each cell"""


def sort_by_cell(position: Array, grid: Grid) -> Sorted:
    """The particles, (d, N), in the order of their cells."""
    count, cells = position.shape[1], int(np.prod(grid.shape))
    sorted_particles = Sorted(np.empty_like(position), np.empty(count, np.int32), np.empty(cells + 1, np.int64))
    tally = np.empty((BLOCKS if count >= FEW else 1, cells), np.int32)
    _counting_sort(position, *grid, np.empty(count, np.int32), tally, *sorted_particles)
    return sorted_particles


@spread
def _counting_sort(
    position: Array, low: Array, edge: Array, shape: Integers, cell: Slots, tally: Slots, there: Array,
    order: Slots, start: Integers,
) -> None:  # fmt: skip
    """Sort particles by cell, with a linear and stable counting sort: each block of particles is counted, gets offsets
    for each cell, and is written.
    """
    dimension, count = position.shape
    blocks, cells = tally.shape
    each = (count + blocks - 1) // blocks
    for block in prange(blocks):
        for number in range(cells):
            tally[block, number] = 0
        for i in range(block * each, min(count, (block + 1) * each)):
            number = 0
            for axis in range(dimension):
                number = number * shape[axis] + cell_at((position[axis, i] - low[axis]) / edge[axis], shape[axis])
            cell[i] = number
            tally[block, number] += 1
    total = 0
    for number in range(cells):
        start[number] = total
        for block in range(blocks):
            here = tally[block, number]
            tally[block, number] = total
            total += here
    start[cells] = total
    for block in prange(blocks):
        for i in range(block * each, min(count, (block + 1) * each)):
            place = tally[block, cell[i]]
            tally[block, cell[i]] += 1
            order[place] = i
            for axis in range(dimension):
                there[axis, place] = position[axis, i]


def neighbor_lists(position: Array, passive: tuple[int, int], reach: float, before: Lists) -> Lists:
    """The neighbors closer than `reach` of the first particles at positions (d, N), without the
    particle itself.

    Particles from `passive[0]` up to `passive[1]` are not neighbors of each other: walls do not act on walls. The
    arrays of the previous lists are reused; a larger one replaces theirs. Neighbors are counted first, which takes a
    third of the search time, so that each row has exactly the required length.
    """
    if not position.shape[1]:
        return before
    grid = grid_around(position, reach)
    sorted_particles = sort_by_cell(position, grid)
    longest = _longest_run(sorted_particles.start, 2 * math.ceil(reach / grid.edge[-1]) + 2)
    limits, (counts, start, neighbor) = np.array([*passive, longest]), before
    search = *sorted_particles, *grid, reach, limits
    _search(*search, counts, start, neighbor, False)
    np.cumsum(counts + (STRIDE - 1) & -STRIDE, out=start[1:])
    if start[-1] > len(neighbor):
        del before, neighbor  # memory that the larger one may take
        neighbor = np.empty(int(ROOMIER * start[-1]), np.int32)
    _search(*search, counts, start, neighbor, True)
    return Lists(counts, start, neighbor)


def _longest_run(start: Integers, cells: int) -> int:
    """The largest number of particles in this number of consecutive cells."""
    if len(start) <= cells:
        return int(start[-1])
    return int((start[cells:] - start[:-cells]).max())


@spread
def _search(
    position: Array, order: Slots, cell_start: Integers, low: Array, edge: Array, shape: Integers, reach: float,
    limits: Integers, count: NDArray[np.int32], start: Integers, neighbor: Slots, fills: bool,
) -> None:  # fmt: skip
    """Count the neighbors of each particle, or fill its row.

    Two loops avoid branches: the first computes the distances of a run, the second writes the indices, each over the
    previous one if that was too far.
    """
    dimension, particles = position.shape
    first, last, longest = limits[0], limits[1], limits[2]
    deep = dimension == 3
    x, y, z = position[dimension - 1], position[dimension - 2], position[0]
    slices, rows, layers = shape[dimension - 1], shape[dimension - 2], shape[0] if deep else 1
    x_low, y_low, z_low = low[dimension - 1], low[dimension - 2], low[0]
    y_edge, z_edge = edge[dimension - 2], edge[0]
    inverse, square = 1.0 / edge[dimension - 1], reach * reach
    for chunk in prange((particles + CHUNK - 1) // CHUNK):
        distance = np.empty(longest, np.float64)
        found = np.empty(9 * longest + STRIDE, np.int32)
        for place in range(INDEX(chunk * CHUNK), INDEX(min(particles, (chunk + 1) * CHUNK))):
            i = order[place]
            if i >= len(count):
                continue
            xi, yi, zi = x[place], y[place], z[place]
            row = cell_at((yi - y_low) / y_edge, rows)
            layer = cell_at((zi - z_low) / z_edge, layers) if deep else 0
            at, idle = INDEX(0), first <= i < last
            for k in range(max(layer - 1, 0), min(layer + 2, layers)):
                over = _gap_to(zi, z_low, z_edge, k, layer)
                above = square - over * over
                for m in range(max(row - 1, 0), min(row + 2, rows)):
                    over = _gap_to(yi, y_low, y_edge, m, row)
                    left = above - over * over
                    if left <= 0.0:
                        continue
                    chord = math.sqrt(left)
                    line = (k * rows + m) * slices
                    begin = INDEX(cell_start[line + cell_at((xi - chord - x_low) * inverse, slices)])
                    end = INDEX(cell_start[line + cell_at((xi + chord - x_low) * inverse, slices) + 1])
                    length = end - begin
                    if deep:
                        for n in range(length):
                            dx, dy, dz = x[begin + n] - xi, y[begin + n] - yi, z[begin + n] - zi
                            distance[n] = dx * dx + dy * dy + dz * dz
                    else:
                        for n in range(length):
                            dx, dy = x[begin + n] - xi, y[begin + n] - yi
                            distance[n] = dx * dx + dy * dy
                    if begin <= place < end:
                        distance[place - begin] = math.inf
                    if not fills and not idle:
                        for n in range(length):
                            at += INDEX(distance[n] < square)
                        continue
                    for n in range(length):
                        found[at] = order[begin + n]
                        at += INDEX(distance[n] < square)
            if idle:
                kept = INDEX(0)
                for n in range(at):
                    found[kept] = found[n]
                    kept += INDEX(not first <= found[n] < last)
                at = kept
            count[i] = at
            if fills:
                while at % STRIDE != 0:
                    found[at] = i
                    at += INDEX(1)
                first_place = INDEX(start[i])
                for n in range(at):
                    neighbor[first_place + n] = found[n]


@compiled_inside
def cell_at(along: float, cells: int) -> int:
    """The index of the cell at this number of edges along an axis; NaN is in the first cell."""
    return int(min(along, cells - 1.0)) if along > 0.0 else 0


@compiled_inside
def _gap_to(x: float, low: float, edge: float, cell: int, own: int) -> float:
    """The distance to a neighboring cell."""
    if cell == own:
        return 0.0
    return max(max(low + cell * edge - x, x - (low + (cell + 1) * edge)), 0.0)
