"""Steps of a cluster of four spheres, by their positions, until its vertical pair carries the forces.

Python runs these functions and calls the compiled attempt of a step; for pages all functions are compiled.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume.engine.root_finding import root_between
from ecume.models.soft.contacts.films import Films, stored_energy
from ecume.models.soft.contacts.rotation import carry
from ecume.models.soft.integration import dirk
from ecume.models.soft.integration.step_control import (
    Control,
    Pace,
    control_of,
    drives_of,
    for_work,
    go_to_end,
    missing_work,
    shortened_until_exact,
    work_scale,
)
from ecume.models.soft.parameters import Contacts, Parameters
from ecume.models.soft.protocol import drive_at, interval_at
from ecume.models.soft.report.energy_budget import DRAG, FILMS, across_energy, stake_of
from ecume.models.soft.state import CLOCK, State, Step, StepRequest
from ecume.models.soft.t1.cluster import (
    APART,
    DIAGONAL,
    DIAGONALS,
    HORIZONTAL,
    VERTICAL,
    Instant,
    ReachedGoals,
    Units,
    no_goals_reached,
    watch,
)
from ecume.units import Array

WORK_TRIES = 4
"""Attempts to make the energy budget of a step as exact as that of a run: see `step_control`."""
CLOSE, NEAR_START = 1e-13, 1e-9
"""The accuracy of the time of a threshold over the step, and the part of the step at which the search begins."""
GOING_ON, ENDED, STUCK = range(3)
"""All goals are reached, the cluster has dissociated, or its time is over; or no step is short enough."""


class Start(NamedTuple):
    """The start of a step, which can be restored."""

    position: Array
    log_gap: Array
    direction: Array


class Cluster(NamedTuple):
    """A cluster with all quantities that pages need."""

    contacts: Contacts
    step: Step
    control: Control
    now: Pace
    budget: Array
    """(4,) J, as in `State`"""
    scale: tuple[float, float]
    """that of `work_scale`"""
    start: Array
    """(3,) of a step: its time (s), what is stored (J), and how often its budget may still make it shorter"""
    before: Start
    """of the last step"""
    after: Start
    """of the next one"""
    axes: Array
    """(2, 2) of the cluster's symmetry"""
    units: Units
    goals: Array
    seen: ReachedGoals
    instants: Array
    """(2, 9) the fields of an `Instant`: at the start of the last step, and now"""


def cluster_of(parameters: Parameters, state: State, step: Step, units: Units, goals: Array) -> Cluster:
    """The cluster, for which `begin` must be called next."""
    across = state.position[1] - state.position[0]
    axes = np.array([[across[0], across[1]], [-across[1], across[0]]]) / math.hypot(across[0], across[1])
    before, after = (Start(step.bodies.before.copy(), step.log_gap.copy(), step.direction.copy()) for _ in range(2))
    return Cluster(
        parameters.contacts, step, control_of(parameters), Pace(state.pace, state.tally, state.step), state.budget,
        work_scale(parameters), np.zeros(3), before, after, axes, units, goals,
        no_goals_reached(goals.tolist()), np.zeros((2, len(Instant._fields))),
    )  # fmt: skip


def begin(cluster: Cluster) -> None:
    """Compute the forces in the initial state at rest."""
    request = StepRequest(0.0, drives_of(cluster.control, 0.0, 0.0, 0.0), cluster.control.tolerance)
    dirk.step_dense(cluster.contacts, cluster.step, cluster.control.scheme, request, dirk.BEGIN)
    note(cluster, instant_at(cluster.step, 0.0, cluster.units))


def follow_step(cluster: Cluster) -> int:
    """Integrate over a step, and record the goals that are reached. Returns GOING_ON, ENDED or STUCK."""
    if not take_step(cluster):
        return STUCK
    return ENDED if has_ended(cluster) else GOING_ON


