"""Floats with hydrodynamic interaction: their integrator and their contacts.

The integrator is v = u + M F, with Brownian motion. The current u is added to the velocities instead of a force zeta u:
no force acts on floats that drift with the current. `mobility.MOBILITIES` is the table of the forms of the mobility M.

Contacts: the impulse of each contact moves all floats. Without inertia floats do not rebound. One plastic solve for the
midstep velocities, with the full mobility, keeps floats from overlapping after the step.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._jit import by_type, compiled, compiled_inside, composed
from ecume.engine.cells import Integers
from ecume.engine.contact import contacts as touching
from ecume.engine.contact import impulse_solvers, mobility_contacts
from ecume.engine.contact.contacts import Contacts, Memory
from ecume.engine.contact.impulse_solvers import Tolerance
from ecume.engine.contact.mobility_contacts import CoupledContacts, DenseRows, make_dense_rows
from ecume.engine.philox import counter_of, normals
from ecume.laws.moving_dish import sway_velocity
from ecume.models.floating.contacts.collisions import (
    Friction,
    clear_impulses,
    contact_bodies,
    friction_of,
    goal_of,
    require_gaps,
)
from ecume.models.floating.contacts.thermal_collisions import Flow, collide_on_paths, require_distances
from ecume.models.floating.coupled.many_floats import flow_product
from ecume.models.floating.coupled.mobility import (
    CoupledKicks,
    MobilityMatrix,
    MobilityOnGrid,
    add_drift,
    apply,
    make_matrix,
    make_products,
    place,
    root,
    shares,
)
from ecume.models.floating.forces.flow_and_noise import current_at
from ecume.models.floating.options import Built
from ecume.models.floating.parameters import (
    DRIVEN,
    PUSHED,
    SWEEPS,
    UNCONVERGED,
    WORK,
    Parameters,
    Parts,
    Scratch,
    State,
    Workspace,
    copy_rows,
    memory_of,
)
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


class CoupledScratch(NamedTuple):
    """Workspace of the integrator, the contacts and the films."""

    mobility: Any
    """of a type of `mobility.MOBILITIES`"""
    load: Array
    """(M,) forces and torques on all floats, including films and contacts"""
    motion: Array
    """(M,) velocities and spins"""
    current: Array
    """(N, 2) m/s: the velocity of the liquid far from the floats"""
    flow: Flow
    """for collisions"""


def make_scratch(part: CoupledKicks, mobility: Any) -> CoupledScratch:
    """Return the workspace of the integrator with this mobility."""
    count = len(part.radius)
    size, flow = 2 * count + len(part.spin), Flow(part.radius, 1.0 / (3.0 * math.pi * part.viscosity))
    return CoupledScratch(mobility, np.zeros(size), np.zeros(size), np.zeros((count, 2)), flow)


def scratch_with_matrix(part: CoupledKicks, interactions: tuple[Any, ...]) -> CoupledScratch:
    """Return the workspace of floats with a matrix."""
    return make_scratch(part, make_matrix(part))


def scratch_on_grid(part: CoupledKicks, interactions: tuple[Any, ...]) -> CoupledScratch:
    """Return the workspace of many floats."""
    return make_scratch(part, make_products())


@composed
def fastest_coupled(
    part: CoupledKicks, scratch: CoupledScratch, parameters: Parameters, state: State, workspace: Workspace
) -> float:
    """Compute the velocities by forces, without the current; return the highest speed, NaN if any is NaN."""
    if not place(scratch.mobility, part, state.position):
        return math.nan
    load_forces(workspace.force, scratch.load)
    apply(scratch.mobility, scratch.load, scratch.motion)
    fill_current(parameters, state, scratch.motion, scratch.current)
    if part.thermal > 0.0:
        store_driven(scratch.motion, scratch.current, workspace)
        add_drift(scratch.mobility, part, state.position, scratch.motion)
    return fastest_motion(scratch.motion, scratch.current)


@compiled
def load_forces(force: Array, load: Array) -> None:
    """Write the forces on all floats, without torques."""
    load[:] = 0.0
    for i in range(len(force)):
        load[2 * i], load[2 * i + 1] = force[i, 0], force[i, 1]


@compiled
def store_driven(motion: Array, current: Array, workspace: Workspace) -> None:
    """Store the velocities by forces and the current, without noise and without the drift kT div M."""
    for i in range(len(current)):
        for axis in range(2):
            workspace.stages[DRIVEN, i, axis] = motion[2 * i + axis] + current[i, axis]


@compiled
def fastest_motion(motion: Array, current: Array) -> float:
    """The highest speed of any float with its current, NaN if any is NaN."""
    fastest = 0.0
    for i in range(len(current)):
        x, y = motion[2 * i] + current[i, 0], motion[2 * i + 1] + current[i, 1]
        speed = math.sqrt(x * x + y * y)
        # Written so that a NaN is kept.
        if fastest == fastest and not speed <= fastest:
            fastest = speed
    return fastest


@compiled
def fill_current(parameters: Parameters, state: State, motion: Array, current: Array) -> None:
    """Compute the velocity of the liquid at each float: the flow of the scene at the middle of the step, at the place
    to which the float moves until then without noise (`motion` without the current), and in a moving dish the velocity
    of the liquid relative to the dish.
    """
    drift, half = parameters.drift, 0.5 * parameters.time_step
    now = state.step[0] * parameters.time_step
    for i in range(len(current)):
        x, y = 0.0, 0.0
        if drift.flows:
            x, y = current_at(drift, now, state.position[i, 0], state.position[i, 1])
            ahead_x, ahead_y = half * (motion[2 * i] + x), half * (motion[2 * i + 1] + y)
            x, y = current_at(drift, now + half, state.position[i, 0] + ahead_x, state.position[i, 1] + ahead_y)
        current[i, 0], current[i, 1] = x, y
    if drift.sway.moves:
        time = (state.step[0] + 0.5) * parameters.time_step
        for axis in range(2):
            speed = drift.sway.velocity[axis] + sway_velocity(drift.sway.amplitude[axis], drift.sway.turning, time)
            for i in range(len(current)):
                current[i, axis] -= drift.sway.slip * speed


SPINS = 1
"""The purpose of the random numbers of spins; that of velocities is 0."""


@compiled
def fill_normals(part: CoupledKicks, step: int, seed: int, noise: Array) -> None:
    """Write a normally distributed number for each velocity and spin."""
    count = len(part.radius)
    for i in range(count):
        noise[2 * i], noise[2 * i + 1] = normals(counter_of(i, step, 0), seed)
        if len(part.spin) > 0:
            noise[2 * count + i] = normals(counter_of(i, step, SPINS), seed)[0]


@composed
def predict_coupled(
    part: CoupledKicks, parts: Parts, scratches: Scratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Add thermal noise, with displacements of the covariance 2 kT M dt, and the current to the velocities that
    `fastest_coupled` computed.
    """
    own = scratches.integrator
    if parameters.drift.thermal > 0.0:
        noise, moved = np.empty(len(own.motion)), np.empty(len(own.motion))
        fill_normals(part, int(state.step[0]), parameters.drift.seed, noise)
        root(own.mobility, part, noise, moved)
        add_times(own.motion, math.sqrt(2.0 * parameters.drift.thermal / parameters.time_step), moved)
    add_current(own.motion, own.current)
    store_velocities(own.motion, state, workspace)


