"""Lubrication films between floats: the drag of two floats increases when they approach.

A film opposes the relative velocity along the line of centers with the friction zeta (lambda - 1)/2 of
`drag.pair_factor`, summed over pairs. The two forces of a film cancel to rounding. With films of friction D the
velocities v0 after a kick become v = v0 - M J^T D J v, where M is the mobility of all floats (`coupled.mobility`). This
is solved for psi = D^(1/2) J v, (1 + D^(1/2) J M J^T D^(1/2)) psi = D^(1/2) J v0, by conjugate gradients.

Where floats move one another through the liquid, films are the near field of each pair. The mobility describes two
distant spheres; at small gaps a film also resists their relative motion. Its friction gives two approaching spheres the
exact resistance at any gap: zeta/2 times lambda(l/R) minus the resistance by the mobility alone. Films do not affect a
rigid raft, whose speed follows from the far field.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._jit import admit, compiled
from ecume.engine.cells import Integers
from ecume.engine.contact.contacts import apart
from ecume.engine.neighbors import NeighborLists
from ecume.laws import pair_mobility
from ecume.laws.drag import pair_factor
from ecume.laws.pair_mobility import rotne_prager
from ecume.models.floating.coupled.mobility import MobilityOfEach, apply, closing
from ecume.models.floating.options import Built
from ecume.models.floating.parameters import Parameters, State, Workspace, advance_rows, copy_rows
from ecume.models.liquids import liquid_of
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene

admit(pair_mobility)


NODES = 1024
CLOSEST = 1e-6
"""Smallest gap over R in the table for smooth floats."""

REACH = 4.0
"""The default distance of centers, in radii, beyond which a pair has no film."""

TOLERANCE = 1e-10
"""Residual of the velocities over its initial value."""

MOST_ITERATIONS = 10_000


class Films(NamedTuple):
    """Constants of films."""

    excess: Array
    """(NODES,) lambda - lambda(reach), over the logarithm of gap/R"""
    ends: Array
    """(2,) the first and the last logarithm"""
    reach: float
    """l/R beyond which there is no film"""
    roughness: float = 0.0
    """m: the gap below which no film becomes thinner, whatever the size of the floats"""


class Pairs(NamedTuple):
    """The films of one time step."""

    first: Integers
    second: Integers
    along: Array
    """(P, 2) from the first to the second"""
    friction: Array
    """N s/m"""


def make_films(roughness: float, reach: float, thinnest: float = 0.0) -> Films:
    """Return a table of `pair_factor`, constant below the gap `roughness` (over R), zero at l/R = `reach`. `thinnest`:
    the roughness in m, for floats of several sizes.
    """
    ends = np.log([max(roughness, CLOSEST), reach - 2.0])
    gaps = np.exp(np.linspace(ends[0], ends[1], NODES))
    return Films(np.asarray(pair_factor(2.0 + gaps, roughness)) - float(pair_factor(reach)), ends, reach, thinnest)


@compiled
def film_excess(films: Films, gap: float) -> float:
    """The value of lambda - lambda(reach) at this gap (over R)."""
    ends, excess = films.ends, films.excess
    if gap >= films.reach - 2.0:
        return 0.0
    place = (math.log(max(gap, math.exp(ends[0]))) - ends[0]) / (ends[1] - ends[0]) * (NODES - 1)
    node = min(int(place), NODES - 2)
    return float(excess[node] + (place - node) * (excess[node + 1] - excess[node]))


@compiled
def reduced_float(parameters: Parameters, i: int, j: int) -> tuple[float, float]:
    """The radius (m) and the friction (N s/m) of the two equal floats that represent a pair: twice the reduced radius,
    and the mean friction per radius.
    """
    floats = parameters.floats
    radius = 2.0 * floats.radius[i] * floats.radius[j] / (floats.radius[i] + floats.radius[j])
    drag_i = floats.mass[i] / (floats.relaxation_time[i] * floats.radius[i])
    drag_j = floats.mass[j] / (floats.relaxation_time[j] * floats.radius[j])
    return radius, 0.5 * (drag_i + drag_j) * radius


@compiled
def find_films(films: Films, parameters: Parameters, position: Array, lists: NeighborLists) -> Pairs:
    """All pairs with a film, ordered by the slot of i. Unequal floats are represented by two equal ones of twice the
    reduced radius.
    """
    order, first, neighbor, floats = lists.cells.order, lists.rows.first, lists.rows.neighbor, parameters.floats
    periods = lists.rows.periods
    found, pairs = 0, Pairs(np.empty(0, np.int64), np.empty(0, np.int64), np.empty((0, 2)), np.empty(0))
    for writing in range(2):
        if writing == 1:
            pairs = Pairs(np.empty(found, np.int64), np.empty(found, np.int64), np.empty((found, 2)), np.empty(found))
        found = 0
        for slot in range(len(order)):
            i = order[slot]
            for place in range(first[slot], first[slot + 1]):
                j = order[neighbor[place]]
                x, y = apart(position, i, j, periods)
                distance = math.sqrt(x * x + y * y)
                radius, friction = reduced_float(parameters, i, j)
                gap = (distance - floats.radius[i] - floats.radius[j]) / radius
                if i < j and gap < films.reach - 2.0 and distance > 0.0:
                    if writing == 1:
                        pairs.first[found], pairs.second[found] = i, j
                        pairs.along[found, 0], pairs.along[found, 1] = x / distance, y / distance
                        pairs.friction[found] = 0.5 * friction * film_excess(films, max(gap, films.roughness / radius))
                    found += 1
    return pairs


@compiled
def solve_with_films(mobility: Any, pairs: Pairs, motion: Array, load: Array) -> int:
    """Change the motion by films, and add the forces of the films to those on the floats; return the number of
    iterations.
    """
    total, size = len(pairs.friction), len(motion)
    strength, weight, found = np.empty(total), np.empty(total), np.zeros(total)
    residual, direction, image = np.empty(total), np.empty(total), np.empty(total)
    force, moved, square = np.zeros(size), motion.copy(), 0.0
    closing_speeds(pairs, moved, residual)
    for row in range(total):
        strength[row] = math.sqrt(pairs.friction[row])
        weight[row] = 1.0 / (1.0 + pairs.friction[row] * closing_of(mobility, pairs, row))
        residual[row] *= strength[row]
        direction[row] = weight[row] * residual[row]
        square += residual[row] * direction[row]
    goal, iterations = TOLERANCE * TOLERANCE * square, 0
    while square > goal and iterations < MOST_ITERATIONS:
        spread_forces(pairs, strength, direction, force)
        apply(mobility, force, moved)
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
    apply(mobility, force, moved)
    for k in range(size):
        motion[k] -= moved[k]
        load[k] -= force[k]
    return iterations


@compiled
def closing_speeds(pairs: Pairs, motion: Array, speed: Array) -> None:
    """Compute the relative velocity of each pair along its line of centers, positive if it separates."""
    for row in range(len(speed)):
        i, j = pairs.first[row], pairs.second[row]
        along = pairs.along[row, 0] * (motion[2 * j] - motion[2 * i])
        speed[row] = along + pairs.along[row, 1] * (motion[2 * j + 1] - motion[2 * i + 1])


@compiled
def closing_of(mobility: Any, pairs: Pairs, row: int) -> float:
    """The relative velocity of a pair by opposite unit forces along its line of centers."""
    pair, along = (pairs.first[row], pairs.second[row]), (pairs.along[row, 0], pairs.along[row, 1])
    found: float = closing(mobility, pair, along)
    return found


@compiled
def spread_forces(pairs: Pairs, strength: Array, share: Array, force: Array) -> None:
    """Compute the forces along the lines of centers on the floats, equal and opposite."""
    force[:] = 0.0
    for row in range(len(share)):
        i, j, push = pairs.first[row], pairs.second[row], strength[row] * share[row]
        for axis in range(2):
            force[2 * i + axis] -= push * pairs.along[row, axis]
            force[2 * j + axis] += push * pairs.along[row, axis]


@compiled
def apply_films(
    part: Films, scratch: Any, parameters: Parameters, state: State, workspace: Workspace, first: bool
) -> None:
    """Apply films to the velocities after a kick, and after the first one to the midstep velocities, too."""
    pairs = find_films(part, parameters, state.position, workspace.lists)
    if len(pairs.friction) > 0:
        motion, midstep_velocity = state.velocity.reshape(-1), workspace.midstep_velocity
        # The current moves floats by its change until the middle of the step, too, which is not in the velocities.
        ahead = midstep_velocity[: len(state.velocity)] - state.velocity
        solve_with_films(MobilityOfEach(parameters.kick.gain), pairs, motion, np.zeros(len(motion)))
        if first and not parameters.scheme.drifts_first:
            copy_rows(midstep_velocity, state.velocity)
            advance_rows(midstep_velocity, ahead, 1.0)


def films_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return the films of a scene."""
    films = films_within(parameters, scene, REACH)
    return Built(films, reach=films.reach * float(parameters.floats.radius.max()))


