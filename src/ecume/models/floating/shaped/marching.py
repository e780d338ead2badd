"""One step of shapes that glide and turn, and their march: the scheme of `ecume.models.floating.stepping`, with spins.

A body is slowed along itself, across itself and in its spin, each exactly under a force that stays for the kick.
"""

from __future__ import annotations

import math

from ecume._jit import compiled
from ecume.engine.contact import torque_contacts as touching
from ecume.engine.neighbors import farthest_move
from ecume.engine.outlines import Stance
from ecume.models.floating.parameters import NO_CONTACTS, OVERDAMPED, VELOCITY_VERLET, Parameters
from ecume.models.floating.shaped.bodies import Crew, party_of
from ecume.models.floating.shaped.forces import shaped_forces
from ecume.models.floating.shaped.meeting import meet, rest, settle
from ecume.models.floating.state import State, Workspace
from ecume.models.floating.stepping import keep_lists
from ecume.models.model import CROWDED, DIVERGED, DONE
from ecume.units import Array

FARTHEST_TURN = 0.5
"""rad in a step: beyond, nothing that is known of contacts holds."""


@compiled
def kick_time(parameters: Parameters) -> float:
    """Half a step for velocity Verlet, a whole one for the others."""
    return 0.5 * parameters.time_step if parameters.scheme == VELOCITY_VERLET else parameters.time_step


@compiled
def slowed(parameters: Parameters, i: int, axis: int) -> tuple[float, float]:
    """What drag leaves of body i's velocity along an axis of its own (2: its spin) after a kick, and what a unit force
    gives.
    """
    many, time = parameters.many, kick_time(parameters)
    friction, mass = many.friction[i, axis], many.inertia[i] if axis == 2 else parameters.floats.mass[i]
    if parameters.scheme == OVERDAMPED:
        return 0.0, 1.0 / friction
    rate = friction / mass * time
    held = -math.expm1(-rate) / rate if rate > 0.0 else 1.0
    return math.exp(-rate), held * time / mass


@compiled
def kick(parameters: Parameters, crew: Crew, force: Array, velocity: Array, share: float) -> None:
    """Drag and `share` of the forces that stay for a kick, solved exactly, on velocities and spins (N, 3)."""
    for i in range(len(force)):
        c, s = math.cos(crew.angle[i]), math.sin(crew.angle[i])
        decay, gain = slowed(parameters, i, 0)
        along = decay * (c * velocity[i, 0] + s * velocity[i, 1]) + share * gain * (c * force[i, 0] + s * force[i, 1])
        decay, gain = slowed(parameters, i, 1)
        across = decay * (c * velocity[i, 1] - s * velocity[i, 0]) + share * gain * (c * force[i, 1] - s * force[i, 0])
        decay, gain = slowed(parameters, i, 2)
        velocity[i, 0], velocity[i, 1] = c * along - s * across, s * along + c * across
        velocity[i, 2] = decay * velocity[i, 2] + share * gain * crew.torque[i]


@compiled
def load(state: State, velocity: Array) -> None:
    """Velocities and spins of the state; walls stand still."""
    for i in range(len(state.velocity)):
        velocity[i, 0], velocity[i, 1], velocity[i, 2] = state.velocity[i, 0], state.velocity[i, 1], state.turning[i, 1]


@compiled
def store(state: State, velocity: Array) -> None:
    """These are the state's velocities and spins."""
    for i in range(len(state.velocity)):
        state.velocity[i, 0], state.velocity[i, 1], state.turning[i, 1] = velocity[i, 0], velocity[i, 1], velocity[i, 2]


@compiled
def copy(target: Array, source: Array) -> None:
    """All of it."""
    for i in range(target.shape[0]):
        for axis in range(3):
            target[i, axis] = source[i, axis]


@compiled
def tips_ahead(parameters: Parameters, state: State, crew: Crew) -> tuple[float, float]:
    """How far a tip may go in this step because its body turns, and the farthest turn (rad); NaN if one is none."""
    farthest, widest = 0.0, 0.0
    for i in range(len(state.turning)):
        decay, gain = slowed(parameters, i, 2)
        # Twice, for Verlet's second half.
        turn = parameters.time_step * (decay * abs(state.turning[i, 1]) + 2.0 * gain * abs(crew.torque[i]))
        way = turn * parameters.floats.radius[i]
        if farthest == farthest and not way <= farthest:
            farthest = way
        if widest == widest and not turn <= widest:
            widest = turn
    return farthest, widest


@compiled
def fill_mobility(parameters: Parameters, crew: Crew) -> None:
    """Velocity per impulse along each body, across it, and in its spin."""
    time = kick_time(parameters)
    for i in range(len(crew.mobility)):
        for axis in range(3):
            crew.mobility[i, axis] = slowed(parameters, i, axis)[1] / time


@compiled
def look(parameters: Parameters, state: State, workspace: Workspace, ahead: float) -> bool:
    """Who may meet in this step; False where there is no room for all."""
    if parameters.contact_law == NO_CONTACTS:
        return True
    crew = workspace.sorted_floats
    stance = Stance(state.position, crew.angle, crew.corner)
    # Twice the pace for a pair that meets head on, and twice again for those whom others push.
    reach = 4.0 * ahead + parameters.slop
    return touching.gather(crew.levers, workspace.candidates, stance, party_of(parameters, crew), reach)


@compiled
def step_shaped(parameters: Parameters, state: State, workspace: Workspace, ahead: float) -> None:
    """One time step."""
    crew, force, time = workspace.sorted_floats, workspace.force, parameters.time_step
    load(state, crew.passage)
    copy(crew.before, crew.passage)
    kick(parameters, crew, force, crew.before, 0.0)
    kick(parameters, crew, force, crew.passage, 1.0)
    if parameters.contact_law != NO_CONTACTS:
        meet(parameters, state, workspace)
    for i in range(len(state.position)):
        state.position[i, 0] += time * crew.passage[i, 0]
        state.position[i, 1] += time * crew.passage[i, 1]
        crew.angle[i] += time * crew.passage[i, 2]
    if parameters.contact_law != NO_CONTACTS:
        settle(parameters, state, workspace, 2.0 * ahead + parameters.slop)
    for i in range(len(state.position)):
        state.turning[i, 0] = crew.angle[i]
    shaped_forces(parameters, state.position, workspace.lists, (crew, force))
    if parameters.scheme == VELOCITY_VERLET:
        copy(crew.before, crew.passage)
        kick(parameters, crew, force, crew.before, 0.0)
        kick(parameters, crew, force, crew.passage, 1.0)
        if parameters.contact_law != NO_CONTACTS:
            rest(parameters, state, workspace)
    store(state, crew.passage)
    state.step[0] += 1


@compiled
def march_shaped(parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """March: see `ecume.models.model.Model.advance`."""
    crew = workspace.sorted_floats
    for i in range(len(state.position)):
        crew.angle[i] = state.turning[i, 0]
    if workspace.ready[0] == 0:
        fill_mobility(parameters, crew)
        shaped_forces(parameters, state.position, workspace.lists, (crew, workspace.force))
    workspace.ready[0] = 1
    for _ in range(steps):
        status = keep_lists(parameters, state, workspace)
        if status != DONE:
            return status
        tips, turn = tips_ahead(parameters, state, crew)
        if not turn <= FARTHEST_TURN:
            return DIVERGED
        if not look(parameters, state, workspace, workspace.ahead[0] + tips):
            return CROWDED
        step_shaped(parameters, state, workspace, workspace.ahead[0] + tips)
        if not farthest_move(state.position, state.reference) <= 0.5 * parameters.skin:
            return DIVERGED
    return DONE
