"""In which order a block system is eliminated: nested dissection [george1973], and what elimination will need.

Rows that stand near one another in a pattern are near one another in space (`blocks.near_order`): each part of them is
halved, the smaller of the two rims along the cut becomes a separator, and the halves know nothing of each other once it
is set aside. Separators and the last parts are the nodes of a tree; a node is eliminated after all below it. What its
elimination touches is a dense front: its own rows, and the rows of later nodes that it, or what is below it, is tied
to. All of that follows from the pattern and serves every matrix of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import compiled
from ecume.engine.blocks import Pattern
from ecume.engine.cells import Integers

LEAF = 12
"""Rows that are not cut any further."""


class Tree(NamedTuple):
    """The fronts of an elimination, each after all that it needs."""

    row: Integers
    """(N,) in the order of their elimination; those of front t are row[own[t]:own[t + 1]]"""
    own: Integers
    """(T + 1,)"""
    edge: Integers
    """the later rows that fronts touch; those of front t are edge[rim[t]:rim[t + 1]]"""
    rim: Integers
    """(T + 1,)"""
    spot: Integers
    """for each of `edge`, where it stands in the front of the parent"""
    parent: Integers
    """(T,) the front that takes over what is left of this one; -1 where nothing is"""
    front: Integers
    """(N,) the front that each row is eliminated in"""


def dissect(pattern: Pattern) -> Tree:
    """The tree of a pattern."""
    level, place, depth = _cut(pattern)
    end = (place + 1) << (depth - level)
    node = (end << 6) + (63 - level)  # deeper ones first among those that end together
    keys, front = np.unique(node, return_inverse=True)
    row = np.argsort(front, kind="stable")
    own = np.searchsorted(front[row], np.arange(len(keys) + 1))
    above = _parents(keys, depth)
    edge, rim, spot = tie(pattern, row, own, front, above)
    parent = np.where(np.diff(rim) > 0, above, -1)
    return Tree(row, own, edge, rim, spot, parent, front)


def _cut(pattern: Pattern) -> tuple[Integers, Integers, int]:
    """For each row the level of its separator or last part, and which one of the level it is; and the last level."""
    count = len(pattern.order)
    depth = max(int(np.ceil(np.log2(max(count / LEAF, 1.0)))), 0)
    level, place = np.full(count, depth), np.zeros(count, np.int64)
    here, there = np.repeat(np.arange(count), np.diff(pattern.start)), pattern.column
    inside = np.ones(count, np.bool_)
    for now in range(depth):
        half = _halves(place, inside)
        across = inside[here] & inside[there] & (place[here] == place[there]) & (half[here] != half[there])
        rim = np.zeros(count, np.bool_)
        rim[here[across]] = True
        sizes = np.bincount(2 * place[rim] + half[rim], minlength=2 << now).reshape(-1, 2)
        apart = rim & (half == np.argmin(sizes, axis=1)[place])
        level[apart] = now
        inside &= ~apart
        place[inside] = 2 * place[inside] + half[inside]
    return level, place, depth


def _halves(place: Integers, inside: NDArray[np.bool_]) -> Integers:
    """Which half of its part each row is in."""
    rows = np.flatnonzero(inside)
    rows = rows[np.argsort(place[rows], kind="stable")]
    sizes = np.bincount(place[rows])
    begin = np.cumsum(sizes) - sizes
    half = np.zeros(len(place), np.int64)
    half[rows] = np.arange(len(rows)) - begin[place[rows]] >= (sizes // 2)[place[rows]]
    return half


def _parents(keys: Integers, depth: int) -> Integers:
    """For each node the next one above it that has rows; -1 where there is none."""
    level, end = 63 - (keys & 63), keys >> 6
    parents = np.full(len(keys), -1)
    for up in range(1, depth + 1):
        above = np.maximum(level - up, 0)
        size = 1 << (depth - above)
        wanted = (-(-end // size) * size << 6) + (63 - above)
        found = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        good = (parents < 0) & (level >= up) & (keys[found] == wanted)
        parents[good] = found[good]
    return parents


@compiled
def tie(
    pattern: Pattern, row: Integers, own: Integers, front: Integers, above: Integers
) -> tuple[Integers, Integers, Integers]:
    """The later rows that each front touches, where those of each begin, and where they stand in its parent's front."""
    start, column, count = pattern.start, pattern.column, len(own) - 1
    rim = np.zeros(count + 1, np.int64)
    edge, spot = doubled(row, 0), doubled(row, 0)
    seen, local = np.full(len(row), -1), np.zeros(len(row), np.int64)
    youngest, older = np.full(count, -1), np.full(count, -1)
    for t in range(count):
        used, size = rim[t], own[t + 1] - own[t]
        for place in range(own[t], own[t + 1]):
            seen[row[place]], local[row[place]] = t, place - own[t]
        most = used + len(row)
        if most > len(edge):
            edge, spot = doubled(edge, most), doubled(spot, most)
        child = youngest[t]
        while child >= 0:
            for place in range(rim[child], rim[child + 1]):
                r = edge[place]
                if seen[r] != t:
                    seen[r], local[r] = t, size + used - rim[t]
                    edge[used] = r
                    used += 1
                spot[place] = local[r]
            child = older[child]
        for place in range(own[t], own[t + 1]):
            for link in range(start[row[place]], start[row[place] + 1]):
                r = column[link]
                if seen[r] != t and front[r] > t:
                    seen[r], local[r] = t, size + used - rim[t]
                    edge[used] = r
                    used += 1
        rim[t + 1] = used
        if used > rim[t]:
            older[t], youngest[above[t]] = youngest[above[t]], t
    return edge[: rim[count]].copy(), rim, spot[: rim[count]].copy()


@compiled
def doubled(values: Integers, least: int) -> Integers:
    """The same with more room behind."""
    wider = np.zeros(max(2 * len(values), least), np.int64)
    for place in range(len(values)):
        wider[place] = values[place]
    return wider
