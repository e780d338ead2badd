"""Products with the square root of a symmetric, positive definite matrix, by Lanczos's method.

Correlated random numbers B z with B B^T = M need no factorization of M: in the Krylov space of z the square root is
that of a small tridiagonal matrix [ando2012]. The matrix is first scaled to a diagonal of ones, M = S C S, and B = S
C^(1/2). For small matrices, B is the Cholesky factor. Sums have a fixed order, so that the bits do not depend on the
libraries of the processor.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ecume._jit import compiled
from ecume._portable import dot, length
from ecume.units import Array

ACCURATE = 1e-6
"""The relative change of the result at which the iteration ends."""
FACTORIZED = 96
"""The largest size of a matrix for which Cholesky's factorization is faster."""
EVERY = 3
"""The number of iterations between convergence tests."""
MOST = 200
"""The largest number of iterations."""
ROTATED = 1e-15
"""Off-diagonal entries, relative to the diagonal, that count as zero."""


@compiled
def root_product(matrix: Array, vector: Array, result: Array) -> None:
    """Write B z for a matrix M = B B^T and a vector z. Small matrices are factorized; larger ones use `krylov_root`."""
    if len(vector) <= FACTORIZED:
        cholesky_product(matrix, vector, result)
    else:
        krylov_root(matrix, vector, result)


@compiled
def cholesky_product(matrix: Array, vector: Array, result: Array) -> None:
    """Write B z with the lower triangle B of Cholesky's factorization. A pivot that is negative by rounding counts as
    zero, as does its column.
    """
    size = len(vector)
    lower = np.zeros((size, size))
    for row in range(size):
        total = 0.0
        for column in range(row + 1):
            left = matrix[row, column]
            for k in range(column):
                left -= lower[row, k] * lower[column, k]
            if column == row:
                lower[row, row] = math.sqrt(max(left, 0.0))
            elif lower[column, column] > 0.0:
                lower[row, column] = left / lower[column, column]
            total += lower[row, column] * vector[column]
        result[row] = total


@compiled
def krylov_root(matrix: Array, vector: Array, result: Array) -> int:
    """Write B z by Lanczos's method; return the number of iterations."""
    size = len(vector)
    scale = np.empty(size)
    for k in range(size):
        scale[k] = math.sqrt(matrix[k, k])
    most = min(size, MOST)
    basis, diagonal, beside = np.zeros((most + 1, size)), np.zeros(most), np.zeros(most + 1)
    length = math.sqrt(_dot(vector, vector))
    share, before, used = np.zeros(most), np.zeros(most), 0
    for k in range(size):
        basis[0, k] = vector[k] / length if length > 0.0 else 0.0
    while used < most and length > 0.0:
        diagonal[used] = _extend(matrix, scale, basis, used)
        beside[used + 1] = math.sqrt(_dot(basis[used + 1], basis[used + 1]))
        used += 1
        ended = used == most or not beside[used] > ROTATED
        if ended or used % EVERY == 0:
            root_column(diagonal[:used], beside[1:used], share)
            if ended or _changed(share, before, used) <= ACCURATE:
                break
            for k in range(used):
                before[k] = share[k]
        for k in range(size):
            basis[used, k] /= beside[used]
    for k in range(size):
        total = 0.0
        for step in range(used):
            total += share[step] * basis[step, k]
        result[k] = length * scale[k] * total
    return used


