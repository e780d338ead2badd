"""The exact solution of contacts, for the few islands on which sweeps do not converge.

A raft with more contacts than degrees of freedom has self-stresses: changes of impulses that change no velocity.
Thousands of sweeps then move slowly along a self-stress, until a contact opens. The velocities are nevertheless unique:
of all that satisfy the conditions, they are the nearest to the given ones in the norm of kinetic energy. This is least
distance programming, which becomes nonnegative least squares [lawson1974, chapter 23]: minimize |E u - f| over u >= 0,
with the contacts' directions and bounds as the columns of E. The method is direct, and its cost grows with the cube of
the number of contacts: see LARGEST.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_apart, compiled_inside
from ecume.engine.cells import Integers
from ecume.engine.contact.islands import Choice
from ecume.units import Array

LARGEST = 512
"""The largest number of contacts of an island for the active-set method, which takes about a tenth of a second for it;
larger islands are left to sweeps.
"""
DEPENDENT = 1e-12
"""The norm of a column's component orthogonal to the others, over its own norm, below which it counts as dependent.
With a hundred times this, contacts of braced rafts closed at a billionth of the speeds.
"""
OPTIMAL = 1e-13
"""The largest gradient that still counts as zero, where the longest columns are about one."""
FEASIBLE = 1e-12
"""The last component of the residual below which no velocity fulfills all conditions."""


@compiled_apart("float64[:,:]", "float64[:]", "float64[:]")
def nearest_impulses(matrix: Array, need: Array, impulse: Array) -> bool:
    """Solve for the impulses of the least change of the velocities, in the norm of kinetic energy, that closes the
    `need` of each contact (m/s). The columns of `matrix` are the responses to unit impulses in this norm, and its last
    row is empty; the matrix and the needs are overwritten. `impulse` is the initial guess, which receives the solution.
    Returns False, with `impulse` unchanged, if no solution is found.
    """
    scale, longest = 0.0, 0.0
    for k in range(len(need)):
        scale = max(scale, abs(need[k]) if need[k] == need[k] else np.inf)
        square = 0.0
        for row in range(len(matrix)):
            square += matrix[row, k] ** 2
        longest = max(longest, square)
    strength = np.sqrt(longest)
    if not strength > 0.0 or not 0.0 < scale < np.inf:
        return False
    right, guess = np.zeros(len(matrix)), np.empty(len(need), np.bool_)
    right[len(right) - 1] = 1.0
    for k in range(len(need)):
        for row in range(len(matrix)):
            matrix[row, k] /= strength
        matrix[len(matrix) - 1, k] = need[k] / scale
        guess[k] = impulse[k] > 0.0
    solution, found = nonnegative_least_squares(matrix, right, guess)
    explained = 0.0
    for k in range(len(need)):
        explained += matrix[len(matrix) - 1, k] * solution[k]
    rest = 1.0 - explained
    if not found or not rest > FEASIBLE:
        return False
    for k in range(len(need)):
        impulse[k] = solution[k] * (scale / (rest * strength * strength))
    return True


@compiled
def numbered(places: Integers, count: int) -> tuple[Integers, int]:
    """The new index of each of `count` places that occurs, in ascending order, and the number of places that occur."""
    index, found = np.zeros(count, np.int64), 0
    for each in places:
        index[each] = 1
    for place in range(count):
        if index[place] > 0:
            index[place] = found
            found += 1
    return index, found


class Factors(NamedTuple):
    """The factors Q R of the columns that may be positive, in the order of their entry."""

    kept: Integers
    """(1,) the number of columns"""
    who: Integers
    """(capacity,) the number of each column"""
    basis: Array
    """(capacity, rows) the columns of Q, as rows"""
    upper: Array
    """(capacity, capacity) R"""
    share: Array
    """(capacity,) the right side times Q"""


@compiled
def nonnegative_least_squares(matrix: Array, right: Array, guess: Choice) -> tuple[Array, bool]:
    """The u >= 0 that minimizes |matrix u - right|, and whether it was found. `guess` flags the components that may
    initially be positive. Algorithm NNLS of [lawson1974], with factors that columns enter and leave.
    """
    (rows, count), room = matrix.shape, min(matrix.shape) + 1
    factors = Factors(
        np.zeros(1, np.int64), np.empty(room, np.int64), np.empty((room, rows)), np.zeros((room, room)), np.empty(room)
    )
    solution, passive, barred = np.zeros(count), np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    for k in range(count):
        if guess[k] and _enter(factors, matrix, right, k):
            solution[k], passive[k] = 1.0, True
    settled = _settle(factors, solution, passive)
    for _ in range(10 * count):
        if not settled:
            return solution, False
        entering, steepest = -1, OPTIMAL
        gradient = _gradient(matrix, right, solution)
        for k in range(count):
            if not passive[k] and not barred[k] and gradient[k] > steepest:
                entering, steepest = k, gradient[k]
        if entering < 0:
            return solution, True
        passive[entering] = _enter(factors, matrix, right, entering)
        if passive[entering]:
            settled = _settle(factors, solution, passive)
        # A column that leaves at once is linearly dependent to rounding, and would enter and leave endlessly.
        barred[entering] = not passive[entering]
        if not barred[entering]:
            for k in range(count):
                barred[k] = False
    return solution, False


@compiled
def _gradient(matrix: Array, right: Array, solution: Array) -> Array:
    """The products of all columns with the residual right - matrix solution."""
    gradient = np.zeros(len(solution))
    for row in range(len(matrix)):
        rest = 0.0
        for k in range(len(solution)):
            rest += matrix[row, k] * solution[k]
        rest = right[row] - rest
        for k in range(len(solution)):
            gradient[k] += matrix[row, k] * rest
    return gradient


@compiled
def _settle(factors: Factors, solution: Array, passive: Choice) -> bool:
    """Solve least squares for the passive components; components that would become negative leave the set."""
    for _ in range(2 * len(solution) + 2):
        target, share, stays = _least_squares(factors, len(solution)), 1.0, True
        for k in range(len(solution)):
            if passive[k] and target[k] <= 0.0:
                share = min(share, solution[k] / (solution[k] - target[k]) if solution[k] > 0.0 else 0.0)
        for k in range(len(solution)):
            blocks = passive[k] and target[k] <= 0.0
            solution[k] += share * (target[k] - solution[k])
            if blocks and solution[k] <= 1e-14 * abs(target[k]):
                _leave(factors, k)
                solution[k], passive[k], stays = 0.0, False, False
        if share == 1.0 and stays:
            return True
    return False


@compiled
def _least_squares(factors: Factors, count: int) -> Array:
    """The least squares solution: back substitution."""
    solution, who, upper, kept = np.zeros(count), factors.who, factors.upper, factors.kept[0]
    for place in range(kept - 1, -1, -1):
        value = factors.share[place]
        for other in range(place + 1, kept):
            value -= upper[place, other] * solution[who[other]]
        solution[who[place]] = value / upper[place, place]
    return solution


@compiled
def _enter(factors: Factors, matrix: Array, right: Array, k: int) -> bool:
    """Append a column by modified Gram-Schmidt; return whether it is independent of the others."""
    basis, upper, kept, rows = factors.basis, factors.upper, factors.kept[0], len(matrix)
    column = matrix[:, k].copy()
    length = _length(column)
    for place in range(kept + 1):
        upper[place, kept] = 0.0
    for _ in range(2):  # two orthogonalizations suffice
        for place in range(kept):
            along = 0.0
            for row in range(rows):
                along += basis[place, row] * column[row]
            upper[place, kept] += along
            for row in range(rows):
                column[row] -= along * basis[place, row]
    left = _length(column)
    if left <= DEPENDENT * length:
        return False
    factors.share[kept] = 0.0
    for row in range(rows):
        basis[kept, row] = column[row] / left
        factors.share[kept] += basis[kept, row] * right[row]
    upper[kept, kept], factors.who[kept] = left, k
    factors.kept[0] += 1
    return True


@compiled
def _leave(factors: Factors, k: int) -> None:
    """Remove a column, and rotate what follows into triangular form again [lawson1974, chapter 24]."""
    who, basis, upper, share = factors.who, factors.basis, factors.upper, factors.share
    factors.kept[0] -= 1
    kept, place = factors.kept[0], 0
    while who[place] != k:
        place += 1
    for other in range(place, kept):
        who[other] = who[other + 1]
        for row in range(other + 2):
            upper[row, other] = upper[row, other + 1]
        length = np.sqrt(upper[other, other] ** 2 + upper[other + 1, other] ** 2)
        c, s = upper[other, other] / length, upper[other + 1, other] / length
        upper[other, other], upper[other + 1, other] = length, 0.0
        for column in range(other + 2, kept + 1):
            above, below = upper[other, column], upper[other + 1, column]
            upper[other, column], upper[other + 1, column] = c * above + s * below, c * below - s * above
        for row in range(basis.shape[1]):
            above, below = basis[other, row], basis[other + 1, row]
            basis[other, row], basis[other + 1, row] = c * above + s * below, c * below - s * above
        above, below = share[other], share[other + 1]
        share[other], share[other + 1] = c * above + s * below, c * below - s * above


@compiled_inside
def _length(column: Array) -> float:
    square = 0.0
    for row in range(len(column)):
        square += column[row] * column[row]
    return float(np.sqrt(square))
