"""Steps of tracers in a flow that varies in place or time.

Particles without inertia and noise follow their path by the fourth-order Runge-Kutta method, those with noise by Heun's
method, of weak order two. Particles with inertia use the velocity of the liquid in the middle of the step, of second
order. Walls act as in `time_stepping`; between its ends a path is straight.
"""

from __future__ import annotations

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.models.model import DIVERGED, DONE, EXCHANGE
from ecume.models.tracers import time_stepping
from ecume.models.tracers.energy_budget import work_of_drifts, work_of_noise
from ecume.models.tracers.flow_forces import add_forces, work_of_forces
from ecume.models.tracers.flow_loops import Loops, loops_for
from ecume.models.tracers.noise_at_walls import accept_flights, reflect_noise
from ecume.models.tracers.parameters import ADDED_MASS, Parameters, State, Workspace
from ecume.models.tracers.place_diffusion import Surroundings, diffuse, set_hindrances, set_settling, sink
from ecume.models.tracers.time_stepping import (
    add_drifts,
    all_finite,
    fill,
    fly,
    inflow_due,
    move_with,
    plan_steps,
    select_regime,
    wrap,
)
from ecume.units import Array


def advance(parameters: Parameters, state: State, scratch: Workspace, steps: int, loops: Loops | None = None) -> int:
    """Advance by `steps` steps: see `ecume.models.model.Model.advance`. `loops` are those of a user-defined flow."""
    if parameters.current == ():
        return time_stepping.advance(parameters, state, scratch, steps)
    loops = loops or loops_for(parameters.current, parameters.dimensions)
    # Without the flow in their arguments, compiled steps are the same for all flows.
    plain, overdamped = parameters._replace(current=(), around=()), parameters.bodies.overdamped
    around = parameters.around
    for _ in range(steps):
        if not all_finite(state.position, state.velocity):
            return DIVERGED
        when = (int(state.step[0]) * parameters.time_step, parameters.time_step)
        if select_regime(scratch.status, state.left, overdamped, 0) > 0:
            loops.midways(state.position, state.velocity, scratch.status, when, parameters.current, scratch.flow)
            if len(scratch.hindrance):
                moving = (state.position, state.velocity, scratch.status, parameters.bodies.radius)
                set_hindrances(*moving, around, when[1], scratch.hindrance)
            if not _forced_flight(plain, state, scratch, (loops, parameters.current, when)):
                return DIVERGED
        if select_regime(scratch.status, state.left, overdamped, 1) > 0:
            flowing = (loops, parameters.current, when)
            if around != ():
                well = _place_step(plain, state, scratch, flowing, around)
            else:
                step = _noisy_step if parameters.fluid.thermal > 0.0 else _smooth_step
                well = step(plain, state, scratch, flowing)
            if not well:
                return DIVERGED
        if len(state.image) > 0:
            state.work[0] += wrap(plain, state)
        state.step[0] += 1
        if inflow_due(plain, state):
            return EXCHANGE
    return DONE


Flowing = tuple[Loops, object, tuple[float, float]]
"""The loops of a flow, the flow, and the time with the time step."""


def _forced_flight(plain: Parameters, state: State, scratch: Workspace, flowing: Flowing) -> bool:
    """Perform one step of particles with inertia, with the forces of an accelerating and curved flow."""
    if not plain.forces.any:
        return bool(fly(plain, state, scratch))
    (loops, current, when), bodies, fluid = flowing, plain.bodies, plain.fluid
    count, added = len(state.left), ADDED_MASS if plain.added_mass else 0.0
    gradients, forces, laws = np.zeros((count, 9)), np.zeros_like(state.position), scratch.external.copy()
    loops.gradients(state.position, state.velocity, scratch.status, when, current, gradients)
    own = (bodies.mass, bodies.radius, bodies.friction, bodies.apparent_gravity, bodies.sphericity)
    numbers = (when[1], fluid.density, fluid.viscosity, added, *plain.forces)
    add_forces(state.velocity, scratch.status, own, (scratch.flow, gradients, plain.drag), numbers, laws, forces)
    scratch.external[:] = laws + forces
    well = fly(plain, state, scratch)
    ends = (scratch.origin, state.position, scratch.shift)
    state.work[0] += work_of_forces(bodies.mass, scratch.status, scratch.hits, forces, ends)
    scratch.external[:] = laws
    return bool(well)


def _smooth_step(plain: Parameters, state: State, scratch: Workspace, flowing: Flowing) -> bool:
    """Perform one step of particles without inertia and noise."""
    (loops, current, when), bodies = flowing, plain.bodies
    plan_own_drifts(bodies.settling, scratch.status, scratch.kick)
    add_drifts(bodies.mass, bodies.friction, scratch.status, scratch.external, scratch.kick)
    loops.paths(state.position, scratch.status, when, current, scratch.kick, scratch.flow, scratch.travel)
    well = move_with(plain, state, scratch, when[1], plain.stopping)
    state.work[0] += work_of_drifts(plain, state, scratch, when[1])
    return _finished(plain, state, scratch, flowing) and well


