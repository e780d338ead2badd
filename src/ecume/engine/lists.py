"""Full neighbor lists for crowds whose reach is a few spacings: every particle has all its neighbors, in cell order.

Arrays of many particles stand axis by axis, (d, N), so that a loop over neighbors reads along one contiguous row. Lists
are made by threads and are the same for any number of them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import compiled, prange, threaded
from ecume.engine.cells import Integers
from ecume.units import Array

Slots = NDArray[np.uint32]
CHUNK = 128
"""Particles that one thread takes at a time."""
ROOMIER = 1.3


class Grid(NamedTuple):
    """Cubic cells, at least `reach` wide, around a crowd, with a border of empty ones: bounds need no tests."""

    low: Array
    """(d,)"""
    size: float
    shape: Integers
    """(d,) cells along each axis, the border included"""


class Lists(NamedTuple):
    """The neighbors of the first `len(counts)` particles of a crowd."""

    counts: NDArray[np.int32]
    """(n,)"""
    neighbor: Slots
    """(n, room)"""


def grid_around(position: Array, reach: float) -> Grid:
    """The cells of a crowd, (d, N); larger ones where it is so sparse that there would be many more than particles."""
    low, high = position.min(axis=1), position.max(axis=1)
    size = reach
    most = 4.0 * position.shape[1] + 64.0
    while np.prod(np.floor((high - low) / size) + 3.0) > most and size < 1e6 * reach:
        size *= 1.25
    shape = (np.floor((high - low) / size) + 3.0).astype(np.int64)
    return Grid(low - size, size, shape)


@threaded
def _cells_of(position: Array, low: Array, size: float, shape: Integers, cell: Integers) -> None:
    dimension, count = position.shape
    for i in prange(count):
        number = 0
        for axis in range(dimension):
            number = number * shape[axis] + int((position[axis, i] - low[axis]) / size)
        cell[i] = number


def cell_order(position: Array, grid: Grid) -> tuple[Integers, Integers]:
    """The particles cell by cell, ascending inside a cell, and where each cell begins."""
    cell = np.empty(position.shape[1], np.int64)
    _cells_of(position, grid.low, grid.size, grid.shape, cell)
    start = np.zeros(int(np.prod(grid.shape)) + 1, np.int64)
    order = np.empty(len(cell), np.int64)
    _counting_sort(cell, start, order)
    return order, start


@compiled
def _counting_sort(cell: Integers, start: Integers, order: Integers) -> None:
    """Linear and stable."""
    for i in range(len(cell)):
        start[cell[i] + 1] += 1
    for number in range(len(start) - 1):
        start[number + 1] += start[number]
    place = start[:-1].copy()
    for i in range(len(cell)):
        order[place[cell[i]]] = i
        place[cell[i]] += 1


def neighbor_lists(position: Array, centers: int, passive: tuple[int, int], reach: float, room: int) -> Lists:
    """All neighbors closer than `reach` of the first `centers` particles of a crowd, (d, N); nobody is its own.

    Particles from `passive[0]` up to `passive[1]` are not neighbors of one another: walls do not act on walls.
    `room` is a guess of the most neighbors; where it is too small the lists are made anew with more.
    """
    grid = grid_around(position, reach)
    order, start = cell_order(position, grid)
    sorted_position = np.ascontiguousarray(position[:, order])
    runs = _runs(grid.shape)
    while True:
        lists = Lists(np.zeros(centers, np.int32), np.empty((centers, room), np.uint32))
        _fill(sorted_position, order, start, grid.shape, runs, np.array(passive), reach * reach, *lists)
        most = int(lists.counts.max(initial=0))
        if most <= room:
            return lists
        room = math.ceil(ROOMIER * most)


def _runs(shape: Integers) -> Integers:
    """Neighboring cells as runs of three along the last axis: how far each run's middle is from one's own cell."""
    offsets = [0]
    for axis in range(len(shape) - 1):
        stride = int(np.prod(shape[axis + 1 :]))
        offsets = [offset + step * stride for offset in offsets for step in (-1, 0, 1)]
    return np.sort(np.array(offsets, np.int64))


@threaded
def _fill(
    position: Array,
    order: Integers,
    start: Integers,
    shape: Integers,
    runs: Integers,
    passive: Integers,
    square: float,
    count: NDArray[np.int32],
    neighbor: Slots,
) -> None:
    """One row a particle, in the order of cells; counts go on where a row is full."""
    dimension, room = position.shape[0], neighbor.shape[1]
    cells = len(start) - 1
    first, last = passive[0], passive[1]
    for cell in prange(cells):
        for place in range(start[cell], start[cell + 1]):
            i = order[place]
            if i >= len(count):
                continue
            is_passive = first <= i < last
            found = 0
            for run in range(len(runs)):
                middle = cell + runs[run]
                for other in range(start[middle - 1], start[middle + 2]):
                    distance = 0.0
                    for axis in range(dimension):
                        along = position[axis, other] - position[axis, place]
                        distance += along * along
                    j = order[other]
                    if distance < square and j != i and not (is_passive and first <= j < last):
                        if found < room:
                            neighbor[i, found] = j
                        found += 1
            count[i] = found
