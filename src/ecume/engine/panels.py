"""Within one dense front: its own rows are eliminated, a panel at a time, and solutions go through what that left.

Rows are exchanged within a panel only; the rows below it are then reduced, one by one, by all of the panel.
"""

from __future__ import annotations

from ecume._jit import compiled, compiled_inside
from ecume.engine.cells import Integers
from ecume.units import Array

PANEL = 32
"""Pivots that are eliminated before the rows below hear of it: their rows stay in the cache."""


@compiled
def hand_up(front: Array, own: int, to: Array) -> None:
    """What elimination left of the rows of later fronts."""
    rim = len(front) - own
    for i in range(rim):
        for j in range(rim):
            to[i * rim + j] = front[own + i, own + j]


@compiled
def keep(front: Array, own: int, to: Array) -> None:
    """The factors: own rows as wide as the front, and the columns below them."""
    size = len(front)
    for i in range(own):
        for j in range(size):
            to[i * size + j] = front[i, j]
    for i in range(own, size):
        for j in range(own):
            to[own * size + (i - own) * own + j] = front[i, j]


@compiled
def triangulate(front: Array, own: int, swaps: Integers) -> bool:
    """Eliminate a front's own rows, a panel at a time; False where a pivot is missing."""
    for first in range(0, own, PANEL):
        last = min(first + PANEL, own)
        if not triangulate_panel(front, first, last, swaps):
            return False
        for i in range(last, len(front)):
            reduce_row(front, i, first, last)
    return True


@compiled
def triangulate_panel(front: Array, first: int, last: int, swaps: Integers) -> bool:
    """Eliminate within a panel's rows, with its largest pivots."""
    size = len(front)
    for k in range(first, last):
        pivot = k
        for i in range(k + 1, last):
            if abs(front[i, k]) > abs(front[pivot, k]):
                pivot = i
        swaps[k] = pivot
        if not abs(front[pivot, k]) > 0.0:
            return False
        if pivot != k:
            for m in range(size):
                front[k, m], front[pivot, m] = front[pivot, m], front[k, m]
        for i in range(k + 1, last):
            factor = front[i, k] / front[k, k]
            front[i, k] = factor
            for m in range(k + 1, size):
                front[i, m] -= factor * front[k, m]
    return True


@compiled_inside
def reduce_row(front: Array, i: int, first: int, last: int) -> None:
    """Take a panel's rows out of a row below it: four at a time, so that the row is read and written less."""
    size, line = front.shape[1], front[i]
    for k in range(first, last):
        value = line[k]
        for m in range(first, k):
            value -= line[m] * front[m, k]
        line[k] = value / front[k, k]
    k = first
    while k + 4 <= last:
        a, b, c, d = front[k], front[k + 1], front[k + 2], front[k + 3]
        p, q, r, s = line[k], line[k + 1], line[k + 2], line[k + 3]
        for m in range(last, size):
            line[m] -= p * a[m] + q * b[m] + r * c[m] + s * d[m]
        k += 4
    while k < last:
        p, a = line[k], front[k]
        for m in range(last, size):
            line[m] -= p * a[m]
        k += 1


@compiled
def descend(factors: Array, swaps: Integers, own: int, part: Array) -> None:
    """A front's own values through L, and what they take from the others."""
    size = len(part)
    for k in range(own):
        part[k], part[swaps[k]] = part[swaps[k]], part[k]
    for k in range(own):
        for m in range(k):
            part[k] -= factors[k * size + m] * part[m]
    for i in range(own, size):
        line = own * size + (i - own) * own
        for m in range(own):
            part[i] -= factors[line + m] * part[m]


@compiled
def ascend(factors: Array, own: int, part: Array) -> None:
    """A front's own values through U, from those of the others."""
    size = len(part)
    for k in range(own - 1, -1, -1):
        value = part[k]
        for m in range(k + 1, size):
            value -= factors[k * size + m] * part[m]
        part[k] = value / factors[k * size + k]
