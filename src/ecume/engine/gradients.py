"""Iterative solutions of block systems: stabilized biconjugate gradients, preconditioned by symmetric sweeps of Gauss's
and Seidel's.

Right sides and solutions are (R, N, b): several for one matrix, whose own blocks are inverted once.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.sparse import Matrix, apply, center
from ecume.units import Array

MOST_ITERATIONS = 2000
NEWTON = 1e-4
"""How closely a step of Newton's method needs its linear system solved."""


class Gradients(NamedTuple):
    """Scratch of the conjugate gradients: each (N, b), and the inverse blocks of the diagonal."""

    residual: Array
    shadow: Array
    search: Array
    search_image: Array
    image: Array
    relaxed: Array
    more: Array
    inverse: Array
    """(N, b, b)"""


def make_gradients(count: int, width: int) -> Gradients:
    """Room for a solution by conjugate gradients."""
    vectors = np.zeros((7, count, width))
    inverse = np.zeros((count, width, width))
    return Gradients(vectors[0], vectors[1], vectors[2], vectors[3], vectors[4], vectors[5], vectors[6], inverse)


@compiled
def invert_diagonal(matrix: Matrix, inverse: Array) -> bool:
    """The inverse of each particle's own block; False where there is none."""
    blocks, own = matrix.blocks, matrix.pattern.diagonal
    width = blocks.shape[1]
    room = np.empty((width, 2 * width))
    for i in range(len(own)):
        if width == 2:
            good = invert_two(blocks[own[i]], inverse[i])
        elif width == 3:
            good = invert_three(blocks[own[i]], inverse[i])
        else:
            good = invert(blocks[own[i]], inverse[i], room)
        if not good:
            return False
    return True


@compiled
def invert_two(b: Array, inverse: Array) -> bool:
    """By Cramer's rule."""
    determinant = b[0, 0] * b[1, 1] - b[0, 1] * b[1, 0]
    if not determinant > 0.0:
        return False
    inverse[0, 0], inverse[0, 1] = b[1, 1] / determinant, -b[0, 1] / determinant
    inverse[1, 0], inverse[1, 1] = -b[1, 0] / determinant, b[0, 0] / determinant
    return True


@compiled
def invert_three(b: Array, inverse: Array) -> bool:
    """By Cramer's rule."""
    determinant = 0.0
    for k in range(3):
        p, q = (k + 1) % 3, (k + 2) % 3
        determinant += b[0, k] * (b[1, p] * b[2, q] - b[1, q] * b[2, p])
    if not determinant > 0.0:
        return False
    for k in range(3):
        for m in range(3):
            p, q, r, s = (k + 1) % 3, (k + 2) % 3, (m + 1) % 3, (m + 2) % 3
            inverse[m, k] = (b[p, r] * b[q, s] - b[p, s] * b[q, r]) / determinant
    return True


@compiled
def invert(b: Array, inverse: Array, room: Array) -> bool:
    """By Gauss's and Jordan's elimination with pivots, in `room` (b, 2b)."""
    width = b.shape[0]
    for k in range(width):
        for m in range(width):
            room[k, m] = b[k, m]
            room[k, width + m] = 1.0 if k == m else 0.0
    for k in range(width):
        pivot = k
        for i in range(k + 1, width):
            if abs(room[i, k]) > abs(room[pivot, k]):
                pivot = i
        if not abs(room[pivot, k]) > 0.0:
            return False
        for m in range(2 * width):
            room[k, m], room[pivot, m] = room[pivot, m], room[k, m]
        scale = room[k, k]
        for m in range(2 * width):
            room[k, m] /= scale
        for i in range(width):
            factor = room[i, k]
            if i != k and factor != 0.0:
                for m in range(2 * width):
                    room[i, m] -= factor * room[k, m]
    for k in range(width):
        for m in range(width):
            inverse[k, m] = room[k, width + m]
    return True


