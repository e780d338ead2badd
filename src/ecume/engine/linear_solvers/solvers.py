"""The table of solvers of block systems, their stored data for a pattern, and the estimate of the
cheaper one.

Right sides and solutions are (R, N, b): one matrix has several right sides. If nothing fixes the particles, a common
shift of their first `null_space_dimension` unknowns has no resistance, and the mean is subtracted from the solution.
This number is that of the dimensions, or 0 if the particles are fixed.

`iterative` runs biconjugate gradients to the accuracy that a step of Newton's method requires, `direct` factorizes with
SuperLU, `cholmod` factorizes the symmetric part with SuiteSparse, and `dense` is for a few particles. `does_less`
compares costs as numbers of operations, not times, so that equal states choose the same solver. Ill-conditioned systems
need more iterations, and are therefore solved directly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ecume.engine.linear_solvers import cholmod, sparse_lu
from ecume.engine.linear_solvers.bicgstab import Gradients, Tolerance, biconjugate_gradients, make_gradients
from ecume.engine.linear_solvers.block_matrix import Matrix, Pattern, center, eliminate
from ecume.units import Array

MOST_ITERATIONS = 2000
NEWTON, NEWTON_OF_MANY, MANY = 1e-4, 1e-2, 500
"""The relative accuracy of linear systems in Newton's method, and that for at least so many particles. Newton's method
ends at the same residual. With more particles more iterations are needed for each digit, so that digits in excess of
those that the linearization has cost more than a further iteration of Newton's method.
"""
DENSER = 0.3
"""The time of an operation in a factorization over that in a sweep, which waits for memory."""
FEW = 10
"""The number of iterations below which no factorization is tried, since none would be faster."""
MOST_WORK = 2e12
"""The largest number of operations of a factorization that replaces the iterative solver."""


@dataclass
class Kept:
    """Data that solvers store for all systems of a pattern; they do not change solutions."""

    pattern: Pattern
    width: int
    dimensions: int
    accuracy: float = NEWTON
    """of the iterative solver"""
    iterations: int = 0
    """of the iterative solver since the counter was reset"""
    systems: int = 0
    """number of matrices in these iterations"""
    gradients: Gradients | None = None
    elimination: sparse_lu.Analysis | None = None
    analysis: Any = None
    """by CHOLMOD"""


def accuracy_for(count: int) -> float:
    """The relative accuracy of the iterative solver in Newton's method for this number of particles."""
    return NEWTON_OF_MANY if count >= MANY else NEWTON


Solve = Callable[[Kept, Matrix, Array, Array, int], bool]
"""The signature of a solver: write into `solution`, return False without one."""


def densely(kept: Kept, matrix: Matrix, right: Array, solution: Array, null_space_dimension: int) -> bool:
    """Solve by dense elimination."""
    return bool(eliminate(matrix, right, solution, null_space_dimension))


def iteratively(kept: Kept, matrix: Matrix, right: Array, solution: Array, null_space_dimension: int) -> bool:
    """Solve by stabilized biconjugate gradients."""
    if kept.gradients is None:
        kept.gradients = make_gradients(len(kept.pattern.order), kept.width)
    taken = biconjugate_gradients(matrix, right, solution, kept.gradients, Tolerance(kept.accuracy, MOST_ITERATIONS))
    kept.iterations += taken if taken >= 0 else MOST_ITERATIONS
    kept.systems += 1
    for one in solution:
        center(one, null_space_dimension)
    return taken >= 0


def directly(kept: Kept, matrix: Matrix, right: Array, solution: Array, null_space_dimension: int) -> bool:
    """Solve by SuperLU."""
    if kept.elimination is None:
        kept.elimination = sparse_lu.analyze(kept.pattern, kept.width)
    return sparse_lu.solve(matrix, kept.elimination, right, solution, null_space_dimension)


def by_cholmod(kept: Kept, matrix: Matrix, right: Array, solution: Array, null_space_dimension: int) -> bool:
    """Solve by CHOLMOD's factorization of the symmetric part, and GMRES for the antisymmetric one."""
    if kept.analysis is None:
        kept.analysis = cholmod.analyze(kept.pattern, kept.width)
    return cholmod.solve(matrix, kept.analysis, right, solution, null_space_dimension)


SOLVERS: dict[str, Solve] = {"dense": densely, "iterative": iteratively, "direct": directly, "cholmod": by_cholmod}


def does_less(kept: Kept, iterations: int) -> bool:
    """Whether a factorization needs fewer operations than this number of iterations."""
    return iterations > FEW and DENSER * work(kept) < iterations * operations_of_iteration(kept) and pays(kept)


def pays(kept: Kept) -> bool:
    """Whether a factorization is fast enough to replace the iterative solver where the latter breaks down."""
    return work(kept) <= MOST_WORK


def work(kept: Kept) -> float:
    """The number of operations of a factorization."""
    return sparse_lu.operations(len(kept.pattern.order), kept.width, kept.dimensions)


def operations_of_iteration(kept: Kept) -> float:
    """The number of operations of an iteration: two products with their sweeps, and six sums over vectors."""
    blocks, rows = float(len(kept.pattern.column)), float(len(kept.pattern.order))
    return 4.0 * blocks * kept.width**2 + 12.0 * rows * kept.width
