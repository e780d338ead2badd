"""Block systems by CHOLMOD [chen2008], through cvxopt: optional, since both are under the GNU GPL.

CHOLMOD factorizes symmetric positive definite matrices: here the symmetric part, with a symbolic analysis that is
computed once per pattern. GMRES [saad1986] with this factorization as preconditioner corrects for the antisymmetric
part in a few iterations. CHOLMOD uses the installed BLAS: the last digits may depend on the machine and its threads,
the first ten do not.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.linear_solvers.block_matrix import Matrix, Pattern, center
from ecume.engine.linear_solvers.sparse_lu import ACCURATE, USEFUL
from ecume.errors import BadInput, install
from ecume.units import Array

MOST_ITERATIONS = 60


class Analysis(NamedTuple):
    """CHOLMOD's analysis of a pattern, and the indices of its entries."""

    symbolic: Any
    lower: Any
    """the lower triangle in cvxopt's format, by columns"""
    row: Integers
    """row of each entry"""
    column: Integers
    place: Integers
    """index of each entry in the array of all blocks"""
    across: Integers
    """and of the entry on the other side of the diagonal"""


def library() -> Any:
    """Import cvxopt; raise an error with the installation command if it is missing."""
    try:
        import cvxopt
        import cvxopt.cholmod
    except ImportError:
        message = f"the solver cholmod needs cvxopt, which is under the GNU GPL: {install('cholmod')}"
        raise BadInput(f"{message}, or choose auto, direct or iterative") from None
    return cvxopt


def analyze(pattern: Pattern, width: int) -> Analysis:
    """Symbolic factorization of a pattern by CHOLMOD."""
    cvxopt, count = library(), len(pattern.order)
    here, there = np.repeat(np.arange(count), np.diff(pattern.start)), pattern.column
    block = np.flatnonzero(there <= here)
    mirror = np.searchsorted(here * count + there, there[block] * count + here[block])
    k, m = (axis.ravel() for axis in np.indices((width, width)))
    row, column = here[block, None] * width + k, there[block, None] * width + m
    place, across = (block[:, None] * width + k) * width + m, (mirror[:, None] * width + m) * width + k
    below = np.flatnonzero((row >= column).ravel())
    order = below[np.lexsort((row.ravel()[below], column.ravel()[below]))]
    row, column, place, across = (numbers.ravel()[order] for numbers in (row, column, place, across))
    lower = cvxopt.spmatrix(1.0, row.tolist(), column.tolist(), (count * width,) * 2)
    return Analysis(cvxopt.cholmod.symbolic(lower), lower, row, column, place, across)


def solve(matrix: Matrix, analysis: Analysis, right: Array, solution: Array, null_space_dimension: int) -> bool:
    """Solve for all right sides. Returns False if the symmetric part is not positive definite, or GMRES does not
    converge.
    """
    from scipy.sparse import bsr_array

    cvxopt, pattern, size = library(), matrix.pattern, right[0].size
    numbers = matrix.blocks.ravel()
    values = 0.5 * (numbers[analysis.place] + numbers[analysis.across])
    # The fixed unknowns come first; their columns of the lower triangle contain the diagonal only.
    held = analysis.column < null_space_dimension
    values[held] = analysis.row[held] == analysis.column[held]
    analysis.lower.V = cvxopt.matrix(values)
    try:
        cvxopt.cholmod.numeric(analysis.lower, analysis.symbolic)
    except ArithmeticError:  # raised for matrices that are not positive definite
        return False
    whole = bsr_array((matrix.blocks, pattern.column, pattern.start), shape=(size, size))

    def factored(values: Array) -> Array:
        found = cvxopt.matrix(np.ascontiguousarray(values, np.float64))
        cvxopt.cholmod.solve(analysis.symbolic, found)
        return np.array(found).ravel()

    def product(values: Array) -> Array:
        free = values.copy()
        free[:null_space_dimension] = 0.0
        found = np.asarray(whole @ free)
        found[:null_space_dimension] = values[:null_space_dimension]
        return found

    return all(
        _one(one, found, (pattern.order, null_space_dimension), (product, factored))
        for one, found in zip(right, solution, strict=True)
    )


Map = Callable[[Array], Array]


def _one(right: Array, solution: Array, at: tuple[Integers, int], ways: tuple[Map, Map]) -> bool:
    """Solve for one right side by GMRES with CHOLMOD's factorization."""
    from scipy.sparse.linalg import LinearOperator, gmres

    (order, null_space_dimension), (size, (product, factored)) = at, (right.size, ways)
    target = right[order].ravel()
    target[:null_space_dimension] = 0.0
    whole, near = (LinearOperator((size, size), way, dtype=np.float64) for way in (product, factored))
    found, _ = gmres(whole, target, M=near, rtol=0.1 * ACCURATE, restart=MOST_ITERATIONS, maxiter=1)
    solution[order] = found.reshape(right.shape)
    center(solution, null_space_dimension)
    left = np.abs(target - product(found)).max()
    return bool(left <= USEFUL * np.abs(target).max())