def take_step(cluster: Cluster) -> bool:
    """Integrate over a step. Returns False if no step was short enough."""
    step, now, control = cluster.step, cluster.now, cluster.control
    start = float(now.pace[CLOCK])
    keep(cluster.before, step)
    dirk.reset_to_start(step, drive_at(control.protocol, start, interval_at(control.protocol, start)))
    cluster.start[0], cluster.start[1], cluster.start[2] = start, energy(cluster, step.films), WORK_TRIES
    found = shortened_until_exact(attempted, shortening, cluster, control, now)
    if found.length == 0.0:
        return False
    for k in range(len(cluster.budget)):
        cluster.budget[k] += step.budget.lines[len(step.budget.lines) - 1, k]
    dirk.accept(step)
    go_to_end(control, now, found)
    cluster.instants[0] = cluster.instants[1]
    note(cluster, instant_at(step, now.pace[CLOCK] / cluster.units.time, cluster.units))
    mirror(step, cluster.axes)
    return True


def has_ended(cluster: Cluster) -> bool:
    """Record the goals that the last step reached; return whether the process has ended."""
    begin, end = noted(cluster, 0), noted(cluster, 1)
    if watch(cluster.goals, cluster.seen, begin, end, crossing, cluster):
        return True
    return bool(end.gap_diagonal > APART or cluster.now.step[0] >= cluster.control.steps_per_frame)


def attempted(cluster: Cluster, length: float, end: float) -> float:
    """The error of a step from the present state, or `dirk.FAILED`."""
    return tried(cluster, float(cluster.now.pace[CLOCK]), length, end)


def tried(cluster: Cluster, start: float, length: float, end: float) -> float:
    """The error of a step, or `dirk.FAILED`."""
    control = cluster.control
    during = StepRequest(length, drives_of(control, start, length, end), control.tolerance)
    return float(dirk.step_dense(cluster.contacts, cluster.step, control.scheme, during, dirk.STEP))


def shortening(cluster: Cluster) -> float:
    """The factor of the length of a step whose energy budget is not exact; 1 for others."""
    step, films = cluster.step, cluster.step.films
    if cluster.start[2] <= 0.0:
        return 1.0
    direction = films.direction.copy()
    carry(step.pairs.turn, direction)
    at_end = Films(films.log_gap, direction, films.log_gap_start, films.direction_start)
    grown = energy(cluster, at_end) - cluster.start[1]
    stake = stake_of(step.responses.force, films.direction, gaps_of(films), step.pairs.radius_sum)
    spent = cluster.budget[FILMS] + cluster.budget[DRAG] + stake
    excess = missing_work(step.budget.lines[len(step.budget.lines) - 1], grown, spent, cluster.scale)
    if excess > 1.0:
        cluster.start[2] -= 1.0
        return for_work(excess)
    return 1.0


def energy(cluster: Cluster, films: Films) -> float:
    """The energy (J) of deflections and of long-range forces."""
    contacts, pairs = cluster.contacts, cluster.step.pairs
    stored = stored_energy(contacts, pairs, films, cluster.step.bodies.position)
    return stored + across_energy(contacts, films.log_gap, pairs.reduced_radius)


def gaps_of(films: Films) -> Array:
    """The gaps of films."""
    gap = np.empty_like(films.log_gap)
    for c in range(len(gap)):
        gap[c] = math.exp(films.log_gap[c])
    return gap


def keep(to: Start, step: Step) -> None:
    """Store the start of a step."""
    to.position[:], to.log_gap[:], to.direction[:] = step.bodies.before, step.log_gap, step.direction


def go_back(to: Start, step: Step) -> None:
    """Restore the start of a step."""
    step.bodies.before[:], step.log_gap[:], step.direction[:] = to.position, to.log_gap, to.direction


