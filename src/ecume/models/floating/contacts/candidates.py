"""Candidates for contacts: pairs that may touch while the neighbor lists are valid, ordered by both numbers."""

from __future__ import annotations

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume.engine.cells import Integers, nearest
from ecume.engine.contact.contacts import Candidates
from ecume.engine.neighbors import NeighborLists
from ecume.units import Array


@compiled
def find_pairs(
    lists: NeighborLists, slots: tuple[int, int], radius: Array, skin: float, room: int
) -> tuple[Integers, Integers]:
    """Pairs of some slots and later slots that may touch while the lists are valid, as lower and higher numbers. If
    there are more pairs than the capacity, the result has one pair more than the capacity.
    """
    order, rows, widest, found = lists.cells.order, lists.rows, radius.max(), 0
    x, y = rows.sorted_position[0], rows.sorted_position[1]
    first, later, neighbor, periods = rows.first, rows.later, rows.neighbor, rows.periods
    lower, higher = np.empty(room + 1, np.int64), np.empty(room + 1, np.int64)
    for slot in range(slots[0], slots[1]):
        i, own_x, own_y = order[slot], x[slot], y[slot]
        farthest = (radius[i] + widest + skin) ** 2
        for place in range(later[slot], first[slot + 1]):
            other = np.uint64(neighbor[place])
            along = nearest(x[other] - own_x, periods[0, 0], periods[1, 0])
            across = nearest(y[other] - own_y, periods[0, 1], periods[1, 1])
            square = along * along + across * across
            if square <= farthest:
                j = order[other]
                within = radius[i] + radius[j] + skin
                if square < within * within:
                    lower[found], higher[found] = min(i, j), max(i, j)
                    found += 1
                    if found > room:
                        return lower, higher
    return lower[:found], higher[:found]


@compiled
def list_candidates(candidates: Candidates, lists: NeighborLists, radius: Array, skin: float) -> bool:
    """List the pairs that may touch while the lists are valid, ordered by i, then j. Returns False if the capacity is
    exceeded.
    """
    room = len(candidates.partner)
    lower, higher = find_pairs(lists, (0, len(radius)), radius, skin, room)
    if len(lower) > room:
        return False
    sort_pairs(candidates, lower, higher)
    return True


@compiled
def sort_pairs(candidates: Candidates, lower: Integers, higher: Integers) -> None:
    """Store pairs ordered by the lower number, then by the higher."""
    starts, partner, count = candidates.first, candidates.partner, len(candidates.first) - 1
    for i in range(count + 1):
        starts[i] = 0
    for i in lower:
        starts[i + 1] += 1
    for i in range(count):
        starts[i + 1] += starts[i]
    # From the end, so that each start moves down by the number of stored pairs.
    ends = starts[1:].copy()
    for number in range(len(lower)):
        i, j = lower[number], higher[number]
        ends[i] -= 1
        partner[ends[i]] = j
    for i in range(count):
        _ascend(partner, starts[i], starts[i + 1])


@compiled_inside
def _ascend(values: Integers, begin: int, end: int) -> None:
    """Sort a few values by insertion."""
    for place in range(begin + 1, end):
        value, spot = values[place], place
        while spot > begin and values[spot - 1] > value:
            values[spot] = values[spot - 1]
            spot -= 1
        values[spot] = value
