"""Direct solutions of block systems: L U in dense fronts, the multifrontal method [duff1983].

`plan` is made once for a pattern: the tree of fronts, and where the factors of each will stand. Each matrix of that
pattern is then factorized along it. A front is the sum of its rows' blocks and of what fronts below it left over; its
own rows are eliminated, and what that leaves of the others is handed up. Rows are exchanged for a larger pivot within
panels of a front only, so that the plan holds whatever the numbers are; the matrix need not be symmetric.

Each number is worked out by one thread in one order: bits do not depend on threads.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume.engine.blocks import Matrix, Pattern, center
from ecume.engine.cells import Integers
from ecume.engine.dissection import Tree, dissect
from ecume.engine.panels import ascend, descend, hand_up, keep, triangulate
from ecume.errors import BadInput
from ecume.units import Array

ACCURATE = 1e-11
"""What may be left of a right side, over it, before it is solved for as well."""
MOST_CORRECTIONS = 2
USEFUL = 1e-6
"""What may be left in the end, where rounding leaves more of an ill-conditioned system; beyond it is no solution."""


class Plan(NamedTuple):
    """The fronts of a pattern for blocks of one width, with the room for their factors."""

    tree: Tree
    begin: Integers
    """(T + 1,) where the factors of each front begin"""
    stack: int
    """the most numbers that fronts hand up and nobody has taken yet"""
    width: int


class Room(NamedTuple):
    """Room for the factors of a plan."""

    factors: Array
    """of each front, by rows: what was eliminated, as wide as the front, and the columns below"""
    swaps: Integers
    """(N b,) the row that each pivot came from, counted in its front"""
    stack: Array
    """what fronts hand up"""


def plan(pattern: Pattern, width: int) -> Plan:
    """Plan the elimination of a pattern, for blocks of this width."""
    tree = dissect(pattern)
    own, rim = np.diff(tree.own) * width, np.diff(tree.rim) * width
    begin = np.concatenate([[0], np.cumsum(own * (own + 2 * rim))])
    return Plan(tree, begin, _stack(tree, rim), width)


def make_room(plan: Plan) -> Room:
    """Room for the factors; it takes memory once it is filled. Raises BadInput where there is not as much."""
    numbers = int(plan.begin[-1]) + plan.stack
    try:
        factors, stack = np.empty(int(plan.begin[-1])), np.empty(plan.stack)
    except MemoryError:
        told = f"a direct solution needs {8e-9 * numbers:.3g} GB, which are not there"
        raise BadInput(f"{told}; choose the solver auto or iterative") from None
    return Room(factors, np.zeros(len(plan.tree.row) * plan.width, np.int64), stack)


def _stack(tree: Tree, rim: Integers) -> int:
    """The most that fronts hand up and nobody has taken yet."""
    waiting = np.zeros(len(rim) + 1, np.int64)
    now = most = 0
    for t, size in enumerate(rim * rim):
        now += int(size)
        most = max(most, now)
        now -= int(waiting[t])
        waiting[tree.parent[t]] += size
    return most


def operations(plan: Plan) -> float:
    """Multiplications and additions of a factorization."""
    own, rim = np.diff(plan.tree.own) * float(plan.width), np.diff(plan.tree.rim) * float(plan.width)
    return float((2.0 / 3.0 * ((own + rim) ** 3 - rim**3)).sum())


@compiled
def factorize(matrix: Matrix, plan: Plan, room: Room, loose: int) -> bool:
    """L and U of a matrix, whose first `loose` unknowns are held; False where a pivot is missing."""
    tree, begin, width = plan.tree, plan.begin, plan.width
    children = np.zeros(len(tree.parent), np.int64)
    for t in range(len(tree.parent)):
        if tree.parent[t] >= 0:
            children[tree.parent[t]] += 1
    waiting, top, open_fronts = np.empty(len(tree.parent), np.int64), 0, 0
    local = np.full(len(tree.row), -1)
    for t in range(len(tree.parent)):
        own, rim = (tree.own[t + 1] - tree.own[t]) * width, (tree.rim[t + 1] - tree.rim[t]) * width
        front = np.zeros((own + rim, own + rim))
        gather(matrix, tree, t, front, local, loose)
        for _ in range(children[t]):
            open_fronts -= 1
            top -= take(tree, waiting[open_fronts], room.stack, top, front, width)
        if not triangulate(front, own, room.swaps[tree.own[t] * width : tree.own[t + 1] * width]):
            return False
        keep(front, own, room.factors[begin[t] : begin[t + 1]])
        if rim > 0:
            hand_up(front, own, room.stack[top : top + rim * rim])
            top += rim * rim
            waiting[open_fronts] = t
            open_fronts += 1
    return True


@compiled
def gather(matrix: Matrix, tree: Tree, t: int, front: Array, local: Integers, loose: int) -> None:
    """The blocks of a front's own rows and columns; the rows between others come in with other fronts."""
    pattern, blocks = matrix.pattern, matrix.blocks
    start, column, width = pattern.start, pattern.column, blocks.shape[1]
    own = tree.own[t + 1] - tree.own[t]
    for place in range(own):
        local[tree.row[tree.own[t] + place]] = place
    for place in range(tree.rim[t], tree.rim[t + 1]):
        local[tree.edge[place]] = own + place - tree.rim[t]
    for place in range(own):
        r = tree.row[tree.own[t] + place]
        for link in range(start[r], start[r + 1]):
            if tree.front[column[link]] >= t:
                put(front, blocks[link], place, local[column[link]])
                if tree.front[column[link]] > t:
                    put(front, blocks[mirror(start, column, column[link], r)], local[column[link]], place)
    if loose > 0 and tree.front[0] == t:
        hold(front, local[0] * width, loose)
    elif loose > 0:
        for place in range(tree.rim[t], tree.rim[t + 1]):
            if tree.edge[place] == 0:
                release(front, local[0] * width, loose)