def films_within(parameters: Parameters, scene: FloatingScene, reach: float) -> Films:
    """Return the table of a scene; `reach` is that of films by default, in radii."""
    given = scene.hydrodynamics.lubrication
    assert given is not None  # noqa: S101  # for the type checker: the scene has chosen films
    return make_films(given.roughness / float(parameters.floats.radius.max()), given.cutoff or reach, given.roughness)


FAR_REACH = 6.0
"""The same in addition to the mobility of all floats, which alone is within 0.4 % there."""


class CoupledFilms(NamedTuple):
    """Constants of films in addition to the mobility."""

    films: Films
    viscosity: float
    far: float
    """the resistance of two approaching spheres by the mobility alone where films end, over that of single ones"""


def coupled_films_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return the films of a scene."""
    films = films_within(parameters, scene, FAR_REACH)
    part = CoupledFilms(films, liquid_of(scene).viscosity_of_both, approach_factor(films.reach, 1.0))
    return Built(part, reach=films.reach * float(parameters.floats.radius.max()))


@compiled
def approach_factor(distance: float, radius: float) -> float:
    """The resistance of two equal approaching spheres according to the mobility, over that of single spheres."""
    return 1.0 / (1.0 - radius * rotne_prager(distance, radius, radius)[1])


@compiled
def apply_coupled_films(
    part: CoupledFilms, scratch: Any, parameters: Parameters, state: State, workspace: Workspace, first: bool
) -> None:
    """Apply films to the velocities and midstep velocities."""
    pairs = find_films(part.films, parameters, state.position, workspace.lists)
    subtract_far_field(part, parameters, state.position, pairs)
    if len(pairs.friction) > 0:
        solve_with_films(scratch.mobility, pairs, scratch.motion, scratch.load)
        motion = scratch.motion[: 2 * len(state.velocity)].reshape(-1, 2)
        copy_rows(state.velocity, motion)
        copy_rows(workspace.midstep_velocity, motion)


@compiled
def subtract_far_field(part: CoupledFilms, parameters: Parameters, position: Array, pairs: Pairs) -> None:
    """Subtract the resistance that the mobility contains already; films with less friction than this are removed."""
    for row in range(len(pairs.friction)):
        i, j = pairs.first[row], pairs.second[row]
        x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
        # As in `find_films`, two equal spheres of twice the reduced radius.
        radius, friction = reduced_float(parameters, i, j)
        gap = math.sqrt(x * x + y * y) - parameters.floats.radius[i] - parameters.floats.radius[j]
        size = friction / (3.0 * math.pi * part.viscosity * radius)
        known = approach_factor(2.0 + max(gap, 0.0) / radius, size) - part.far
        pairs.friction[row] = max(pairs.friction[row] - 0.5 * friction * known, 0.0)
