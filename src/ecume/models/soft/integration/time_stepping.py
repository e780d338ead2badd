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
from ecume.models.soft.integration.dirk import accept, reset_to_start
from ecume.models.soft.integration.dirk_schemes import LOOSE, error_of_run
from ecume.models.soft.integration.linear_solvers import attempt, balance, begin_step
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
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.protocol import drive_at, interval_at, rules_at
from ecume.models.soft.report.energy_budget import (
    DRAG,
    FILMS,
    INJECTED,
    elastic_energy,
    elastic_energy_at_end,
    energy_of_faded,
    remote_energy,
    stake,
)
from ecume.models.soft.report.observation import deflections, is_beyond, remedy, worst_contact
from ecume.models.soft.state import (
    CLOCK,
    LENGTH,
    PAST_ERROR,
    State,
    Step,
    StepRequest,
    Workspace,
    store,
    workspace,
)
from ecume.units import Array

AFTER_JUMP = 1e-6
"""The first step after a jump, over the time between frames; earlier steps contain no information on the relaxation."""
WORK_TRIES = 4
"""Attempts to make the energy budget of a step as exact as that of a run: see `step_control`."""
LEAST_PART, MOST_PART = 0.05, 0.95
"""The least and the largest factor of the length of a step that ends where a film opens."""


