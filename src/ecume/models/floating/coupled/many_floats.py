"""The integrator and the contacts of many floats that interact through the liquid, by products with the mobility.

The same as `motion` and `contacts` without the matrix: forces, contacts and noise need only products with it. Python
runs the time steps around compiled parts, since the transforms are SciPy's.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, compiled
from ecume.engine.contact import contacts as touching
from ecume.engine.contact import mobility_contacts
from ecume.engine.contact.contacts import Contacts
from ecume.engine.contact.impulse_solvers import Goal
from ecume.engine.linear_solvers.lanczos import root_by_products
from ecume.laws import pair_mobility
from ecume.laws.pair_mobility import rotne_prager
from ecume.models.floating.contacts.collisions import clear_impulses
from ecume.models.floating.contacts.friction import memory_of
from ecume.models.floating.coupled.contacts import gather_contacts
from ecume.models.floating.coupled.flow_grid import ERROR, FlowGrid, flow_divergence, flow_product, place_flow_grid
from ecume.models.floating.coupled.mobility import CoupledKicks, CoupledScratch
from ecume.models.floating.coupled.motion import (
    add_coupled_work,
    add_current,
    fastest_motion,
    fill_current,
    fill_normals,
    store_velocities,
)
from ecume.models.floating.parameters import Parameters, Parts, Scratch
from ecume.models.floating.state import SWEEPS, UNCONVERGED, State, Workspace
from ecume.units import Array

admit(pair_mobility)

MATRIX_UP_TO = 1000
"""The largest number of floats with a matrix: with more, it needs gigabytes for contacts, and more time."""
RESIDUAL = 5e-4
"""The largest approach of touching floats after a solve, over that before it."""
TOLERABLE = 0.1
"""The largest approach in a step that still counts as converged, over the tolerated overlap."""
PRODUCTS = 60.0
"""Products of a time step in a growing raft."""
NEIGHBORS, POINTS = 140.0, 10.0
"""Near pairs and grid points for each float, about."""


class GridKicks(NamedTuple):
    """Constants of many floats that interact through the flow of the liquid."""

    kicks: CoupledKicks


class GridImpulses(NamedTuple):
    """Contacts without friction that are solved by products with the mobility."""

    overlapping: bool
    """whether floats pass through one another"""


class GridScratch(NamedTuple):
    """Workspace of the integrator and the contacts."""

    motion: CoupledScratch
    """without a matrix"""
    grid: list[FlowGrid]
    """one grid, placed in each step"""


def make_grid_scratch(part: GridKicks) -> GridScratch:
    """Return the workspace."""
    count = len(part.kicks.radius)
    motion = CoupledScratch(np.zeros((0, 0)), np.zeros(2 * count), np.zeros(2 * count), np.zeros((count, 2)))
    return GridScratch(motion, [])


def grid_memory(part: GridKicks) -> float:
    """Bytes of the near pairs and of the grid."""
    return len(part.kicks.radius) * (40.0 * NEIGHBORS + 200.0 * POINTS)


def grid_pairs(part: GridKicks) -> float:
    """The work of a time step, in pairs: one for a near pair and about ten for a grid point, in each product."""
    return PRODUCTS * len(part.kicks.radius) * (NEIGHBORS + 10.0 * POINTS)


def fastest_on_grid(
    part: GridKicks, own: GridScratch, parameters: Parameters, state: State, workspace: Workspace
) -> float:
    """Compute the velocities by forces, without the current; return the highest speed: see `motion.fastest_coupled`."""
    kicks, motion = part.kicks, own.motion
    if not np.isfinite(state.position).all():
        return math.nan
    grid = place_flow_grid(state.position, kicks.radius, kicks.viscosity, kicks.thermal > 0.0)
    own.grid[:] = [grid]
    motion.load[:] = workspace.force.ravel()
    motion.motion[:] = flow_product(grid, workspace.force).ravel()
    if kicks.thermal > 0.0:
        motion.motion[:] += kicks.thermal * flow_divergence(grid, state.position).ravel()
    fill_current(motion, parameters, state)
    return float(fastest_motion(motion))


def predict_on_grid(
    part: GridKicks, parts: Parts, scratch: Scratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Complete the velocities by thermal noise and the current."""
    own: GridScratch = scratch.integrator
    if parameters.drift.thermal > 0.0:
        add_noise_on_grid(part.kicks, own, parameters, state)
    add_current(own.motion)
    store_velocities(own.motion, state, workspace)


