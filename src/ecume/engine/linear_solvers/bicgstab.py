"""Iterative solutions of block systems: stabilized biconjugate gradients, BiCGStab [vandervorst1992].

The preconditioner is symmetric Gauss-Seidel (SSOR) within chunks of rows, by Eisenstat's trick.

With D, L and U the diagonal and what is left and right of it within a chunk, and R what ties chunks to one another,
(D + L)^-1 A (D + U)^-1 D y = (D + L)^-1 b is solved for y, and x = (D + U)^-1 D y. A product takes a sweep up for
w = x(y) and one down: it is w + (D + L)^-1 (U w + R w), no more work than A's own [eisenstat1981].

A chunk belongs to one thread, and sums over rows are those of chunks in their order: bits do not depend on threads.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside, inlined, prange, threaded
from ecume.engine.cells import Integers
from ecume.engine.linear_solvers.block_matrix import CHUNK, Matrix, invert_diagonal
from ecume.units import Array

FEW = 2000
"""Particles below which threads are not worth waking."""
RESIDUAL, SHADOW, SEARCH, IMAGE, LEFT, LEFT_IMAGE, SCALED, RAISED, AHEAD = range(9)
"""Vectors of the scratch: r, the first r, p and its product, s and its product, y, w, and what the sweep down adds."""
SEARCHING, HALFWAY, DOWN, TAKE, ALL_UP = range(5)
"""Passes over a chunk: up for p, up for s, down, to the end of an iteration, and up for y."""


class Goal(NamedTuple):
    """The accuracy, and the largest number of iterations."""

    accuracy: float
    most: int


class Gradients(NamedTuple):
    """Scratch of the gradients."""

    vectors: Array
    """(9, N, b), by rows"""
    inverse: Array
    """(N, b, b) of the diagonal's blocks, by rows"""
    sums: Array
    """(chunks, 2)"""


def make_gradients(count: int, width: int) -> Gradients:
    """Room for a solution."""
    chunks = (count + CHUNK - 1) // CHUNK
    return Gradients(np.zeros((9, count, width)), np.zeros((count, width, width)), np.zeros((chunks, 2)))


class Rows(NamedTuple):
    """The matrix in a pass: bare arrays, which threads can be given."""

    start: Integers
    column: Integers
    inside: Integers
    blocks: Array
    inverse: Array


class Pace(NamedTuple):
    """Arguments of a pass: the vector that it makes, one by which it is multiplied, and scalars."""

    image: int
    other: int
    length: float
    damping: float
    turn: float


@compiled_inside
def sweep_up(rows: Rows, y: Array, w: Array, ahead: Array, chunk: tuple[int, int, int]) -> None:
    """Backward substitution in a chunk of rows: w = (D + U)^-1 D y, and U w."""
    column, inside, blocks, inverse = rows.column, rows.inside, rows.blocks, rows.inverse
    begin, end, width = chunk
    for row in range(end - 1, begin - 1, -1):
        for k in range(width):
            ahead[row, k] = 0.0
        for place in range(inside[row, 1] + 1, inside[row, 2]):
            for k in range(width):
                for m in range(width):
                    ahead[row, k] += blocks[place, k, m] * w[column[place], m]
        for k in range(width):
            value = y[row, k]
            for m in range(width):
                value -= inverse[row, k, m] * ahead[row, m]
            w[row, k] = value


@compiled_inside
def sweep_down(rows: Rows, image: Array, w: Array, ahead: Array, chunk: tuple[int, int, int]) -> None:
    """Forward substitution in a chunk of rows: w + (D + L)^-1 (U w + R w); the increment of w replaces U w."""
    start, column, inside, blocks, inverse = rows.start, rows.column, rows.inside, rows.blocks, rows.inverse
    begin, end, width = chunk
    left = np.empty(width)
    for row in range(begin, end):
        for k in range(width):
            left[k] = ahead[row, k]
        for place in range(start[row], inside[row, 0]):
            for k in range(width):
                for m in range(width):
                    left[k] += blocks[place, k, m] * w[column[place], m]
        for place in range(inside[row, 0], inside[row, 1]):
            for k in range(width):
                for m in range(width):
                    left[k] -= blocks[place, k, m] * ahead[column[place], m]
        for place in range(inside[row, 2], start[row + 1]):
            for k in range(width):
                for m in range(width):
                    left[k] += blocks[place, k, m] * w[column[place], m]
        for k in range(width):
            value = 0.0
            for m in range(width):
                value += inverse[row, k, m] * left[m]
            ahead[row, k] = value
            image[row, k] = w[row, k] + value


