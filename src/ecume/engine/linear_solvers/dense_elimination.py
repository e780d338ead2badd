"""Dense elimination: solutions of block systems of a few particles, and inverses of the blocks on a diagonal.

Right sides and solutions are (R, N, b): several for one matrix, which is factorized once. Where nothing holds the
particles in place, the first `loose` unknowns of all of them may shift together without resistance (as many as there
are dimensions; 0 where something holds them): the first particle is then held, and the mean is taken out.
"""

from __future__ import annotations

import numpy as np

from ecume._jit import compiled
from ecume.engine.linear_solvers.block_matrix import Matrix, center
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
    """Backward substitution of a triangular system, into one of its last columns."""
    for k in range(size - 1, -1, -1):
        value = full[k, column]
        for m in range(k + 1, size):
            value -= full[k, m] * full[m, column]
        full[k, column] = value / full[k, k]


@compiled
def invert_diagonal(matrix: Matrix, inverse: Array) -> bool:
    """Write the inverse of each diagonal block; False if one is singular."""
    blocks, inside = matrix.blocks, matrix.pattern.inside
    width = blocks.shape[1]
    room = np.empty((width, 2 * width))
    for row in range(len(inside)):
        own = blocks[inside[row, 1]]
        if width == 2:
            good = invert_two(own, inverse[row])
        elif width == 3:
            good = invert_three(own, inverse[row])
        else:
            good = invert(own, inverse[row], room)
        if not good:
            return False
    return True


@compiled
def invert_two(b: Array, inverse: Array) -> bool:
    """Invert a 2 x 2 matrix by Cramer's rule."""
    determinant = b[0, 0] * b[1, 1] - b[0, 1] * b[1, 0]
    if not determinant > 0.0:
        return False
    inverse[0, 0], inverse[0, 1] = b[1, 1] / determinant, -b[0, 1] / determinant
    inverse[1, 0], inverse[1, 1] = -b[1, 0] / determinant, b[0, 0] / determinant
    return True


@compiled
def invert_three(b: Array, inverse: Array) -> bool:
    """Invert a 3 x 3 matrix by Cramer's rule."""
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
    """Invert a matrix by Gauss-Jordan elimination with pivots, in `room` (b, 2b)."""
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
