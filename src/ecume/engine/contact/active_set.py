"""The impulses of contacts by an active-set method: exact, for the few islands on which sweeps do not converge.

A raft that is braced by more contacts than it has degrees of freedom has self-stresses, along which impulses can change
without changing any velocity. Gauss-Seidel sweeps then creep along one of them for thousands of sweeps, until a contact
opens. The velocities are nevertheless unique: they are the nearest to the given ones, in the norm of kinetic energy,
that break no condition. This is least distance programming, which becomes nonnegative least squares [lawson1974,
chapter 23]: minimize |E u - f| over u >= 0, with the contacts' directions and bounds as the columns of E.

The method is direct, so its cost grows with the cube of the contacts: see LARGEST.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.units import Array

Choice = NDArray[np.bool_]

LARGEST = 128
"""Contacts of an island; so many take about a tenth of a second, and larger islands are left to sweeps."""
DEPENDENT = 1e-10
"""What must be left of a column beside the others, over its length, for it to count as independent."""
OPTIMAL = 1e-13
"""The largest gradient that still counts as zero, where the longest columns are about one."""
FEASIBLE = 1e-12
"""What must be left of the last row: less is rounding, and no velocity fulfills all conditions."""


@compiled
def nearest_velocity(
    pair: tuple[Integers, Integers, Array], bound: Array, impulse: Array, velocity: Array, mobility: Array
) -> bool:
    """Solve contacts (first, second, normal) exactly, from impulses that stand in `velocity` already; both change.

    False, and no change, where no solution was found.
    """
    bodies, number = _numbered(pair)
    if not mobility[bodies].max() > 0.0:
        return False
    matrix, strength = _columns(pair, number, mobility[bodies])
    free = _without_impulses(pair, impulse, velocity, mobility)
    need = _needs(pair, bound, free)
    scale = np.abs(need).max()
    if not 0.0 < scale < np.inf:
        return False
    matrix[len(matrix) - 1] = need / scale
    right = np.zeros(len(matrix))
    right[len(right) - 1] = 1.0
    solution, found = nonnegative_least_squares(matrix, right, impulse > 0.0)
    rest = 1.0 - (matrix[len(matrix) - 1] * solution).sum()
    if not found or not rest > FEASIBLE:
        return False
    impulse[:] = solution * (scale / (rest * strength * strength))
    velocity[:] = free
    _push(pair, impulse, velocity, mobility)
    return True


@compiled
def _numbered(pair: tuple[Integers, Integers, Array]) -> tuple[Integers, Integers]:
    """The bodies that take part, and the places of both bodies of each contact among them, (2, n)."""
    first, second, _ = pair
    bodies = np.unique(np.concatenate((first, second)))
    number = np.empty((2, len(first)), np.int64)
    number[0], number[1] = np.searchsorted(bodies, first), np.searchsorted(bodies, second)
    return bodies, number


@compiled
def _columns(pair: tuple[Integers, Integers, Array], number: Integers, mobility: Array) -> tuple[Array, float]:
    """The responses to unit impulses, in the norm of kinetic energy, over the largest of their lengths, which is
    returned too. The last row remains empty.
    """
    normal = pair[2]
    matrix, longest = np.zeros((2 * len(mobility) + 1, len(normal))), 0.0
    for k in range(len(normal)):
        one, other = number[0, k], number[1, k]
        longest = max(longest, mobility[one] + mobility[other])
        for axis in range(2):
            matrix[2 * one + axis, k] = -np.sqrt(mobility[one]) * normal[k, axis]
            matrix[2 * other + axis, k] = np.sqrt(mobility[other]) * normal[k, axis]
    strength = np.sqrt(longest)
    matrix /= strength
    return matrix, strength


@compiled
def _push(pair: tuple[Integers, Integers, Array], impulse: Array, velocity: Array, mobility: Array) -> None:
    """Change velocities by impulses."""
    first, second, normal = pair
    for k in range(len(first)):
        i, j = first[k], second[k]
        for axis in range(2):
            velocity[i, axis] -= mobility[i] * impulse[k] * normal[k, axis]
            velocity[j, axis] += mobility[j] * impulse[k] * normal[k, axis]


@compiled
def _without_impulses(
    pair: tuple[Integers, Integers, Array], impulse: Array, velocity: Array, mobility: Array
) -> Array:
    """The velocities before the impulses."""
    free = velocity.copy()
    _push(pair, -impulse, free, mobility)
    return free


@compiled
def _needs(pair: tuple[Integers, Integers, Array], bound: Array, velocity: Array) -> Array:
    """The shortfall of each contact's normal velocity below its bound (m/s)."""
    first, second, normal = pair
    need = np.empty(len(first))
    for k in range(len(first)):
        i, j = first[k], second[k]
        along_x = normal[k, 0] * (velocity[j, 0] - velocity[i, 0])
        need[k] = bound[k] - along_x - normal[k, 1] * (velocity[j, 1] - velocity[i, 1])
    return need


