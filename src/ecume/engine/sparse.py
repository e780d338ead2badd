"""Symmetric block systems of pairs: a matrix with a block for each particle and for each pair of neighbors.

`make_pattern` is made once for a set of pairs; `assemble` fills it; `solve` is the one seam behind which the ways to
solve stand: dense elimination for a few particles, conjugate gradients, a sparse factorization. Rows are in the order
of particles, a row's blocks in the order of neighbors, sums in the order of pairs: the bits do not depend on threads.
"""

from __future__ import annotations

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