@compiled_inside
def swept(what: int, rows: Rows, way: tuple[Array, Array, Array], chunk: tuple[int, int, int]) -> None:
    """A sweep up or down."""
    vector, w, ahead = way
    if what == DOWN:
        sweep_down(rows, vector, w, ahead, chunk)
    else:
        sweep_up(rows, vector, w, ahead, chunk)


@compiled_inside
def mixed(what: int, vectors: Array, pace: Pace, begin: int, end: int) -> None:
    """The direction of an iteration before its sweep up: p = r + turn (p - damping p's image), s = r - length p's."""
    residual, search, image, left = vectors[RESIDUAL], vectors[SEARCH], vectors[IMAGE], vectors[LEFT]
    for row in range(begin, end):
        for k in range(residual.shape[1]):
            if what == SEARCHING:
                search[row, k] = residual[row, k] + pace.turn * (search[row, k] - pace.damping * image[row, k])
            else:
                left[row, k] = residual[row, k] - pace.length * image[row, k]


@compiled_inside
def taken(vectors: Array, pace: Pace, begin: int, end: int) -> None:
    """The end of an iteration: y, and the new residual."""
    residual, search, left, image = vectors[RESIDUAL], vectors[SEARCH], vectors[LEFT], vectors[LEFT_IMAGE]
    scaled = vectors[SCALED]
    for row in range(begin, end):
        for k in range(residual.shape[1]):
            scaled[row, k] += pace.length * search[row, k] + pace.damping * left[row, k]
            residual[row, k] = left[row, k] - pace.damping * image[row, k]


@compiled_inside
def over_chunk(what: int, pace: Pace, rows: Rows, work: tuple[Array, Array], chunk: int) -> None:
    """One pass over a chunk, and the two sums in which it ends: of what it made with another vector, and squared."""
    vectors, sums = work
    width = rows.blocks.shape[1]
    begin, end = chunk * CHUNK, min((chunk + 1) * CHUNK, vectors.shape[1])
    if what in (SEARCHING, HALFWAY):
        mixed(what, vectors, pace, begin, end)
    if what == TAKE:
        taken(vectors, pace, begin, end)
    else:
        way = (vectors[pace.image], vectors[RAISED], vectors[AHEAD])
        # Three times the same, twice with a width that the compiler knows.
        if width == 2:
            swept(what, rows, way, (begin, end, 2))
        elif width == 3:
            swept(what, rows, way, (begin, end, 3))
        else:
            swept(what, rows, way, (begin, end, width))
    if what in (DOWN, TAKE):
        made, other = vectors[pace.image], vectors[pace.other]
        sums[chunk, 0] = sums[chunk, 1] = 0.0
        for row in range(begin, end):
            for k in range(width):
                sums[chunk, 0] += made[row, k] * other[row, k]
                sums[chunk, 1] += made[row, k] * made[row, k]


@compiled
def pass_alone(what: int, pace: Pace, rows: Rows, vectors: Array, sums: Array) -> None:
    """One pass over all chunks."""
    for chunk in range(len(sums)):
        over_chunk(what, pace, rows, (vectors, sums), chunk)


@threaded
def pass_together(what: int, pace: Pace, rows: Rows, vectors: Array, sums: Array) -> None:
    """The same, by threads."""
    for chunk in prange(len(sums)):
        over_chunk(what, pace, rows, (vectors, sums), chunk)


@compiled
def total(sums: Array, which: int) -> float:
    """The sum of the chunks' sums."""
    value = 0.0
    for chunk in range(len(sums)):
        value += sums[chunk, which]
    return value


