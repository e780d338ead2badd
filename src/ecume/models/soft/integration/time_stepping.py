"""Time integration with adaptive steps, which end at frames and at corners of the protocol."""

from __future__ import annotations

import math

import numpy as np

from ecume.errors import Diverged
from ecume.models.model import CROWDED, DIVERGED, DONE
from ecume.models.soft.cell import box_of
from ecume.models.soft.contacts.contact_list import new_pairs, update_contact_list, wall_gaps
from ecume.models.soft.contacts.tree_search import PairList
from ecume.models.soft.contacts.walls import Walls
from ecume.models.soft.integration.dirk import FAILED as NOT_SOLVED
from ecume.models.soft.integration.dirk import accept, reset_to_start
from ecume.models.soft.integration.dirk_schemes import LOOSE, SCHEMES, Scheme, error_of_run
from ecume.models.soft.integration.linear_solvers import attempt, balance, begin_step
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.protocol import drive_at, interval_at, next_turn, rules_at
from ecume.models.soft.report.energy_budget import (
    DRAG,
    FILMS,
    INJECTED,
    SIZE,
    elastic_energy,
    elastic_energy_at_end,
    energy_of_faded,
    remote_energy,
    stake,
)
from ecume.models.soft.report.observation import deflections, is_beyond, remedy, worst_contact
from ecume.models.soft.state import (
    ACCEPTED,
    CLOCK,
    FAILED,
    LENGTH,
    PAST_ERROR,
    REJECTED,
    State,
    Step,
    StepRequest,
    Workspace,
    store,
    workspace,
)
from ecume.units import Array

SAFETY = 0.9
MOST_GROWTH, MOST_SHRINK = 5.0, 0.2
AFTER_FAILURE = 0.25
"""The factor of the next time step after the equations of a step could not be solved."""
LEAST_ERROR = 1e-8
MOST_TRIES = 60
"""The number of attempts of a step, each with a shorter time step, before the run ends."""
LEAST_PER_CYCLE, COARSE = 20, 1e-3
"""The least number of time steps per cycle of an oscillation, at tolerances of COARSE or more. A sine is then as
accurate as the gaps.
"""
AFTER_JUMP = 1e-6
"""The first step after a jump, over the time between frames; earlier steps contain no information on the relaxation."""
PER_AGE = 16.0
"""The longest step over the time since a jump is (PER_AGE tolerance)^(1/(p + 1)). After a jump films relax at all
rates. The widest relax first; their gaps change little, so that the error of gaps does not limit the error of the work.
"""
WORK_TRIES, PART_OF_RUN = 4, 0.01
"""The number of attempts to reduce the residual of the energy budget of a step, relative to the energy exchanged in the
step plus PART_OF_RUN times that exchanged in the run.
"""
SHRINK_FOR_WORK = 0.01, 0.5
"""The least and the largest factor of the length of a step whose energy budget has too large a residual."""
LEAST_WORK = 1e-14
"""The rounding error of a work, over modulus times radius cubed, summed over the spheres."""
NARROW = 0.5
"""A new contact with a gap below NARROW times the reach of films was missed by a too long step."""
NEARLY = 1e-9
"""A step that would end before a frame or corner by less than this fraction of its length is extended to it."""


def advance(parameters: Parameters, state: State, scratch: Workspace, steps: int) -> int:
    """Integrate over at least that many ticks, but not past a frame; one step for 0 ticks. Returns `CROWDED` if
    contacts opened or closed.
    """
    if scratch.generation != state.generation[0]:
        return CROWDED
    until = int(state.step[0]) + steps
    while True:
        opened = one_step(parameters, state, scratch)
        if opened is None or not jump(parameters, state, scratch):
            return DIVERGED
        lost = energy_of_faded(parameters.contacts, scratch.step)
        if len(state.budget):
            state.budget[FILMS] += lost
        if update_contacts(parameters, state, None if jumps_now(parameters, state) else opened):
            if lost > 0.0:
                rebalance(parameters, state)
            return CROWDED
        if state.step[0] >= until or state.step[0] % parameters.steps_per_frame == 0:
            return DONE


