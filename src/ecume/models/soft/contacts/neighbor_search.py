"""Neighbor search among many spheres by cells, with threads.

The pairs are those of `tree_search.neighbors`, in the same order and with the same bits. Each sphere writes its own
row, so that the result does not depend on the number of threads.
"""

from __future__ import annotations

import numpy as np

from ecume._jit import compiled, compiled_inside, prange, shared
from ecume.engine.cells import Cells, Integers, make_cells, sort_into_cells
from ecume.units import Array

ROOM = 32
"""Initial capacity of a row of neighbors."""


def search(
    radius: Array, reach: float, copies: tuple[Array, Integers, Integers], away: Integers
) -> tuple[Integers, Integers, Array]:
    """All pairs whose gap is below the reach: pairs, images, and the vectors between the centers.

    `copies` contains positions, owners and images; those of the spheres in the box come first. `away` is the periodic
    image in which each sphere is.
    """
    place = copies[0]
    count, dimensions = away.shape
    cells = make_cells(len(place), dimensions)
    sort_into_cells(cells, place, 2.0 * float(radius.max()) + reach)
    counts, room = np.zeros(count, np.int64), ROOM
    while True:
        rows = np.zeros((count, room), np.int64)
        fill_rows(rows, counts, cells, copies, (radius, reach))
        if counts.max(initial=0) <= room:
            break
        room = int(counts.max())
    start = np.concatenate([[0], np.cumsum(counts)])
    pair = np.zeros((start[-1], 2), np.int64)
    image, between = np.zeros((start[-1], dimensions), np.int64), np.zeros((start[-1], dimensions))
    write_pairs(rows, start, copies, away, (pair, image, between))
    return pair, image, between


def count_rows(rows: Integers, *_: object) -> int:
    """The number of spheres, for the choice between serial and threaded loops."""
    return len(rows)


@shared(count_rows)
def fill_rows(
    rows: Integers,
    counts: Integers,
    cells: Cells,
    copies: tuple[Array, Integers, Integers],
    near: tuple[Array, float],
) -> None:
    """Write the neighbors of each sphere among all copies, in order. If a row is too short, only the number of
    neighbors is valid.
    """
    place, owner, copy = copies
    radius, reach = near
    shape, cell, begin, order = cells.shape, cells.cell, cells.start, cells.order
    dimensions = place.shape[1]
    deep = shape[2] if dimensions == 3 else 1
    for i in prange(len(rows)):
        x, y, z = cell[i] // (shape[1] * deep), cell[i] // deep % shape[1], cell[i] % deep
        found = 0
        for a in range(max(x - 1, 0), min(x + 2, shape[0])):
            for b in range(max(y - 1, 0), min(y + 2, shape[1])):
                first = (a * shape[1] + b) * deep + max(z - 1, 0)
                last = (a * shape[1] + b) * deep + min(z + 1, deep - 1)
                for k in range(begin[first], begin[last + 1]):
                    p = order[k]
                    j = owner[p]
                    if j < i or (j == i and not is_ahead(copy, p)):
                        continue
                    square = 0.0
                    for axis in range(dimensions):
                        side = place[p, axis] - place[i, axis]
                        square += side * side
                    if np.sqrt(square) - radius[i] - radius[j] < reach:
                        if found < rows.shape[1]:
                            insert(rows[i], found, p, (owner, copy))
                        found += 1
        counts[i] = found


@compiled_inside
def is_ahead(copy: Integers, p: int) -> bool:
    """Whether the first nonzero component of an image is positive; only one of two opposite images is kept."""
    for k in range(copy.shape[1]):
        if copy[p, k] != 0:
            return bool(copy[p, k] > 0)
    return False


@compiled_inside
def insert(row: Integers, found: int, p: int, names: tuple[Integers, Integers]) -> None:
    """Insert a copy into a sorted row with `found` entries."""
    k = found
    while k > 0 and precedes(p, row[k - 1], names):
        row[k] = row[k - 1]
        k -= 1
    row[k] = p


@compiled_inside
def precedes(p: int, q: int, names: tuple[Integers, Integers]) -> bool:
    """Whether one copy precedes another in the order of owners and images. A shift that all copies of an owner have in
    common does not change the order.
    """
    owner, copy = names
    if owner[p] != owner[q]:
        return bool(owner[p] < owner[q])
    for k in range(copy.shape[1]):
        if copy[p, k] != copy[q, k]:
            return bool(copy[p, k] < copy[q, k])
    return False


@shared(count_rows)
def write_pairs(
    rows: Integers,
    start: Integers,
    copies: tuple[Array, Integers, Integers],
    away: Integers,
    to: tuple[Integers, Integers, Array],
) -> None:
    """Write the rows one after the other as pairs, images and vectors."""
    place, owner, copy = copies
    pair, image, between = to
    for i in prange(len(rows)):
        for k in range(start[i + 1] - start[i]):
            p, c = rows[i, k], start[i] + k
            j = owner[p]
            pair[c, 0], pair[c, 1] = i, j
            for axis in range(place.shape[1]):
                image[c, axis] = copy[p, axis] + away[i, axis] - away[j, axis]
                between[c, axis] = place[p, axis] - place[i, axis]


@compiled
def periodic_copies(
    places: Array, sides: Array, shifts: tuple[Integers, Array], far: float
) -> tuple[Array, Integers, Integers]:
    """The spheres in their box and their copies near its borders: positions, owners, and images. `shifts` contains the
    images, and the displacement of each along the first axis by the tilt of the box.
    """
    moves, leans = shifts
    count, dimensions = places.shape
    total = count
    for s in range(len(moves)):
        for i in range(count):
            total += 1 if is_near(places, sides, (moves[s], leans[s]), far, i) else 0
    place = np.zeros((total, dimensions))
    owner, copy = np.zeros(total, np.int64), np.zeros((total, dimensions), np.int64)
    for i in range(count):
        owner[i] = i
        for axis in range(dimensions):
            place[i, axis] = places[i, axis]
    p = count
    for s in range(len(moves)):
        for i in range(count):
            if is_near(places, sides, (moves[s], leans[s]), far, i):
                owner[p] = i
                for axis in range(dimensions):
                    copy[p, axis] = moves[s, axis]
                    place[p, axis] = shifted(places, sides, (moves[s], leans[s]), i, axis)
                p += 1
    return place, owner, copy


@compiled_inside
def shifted(places: Array, sides: Array, shift: tuple[Integers, float], i: int, axis: int) -> float:
    """One coordinate of a shifted copy."""
    along = places[i, axis] + shift[0][axis] * sides[axis]
    return float(along + shift[1] if axis == 0 else along)


@compiled_inside
def is_near(places: Array, sides: Array, shift: tuple[Integers, float], far: float, i: int) -> bool:
    """Whether a copy may touch a sphere in the box."""
    for axis in range(places.shape[1]):
        along = shifted(places, sides, shift, i, axis)
        if sides[axis] != 0.0 and not -far < along < sides[axis] + far:
            return False
    return True