def root_by_products(product: Callable[[Array], Array], scale: Array, vector: Array, accuracy: float) -> Array:
    """The product B z by Lanczos's method for a matrix that is known by its products with vectors; `scale` is the
    square root of its diagonal.
    """
    far, most = length(vector), min(len(vector), MOST)
    basis, diagonal, beside = [vector / far], np.zeros(most), np.zeros(most + 1)
    share, before = np.zeros(most), np.zeros(most)
    for used in range(1, most + 1):
        following = product(basis[-1] / scale) / scale
        diagonal[used - 1] = dot(basis[-1], following)
        for _ in range(2):
            for each in basis:
                following = following - dot(each, following) * each
        beside[used] = length(following)
        ended = used == most or not beside[used] > ROTATED
        if ended or used % EVERY == 0:
            root_column(diagonal[:used], beside[1:used], share)
            if ended or _changed(share, before, used) <= accuracy:
                break
            before[:used] = share[:used]
        basis.append(following / beside[used])
    result = np.zeros_like(vector)
    for part, each in zip(share, basis, strict=False):
        result += part * each
    return far * scale * result


@compiled
def _extend(matrix: Array, scale: Array, basis: Array, used: int) -> float:
    """Write the next basis vector, not yet normalized. Returns the diagonal entry of the last one."""
    last, following, size = basis[used], basis[used + 1], len(scale)
    # The matrix is symmetric, so that rows replace columns: this loop vectorizes, while a sum along a row does not.
    for row in range(size):
        share = last[row] / scale[row]
        for column in range(size):
            following[column] += share * matrix[row, column]
    for row in range(size):
        following[row] /= scale[row]
    own = _dot(last, following)
    # Orthogonalize against all basis vectors, twice: rounding would make them lose orthogonality.
    for _ in range(2):
        for step in range(used + 1):
            along = _dot(basis[step], following)
            for k in range(size):
                following[k] -= along * basis[step, k]
    return own


@compiled
def _dot(one: Array, other: Array) -> float:
    total = 0.0
    for k in range(len(one)):
        total += one[k] * other[k]
    return total


@compiled
def _changed(share: Array, before: Array, used: int) -> float:
    """The relative change of the result since the last test."""
    change, whole = 0.0, 0.0
    for k in range(used):
        change += (share[k] - before[k]) ** 2
        whole += share[k] ** 2
    return math.sqrt(change / whole)


@compiled
def root_column(diagonal: Array, beside: Array, column: Array) -> None:
    """Write the first column of the square root of a tridiagonal matrix, by Jacobi's rotations. Eigenvalues that are
    negative by rounding count as zero.
    """
    size = len(diagonal)
    rows, vectors = np.zeros((size, size)), np.eye(size)
    for k in range(size):
        rows[k, k] = diagonal[k]
        if k > 0:
            rows[k, k - 1], rows[k - 1, k] = beside[k - 1], beside[k - 1]
    turned = True
    while turned:
        turned = False
        for p in range(size):
            for q in range(p + 1, size):
                if abs(rows[p, q]) > ROTATED * math.sqrt(abs(rows[p, p] * rows[q, q])):
                    _rotate(rows, vectors, p, q)
                    turned = True
    for k in range(size):
        total = 0.0
        for mode in range(size):
            total += vectors[k, mode] * math.sqrt(max(rows[mode, mode], 0.0)) * vectors[0, mode]
        column[k] = total


@compiled
def _rotate(rows: Array, vectors: Array, p: int, q: int) -> None:
    """Eliminate one off-diagonal entry of a symmetric matrix by a rotation, which is also applied to the vectors."""
    half = 0.5 * (rows[q, q] - rows[p, p]) / rows[p, q]
    tangent = (1.0 if half >= 0.0 else -1.0) / (abs(half) + math.sqrt(1.0 + half * half))
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    sine = tangent * cosine
    for k in range(len(rows)):
        one, other = rows[k, p], rows[k, q]
        rows[k, p], rows[k, q] = cosine * one - sine * other, sine * one + cosine * other
    for k in range(len(rows)):
        one, other = rows[p, k], rows[q, k]
        rows[p, k], rows[q, k] = cosine * one - sine * other, sine * one + cosine * other
    rows[p, q], rows[q, p] = 0.0, 0.0
    for k in range(len(rows)):
        one, other = vectors[k, p], vectors[k, q]
        vectors[k, p], vectors[k, q] = cosine * one - sine * other, sine * one + cosine * other
