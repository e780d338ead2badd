"""How shapes glide and turn in a time step: kicks and drift of three velocities for each body.

A body is slowed along itself, across itself and in its spin, each exactly under a force that stays for the kick.
"""

from __future__ import annotations

import math

from ecume._jit import compiled, composed
from ecume.models.floating.parameters import Parameters, Parts, Scratch
from ecume.models.floating.shaped.bodies import RigidKicks, ShapedScratch
from ecume.models.floating.state import State, Workspace
from ecume.models.model import DIVERGED, DONE
from ecume.units import Array

FARTHEST_TURN = 0.5
"""rad in a step: beyond, nothing that is known of contacts holds."""


@compiled
def kick_time(parameters: Parameters) -> float:
    """Half a step for velocity Verlet, a whole one for the others."""
    return 0.5 * parameters.time_step if parameters.scheme.half_kicks else parameters.time_step


@compiled
def slowed(part: RigidKicks, parameters: Parameters, i: int, axis: int) -> tuple[float, float]:
    """What drag leaves of body i's velocity along an axis of its own (2: its spin) after a kick, and what a unit force
    gives.
    """
    time = kick_time(parameters)
    friction, mass = part.friction[i, axis], part.inertia[i] if axis == 2 else parameters.floats.mass[i]
    if not parameters.scheme.inertia:
        return 0.0, 1.0 / friction
    rate = friction / mass * time
    held = -math.expm1(-rate) / rate if rate > 0.0 else 1.0
    return math.exp(-rate), held * time / mass


@compiled
def kick(
    part: RigidKicks, own: ShapedScratch, parameters: Parameters, force: Array, velocity: Array, share: float
) -> None:
    """Drag and `share` of the forces that stay for a kick, solved exactly, on velocities and spins (N, 3)."""
    for i in range(len(force)):
        c, s = math.cos(own.angle[i]), math.sin(own.angle[i])
        decay, gain = slowed(part, parameters, i, 0)
        along = decay * (c * velocity[i, 0] + s * velocity[i, 1]) + share * gain * (c * force[i, 0] + s * force[i, 1])
        decay, gain = slowed(part, parameters, i, 1)
        across = decay * (c * velocity[i, 1] - s * velocity[i, 0]) + share * gain * (c * force[i, 1] - s * force[i, 0])
        decay, gain = slowed(part, parameters, i, 2)
        velocity[i, 0], velocity[i, 1] = c * along - s * across, s * along + c * across
        velocity[i, 2] = decay * velocity[i, 2] + share * gain * own.torque[i]


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
def tip_travel(part: RigidKicks, own: ShapedScratch, parameters: Parameters, state: State) -> tuple[float, float]:
    """How far a tip may go in this step because its body turns, and the farthest turn (rad); NaN if one is none."""
    farthest, widest = 0.0, 0.0
    for i in range(len(state.turning)):
        decay, gain = slowed(part, parameters, i, 2)
        # Twice, for Verlet's second half.
        turn = parameters.time_step * (decay * abs(state.turning[i, 1]) + 2.0 * gain * abs(own.torque[i]))
        way = turn * parameters.floats.radius[i]
        if farthest == farthest and not way <= farthest:
            farthest = way
        if widest == widest and not turn <= widest:
            widest = turn
    return farthest, widest


@compiled
def fill_mobility(part: RigidKicks, own: ShapedScratch, parameters: Parameters) -> None:
    """Velocity per impulse along each body, across it, and in its spin."""
    time = kick_time(parameters)
    for i in range(len(own.mobility)):
        for axis in range(3):
            own.mobility[i, axis] = slowed(part, parameters, i, axis)[1] / time


@composed
def predict_rigid(
    part: RigidKicks, parts: Parts, scratch: Scratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """The kick up to the drift, on the passage; `before` is the velocity without forces."""
    load(state, scratch.integrator.midstep_velocity)
    kick_twice(part, scratch.integrator, parameters, workspace.force)


@compiled
def kick_twice(part: RigidKicks, own: ShapedScratch, parameters: Parameters, force: Array) -> None:
    """The passage after a kick, and `before` after one without forces."""
    copy(own.before, own.midstep_velocity)
    kick(part, own, parameters, force, own.before, 0.0)
    kick(part, own, parameters, force, own.midstep_velocity, 1.0)


@compiled
def finish_rigid(
    part: RigidKicks, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """The second half of a kick, where there are halves."""
    if parameters.scheme.half_kicks:
        kick_twice(part, own, parameters, workspace.force)


@compiled
def move_rigid(
    part: RigidKicks, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Glide and turn with the passage."""
    time = parameters.time_step
    for i in range(len(state.position)):
        state.position[i, 0] += time * own.midstep_velocity[i, 0]
        state.position[i, 1] += time * own.midstep_velocity[i, 1]
        own.angle[i] += time * own.midstep_velocity[i, 2]
        state.turning[i, 0] = own.angle[i]


@compiled
def begin_rigid(part: RigidKicks, own: ShapedScratch, parameters: Parameters, state: State) -> None:
    """Angles and mobilities for a new workspace."""
    for i in range(len(state.position)):
        own.angle[i] = state.turning[i, 0]
    fill_mobility(part, own, parameters)


@compiled
def bound_rigid_travel(
    part: RigidKicks, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> int:
    """Tips go farther than centers; DIVERGED where a body turns too far in a step."""
    tips, turn = tip_travel(part, own, parameters, state)
    workspace.travel[0] += tips
    return DONE if turn <= FARTHEST_TURN else DIVERGED


@compiled
def store_rigid(part: RigidKicks, own: ShapedScratch, state: State) -> None:
    """Velocities and spins of the state."""
    store(state, own.midstep_velocity)
