"""Block systems of pairs: a matrix with a block for each particle and for each pair of neighbors.

`make_pattern` is made once for a set of pairs; `assemble` or `assemble_quads` fills it. A block is as wide as a
particle has unknowns. How systems are solved stands in `elimination` and `gradients`, whose right sides are (R, N, b):
several for one matrix. Rows are in the order of particles, a row's blocks in the order of neighbors, sums in the order
of pairs: the bits do not depend on threads.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.units import Array

OWN, ACROSS, BACK, OTHER = range(4)
"""The four blocks of a pair (i, j) in `assemble_quads`: (i, i), (i, j), (j, i), (j, j)."""


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
    first_link: Integers
    """(N + 1,) the pairs of particle i are link[first_link[i]:first_link[i + 1]], in their order"""
    link: Integers
    """(2P,) twice the number of a pair, and 1 more where the particle is its second"""


class Matrix(NamedTuple):
    """A pattern with its blocks."""

    pattern: Pattern
    blocks: Array
    """(B, b, b)"""


def make_pattern(count: int, first: Integers, second: Integers) -> Pattern:
    """The pattern of pairs (first, second), each of which may stand several times, among so many particles."""
    every = np.arange(count)
    rows, columns = np.concatenate([every, first, second]), np.concatenate([every, second, first])
    places, inverse = np.unique(rows * count + columns, return_inverse=True)
    start = np.searchsorted(places, np.arange(count + 1) * count)
    diagonal, upper, lower = np.split(inverse, [count, count + len(first)])
    ends = np.stack([first, second], axis=1).ravel()
    link = np.argsort(ends, kind="stable")
    first_link = np.searchsorted(ends[link], np.arange(count + 1))
    return Pattern(start, places % count, diagonal, upper, lower, first_link, link)


def make_matrix(pattern: Pattern, width: int) -> Matrix:
    """Room for the blocks of particles with so many unknowns."""
    return Matrix(pattern, np.zeros((len(pattern.column), width, width)))


@compiled
def assemble(matrix: Matrix, stiffness: Array, diagonal: Array) -> None:
    """Blocks of pairs that resist their relative displacement, (P, b, b) or wider, and what resists each particle's
    own, (N, b).
    """
    first_link, link = matrix.pattern.first_link, matrix.pattern.link
    upper, lower, own, blocks = matrix.pattern.upper, matrix.pattern.lower, matrix.pattern.diagonal, matrix.blocks
    begin_rows(matrix, diagonal)
    width = blocks.shape[1]
    for i in range(len(own)):
        here = own[i]
        for place in range(first_link[i], first_link[i + 1]):
            c = link[place] // 2
            there = upper[c] if link[place] % 2 == 0 else lower[c]
            for k in range(width):
                for m in range(width):
                    blocks[here, k, m] += stiffness[c, k, m]
                    blocks[there, k, m] -= stiffness[c, k, m]


@compiled
def assemble_quads(matrix: Matrix, quads: Array, diagonal: Array) -> None:
    """The four blocks of each pair, (P, 4, b, b) in the order OWN, ACROSS, BACK, OTHER, and what resists each
    particle's own, (N, b).
    """
    first_link, link = matrix.pattern.first_link, matrix.pattern.link
    upper, lower, own, blocks = matrix.pattern.upper, matrix.pattern.lower, matrix.pattern.diagonal, matrix.blocks
    begin_rows(matrix, diagonal)
    width = blocks.shape[1]
    for i in range(len(own)):
        here = own[i]
        for place in range(first_link[i], first_link[i + 1]):
            c, side = link[place] // 2, link[place] % 2
            there = upper[c] if side == 0 else lower[c]
            mine, yours = (OWN, ACROSS) if side == 0 else (OTHER, BACK)
            for k in range(width):
                for m in range(width):
                    blocks[here, k, m] += quads[c, mine, k, m]
                    blocks[there, k, m] += quads[c, yours, k, m]


@compiled
def begin_rows(matrix: Matrix, diagonal: Array) -> None:
    """Zeros, and what resists each particle's own displacement."""
    own, blocks = matrix.pattern.diagonal, matrix.blocks
    blocks[:] = 0.0
    for i in range(len(own)):
        for k in range(blocks.shape[1]):
            blocks[own[i], k, k] = diagonal[i, k]


@compiled
def apply(matrix: Matrix, vectors: Array, image: Array) -> None:
    """The product of the matrix and a vector, (N, b)."""
    start, column, blocks = matrix.pattern.start, matrix.pattern.column, matrix.blocks
    count, width = vectors.shape
    for i in range(count):
        for k in range(width):
            value = 0.0
            for place in range(start[i], start[i + 1]):
                j = column[place]
                for m in range(width):
                    value += blocks[place, k, m] * vectors[j, m]
            image[i, k] = value


@compiled
def center(vectors: Array, loose: int) -> None:
    """Take the mean out of the first components, so many of them."""
    count = vectors.shape[0]
    for k in range(loose):
        mean = 0.0
        for i in range(count):
            mean += vectors[i, k]
        mean /= count
        for i in range(count):
            vectors[i, k] -= mean
