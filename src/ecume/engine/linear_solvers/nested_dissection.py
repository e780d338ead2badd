"""The order in which a direct solver eliminates a block system: nested dissection [george1973].

Rows that are close to each other in a pattern are close to each other in position (`block_matrix.near_order`). So each
part of them is cut into two halves at its middle; of the rows on the two sides of the cut, the fewer become the
separator, without which the halves are not connected. Parts are eliminated before the separators that bound them.
Fill-in then grows like N log N in 2D.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ecume.engine.cells import Integers
from ecume.engine.linear_solvers.block_matrix import Pattern

LEAF = 12
"""Rows of a part that is not cut any further."""


def elimination_order(pattern: Pattern) -> Integers:
    """The rows of a pattern in the order of their elimination."""
    level, part, depth = _cut(pattern)
    end = (part + 1) << (depth - level)  # parts of the last level that end with this one
    return np.lexsort((-level, end))  # of those that end together, deeper ones first


def _cut(pattern: Pattern) -> tuple[Integers, Integers, int]:
    """For each row the level of its separator or last part, and its number within the level; and the last level."""
    count = len(pattern.order)
    depth = max(int(np.ceil(np.log2(max(count / LEAF, 1.0)))), 0)
    level, part = np.full(count, depth), np.zeros(count, np.int64)
    row, column = np.repeat(np.arange(count), np.diff(pattern.start)), pattern.column
    remaining = np.ones(count, np.bool_)
    for now in range(depth):
        half = _halves(part, remaining)
        across = remaining[row] & remaining[column] & (part[row] == part[column]) & (half[row] != half[column])
        rim = np.zeros(count, np.bool_)
        rim[row[across]] = True
        sizes = np.bincount(2 * part[rim] + half[rim], minlength=2 << now).reshape(-1, 2)
        separator = rim & (half == np.argmin(sizes, axis=1)[part])
        level[separator] = now
        remaining &= ~separator
        part[remaining] = 2 * part[remaining] + half[remaining]
    return level, part, depth


def _halves(part: Integers, remaining: NDArray[np.bool_]) -> Integers:
    """The half of its part that each row belongs to: 0 or 1."""
    rows = np.flatnonzero(remaining)
    rows = rows[np.argsort(part[rows], kind="stable")]
    sizes = np.bincount(part[rows])
    begin = np.cumsum(sizes) - sizes
    half = np.zeros(len(part), np.int64)
    half[rows] = np.arange(len(rows)) - begin[part[rows]] >= (sizes // 2)[part[rows]]
    return half
