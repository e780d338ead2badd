"""Translation and rotation of shapes in a time step: kicks and drift of three velocities for each body.

Drag acts along the axis, across it and on the spin, each solved exactly for a constant force during the kick.
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
"""rad in one step: beyond it, the predicted contacts are wrong."""


@compiled
def kick_time(parameters: Parameters) -> float:
    """The duration of a kick (s): half a step for velocity Verlet, a whole step for the others."""
    return 0.5 * parameters.time_step if parameters.scheme.half_kicks else parameters.time_step


@compiled
def slowed(part: RigidKicks, parameters: Parameters, i: int, axis: int) -> tuple[float, float]:
    """The decay of the velocity of body i along one of its axes (2: spin) by drag in a kick, and the gain per unit
    force.
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
    """Change velocities and spins (N, 3) by drag and `share` of the forces during a kick, solved exactly."""
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
    """Copy velocities and spins from the state; walls are at rest."""
    for i in range(len(state.velocity)):
        velocity[i, 0], velocity[i, 1], velocity[i, 2] = state.velocity[i, 0], state.velocity[i, 1], state.turning[i, 1]


@compiled
def store(state: State, velocity: Array) -> None:
    """Store velocities and spins in the state."""
    for i in range(len(state.velocity)):
        state.velocity[i, 0], state.velocity[i, 1], state.turning[i, 1] = velocity[i, 0], velocity[i, 1], velocity[i, 2]


@compiled
def copy(target: Array, source: Array) -> None:
    """Copy all rows."""
    for i in range(target.shape[0]):
        for axis in range(3):
            target[i, axis] = source[i, axis]


@compiled
def tip_travel(part: RigidKicks, own: ShapedScratch, parameters: Parameters, state: State) -> tuple[float, float]:
    """The longest travel of a tip by rotation in this step (m), and the largest rotation (rad); NaN is kept."""
    farthest, widest = 0.0, 0.0
    for i in range(len(state.turning)):
        decay, gain = slowed(part, parameters, i, 2)
        # Twice, for the second half kick of velocity Verlet.
        turn = parameters.time_step * (decay * abs(state.turning[i, 1]) + 2.0 * gain * abs(own.torque[i]))
        way = turn * parameters.floats.radius[i]
        if farthest == farthest and not way <= farthest:
            farthest = way
        if widest == widest and not turn <= widest:
            widest = turn
    return farthest, widest


@compiled
def fill_mobility(part: RigidKicks, own: ShapedScratch, parameters: Parameters) -> None:
    """Compute velocity per impulse along each body, across it, and for its spin."""
    time = kick_time(parameters)
    for i in range(len(own.mobility)):
        for axis in range(3):
            own.mobility[i, axis] = slowed(part, parameters, i, axis)[1] / time


@composed
def predict_rigid(
    part: RigidKicks, parts: Parts, scratch: Scratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Compute the midstep velocities by the first kick; `before` is the velocity without forces."""
    load(state, scratch.integrator.midstep_velocity)
    kick_twice(part, scratch.integrator, parameters, workspace.force)


@compiled
def kick_twice(part: RigidKicks, own: ShapedScratch, parameters: Parameters, force: Array) -> None:
    """Compute the midstep velocities after a kick, and `before` after a kick without forces."""
    copy(own.before, own.midstep_velocity)
    kick(part, own, parameters, force, own.before, 0.0)
    kick(part, own, parameters, force, own.midstep_velocity, 1.0)


@compiled
def finish_rigid(
    part: RigidKicks, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Apply the second half kick, if the scheme has one."""
    if parameters.scheme.half_kicks:
        kick_twice(part, own, parameters, workspace.force)


@compiled
def move_rigid(
    part: RigidKicks, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Advance positions and angles with the midstep velocities."""
    time = parameters.time_step
    for i in range(len(state.position)):
        state.position[i, 0] += time * own.midstep_velocity[i, 0]
        state.position[i, 1] += time * own.midstep_velocity[i, 1]
        own.angle[i] += time * own.midstep_velocity[i, 2]
        state.turning[i, 0] = own.angle[i]


@compiled
def begin_rigid(part: RigidKicks, own: ShapedScratch, parameters: Parameters, state: State) -> None:
    """Fill in the angles and mobilities of a new workspace."""
    for i in range(len(state.position)):
        own.angle[i] = state.turning[i, 0]
    fill_mobility(part, own, parameters)


@compiled
def bound_rigid_travel(
    part: RigidKicks, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> int:
    """Add the travel of tips by rotation; `DIVERGED` if a body turns too far in a step."""
    tips, turn = tip_travel(part, own, parameters, state)
    workspace.travel[0] += tips
    return DONE if turn <= FARTHEST_TURN else DIVERGED


@compiled
def store_rigid(part: RigidKicks, own: ShapedScratch, state: State) -> None:
    """Store velocities and spins in the state."""
    store(state, own.midstep_velocity)
