"""What is done to floats from outside, booked step by step: by a current, by a dish that is moved, by chance.

A current drags with zeta (u - v). Its own part, zeta u, does the work that is injected; -zeta v is what a liquid at
rest would do, and dissipates. So a float that drifts with the current is given zeta u^2 and loses as much. A dish in
motion acts, as seen from it, by the inertia and the drag that `swaying.left_behind` tells. Chance gives and takes
heat: what Langevin's random force and drag do together along a path, -F o dx of all other forces, in Stratonovich's
sense [sekimoto1998]; contacts are hard and do no work.
"""

from __future__ import annotations

import math

from ecume._jit import compiled
from ecume.laws.drag import schiller_naumann_factor
from ecume.laws.swaying import left_behind, sway_acceleration, sway_velocity
from ecume.models.floating.currents import current_at
from ecume.models.floating.parameters import OVERDAMPED, Parameters
from ecume.models.floating.state import WORK, State, Workspace


@compiled
def is_driven(parameters: Parameters) -> bool:
    """Whether anything does work on the floats from outside."""
    drift = parameters.drift
    return bool(drift.flows or drift.sway.moves or drift.thermal > 0.0)


@compiled
def faster(parameters: Parameters, state: State, i: int, along: float, across: float) -> float:
    """Drag over Stokes's, of a float in a current."""
    slip = math.sqrt((state.velocity[i, 0] - along) ** 2 + (state.velocity[i, 1] - across) ** 2)
    return float(schiller_naumann_factor(2.0 * parameters.floats.radius[i] * slip * parameters.drift.thickness))


@compiled
def power_of_current(parameters: Parameters, state: State, workspace: Workspace) -> float:
    """That of the current's drag along the passage, and of the heat that chance gives (W)."""
    mass, relaxation, drift = parameters.floats.mass, parameters.floats.relaxation_time, parameters.drift
    position, passage, force, power = state.position, workspace.passage, workspace.force, 0.0
    for i in range(len(position)):
        along, across = current_at(drift, position[i, 0], position[i, 1])
        friction = mass[i] / relaxation[i]
        if drift.thickness > 0.0:
            friction *= faster(parameters, state, i, along, across)
        power += friction * (along * passage[i, 0] + across * passage[i, 1])
        if drift.thermal > 0.0:
            power -= force[i, 0] * passage[i, 0] + force[i, 1] * passage[i, 1]
    return power


@compiled
def power_of_dish(parameters: Parameters, workspace: Workspace, time: float) -> float:
    """That of a dish in motion, as seen from it (W)."""
    mass, relaxation, sway = parameters.floats.mass, parameters.floats.relaxation_time, parameters.drift.sway
    passage, power = workspace.passage, 0.0
    for axis in range(2):
        speed = sway.velocity[axis] + sway_velocity(sway.amplitude[axis], sway.turning, time)
        change = sway_acceleration(sway.amplitude[axis], sway.turning, time)
        change = 0.0 if parameters.scheme == OVERDAMPED else change
        for i in range(len(mass)):
            pulled = left_behind(mass[i], mass[i] / relaxation[i], change, speed, sway.slip)
            power += passage[i, axis] * pulled
    return power


@compiled
def book(parameters: Parameters, state: State, workspace: Workspace, ahead: float) -> None:
    """Half of a step's work: by the forces where the passage begins, or, one step `ahead`, where it ends."""
    drift, tally = parameters.drift, state.tally
    # Runs of former versions have no place for it.
    if len(tally) <= WORK:
        return
    half = 0.5 * parameters.time_step
    if drift.flows or drift.thermal > 0.0:
        tally[WORK] += half * power_of_current(parameters, state, workspace)
    if drift.sway.moves and not drift.thermal > 0.0:
        tally[WORK] += half * power_of_dish(parameters, workspace, (state.step[0] + ahead) * parameters.time_step)