def _noisy_step(plain: Parameters, state: State, scratch: Workspace, flowing: Flowing) -> bool:
    """Perform one step of particles without inertia, with thermal noise."""
    (loops, current, when), bodies = flowing, plain.bodies
    key = (plain.seed, int(state.step[0]), plain.fluid.thermal)
    plan_own_drifts(bodies.settling, scratch.status, scratch.kick)
    add_drifts(bodies.mass, bodies.friction, scratch.status, scratch.external, scratch.kick)
    plan_steps(bodies.friction, scratch.status, key, when[1], scratch.noise)
    loops.noisy_paths(state.position, scratch.status, when, current, scratch.kick, scratch.noise, scratch.flow)
    add_up(scratch.status, scratch.flow, scratch.kick, scratch.travel)
    add_up(scratch.status, scratch.travel, scratch.noise, scratch.travel)
    reflect_noise(plain, state, scratch)
    well = move_with(plain, state, scratch, when[1], plain.mirroring)
    accept_flights(plain, state, scratch)
    state.work[0] += work_of_noise(plain, state, scratch, when[1])
    return _finished(plain, state, scratch, flowing) and well


def _place_step(plain: Parameters, state: State, scratch: Workspace, flowing: Flowing, around: Surroundings) -> bool:
    """Perform one step of particles without inertia whose diffusivity depends on position: half a step with the liquid,
    settling and diffusion, and another half step with the liquid.
    """
    (_, _, (time, h)), bodies = flowing, plain.bodies
    well = _half_path(plain, state, scratch, flowing, time)
    select_regime(scratch.status, state.left, bodies.overdamped, 1)
    key = (plain.seed, int(state.step[0]), plain.fluid.thermal)
    noisy = plain.fluid.thermal > 0.0 or len(around.heights) > 0
    if noisy:
        own = (bodies.radius, bodies.friction, bodies.settling)
        diffuse(state.position, scratch.status, own, around, key, h, scratch.travel)
    else:
        sink(state.position, scratch.status, (bodies.radius, bodies.settling), around, h, scratch.travel)
    well = move_with(plain, state, scratch, h, plain.mirroring if noisy else plain.stopping) and well
    state.work[0] += work_of_noise(plain, state, scratch, h)
    select_regime(scratch.status, state.left, bodies.overdamped, 1)
    well = _half_path(plain, state, scratch, flowing, time + 0.5 * h) and well
    select_regime(scratch.status, state.left, bodies.overdamped, 1)
    fill(scratch.kick, 0.0)
    set_settling(state.position, scratch.status, (bodies.radius, bodies.settling), around, scratch.kick)
    add_drifts(bodies.mass, bodies.friction, scratch.status, scratch.external, scratch.kick)
    return _finished(plain, state, scratch, flowing) and well


def _half_path(plain: Parameters, state: State, scratch: Workspace, flowing: Flowing, time: float) -> bool:
    """Move particles for half a step with the liquid and the user laws."""
    loops, current, (_, h) = flowing
    fill(scratch.kick, 0.0)
    add_drifts(plain.bodies.mass, plain.bodies.friction, scratch.status, scratch.external, scratch.kick)
    half = (time, 0.5 * h)
    loops.paths(state.position, scratch.status, half, current, scratch.kick, scratch.flow, scratch.travel)
    well = move_with(plain, state, scratch, 0.5 * h, plain.stopping)
    state.work[0] += work_of_noise(plain, state, scratch, 0.0)
    return well


def _finished(plain: Parameters, state: State, scratch: Workspace, flowing: Flowing) -> bool:
    """Set the velocities of particles without inertia: if a frame is due, those at its time, otherwise the means over
    the step.
    """
    (loops, current, when), bodies = flowing, plain.bodies
    select_regime(scratch.status, state.left, bodies.overdamped, 1)
    if (int(state.step[0]) + 1) % plain.steps_per_frame == 0:
        loops.velocities(state.position, when[0] + when[1], current, scratch.flow)
    add_up(scratch.status, scratch.flow, scratch.kick, state.velocity)
    return True


@compiled
def plan_own_drifts(settling: Array, status: Integers, drift: Array) -> None:
    """Set the velocity relative to the liquid, which is the settling velocity."""
    fill(drift, 0.0)
    last = drift.shape[1] - 1
    for i in range(len(status)):
        if status[i] == 0:
            drift[i, last] = -settling[i]


@compiled
def add_up(status: Integers, first: Array, second: Array, total: Array) -> None:
    """Sum two velocities of each particle."""
    for i in range(len(status)):
        if status[i] == 0:
            for axis in range(total.shape[1]):
                total[i, axis] = first[i, axis] + second[i, axis]
