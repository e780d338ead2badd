"""Amplitudes that answer one another: alpha = S + T c(alpha), by elimination for few bodies, by GMRES for many.

A body's answer to itself is in T already, so that the system is 1 - (what comes from others): GMRES [saad1986] needs
few turns unless rims nearly touch, and fewer from the solution of the step before. It ends on the true residual, so
that a solution that is solved again is left as it is, to the bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.laws.multipole.echoes import Echoes, from_the_middle, incoming, to_the_middle
from ecume.laws.multipole.graf import Rims, Waves, receive, sent
from ecume.units import Array

TURNS = 40
"""Directions that GMRES keeps before it starts again."""
MOST_ROUNDS = 25


class Krylov(NamedTuple):
    """Scratch of the iterative solution."""

    basis: Waves
    """(TURNS + 1, N, order + 1)"""
    waves: Waves
    """(N, order + 1)"""
    matrix: Array
    """(TURNS + 1, TURNS), upper triangular after the rotations"""
    rotations: Array
    """(TURNS, 2)"""
    right: Array
    """(TURNS + 1,)"""


def make_krylov(count: int, orders: int) -> Krylov:
    """Room for that many bodies with that many amplitudes each."""
    return Krylov(
        np.zeros((TURNS + 1, count, orders), np.complex128),
        np.zeros((count, orders), np.complex128),
        np.zeros((TURNS + 1, TURNS)),
        np.zeros((TURNS, 2)),
        np.zeros(TURNS + 1),
    )


@compiled
def product(a: Waves, b: Waves) -> float:
    """The sum of products of real and imaginary parts."""
    total = 0.0
    for i in range(a.shape[0]):
        for m in range(a.shape[1]):
            total += a[i, m].real * b[i, m].real + a[i, m].imag * b[i, m].imag
    return total


@compiled
def add(target: Waves, factor: float, other: Waves) -> None:
    """Add a multiple of other amplitudes."""
    for i in range(target.shape[0]):
        for m in range(target.shape[1]):
            target[i, m] += factor * other[i, m]


@compiled
def residual(
    rims: Rims, echoes: Echoes, position: Array, right: Waves, amplitudes: Waves, result: tuple[Waves, Waves]
) -> float:
    """Fill the first of `result` with right - (alpha - T c(alpha)), and return its length."""
    left, waves = result
    incoming(rims, echoes, position, amplitudes, waves)
    for i in range(left.shape[0]):
        for m in range(left.shape[1]):
            left[i, m] = right[i, m] - amplitudes[i, m] + rims.response[i, m] * waves[i, m]
    return math.sqrt(product(left, left))


@compiled
def rotate(krylov: Krylov, k: int) -> None:
    """Make column k of the small matrix triangular, and carry its right side along."""
    matrix, rotations, right = krylov.matrix, krylov.rotations, krylov.right
    for row in range(k):
        upper, lower = matrix[row, k], matrix[row + 1, k]
        matrix[row, k] = rotations[row, 0] * upper + rotations[row, 1] * lower
        matrix[row + 1, k] = rotations[row, 0] * lower - rotations[row, 1] * upper
    length = math.hypot(matrix[k, k], matrix[k + 1, k])
    rotations[k, 0], rotations[k, 1] = matrix[k, k] / length, matrix[k + 1, k] / length
    matrix[k, k], matrix[k + 1, k] = length, 0.0
    right[k + 1] = -rotations[k, 1] * right[k]
    right[k] = rotations[k, 0] * right[k]


@compiled
def combine(krylov: Krylov, used: int, amplitudes: Waves) -> None:
    """Add the best combination of the directions to the amplitudes."""
    matrix, right = krylov.matrix, krylov.right
    for row in range(used - 1, -1, -1):
        for column in range(row + 1, used):
            right[row] -= matrix[row, column] * right[column]
        right[row] /= matrix[row, row]
    for k in range(used):
        add(amplitudes, right[k], krylov.basis[k])


@compiled
def expand(rims: Rims, echoes: Echoes, position: Array, krylov: Krylov, k: int) -> float:
    """One more direction: what the system makes of the last, orthogonal to all before. Its length."""
    basis, matrix = krylov.basis, krylov.matrix
    incoming(rims, echoes, position, basis[k], krylov.waves)
    for i in range(basis.shape[1]):
        for m in range(basis.shape[2]):
            basis[k + 1, i, m] = basis[k, i, m] - rims.response[i, m] * krylov.waves[i, m]
    for row in range(k + 1):
        matrix[row, k] = product(basis[k + 1], basis[row])
        add(basis[k + 1], -matrix[row, k], basis[row])
    matrix[k + 1, k] = math.sqrt(product(basis[k + 1], basis[k + 1]))
    if matrix[k + 1, k] > 0.0:
        add(basis[k + 1], 1.0 / matrix[k + 1, k] - 1.0, basis[k + 1])
    return float(matrix[k + 1, k])


@compiled
def iterate(
    rims: Rims, echoes: Echoes, position: Array, right: Waves, amplitudes: Waves, krylov: Krylov, tolerance: float
) -> int:
    """Improve `amplitudes` until the residual is below `tolerance` of the right side. How many directions that took;
    -1 if they did not lead there.
    """
    wanted = tolerance * math.sqrt(product(right, right))
    taken, basis = 0, krylov.basis
    for _ in range(MOST_ROUNDS):
        length = residual(rims, echoes, position, right, amplitudes, (basis[0], krylov.waves))
        if length <= wanted:
            return taken
        add(basis[0], 1.0 / length - 1.0, basis[0])
        krylov.right[:] = 0.0
        krylov.right[0] = length
        used = 0
        while used < TURNS and abs(krylov.right[used]) > 0.5 * wanted:
            more = expand(rims, echoes, position, krylov, used)
            rotate(krylov, used)
            used += 1
            if more <= 0.0:
                break
        combine(krylov, used, amplitudes)
        taken += used
    return -1


@compiled
def fill_matrix(rims: Rims, echoes: Echoes, position: Array, matrix: Array) -> None:
    """1 - T G over real unknowns: alpha_0, then real and imaginary parts, body by body."""
    count, orders = rims.response.shape
    unknowns = 2 * orders - 1
    turned, unit = np.zeros(orders, np.complex128), np.zeros(orders, np.complex128)
    scratch, place, waves = np.zeros(2 * orders + 3), np.zeros(2), np.zeros(orders, np.complex128)
    middle = np.zeros((1, len(echoes.answer)), np.complex128)
    for j in range(count):
        for k in range(unknowns):
            m = (k + 1) // 2
            unit[:] = 0.0
            unit[m] = complex(1.0, 0.0) if k == 0 or k % 2 == 1 else complex(0.0, 1.0)
            middle[:] = 0.0
            if len(echoes.answer) > 0:
                to_the_middle(rims, echoes, j, position[j], unit, middle)
            for i in range(count):
                waves[:] = 0.0
                for t in range(len(echoes.mirrors)):
                    mirror = echoes.mirrors[t]
                    if t == 0 and j == i:
                        continue
                    place[0] = position[i, 0] - mirror[0] * position[j, 0] - mirror[1]
                    place[1] = position[i, 1] - mirror[2] * position[j, 1] - mirror[3]
                    sent(unit, mirror, turned)
                    receive(rims, (i, j), place, turned, scratch, waves)
                if len(echoes.answer) > 0:
                    from_the_middle(rims, echoes, i, position[i], middle, waves)
                row = i * unknowns
                matrix[row, j * unknowns + k] = -rims.response[i, 0] * waves[0].real
                for n in range(1, orders):
                    matrix[row + 2 * n - 1, j * unknowns + k] = -rims.response[i, n] * waves[n].real
                    matrix[row + 2 * n, j * unknowns + k] = -rims.response[i, n] * waves[n].imag
            matrix[j * unknowns + k, j * unknowns + k] += 1.0


def eliminate(rims: Rims, echoes: Echoes, position: Array, right: Waves) -> Waves:
    """The amplitudes, by LAPACK."""
    count, orders = right.shape
    unknowns = 2 * orders - 1
    matrix = np.zeros((count * unknowns, count * unknowns))
    fill_matrix(rims, echoes, position, matrix)
    parts = np.stack([right.real, right.imag], axis=2).reshape(count, 2 * orders)
    known = np.delete(parts, 1, axis=1).ravel()
    solved = np.linalg.solve(matrix, known).reshape(count, unknowns)
    both = np.insert(solved, 1, 0.0, axis=1).reshape(count, orders, 2)
    found: Waves = both[:, :, 0] + 1j * both[:, :, 1]
    return found
