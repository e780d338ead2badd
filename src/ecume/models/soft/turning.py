"""Spheres that spin and that nothing holds: how all of them lie together.

Turned as a whole they resist nothing, and their matrix is singular, or nearly: forces that stay as they are on spheres
that turn have a moment then, and contacts bear none. So the first sphere is held against turning, and then as much of
what turns it is added as leaves no moment to what pulls.
"""

from __future__ import annotations

import numpy as np

from ecume._jit import compiled
from ecume.engine.linear_solvers.block_matrix import Matrix
from ecume.models.soft.spins import Spins
from ecume.units import Array

UNTOLD = 1e-6
"""Of what loads would resist a turn with, if nothing in it canceled: less than this says nothing of the turn."""


@compiled
def turn_first(matrix: Matrix, spins: Spins, right: Array) -> None:
    """Right sides, after the first one: torques on the first sphere that turn all of them by about a radian."""
    block, begin = matrix.blocks[matrix.pattern.diagonal[0]], matrix.blocks.shape[1] - spins.turn.shape[1]
    for k in range(spins.turn.shape[1]):
        for i in range(right.shape[1]):
            for m in range(right.shape[2]):
                right[1 + k, i, m] = 0.0
        right[1 + k, 0, begin + k] = block[begin + k, begin + k] * spins.radius[0]


@compiled
def unturn(position: Array, spins: Spins, changes: Array, pull: tuple[Array, Array, float]) -> None:
    """Add to the first change of places and spins as much of the others, which answer to `turn_first`, as leaves what
    pulls at the spheres without moment; where no pull resists a turn, as leaves the spheres without mean spin. `pull`
    is what grows with the load, what does not, and the load.

    The first sphere is held in the matrix: by what is so left of the moment, since the contacts' own is none.
    """
    whole, columns, to_mean, to_moment = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(3), np.zeros(3)
    moment, size = moment_of(position, spins, changes[0], pull)
    mean, own, nowhere = mean_spin(spins, changes[0]), own_moment(spins, pull[2]), np.zeros(position.shape)
    for k in range(spins.turn.shape[1]):
        by_turn, (by_pull, _) = mean_spin(spins, changes[1 + k]), moment_of(nowhere, spins, changes[1 + k], pull)
        for m in range(3):
            whole[m, k] = by_turn[m]
            columns[m, k] = by_pull[m] / size if size > 0.0 else 0.0
    for m in range(3):
        to_mean[m] = -mean[m]
        to_moment[m] = -(moment[m] + own[m]) / size if size > 0.0 else 0.0
    unturned = least_squares(whole, to_mean, np.zeros(3))
    if size > 0.0:
        unturned = least_squares(columns, to_moment, unturned)
    for k in range(spins.turn.shape[1]):
        for i in range(len(position)):
            for m in range(changes.shape[2]):
                changes[0, i, m] += unturned[k] * changes[1 + k, i, m]


@compiled
def mean_spin(spins: Spins, change: Array) -> Array:
    """Of all spheres, as an axial vector (rad)."""
    mean, width = np.zeros(3), spins.turn.shape[1]
    for i in range(len(change)):
        for k in range(width):
            mean[2 if width == 1 else k] += change[i, change.shape[1] - width + k] / (spins.radius[i] * len(change))
    return mean


@compiled
def moment_of(position: Array, spins: Spins, change: Array, pull: tuple[Array, Array, float]) -> tuple[Array, float]:
    """The moment of what pulls at changed places (N m), and how large it were if nothing in it canceled."""
    (by_load, always, load), (count, d) = pull, position.shape
    moment, size, middle = np.zeros(3), 0.0, np.zeros(3)
    for i in range(count):
        for k in range(d):
            middle[k] += (position[i, k] + change[i, k]) / count
    p, f = np.zeros(3), np.zeros(3)
    for i in range(count):
        for k in range(d):
            p[k] = position[i, k] + change[i, k] - middle[k]
            f[k] = load * by_load[i, k] + always[i, k]
        for k in range(3):
            moment[k] += p[(k + 1) % 3] * f[(k + 2) % 3] - p[(k + 2) % 3] * f[(k + 1) % 3]
            size += abs(p[k] * f[k])
    return moment, size


@compiled
def own_moment(spins: Spins, load: float) -> Array:
    """Of the torques on the spheres (N m)."""
    total, width = np.zeros(3), spins.turn.shape[1]
    for i in range(len(spins.torque)):
        for k in range(width):
            total[2 if width == 1 else k] += load * spins.torque[i, k] * spins.radius[i]
    return total


@compiled
def least_squares(matrix: Array, right: Array, otherwise: Array) -> Array:
    """What solves three equations, and where they say nothing is as told: by normal equations and elimination."""
    rows, solution = np.zeros((3, 4)), np.zeros(3)
    for k in range(3):
        rows[k, k] = UNTOLD**2
        rows[k, 3] = UNTOLD**2 * otherwise[k]
        for m in range(3):
            for n in range(3):
                rows[k, n] += matrix[m, k] * matrix[m, n]
            rows[k, 3] += matrix[m, k] * right[m]
    for k in range(3):
        for m in range(3):
            if m != k:
                part = rows[m, k] / rows[k, k]
                for n in range(k, 4):
                    rows[m, n] -= part * rows[k, n]
    for k in range(3):
        solution[k] = rows[k, 3] / rows[k, k]
    return solution
