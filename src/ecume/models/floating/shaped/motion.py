"""Translation and rotation of shapes in a time step, and their contacts.

Translation and rotation of shapes in a time step: kicks and drift of three velocities for each body. Drag acts along
the axis, across it and on the spin, each solved exactly for a constant force during the kick.
"""

from __future__ import annotations

import math

from ecume._jit import compiled, composed
from ecume.engine.contact import contacts, impulse_solvers
from ecume.engine.contact import torque_contacts as touching
from ecume.engine.contact.contacts import Memory, deepest_overlap
from ecume.engine.contact.torque_contacts import TorqueContacts
from ecume.engine.outlines import Stance
from ecume.models.floating.contacts.collisions import (
    clear_impulses,
    goal_for,
    goal_of,
    require_gaps,
    require_rest,
    require_stops,
    share_restitution,
)
from ecume.models.floating.parameters import Parameters, Parts, Scratch
from ecume.models.floating.shaped.bodies import Outlined, RigidKicks, ShapedScratch, solver_bodies, store_angles
from ecume.models.floating.state import COLLISIONS, DEEPEST, SWEEPS, UNCONVERGED, State, Workspace
from ecume.models.model import CROWDED, DIVERGED, DONE
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


@compiled
def bounce(own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Apply collisions to the midstep velocities: (1 + e) times the impulses that stop all approaches."""
    of_float = workspace.restitution
    levers = own.levers
    touching.normal_velocities(levers, own.before, levers.scratch)
    fastest = require_stops(False, parameters, levers)
    if fastest <= 0.0:
        return
    clear_impulses(levers)
    goal = goal_for(parameters, fastest)
    state.tally[SWEEPS] += touching.solve(levers, own.before, goal)
    share_restitution(parameters, levers, of_float)
    for row in range(levers.total[0]):
        if levers.impulse[row] > 0.0:
            state.tally[COLLISIONS] += 1.0
            levers.impulse[row] *= 1.0 + of_float[levers.first[row]]
    touching.apply_impulses(levers, levers.impulse, own.midstep_velocity)


@compiled
def solve_contacts(parameters: Parameters, state: State, levers: TorqueContacts, velocity: Array) -> None:
    """Solve for impulses on `velocity`, starting from those of the previous solve, and store them."""
    memory = Memory(state.touches, state.touching, state.push)
    contacts.recall(touching.contact_keys(levers), memory)
    touching.normal_velocities(levers, velocity, levers.scratch)
    goal = goal_of(parameters, levers)
    if goal.target > 0.0:
        sweeps = touching.solve(levers, velocity, goal)
        state.tally[SWEEPS] += sweeps
        state.tally[UNCONVERGED] += 1.0 if sweeps > impulse_solvers.MOST_SWEEPS else 0.0
    else:
        clear_impulses(levers)
    contacts.remember(touching.contact_keys(levers), memory)


@compiled
def collide_outlines(
    part: Outlined, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Solve collisions, then a plastic solve for the midstep velocities, so that no float overlaps another."""
    if not part.solved:
        return
    bounce(own, parameters, state, workspace)
    require_gaps(False, parameters, own.levers)
    solve_contacts(parameters, state, own.levers, own.midstep_velocity)


@compiled
def separate_outlines(
    part: Outlined, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """List the contacts at the new positions, and remove deep overlaps without changing velocities."""
    if not part.solved:
        return
    reach = 2.0 * workspace.travel[0] + parameters.slop
    stance = Stance(state.position, own.angle, own.corner)
    bodies, levers = solver_bodies(part, parameters, own), own.levers
    touching.gather(levers, workspace.candidates, stance, bodies, reach)
    deepest = deepest_overlap(levers.total, levers.gap)
    state.tally[DEEPEST] = max(state.tally[DEEPEST], deepest)
    if deepest > parameters.slop:
        touching.separate(levers, workspace.candidates, stance, bodies, parameters.slop)
        touching.gather(levers, workspace.candidates, stance, bodies, reach)
    store_angles(own, state)


@compiled
def constrain_outline_velocities(
    part: Outlined, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Solve contacts for the velocity at the end of the step; `before` is the velocity without the kick.

    A faster approach than by the kick alone is a collision of the next step.
    """
    if not part.solved:
        return
    levers = own.levers
    touching.normal_velocities(levers, own.before, levers.change)
    touching.normal_velocities(levers, own.midstep_velocity, levers.scratch)
    require_rest(parameters, levers)
    solve_contacts(parameters, state, levers, own.midstep_velocity)


@compiled
def find_outline_contacts(
    part: Outlined, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> int:
    """List the contacts that are possible in this step; `CROWDED` if there is no room."""
    if not part.solved:
        return DONE
    stance = Stance(state.position, own.angle, own.corner)
    # Twice the travel for a head-on pair, and twice again for floats that others push.
    reach = 4.0 * workspace.travel[0] + parameters.slop
    room = touching.gather(own.levers, workspace.candidates, stance, solver_bodies(part, parameters, own), reach)
    return DONE if room else CROWDED
