"""Direct solutions of block systems of a few particles, by dense elimination.

Right sides and solutions are (R, N, b): several for one matrix, which is factorized once. Where nothing holds the
particles in place, the first `loose` unknowns of all of them may shift together without resistance (as many as there
are dimensions; 0 where something holds them): the first particle is then held, and the mean is taken out.
"""

from __future__ import annotations

import numpy as np

from ecume._jit import compiled
from ecume.engine.blocks import Matrix, center
from ecume.units import Array


@compiled
def eliminate(matrix: Matrix, right: Array, solution: Array, loose: int) -> bool:
    """Solve by dense elimination with pivots; whether there is a solution."""
    (several, count, width), order = right.shape, matrix.pattern.order
    size = count * width
    full = np.zeros((size, size + several))
    scatter(matrix, full)
    for s in range(several):
        for row in range(count):
            for k in range(width):
                full[row * width + k, size + s] = right[s, order[row], k]
    hold(full, loose)
    if not triangulate(full):
        return False
    for s in range(several):
        substitute(full, size, size + s)
        for row in range(count):
            for k in range(width):
                solution[s, order[row], k] = full[row * width + k, size + s]
        center(solution[s], loose)
    return True


@compiled
def hold(full: Array, loose: int) -> None:
    """Keep the first unknowns, so many, where they are."""
    size, wide = full.shape
    for k in range(loose):
        for i in range(size):
            full[i, k] = 0.0
        for m in range(wide):
            full[k, m] = 0.0
        full[k, k] = 1.0


@compiled
def scatter(matrix: Matrix, full: Array) -> None:
    """The blocks into a dense matrix."""
    start, column, blocks = matrix.pattern.start, matrix.pattern.column, matrix.blocks
    width = blocks.shape[1]
    for i in range(len(start) - 1):
        for place in range(start[i], start[i + 1]):
            for k in range(width):
                for m in range(width):
                    full[i * width + k, column[place] * width + m] = blocks[place, k, m]


@compiled
def triangulate(full: Array) -> bool:
    """Gauss's elimination of a matrix with its right sides as the last columns; False where it is singular."""
    size, wide = full.shape
    for k in range(size):
        pivot = k
        for i in range(k + 1, size):
            if abs(full[i, k]) > abs(full[pivot, k]):
                pivot = i
        if not abs(full[pivot, k]) > 0.0:
            return False
        if pivot != k:
            for m in range(k, wide):
                full[k, m], full[pivot, m] = full[pivot, m], full[k, m]
        for i in range(k + 1, size):
            if full[i, k] != 0.0:
                factor = full[i, k] / full[k, k]
                for m in range(k, wide):
                    full[i, m] -= factor * full[k, m]
    return True


@compiled
def substitute(full: Array, size: int, column: int) -> None:
    """Put the solution of a triangular system of so many rows into one of its last columns, from its last row up."""
    for k in range(size - 1, -1, -1):
        value = full[k, column]
        for m in range(k + 1, size):
            value -= full[k, m] * full[m, column]
        full[k, column] = value / full[k, k]