def update_contacts(parameters: Parameters, state: State, opened: PairList | None) -> bool:
    """Open and close contacts. Returns whether any changed. If spheres meet without a film while deflections are beyond
    the range of the contact laws, the message of Diverged names these as the cause.
    """
    try:
        return update_contact_list(parameters, state, opened)
    except Diverged as error:
        found = deflections(parameters, state)
        if not is_beyond(found):
            raise
        what = str(error).split(";")[0]
        raise Diverged(f"{what}; {worst_contact(found)}: {remedy(found, parameters.contacts)}") from None


def rebalance(parameters: Parameters, state: State) -> None:
    """Balance the forces again at constant gaps after contacts with a small force have faded; the films dissipate the
    released energy. If that fails, the next step starts from the present positions.
    """
    scratch, now = workspace(parameters, state, 1.0), float(state.pace[CLOCK])
    interval = interval_at(parameters.protocol, now)
    drive = drive_at(parameters.protocol, now, interval)
    begin_step(parameters, scratch.step, drive)
    before = elastic_energy(parameters.contacts, scratch.step)
    if not balance(parameters, scratch, (drive, drive, rules_at(parameters.protocol, interval)), state.effort):
        return
    accept(scratch.step)
    store(parameters, state, scratch.step)
    if len(state.budget):
        state.budget[FILMS] += before - elastic_energy(parameters.contacts, scratch.step)


def one_step(parameters: Parameters, state: State, scratch: Workspace) -> PairList | None:
    """Repeat a step with shorter time steps until its error is small enough, and accept it. Returns the new contacts at
    its end, or None without success.
    """
    scheme, step, tries = SCHEMES[parameters.scheme].tableau, scratch.step, WORK_TRIES if len(state.budget) else 0
    reset_to_start(step, drive_at(parameters.protocol, float(state.pace[CLOCK])))
    before = elastic_energy(parameters.contacts, step) + remote_energy(parameters.contacts, step)
    for _ in range(MOST_TRIES):
        length, end = _next(parameters, state)
        if not end > state.pace[CLOCK]:
            break
        interval = interval_at(parameters.protocol, float(state.pace[CLOCK]))
        during = StepRequest(length, _drives(parameters, state, (length, end)), parameters.tolerance)
        error = attempt(parameters, scratch, during, rules_at(parameters.protocol, interval), state.effort)
        ratio = max(error / parameters.tolerance, LEAST_ERROR)
        if error == NOT_SOLVED or not math.isfinite(error):
            state.pace[LENGTH] = AFTER_FAILURE * length
            state.tally[FAILED] += 1
        elif ratio > 1.0:
            state.pace[LENGTH] = length * max(MOST_SHRINK, SAFETY * ratio ** (-1.0 / scheme.order))
            state.tally[REJECTED] += 1
        elif missed_contact(parameters, scratch.step, opened := new_contacts(parameters, scratch.step)):
            state.pace[LENGTH] = 0.5 * length
            state.tally[REJECTED] += 1
        elif tries > 0 and (excess := missed_work(parameters, state, step, before)) > 1.0:
            state.pace[LENGTH] = length * float(np.clip(SAFETY / excess, *SHRINK_FOR_WORK))
            state.tally[REJECTED], tries = state.tally[REJECTED] + 1, tries - 1
        else:
            if len(state.budget):
                state.budget[:] += scratch.step.budget.lines[-1, : len(state.budget)]
            _take(parameters, state, scratch, end)
            # The error of a step that ends early at a frame does not limit the next step.
            state.pace[LENGTH] = max(
                _grown(state, length, ratio, scheme), state.pace[LENGTH] * (length < state.pace[LENGTH])
            )
            state.pace[PAST_ERROR] = ratio
            return opened
    return None