@compiled
def sweep(matrix: Matrix, inverse: Array, right: Array, relaxed: Array) -> None:
    """Symmetric Gauss and Seidel from zero, by blocks: down the rows, and up again."""
    start, column, blocks = matrix.pattern.start, matrix.pattern.column, matrix.blocks
    count, width = right.shape
    left = np.empty(width)
    for turn in range(2 * count):
        i = turn if turn < count else 2 * count - 1 - turn
        for k in range(width):
            left[k] = right[i, k]
        for place in range(start[i], start[i + 1]):
            j = column[place]
            if j < i or (turn >= count and j > i):
                for k in range(width):
                    for m in range(width):
                        left[k] -= blocks[place, k, m] * relaxed[j, m]
        for k in range(width):
            value = 0.0
            for m in range(width):
                value += inverse[i, k, m] * left[m]
            relaxed[i, k] = value


@compiled
def product(a: Array, b: Array) -> float:
    """The scalar product."""
    total = 0.0
    for i in range(a.shape[0]):
        for k in range(a.shape[1]):
            total += a[i, k] * b[i, k]
    return total


@compiled
def add(vectors: Array, other: Array, factor: float) -> None:
    """Add a multiple of another vector."""
    for i in range(vectors.shape[0]):
        for k in range(vectors.shape[1]):
            vectors[i, k] += factor * other[i, k]


@compiled
def descend(matrix: Matrix, right: Array, solution: Array, scratch: Gradients, accuracy: float) -> int:
    """The residual of each right side shrinks to `accuracy` of it; how many iterations all took, -1 where they break
    down or are too many. The matrix need not be symmetric [vandervorst1992].
    """
    if not invert_diagonal(matrix, scratch.inverse):
        return -1
    total = 0
    for s in range(right.shape[0]):
        taken = descend_one(matrix, right[s], solution[s], scratch, accuracy)
        if taken < 0:
            return -1
        total += taken
    return total


@compiled
def descend_one(matrix: Matrix, right: Array, solution: Array, scratch: Gradients, accuracy: float) -> int:
    """Stabilized biconjugate gradients from zero for one right side, with the diagonal inverted."""
    residual, search, search_image, image = scratch.residual, scratch.search, scratch.search_image, scratch.image
    solution[:] = 0.0
    residual[:] = right
    scratch.shadow[:] = right
    search[:] = right
    begin = product(right, right)
    if begin == 0.0:
        return 0
    slope = begin
    for iteration in range(1, MOST_ITERATIONS + 1):
        sweep(matrix, scratch.inverse, search, scratch.relaxed)
        apply(matrix, scratch.relaxed, search_image)
        length = slope / product(scratch.shadow, search_image)
        add(residual, search_image, -length)
        add(solution, scratch.relaxed, length)
        sweep(matrix, scratch.inverse, residual, scratch.more)
        apply(matrix, scratch.more, image)
        square = product(image, image)
        damping = product(image, residual) / square if square > 0.0 else 0.0
        add(solution, scratch.more, damping)
        add(residual, image, -damping)
        left = product(residual, residual)
        if left <= accuracy * accuracy * begin:
            return iteration
        before, slope = slope, product(scratch.shadow, residual)
        turn = slope / before * length / damping if damping != 0.0 and before != 0.0 else math.nan
        if not math.isfinite(turn * left):
            return -1
        add(search, search_image, -damping)
        for i in range(residual.shape[0]):
            for k in range(residual.shape[1]):
                search[i, k] = residual[i, k] + turn * search[i, k]
    return -1


@compiled
def follow_gradients(matrix: Matrix, right: Array, solution: Array, scratch: Gradients, loose: int) -> bool:
    """Solve as closely as one of Newton's steps can use; of the first `loose` unknowns the mean is taken out."""
    found = descend(matrix, right, solution, scratch, NEWTON) >= 0
    for s in range(solution.shape[0]):
        center(solution[s], loose)
    return found