def add_noise_on_grid(part: CoupledKicks, own: GridScratch, parameters: Parameters, state: State) -> None:
    """Add Brownian motion to the velocities: displacements with the covariance 2 kT M dt."""
    grid, chance = own.grid[0], np.empty(len(own.motion.motion))
    fill_normals(part, int(state.step[0]), parameters.drift.seed, chance)
    scale = np.repeat(np.sqrt(grid.unit / part.radius), 2)
    moved = root_by_products(lambda force: flow_product(grid, force.reshape(-1, 2)).ravel(), scale, chance, ERROR)
    own.motion.motion[:] += math.sqrt(2.0 * parameters.drift.thermal / parameters.time_step) * moved


def add_work_on_grid(
    part: GridKicks, own: GridScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Add the work of the current: see `motion.add_coupled_work`."""
    add_coupled_work(part.kicks, own.motion, parameters, state, workspace)


def collide_on_grid(
    part: GridImpulses, own: GridScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Solve for the midstep velocities, so that no float overlaps another after the step."""
    if part.overlapping:
        return
    contacts, memory = workspace.contacts, memory_of(state)
    wanted = gather_contacts(parameters, state, workspace)
    if wanted.target > 0.0:
        push_on_grid(own, parameters, state, workspace, wanted)
    else:
        clear_impulses(contacts)
    touching.remember(touching.contact_keys(contacts), memory)
    store_velocities(own.motion, state, workspace)


def push_on_grid(own: GridScratch, parameters: Parameters, state: State, workspace: Workspace, wanted: Goal) -> None:
    """Solve for the forces of all contacts and change the motion by them."""
    contacts, grid, count = workspace.contacts, own.grid[0], len(own.motion.current)
    total = int(contacts.total[0])
    set_pair_weights(contacts, state.position, grid.radius, grid.unit)
    contacts.impulse[:total] /= parameters.time_step
    velocity = workspace.midstep_velocity.copy()

    def respond(force: Array) -> Array:
        moved = np.zeros_like(force)
        moved[:count] = flow_product(grid, force[:count])
        return moved

    fastest = float(np.max(contacts.bound[:total] - contacts.scratch[:total]))
    goal = Goal(max(wanted.target, RESIDUAL * fastest), TOLERABLE * parameters.slop / parameters.time_step)
    products = mobility_contacts.solve_by_products(contacts, velocity, respond, goal)
    state.tally[SWEEPS] += products
    state.tally[UNCONVERGED] += 1.0 if products > mobility_contacts.MOST_PRODUCTS else 0.0
    force = np.zeros_like(velocity)
    mobility_contacts.spread_forces(contacts, contacts.impulse, force)
    own.motion.load[:] += force[:count].ravel()
    own.motion.motion[:] = velocity[:count].ravel()
    contacts.impulse[:total] *= parameters.time_step


@compiled
def set_pair_weights(contacts: Contacts, position: Array, radius: Array, unit: float) -> None:
    """Set the effective mass of each contact: force over the relative velocity that it gives to its two bodies."""
    for row in range(contacts.total[0]):
        i, j = contacts.first[row], contacts.second[row]
        closing = 1.0 / radius[i]
        if j < len(radius):
            x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
            along = rotne_prager(math.sqrt(x * x + y * y), radius[i], radius[j])[1]
            closing += 1.0 / radius[j] - 2.0 * along
        contacts.weight[row] = 1.0 / (unit * closing)