@compiled
def begin_with(right: Array, order: Integers, vectors: Array) -> None:
    """A right side by rows, for a sweep down from zero."""
    for row in range(len(order)):
        for k in range(right.shape[1]):
            vectors[AHEAD, row, k] = right[order[row], k]
            vectors[RAISED, row, k] = vectors[SCALED, row, k] = 0.0


@inlined
def descend_one(
    passed: Callable[..., None], rows: Rows, order: Integers, sides: tuple[Array, Array], scratch: Gradients, goal: Goal
) -> int:
    """Stabilized biconjugate gradients from zero for one right side: how many iterations, -1 where they break down or
    are too many.
    """
    (right, solution), (vectors, _, sums) = sides, scratch
    begin_with(right, order, vectors)
    passed(DOWN, Pace(RESIDUAL, RESIDUAL, 0.0, 0.0, 0.0), rows, vectors, sums)
    begin = slope = total(sums, 1)
    for row in range(len(order)):
        for k in range(right.shape[1]):
            vectors[SHADOW, row, k] = vectors[SEARCH, row, k] = vectors[RESIDUAL, row, k]
    length, damping, turn, left, iteration = 0.0, 0.0, 0.0, begin, 0
    while left > goal.accuracy * goal.accuracy * begin:
        if iteration == goal.most:
            return -1
        iteration += 1
        passed(SEARCHING, Pace(SEARCH, SEARCH, length, damping, turn), rows, vectors, sums)
        passed(DOWN, Pace(IMAGE, SHADOW, length, damping, turn), rows, vectors, sums)
        length = slope / total(sums, 0)
        passed(HALFWAY, Pace(LEFT, LEFT, length, damping, turn), rows, vectors, sums)
        passed(DOWN, Pace(LEFT_IMAGE, LEFT, length, damping, turn), rows, vectors, sums)
        square = total(sums, 1)
        damping = total(sums, 0) / square if square > 0.0 else 0.0
        passed(TAKE, Pace(RESIDUAL, SHADOW, length, damping, turn), rows, vectors, sums)
        left, before, slope = total(sums, 1), slope, total(sums, 0)
        turn = slope / before * length / damping if damping != 0.0 and before != 0.0 else math.nan
        if not (math.isfinite(left) and (math.isfinite(turn) or left == 0.0)):
            return -1
    passed(ALL_UP, Pace(SCALED, SCALED, 0.0, 0.0, 0.0), rows, vectors, sums)
    for row in range(len(order)):
        for k in range(right.shape[1]):
            solution[order[row], k] = vectors[RAISED, row, k]
    return iteration


@inlined
def descend_all(
    passed: Callable[..., None], matrix: Matrix, sides: tuple[Array, Array], scratch: Gradients, goal: Goal
) -> int:
    """All right sides, one after the other: how many iterations they took, -1 where one breaks down."""
    pattern, (right, solution), iterations = matrix.pattern, sides, 0
    if not invert_diagonal(matrix, scratch.inverse):
        return -1
    rows = Rows(pattern.start, pattern.column, pattern.inside, matrix.blocks, scratch.inverse)
    for s in range(right.shape[0]):
        taken_here = descend_one(passed, rows, pattern.order, (right[s], solution[s]), scratch, goal)
        if taken_here < 0:
            return -1
        iterations += taken_here
    return iterations


@compiled
def descend_alone(matrix: Matrix, sides: tuple[Array, Array], scratch: Gradients, goal: Goal) -> int:
    """Solve in one thread."""
    return descend_all(pass_alone, matrix, sides, scratch, goal)


@compiled
def descend_together(matrix: Matrix, sides: tuple[Array, Array], scratch: Gradients, goal: Goal) -> int:
    """Solve in several threads."""
    return descend_all(pass_together, matrix, sides, scratch, goal)


def descend(matrix: Matrix, right: Array, solution: Array, scratch: Gradients, goal: Goal) -> int:
    """Shrink what is left of each right side, measured by (D + L)^-1, to `goal.accuracy` of it; how many iterations all
    took, -1 where they break down or are too many. The matrix need not be symmetric.
    """
    solve = descend_together if right.shape[1] >= FEW else descend_alone
    return int(solve(matrix, (right, solution), scratch, goal))
