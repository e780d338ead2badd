"""Inverses of the blocks on a block matrix's diagonal."""

from __future__ import annotations

import numpy as np

from ecume._jit import compiled
from ecume.engine.blocks import Matrix
from ecume.units import Array


@compiled
def invert_diagonal(matrix: Matrix, inverse: Array) -> bool:
    """The inverse of each row's own block; False where there is none."""
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