def mirror(step: Step, axes: Array) -> None:
    """Remove the rounding errors of the two mirror symmetries of the cluster.

    Forces with fixed directions make a compressed cluster unstable against rotation, like a rod that is compressed
    between two points. An asymmetry of 1e-16 grows to a rotation in processes of 1e5 time units.
    """
    place, direction, log_gap = step.bodies.before, step.direction, step.log_gap
    rotate(place, axes)
    rotate(direction, axes)
    average(place, 0, 2)
    average(place, 2, 4)
    average(direction, DIAGONALS[0], DIAGONALS[-1] + 1)
    place[:2, 1] = 0.0
    place[2:, 0] = 0.0
    direction[HORIZONTAL, 1] = direction[VERTICAL, 0] = 0.0
    log_gap[DIAGONALS[0] : DIAGONALS[-1] + 1] = log_gap[DIAGONALS[0] : DIAGONALS[-1] + 1].mean()
    rotate(place, axes.T)
    rotate(direction, axes.T)
    for c in range(len(direction)):
        size = math.sqrt(direction[c, 0] * direction[c, 0] + direction[c, 1] * direction[c, 1])
        direction[c, 0] /= size
        direction[c, 1] /= size


def rotate(vectors: Array, axes: Array) -> None:
    """Replace vectors by their components along two axes."""
    for i in range(len(vectors)):
        x, y = vectors[i, 0], vectors[i, 1]
        vectors[i, 0], vectors[i, 1] = x * axes[0, 0] + y * axes[0, 1], x * axes[1, 0] + y * axes[1, 1]


def average(vectors: Array, first: int, end: int) -> None:
    """Replace the magnitudes of components of some vectors by their mean."""
    for k in range(2):
        mean = np.abs(vectors[first:end, k]).sum() / (end - first)
        for i in range(first, end):
            vectors[i, k] = np.sign(vectors[i, k]) * mean


def instant_at(step: Step, time: float, units: Units) -> Instant:
    """The state at the end of a step, from the last solution in `films` and `responses`."""
    gap, force, direction = gaps_of(step.films), step.responses.force, step.films.direction
    x, y = direction[DIAGONAL, 0], direction[DIAGONAL, 1]
    place = step.bodies.position
    across, along = place[1] - place[0], place[2] - place[0]
    angle = math.atan2(across[0] * along[1] - across[1] * along[0], across[0] * along[0] + across[1] * along[1])
    return Instant(
        time,
        angle,
        gap[HORIZONTAL] / units.length,
        gap[VERTICAL] / units.length,
        gap[DIAGONAL] / units.length,
        tension(force, direction, HORIZONTAL) / units.force,
        tension(force, direction, VERTICAL) / units.force,
        tension(force, direction, DIAGONAL) / units.force,
        (force[DIAGONAL, 0] * y - force[DIAGONAL, 1] * x) / units.force,
    )


def tension(force: Array, direction: Array, c: int) -> float:
    """The force of a contact along its direction."""
    f, n = force[c], direction[c]
    return float(f[0] * n[0] + f[1] * n[1] + f[2] * n[2])


def note(cluster: Cluster, instant: Instant) -> None:
    """Store the present instant as numbers."""
    for k in range(len(instant)):
        cluster.instants[1, k] = instant[k]


def noted(cluster: Cluster, which: int) -> Instant:
    """An instant that was stored."""
    row = cluster.instants[which]
    return Instant(row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8])


def crossing(cluster: Cluster, goal: float) -> float:
    """The time within the last step at which the vertical pair carries the force `goal`, found by shorter steps."""
    start = float(cluster.start[0])
    keep(cluster.after, cluster.step)
    length = cluster.now.pace[CLOCK] - start
    at = (cluster, start, goal)
    if lacking(at, NEAR_START * length) > 0.0 > lacking(at, length):
        length = root_between(lacking, at, (NEAR_START * length, length), CLOSE * length)
    go_back(cluster.after, cluster.step)
    return float((start + length) / cluster.units.time)


def lacking(at: tuple[Cluster, float, float], length: float) -> float:
    """The goal minus the force of the vertical pair after a step of this length."""
    cluster, start, goal = at
    go_back(cluster.before, cluster.step)
    tried(cluster, start, length, start + length)
    return float(goal + instant_at(cluster.step, 0.0, cluster.units).tension_vertical)
