"""Iterative solutions of block systems: stabilized biconjugate gradients, BiCGStab [vandervorst1992].

The preconditioner is symmetric Gauss-Seidel (SSOR) within chunks of rows, by Eisenstat's trick.

With D, L and U the diagonal and the lower and upper triangles within each chunk, and R the blocks between chunks, (D +
L)^-1 A (D + U)^-1 D y = (D + L)^-1 b is solved for y, and x = (D + U)^-1 D y. A product consists of a sweep up for w =
x(y) and a sweep down for w + (D + L)^-1 (U w + R w). This is no more work than a product with A itself [eisenstat1981].

A chunk belongs to one thread, and sums over rows are sums over chunks in their order, so that bits do not depend on the
number of threads.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside, inlined, prange, threaded
from ecume.engine.cells import Integers
from ecume.engine.linear_solvers.block_matrix import CHUNK, Matrix, invert_diagonal
from ecume.units import Array

FEW = 2000
"""The number of particles from which threads are used."""
R, R0, P, V, S, T, Y, W, UW = range(9)
"""Vectors of the method: r, r0 (shadow residual), p, v = A p, s, t = A s, y, w (see the module), and U w or the
increment of w.
"""
MAKE_P, MAKE_S, SWEEP_DOWN, UPDATE, MAKE_X = range(5)
"""Passes over a chunk: update p and sweep up, update s and sweep up, sweep down, update y and r, sweep up for x."""


class Tolerance(NamedTuple):
    """The relative accuracy, and the largest number of iterations."""

    accuracy: float
    most: int


class Gradients(NamedTuple):
    """Scratch memory of the method."""

    vectors: Array
    """(9, N, b), by rows"""
    inverse: Array
    """(N, b, b) inverse diagonal blocks, by rows"""
    sums: Array
    """(chunks, 2)"""


def make_gradients(count: int, width: int) -> Gradients:
    """Scratch memory for systems of this size."""
    chunks = (count + CHUNK - 1) // CHUNK
    return Gradients(np.zeros((9, count, width)), np.zeros((count, width, width)), np.zeros((chunks, 2)))


class Rows(NamedTuple):
    """The matrix as plain arrays, as threads require."""

    start: Integers
    column: Integers
    inside: Integers
    blocks: Array
    inverse: Array


class PassArguments(NamedTuple):
    """Arguments of a pass: the vector that it computes, the vector of the scalar product, and alpha, omega, beta."""

    vector: int
    other: int
    alpha: float
    omega: float
    beta: float


@compiled_inside
def sweep_up(rows: Rows, y: Array, w: Array, uw: Array, chunk: tuple[int, int, int]) -> None:
    """Backward substitution in a chunk of rows: w = (D + U)^-1 D y, and U w."""
    column, inside, blocks, inverse = rows.column, rows.inside, rows.blocks, rows.inverse
    begin, end, width = chunk
    for row in range(end - 1, begin - 1, -1):
        for k in range(width):
            uw[row, k] = 0.0
        for place in range(inside[row, 1] + 1, inside[row, 2]):
            for k in range(width):
                for m in range(width):
                    uw[row, k] += blocks[place, k, m] * w[column[place], m]
        for k in range(width):
            value = y[row, k]
            for m in range(width):
                value -= inverse[row, k, m] * uw[row, m]
            w[row, k] = value


@compiled_inside
def sweep_down(rows: Rows, image: Array, w: Array, uw: Array, chunk: tuple[int, int, int]) -> None:
    """Forward substitution in a chunk of rows: `image` = w + (D + L)^-1 (U w + R w). The increment
    of w replaces U w.
    """
    start, column, inside, blocks, inverse = rows.start, rows.column, rows.inside, rows.blocks, rows.inverse
    begin, end, width = chunk
    left = np.empty(width)
    for row in range(begin, end):
        for k in range(width):
            left[k] = uw[row, k]
        for place in range(start[row], inside[row, 0]):
            for k in range(width):
                for m in range(width):
                    left[k] += blocks[place, k, m] * w[column[place], m]
        for place in range(inside[row, 0], inside[row, 1]):
            for k in range(width):
                for m in range(width):
                    left[k] -= blocks[place, k, m] * uw[column[place], m]
        for place in range(inside[row, 2], start[row + 1]):
            for k in range(width):
                for m in range(width):
                    left[k] += blocks[place, k, m] * w[column[place], m]
        for k in range(width):
            value = 0.0
            for m in range(width):
                value += inverse[row, k, m] * left[m]
            uw[row, k] = value
            image[row, k] = w[row, k] + value


@compiled_inside
def sweep(task: int, rows: Rows, buffers: tuple[Array, Array, Array], chunk: tuple[int, int, int]) -> None:
    """A sweep up or down over a chunk of rows."""
    vector, w, uw = buffers
    if task == SWEEP_DOWN:
        sweep_down(rows, vector, w, uw, chunk)
    else:
        sweep_up(rows, vector, w, uw, chunk)


@compiled_inside
def update_direction(task: int, vectors: Array, given: PassArguments, begin: int, end: int) -> None:
    """Compute p = r + beta (p - omega v), or s = r - alpha v."""
    r, p, v, s = vectors[R], vectors[P], vectors[V], vectors[S]
    for row in range(begin, end):
        for k in range(r.shape[1]):
            if task == MAKE_P:
                p[row, k] = r[row, k] + given.beta * (p[row, k] - given.omega * v[row, k])
            else:
                s[row, k] = r[row, k] - given.alpha * v[row, k]


@compiled_inside
def update_solution(vectors: Array, given: PassArguments, begin: int, end: int) -> None:
    """Compute y += alpha p + omega s, and r = s - omega t."""
    r, p, s, t, y = vectors[R], vectors[P], vectors[S], vectors[T], vectors[Y]
    for row in range(begin, end):
        for k in range(r.shape[1]):
            y[row, k] += given.alpha * p[row, k] + given.omega * s[row, k]
            r[row, k] = s[row, k] - given.omega * t[row, k]


@compiled_inside
def pass_over_chunk(task: int, given: PassArguments, rows: Rows, work: tuple[Array, Array], chunk: int) -> None:
    """Perform one pass over a chunk of rows, and sum the product of its vector with another, and its square."""
    vectors, sums = work
    width = rows.blocks.shape[1]
    begin, end = chunk * CHUNK, min((chunk + 1) * CHUNK, vectors.shape[1])
    if task in (MAKE_P, MAKE_S):
        update_direction(task, vectors, given, begin, end)
    if task == UPDATE:
        update_solution(vectors, given, begin, end)
    else:
        buffers = (vectors[given.vector], vectors[W], vectors[UW])
        # The same call three times, since the compiler unrolls the loops for a known width.
        if width == 2:
            sweep(task, rows, buffers, (begin, end, 2))
        elif width == 3:
            sweep(task, rows, buffers, (begin, end, 3))
        else:
            sweep(task, rows, buffers, (begin, end, width))
    if task in (SWEEP_DOWN, UPDATE):
        made, other = vectors[given.vector], vectors[given.other]
        sums[chunk, 0] = sums[chunk, 1] = 0.0
        for row in range(begin, end):
            for k in range(width):
                sums[chunk, 0] += made[row, k] * other[row, k]
                sums[chunk, 1] += made[row, k] * made[row, k]


@compiled
def pass_serial(task: int, given: PassArguments, rows: Rows, vectors: Array, sums: Array) -> None:
    """Perform one pass over all chunks, in one thread."""
    for chunk in range(len(sums)):
        pass_over_chunk(task, given, rows, (vectors, sums), chunk)


@threaded
def pass_threaded(task: int, given: PassArguments, rows: Rows, vectors: Array, sums: Array) -> None:
    """Perform one pass over all chunks, by several threads."""
    for chunk in prange(len(sums)):
        pass_over_chunk(task, given, rows, (vectors, sums), chunk)


@compiled
def total(sums: Array, which: int) -> float:
    """The sum over all chunks."""
    value = 0.0
    for chunk in range(len(sums)):
        value += sums[chunk, which]
    return value


@compiled
def start_from(right: Array, order: Integers, vectors: Array) -> None:
    """Copy a right side to the order of rows, and set the solution to zero."""
    for row in range(len(order)):
        for k in range(right.shape[1]):
            vectors[UW, row, k] = right[order[row], k]
            vectors[W, row, k] = vectors[Y, row, k] = 0.0


@inlined
def solve_one(
    run_pass: Callable[..., None],
    rows: Rows,
    order: Integers,
    sides: tuple[Array, Array],
    scratch: Gradients,
    tolerance: Tolerance,
) -> int:
    """Solve for one right side by BiCGStab from zero. Returns the number of iterations, or -1 at a breakdown or after
    too many.
    """
    (right, solution), (vectors, _, sums) = sides, scratch
    start_from(right, order, vectors)
    run_pass(SWEEP_DOWN, PassArguments(R, R, 0.0, 0.0, 0.0), rows, vectors, sums)
    start = rho = total(sums, 1)
    for row in range(len(order)):
        for k in range(right.shape[1]):
            vectors[R0, row, k] = vectors[P, row, k] = vectors[R, row, k]
    alpha, omega, beta, square, iteration = 0.0, 0.0, 0.0, start, 0
    while square > tolerance.accuracy * tolerance.accuracy * start:
        if iteration == tolerance.most:
            return -1
        iteration += 1
        run_pass(MAKE_P, PassArguments(P, P, alpha, omega, beta), rows, vectors, sums)
        run_pass(SWEEP_DOWN, PassArguments(V, R0, alpha, omega, beta), rows, vectors, sums)
        alpha = rho / total(sums, 0)
        run_pass(MAKE_S, PassArguments(S, S, alpha, omega, beta), rows, vectors, sums)
        run_pass(SWEEP_DOWN, PassArguments(T, S, alpha, omega, beta), rows, vectors, sums)
        t_squared = total(sums, 1)
        omega = total(sums, 0) / t_squared if t_squared > 0.0 else 0.0
        run_pass(UPDATE, PassArguments(R, R0, alpha, omega, beta), rows, vectors, sums)
        square, rho_before, rho = total(sums, 1), rho, total(sums, 0)
        beta = rho / rho_before * alpha / omega if omega != 0.0 and rho_before != 0.0 else math.nan
        if not (math.isfinite(square) and (math.isfinite(beta) or square == 0.0)):
            return -1
    run_pass(MAKE_X, PassArguments(Y, Y, 0.0, 0.0, 0.0), rows, vectors, sums)
    for row in range(len(order)):
        for k in range(right.shape[1]):
            solution[order[row], k] = vectors[W, row, k]
    return iteration


@inlined
def solve_all(
    run_pass: Callable[..., None], matrix: Matrix, sides: tuple[Array, Array], scratch: Gradients, tolerance: Tolerance
) -> int:
    """Solve for all right sides. Returns the total number of iterations, or -1 if one fails."""
    pattern, (right, solution), iterations = matrix.pattern, sides, 0
    if not invert_diagonal(matrix, scratch.inverse):
        return -1
    rows = Rows(pattern.start, pattern.column, pattern.inside, matrix.blocks, scratch.inverse)
    for side in range(right.shape[0]):
        took = solve_one(run_pass, rows, pattern.order, (right[side], solution[side]), scratch, tolerance)
        if took < 0:
            return -1
        iterations += took
    return iterations


@compiled
def solve_serial(matrix: Matrix, sides: tuple[Array, Array], scratch: Gradients, tolerance: Tolerance) -> int:
    """Solve in one thread."""
    return solve_all(pass_serial, matrix, sides, scratch, tolerance)


@compiled
def solve_threaded(matrix: Matrix, sides: tuple[Array, Array], scratch: Gradients, tolerance: Tolerance) -> int:
    """Solve in several threads."""
    return solve_all(pass_threaded, matrix, sides, scratch, tolerance)


def biconjugate_gradients(
    matrix: Matrix, right: Array, solution: Array, scratch: Gradients, tolerance: Tolerance
) -> int:
    """Reduce the residual of each right side, in the norm of (D + L)^-1 r, by `tolerance.accuracy`. Returns the total
    number of iterations, or -1 at a breakdown or after too many. The matrix need not be symmetric.
    """
    solve = solve_threaded if right.shape[1] >= FEW else solve_serial
    return int(solve(matrix, (right, solution), scratch, tolerance))
