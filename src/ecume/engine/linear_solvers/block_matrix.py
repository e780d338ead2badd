"""Block systems of pairs: a matrix with a block for each particle and for each pair of neighbors.

`make_pattern` is called once for a set of pairs; `assemble` or `assemble_pair_blocks` fills the blocks. The width of a
block is the number of unknowns per particle. `solvers` solves the systems. A row belongs to one thread, and its sums
are in the order of pairs, so that bits do not depend on the number of threads.

Systems of a few particles are solved here, by dense elimination (`eliminate`). Right sides and solutions are (R, N, b):
one matrix, which is factorized once, has several right sides. If the particles are free, a common shift of the first
`null_space_dimension` unknowns (the number of dimensions; otherwise 0) has no resistance: the first particle is then
fixed, and the mean of the solution is subtracted.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume.engine.cells import Integers
from ecume.units import Array

OWN, ACROSS, BACK, OTHER = range(4)
"""The four blocks of a pair (i, j) in `assemble_pair_blocks`: (i, i), (i, j), (j, i), (j, j)."""
CHUNK = 1024
"""Rows that one thread processes at once. Their coupling to other chunks is omitted from the preconditioner."""
BITS = 16
"""Bits per coordinate in the order along Morton's curve."""


class Pattern(NamedTuple):
    """The sparsity pattern: the blocks of row r are blocks[start[r]:start[r + 1]], by ascending columns."""

    start: Integers
    """(N + 1,)"""
    column: Integers
    order: Integers
    """(N,) the particle of each row"""
    rank: Integers
    """(N,) the row of each particle"""
    diagonal: Integers
    """(N,) index of the block (i, i) of each particle"""
    inside: Integers
    """(N, 3) in each row the indices of the first block of its chunk, of the diagonal block, and of the first block
    beyond the chunk
    """
    upper: Integers
    """(P,) index of the block (i, j) of each pair"""
    lower: Integers
    """(P,) and of (j, i)"""
    first_link: Integers
    """(N + 1,) the pairs of particle i are link[first_link[i]:first_link[i + 1]], in their order"""
    link: Integers
    """(2P,) twice the number of a pair, plus 1 where the particle is its second"""


class Matrix(NamedTuple):
    """A pattern with its blocks."""

    pattern: Pattern
    blocks: Array
    """(B, b, b)"""


def make_pattern(count: int, first: Integers, second: Integers, order: Integers | None = None) -> Pattern:
    """The pattern of pairs (first, second), which may be repeated, among `count` particles; rows in the order of
    particles unless another one is given.
    """
    order = np.arange(count) if order is None else order
    rank = np.empty(count, np.int64)
    rank[order] = np.arange(count)
    first_link, link = links_of(count, first, second)
    start = np.zeros(count + 1, np.int64)
    count_blocks(start, (order, rank), (first, second), (first_link, link))
    column, inside = np.zeros(start[-1], np.int64), np.zeros((count, 3), np.int64)
    upper, lower = np.zeros(len(first), np.int64), np.zeros(len(first), np.int64)
    place_blocks(start, (order, rank), (first, second), (first_link, link), (column, inside, upper, lower))
    return Pattern(start, column, order, rank, inside[rank, 1], inside, upper, lower, first_link, link)


@compiled
def links_of(count: int, first: Integers, second: Integers) -> tuple[Integers, Integers]:
    """The pairs of each particle, as in a `Pattern`, by a counting sort."""
    first_link, link = np.zeros(count + 1, np.int64), np.zeros(2 * len(first), np.int64)
    for c in range(len(first)):
        first_link[first[c] + 1] += 1
        first_link[second[c] + 1] += 1
    for i in range(count):
        first_link[i + 1] += first_link[i]
    free = first_link.copy()
    for c in range(len(first)):
        link[free[first[c]]] = 2 * c
        free[first[c]] += 1
        link[free[second[c]]] = 2 * c + 1
        free[second[c]] += 1
    return first_link, link