def missed_work(parameters: Parameters, state: State, step: Step, before: float) -> float:
    """The residual of the energy budget of a step, over its limit; `before` is the stored energy at
    its start (J).

    Where a film has just opened, or a load has begun, forces relax in a time far below that in which gaps change. Gaps
    are then exact to the tolerance while the power at the stages is not that of the step.
    """
    contacts, line = parameters.contacts, step.budget.lines[-1]
    grown = elastic_energy_at_end(contacts, step) + remote_energy(contacts, step) - before
    dissipated = line[FILMS] + line[DRAG]
    missing = abs(line[INJECTED] - dissipated - line[SIZE] - grown)
    if not math.isfinite(missing):
        return math.inf
    spent = float(state.budget[FILMS] + state.budget[DRAG])
    moved = abs(dissipated) + abs(grown) + PART_OF_RUN * (spent + stake(step))
    rounding = LEAST_WORK * float((parameters.modulus * parameters.radius**3).sum())
    allowed = error_of_run(parameters.scheme, parameters.tolerance) / LOOSE
    return float(missing / (allowed * moved + rounding))


def new_contacts(parameters: Parameters, step: Step) -> PairList:
    """The pairs that need a film at the end of a step and have none."""
    box = box_of(parameters.box, step.cell.shape, parameters.dimensions)
    pair = np.stack([step.pairs.first, step.pairs.second], axis=1)
    image = step.pairs.image[:, : parameters.dimensions].astype(np.int64)
    return new_pairs(parameters, step.bodies.position, box, (pair, image))


def missed_contact(parameters: Parameters, step: Step, opened: PairList) -> bool:
    """Whether a gap is narrower than a new contact should have, so that its film should have appeared in an earlier
    step.
    """
    if step.walls and missed_wall_contact(parameters, step, step.walls):
        return True
    reach, moved = parameters.contacts.fade_from, step.bodies.position - step.bodies.before
    if 2.0 * float(np.linalg.norm(moved - moved.mean(axis=0), axis=1).max()) < (1.0 - NARROW) * reach:
        return False
    pair, _, between = opened
    gap = np.linalg.norm(between, axis=1) - parameters.radius[pair].sum(axis=1)
    return bool((gap < NARROW * reach).any())


def missed_wall_contact(parameters: Parameters, step: Step, walls: Walls) -> bool:
    """Whether a sphere is closer to a wall than a new contact should be."""
    touching = np.zeros((len(step.bodies.position), len(parameters.walls.modulus)), np.bool_)
    touching[walls.touches.first, walls.touches.wall] = True
    close = wall_gaps(parameters, step.bodies.position, walls.places.place) < NARROW * parameters.contacts.fade_from
    return bool((~touching & close).any())


def _drives(parameters: Parameters, state: State, way: tuple[float, float]) -> Array:
    """The imposed values at each stage of a step; at its end the values before a jump there."""
    protocol, now = parameters.protocol, float(state.pace[CLOCK])
    interval, (length, end) = interval_at(protocol, now), way
    times = [now + part * length for part in SCHEMES[parameters.scheme].tableau.times[:-1]]
    return np.array([drive_at(protocol, time, interval) for time in (*times, end)])


def jump(parameters: Parameters, state: State, scratch: Workspace) -> bool:
    """Balance forces at constant gaps if the protocol jumps at this time. Returns False without a
    balance.

    A jump is the limit of a fast ramp: all its work is stored in deflections.
    """
    if not jumps_now(parameters, state):
        return True
    protocol, now = parameters.protocol, float(state.pace[CLOCK])
    interval = interval_at(protocol, now)
    origin, drive = drive_at(protocol, now, interval - 1), drive_at(protocol, now, interval)
    at = (origin, drive, rules_at(protocol, interval))
    before = elastic_energy(parameters.contacts, scratch.step)
    if not balance(parameters, scratch, at, state.effort):
        return False
    accept(scratch.step)
    store(parameters, state, scratch.step)
    if len(state.budget):
        state.budget[INJECTED] += elastic_energy(parameters.contacts, scratch.step) - before
    first = AFTER_JUMP * parameters.time_step * parameters.steps_per_frame
    state.pace[LENGTH], state.pace[PAST_ERROR] = min(first, float(state.pace[LENGTH])), 0.0
    return True


