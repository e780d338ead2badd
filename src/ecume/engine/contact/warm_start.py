"""What contacts remember from step to step, by who touches whom."""

from __future__ import annotations

from typing import NamedTuple

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.units import Array


class Memory(NamedTuple):
    """Impulses that last from step to step: a part of the state, since warm starts change the last bits."""

    total: Integers
    pair: Integers
    """(capacity, 2)"""
    impulse: Array


class Keyed(NamedTuple):
    """Contacts by two whole numbers, in ascending order: by the first, then by the second."""

    total: Integers
    """(1,) how many there are"""
    first: Integers
    second: Integers
    impulse: Array
    """what pushes is remembered, and all else forgotten"""


@compiled
def remember_each(keyed: Keyed, value: Array, memory: Memory, kept: Array) -> None:
    """Keep a value of each contact that pushes, and who it belongs to."""
    found = 0
    for row in range(keyed.total[0]):
        if keyed.impulse[row] > 0.0 and found < len(kept):
            memory.pair[found, 0], memory.pair[found, 1] = keyed.first[row], keyed.second[row]
            kept[found] = value[row]
            found += 1
    memory.total[0] = found


@compiled
def recall_each(keyed: Keyed, value: Array, memory: Memory, kept: Array) -> None:
    """Give each contact the value of the step before, or none. Both lists are ordered alike: one walk finds all."""
    place, last = 0, memory.total[0]
    for row in range(keyed.total[0]):
        i, j = keyed.first[row], keyed.second[row]
        while place < last and (
            memory.pair[place, 0] < i or (memory.pair[place, 0] == i and memory.pair[place, 1] < j)
        ):
            place += 1
        found = place < last and memory.pair[place, 0] == i and memory.pair[place, 1] == j
        value[row] = kept[place] if found else 0.0
