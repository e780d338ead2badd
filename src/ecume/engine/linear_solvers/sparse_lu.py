"""Direct solutions of block systems: SciPy's SuperLU [demmel1999], in the order of a nested dissection [george1973].

Nested dissection [george1973] is the order in which a direct solver eliminates a block system. Rows that are close to
each other in a pattern are close in position (`block_matrix.near_order`). Therefore each part of the rows is cut at its
middle into two halves. Of the rows on either side of the cut, the smaller set becomes the separator, without which the
halves are not connected. Parts are eliminated before the separators that bound them. Fill-in then grows like N log N in
2D.

The pattern of a block system is symmetric, so that SuperLU runs in its symmetric mode, with the given order and with
pivots on the diagonal unless these are tiny. SuperLU's own orders (minimum degree) take as long for 300 and 3,000
discs, but 3.8 times as long for 10,000 discs and 1.4 times as long for 1,000 spheres (`benchmarks/factorizations.py`).

SuperLU calls the installed BLAS. Its sums are in one order for any number of threads, but the last digits depend on the
processor, as those of LAPACK do.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.engine.cells import Integers
from ecume.engine.linear_solvers.block_matrix import Matrix, Pattern, center
from ecume.errors import BadInput
from ecume.units import Array

if TYPE_CHECKING:
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import SuperLU

LEAF = 12
"""Rows of a part that is not cut any further."""


def elimination_order(pattern: Pattern) -> Integers:
    """The rows of a pattern in the order of their elimination."""
    level, part, depth = _cut(pattern)
    end = (part + 1) << (depth - level)  # parts of the last level that end at this row
    return np.lexsort((-level, end))  # of separators that end at the same row, the deeper ones come first


def _cut(pattern: Pattern) -> tuple[Integers, Integers, int]:
    """The level of the separator or last part of each row, and its index within the level; and the last level."""
    count = len(pattern.order)
    depth = max(int(np.ceil(np.log2(max(count / LEAF, 1.0)))), 0)
    level, part = np.full(count, depth), np.zeros(count, np.int64)
    row, column = np.repeat(np.arange(count), np.diff(pattern.start)), pattern.column
    remaining = np.ones(count, np.bool_)
    for now in range(depth):
        half = _halves(part, remaining)
        across = remaining[row] & remaining[column] & (part[row] == part[column]) & (half[row] != half[column])
        rim = np.zeros(count, np.bool_)
        rim[row[across]] = True
        sizes = np.bincount(2 * part[rim] + half[rim], minlength=2 << now).reshape(-1, 2)
        separator = rim & (half == np.argmin(sizes, axis=1)[part])
        level[separator] = now
        remaining &= ~separator
        part[remaining] = 2 * part[remaining] + half[remaining]
    return level, part, depth


def _halves(part: Integers, remaining: NDArray[np.bool_]) -> Integers:
    """The half (0 or 1) of its part to which each row belongs."""
    rows = np.flatnonzero(remaining)
    rows = rows[np.argsort(part[rows], kind="stable")]
    sizes = np.bincount(part[rows])
    begin = np.cumsum(sizes) - sizes
    half = np.zeros(len(part), np.int64)
    half[rows] = np.arange(len(rows)) - begin[part[rows]] >= (sizes // 2)[part[rows]]
    return half


Indexes = NDArray[np.int32]
"""The integer type of SuperLU."""
ACCURATE = 1e-11
"""The residual, relative to the right side, above which a solution is refined."""
USEFUL = 1e-6
"""The largest residual that is accepted after refinement, for ill-conditioned systems."""
MOST_REFINEMENTS = 2
PIVOT_THRESHOLD = 1e-3
"""The ratio to the largest number of its column above which a diagonal entry is accepted as a pivot."""
OPERATIONS = {2: 75.0, 3: 36.0}
"""Operations of a factorization, over the cube of the block width and N^(3/2) in 2D or N^2 in 3D: fitted to nested
dissections of packings of 300 to 10,000 discs (within 20 %) and of 1,000 spheres.
"""


class Analysis(NamedTuple):
    """The symbolic factorization, shared by all matrices of a pattern."""

    order: Integers
    """the unknowns, counted by the rows of blocks, in the order of their elimination"""
    rank: Integers
    """the place of each unknown in this order"""
    place: Integers
    """the index of each entry of the compressed columns, among the entries of all blocks"""
    row: Indexes
    """of each number, in the order of the elimination"""
    column: Indexes
    start: Indexes
    """the first entry of each column"""


def analyze(pattern: Pattern, width: int) -> Analysis:
    """The elimination order, and the positions of the block entries in the reordered matrix."""
    count, within = len(pattern.order), np.arange(width)
    order = (elimination_order(pattern)[:, None] * width + within).ravel()
    rank = np.empty(count * width, np.int64)
    rank[order] = np.arange(count * width)
    block_row = np.repeat(np.arange(count), np.diff(pattern.start))
    row = np.broadcast_to((block_row[:, None] * width + within)[:, :, None], (len(block_row), width, width)).ravel()
    column = np.broadcast_to((pattern.column[:, None] * width + within)[:, None, :], (len(block_row), width, width))
    row, column = rank[row], rank[column.ravel()]
    place = np.lexsort((row, column))
    start = np.searchsorted(column[place], np.arange(count * width + 1))
    short = (numbers.astype(np.int32) for numbers in (row[place], column[place], start))
    return Analysis(order, rank, place, *short)


def operations(count: int, width: int, dimensions: int) -> float:
    """The estimated number of operations of a factorization by nested dissection [george1973]."""
    return OPERATIONS[dimensions] * width**3 * math.pow(count, 1.5 if dimensions == 2 else 2.0)


def solve(matrix: Matrix, analysis: Analysis, right: Array, solution: Array, null_space_dimension: int) -> bool:
    """Solve for all right sides. Returns False if the matrix is singular, or a solution is not accurate."""
    whole, held = reordered(matrix, analysis, null_space_dimension), analysis.rank[:null_space_dimension]
    factors = factorize(whole)
    if factors is None:
        return False
    for one, found in zip(right, solution, strict=True):
        side = one[matrix.pattern.order].ravel()[analysis.order]
        side[held] = 0.0
        values = refined(whole, factors, side)
        if values is None:
            return False
        found[matrix.pattern.order] = values[analysis.rank].reshape(one.shape)
        center(found, null_space_dimension)
    return True


def reordered(matrix: Matrix, analysis: Analysis, null_space_dimension: int) -> csc_array:
    """The matrix in the order of its elimination; the equations of the first `null_space_dimension` unknowns are
    replaced by x = 0.
    """
    from scipy.sparse import csc_array

    numbers, (row, column) = matrix.blocks.ravel()[analysis.place], (analysis.row, analysis.column)
    if null_space_dimension:
        held = np.isin(row, analysis.rank[:null_space_dimension]) | np.isin(
            column, analysis.rank[:null_space_dimension]
        )
        numbers[held] = (row == column)[held]
    return csc_array((numbers, row, analysis.start), shape=(len(analysis.order),) * 2)


def factorize(whole: csc_array) -> SuperLU | None:
    """The factors L and U of a matrix; None if it is singular."""
    from scipy.sparse.linalg import splu

    try:
        return splu(whole, permc_spec="NATURAL", diag_pivot_thresh=PIVOT_THRESHOLD, options={"SymmetricMode": True})
    except RuntimeError:  # "Factor is exactly singular"
        return None
    except MemoryError:
        reason = f"a direct solution of {whole.shape[0]:,} unknowns needs more memory than there is"
        raise BadInput(f"{reason}; choose the solver auto or iterative") from None


def refined(whole: csc_array, factors: SuperLU, side: Array) -> Array | None:
    """The iteratively refined solution, or None if its residual remains too large."""
    values, residual, largest, worst = np.zeros_like(side), side, float(np.abs(side).max()), math.inf
    for _ in range(1 + MOST_REFINEMENTS):
        values = values + factors.solve(residual)
        residual = side - whole @ values
        worst = float(np.abs(residual).max())
        if worst <= ACCURATE * largest:
            break
    return values if worst <= USEFUL * largest else None