@compiled
def add_times(to: Array, factor: float, other: Array) -> None:
    """Add a multiple of a vector."""
    for k in range(len(to)):
        to[k] += factor * other[k]


@compiled
def add_current(motion: Array, current: Array) -> None:
    """Add the current to the velocities relative to it."""
    for i in range(len(current)):
        motion[2 * i] += current[i, 0]
        motion[2 * i + 1] += current[i, 1]


@compiled
def store_velocities(motion: Array, state: State, workspace: Workspace) -> None:
    """Write the velocities and midstep velocities."""
    for i in range(len(state.velocity)):
        for axis in range(2):
            state.velocity[i, axis] = motion[2 * i + axis]
            workspace.midstep_velocity[i, axis] = motion[2 * i + axis]


@composed
def add_coupled_work(
    part: CoupledKicks, scratch: CoupledScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Add the work of the current in one step. With thermal noise, the heat contains this work."""
    copy_rows(workspace.stages[PUSHED], workspace.force)
    if not parameters.drift.thermal > 0.0 and len(state.tally) > WORK:
        state.tally[WORK] += parameters.time_step * power_on_floats(scratch.load, scratch.current)


@compiled
def add_coupled_heat(
    part: CoupledKicks,
    scratch: CoupledScratch,
    parameters: Parameters,
    state: State,
    workspace: Workspace,
    ahead: float,
) -> None:
    """Add the heat of half a step with thermal noise, by the forces at its beginning or end; without it, correct the
    work of the current by half of the change of the forces, which is 0 at the beginning.
    """
    if len(state.tally) <= WORK:
        return
    velocity, force, power = workspace.midstep_velocity, workspace.force, 0.0
    if parameters.drift.thermal > 0.0:
        for i in range(len(force)):
            power += force[i, 0] * velocity[i, 0] + force[i, 1] * velocity[i, 1]
    else:
        first = workspace.stages[PUSHED]
        for i in range(len(force)):
            for axis in range(2):
                power += (force[i, axis] - first[i, axis]) * scratch.current[i, axis]
    state.tally[WORK] -= 0.5 * parameters.time_step * power


@compiled
def power_on_floats(load: Array, current: Array) -> float:
    """The power -F u of the current on the floats (W), with all forces F on them including contacts: the liquid exerts
    -F, and u is its velocity far from the floats. The remaining power of the liquid is dissipated.
    """
    power = 0.0
    for i in range(len(current)):
        power -= load[2 * i] * current[i, 0] + load[2 * i + 1] * current[i, 1]
    return power


class CoupledImpulses(NamedTuple):
    """Contacts that are solved with the mobility of all floats, with or without friction."""

    friction: tuple[float, float]
    """coefficients of friction between two floats, and at walls"""
    inertia: Array
    """(N,) kg m^2 of floats that turn; (0,) without friction"""
    overlapping: bool = False
    """see `collisions.Impulses`"""


def rubbing_impulses_of(parameters: Parameters, scene: FloatingScene, interactions: tuple[Any, ...]) -> Built:
    """Return contacts with friction."""
    made: Friction = friction_of(parameters, scene, interactions).part
    return Built(CoupledImpulses(made.friction, made.inertia, False))


def smooth_impulses_of(parameters: Parameters, scene: FloatingScene, interactions: tuple[Any, ...]) -> Built:
    """Return contacts without friction."""
    return Built(CoupledImpulses((0.0, 0.0), np.zeros(0)))


@composed
def collide_coupled(
    part: CoupledImpulses, scratch: CoupledScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Solve for the midstep velocities, so that no float overlaps another after the step."""
    gather_contacts(parameters, state, workspace)
    if parameters.drift.thermal > 0.0:
        collide_coupled_paths(part, scratch, parameters, state, workspace)
    goal = begin_contacts(parameters, state, workspace)
    if goal.target > 0.0:
        push(scratch.mobility, part, scratch, parameters, state, workspace, goal)
    else:
        clear_impulses(workspace.contacts)
    keep_contacts(state, workspace)
    store_velocities(scratch.motion, state, workspace)
    turn(part, scratch.motion, parameters.time_step, state)


@compiled
def keep_contacts(state: State, workspace: Workspace) -> None:
    """Store the impulses for the next step."""
    memory = memory_of(state)
    touching.remember(touching.contact_keys(workspace.contacts), workspace.contacts.impulse, memory, memory.impulse)


@compiled
def turn(part: CoupledImpulses, motion: Array, time: float, state: State) -> None:
    """Store the spins of floats with friction, and advance their angles."""
    for i in range(len(part.inertia)):
        state.turning[i, 1] = motion[2 * len(state.turning) + i]
        state.turning[i, 0] += time * state.turning[i, 1]


@composed
def collide_coupled_paths(
    part: CoupledImpulses, scratch: CoupledScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Compute the frictionless collisions of Brownian floats on their paths, and the response of all floats."""
    contacts = workspace.contacts
    share = shares(scratch.mobility, contacts, state.position)
    lasting: Integers = np.ones(len(scratch.current), np.int64)
    if len(part.inertia) == 0:
        motion = workspace.midstep_velocity, workspace.stages[DRIVEN]
        found = collide_on_paths(parameters, state, contacts, motion, share, scratch.flow)
        lasting = found.lasting
        if len(found.impulse) > 0:
            load, moved = np.zeros(len(scratch.motion)), np.zeros(len(scratch.motion))
            load_forces(found.impulse, load)
            apply(scratch.mobility, load, moved)
            add_times(scratch.load, 1.0, load)
            add_times(scratch.motion, 1.0, moved)
            store_velocities(scratch.motion, state, workspace)
    require_distances(parameters, state, contacts, workspace.midstep_velocity, share, lasting)


@compiled
def gather_contacts(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Find the contacts of this step."""
    contacts = workspace.contacts
    # Twice the travel for a head-on pair; another factor of two for floats that other floats push.
    reach = 4.0 * workspace.travel[0] + parameters.slop
    touching.gather(contacts, workspace.candidates, state.position, contact_bodies(parameters), reach)
    require_gaps(False, parameters, contacts)


@compiled
def begin_contacts(parameters: Parameters, state: State, workspace: Workspace) -> Tolerance:
    """Start from the impulses of the last step; return the tolerance of their solution."""
    contacts = workspace.contacts
    memory = memory_of(state)
    touching.recall(touching.contact_keys(contacts), contacts.impulse, memory, memory.impulse)
    touching.normal_velocities(contacts, workspace.midstep_velocity, contacts.scratch)
    return goal_of(parameters, contacts)


@compiled
def push_by_matrix(
    mobility: MobilityMatrix,
    part: CoupledImpulses,
    scratch: CoupledScratch,
    parameters: Parameters,
    state: State,
    workspace: Workspace,
    goal: Tolerance,
) -> None:
    """Solve for the forces of all contacts, with friction, and change the motion by them."""
    contacts, memory, turning = workspace.contacts, memory_of(state), len(part.inertia) > 0
    rows = dense_rows_of(part, contacts, parameters, len(scratch.motion))
    if turning:
        recall_friction(rows, contacts, memory, state.friction_impulse, parameters.time_step)
    sweeps = impulse_solvers.solve(CoupledContacts(rows, mobility.matrix), scratch.motion, goal)
    state.tally[SWEEPS] += sweeps
    state.tally[UNCONVERGED] += 1.0 if sweeps > impulse_solvers.MOST_SWEEPS else 0.0
    keep_impulses(rows, contacts, parameters, scratch)
    if turning:
        tangential_impulse = parameters.time_step * rows.impulse[contacts.total[0] :]
        touching.remember(touching.contact_keys(contacts), tangential_impulse, memory, state.friction_impulse)


RESIDUAL = 5e-4
"""The largest approach of touching floats after a solve by products, over that before it."""
TOLERABLE = 0.1
"""The largest approach in a step that still counts as converged, over the tolerated overlap."""


def push_by_products(
    mobility: MobilityOnGrid,
    part: CoupledImpulses,
    scratch: CoupledScratch,
    parameters: Parameters,
    state: State,
    workspace: Workspace,
    goal: Tolerance,
) -> None:
    """Solve for the forces of all contacts and add the velocities that they cause."""
    contacts, count, total = workspace.contacts, len(scratch.current), int(workspace.contacts.total[0])
    contacts.weight[:total] = 1.0 / shares(mobility, contacts, state.position).sum(axis=1)
    contacts.impulse[:total] /= parameters.time_step
    velocity = workspace.midstep_velocity.copy()

    def respond(force: Array) -> Array:
        moved = np.zeros_like(force)
        moved[:count] = flow_product(mobility.grid[0], force[:count])
        return moved

    fastest = float(np.max(contacts.bound[:total] - contacts.scratch[:total]))
    target, acceptable = max(goal.target, RESIDUAL * fastest), TOLERABLE * parameters.slop / parameters.time_step
    products = mobility_contacts.solve_by_products(contacts, velocity, respond, target, acceptable)
    state.tally[SWEEPS] += products
    state.tally[UNCONVERGED] += 1.0 if products > mobility_contacts.MOST_PRODUCTS else 0.0
    force = np.zeros_like(velocity)
    mobility_contacts.spread_forces(contacts, contacts.impulse, force)
    scratch.load[:] += force[:count].ravel()
    scratch.motion[:] = velocity[:count].ravel()
    contacts.impulse[:total] *= parameters.time_step


@compiled
def dense_rows_of(part: CoupledImpulses, contacts: Contacts, parameters: Parameters, size: int) -> DenseRows:
    """Return the rows of all contacts; their unknowns are mean forces, which are impulses over the time step."""
    total, count, radius = contacts.total[0], len(parameters.floats.radius), parameters.floats.radius
    turning = len(part.inertia) > 0
    rows = make_dense_rows(2 * total if turning else total, total, size)
    for row in range(total):
        i, j, x, y = contacts.first[row], contacts.second[row], contacts.normal[row, 0], contacts.normal[row, 1]
        rows.bound[row] = contacts.bound[row]
        rows.impulse[row] = contacts.impulse[row] / parameters.time_step
        set_direction(rows, row, (i, j), (x, y), count)
        if turning:
            among_floats = j < count
            rows.friction[row] = part.friction[0] if among_floats else part.friction[1]
            set_direction(rows, total + row, (i, j), (-y, x), count)
            rows.place[total + row, 4] = 2 * count + i
            rows.value[total + row, 4] = -(radius[i] + (0.5 if among_floats else 1.0) * contacts.gap[row])
            if among_floats:
                rows.place[total + row, 5] = 2 * count + j
                rows.value[total + row, 5] = -(radius[j] + 0.5 * contacts.gap[row])
    return rows


@compiled_inside
def set_direction(rows: DenseRows, row: int, pair: tuple[int, int], way: tuple[float, float], count: int) -> None:
    """Write the row of the relative velocity of two bodies in one direction; walls are at rest."""
    i, j = pair
    for axis in range(2):
        rows.place[row, axis], rows.value[row, axis] = 2 * i + axis, -way[axis]
        if j < count:
            rows.place[row, 2 + axis], rows.value[row, 2 + axis] = 2 * j + axis, way[axis]


@compiled
def recall_friction(
    rows: DenseRows, contacts: Contacts, memory: Memory, tangential_impulse: Array, time: float
) -> None:
    """Start from the tangential impulses of the previous step, converted to mean forces."""
    total = contacts.total[0]
    touching.recall(touching.contact_keys(contacts), rows.impulse[total:], memory, tangential_impulse)
    for row in range(total):
        rows.impulse[total + row] /= time


@compiled
def keep_impulses(rows: DenseRows, contacts: Contacts, parameters: Parameters, scratch: CoupledScratch) -> None:
    """Store the impulses of the contacts, and add their forces to those on the floats."""
    for row in range(contacts.total[0]):
        contacts.impulse[row] = parameters.time_step * rows.impulse[row]
    for row in range(len(rows.impulse)):
        for entry in range(mobility_contacts.ENTRIES):
            scratch.load[rows.place[row, entry]] += rows.value[row, entry] * rows.impulse[row]


PUSHES: dict[type, Callable[..., None]] = {MobilityMatrix: push_by_matrix, MobilityOnGrid: push_by_products}
push = by_type(PUSHES.__getitem__, 0)
"""The solver of contacts for each mobility."""
