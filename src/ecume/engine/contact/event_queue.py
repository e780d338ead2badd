"""A priority queue of the events of a step, as in event-driven molecular dynamics: a binary heap in which the time of
each row can change.

`place[row]` is the index of a row in the heap, or -1.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.units import Array


class EventQueue(NamedTuple):
    """A heap of rows by time."""

    size: Integers
    """(1,) number of rows in the heap"""
    heap: Integers
    """(rows,) the rows; the first is the earliest"""
    place: Integers
    """(rows,) the index of each row in the heap; -1 without an event"""
    time: Array
    """(rows,) s"""


@compiled
def make_event_queue(rows: int) -> EventQueue:
    """Return an empty queue for this number of rows."""
    return EventQueue(np.zeros(1, np.int64), np.empty(rows, np.int64), np.full(rows, -1), np.empty(rows))


@compiled
def schedule(queue: EventQueue, row: int, time: float) -> None:
    """Set the time of the event of a row (s); infinite for none."""
    heap, place, times, size = queue.heap, queue.place, queue.time, queue.size
    spot = place[row]
    if time < np.inf:
        if spot < 0:
            spot = size[0]
            size[0] += 1
        times[row] = time
        settle(heap, place, times, size[0], row, spot)
    elif spot >= 0:
        size[0] -= 1
        place[row] = -1
        last = heap[size[0]]
        if last != row:
            settle(heap, place, times, size[0], last, spot)


@compiled
def settle(heap: Integers, place: Integers, times: Array, size: int, row: int, spot: int) -> None:
    """Move a row up or down from a free place of the heap, until no parent is later than its children."""
    while spot > 0 and times[row] < times[heap[(spot - 1) // 2]]:
        heap[spot] = heap[(spot - 1) // 2]
        place[heap[spot]] = spot
        spot = (spot - 1) // 2
    while 2 * spot + 1 < size:
        child = 2 * spot + 1
        if child + 1 < size and times[heap[child + 1]] < times[heap[child]]:
            child += 1
        if not times[heap[child]] < times[row]:
            break
        heap[spot] = heap[child]
        place[heap[spot]] = spot
        spot = child
    heap[spot], place[row] = row, spot
