"""The smooth part of a time step, scheme by scheme: what kick, drag and drift do when nothing touches."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ecume._jit import admit, compiled, inlined
from ecume.engine.philox import counter_of, normals
from ecume.laws import brownian, dish_motion, drag
from ecume.laws.brownian import diffusivity
from ecume.laws.dish_motion import left_behind, sway_acceleration, sway_velocity
from ecume.laws.drag import schiller_naumann_factor
from ecume.models.floating.currents import current_at
from ecume.models.floating.parameters import EXPLICIT_EULER, OVERDAMPED, RK4, VELOCITY_VERLET, Kick, Parameters
from ecume.models.floating.state import State, Workspace
from ecume.units import Array

admit(brownian, drag, dish_motion)


@compiled
def give_kick(kick: Kick, velocity: Array, force: Array) -> None:
    """Drag and a force that stays for the kick's time, solved exactly."""
    decay, gain = kick.decay, kick.gain
    for i in range(force.shape[0]):
        velocity[i, 0] = decay[i] * velocity[i, 0] + gain[i] * force[i, 0]
        velocity[i, 1] = decay[i] * velocity[i, 1] + gain[i] * force[i, 1]


@compiled
def kick_floats(parameters: Parameters, state: State, force: Array, ahead: float) -> None:
    """`give_kick`, with the drag of the scene's law and a dish in motion, `ahead` steps from now."""
    if parameters.drift.thickness > 0.0:
        give_fast_kick(parameters, state, force)
    else:
        give_kick(parameters.kick, state.velocity, force)
    if parameters.drift.sway.moves:
        leave_behind(parameters, state, (state.step[0] + ahead) * parameters.time_step)


@compiled
def leave_behind(parameters: Parameters, state: State, time: float) -> None:
    """What the motion of the dish does to velocities as seen from it; what has no inertia feels its velocity only."""
    sway, floats, gain, velocity = parameters.drift.sway, parameters.floats, parameters.kick.gain, state.velocity
    for axis in range(2):
        speed = sway.velocity[axis] + sway_velocity(sway.amplitude[axis], sway.turning, time)
        change = sway_acceleration(sway.amplitude[axis], sway.turning, time)
        change = 0.0 if parameters.scheme == OVERDAMPED else change
        for i in range(velocity.shape[0]):
            friction = floats.mass[i] / floats.relaxation_time[i]
            velocity[i, axis] += gain[i] * left_behind(floats.mass[i], friction, change, speed, sway.slip)


@compiled
def give_fast_kick(parameters: Parameters, state: State, force: Array) -> None:
    """A drag that grows with the speed through the liquid: that of the kick's beginning, then as in `give_kick`."""
    floats, velocity = parameters.floats, state.velocity
    time = 0.5 * parameters.time_step if parameters.scheme == VELOCITY_VERLET else parameters.time_step
    for i in range(force.shape[0]):
        friction = floats.mass[i] / floats.relaxation_time[i]
        along, across = current_at(parameters.drift, state.position[i, 0], state.position[i, 1])
        speed = math.sqrt((velocity[i, 0] - along) ** 2 + (velocity[i, 1] - across) ** 2)
        faster = schiller_naumann_factor(2.0 * floats.radius[i] * speed * parameters.drift.thickness)
        decay = math.exp(-time * faster / floats.relaxation_time[i])
        # The speed that the force and the flow would lead to; the force holds Stokes's part of the flow.
        last_x = along + (force[i, 0] - friction * along) / (friction * faster)
        last_y = across + (force[i, 1] - friction * across) / (friction * faster)
        velocity[i, 0] = last_x + decay * (velocity[i, 0] - last_x)
        velocity[i, 1] = last_y + decay * (velocity[i, 1] - last_y)


@compiled
def drift(position: Array, velocity: Array, time: float) -> None:
    """Straight on. The passage has a row more than there are floats where a dish stands around them: its own."""
    for i in range(min(position.shape[0], velocity.shape[0])):
        position[i, 0] += time * velocity[i, 0]
        position[i, 1] += time * velocity[i, 1]


