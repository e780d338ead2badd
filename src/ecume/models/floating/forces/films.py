"""Lubrication films between floats: the drag of two floats increases when they approach.

A film opposes the relative velocity along the line of centers with the friction zeta (lambda - 1)/2 of
`drag.pair_factor`, summed over pairs. The velocities are the solution of the linear system (1/g + G) v = v0/g, where v0
are the velocities after the kick without films, g is its gain and G the friction of the films, by conjugate gradients.
The two forces of a film cancel to rounding.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.engine.contact.contacts import apart
from ecume.engine.neighbors import NeighborLists
from ecume.laws.drag import pair_factor
from ecume.models.floating.options import Built
from ecume.models.floating.parameters import Parameters, State, Workspace, copy_rows
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


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
def film_forces(pairs: Pairs, velocity: Array, force: Array) -> None:
    """Compute the forces of the films, equal and opposite."""
    for i in range(force.shape[0]):
        force[i, 0], force[i, 1] = 0.0, 0.0
    first, second, along, friction = pairs.first, pairs.second, pairs.along, pairs.friction
    for row in range(len(friction)):
        i, j, x, y = first[row], second[row], along[row, 0], along[row, 1]
        apart = (velocity[j, 0] - velocity[i, 0]) * x + (velocity[j, 1] - velocity[i, 1]) * y
        pull = friction[row] * apart
        force[i, 0] += pull * x
        force[i, 1] += pull * y
        force[j, 0] -= pull * x
        force[j, 1] -= pull * y


@compiled
def solve_velocities(pairs: Pairs, gain: Array, velocity: Array) -> int:
    """Solve for the velocities with films from those without; return the number of iterations."""
    count = velocity.shape[0]
    given, slowed, force = velocity.copy(), velocity.copy(), np.zeros((count, 2))
    residual, direction = np.zeros((count, 2)), np.zeros((count, 2))
    film_forces(pairs, slowed, residual)
    square, iterations = 0.0, 0
    for i in range(count):
        direction[i, 0], direction[i, 1] = gain[i] * residual[i, 0], gain[i] * residual[i, 1]
        square += residual[i, 0] * direction[i, 0] + residual[i, 1] * direction[i, 1]
    goal = TOLERANCE * TOLERANCE * square
    while square > goal and iterations < MOST_ITERATIONS:
        film_forces(pairs, direction, force)
        curvature = 0.0
        for i in range(count):
            force[i, 0] = direction[i, 0] / gain[i] - force[i, 0]
            force[i, 1] = direction[i, 1] / gain[i] - force[i, 1]
            curvature += direction[i, 0] * force[i, 0] + direction[i, 1] * force[i, 1]
        length, last, square = square / curvature, square, 0.0
        for i in range(count):
            for axis in range(2):
                slowed[i, axis] += length * direction[i, axis]
                residual[i, axis] -= length * force[i, axis]
                square += residual[i, axis] * residual[i, axis] * gain[i]
        for i in range(count):
            direction[i, 0] = gain[i] * residual[i, 0] + square / last * direction[i, 0]
            direction[i, 1] = gain[i] * residual[i, 1] + square / last * direction[i, 1]
        iterations += 1
    # The velocities follow from the forces of the films, so that momentum is conserved to rounding for any number of
    # iterations.
    film_forces(pairs, slowed, force)
    for i in range(count):
        velocity[i, 0] = given[i, 0] + gain[i] * force[i, 0]
        velocity[i, 1] = given[i, 1] + gain[i] * force[i, 1]
    return iterations


@compiled
def apply_films(part: Films, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Apply films to the velocities after a kick and to the midstep velocities."""
    pairs = find_films(part, parameters, state.position, workspace.lists)
    if len(pairs.friction) > 0:
        solve_velocities(pairs, parameters.kick.gain, state.velocity)
        copy_rows(workspace.midstep_velocity, state.velocity)


def films_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return the films of a scene."""
    films = films_within(parameters, scene, REACH)
    return Built(films, reach=films.reach * float(parameters.floats.radius.max()))


def films_within(parameters: Parameters, scene: FloatingScene, reach: float) -> Films:
    """Return the table of a scene; `reach` is that of films by default, in radii."""
    given = scene.hydrodynamics.lubrication
    assert given is not None  # noqa: S101  # for the type checker: the scene has chosen films
    return make_films(given.roughness / float(parameters.floats.radius.max()), given.cutoff or reach, given.roughness)