@compiled
def count_blocks(
    start: Integers,
    ranks: tuple[Integers, Integers],
    pairs: tuple[Integers, Integers],
    links: tuple[Integers, Integers],
) -> None:
    """Compute where the blocks of each row start. Columns are visited in order, so that repeated pairs are
    consecutive.
    """
    (order, rank), (first, second), (first_link, link) = ranks, pairs, links
    last = np.full(len(order), -1)
    for q in range(len(order)):
        last[q] = q
        start[q + 1] += 1
        for k in range(first_link[order[q]], first_link[order[q] + 1]):
            row = rank[second[link[k] // 2] if link[k] % 2 == 0 else first[link[k] // 2]]
            if last[row] != q:
                last[row] = q
                start[row + 1] += 1
    for row in range(len(order)):
        start[row + 1] += start[row]


@compiled
def place_blocks(
    start: Integers,
    ranks: tuple[Integers, Integers],
    pairs: tuple[Integers, Integers],
    links: tuple[Integers, Integers],
    to: tuple[Integers, Integers, Integers, Integers],
) -> None:
    """Compute columns, limits of chunks, and indices of pairs, column by column."""
    (order, rank), (first, second), (first_link, link) = ranks, pairs, links
    column, inside, upper, lower = to
    free = start[:-1].copy()
    for row in range(len(order)):
        inside[row, 0] = inside[row, 2] = start[row]
    for q in range(len(order)):
        add_block(q, q, free, column, inside)
        inside[q, 1] = free[q] - 1
        for k in range(first_link[order[q]], first_link[order[q] + 1]):
            c, is_first = link[k] // 2, link[k] % 2 == 0
            row = rank[second[c] if is_first else first[c]]
            if free[row] == start[row] or column[free[row] - 1] != q:
                add_block(row, q, free, column, inside)
            if is_first:
                lower[c] = free[row] - 1
            else:
                upper[c] = free[row] - 1


@compiled_inside
def add_block(row: int, q: int, free: Integers, column: Integers, inside: Integers) -> None:
    """Append a block in column q to a row."""
    begin = row // CHUNK * CHUNK
    column[free[row]] = q
    free[row] += 1
    if q < begin:
        inside[row, 0] = free[row]
    if q < begin + CHUNK:
        inside[row, 2] = free[row]


def near_order(position: Array) -> Integers:
    """An order of particles along Morton's curve, in which neighbors are mostly close."""
    low, span = position.min(axis=0), np.ptp(position, axis=0).max()
    cell = ((position - low) / (span or 1.0) * (2**BITS - 1)).astype(np.int64)
    code = np.zeros(len(position), np.int64)
    for bit in range(BITS):
        for axis, column in enumerate(cell.T):
            code |= (column >> bit & 1) << (bit * cell.shape[1] + axis)
    return np.argsort(code, kind="stable")


def make_matrix(pattern: Pattern, width: int) -> Matrix:
    """A matrix of zeros with `width` unknowns per particle."""
    return Matrix(pattern, np.zeros((len(pattern.column), width, width)))


@compiled
def assemble(matrix: Matrix, stiffness: Array, diagonal: Array) -> None:
    """Fill the matrix from stiffnesses of pairs against relative displacement, (P, b, b) or wider, and of each
    particle, (N, b).
    """
    pattern, blocks = matrix.pattern, matrix.blocks
    for i in range(len(diagonal)):
        fill_row(pattern, blocks, stiffness, diagonal, i)


@compiled
def assemble_pair_blocks(matrix: Matrix, pair_blocks: Array, diagonal: Array) -> None:
    """Fill the matrix from the four blocks of each pair, (P, 4, b, b) in the order OWN, ACROSS, BACK, OTHER, and the
    stiffness of each particle, (N, b).
    """
    pattern, blocks = matrix.pattern, matrix.blocks
    for i in range(len(diagonal)):
        fill_row_quads(pattern, blocks, pair_blocks, diagonal, i)


@compiled_inside
def fill_row(pattern: Pattern, blocks: Array, stiffness: Array, diagonal: Array, i: int) -> None:
    """Fill the row of one particle."""
    here, upper, lower, link = pattern.diagonal[i], pattern.upper, pattern.lower, pattern.link
    width = blocks.shape[1]
    begin_row(pattern, blocks, diagonal, i)
    for place in range(pattern.first_link[i], pattern.first_link[i + 1]):
        c = link[place] // 2
        there = upper[c] if link[place] % 2 == 0 else lower[c]
        for k in range(width):
            for m in range(width):
                blocks[here, k, m] += stiffness[c, k, m]
                blocks[there, k, m] -= stiffness[c, k, m]


@compiled_inside
def fill_row_quads(pattern: Pattern, blocks: Array, pair_blocks: Array, diagonal: Array, i: int) -> None:
    """Fill the row of one particle from pairs with four blocks."""
    here, upper, lower, link = pattern.diagonal[i], pattern.upper, pattern.lower, pattern.link
    width = blocks.shape[1]
    begin_row(pattern, blocks, diagonal, i)
    for place in range(pattern.first_link[i], pattern.first_link[i + 1]):
        c, side = link[place] // 2, link[place] % 2
        there = upper[c] if side == 0 else lower[c]
        mine, yours = (OWN, ACROSS) if side == 0 else (OTHER, BACK)
        for k in range(width):
            for m in range(width):
                blocks[here, k, m] += pair_blocks[c, mine, k, m]
                blocks[there, k, m] += pair_blocks[c, yours, k, m]


@compiled_inside
def begin_row(pattern: Pattern, blocks: Array, diagonal: Array, i: int) -> None:
    """Set the row to zero, with the stiffness of the particle on the diagonal."""
    row, here, width = pattern.rank[i], pattern.diagonal[i], blocks.shape[1]
    for place in range(pattern.start[row], pattern.start[row + 1]):
        for k in range(width):
            for m in range(width):
                blocks[place, k, m] = 0.0
    for k in range(width):
        blocks[here, k, k] = diagonal[i, k]


@compiled
def center(vectors: Array, null_space_dimension: int) -> None:
    """Subtract the mean of the first components."""
    count = vectors.shape[0]
    for k in range(null_space_dimension):
        mean = 0.0
        for i in range(count):
            mean += vectors[i, k]
        mean /= count
        for i in range(count):
            vectors[i, k] -= mean


@compiled
def eliminate(matrix: Matrix, right: Array, solution: Array, null_space_dimension: int) -> bool:
    """Solve by dense elimination with pivoting. Returns False if the matrix is singular."""
    (several, count, width), order = right.shape, matrix.pattern.order
    size = count * width
    full = np.zeros((size, size + several))
    scatter(matrix, full)
    for s in range(several):
        for row in range(count):
            for k in range(width):
                full[row * width + k, size + s] = right[s, order[row], k]
    hold(full, null_space_dimension)
    if not triangulate(full):
        return False
    for s in range(several):
        substitute(full, size, size + s)
        for row in range(count):
            for k in range(width):
                solution[s, order[row], k] = full[row * width + k, size + s]
        center(solution[s], null_space_dimension)
    return True


@compiled
def hold(full: Array, null_space_dimension: int) -> None:
    """Replace the equations of the first unknowns by x = 0."""
    size, wide = full.shape
    for k in range(null_space_dimension):
        for i in range(size):
            full[i, k] = 0.0
        for m in range(wide):
            full[k, m] = 0.0
        full[k, k] = 1.0


@compiled
def scatter(matrix: Matrix, full: Array) -> None:
    """Copy the blocks to a dense matrix."""
    start, column, blocks = matrix.pattern.start, matrix.pattern.column, matrix.blocks
    width = blocks.shape[1]
    for i in range(len(start) - 1):
        for place in range(start[i], start[i + 1]):
            for k in range(width):
                for m in range(width):
                    full[i * width + k, column[place] * width + m] = blocks[place, k, m]


@compiled
def triangulate(full: Array) -> bool:
    """Apply Gaussian elimination to a matrix whose last columns are its right sides. Returns False if it is
    singular.
    """
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
    """Invert a matrix by Gauss-Jordan elimination with pivoting, in `room` (b, 2b)."""
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