@compiled
def copy_rows(target: Array, source: Array) -> None:
    """The first rows of one become those of the other."""
    for i in range(min(target.shape[0], source.shape[0])):
        target[i, 0], target[i, 1] = source[i, 0], source[i, 1]


@compiled
def clear(rows: Array) -> None:
    """All zero."""
    for i in range(rows.shape[0]):
        rows[i, 0], rows[i, 1] = 0.0, 0.0


@compiled
def accelerate(parameters: Parameters, velocity: Array, force: Array, acceleration: Array) -> None:
    """F/m - v/tau."""
    mass, relaxation = parameters.floats.mass, parameters.floats.relaxation_time
    for i in range(force.shape[0]):
        acceleration[i, 0] = force[i, 0] / mass[i] - velocity[i, 0] / relaxation[i]
        acceleration[i, 1] = force[i, 1] / mass[i] - velocity[i, 1] / relaxation[i]


@compiled
def jiggle(parameters: Parameters, velocity: Array, step: int) -> None:
    """Brownian motion as a velocity of one step: a normal displacement of variance 2 kT/zeta dt along each axis."""
    gain, time = parameters.kick.gain, parameters.time_step
    for i in range(velocity.shape[0]):
        far = math.sqrt(2.0 * diffusivity(parameters.drift.thermal, 1.0 / gain[i]) / time)
        along, across = normals(counter_of(i, step, 0), parameters.drift.seed)
        velocity[i, 0] += far * along
        velocity[i, 1] += far * across


@compiled
def predict(law: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """The smooth part up to the drift: `passage` is the displacement over the time step, and the velocity has its
    kick.
    """
    if parameters.scheme == EXPLICIT_EULER:
        copy_rows(workspace.passage, state.velocity)
        kick_floats(parameters, state, workspace.force, 0.5)
    else:
        kick_floats(parameters, state, workspace.force, 0.0 if parameters.scheme == VELOCITY_VERLET else 0.5)
        if parameters.drift.thermal > 0.0:
            jiggle(parameters, state.velocity, int(state.step[0]))
        copy_rows(workspace.passage, state.velocity)


@inlined
def runge_kutta_with(
    evaluate: Callable[..., None], law: Any, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """The classical scheme of fourth order, drag included: passage and velocity change by the weighted means of four
    stages.
    """
    time, passage, stages = parameters.time_step, workspace.passage, workspace.stages
    position, velocity, rate, slope, push = stages[0], stages[1], stages[2], stages[3], stages[4]
    clear(passage)
    clear(rate)
    copy_rows(push, workspace.force)
    copy_rows(velocity, state.velocity)
    for stage in range(4):
        if stage > 0:
            ahead = time if stage == 3 else 0.5 * time
            copy_rows(position, state.position)
            drift(position, velocity, ahead)
            copy_rows(velocity, state.velocity)
            drift(velocity, slope, ahead)
            evaluate(law, parameters, position, workspace.lists, (workspace.sorted_floats, push))
        accelerate(parameters, velocity, push, slope)
        weight = 1.0 / 6.0 if stage in (0, 3) else 1.0 / 3.0
        drift(passage, velocity, weight)
        drift(rate, slope, weight)
    drift(state.velocity, rate, time)


@inlined
def predict_rarely_with(
    evaluate: Callable[..., None], law: Any, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """`predict` for the schemes that ask for forces on the way.

    Stoermer's scheme is the drift-kick-drift form, whose midpoints obey x(t+dt) = 2 x(t) - x(t-dt) + dt^2 a.
    """
    if parameters.scheme == RK4:
        runge_kutta_with(evaluate, law, parameters, state, workspace)
        return
    passage, middle = workspace.passage, workspace.stages[0]
    copy_rows(passage, state.velocity)
    copy_rows(middle, state.position)
    drift(middle, state.velocity, 0.5 * parameters.time_step)
    evaluate(law, parameters, middle, workspace.lists, (workspace.sorted_floats, workspace.force))
    give_kick(parameters.kick, state.velocity, workspace.force)
    for i in range(len(middle)):
        passage[i, 0] = 0.5 * (passage[i, 0] + state.velocity[i, 0])
        passage[i, 1] = 0.5 * (passage[i, 1] + state.velocity[i, 1])
