"""Block systems of pairs: a matrix with a block for each particle and for each pair of neighbors.

`make_pattern` is made once for a set of pairs; `assemble` fills it; `solve` is the one seam behind which the ways to
solve stand: dense elimination for a few particles, biconjugate gradients, a sparse factorization. Rows are in the order
of particles, a row's blocks in the order of neighbors, sums in the order of pairs: the bits do not depend on threads.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.units import Array


class Pattern(NamedTuple):
    """Where the blocks stand: the rows of particle i are blocks[start[i]:start[i + 1]]."""

    start: Integers
    """(N + 1,)"""
    column: Integers
    diagonal: Integers
    """(N,) place of the block (i, i)"""
    upper: Integers
    """(P,) place of the block (i, j) of a pair"""
    lower: Integers
    """(P,) and of (j, i)"""


class Matrix(NamedTuple):
    """A pattern with its blocks."""

    pattern: Pattern
    blocks: Array
    """(B, d, d)"""


def make_pattern(count: int, first: Integers, second: Integers) -> Pattern:
    """The pattern of pairs (first, second), each of which may stand several times, among so many particles."""
    every = np.arange(count)
    rows, columns = np.concatenate([every, first, second]), np.concatenate([every, second, first])
    places, inverse = np.unique(rows * count + columns, return_inverse=True)
    start = np.searchsorted(places, np.arange(count + 1) * count)
    diagonal, upper, lower = np.split(inverse, [count, count + len(first)])
    return Pattern(start, places % count, diagonal, upper, lower)


def make_matrix(pattern: Pattern, dimensions: int) -> Matrix:
    """Room for the blocks."""
    return Matrix(pattern, np.zeros((len(pattern.column), dimensions, dimensions)))


@compiled
def assemble(matrix: Matrix, stiffness: Array, diagonal: Array) -> None:
    """Blocks of pairs that resist their relative displacement, and what resists each particle's own."""
    blocks = matrix.blocks
    upper, lower, own = matrix.pattern.upper, matrix.pattern.lower, matrix.pattern.diagonal
    column = matrix.pattern.column
    dimensions = blocks.shape[1]
    blocks[:] = 0.0
    for i in range(len(own)):
        for k in range(dimensions):
            blocks[own[i], k, k] = diagonal[i]
    for c in range(len(upper)):
        i, j = own[column[lower[c]]], own[column[upper[c]]]
        up, low = upper[c], lower[c]
        for k in range(dimensions):
            for m in range(dimensions):
                value = stiffness[c, k, m]
                blocks[i, k, m] += value
                blocks[j, k, m] += value
                blocks[up, k, m] -= value
                blocks[low, k, m] -= value


@compiled
def eliminate(matrix: Matrix, right: Array, solution: Array, anchored: bool) -> bool:
    """Solve by dense elimination with pivots; whether there is a solution.

    A matrix that nothing holds in place is `anchored`: the first particle is held, and the mean is taken out.
    """
    count, dimensions = right.shape
    size = count * dimensions
    full = np.zeros((size, size + 1))
    scatter(matrix, full)
    for i in range(count):
        for k in range(dimensions):
            full[i * dimensions + k, size] = right[i, k]
    if anchored:
        for k in range(dimensions):
            full[k, :] = 0.0
            full[:, k] = 0.0
            full[k, k] = 1.0
    if not triangulate(full):
        return False
    substitute(full, solution)
    if anchored:
        center(solution)
    return True


@compiled
def scatter(matrix: Matrix, full: Array) -> None:
    """The blocks into a dense matrix."""
    start, column, blocks = matrix.pattern.start, matrix.pattern.column, matrix.blocks
    dimensions = blocks.shape[1]
    for i in range(len(start) - 1):
        for place in range(start[i], start[i + 1]):
            for k in range(dimensions):
                for m in range(dimensions):
                    full[i * dimensions + k, column[place] * dimensions + m] = blocks[place, k, m]


@compiled
def triangulate(full: Array) -> bool:
    """Gauss's elimination of a matrix with its right side as the last column; False where it is singular."""
    size = full.shape[0]
    for k in range(size):
        pivot = k
        for i in range(k + 1, size):
            if abs(full[i, k]) > abs(full[pivot, k]):
                pivot = i
        if not abs(full[pivot, k]) > 0.0:
            return False
        if pivot != k:
            for m in range(k, size + 1):
                full[k, m], full[pivot, m] = full[pivot, m], full[k, m]
        for i in range(k + 1, size):
            if full[i, k] != 0.0:
                factor = full[i, k] / full[k, k]
                for m in range(k, size + 1):
                    full[i, m] -= factor * full[k, m]
    return True


