"""Block systems of pairs: a matrix with a block for each particle and for each pair of neighbors.

`make_pattern` is made once for a set of pairs; `assemble` or `assemble_quads` fills it. A block is as wide as a
particle has unknowns. `solvers` solves the systems. A row belongs to one thread, its sums are in the order of pairs:
bits do not depend on threads.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume.engine.cells import Integers
from ecume.units import Array

OWN, ACROSS, BACK, OTHER = range(4)
"""The four blocks of a pair (i, j) in `assemble_quads`: (i, i), (i, j), (j, i), (j, j)."""
CHUNK = 1024
"""Rows that one thread processes at once. Their coupling to other chunks is omitted from the preconditioner."""
BITS = 16
"""Of a coordinate, in the order along Morton's curve."""


class Pattern(NamedTuple):
    """The sparsity pattern: the blocks of row r are blocks[start[r]:start[r + 1]], by ascending columns."""

    start: Integers
    """(N + 1,)"""
    column: Integers
    order: Integers
    """(N,) the particle that each row is of"""
    rank: Integers
    """(N,) the row of each particle"""
    diagonal: Integers
    """(N,) place of the block (i, i) of each particle"""
    inside: Integers
    """(N, 3) in each row, the places of the first block of its chunk of rows, of the diagonal block, and of the first
    block beyond the chunk
    """
    upper: Integers
    """(P,) place of the block (i, j) of a pair"""
    lower: Integers
    """(P,) and of (j, i)"""
    first_link: Integers
    """(N + 1,) the pairs of particle i are link[first_link[i]:first_link[i + 1]], in their order"""
    link: Integers
    """(2P,) twice the number of a pair, and 1 more where the particle is its second"""


class Matrix(NamedTuple):
    """A pattern with its blocks."""

    pattern: Pattern
    blocks: Array
    """(B, b, b)"""


def make_pattern(count: int, first: Integers, second: Integers, order: Integers | None = None) -> Pattern:
    """The pattern of pairs (first, second), each of which may stand several times, among so many particles; rows in
    their order unless another one is given.
    """
    every = np.arange(count)
    order = every if order is None else order
    rank = np.empty(count, np.int64)
    rank[order] = every
    here, there = rank[first], rank[second]
    rows, columns = np.concatenate([rank, here, there]), np.concatenate([rank, there, here])
    places, inverse = np.unique(rows * count + columns, return_inverse=True)
    start = np.searchsorted(places, np.arange(count + 1) * count)
    diagonal, upper, lower = np.split(inverse, [count, count + len(first)])
    begin = every // CHUNK * CHUNK
    limits = [every * count + begin, every * count + every, every * count + np.minimum(begin + CHUNK, count)]
    inside = np.ascontiguousarray(np.searchsorted(places, limits).T)
    ends = np.stack([first, second], axis=1).ravel()
    link = np.argsort(ends, kind="stable")
    first_link = np.searchsorted(ends[link], np.arange(count + 1))
    return Pattern(start, places % count, order, rank, diagonal, inside, upper, lower, first_link, link)


def near_order(position: Array) -> Integers:
    """An order in which those that are near one another mostly stand near one another: along Morton's curve."""
    low, span = position.min(axis=0), np.ptp(position, axis=0).max()
    cell = ((position - low) / (span or 1.0) * (2**BITS - 1)).astype(np.int64)
    code = np.zeros(len(position), np.int64)
    for bit in range(BITS):
        for axis, column in enumerate(cell.T):
            code |= (column >> bit & 1) << (bit * cell.shape[1] + axis)
    return np.argsort(code, kind="stable")


def make_matrix(pattern: Pattern, width: int) -> Matrix:
    """Room for the blocks of particles with so many unknowns."""
    return Matrix(pattern, np.zeros((len(pattern.column), width, width)))


@compiled
def assemble(matrix: Matrix, stiffness: Array, diagonal: Array) -> None:
    """Blocks of pairs that resist their relative displacement, (P, b, b) or wider, and what resists each particle's
    own, (N, b).
    """
    pattern, blocks = matrix.pattern, matrix.blocks
    for i in range(len(diagonal)):
        fill_row(pattern, blocks, stiffness, diagonal, i)


@compiled
def assemble_quads(matrix: Matrix, quads: Array, diagonal: Array) -> None:
    """The four blocks of each pair, (P, 4, b, b) in the order OWN, ACROSS, BACK, OTHER, and what resists each
    particle's own, (N, b).
    """
    pattern, blocks = matrix.pattern, matrix.blocks
    for i in range(len(diagonal)):
        fill_row_quads(pattern, blocks, quads, diagonal, i)


@compiled_inside
def fill_row(pattern: Pattern, blocks: Array, stiffness: Array, diagonal: Array, i: int) -> None:
    """The row of one particle."""
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
def fill_row_quads(pattern: Pattern, blocks: Array, quads: Array, diagonal: Array, i: int) -> None:
    """The row of one particle, of pairs that have four blocks."""
    here, upper, lower, link = pattern.diagonal[i], pattern.upper, pattern.lower, pattern.link
    width = blocks.shape[1]
    begin_row(pattern, blocks, diagonal, i)
    for place in range(pattern.first_link[i], pattern.first_link[i + 1]):
        c, side = link[place] // 2, link[place] % 2
        there = upper[c] if side == 0 else lower[c]
        mine, yours = (OWN, ACROSS) if side == 0 else (OTHER, BACK)
        for k in range(width):
            for m in range(width):
                blocks[here, k, m] += quads[c, mine, k, m]
                blocks[there, k, m] += quads[c, yours, k, m]


@compiled_inside
def begin_row(pattern: Pattern, blocks: Array, diagonal: Array, i: int) -> None:
    """Zeros, and what resists the particle's own displacement."""
    row, here, width = pattern.rank[i], pattern.diagonal[i], blocks.shape[1]
    for place in range(pattern.start[row], pattern.start[row + 1]):
        for k in range(width):
            for m in range(width):
                blocks[place, k, m] = 0.0
    for k in range(width):
        blocks[here, k, k] = diagonal[i, k]


@compiled
def center(vectors: Array, loose: int) -> None:
    """Subtract the mean of the first components."""
    count = vectors.shape[0]
    for k in range(loose):
        mean = 0.0
        for i in range(count):
            mean += vectors[i, k]
        mean /= count
        for i in range(count):
            vectors[i, k] -= mean
