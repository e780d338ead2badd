"""Energy budget: the work done on floats from outside in each step, by a current, by a moving dish, and by noise.

A current drags with zeta (u - v). Its part zeta u does the injected work; -zeta v is the drag of a liquid at rest,
which dissipates. A float that drifts with the current receives zeta u^2 and dissipates as much. A moving dish acts,
in its own frame, by inertia and by the drag of `left_behind`. Noise exchanges heat with the floats: the work of the
random force and of the drag together along a path is -F o dx of all other forces, in the sense of Stratonovich
[sekimoto1998]. Contacts are hard and do no work.
"""

from __future__ import annotations

import math
from typing import Any

from ecume._jit import compiled
from ecume.laws.dish_motion import left_behind, sway_acceleration, sway_velocity
from ecume.laws.drag import schiller_naumann_factor
from ecume.models.floating.forces.flow_and_noise import current_at, straight_current
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.state import WORK, State, Workspace
from ecume.units import Array


@compiled
def is_driven(parameters: Parameters) -> bool:
    """Whether external forces do work on the floats."""
    drift = parameters.drift
    return bool(drift.flows or drift.sway.moves or drift.thermal > 0.0 or drift.active)


@compiled
def power_of_current(parameters: Parameters, state: State, midstep_velocity: Array) -> float:
    """The power of the drag of the current at the midpoint of the step (W)."""
    mass, relaxation, radius = parameters.floats.mass, parameters.floats.relaxation_time, parameters.floats.radius
    drift, position, velocity, half = parameters.drift, state.position, state.velocity, 0.5 * parameters.time_step
    flow, thickness, tabled, power = drift.flow, drift.thickness, drift.nodes.shape[1] > 0, 0.0
    for i in range(len(position)):
        x, y = position[i, 0] + half * midstep_velocity[i, 0], position[i, 1] + half * midstep_velocity[i, 1]
        # Passing the whole of `drift` is slow.
        along, across = current_at(drift, x, y) if tabled else straight_current(flow, x, y)
        friction = mass[i] / relaxation[i]
        if thickness > 0.0:
            slip = math.sqrt((velocity[i, 0] - along) ** 2 + (velocity[i, 1] - across) ** 2)
            friction *= schiller_naumann_factor(2.0 * radius[i] * slip * thickness)
        power += friction * (along * midstep_velocity[i, 0] + across * midstep_velocity[i, 1])
    return power


@compiled
def power_of_dish(parameters: Parameters, midstep_velocity: Array, time: float) -> float:
    """The power of a moving dish, in its frame (W)."""
    mass, relaxation, sway = parameters.floats.mass, parameters.floats.relaxation_time, parameters.drift.sway
    power = 0.0
    for axis in range(2):
        speed = sway.velocity[axis] + sway_velocity(sway.amplitude[axis], sway.turning, time)
        change = sway_acceleration(sway.amplitude[axis], sway.turning, time)
        change = change if parameters.scheme.inertia else 0.0
        for i in range(len(mass)):
            pulled = left_behind(mass[i], mass[i] / relaxation[i], change, speed, sway.slip)
            power += midstep_velocity[i, axis] * pulled
    return power


@compiled
def add_work_of_kicks(part: Any, own: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Add the work of one step, by the forces at its midpoint."""
    drift, tally, time, midstep_velocity = (
        parameters.drift,
        state.tally,
        parameters.time_step,
        workspace.midstep_velocity,
    )
    # States of former versions have no such entry.
    if len(tally) <= WORK:
        return
    if drift.flows:
        tally[WORK] += time * power_of_current(parameters, state, midstep_velocity)
    if drift.sway.moves and not drift.thermal > 0.0:
        tally[WORK] += time * power_of_dish(parameters, midstep_velocity, (state.step[0] + 0.5) * time)


@compiled
def add_heat(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Add the heat of half a step, by the forces at its beginning or end, including a moving dish."""
    midstep_velocity, force, power = workspace.midstep_velocity, workspace.force, 0.0
    if parameters.drift.thermal > 0.0 and len(state.tally) > WORK:
        for i in range(len(force)):
            power += force[i, 0] * midstep_velocity[i, 0] + force[i, 1] * midstep_velocity[i, 1]
        state.tally[WORK] -= 0.5 * parameters.time_step * power