@compiled
def substitute(full: Array, solution: Array) -> None:
    """The solution of a triangular system, from its last row up."""
    size, dimensions = full.shape[0], solution.shape[1]
    for k in range(size - 1, -1, -1):
        value = full[k, size]
        for m in range(k + 1, size):
            value -= full[k, m] * solution[m // dimensions, m % dimensions]
        solution[k // dimensions, k % dimensions] = value / full[k, k]


@compiled
def center(vectors: Array) -> None:
    """Take the mean out."""
    count, dimensions = vectors.shape
    for k in range(dimensions):
        mean = 0.0
        for i in range(count):
            mean += vectors[i, k]
        mean /= count
        for i in range(count):
            vectors[i, k] -= mean


MOST_ITERATIONS = 2000
NEWTON = 1e-4
"""How closely a step of Newton's method needs its linear system solved."""


class Gradients(NamedTuple):
    """Scratch of the conjugate gradients: each (N, d), and the inverse blocks of the diagonal."""

    residual: Array
    shadow: Array
    search: Array
    search_image: Array
    image: Array
    relaxed: Array
    more: Array
    inverse: Array
    """(N, d, d)"""


def make_gradients(count: int, dimensions: int) -> Gradients:
    """Room for a solution by conjugate gradients."""
    vectors = np.zeros((7, count, dimensions))
    inverse = np.zeros((count, dimensions, dimensions))
    return Gradients(vectors[0], vectors[1], vectors[2], vectors[3], vectors[4], vectors[5], vectors[6], inverse)


@compiled
def invert_diagonal(matrix: Matrix, inverse: Array) -> bool:
    """The inverse of each particle's own block, by Cramer's rule; False where there is none."""
    blocks, own = matrix.blocks, matrix.pattern.diagonal
    dimensions = blocks.shape[1]
    for i in range(len(own)):
        b = blocks[own[i]]
        determinant = 0.0
        if dimensions == 2:
            determinant = b[0, 0] * b[1, 1] - b[0, 1] * b[1, 0]
        else:
            for k in range(3):
                p, q = (k + 1) % 3, (k + 2) % 3
                determinant += b[0, k] * (b[1, p] * b[2, q] - b[1, q] * b[2, p])
        if not determinant > 0.0:
            return False
        if dimensions == 2:
            inverse[i, 0, 0], inverse[i, 0, 1] = b[1, 1] / determinant, -b[0, 1] / determinant
            inverse[i, 1, 0], inverse[i, 1, 1] = -b[1, 0] / determinant, b[0, 0] / determinant
        else:
            for k in range(3):
                for m in range(3):
                    p, q, r, s = (k + 1) % 3, (k + 2) % 3, (m + 1) % 3, (m + 2) % 3
                    inverse[i, m, k] = (b[p, r] * b[q, s] - b[p, s] * b[q, r]) / determinant
    return True


@compiled
def sweep(matrix: Matrix, inverse: Array, right: Array, relaxed: Array) -> None:
    """Symmetric Gauss and Seidel from zero, by blocks: down the rows, and up again."""
    start, column, blocks = matrix.pattern.start, matrix.pattern.column, matrix.blocks
    count, dimensions = right.shape
    for turn in range(2 * count):
        i = turn if turn < count else 2 * count - 1 - turn
        a, b, c = right[i, 0], right[i, 1], right[i, dimensions - 1]
        for place in range(start[i], start[i + 1]):
            j = column[place]
            if j < i or (turn >= count and j > i):
                for m in range(dimensions):
                    value = relaxed[j, m]
                    a -= blocks[place, 0, m] * value
                    b -= blocks[place, 1, m] * value
                    c -= blocks[place, dimensions - 1, m] * value
        for k in range(dimensions):
            value = inverse[i, k, 0] * a + inverse[i, k, 1] * b
            if dimensions == 3:
                value += inverse[i, k, 2] * c
            relaxed[i, k] = value


@compiled
def apply(matrix: Matrix, vectors: Array, image: Array) -> None:
    """The product of the matrix and a vector."""
    start, column, blocks = matrix.pattern.start, matrix.pattern.column, matrix.blocks
    count, dimensions = vectors.shape
    for i in range(count):
        for k in range(dimensions):
            value = 0.0
            for place in range(start[i], start[i + 1]):
                j = column[place]
                for m in range(dimensions):
                    value += blocks[place, k, m] * vectors[j, m]
            image[i, k] = value


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
    """Stabilized biconjugate gradients from zero, preconditioned by symmetric Gauss-Seidel sweeps: the residual shrinks
    to `accuracy` of the right side. How many iterations that took; -1 where they break down or are too many.

    The matrix need not be symmetric [vandervorst1992].
    """
    residual, search, search_image, image = scratch.residual, scratch.search, scratch.search_image, scratch.image
    solution[:] = 0.0
    residual[:] = right
    scratch.shadow[:] = right
    search[:] = right
    begin = product(right, right)
    if begin == 0.0:
        return 0
    if not invert_diagonal(matrix, scratch.inverse):
        return -1
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
def follow_gradients(matrix: Matrix, right: Array, solution: Array, scratch: Gradients, anchored: bool) -> bool:
    """Solve by conjugate gradients, as closely as one of Newton's steps can use."""
    found = descend(matrix, right, solution, scratch, NEWTON) >= 0
    if anchored:
        center(solution)
    return found


def factorize(matrix: Matrix, right: Array, solution: Array, anchored: bool) -> bool:
    """Solve by SuperLU, whatever the matrix; whether there is a solution."""
    from scipy.sparse import bsr_array
    from scipy.sparse.linalg import splu

    count, dimensions = right.shape
    pattern = matrix.pattern
    whole = bsr_array((matrix.blocks, pattern.column, pattern.start), shape=(count * dimensions,) * 2).tocsc()
    begin = dimensions if anchored else 0
    solution[:] = 0.0
    try:
        factors = splu(whole[begin:, begin:], permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    except RuntimeError:  # SuperLU says so of a singular matrix
        return False
    solution.reshape(-1)[begin:] = factors.solve(right.reshape(-1)[begin:])
    if anchored:
        center(solution)
    return bool(np.isfinite(solution).all())