def advance(parameters: Parameters, state: State, scratch: Workspace, steps: int) -> int:
    """Integrate over at least this number of ticks, but not past a frame; for 0 ticks, one step. Returns `CROWDED` if
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
    the range of the contact laws, the message of Diverged states the deflections as the cause.
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
    step, control, now = scratch.step, control_of(parameters), Pace(state.pace, state.tally, state.step)
    reset_to_start(step, drive_at(parameters.protocol, float(state.pace[CLOCK])))
    tried = Tried(parameters, state, scratch, control, WORK_TRIES if len(state.budget) else 0)
    found = shortened_until_exact(attempted, shortening, tried, control, now)
    if found.length == 0.0:
        return None
    if len(state.budget):
        state.budget[:] += step.budget.lines[-1, : len(state.budget)]
    _take(parameters, state, scratch, found.end)
    go_to_end(control, now, found)
    return tried.opened


class Tried:
    """A step that is tried."""

    def __init__(self, parameters: Parameters, state: State, scratch: Workspace, control: Control, tries: int) -> None:
        self.parameters, self.state, self.scratch, self.control, self.tries = parameters, state, scratch, control, tries
        contacts, step = parameters.contacts, scratch.step
        self.before = elastic_energy(contacts, step) + remote_energy(contacts, step)
        self.opened: PairList


def attempted(tried: Tried, length: float, end: float) -> float:
    """The error of a step, or `dirk.FAILED`."""
    parameters, state, control = tried.parameters, tried.state, tried.control
    start = float(state.pace[CLOCK])
    during = StepRequest(length, drives_of(control, start, length, end), parameters.tolerance)
    rules = rules_at(parameters.protocol, interval_at(parameters.protocol, start))
    return attempt(parameters, tried.scratch, during, rules, state.effort)


def shortening(tried: Tried) -> float:
    """The factor of the length of a step in which a contact should have opened, or whose energy budget is not exact;
    otherwise 1.
    """
    parameters, step = tried.parameters, tried.scratch.step
    tried.opened = new_contacts(parameters, step)
    if (part := part_until_contacts(parameters, step, tried.opened)) < 1.0:
        return part
    if tried.tries > 0 and (excess := missed_work(tried)) > 1.0:
        tried.tries -= 1
        # A power of two: the residual is a difference of large terms, and its rounding error must not affect the
        # lengths of later steps.
        return 2.0 ** math.floor(math.log2(for_work(excess)))
    return 1.0


def missed_work(tried: Tried) -> float:
    """The residual of the energy budget of a step, over its limit."""
    parameters, step, budget = tried.parameters, tried.scratch.step, tried.state.budget
    grown = elastic_energy_at_end(parameters.contacts, step) + remote_energy(parameters.contacts, step) - tried.before
    spent = float(budget[FILMS] + budget[DRAG]) + stake(step)
    return missing_work(step.budget.lines[-1], grown, spent, work_scale(parameters))


def new_contacts(parameters: Parameters, step: Step) -> PairList:
    """The pairs without a film that need one at the end of a step."""
    box = box_of(parameters.box, step.cell.shape, parameters.dimensions)
    pair = np.stack([step.pairs.first, step.pairs.second], axis=1)
    image = step.pairs.image[:, : parameters.dimensions].astype(np.int64)
    return new_pairs(parameters, step.bodies.position, box, (pair, image))


def part_until_contacts(parameters: Parameters, step: Step, opened: PairList) -> float:
    """The part of a step until the first new contact opens, by linear interpolation of its gap; 1 if all are wide
    enough at the end.
    """
    found = part_until_pairs(parameters, step, opened)
    return min(found, part_until_walls(parameters, step, step.walls)) if step.walls else found


def part_until_pairs(parameters: Parameters, step: Step, opened: PairList) -> float:
    """The part of a step until the first new contact between spheres."""
    pair, image, between = opened
    reach = parameters.radius[pair].sum(axis=1)
    end = np.linalg.norm(between, axis=1) - reach
    late = end < narrowest(parameters)
    if not late.any():
        return 1.0
    pair, image, reach = pair[late], image[late], reach[late]
    box = box_of(parameters.box, step.cell.before, parameters.dimensions)
    apart = step.bodies.before[pair[:, 1]] - step.bodies.before[pair[:, 0]] + image * box.sides
    apart[:, 0] += box.tilt * image[:, 1]
    return part_until(parameters, np.linalg.norm(apart, axis=1) - reach, end[late])


def part_until_walls(parameters: Parameters, step: Step, walls: Walls) -> float:
    """The part of a step until the first new contact with a wall."""
    touching = np.zeros((len(step.bodies.position), len(parameters.walls.modulus)), np.bool_)
    touching[walls.touches.first, walls.touches.wall] = True
    end = wall_gaps(parameters, step.bodies.position, walls.places.place)
    late = ~touching & (end < narrowest(parameters))
    if not late.any():
        return 1.0
    return part_until(parameters, wall_gaps(parameters, step.bodies.before, walls.places.before)[late], end[late])


def narrowest(parameters: Parameters) -> float:
    """The smallest gap of a new contact (m): the moment at which a film opens is as exact as stresses and work are."""
    return parameters.contacts.fade_from * (1.0 - error_of_run(parameters.scheme, parameters.tolerance) / LOOSE)


def part_until(parameters: Parameters, start: Array, end: Array) -> float:
    """The part of a step until the first of these gaps is between that of the narrowest new contact and the reach of
    films. Those that are narrower at its start, after a jump, do not count.
    """
    reach = parameters.contacts.fade_from
    aim = 0.5 * (narrowest(parameters) + reach)
    parts = [(wide - aim) / (wide - narrow) for wide, narrow in zip(start, end, strict=True) if wide >= reach]
    return min(max(float(min(parts)), LEAST_PART), MOST_PART) if parts else 1.0


def jump(parameters: Parameters, state: State, scratch: Workspace) -> bool:
    """Balance forces at constant gaps if the protocol jumps at this time. Returns False if no balance is found.

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


def _take(parameters: Parameters, state: State, scratch: Workspace, end: float) -> None:
    """Copy the accepted step to the state."""
    accept(scratch.step)
    length = end - float(state.pace[CLOCK])
    state.velocity[:] = (scratch.step.bodies.before - state.position) / length
    if state.spin.shape[1]:
        state.spin[:] = scratch.step.spins.turn / (length * parameters.radius[:, None])
    store(parameters, state, scratch.step)
