"""Films between floats that interact through the liquid: the near field of each pair.

Far apart two spheres move one another as the mobility says; close together a film resists their relative motion in
addition. Its friction is such that two spheres which approach have the exact resistance at any gap: zeta/2 times
lambda(l/R) of `drag.pair_factor` minus the resistance by the mobility alone. Films have no part in the motion of a
rigid raft, whose speed is that of the far field.

With films of friction D the velocities v0 become v = v0 - M J^T D J v. This is solved for psi = D^(1/2) J v,
(1 + D^(1/2) J M J^T D^(1/2)) psi = D^(1/2) J v0, by conjugate gradients.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecume._jit import admit, compiled
from ecume.laws import pair_mobility
from ecume.laws.pair_mobility import rotne_prager
from ecume.models.floating.coupled.mobility import CoupledScratch, multiply, store_velocities
from ecume.models.floating.forces.films import (
    MOST_ITERATIONS,
    TOLERANCE,
    Films,
    Pairs,
    films_within,
    find_films,
    reduced_float,
)
from ecume.models.floating.options import Built
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.state import State, Workspace
from ecume.models.liquids import liquid_of
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene

admit(pair_mobility)

REACH = 6.0
"""Default distance of centers, in radii, beyond which films are neglected: the mobility alone is within 0.4 % there."""


class CoupledFilms(NamedTuple):
    """Constants of films in addition to the mobility."""

    films: Films
    viscosity: float
    far: float
    """the resistance of two approaching spheres by the mobility alone where films end, over that of single ones"""


def coupled_films_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return the films of a scene."""
    films = films_within(parameters, scene, REACH)
    part = CoupledFilms(films, liquid_of(scene).viscosity, approach_factor(films.reach, 1.0))
    return Built(part, reach=films.reach * float(parameters.floats.radius.max()))


@compiled
def approach_factor(distance: float, radius: float) -> float:
    """The resistance of two equal approaching spheres by the mobility alone, over that of single ones."""
    return 1.0 / (1.0 - radius * rotne_prager(distance, radius, radius)[1])


@compiled
def apply_coupled_films(
    part: CoupledFilms, own: CoupledScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Apply films to the velocities and midstep velocities."""
    pairs = find_films(part.films, parameters, state.position, workspace.lists)
    subtract_far_field(part, parameters, state.position, pairs)
    if len(pairs.friction) > 0:
        solve_with_films(pairs, own)
        store_velocities(own, state, workspace)


@compiled
def subtract_far_field(part: CoupledFilms, parameters: Parameters, position: Array, pairs: Pairs) -> None:
    """Subtract what the mobility resists already; nothing is left of films where it resists more."""
    for row in range(len(pairs.friction)):
        i, j = pairs.first[row], pairs.second[row]
        x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
        # As in `find_films`, two equal spheres of twice the reduced radius.
        radius, friction = reduced_float(parameters, i, j)
        gap = math.sqrt(x * x + y * y) - parameters.floats.radius[i] - parameters.floats.radius[j]
        size = friction / (3.0 * math.pi * part.viscosity * radius)
        known = approach_factor(2.0 + max(gap, 0.0) / radius, size) - part.far
        pairs.friction[row] = max(pairs.friction[row] - 0.5 * friction * known, 0.0)


@compiled
def solve_with_films(pairs: Pairs, own: CoupledScratch) -> int:
    """Change the motion by films, and add their forces to those on the floats; return the number of iterations."""
    total, size = len(pairs.friction), len(own.motion)
    strength, weight, found = np.empty(total), np.empty(total), np.zeros(total)
    residual, direction, image = np.empty(total), np.empty(total), np.empty(total)
    force, moved, square = np.zeros(size), own.motion.copy(), 0.0
    closing_speeds(pairs, moved, residual)
    for row in range(total):
        strength[row] = math.sqrt(pairs.friction[row])
        weight[row] = 1.0 / (1.0 + pairs.friction[row] * closing_mobility(pairs, row, own.mobility))
        residual[row] *= strength[row]
        direction[row] = weight[row] * residual[row]
        square += residual[row] * direction[row]
    goal, iterations = TOLERANCE * TOLERANCE * square, 0
    while square > goal and iterations < MOST_ITERATIONS:
        spread_forces(pairs, strength, direction, force)
        multiply(own.mobility, force, moved)
        closing_speeds(pairs, moved, image)
        curvature, last = 0.0, square
        for row in range(total):
            image[row] = direction[row] + strength[row] * image[row]
            curvature += direction[row] * image[row]
        square = 0.0
        for row in range(total):
            found[row] += last / curvature * direction[row]
            residual[row] -= last / curvature * image[row]
            square += weight[row] * residual[row] * residual[row]
        for row in range(total):
            direction[row] = weight[row] * residual[row] + square / last * direction[row]
        iterations += 1
    spread_forces(pairs, strength, found, force)
    multiply(own.mobility, force, moved)
    for k in range(size):
        own.motion[k] -= moved[k]
        own.load[k] -= force[k]
    return iterations


@compiled
def closing_speeds(pairs: Pairs, motion: Array, speed: Array) -> None:
    """Compute the relative velocity of each pair along its line of centers, positive if it separates."""
    for row in range(len(speed)):
        i, j = pairs.first[row], pairs.second[row]
        along = pairs.along[row, 0] * (motion[2 * j] - motion[2 * i])
        speed[row] = along + pairs.along[row, 1] * (motion[2 * j + 1] - motion[2 * i + 1])


@compiled
def closing_mobility(pairs: Pairs, row: int, mobility: Array) -> float:
    """The relative velocity of a pair by opposite unit forces along its line of centers."""
    i, j, total = pairs.first[row], pairs.second[row], 0.0
    for one in range(2):
        for other in range(2):
            both = mobility[2 * i + one, 2 * i + other] + mobility[2 * j + one, 2 * j + other]
            both -= mobility[2 * i + one, 2 * j + other] + mobility[2 * j + one, 2 * i + other]
            total += pairs.along[row, one] * both * pairs.along[row, other]
    return total


@compiled
def spread_forces(pairs: Pairs, strength: Array, share: Array, force: Array) -> None:
    """Compute the forces along the lines of centers on the floats, equal and opposite."""
    force[:] = 0.0
    for row in range(len(share)):
        i, j, push = pairs.first[row], pairs.second[row], strength[row] * share[row]
        for axis in range(2):
            force[2 * i + axis] -= push * pairs.along[row, axis]
            force[2 * j + axis] += push * pairs.along[row, axis]
