"""The explicit scheme of the paper for a T1 process, for comparison.

The time derivative of the force balance is solved for the velocities of the spheres; positions and gap vectors are
integrated by the second-order Adams-Bashforth formula or by Runge-Kutta schemes. The force balance itself is never
solved, so that the forces drift away from balance, and a step must be as short as the fastest relaxation of a contact,
eta/E. [rognon2009, eq. 16 to 20 and 35 to 49].
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume._portable import exp
from ecume.engine.array_copies import copy_line, copy_rows
from ecume.engine.linear_solvers import block_matrix
from ecume.errors import BadInput
from ecume.laws.arguments import require_positive
from ecume.models.soft.contacts.films import contact_response
from ecume.models.soft.integration.newton import imbalance
from ecume.models.soft.parameters import Contacts
from ecume.models.soft.setup import parameters_of, start
from ecume.models.soft.state import Step, workspace
from ecume.models.soft.t1.cluster import (
    APART,
    DIAGONAL,
    HORIZONTAL,
    LONGEST,
    SQRT3,
    T1,
    VERTICAL,
    Effort,
    Instant,
    goals_of,
    no_goals_reached,
    result_of,
    watch,
)
from ecume.scenes.soft import SoftScene
from ecume.units import Array

ADAMS_BASHFORTH, RUNGE_KUTTA_2, RUNGE_KUTTA_4 = range(3)
SCHEMES = {"paper": ADAMS_BASHFORTH, "rk2": RUNGE_KUTTA_2, "rk4": RUNGE_KUTTA_4}


ROWS = 400
"""Rows of a record that are computed in one call."""
LOOKS = 4000
"""Rows of a record within the closed-form time to separate two spheres."""
MOST_STEPS = 1e9


class Places(NamedTuple):
    """Positions of spheres and gap vectors, or their rates."""

    position: Array
    """(N, d)"""
    gap: Array
    """(C, 3)"""


class Course(NamedTuple):
    """Settings of an integration: time step, ramp of the forces, scheme, and times of output."""

    length: float
    ramp: float
    scheme: int
    every: int
    """steps between two rows of the record"""


@compiled
def look(step: Step, places: Places) -> bool:
    """Compute gaps and directions of gap vectors. Returns False if a gap has vanished."""
    films, radius_sum = step.films, step.pairs.radius_sum
    copy_rows(step.bodies.position, places.position)
    for c in range(len(radius_sum)):
        length = math.sqrt(places.gap[c, 0] ** 2 + places.gap[c, 1] ** 2 + places.gap[c, 2] ** 2)
        if not length > radius_sum[c]:
            return False
        films.log_gap[c] = math.log(length - radius_sum[c])
        for k in range(3):
            films.direction[c, k] = places.gap[c, k] / length
    copy_line(films.log_gap_start, films.log_gap)
    copy_rows(films.direction_start, films.direction)
    return True


@compiled
def velocities(contacts: Contacts, step: Step, places: Places, load_rate: float, found: Places) -> bool:
    """Compute the rates of sphere positions and gap vectors. Films flow under the forces of the surfaces, which remain
    balanced.
    """
    if not look(step, places):
        return False
    films, responses, bodies = step.films, step.responses, step.bodies
    contact_response(contacts, step.pairs, films, bodies.position, 0.0, responses)
    # With starts displaced by the rates, the correction of a response is the rate of the force at fixed centers.
    for c in range(len(films.log_gap)):
        films.log_gap_start[c] += responses.slope[c, 0]
        reach = step.pairs.radius_sum[c] + math.exp(films.log_gap[c])
        opening = math.exp(films.log_gap[c]) * responses.slope[c, 0]
        for k in range(3):
            films.direction_start[c, k] += responses.slope[c, 1 + k]
            found.gap[c, k] = opening * films.direction[c, k] + reach * responses.slope[c, 1 + k]
    contact_response(contacts, step.pairs, films, bodies.position, 0.0, responses)
    copy_rows(responses.force, responses.correction)
    imbalance(step, load_rate, 1.0, False)
    bodies.diagonal[:] = 0.0
    block_matrix.assemble(step.matrix, responses.stiffness, bodies.diagonal)
    right, change = step.borders.right[:1], step.borders.change[:1]
    if not block_matrix.eliminate(step.matrix, right, change, change.shape[2]):
        return False
    copy_rows(found.position, bodies.change)
    return True


@compiled
def displaced(places: Places, by: Places, part: float, to: Places) -> None:
    """Compute positions displaced by a multiple of velocities."""
    for i in range(places.position.shape[0]):
        for k in range(places.position.shape[1]):
            to.position[i, k] = places.position[i, k] + part * by.position[i, k]
    for c in range(places.gap.shape[0]):
        for k in range(3):
            to.gap[c, k] = places.gap[c, k] + part * by.gap[c, k]


@compiled
def one_step(contacts: Contacts, step: Step, course: Course, time: float, kept: tuple[Places, ...]) -> bool:
    """Perform one step of a scheme; `kept` contains positions, trial positions, and the velocities
    of four evaluations.
    """
    places, trial, first, second, third, fourth = kept
    length = course.length
    # The load increases in a step whose middle is within the ramp.
    rate = 1.0 / course.ramp if time + 0.5 * length < course.ramp else 0.0
    if course.scheme == ADAMS_BASHFORTH:
        displaced(first, first, 0.0, second)
        if not velocities(contacts, step, places, rate, first):
            return False
        # Velocities are discontinuous at both ends of the ramp, so that previous velocities cannot be extrapolated
        # across them.
        if time == 0.0 or (rate == 0.0 and time - 0.5 * length < course.ramp):
            displaced(first, first, 0.0, second)
        displaced(places, first, 1.5 * length, trial)
        displaced(trial, second, -0.5 * length, places)
        return True
    good = velocities(contacts, step, places, rate, first)
    displaced(places, first, 0.5 * length, trial)
    good = good and velocities(contacts, step, trial, rate, second)
    if course.scheme == RUNGE_KUTTA_2:
        displaced(places, second, length, places)
        return good
    displaced(places, second, 0.5 * length, trial)
    good = good and velocities(contacts, step, trial, rate, third)
    displaced(places, third, length, trial)
    good = good and velocities(contacts, step, trial, rate, fourth)
    for by, weight in ((first, 1.0), (second, 2.0), (third, 2.0), (fourth, 1.0)):
        displaced(places, by, weight * length / 6.0, places)
    return good


@compiled
def integrate(
    contacts: Contacts, step: Step, course: Course, kept: tuple[Places, ...], begin: int, record: Array
) -> tuple[int, float]:
    """Integrate while filling a record: time, then ln(gap), tension, and tangential force of each
    contact.

    Returns the number of rows before a gap vanished, and the largest residual force on a sphere in them.
    """
    first, films, responses = step.pairs.first, step.films, step.responses
    drift = 0.0
    for row in range(len(record)):
        for k in range(course.every):
            if not one_step(contacts, step, course, (begin + row * course.every + k) * course.length, kept):
                return row, drift
        if not look(step, kept[0]):
            return row, drift
        time = (begin + (row + 1) * course.every) * course.length
        contact_response(contacts, step.pairs, films, step.bodies.position, 0.0, responses)
        drift = max(drift, imbalance(step, min(time / course.ramp, 1.0), 1.0, False)[0])
        record[row, 0] = time
        for c in range(len(first)):
            n, force = films.direction[c], responses.force[c]
            record[row, 1 + 3 * c] = films.log_gap[c]
            record[row, 2 + 3 * c] = n[0] * force[0] + n[1] * force[1] + n[2] * force[2]
            record[row, 3 + 3 * c] = n[1] * force[0] - n[0] * force[1]
    return len(record), drift


def places_like(step: Step) -> Places:
    """Zero arrays for positions and gap vectors."""
    return Places(np.zeros_like(step.bodies.position), np.zeros((len(step.log_gap), 3)))


def places_of(step: Step) -> Places:
    """The positions and gap vectors of a step."""
    reach = step.pairs.radius_sum + exp(step.log_gap)
    return Places(step.bodies.before.copy(), reach[:, None] * step.direction)


def follow(
    scene: SoftScene, forces: tuple[float, float], thresholds: Sequence[float], how: tuple[str, float | None]
) -> T1:
    """Integrate a cluster; `how` contains the scheme and its time step, by default eta/E or a tenth of the ramp."""
    horizontal, vertical = forces
    kappa, ramp = abs(horizontal - vertical / SQRT3), scene.protocol[-1].time
    length = min(kappa, 0.1 * ramp) if how[1] is None else how[1]
    require_positive("time_step", length)
    length = ramp / math.ceil(ramp / length * (1.0 - 1e-9))  # whole steps, so that the ramp ends between two of them
    goals = goals_of(forces, thresholds).tolist()
    course = Course(length, ramp, SCHEMES[how[0]], max(1, round(scene.duration / (LOOKS * 30.0 * length))))
    if scene.duration >= LONGEST or scene.duration / (10.0 * length) > MOST_STEPS:
        raise BadInput(f"steps of {length:.3g} would be more than {MOST_STEPS:.0e}; expected method='implicit'")
    series, seen, steps, drift = list[Instant](), no_goals_reached(goals), 0, 0.0
    for rows, drift in _records(scene, course):
        for now in rows:
            series.append(_instant(now, kappa, scene))
            steps += course.every
            begin = series[-2] if len(series) > 1 else series[-1]._replace(time=0.0, tension_vertical=0.0)
            done = watch(goals, seen, begin, series[-1], _crossing, (begin, series[-1]))
            if done or series[-1].gap_diagonal > APART:
                return result_of(series, list(seen.found), thresholds, kappa, Effort(steps, 0, drift / kappa))
    return result_of(series, list(seen.found), thresholds, kappa, Effort(steps, 0, drift / kappa))


def _records(scene: SoftScene, course: Course) -> Iterator[tuple[Array, float]]:
    """Rows of records, each with the largest imbalance so far, up to the horizon or until a gap vanishes."""
    parameters = parameters_of(scene)
    step = workspace(parameters, start(scene, parameters), 1.0).step
    kept = (places_of(step), *(places_like(step) for _ in range(5)))
    begin, worst = 0, 0.0
    while begin * course.length < scene.duration:
        record = np.zeros((ROWS, 1 + 3 * len(step.log_gap)))
        done, drift = integrate(parameters.contacts, step, course, kept, begin, record)
        worst = max(worst, float(drift))
        yield record[:done], worst
        if done < ROWS:
            return
        begin += ROWS * course.every


def _instant(row: Array, kappa: float, scene: SoftScene) -> Instant:
    gap, tension, slide = (row[1 + k :: 3] for k in range(3))
    # The angle of the gap vectors: that of the centers differs by the deflections.
    across, along = 2.0 + exp(gap[[HORIZONTAL, VERTICAL]])
    return Instant(
        time=float(row[0]),
        angle=math.atan2(along, across),
        gap_horizontal=math.exp(gap[HORIZONTAL]),
        gap_vertical=math.exp(gap[VERTICAL]),
        gap_diagonal=math.exp(gap[DIAGONAL]),
        tension_horizontal=float(tension[HORIZONTAL]) / kappa,
        tension_vertical=float(tension[VERTICAL]) / kappa,
        tension_diagonal=float(tension[DIAGONAL]) / kappa,
        sliding_force=float(slide[DIAGONAL]) / kappa,
    )


def _crossing(given: tuple[Instant, Instant], goal: float) -> float:
    """The time at which a force is reached between two rows, by linear interpolation."""
    before, after = given
    low, high = -before.tension_vertical, -after.tension_vertical
    part = (goal - low) / (high - low) if low < goal < high else 1.0
    return before.time + part * (after.time - before.time)
