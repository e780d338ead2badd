"""Verlet neighbor lists: full lists with a skin, valid while no particle has moved by more than half of the skin.

Particles are renumbered cell by cell ("slots") so that neighbors are close in memory. The list of each slot contains
all its neighbors in ascending order. This fixes the order of sums over all neighbors, and over the later ones only, in
which each pair occurs once.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside, prange, threaded
from ecume.engine.cells import Cells, Integers, make_cells, nearest, sort_into_cells
from ecume.units import Array

Slots = np.ndarray[tuple[int, ...], np.dtype[np.uint32]]

THREADS_FROM = 2000
"""The number of particles from which threads are used."""
CHUNK = 256
"""Slots per task of a thread."""
STRETCHES = 32
"""Number of parts into which the sum over all pairs is divided; it does not depend on the number of threads."""


Span = tuple[int, int, int]
"""The first slot, the end, and the longest run of slots that is searched."""


class Rows(NamedTuple):
    """Lists of neighbors: those of slot s are the slots `neighbor[first[s]:first[s + 1]]`. The tuple is flat, since
    threads in Numba do not support nested tuples.
    """

    first: Integers
    later: Integers
    """(N,) index of the first neighbor with a higher slot"""
    neighbor: Slots
    sorted_position: Array
    """(d, N) by slots"""
    edge: Integers
    """(STRETCHES + 1,) the first slot of each stretch (see `part_pairs`), and the end"""
    place: Integers
    """(STRETCHES + 1,) offset of the window of each stretch in a scratch array"""
    periods: Array
    """(2, d): see `ecume.engine.cells`"""


class NeighborLists(NamedTuple):
    """The neighbor lists of a system. Slot s is particle `cells.order[s]`; its neighbors are in `rows`."""

    cells: Cells
    rows: Rows
    valid: Integers
    """(1,) whether the lists are valid"""


def make_lists(count: int, dimension: int, capacity: int, periods: Array | None = None) -> NeighborLists:
    """Empty lists with room for `capacity` neighbors in total. Distances are to nearest images in a periodic box."""
    cells = make_cells(count, dimension, periods)
    return NeighborLists(
        cells=cells,
        rows=Rows(
            first=np.zeros(count + 1, np.int64),
            later=np.zeros(count, np.int64),
            neighbor=np.zeros(max(capacity, 16), np.uint32),
            sorted_position=np.zeros((dimension, count)),
            edge=np.zeros(STRETCHES + 1, np.int64),
            place=np.zeros(STRETCHES + 1, np.int64),
            periods=cells.periods,
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


@compiled_inside
def _beside(place: int, number: int, cells: int, periodic: bool) -> int:
    """Cell `number` (0 to 2) of the three around a cell along an axis, in ascending order; -1 outside the grid, and for
    the second occurrence of a cell in a short period.
    """
    if not periodic:
        other = place + number - 1
        return other if other < cells else -1
    if cells <= 3:
        return number if number < cells else -1
    if place == 0:
        return number if number < 2 else cells - 1
    if place == cells - 1:
        return place + number - 2 if number > 0 else 0
    return place + number - 1


@compiled_inside
def _runs(cells: Cells) -> int:
    """The number of runs of slots around a cell, including empty runs."""
    last = len(cells.shape) - 1
    runs = 2 if cells.periods[0, last] > 0.0 else 1
    for _ in range(last):
        runs *= 3
    return runs


@compiled_inside
def _run_beside(cells: Cells, cell: int, number: int) -> tuple[int, int]:
    """The slots, from the first up to one after the last, of a run of neighboring cells, in ascending order; none
    outside the grid. Each of the 3^(d - 1) rows around `cell` has one run, or two if the last axis is periodic, since
    the cells across the border are separate.
    """
    shape, last = cells.shape, len(cells.shape) - 1
    along, stride, row, inside = cell % shape[last], shape[last], 0, True
    wraps, second = cells.periods[0, last] > 0.0, False
    if wraps:
        second = number % 2 == 1
        number //= 2
    cell //= shape[last]
    for axis in range(last - 1, -1, -1):
        place = _beside(cell % shape[axis], number % 3, shape[axis], cells.periods[0, axis] > 0.0)
        cell //= shape[axis]
        number //= 3
        inside = inside and place >= 0
        row += place * stride
        stride *= shape[axis]
    low, high = max(along - 1, 0), min(along + 1, shape[last] - 1)
    if wraps and shape[last] <= 3:
        low, high, inside = 0, shape[last] - 1, inside and not second
    elif wraps and along == 0:
        low, high = (shape[last] - 1, shape[last] - 1) if second else (0, 1)
    elif wraps and along == shape[last] - 1:
        low, high = (along - 1, along) if second else (0, 0)
    elif second:
        inside = False
    if not inside:
        return 0, 0
    return cells.start[row + low], cells.start[row + high + 1]


@compiled
def _longest_run(cells: Cells, count: int) -> int:
    """An upper bound of the number of slots in three consecutive cells."""
    longest, every = 0, 1
    for axis in range(len(cells.shape)):
        every *= cells.shape[axis]
    for cell in range(every):
        longest = max(longest, cells.start[min(cell + 3, every)] - cells.start[cell])
    return min(longest, count)


@compiled
def _count(cells: Cells, x: Array, slots: Span, reach: float, first: Integers, later: Integers) -> None:
    """Count the neighbors of some slots in `first[slot + 1]`, and their earlier neighbors in `later`."""
    square, distance = reach * reach, np.empty(slots[2], np.float64)
    for slot in range(slots[0], slots[1]):
        cell, found, earlier = cells.cell[cells.order[slot]], 0, 0
        for number in range(_runs(cells)):
            begin, end = _run_beside(cells, cell, number)
            _squares_of(cells.periods, x, slot, begin, distance[: end - begin])
            if begin <= slot < end:
                distance[slot - begin] = math.inf
            split = max(min(end, slot) - begin, 0)
            before = _nearer(distance[:split], square)
            found += before + _nearer(distance[split : end - begin], square)
            earlier += before
        first[slot + 1], later[slot] = found, earlier


@compiled_inside
def _nearer(distance: Array, square: float) -> int:
    """The number of slots within reach."""
    found = 0
    for n in range(np.uint64(len(distance))):
        found += 1 if distance[n] < square else 0
    return found


@compiled
def _write(cells: Cells, x: Array, slots: Span, reach: float, first: Integers, neighbor: Slots) -> None:
    """Write the neighbors of some slots.

    To avoid branches, the distances of a run are computed first. Then each slot is written, and overwritten by the next
    one if it was too far.
    """
    square, distance = reach * reach, np.empty(slots[2], np.float64)
    found = np.empty(_runs(cells) * slots[2] + 1, np.uint32)
    for slot in range(slots[0], slots[1]):
        cell, at = cells.cell[cells.order[slot]], np.uint64(0)
        for number in range(_runs(cells)):
            begin, end = _run_beside(cells, cell, number)
            start = np.uint64(begin)
            _squares_of(cells.periods, x, slot, begin, distance[: end - begin])
            if begin <= slot < end:
                distance[slot - begin] = math.inf
            for n in range(np.uint64(end - begin)):
                found[at] = start + n
                at += np.uint64(distance[n] < square)
        start = np.uint64(first[slot])
        for n in range(np.uint64(first[slot + 1]) - start):
            neighbor[start + n] = found[n]


@compiled_inside
def _squares_of(periods: Array, x: Array, slot: int, start: int, distance: Array) -> None:
    """The squared distances of a slot from the slots of a run."""
    place = np.uint64(start)
    distance[:] = 0.0
    for axis in range(x.shape[0]):
        own, others, period, inverse = x[axis, slot], x[axis], periods[0, axis], periods[1, axis]
        if period > 0.0:
            for n in range(np.uint64(len(distance))):
                apart = nearest(others[place + n] - own, period, inverse)
                distance[n] += apart * apart
        else:
            for n in range(np.uint64(len(distance))):
                apart = others[place + n] - own
                distance[n] += apart * apart


# Inside a prange, Numba writes to a copy of an array in a tuple; arrays are therefore passed separately. Slots are
# signed in both functions, so that they share one compilation.


@threaded
def _count_in_threads(cells: Cells, x: Array, slots: Span, reach: float, first: Integers, later: Integers) -> None:
    low, high, longest = slots
    for chunk in prange((high - low + CHUNK - 1) // CHUNK):
        begin = low + int(np.int64(chunk)) * CHUNK
        _count(cells, x, (begin, min(begin + CHUNK, high), longest), reach, first, later)


@threaded
def _write_in_threads(cells: Cells, x: Array, slots: Span, reach: float, first: Integers, neighbor: Slots) -> None:
    low, high, longest = slots
    for chunk in prange((high - low + CHUNK - 1) // CHUNK):
        begin = low + int(np.int64(chunk)) * CHUNK
        _write(cells, x, (begin, min(begin + CHUNK, high), longest), reach, first, neighbor)


@compiled
def build(lists: NeighborLists, position: Array, reach: float) -> bool:
    """List all neighbors closer than `reach`. Returns False, with empty lists, if the capacity is exceeded."""
    count_neighbors(lists, position, reach, (0, position.shape[0]))
    if not make_room(lists):
        return False
    write_neighbors(lists, reach, (0, STRETCHES))
    place_windows(lists.rows.place)
    return True


@compiled
def count_neighbors(lists: NeighborLists, position: Array, reach: float, slots: tuple[int, int]) -> None:
    """Sort all particles into slots, and count the neighbors of some slots: all into `first[slot + 1]`, the earlier
    ones into `later[slot]`.
    """
    rows = lists.rows
    sort_into_cells(lists.cells, position, reach)
    sort_positions(lists, position)
    span = slots[0], slots[1], _longest_run(lists.cells, position.shape[0])
    if slots[1] - slots[0] >= THREADS_FROM:
        _count_in_threads(lists.cells, rows.sorted_position, span, reach, rows.first, rows.later)
    else:
        _count(lists.cells, rows.sorted_position, span, reach, rows.first, rows.later)


@compiled
def make_room(lists: NeighborLists) -> bool:
    """Convert counts to offsets of rows, and divide the rows among threads. Returns False, with empty lists, if the
    capacity is too small.
    """
    first, later = lists.rows.first, lists.rows.later
    first[0] = 0
    for slot in range(len(later)):
        later[slot] += first[slot]
        first[slot + 1] += first[slot]
    fits = first[len(later)] <= len(lists.rows.neighbor)
    if not fits:
        for slot in range(len(later)):
            first[slot + 1], later[slot] = 0, 0
    part_pairs(first, later, lists.rows.edge)
    lists.valid[0] = 1 if fits else 0
    return bool(fits)


@compiled
def part_pairs(first: Integers, later: Integers, edge: Integers) -> None:
    """Divide the slots into stretches with equal numbers of pairs, as far as whole rows allow; a pair belongs to its
    lower slot.
    """
    total = 0
    for slot in range(len(later)):
        total += first[slot + 1] - later[slot]
    slot, pairs = 0, 0
    for k in range(STRETCHES):
        edge[k] = slot
        while slot < len(later) and (k == STRETCHES - 1 or STRETCHES * pairs < (k + 1) * total):
            pairs += first[slot + 1] - later[slot]
            slot += 1
    edge[STRETCHES] = slot


@compiled
def write_neighbors(lists: NeighborLists, reach: float, stretches: tuple[int, int]) -> None:
    """Write the rows of a range of stretches, and the widths of their windows: from the first slot of a stretch to the
    last neighbor of its last slot.
    """
    rows = lists.rows
    low, high = rows.edge[stretches[0]], rows.edge[stretches[1]]
    span = low, high, _longest_run(lists.cells, len(rows.later))
    if high - low >= THREADS_FROM:
        _write_in_threads(lists.cells, rows.sorted_position, span, reach, rows.first, rows.neighbor)
    else:
        _write(lists.cells, rows.sorted_position, span, reach, rows.first, rows.neighbor)
    for k in range(stretches[0], stretches[1]):
        last = rows.edge[k] - 1
        for slot in range(rows.edge[k], rows.edge[k + 1]):
            alone = rows.first[slot + 1] == rows.later[slot]
            last = max(last, slot if alone else np.int64(rows.neighbor[rows.first[slot + 1] - 1]))
        rows.place[k + 1] = last + 1 - rows.edge[k]


@compiled
def place_windows(place: Integers) -> None:
    """Convert widths of windows to offsets."""
    place[0] = 0
    for k in range(STRETCHES):
        place[k + 1] += place[k]


@compiled
def farthest_move(position: Array, reference: Array) -> float:
    """The largest displacement since `reference`; NaN if a position is not finite."""
    farthest = 0.0
    for i in range(position.shape[0]):
        square = 0.0
        for axis in range(position.shape[1]):
            moved = position[i, axis] - reference[i, axis]
            square += moved * moved
        # The comparison is written so that a NaN propagates.
        if farthest == farthest and not square <= farthest:
            farthest = square
    return math.sqrt(farthest)
