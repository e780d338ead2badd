"""The integrator of floats that interact through the liquid: v = u + M F, with Brownian motion.

The current u adds to the velocities, and is no force zeta u: floats that drift with it are free of forces.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume._jit import compiled, composed
from ecume.engine.linear_solvers.lanczos import root_product
from ecume.engine.philox import counter_of, normals
from ecume.laws.dish_motion import sway_velocity
from ecume.models.floating.coupled.mobility import (
    CoupledKicks,
    CoupledScratch,
    add_divergence,
    fill_mobility,
    multiply,
)
from ecume.models.floating.forces.flow_and_noise import current_at
from ecume.models.floating.parameters import Parameters, Parts, Scratch
from ecume.models.floating.state import WORK, State, Workspace
from ecume.units import Array

SPINS = 1
"""The purpose of the random numbers of spins; that of velocities is 0."""


@compiled
def fastest_coupled(
    part: CoupledKicks, own: CoupledScratch, parameters: Parameters, state: State, workspace: Workspace
) -> float:
    """Compute the velocities by forces, without the current; return the highest speed, NaN if any is NaN."""
    count = len(part.radius)
    fill_mobility(part, state.position, own.mobility)
    for i in range(count):
        own.load[2 * i], own.load[2 * i + 1] = workspace.force[i, 0], workspace.force[i, 1]
    own.load[2 * count :] = 0.0
    multiply(own.mobility, own.load, own.motion)
    if part.thermal > 0.0:
        add_divergence(part, state.position, own.motion)
    fill_current(own, parameters, state)
    return fastest_motion(own)


@compiled
def fastest_motion(own: CoupledScratch) -> float:
    """The highest speed of any float with its current, NaN if any is NaN."""
    fastest = 0.0
    for i in range(len(own.current)):
        x, y = own.motion[2 * i] + own.current[i, 0], own.motion[2 * i + 1] + own.current[i, 1]
        speed = math.sqrt(x * x + y * y)
        # Written so that a NaN is kept.
        if fastest == fastest and not speed <= fastest:
            fastest = speed
    return fastest


@compiled
def fill_current(own: CoupledScratch, parameters: Parameters, state: State) -> None:
    """Compute the velocity of the liquid at each float: the flow of the scene, and in a moving dish that of the liquid
    that stays behind.
    """
    drift, current = parameters.drift, own.current
    for i in range(len(current)):
        x, y = 0.0, 0.0
        if drift.flows:
            x, y = current_at(drift, state.position[i, 0], state.position[i, 1])
        current[i, 0], current[i, 1] = x, y
    if drift.sway.moves:
        time = (state.step[0] + 0.5) * parameters.time_step
        for axis in range(2):
            speed = drift.sway.velocity[axis] + sway_velocity(drift.sway.amplitude[axis], drift.sway.turning, time)
            for i in range(len(current)):
                current[i, axis] -= drift.sway.slip * speed


@compiled
def add_coupled_noise(part: CoupledKicks, own: CoupledScratch, parameters: Parameters, state: State) -> None:
    """Add Brownian motion to the velocities and spins: displacements with the covariance 2 kT M dt."""
    chance, moved = np.empty(len(own.motion)), np.empty(len(own.motion))
    fill_normals(part, int(state.step[0]), parameters.drift.seed, chance)
    root_product(own.mobility, chance, moved)
    far = math.sqrt(2.0 * parameters.drift.thermal / parameters.time_step)
    for k in range(len(moved)):
        own.motion[k] += far * moved[k]


@compiled
def fill_normals(part: CoupledKicks, step: int, seed: int, chance: Array) -> None:
    """Write a normally distributed number for each velocity and spin."""
    count = len(part.radius)
    for i in range(count):
        chance[2 * i], chance[2 * i + 1] = normals(counter_of(i, step, 0), seed)
        if len(part.spin) > 0:
            chance[2 * count + i] = normals(counter_of(i, step, SPINS), seed)[0]


@composed
def predict_coupled(
    part: CoupledKicks, parts: Parts, scratch: Scratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Complete the velocities that `fastest_coupled` computed by thermal noise."""
    if parameters.drift.thermal > 0.0:
        add_coupled_noise(part, scratch.integrator, parameters, state)
    add_current(scratch.integrator)
    store_velocities(scratch.integrator, state, workspace)


@compiled
def add_current(own: CoupledScratch) -> None:
    """Add the current to the velocities relative to it."""
    for i in range(len(own.current)):
        own.motion[2 * i] += own.current[i, 0]
        own.motion[2 * i + 1] += own.current[i, 1]


@compiled
def store_velocities(own: CoupledScratch, state: State, workspace: Workspace) -> None:
    """Write the velocities and midstep velocities."""
    for i in range(len(own.current)):
        for axis in range(2):
            state.velocity[i, axis] = own.motion[2 * i + axis]
            workspace.midstep_velocity[i, axis] = own.motion[2 * i + axis]


@compiled
def finish_coupled(part: Any, own: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Do nothing: velocities follow from the forces at the start of the step."""


@compiled
def add_coupled_work(
    part: CoupledKicks, own: CoupledScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Add the work of the current on the floats in one step, -F u with all forces F on them including contacts: the
    liquid exerts -F, and u is its velocity far from them. The rest of its work is dissipated. With thermal noise, the
    heat contains it.
    """
    if parameters.drift.thermal > 0.0 or len(state.tally) <= WORK:
        return
    power = 0.0
    for i in range(len(own.current)):
        power -= own.load[2 * i] * own.current[i, 0] + own.load[2 * i + 1] * own.current[i, 1]
    state.tally[WORK] += parameters.time_step * power
