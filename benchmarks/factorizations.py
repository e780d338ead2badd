r"""The solver `direct` and other factorizations that come as wheels, on matrices of packings of soft spheres.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1 \
        python benchmarks/factorizations.py [--layers 300 3000 10000] [--spaces 1000] [--rounds 11]

Each solver analyzes the pattern once; then each round gives all of them new numbers of that pattern in turn, as time
stepping does, and measures the factorization with the solution of one right side. Medians of processor time, one
thread. Residuals are relative to the right side; matrices are not quite symmetric, as those of films are. What is not
installed is skipped:

- `direct`: SciPy's SuperLU in the order of our nested dissection;
- `superlu`: the same in the best of its own orders, found once and handed over with permc_spec="NATURAL";
- `pardiso`: Intel's, from the wheels pypardiso and mkl (its license is not an open one; x86-64 only);
- `klu`: SuiteSparse's, from klujax (GNU LGPL), refactorized along the first pivots;
- `cholmod`: our solver `cholmod`, from cvxopt (GNU GPL): the symmetric part, with GMRES for the rest.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.sparse import bsr_array, csc_array, csr_matrix
from scipy.sparse.linalg import splu
from soft_solvers import fill, system
from timed_runs import machine

from ecume._quick import parser_of, sized
from ecume.engine.linear_solvers import solvers
from ecume.engine.linear_solvers.block_matrix import Matrix
from ecume.units import Array

LENGTH = 1.0
"""s, of the step: long, so that films hardly resist and the matrix is ill-conditioned."""
Solve = Callable[[Array], Array]
"""From new numbers of the pattern, in the order of our blocks, to the solution by rows."""


class Pattern:
    """Where each number of our blocks stands in compressed columns or rows, in a given order of the unknowns."""

    def __init__(self, matrix: Matrix) -> None:
        pattern, self.width = matrix.pattern, matrix.blocks.shape[1]
        self.size = self.width * len(pattern.order)
        here, there = np.repeat(np.arange(len(pattern.order)), np.diff(pattern.start)), pattern.column
        k, m = (axis.ravel() for axis in np.indices((self.width, self.width)))
        self.row = (here[:, None] * self.width + k).ravel()
        self.column = (there[:, None] * self.width + m).ravel()

    def columns(self, order: Array) -> tuple[csc_array, Array]:
        """A matrix in this order, and the place of each of its numbers among our blocks."""
        rank = np.empty(self.size, np.int64)
        rank[order] = np.arange(self.size)
        place = np.lexsort((rank[self.row], rank[self.column]))
        start = np.searchsorted(rank[self.column][place], np.arange(self.size + 1))
        whole = csc_array((np.ones(len(place)), rank[self.row][place], start), shape=(self.size,) * 2)
        whole.indices, whole.indptr = whole.indices.astype(np.int32), whole.indptr.astype(np.int32)
        return whole, place


def superlu(matrix: Matrix, right: Array, order: Array) -> Solve:
    """SciPy's SuperLU in a given order."""
    whole, place = Pattern(matrix).columns(order)

    def solve(numbers: Array) -> Array:
        whole.data = numbers[place]
        factors = splu(whole, permc_spec="NATURAL", diag_pivot_thresh=0.001, options={"SymmetricMode": True})
        found = np.empty_like(right)
        found[order] = factors.solve(right[order])
        return found

    return solve


def its_order(matrix: Matrix) -> Array:
    """The one of SuperLU's orders that leaves the fewest numbers in the factors."""
    pattern = Pattern(matrix)
    whole, place = pattern.columns(np.arange(pattern.size))
    whole.data = matrix.blocks.ravel()[place]
    several = (
        splu(whole, permc_spec=name, diag_pivot_thresh=0.001, options={"SymmetricMode": True})
        for name in ("MMD_AT_PLUS_A", "COLAMD")
    )
    best = min(several, key=lambda factors: factors.nnz)
    return np.argsort(best.perm_c)


def pardiso(matrix: Matrix, right: Array) -> Solve:
    """PARDISO of Intel's MKL, for a structurally symmetric matrix; the analysis is kept."""
    from pypardiso import PyPardisoSolver

    pattern = Pattern(matrix)
    place = np.lexsort((pattern.column, pattern.row))
    start = np.searchsorted(pattern.row[place], np.arange(pattern.size + 1)).astype(np.int32)
    columns = pattern.column[place].astype(np.int32)
    solver = PyPardisoSolver(mtype=1)

    def run(phase: int, numbers: Array) -> Array:
        whole = csr_matrix((numbers[place], columns, start), shape=(pattern.size,) * 2)
        solver.set_phase(phase)
        return np.asarray(solver._call_pardiso(whole, right[:, None])).ravel()

    run(11, matrix.blocks.ravel())
    return lambda numbers: run(23, numbers)


