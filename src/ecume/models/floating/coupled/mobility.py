"""Hydrodynamic interaction of floats by a mobility matrix: the matrix, the integrator, and
contacts.

The integrator of floats that interact through the liquid is v = u + M F, with Brownian motion. The current u is added
to the velocities instead of a force zeta u: no force acts on floats that drift with the current.

Contacts of floats that interact through the liquid: the impulse of each contact moves all floats. Without inertia
floats do not rebound. One plastic solve for the midstep velocities, with the full mobility, keeps floats from
overlapping after the step.

Films are the near field of each pair. The mobility describes two distant spheres; at small gaps a film also resists
their relative motion. Its friction gives two approaching spheres the exact resistance at any gap: zeta/2 times
lambda(l/R) of `drag.pair_factor` minus the resistance by the mobility alone. Films do not affect a rigid raft, whose
speed follows from the far field.

With films of friction D the velocities v0 become v = v0 - M J^T D J v. This is solved for psi = D^(1/2) J v,
(1 + D^(1/2) J M J^T D^(1/2)) psi = D^(1/2) J v0, by conjugate gradients.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._jit import admit, compiled, compiled_inside, composed
from ecume.engine.cells import Integers
from ecume.engine.contact import contacts as touching
from ecume.engine.contact import impulse_solvers, mobility_contacts
from ecume.engine.contact.contacts import Contacts, Memory
from ecume.engine.contact.impulse_solvers import Tolerance
from ecume.engine.contact.mobility_contacts import CoupledContacts, DenseRows, make_dense_rows
from ecume.engine.linear_solvers.lanczos import root_product
from ecume.engine.philox import counter_of, normals
from ecume.laws import pair_mobility
from ecume.laws.moving_dish import sway_velocity
from ecume.laws.pair_mobility import rotne_prager, spin_by_force, spin_by_torque, surface_divergence
from ecume.models.floating.contacts.collisions import (
    Friction,
    clear_impulses,
    contact_bodies,
    friction_of,
    goal_of,
    require_gaps,
)
from ecume.models.floating.contacts.thermal_collisions import Flow, collide_on_paths, require_distances
from ecume.models.floating.forces.films import (
    MOST_ITERATIONS,
    TOLERANCE,
    Films,
    Pairs,
    films_within,
    find_films,
    reduced_float,
)
from ecume.models.floating.forces.flow_and_noise import current_at
from ecume.models.floating.options import Built
from ecume.models.floating.parameters import (
    DRIVEN,
    SWEEPS,
    UNCONVERGED,
    WORK,
    Parameters,
    Parts,
    Scratch,
    State,
    Workspace,
    memory_of,
)
from ecume.models.liquids import liquid_of
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene

admit(pair_mobility)


class CoupledKicks(NamedTuple):
    """Constants of floats that interact through the flow of the liquid."""

    radius: Array
    """(N,) m: of the half-immersed sphere with the same drag, 2 f R"""
    spin: Array
    """(N,) 1/(N m s): what the spin of a single float has in addition to that of this sphere; (0,) if no float turns"""
    viscosity: float
    thermal: float
    """J: kT, of the drift kT div M; zero without thermal noise"""


class CoupledScratch(NamedTuple):
    """Workspace of the integrator, the contacts and the films."""

    mobility: Array
    """(M, M) velocities (x, y of each float), then spins if floats turn, by forces and torques"""
    load: Array
    """(M,) forces and torques on all floats, including films and contacts"""
    motion: Array
    """(M,) velocities and spins"""
    current: Array
    """(N, 2) m/s: the velocity of the liquid far from the floats"""
    flow: Flow
    """for collisions"""


def flow_of(part: CoupledKicks) -> Flow:
    """The data that describe how collisions of floats move their neighbors."""
    return Flow(part.radius, 1.0 / (3.0 * math.pi * part.viscosity))


def make_coupled_scratch(part: CoupledKicks) -> CoupledScratch:
    """Return the workspace."""
    count = len(part.radius)
    size = 2 * count + len(part.spin)
    return CoupledScratch(np.zeros((size, size)), np.zeros(size), np.zeros(size), np.zeros((count, 2)), flow_of(part))


def coupled_memory(part: CoupledKicks) -> float:
    """The memory (bytes) of the mobility matrix, and of the responses to each contact of a raft, with three contacts
    per float.
    """
    count, size = len(part.radius), 2 * len(part.radius) + len(part.spin)
    contacts = 3 * count * (2 if len(part.spin) else 1)
    return float(8 * size * (size + contacts))


def coupled_pairs(part: CoupledKicks) -> float:
    """The work of a time step, in units of a pair force: filling the matrix, and multiplying by it, repeatedly for
    thermal noise.
    """
    return (20.0 if part.thermal > 0.0 else 2.0) * len(part.radius) ** 2


def hydrodynamic_radius(parameters: Parameters, viscosity: float) -> Array:
    """The radius of the half-immersed sphere with the same drag as each float: zeta/(3 pi eta)."""
    floats = parameters.floats
    return np.asarray(floats.mass / floats.relaxation_time / (3.0 * math.pi * viscosity))


@compiled
def fill_mobility(part: CoupledKicks, position: Array, mobility: Array) -> None:
    """Compute the mobility matrix at these positions: twice that of whole spheres in unbounded liquid, by the mirror
    symmetry of the flat surface.
    """
    radius, count, turning = part.radius, len(part.radius), len(part.spin) > 0
    unit = 1.0 / (3.0 * math.pi * part.viscosity)
    for i in range(count):
        fill_own_block(part, unit, i, mobility)
        for j in range(i):
            x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
            distance = math.sqrt(x * x + y * y)
            # At zero distance the mobility is isotropic.
            x, y = (x / distance, y / distance) if distance > 0.0 else (1.0, 0.0)
            across, along = rotne_prager(distance, radius[i], radius[j])
            mixed = unit * (along - across) * x * y
            for one, other in ((2 * i, 2 * j), (2 * j, 2 * i)):
                mobility[one, other] = unit * (across + (along - across) * x * x)
                mobility[one + 1, other + 1] = unit * (across + (along - across) * y * y)
                mobility[one, other + 1], mobility[one + 1, other] = mixed, mixed
            if turning:
                fill_spins(part, (i, j), (distance, x, y), mobility)


@compiled
def fill_own_block(part: CoupledKicks, unit: float, i: int, mobility: Array) -> None:
    """Compute the velocity and the spin of a float by the force and the torque on itself."""
    count, radius = len(part.radius), part.radius[i]
    mobility[2 * i, 2 * i], mobility[2 * i + 1, 2 * i + 1] = unit / radius, unit / radius
    mobility[2 * i, 2 * i + 1], mobility[2 * i + 1, 2 * i] = 0.0, 0.0
    if len(part.spin) > 0:
        spin = 2 * count + i
        mobility[spin, spin] = unit * spin_by_torque(0.0, radius, radius) + part.spin[i]
        for axis in range(2):
            mobility[spin, 2 * i + axis], mobility[2 * i + axis, spin] = 0.0, 0.0


@compiled
def fill_spins(part: CoupledKicks, pair: tuple[int, int], way: tuple[float, float, float], mobility: Array) -> None:
    """Compute the spins of two floats by forces and torques on each other, and their velocities by torques; `way` is
    the distance and the unit vector from the first to the second.
    """
    (i, j), (distance, x, y), radius, count = pair, way, part.radius, len(part.radius)
    unit = 1.0 / (3.0 * math.pi * part.viscosity)
    turned = unit * spin_by_torque(distance, radius[i], radius[j])
    mobility[2 * count + i, 2 * count + j], mobility[2 * count + j, 2 * count + i] = turned, turned
    for one, other, sign in ((i, j, -1.0), (j, i, 1.0)):
        # The spin F x d / (8 pi eta d^3); d points from the float with the force to the float that rotates.
        strength = sign * unit * spin_by_force(distance, radius[one], radius[other])
        spin = 2 * count + one
        mobility[spin, 2 * other], mobility[2 * other, spin] = strength * y, strength * y
        mobility[spin, 2 * other + 1], mobility[2 * other + 1, spin] = -strength * x, -strength * x


@compiled
def multiply(matrix: Array, vector: Array, product: Array) -> None:
    """Write the product of a symmetric matrix and a vector: row by row, since sums along a row do not vectorize."""
    product[:] = 0.0
    for row in range(len(matrix)):
        share = vector[row]
        for column in range(len(product)):
            product[column] += share * matrix[row, column]


@compiled
def add_divergence(part: CoupledKicks, position: Array, motion: Array) -> None:
    """Add the drift kT div M, without which floats with thermal noise would accumulate where their mobility is low. The
    divergence is known in closed form; it has no component along the spins.
    """
    radius, unit = part.radius, part.thermal / (3.0 * math.pi * part.viscosity)
    for i in range(len(radius)):
        for j in range(i):
            x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
            distance = math.sqrt(x * x + y * y)
            if distance > 0.0:
                drift = unit * surface_divergence(distance, radius[i], radius[j]) / distance
                motion[2 * i] += drift * x
                motion[2 * i + 1] += drift * y
                motion[2 * j] -= drift * x
                motion[2 * j + 1] -= drift * y


SPINS = 1
"""The purpose of the random numbers of spins; that of velocities is 0."""


@compiled
def fastest_coupled(
    part: CoupledKicks, scratch: CoupledScratch, parameters: Parameters, state: State, workspace: Workspace
) -> float:
    """Compute the velocities by forces, without the current; return the highest speed, NaN if any is NaN."""
    count = len(part.radius)
    fill_mobility(part, state.position, scratch.mobility)
    for i in range(count):
        scratch.load[2 * i], scratch.load[2 * i + 1] = workspace.force[i, 0], workspace.force[i, 1]
    scratch.load[2 * count :] = 0.0
    multiply(scratch.mobility, scratch.load, scratch.motion)
    fill_current(scratch, parameters, state)
    if part.thermal > 0.0:
        store_driven(scratch, workspace)
        add_divergence(part, state.position, scratch.motion)
    return fastest_motion(scratch)


@compiled
def store_driven(scratch: CoupledScratch, workspace: Workspace) -> None:
    """Store the velocities by forces and the current, without noise and without the drift kT div M."""
    for i in range(len(scratch.current)):
        for axis in range(2):
            workspace.stages[DRIVEN, i, axis] = scratch.motion[2 * i + axis] + scratch.current[i, axis]


@compiled
def fastest_motion(scratch: CoupledScratch) -> float:
    """The highest speed of any float with its current, NaN if any is NaN."""
    fastest = 0.0
    for i in range(len(scratch.current)):
        x, y = scratch.motion[2 * i] + scratch.current[i, 0], scratch.motion[2 * i + 1] + scratch.current[i, 1]
        speed = math.sqrt(x * x + y * y)
        # Written so that a NaN is kept.
        if fastest == fastest and not speed <= fastest:
            fastest = speed
    return fastest


@compiled
def fill_current(scratch: CoupledScratch, parameters: Parameters, state: State) -> None:
    """Compute the velocity of the liquid at each float: the flow of the scene, and in a moving dish the velocity of the
    liquid relative to the dish.
    """
    drift, current = parameters.drift, scratch.current
    now = state.step[0] * parameters.time_step
    for i in range(len(current)):
        x, y = 0.0, 0.0
        if drift.flows:
            x, y = current_at(drift, now, state.position[i, 0], state.position[i, 1])
        current[i, 0], current[i, 1] = x, y
    if drift.sway.moves:
        time = (state.step[0] + 0.5) * parameters.time_step
        for axis in range(2):
            speed = drift.sway.velocity[axis] + sway_velocity(drift.sway.amplitude[axis], drift.sway.turning, time)
            for i in range(len(current)):
                current[i, axis] -= drift.sway.slip * speed


@compiled
def add_coupled_noise(part: CoupledKicks, scratch: CoupledScratch, parameters: Parameters, state: State) -> None:
    """Add Brownian motion to the velocities and spins: displacements with the covariance 2 kT M dt."""
    noise, moved = np.empty(len(scratch.motion)), np.empty(len(scratch.motion))
    fill_normals(part, int(state.step[0]), parameters.drift.seed, noise)
    root_product(scratch.mobility, noise, moved)
    far = math.sqrt(2.0 * parameters.drift.thermal / parameters.time_step)
    for k in range(len(moved)):
        scratch.motion[k] += far * moved[k]


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
    """Add thermal noise and the current to the velocities that `fastest_coupled` computed."""
    if parameters.drift.thermal > 0.0:
        add_coupled_noise(part, scratches.integrator, parameters, state)
    add_current(scratches.integrator)
    store_velocities(scratches.integrator, state, workspace)


@compiled
def add_current(scratch: CoupledScratch) -> None:
    """Add the current to the velocities relative to it."""
    for i in range(len(scratch.current)):
        scratch.motion[2 * i] += scratch.current[i, 0]
        scratch.motion[2 * i + 1] += scratch.current[i, 1]


@compiled
def store_velocities(scratch: CoupledScratch, state: State, workspace: Workspace) -> None:
    """Write the velocities and midstep velocities."""
    for i in range(len(scratch.current)):
        for axis in range(2):
            state.velocity[i, axis] = scratch.motion[2 * i + axis]
            workspace.midstep_velocity[i, axis] = scratch.motion[2 * i + axis]


@compiled
def add_coupled_work(
    part: CoupledKicks, scratch: CoupledScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Add the work of the current on the floats in one step, -F u with all forces F on them including contacts: the
    liquid exerts -F, and u is its velocity far from the floats. The remaining work of the liquid is dissipated. With
    thermal noise, the heat already contains this work.
    """
    if parameters.drift.thermal > 0.0 or len(state.tally) <= WORK:
        return
    power = 0.0
    for i in range(len(scratch.current)):
        power -= scratch.load[2 * i] * scratch.current[i, 0] + scratch.load[2 * i + 1] * scratch.current[i, 1]
    state.tally[WORK] += parameters.time_step * power


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


