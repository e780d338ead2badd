"""Arrays of vectors, row by row."""

from __future__ import annotations

from ecume._jit import compiled
from ecume.units import Array


@compiled
def drift(position: Array, velocity: Array, time: float) -> None:
    """Straight on. The passage has a row more than there are floats where a dish stands around them: its own."""
    for i in range(min(position.shape[0], velocity.shape[0])):
        position[i, 0] += time * velocity[i, 0]
        position[i, 1] += time * velocity[i, 1]


@compiled
def copy_rows(target: Array, source: Array) -> None:
    """The first rows of one become those of the other."""
    for i in range(min(target.shape[0], source.shape[0])):
        target[i, 0], target[i, 1] = source[i, 0], source[i, 1]


@compiled
def clear(rows: Array) -> None:
    """All zero."""
    for i in range(rows.shape[0]):
        rows[i, 0], rows[i, 1] = 0.0, 0.0


@compiled
def add_rows(to: Array, others: Array) -> None:
    """Add rows to as many others."""
    for i in range(len(to)):
        to[i, 0] += others[i, 0]
        to[i, 1] += others[i, 1]