@compiled
def nonnegative_least_squares(matrix: Array, right: Array, guess: Choice) -> tuple[Array, bool]:
    """The u >= 0 for which |matrix u - right| is least, and whether it was found; `guess` says which components may be
    positive to begin with. Algorithm NNLS of [lawson1974], with modified Gram-Schmidt for least squares.
    """
    count = matrix.shape[1]
    solution, passive, barred = np.zeros(count), guess.copy(), np.zeros(count, np.bool_)
    for k in range(count):
        solution[k] = 1.0 if passive[k] else 0.0
    settled = _settle(matrix, right, solution, passive)
    for _ in range(10 * count):
        if not settled:
            return solution, False
        rest = right - _applied(matrix, solution)
        entering, steepest = -1, OPTIMAL
        for k in range(count):
            gradient = 0.0
            for row in range(len(rest)):
                gradient += matrix[row, k] * rest[row]
            if not passive[k] and not barred[k] and gradient > steepest:
                entering, steepest = k, gradient
        if entering < 0:
            return solution, True
        passive[entering] = True
        settled = _settle(matrix, right, solution, passive)
        # One that leaves at once depends on those that are there, to rounding: it would come and go for ever.
        barred[entering] = not passive[entering]
        if not barred[entering]:
            barred[:] = False
    return solution, False


@compiled
def _applied(matrix: Array, solution: Array) -> Array:
    """The product, added column by column."""
    total = np.zeros(len(matrix))
    for k in range(len(solution)):
        if solution[k] != 0.0:
            for row in range(len(matrix)):
                total[row] += matrix[row, k] * solution[k]
    return total


@compiled
def _settle(matrix: Array, right: Array, solution: Array, passive: Choice) -> bool:
    """Solve least squares for the passive components; those that would become negative leave the set, one by one."""
    for _ in range(2 * len(solution) + 2):
        target = _least_squares(matrix, right, passive)
        share = 1.0
        for k in range(len(solution)):
            if passive[k] and target[k] <= 0.0:
                share = min(share, solution[k] / (solution[k] - target[k]) if solution[k] > 0.0 else 0.0)
        stays = True
        for k in range(len(solution)):
            blocks = passive[k] and target[k] <= 0.0
            solution[k] += share * (target[k] - solution[k])
            if not passive[k] or (blocks and solution[k] <= 1e-14 * abs(target[k])):
                stays = stays and not passive[k]
                solution[k], passive[k] = 0.0, False
        if share == 1.0 and stays:
            return True
    return False


@compiled
def _least_squares(matrix: Array, right: Array, passive: Choice) -> Array:
    """The least squares of the passive components, by modified Gram-Schmidt; dependent columns leave these."""
    rows, columns = matrix.shape
    basis, upper = np.empty((columns, rows)), np.zeros((columns, columns))
    who, kept = np.empty(columns, np.int64), 0
    for k in range(columns):
        if not passive[k]:
            continue
        column, length = matrix[:, k].copy(), np.sqrt((matrix[:, k] ** 2).sum())
        for _ in range(2):  # twice is enough
            for other in range(kept):
                along = 0.0
                for row in range(rows):
                    along += basis[other, row] * column[row]
                upper[other, kept] += along
                for row in range(rows):
                    column[row] -= along * basis[other, row]
        left = np.sqrt((column**2).sum())
        if left <= DEPENDENT * length:
            upper[:, kept] = 0.0
            passive[k] = False
            continue
        basis[kept], upper[kept, kept], who[kept] = column / left, left, k
        kept += 1
    solution, rest = np.zeros(columns), right.copy()
    shares = np.zeros(kept)
    for place in range(kept):
        for row in range(rows):
            shares[place] += basis[place, row] * rest[row]
        rest -= shares[place] * basis[place]
    for place in range(kept - 1, -1, -1):
        value = shares[place]
        for other in range(place + 1, kept):
            value -= upper[place, other] * solution[who[other]]
        solution[who[place]] = value / upper[place, place]
    return solution