@compiled
def collide_coupled(
    part: CoupledImpulses, scratch: CoupledScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Solve for the midstep velocities, so that no float overlaps another after the step."""
    contacts, memory, turning = workspace.contacts, memory_of(state), len(part.inertia) > 0
    gather_contacts(parameters, state, workspace)
    if parameters.drift.thermal > 0.0:
        collide_coupled_paths(part, scratch, parameters, state, workspace)
    goal = begin_contacts(parameters, state, workspace)
    if goal.target > 0.0:
        rows = dense_rows_of(part, contacts, parameters, len(scratch.motion))
        if turning:
            recall_friction(rows, contacts, memory, state.friction_impulse, parameters.time_step)
        sweeps = impulse_solvers.solve(CoupledContacts(rows, scratch.mobility), scratch.motion, goal)
        state.tally[SWEEPS] += sweeps
        state.tally[UNCONVERGED] += 1.0 if sweeps > impulse_solvers.MOST_SWEEPS else 0.0
        keep_impulses(rows, contacts, parameters, scratch)
        touching.remember(touching.contact_keys(contacts), contacts.impulse, memory, memory.impulse)
        if turning:
            tangential_impulse = parameters.time_step * rows.impulse[contacts.total[0] :]
            touching.remember(touching.contact_keys(contacts), tangential_impulse, memory, state.friction_impulse)
    else:
        clear_impulses(contacts)
        touching.remember(touching.contact_keys(contacts), contacts.impulse, memory, memory.impulse)
    store_velocities(scratch, state, workspace)
    for i in range(len(state.turning) if turning else 0):
        state.turning[i, 1] = scratch.motion[2 * len(state.turning) + i]
        state.turning[i, 0] += parameters.time_step * state.turning[i, 1]


@compiled
def collide_coupled_paths(
    part: CoupledImpulses, scratch: CoupledScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Compute the frictionless collisions of Brownian floats on their paths, and the response of all floats."""
    contacts, count = workspace.contacts, len(scratch.current)
    share = closing_shares(scratch.mobility, count, contacts)
    lasting: Integers = np.ones(count, np.int64)
    if len(part.inertia) == 0:
        motion = workspace.midstep_velocity, workspace.stages[DRIVEN]
        found = collide_on_paths(parameters, state, contacts, motion, share, scratch.flow)
        lasting = found.lasting
        if len(found.impulse) > 0:
            load, moved = np.zeros(len(scratch.motion)), np.zeros(len(scratch.motion))
            for i in range(count):
                load[2 * i], load[2 * i + 1] = found.impulse[i, 0], found.impulse[i, 1]
            multiply(scratch.mobility, load, moved)
            for entry in range(len(moved)):
                scratch.load[entry] += load[entry]
                scratch.motion[entry] += moved[entry]
            store_velocities(scratch, state, workspace)
    require_distances(parameters, state, contacts, workspace.midstep_velocity, share, lasting)


@compiled
def closing_shares(mobility: Array, count: int, contacts: Contacts) -> Array:
    """The velocities of both floats of each contact by opposite unit forces along its normal; walls are at rest."""
    share = np.zeros((contacts.total[0], 2))
    for row in range(len(share)):
        i, j, normal = contacts.first[row], contacts.second[row], contacts.normal
        for one in range(2):
            for other in range(2):
                along = normal[row, one] * normal[row, other]
                share[row, 0] += along * mobility[2 * i + one, 2 * i + other]
                if j < count:
                    mutual = along * mobility[2 * i + one, 2 * j + other]
                    share[row, 0] -= mutual
                    share[row, 1] += along * mobility[2 * j + one, 2 * j + other] - mutual
    return share


@compiled
def gather_contacts(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Find the contacts of this step."""
    contacts = workspace.contacts
    # Twice the travel for a head-on pair, and twice again for floats that others push.
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


admit(pair_mobility)

REACH = 6.0
"""Default distance of centers, in radii, beyond which films are neglected: the mobility alone is within 0.4 % there."""


class CoupledFilms(NamedTuple):
    """Constants of films in addition to the mobility."""

    films: Films
    viscosity: float
    far: float
    """the resistance of two approaching spheres by the mobility alone where films end, over that of single ones"""


def coupled_films_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return the films of a scene."""
    films = films_within(parameters, scene, REACH)
    part = CoupledFilms(films, liquid_of(scene).viscosity_of_both, approach_factor(films.reach, 1.0))
    return Built(part, reach=films.reach * float(parameters.floats.radius.max()))


@compiled
def approach_factor(distance: float, radius: float) -> float:
    """The resistance of two equal approaching spheres according to the mobility, over that of single spheres."""
    return 1.0 / (1.0 - radius * rotne_prager(distance, radius, radius)[1])


@compiled
def apply_coupled_films(
    part: CoupledFilms, scratch: CoupledScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Apply films to the velocities and midstep velocities."""
    pairs = find_films(part.films, parameters, state.position, workspace.lists)
    subtract_far_field(part, parameters, state.position, pairs)
    if len(pairs.friction) > 0:
        solve_with_films(pairs, scratch)
        store_velocities(scratch, state, workspace)


@compiled
def subtract_far_field(part: CoupledFilms, parameters: Parameters, position: Array, pairs: Pairs) -> None:
    """Subtract the resistance that the mobility contains already; films with less friction than this are removed."""
    for row in range(len(pairs.friction)):
        i, j = pairs.first[row], pairs.second[row]
        x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
        # As in `find_films`, two equal spheres of twice the reduced radius.
        radius, friction = reduced_float(parameters, i, j)
        gap = math.sqrt(x * x + y * y) - parameters.floats.radius[i] - parameters.floats.radius[j]
        size = friction / (3.0 * math.pi * part.viscosity * radius)
        known = approach_factor(2.0 + max(gap, 0.0) / radius, size) - part.far
        pairs.friction[row] = max(pairs.friction[row] - 0.5 * friction * known, 0.0)


@compiled
def solve_with_films(pairs: Pairs, scratch: CoupledScratch) -> int:
    """Change the motion by films, and add the forces of the films to those on the floats; return the number of
    iterations.
    """
    total, size = len(pairs.friction), len(scratch.motion)
    strength, weight, found = np.empty(total), np.empty(total), np.zeros(total)
    residual, direction, image = np.empty(total), np.empty(total), np.empty(total)
    force, moved, square = np.zeros(size), scratch.motion.copy(), 0.0
    closing_speeds(pairs, moved, residual)
    for row in range(total):
        strength[row] = math.sqrt(pairs.friction[row])
        weight[row] = 1.0 / (1.0 + pairs.friction[row] * closing_mobility(pairs, row, scratch.mobility))
        residual[row] *= strength[row]
        direction[row] = weight[row] * residual[row]
        square += residual[row] * direction[row]
    goal, iterations = TOLERANCE * TOLERANCE * square, 0
    while square > goal and iterations < MOST_ITERATIONS:
        spread_forces(pairs, strength, direction, force)
        multiply(scratch.mobility, force, moved)
        closing_speeds(pairs, moved, image)
        curvature, last = 0.0, square
        for row in range(total):
            image[row] = direction[row] + strength[row] * image[row]
            curvature += direction[row] * image[row]
        square = 0.0
        for row in range(total):
            found[row] += last / curvature * direction[row]
            residual[row] -= last / curvature * image[row]
            square += weight[row] * residual[row] * residual[row]
        for row in range(total):
            direction[row] = weight[row] * residual[row] + square / last * direction[row]
        iterations += 1
    spread_forces(pairs, strength, found, force)
    multiply(scratch.mobility, force, moved)
    for k in range(size):
        scratch.motion[k] -= moved[k]
        scratch.load[k] -= force[k]
    return iterations


@compiled
def closing_speeds(pairs: Pairs, motion: Array, speed: Array) -> None:
    """Compute the relative velocity of each pair along its line of centers, positive if it separates."""
    for row in range(len(speed)):
        i, j = pairs.first[row], pairs.second[row]
        along = pairs.along[row, 0] * (motion[2 * j] - motion[2 * i])
        speed[row] = along + pairs.along[row, 1] * (motion[2 * j + 1] - motion[2 * i + 1])


@compiled
def closing_mobility(pairs: Pairs, row: int, mobility: Array) -> float:
    """The relative velocity of a pair by opposite unit forces along its line of centers."""
    i, j, total = pairs.first[row], pairs.second[row], 0.0
    for one in range(2):
        for other in range(2):
            both = mobility[2 * i + one, 2 * i + other] + mobility[2 * j + one, 2 * j + other]
            both -= mobility[2 * i + one, 2 * j + other] + mobility[2 * j + one, 2 * i + other]
            total += pairs.along[row, one] * both * pairs.along[row, other]
    return total


@compiled
def spread_forces(pairs: Pairs, strength: Array, share: Array, force: Array) -> None:
    """Compute the forces along the lines of centers on the floats, equal and opposite."""
    force[:] = 0.0
    for row in range(len(share)):
        i, j, push = pairs.first[row], pairs.second[row], strength[row] * share[row]
        for axis in range(2):
            force[2 * i + axis] -= push * pairs.along[row, axis]
            force[2 * j + axis] += push * pairs.along[row, axis]