@compiled_inside
def mirror(start: Integers, column: Integers, r: int, other: int) -> int:
    """Where the block of a row and a column stands."""
    low, high = int(start[r]), int(start[r + 1])
    while low < high:
        middle = (low + high) // 2
        if column[middle] < other:
            low = middle + 1
        else:
            high = middle
    return low


@compiled_inside
def put(front: Array, block: Array, i: int, j: int) -> None:
    """Put a block into a front."""
    width = block.shape[0]
    for k in range(width):
        for m in range(width):
            front[i * width + k, j * width + m] = block[k, m]


@compiled
def hold(front: Array, first: int, loose: int) -> None:
    """Keep these unknowns where they are."""
    release(front, first, loose)
    for k in range(loose):
        front[first + k, first + k] = 1.0


@compiled
def release(front: Array, first: int, loose: int) -> None:
    """Forget what ties these unknowns to others."""
    for k in range(first, first + loose):
        for m in range(len(front)):
            front[k, m] = 0.0
            front[m, k] = 0.0


@compiled
def take(tree: Tree, child: int, stack: Array, top: int, front: Array, width: int) -> int:
    """Add what a child handed up, the last of the stack; how much that is."""
    first, count = tree.rim[child], int(tree.rim[child + 1] - tree.rim[child])
    size = count * width
    begin = top - size * size
    for i in range(count):
        for k in range(width):
            into, line = tree.spot[first + i] * width + k, begin + (i * width + k) * size
            for j in range(count):
                there = tree.spot[first + j] * width
                for m in range(width):
                    front[into, there + m] += stack[line + j * width + m]
    return size * size


@compiled
def substitute(plan: Plan, room: Room, values: Array) -> None:
    """Turn a right side, (N, b) by rows of the matrix, into the solution."""
    tree, begin, width = plan.tree, plan.begin, plan.width
    count = len(tree.parent)
    for t in range(count):
        part = gathered(tree, t, values)
        own = (tree.own[t + 1] - tree.own[t]) * width
        descend(room.factors[begin[t] : begin[t + 1]], room.swaps[tree.own[t] * width :], own, part)
        scattered(tree, t, values, part)
    for t in range(count - 1, -1, -1):
        part = gathered(tree, t, values)
        own = (tree.own[t + 1] - tree.own[t]) * width
        ascend(room.factors[begin[t] : begin[t + 1]], own, part)
        scattered(tree, t, values, part)


@compiled
def gathered(tree: Tree, t: int, values: Array) -> Array:
    """The values of a front's rows."""
    own, rim, width = tree.own[t + 1] - tree.own[t], tree.rim[t + 1] - tree.rim[t], values.shape[1]
    part = np.empty((own + rim) * width)
    for place in range(own + rim):
        r = tree.row[tree.own[t] + place] if place < own else tree.edge[tree.rim[t] + place - own]
        for k in range(width):
            part[place * width + k] = values[r, k]
    return part


@compiled
def scattered(tree: Tree, t: int, values: Array, part: Array) -> None:
    """Put the values of a front's rows back."""
    own, rim, width = tree.own[t + 1] - tree.own[t], tree.rim[t + 1] - tree.rim[t], values.shape[1]
    for place in range(own + rim):
        r = tree.row[tree.own[t] + place] if place < own else tree.edge[tree.rim[t] + place - own]
        for k in range(width):
            values[r, k] = part[place * width + k]


@compiled
def multiply(matrix: Matrix, values: Array, found: Array) -> None:
    """The matrix times (N, b) values, both by its rows."""
    start, column, blocks = matrix.pattern.start, matrix.pattern.column, matrix.blocks
    width = blocks.shape[1]
    for r in range(len(start) - 1):
        for k in range(width):
            total = 0.0
            for place in range(start[r], start[r + 1]):
                for m in range(width):
                    total += blocks[place, k, m] * values[column[place], m]
            found[r, k] = total


def solve(matrix: Matrix, plan: Plan, room: Room, sides: tuple[Array, Array], loose: int) -> bool:
    """Solve for all right sides; where rounding left too much over, that is solved for as well. False where there is
    no solution, or none as accurate as it should be.
    """
    if not factorize(matrix, plan, room, loose):
        return False
    order = matrix.pattern.order
    for one, found in zip(*sides, strict=True):
        wanted = one[order]
        wanted[0, :loose] = 0.0
        values = _refined(matrix, (plan, room), wanted, loose)
        if values is None:
            return False
        found[order] = values
        center(found, loose)
    return True


def _refined(matrix: Matrix, by: tuple[Plan, Room], wanted: Array, loose: int) -> Array | None:
    """A solution by rows, corrected by what it leaves over."""
    (plan, room), values, largest = by, np.zeros_like(wanted), float(np.abs(wanted).max())
    left, worst = wanted, math.inf
    for _ in range(1 + MOST_CORRECTIONS):
        change = left.copy()
        substitute(plan, room, change)
        values += change
        left = left_over(matrix, values, wanted, loose)
        worst = float(np.abs(left).max())
        if worst <= ACCURATE * largest:
            break
    return values if worst <= USEFUL * largest else None


def left_over(matrix: Matrix, values: Array, wanted: Array, loose: int) -> Array:
    """What a solution leaves of a right side, both by rows; of unknowns that are held, nothing."""
    left = np.empty_like(wanted)
    multiply(matrix, values, left)
    np.subtract(wanted, left, out=left)
    left[0, :loose] = 0.0
    return left
