"""Islands of contacts: contacts that are connected by movable bodies, which a solver treats separately."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.units import Array

Choice = NDArray[np.bool_]


class Islands(NamedTuple):
    """Contacts by island, ascending in each; only islands with an impulse, or a change in the last sweep."""

    rows: Integers
    """(n,)"""
    first: Integers
    """(islands + 1,) offsets into `rows`"""


@compiled
def islands_among(first_body: Integers, second_body: Integers, busy: Choice, mobility: Array) -> Islands:
    """The islands of the first len(busy) contacts that contain at least one busy contact; fixed bodies do not connect
    contacts.
    """
    total = len(busy)
    island = _island_of_each(first_body[:total], second_body[:total], mobility)
    active, ends = np.zeros(len(mobility), np.bool_), np.zeros(len(mobility) + 1, np.int64)
    for row in range(total):
        if busy[row]:
            active[island[row]] = True
    for row in range(total):
        ends[island[row] + 1] += 1 if active[island[row]] else 0
    first, islands = np.zeros(len(mobility) + 1, np.int64), 0
    for name in range(len(mobility)):
        if ends[name + 1] > 0:
            islands += 1
            first[islands] = first[islands - 1] + ends[name + 1]
        ends[name + 1] += ends[name]
    rows = np.empty(first[islands], np.int64)
    for row in range(total):
        name = island[row]
        if active[name]:
            rows[ends[name]] = row
            ends[name] += 1
    return Islands(rows, first[: islands + 1])


@compiled
def _island_of_each(first: Integers, second: Integers, mobility: Array) -> Integers:
    """The island of each contact, named by its lowest body: union-find with path halving."""
    parent = np.arange(len(mobility))
    for row in range(len(first)):
        i, j = first[row], second[row]
        if mobility[i] > 0.0 and mobility[j] > 0.0:
            while parent[i] != i:
                parent[i] = parent[parent[i]]
                i = parent[i]
            while parent[j] != j:
                parent[j] = parent[parent[j]]
                j = parent[j]
            parent[max(i, j)] = min(i, j)
    # A parent is never higher than its child.
    for i in range(len(mobility)):
        parent[i] = parent[parent[i]]
    island = np.empty(len(first), np.int64)
    for row in range(len(first)):
        island[row] = parent[first[row]] if mobility[first[row]] > 0.0 else parent[second[row]]
    return island