def jumps_now(parameters: Parameters, state: State) -> bool:
    """Whether the protocol jumps at this time."""
    protocol, now = parameters.protocol, float(state.pace[CLOCK])
    interval = interval_at(protocol, now)
    return interval != 0 and now == protocol.times[interval] and bool(protocol.jumps[interval])


def _grown(state: State, length: float, ratio: float, scheme: Scheme) -> float:
    """The length of the next step, from the errors of this step and the previous one (a PI controller)."""
    past = float(state.pace[PAST_ERROR]) or 1.0
    growth = SAFETY * ratio ** (-0.7 / scheme.order) * past ** (0.4 / scheme.order)
    return length * float(min(MOST_GROWTH, max(MOST_SHRINK, growth)))


def _take(parameters: Parameters, state: State, scratch: Workspace, end: float) -> None:
    """Copy the accepted step to the state."""
    accept(scratch.step)
    length = end - float(state.pace[CLOCK])
    state.velocity[:] = (scratch.step.bodies.before - state.position) / length
    if state.spin.shape[1]:
        state.spin[:] = scratch.step.spins.turn / (length * parameters.radius[:, None])
    store(parameters, state, scratch.step)
    state.pace[CLOCK] = end
    state.tally[ACCEPTED] += 1
    state.step[0] = _tick(parameters, int(state.step[0]), end)


def _due(parameters: Parameters, frame: int) -> float:
    """The time of a frame (s); that of the last is the end of the run."""
    return min(frame * parameters.steps_per_frame * parameters.time_step, parameters.end)


def _tick(parameters: Parameters, before: int, time: float) -> int:
    """The tick of a time; between two frames it never equals that of a frame."""
    frame = before // parameters.steps_per_frame
    first, last = frame * parameters.steps_per_frame, (frame + 1) * parameters.steps_per_frame
    if parameters.end < math.inf:
        last = min(last, parameters.last_tick)
    if time == _due(parameters, frame + 1):
        return last
    return min(max(int(time / parameters.time_step), before, first + 1), last - 1)


def _longest(parameters: Parameters, now: float) -> float:
    """The longest next step (s): a part of a cycle during oscillations, which the error of films does not predict.
    After a jump, or a start under a stress, also a part of the time since then.
    """
    protocol, interval = parameters.protocol, interval_at(parameters.protocol, now)
    pace, age = float(protocol.waves[interval, 2]), now - float(protocol.times[interval])
    cycle = math.tau / pace / steps_per_cycle(parameters) if pace > 0.0 else math.inf
    leaps = protocol.jumps[interval] and (interval > 0 or any(rules_at(protocol, interval)))
    return min(cycle, step_per_age(parameters) * age) if leaps and age > 0.0 else cycle


def step_per_age(parameters: Parameters) -> float:
    """The longest step after a jump, over the time since the jump."""
    order = SCHEMES[parameters.scheme].tableau.order
    return float((PER_AGE * parameters.tolerance) ** (1.0 / (order + 1.0)))


def steps_per_cycle(parameters: Parameters) -> float:
    """The minimum number of steps per cycle, proportional to tolerance^(-1/(p + 1)) for a scheme of order p."""
    order = SCHEMES[parameters.scheme].tableau.order
    return float(LEAST_PER_CYCLE * max(COARSE / parameters.tolerance, 1.0) ** (1.0 / (order + 1.0)))


def _next(parameters: Parameters, state: State) -> tuple[float, float]:
    """The length of the next step and the time of its end, at most that of the next frame or corner of the protocol."""
    now = float(state.pace[CLOCK])
    due = _due(parameters, int(state.step[0]) // parameters.steps_per_frame + 1)
    stop = min(due, next_turn(parameters.protocol, now))
    length = min(float(state.pace[LENGTH]), _longest(parameters, now))
    if now + length * (1.0 + NEARLY) >= stop:
        return stop - now, stop
    return length, now + length