def klu(matrix: Matrix, right: Array) -> Solve:
    """KLU, refactorized along its first pivots."""
    import jax
    import klujax as library

    jax.config.update("jax_enable_x64", True)
    pattern = Pattern(matrix)
    at = jax.numpy.asarray(pattern.row, "int32"), jax.numpy.asarray(pattern.column, "int32")
    symbolic = library.analyze(*at, pattern.size)
    numeric = library.factor(*at, jax.numpy.asarray(matrix.blocks.ravel()), symbolic)
    side = jax.numpy.asarray(right)

    def solve(numbers: Array) -> Array:
        again = library.refactor(*at, jax.numpy.asarray(numbers), numeric, symbolic)
        return np.asarray(library.solve_with_numeric(again, side, symbolic)).ravel()

    return solve


def ours(name: str, matrix: Matrix, right: Array) -> Solve:
    """One of the package's solvers, with the plan kept; its right sides and solutions are by particles."""
    kept = solvers.Kept(matrix.pattern, matrix.blocks.shape[1], 2)
    order, width = matrix.pattern.order, matrix.blocks.shape[1]
    side, found = np.empty((1, len(order), width)), np.empty((1, len(order), width))
    side[0, order] = right.reshape(-1, width)

    def solve(numbers: Array) -> Array:
        changed = Matrix(matrix.pattern, numbers.reshape(matrix.blocks.shape))
        if not solvers.SOLVERS[name](kept, changed, side, found, 0):
            raise SystemExit(f"{name} found no solution")
        return np.asarray(found[0, order]).ravel()

    return solve


def installed(matrix: Matrix, right: Array) -> dict[str, Solve]:
    """Those that are installed."""
    found = {
        "direct": ours("direct", matrix, right),
        "superlu": superlu(matrix, right, its_order(matrix)),
    }
    if find_spec("pypardiso"):
        found["pardiso"] = pardiso(matrix, right)
    if find_spec("klujax"):
        found["klu"] = klu(matrix, right)
    if find_spec("cvxopt"):
        found["cholmod"] = ours("cholmod", matrix, right)
    return found


def measure(matrix: Matrix, right: Array, rounds: int) -> dict[str, tuple[float, float]]:
    """Median seconds of processor time, and the largest residual, of each solver."""
    random = np.random.default_rng(1)
    several = installed(matrix, right)
    spent: dict[str, list[float]] = {name: [] for name in several}
    left: dict[str, float] = dict.fromkeys(several, 0.0)
    pattern, size = matrix.pattern, len(right)
    for turn in range(rounds + 1):
        numbers = matrix.blocks.ravel() * (1.0 + 1e-4 * random.uniform(size=matrix.blocks.size))
        whole: Any = bsr_array((numbers.reshape(matrix.blocks.shape), pattern.column, pattern.start), shape=(size,) * 2)
        for name, solve in several.items():
            begin = time.process_time()
            found = solve(numbers)
            if turn:  # the first one compiles
                spent[name].append(time.process_time() - begin)
            left[name] = max(left[name], float(np.abs(whole @ found - right).max() / np.abs(right).max()))
    return {name: (statistics.median(spent[name]), left[name]) for name in several}


def main() -> None:
    """Measure, and print a table."""
    parser = parser_of(__doc__)
    parser.add_argument("--layers", type=int, nargs="*", default=sized([300, 3000, 10_000], [40]))
    parser.add_argument("--spaces", type=int, nargs="*", default=sized([1000], [40]))
    parser.add_argument("--rounds", type=int, default=sized(11, 1))
    asked = parser.parse_args()
    print(machine())
    for dimensions, counts in ((2, asked.layers), (3, asked.spaces)):
        for count in counts:
            parameters, scratch = system(count, dimensions)
            fill(parameters, scratch, LENGTH)
            matrix = scratch.step.matrix
            right = scratch.step.borders.right[0][matrix.pattern.order].ravel()
            for name, (seconds, left) in measure(matrix, right, asked.rounds).items():
                print(f"| {dimensions}D, {count:,} | {name} | {1e3 * seconds:.3g} | {left:.1e} |", flush=True)


if __name__ == "__main__":
    main()
