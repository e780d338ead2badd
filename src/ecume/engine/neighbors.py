"""Who is near whom: full lists with a skin, kept while nobody has moved by more than half of it.

Particles are renumbered cell by cell ("slots") so that neighbors lie close in memory. Each slot's list holds all its
neighbors in ascending order: sums over all of them, or over the later ones, which is each pair once, have one order.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, prange, threaded
from ecume.engine.cells import Cells, Integers, make_cells, sort_into_cells
from ecume.units import Array

Slots = np.ndarray[tuple[int, ...], np.dtype[np.uint32]]

THREADS_FROM = 2000
"""Below this many particles starting threads takes longer than they save."""


class Rows(NamedTuple):
    """Neighbors of slot s: `neighbor[first[s]:first[s + 1]]`, slots themselves. Flat, since Numba's threads take no
    nested tuples.
    """

    first: Integers
    later: Integers
    """(N,) where the neighbors with higher slots begin"""
    neighbor: Slots
    sorted_position: Array
    """(d, N) by slots"""


class NeighborLists(NamedTuple):
    """Slot s is particle `cells.order[s]`; its neighbors stand in `rows`."""

    cells: Cells
    rows: Rows
    valid: Integers
    """(1,) whether the lists hold; a new workspace has none"""


def make_lists(count: int, dimension: int, capacity: int) -> NeighborLists:
    """Room for `capacity` neighbors in all."""
    return NeighborLists(
        cells=make_cells(count, dimension),
        rows=Rows(
            first=np.zeros(count + 1, np.int64),
            later=np.zeros(count, np.int64),
            neighbor=np.zeros(max(capacity, 16), np.uint32),
            sorted_position=np.zeros((dimension, count)),
        ),
        valid=np.zeros(1, np.int64),
    )


@compiled
def sort_positions(lists: NeighborLists, position: Array) -> None:
    """Copy the positions into the order of the slots."""
    count, dimension = position.shape
    for slot in range(count):
        i = lists.cells.order[slot]
        for axis in range(dimension):
            lists.rows.sorted_position[axis, slot] = position[i, axis]


@compiled
def _visit(cells: Cells, x: Array, slot: int, reach: float, found_slots: Slots) -> int:
    """Count the neighbors of one slot, and write down as many as there is room for."""
    dimension = x.shape[0]
    cell = cells.cell[cells.order[slot]]
    found = 0
    for number in range(3**dimension):
        other, inside = _cell_beside(cells.shape, cell, number)
        if not inside:
            continue
        for candidate in range(cells.start[other], cells.start[other + 1]):
            square = 0.0
            for axis in range(dimension):
                apart = x[axis, candidate] - x[axis, slot]
                square += apart * apart
            if square < reach * reach and candidate != slot:
                if found < len(found_slots):
                    found_slots[found] = candidate
                found += 1
    return found


@compiled
def _cell_beside(shape: Integers, cell: int, number: int) -> tuple[int, bool]:
    """The `number`-th of the 3^d cells around `cell`, and whether it is inside the grid."""
    other, stride, inside = 0, 1, True
    for axis in range(len(shape) - 1, -1, -1):
        along = cell % shape[axis] + number % 3 - 1
        cell //= shape[axis]
        number //= 3
        inside = inside and 0 <= along < shape[axis]
        other += along * stride
        stride *= shape[axis]
    return other, inside


@threaded
def _visit_in_threads(cells: Cells, x: Array, reach: float, first: Integers, neighbor: Slots) -> None:
    # Inside a prange Numba writes to a copy of an array that is reached through a tuple: hence the bare arrays.
    for row in prange(len(first) - 1):
        # Signed as outside of threads, so that one compilation serves both.
        slot = int(np.int64(row))
        if len(neighbor) == 0:
            first[slot + 1] = _visit(cells, x, slot, reach, neighbor)
        else:
            _visit(cells, x, slot, reach, neighbor[first[slot] : first[slot + 1]])


@compiled
def _visit_all(cells: Cells, x: Array, reach: float, first: Integers, neighbor: Slots) -> None:
    """Without room (`neighbor` empty) count into `first`, else write."""
    if len(first) > THREADS_FROM:
        _visit_in_threads(cells, x, reach, first, neighbor)
        return
    for slot in range(len(first) - 1):
        if len(neighbor) == 0:
            first[slot + 1] = _visit(cells, x, slot, reach, neighbor)
        else:
            _visit(cells, x, slot, reach, neighbor[first[slot] : first[slot + 1]])


@compiled
def build(lists: NeighborLists, position: Array, reach: float) -> bool:
    """List all neighbors nearer than `reach`. False when there is no room for them: the lists are then empty."""
    rows = lists.rows
    sort_into_cells(lists.cells, position, reach)
    sort_positions(lists, position)
    rows.first[0] = 0
    _visit_all(lists.cells, rows.sorted_position, reach, rows.first, rows.neighbor[:0])
    for slot in range(position.shape[0]):
        rows.first[slot + 1] += rows.first[slot]
    if rows.first[position.shape[0]] > len(rows.neighbor):
        for slot in range(position.shape[0]):
            rows.first[slot + 1], rows.later[slot] = 0, 0
        lists.valid[0] = 0
        return False
    _visit_all(lists.cells, rows.sorted_position, reach, rows.first, rows.neighbor)
    _part_rows(rows.first, rows.later, rows.neighbor)
    lists.valid[0] = 1
    return True


@compiled
def _part_rows(first: Integers, later: Integers, neighbor: Slots) -> None:
    """Find where in each row the higher slots begin: cells are visited in their order, so that rows ascend."""
    for slot in range(len(later)):
        low, high = first[slot], first[slot + 1]
        while low < high:
            middle = (low + high) // 2
            if neighbor[middle] < slot:
                low = middle + 1
            else:
                high = middle
        later[slot] = low


@compiled
def farthest_move(position: Array, reference: Array) -> float:
    """The longest way any particle went since `reference`; NaN if a position is none."""
    farthest = 0.0
    for i in range(position.shape[0]):
        square = 0.0
        for axis in range(position.shape[1]):
            moved = position[i, axis] - reference[i, axis]
            square += moved * moved
        # Written so that a NaN is taken, and kept.
        if farthest == farthest and not square <= farthest:
            farthest = square
    return math.sqrt(farthest)
