"""Warm start: the impulses of the previous step are the initial guess of the solver, contact by contact."""

from __future__ import annotations

from typing import NamedTuple

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.units import Array


class Memory(NamedTuple):
    """Impulses kept from step to step: a part of the state, since warm starts change the last bits."""

    total: Integers
    pair: Integers
    """(capacity, 2)"""
    impulse: Array


class ContactKeys(NamedTuple):
    """Contacts identified by two integers, in ascending order: by the first, then by the second."""

    total: Integers
    """(1,) number of contacts"""
    first: Integers
    second: Integers
    impulse: Array
    """contacts with a positive impulse are kept, all others dropped"""


@compiled
def remember(keys: ContactKeys, memory: Memory) -> None:
    """Keep the positive normal impulses."""
    remember_each(keys, keys.impulse, memory, memory.impulse)


@compiled
def recall(keys: ContactKeys, memory: Memory) -> None:
    """Set the normal impulses to those of the previous step."""
    recall_each(keys, keys.impulse, memory, memory.impulse)


@compiled
def remember_each(keys: ContactKeys, value: Array, memory: Memory, kept: Array) -> None:
    """Keep a value of each contact with a positive impulse, with its keys."""
    found = 0
    for row in range(keys.total[0]):
        if keys.impulse[row] > 0.0 and found < len(kept):
            memory.pair[found, 0], memory.pair[found, 1] = keys.first[row], keys.second[row]
            kept[found] = value[row]
            found += 1
    memory.total[0] = found


@compiled
def recall_each(keys: ContactKeys, value: Array, memory: Memory, kept: Array) -> None:
    """Set each contact's value to that of the previous step, or zero. Both lists are sorted, so one pass suffices."""
    place, last = 0, memory.total[0]
    for row in range(keys.total[0]):
        i, j = keys.first[row], keys.second[row]
        while place < last and (
            memory.pair[place, 0] < i or (memory.pair[place, 0] == i and memory.pair[place, 1] < j)
        ):
            place += 1
        found = place < last and memory.pair[place, 0] == i and memory.pair[place, 1] == j
        value[row] = kept[place] if found else 0.0
