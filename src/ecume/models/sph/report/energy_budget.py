"""Energies of the liquid and the bodies, and the external work on them. Energy minus work never increases.

Moving walls, driven bodies (see `boundaries.driven_bodies`), and the liquid behind inflows and outflows do work by
their forces F, pair by pair as in the sums over neighbors. The work of a wall is W = integral of F.w dt with its force
F on the liquid and its velocity w; that of a shaken tank is the integral of M.a with the apparent acceleration a and
the momentum M. A buffer particle b does F_ib.(v_i + v_b)/2 on the particle i before it: the energy flux of a pair, the
mean of what i gains and b loses. The rest, F_ib.(v_i - v_b)/2, is dissipated if the force is viscous, and compresses i
if it is pressure, up to (P_i - P_b)(v_i - v_b)/2, of second order. Particles that cross a border carry their energy,
and particles that cross a periodic side are lifted, in gravity, by the length of the tank.

Density diffusion changes the elastic energy; this is work of the numerical method: see `add_diffusion_work`. So does
the pressure of dummies, which approaching liquid compresses although dummies store no energy: see `power_of_dummies`.
In an incompressible liquid the correction of the density does work: see `projection.add_remaining_work`.

Rates are integrated by the trapezoidal rule, which is exact for kicks: each force acts half before and half after the
velocity by which it is multiplied.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ecume._jit import admit, compiled, prange, spread
from ecume._portable import dot, product
from ecume.engine.cells import Integers
from ecume.engine.neighbor_rows import Lists, pairs_in
from ecume.engine.walls.sheets import SIZE, SPEED
from ecume.laws import states
from ecume.laws.kernels import KERNELS, kernel
from ecume.laws.states import tait_energy
from ecume.models.sph.boundaries.driven_bodies import power_of_driven_bodies
from ecume.models.sph.boundaries.forces_on_solids import force_of_mirror, forces_on, roots_of
from ecume.models.sph.boundaries.rigid_bodies import added_gravity, energy_of_bodies, with_moved_solids
from ecume.models.sph.boundaries.rolling import inertial_accelerations
from ecume.models.sph.boundaries.touching_solids import power_on_bodies
from ecume.models.sph.boundaries.walls import braked_by_wall, repelled_by_wall
from ecume.models.sph.fields import FIELD, Constants, Floats
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.rates.dummy_compression import taken_up, takes_up
from ecume.models.sph.rates.fill_fields import fill_images
from ecume.models.sph.rates.kernel_loops import slope_of
from ecume.models.sph.state import RATE, WORK, State, Workspace, particle_arrays, put_dummies
from ecume.units import Array

admit(states)


def energies(parameters: Parameters, state: State, propped: float, surface: float) -> Mapping[str, float]:
    """The kinetic, potential, elastic (with the repulsion of walls) and surface energy, and the energy of the bodies
    (J); the acceleration of a shaken tank counts as work.
    """
    waves = parameters.pressure_method.compressible
    kinetic = 0.5 * float(np.sum(state.mass * (state.velocity**2).sum(axis=0)))
    potential = potential_of(parameters, state.mass, state.position)
    stored = sum(
        float(np.sum(state.mass[who] * elastic_energies(state.density[who], *liquid.laws)))
        for liquid, who in parameters.parts(state.region)
        if waves
    )
    elastic = stored + propped
    bodies = energy_of_bodies(parameters, state.pose, state.motion)
    return {
        "kinetic_energy": kinetic,
        "potential_energy": potential,
        "elastic_energy": elastic,
        "surface_energy": surface,
        "bodies_energy": bodies,
        "total_energy": kinetic + potential + elastic + surface + bodies,
    }


def spreading_energy(now: Parameters, state: State, workspace: Workspace) -> float:
    """The energy (J) of the pressure whose gradient is not completed, from a filled workspace: see `rates.corrections`.
    It is zero in the interior of a lattice at the reference density, and negative at a surface. A dummy counts once:
    see `power_of_dummies`.
    """
    if now.spreading_pressure == 0.0:
        return 0.0
    lists, fields, count = workspace.lists, workspace.fields, state.position.shape[1]
    rest, length = now.material.density, float(now.numbers.smoothing_length)
    resting = np.where(fields.liquid > 0.0, fields.volume * fields.density / rest, fields.volume).astype(np.float64)
    form = kernel(list(KERNELS)[int(now.numbers.kernel)], dim=now.dimension)
    mine, place = pairs_in(lists, count)
    who = lists.neighbor[place]
    apart = np.sqrt(((fields.position[:, who] - fields.position[:, mine]) ** 2).sum(axis=0))
    pairs = np.bincount(mine, form.value(apart, length) * resting[who], count)
    own = state.mass / rest
    around = pairs + own * form.value(0.0, length)
    return now.spreading_pressure * float(np.sum(own * (around - 1.0)) + np.sum(state.mass / state.density - own))


@compiled
def elastic_energies(density: Array, reference_density: float, sound_speed: float, exponent: float) -> Array:
    """The `tait_energy` of each particle (J/kg), computed with the power function of the C library."""
    found = np.empty_like(density)
    for i in range(len(density)):
        found[i] = tait_energy(density[i], reference_density, sound_speed, exponent)
    return found


def potential_of(parameters: Parameters, mass: Array, position: Array) -> float:
    """The potential energy (J) in gravity and in the central pull at positions (d, N)."""
    potential = -float(np.sum(mass * product(parameters.gravity, position)))
    away = position - parameters.pull_center[:, None]
    return potential + 0.5 * parameters.pull_rate**2 * float(np.sum(mass * (away**2).sum(axis=0)))


def energy_of(parameters: Parameters, state: State, who: Any) -> float:
    """The kinetic, potential and elastic energy of some particles (J)."""
    some = subset(state, who)
    alone = energies(parameters, some, 0.0, 0.0)
    return alone["total_energy"] - alone["bodies_energy"]


def liquid_alone(parameters: Parameters, state: State) -> State:
    """The state without the buffers behind inflows and outflows."""
    return subset(state, state.zone == 0) if parameters.open_boundaries else state


def subset(state: State, who: Any) -> State:
    """The state of some of the particles."""
    return state._replace(**{name: array[..., who] for name, array in particle_arrays(state).items()})


def shaken(parameters: Parameters) -> bool:
    """Whether the frame of the tank is accelerated."""
    return parameters.base_excitation is not None or parameters.roll is not None


def has_external_work(parameters: Parameters) -> bool:
    """Whether any process may add or remove energy."""
    around = product(parameters.boundary.sides.shift, parameters.gravity)
    outside = has_work_of_forces(parameters) or around.any()
    return bool(has_numerical_work(parameters) or outside or may_lose_liquid(parameters))


def has_numerical_work(parameters: Parameters) -> bool:
    """Whether density diffusion, the conservation of volume, dummies, or the correction of the density of an
    incompressible liquid do work.
    """
    diffuses = parameters.density_diffusion.excess is not None or parameters.fixed_volume
    return diffuses or dummies_work(parameters) or parameters.projection is not None


def has_work_of_forces(parameters: Parameters) -> bool:
    """Whether base excitation, moving walls, buffers, dummies or user laws do work."""
    return shaken(parameters) or forces_work(parameters)


def forces_work(parameters: Parameters) -> bool:
    """Whether moving walls, buffers, dummies or user laws do work."""
    sliding = len(moving_sides(parameters)) or dummies_work(parameters)
    moving = parameters.drives or parameters.bodies.paths or parameters.open_boundaries or sliding
    return bool(moving or parameters.user_forces is not None)


def dummies_work(parameters: Parameters) -> bool:
    """Whether dummies do work; it is known for forces that are sums of two pressures."""
    compressed = parameters.pressure_method.compressible and not parameters.pressure_force.transported
    return bool(parameters.boundary.dummies.position.shape[1]) and compressed


def may_lose_liquid(parameters: Parameters) -> bool:
    """Whether liquid may leave through a side; sides that it could reach only by rising do not count."""
    outwards = np.array([-parameters.gravity, parameters.gravity])
    return bool((np.isfinite(parameters.bounds) & (outwards >= 0.0)).any())


def has_unbudgeted_work(parameters: Parameters) -> bool:
    """Whether surface tension does work outside the energy budget: it acts on moving solids, but is not part of the
    loads.
    """
    return parameters.tension != "none" and bool(
        parameters.drives or parameters.open_boundaries or parameters.bodies.shapes
    )


def add_diffusion_work(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Add the work of density diffusion in a step, before its densities change: it changes the elastic energy without
    any motion, and the resulting pressure may lift the liquid. It also does work against the acoustic damping, which in
    total dissipates (zeta/rho^2) V (drho/dt)^2.
    """
    if parameters.density_diffusion.excess is None and not parameters.fixed_volume:
        return
    fields, rates, count = workspace.fields, workspace.rates, len(state.density)
    rows = state.mass, state.density, fields.pressure[:count], rates.diffusion[:count], state.density_rate
    damping = parameters.bulk_viscosity * parameters.pressure_force.damping_shares(fields, count)
    work = 0.0
    for liquid, who in parameters.parts(state.region):
        mass, density, pressure, diffusion, rate = (each[who] for each in rows)
        zone, bulk = state.zone[who], damping[who] * parameters.damping_ratio(liquid)
        work += diffusion_work(mass, density, pressure, diffusion, rate, zone, liquid.sound_speed, bulk, time)
    state.budget[WORK] += work
    state.numerical[WORK] += work


@compiled
def diffusion_work(
    mass: Array,
    density: Array,
    pressure: NDArray[np.floating[Any]],
    diffusion: NDArray[np.floating[Any]],
    density_rate: Array,
    zone: Integers,
    sound_speed: float,
    bulk_viscosity: Array,
    time: float,
) -> float:
    """The work sum_i m_i p/rho^2 (drho/dt of diffusion) dt (J), with the pressure in the middle of the change of
    density, and with the damping.
    """
    total = 0.0
    for i in range(len(mass)):
        if zone[i] == 0:
            middle = pressure[i] + 0.5 * sound_speed * sound_speed * density_rate[i] * time
            middle += bulk_viscosity[i] * density_rate[i] / density[i]
            total += mass[i] / (density[i] * density[i]) * middle * diffusion[i] * time
    return total


def add_work(
    parameters: Parameters, state: State, workspace: Workspace, began: tuple[float, bool], time: float
) -> None:
    """Add the work of a completed step, if any force does work; `began` contains the power (W) before it, and whether
    the forces were known then.
    """
    if parameters.projection is not None:  # the forces of these particles act during the whole step
        pulled = 0.5 * (began[0] + power_of_base_excitation(parameters, state))
        state.budget[WORK] += (float(state.budget[RATE]) + pulled) * time
        state.budget[RATE] = 0.0
        return
    # Positions that are not finite are reported by the time integration.
    with np.errstate(over="ignore", invalid="ignore"):
        rate, numerical = powers_of_forces(with_moved_solids(parameters, state), state, workspace)
    before, known = began
    after = rate + power_of_base_excitation(parameters, state)
    state.budget[WORK] += 0.5 * ((before if known else before + rate) + after) * time
    state.budget[RATE] = rate
    state.numerical[WORK] += 0.5 * ((float(state.numerical[RATE]) if known else numerical) + numerical) * time
    state.numerical[RATE] = numerical


def power_of_base_excitation(parameters: Parameters, state: State) -> float:
    """The power (W, in the frame of the tank) of base excitation and roll on liquid and bodies: acceleration times
    momentum.
    """
    time = float(state.clock[0])
    pull = added_gravity(parameters, time)
    if pull is None:
        return 0.0
    liquid = liquid_alone(parameters, state)
    momentum = np.sum(liquid.mass * liquid.velocity, axis=1)
    if parameters.bodies.shapes:
        free = np.isfinite(parameters.bodies.mass)
        momentum = momentum + np.sum((state.motion[: len(pull)] * parameters.bodies.mass)[:, free], axis=1)
    power = dot(pull, momentum)
    if parameters.roll is not None:
        inertial = inertial_accelerations(parameters.roll, time, liquid.position, liquid.velocity)
        power += float(np.sum(liquid.mass * (inertial * liquid.velocity).sum(axis=0)))
    return power


def power_of_forces(now: Parameters, state: State, workspace: Workspace) -> float:
    """The power (W) of moving sides, buffers, dummies and user laws, from a filled workspace."""
    return powers_of_forces(now, state, workspace)[0]


def powers_of_forces(now: Parameters, state: State, workspace: Workspace) -> tuple[float, float]:
    """The power (W) of all external forces, and its part by the compression of dummies."""
    power, compressing = 0.0, 0.0
    if workspace.user_acceleration is not None:
        inside = state.zone == 0
        power += float(np.sum((state.mass * (workspace.user_acceleration * state.velocity).sum(axis=0))[inside]))
    for row in moving_sides(now):
        power += power_of_side(now, state, workspace, int(row))
    if len(moving_dummies(now)):
        power += power_of_moving_dummies(now, workspace)
    power += power_of_driven_bodies(now, state, workspace)
    if dummies_work(now):
        compressing = power_of_dummies(now, state, workspace)
        power += compressing
    if now.bodies.shapes:
        power += power_on_bodies(now, state, workspace)
    return power + power_of_buffers(now, state, workspace) if now.open_boundaries else power, compressing


def moving_sides(now: Parameters) -> Integers:
    """The rows of moving mirrors in the table of sides."""
    boundary, d = now.boundary, now.dimension
    return np.flatnonzero((boundary.image_owner >= 0) & boundary.table[:, 2 * d : 3 * d].any(axis=1))


def power_of_side(now: Parameters, state: State, workspace: Workspace, row: int) -> float:
    """The power (W) of a moving side on images and on repelled particles."""
    boundary, d = now.boundary, now.dimension
    side, velocity = int(boundary.image_owner[row]), boundary.table[row, 2 * d : 3 * d]
    normal, place = boundary.sides.normal[row], boundary.sides.point[row]
    near = np.flatnonzero(product(normal, state.position - place[:, None]) < now.support)
    position, moving = (np.ascontiguousarray(vectors[:, near]) for vectors in (state.position, state.velocity))
    few = state._replace(position=position, velocity=moving, mass=state.mass[near])
    pushed = repelled_by_wall(now, few, side), braked_by_wall(now, few, side)
    force = np.sum([np.sum(each.acceleration * few.mass[each.who], axis=1) for each in pushed], axis=0)
    for axis in np.flatnonzero(velocity):
        force[axis] += force_of_mirror(now, workspace, near, (side, int(axis)))
    return dot(force, velocity)


def moving_dummies(parameters: Parameters) -> Integers:
    """The dummies of walls that move parallel to their surface."""
    dummies = parameters.boundary.dummies
    return np.flatnonzero(dummies.velocity.any(axis=0) & (dummies.owner < 2 * parameters.dimension))


def power_of_moving_dummies(now: Parameters, workspace: Workspace) -> float:
    """The power (W) of moving layers of dummies; only periodic sides have images next to them."""
    mine, first = moving_dummies(now), workspace.rates.shape[1]
    group = np.zeros(workspace.fields.shape[1], np.int64)
    force = forces_on(now, workspace, first + mine, group)[0]
    return -float(np.sum(force[: now.dimension] * now.boundary.dummies.velocity[:, mine]))


def power_of_dummies(now: Parameters, state: State, workspace: Workspace) -> float:
    """The power (W) of the pressure of dummies, in addition to that of their forces and their motion.

    A pair of liquid i and dummy w changes the kinetic energy by w_i w_w F (P_i + P_w) x_iw.v_i and the elastic energy
    of i by w_i w_w F P_i x_iw.(v_w - v_i). Their sum is the force times v_w, plus w_i w_w F P_w x_iw.(v_i - v_w): the
    dummy is compressed like liquid, but has no elastic energy. The liquid stores most of this work instead: see
    `rates.dummy_compression`. The remainder is that of the weight of the liquid between, and of clipped pressures.
    """
    fields, lists, images, count = workspace.fields, workspace.lists, workspace.images, state.position.shape[1]
    real, d = len(lists.counts), now.dimension
    fields.velocity[:d, :count] = state.velocity
    if now.moves:
        put_dummies(now, fields, count)
    if len(images.source):
        table = now.boundary.table.copy()
        table[:, :d] -= now.origin
        fill_images(images.source, fields.table, real, images.start, table, now.gravity, now.equation_of_state)
    counted = fields.liquid.copy()
    if now.open_boundaries:
        root = np.concatenate([np.arange(real), roots_of(images, real)])
        counted[(root < count) & (state.zone[np.minimum(root, count - 1)] > 0)] = 0.0
    power = np.zeros(real - count)
    dummy_powers(fields.table, counted, count, lists, now.constants, power)
    stored = power_taken_up(now, state, workspace) if now.bodies.shapes and takes_up(now) else 0.0
    return float(np.sum(power)) + stored


def power_taken_up(now: Parameters, state: State, workspace: Workspace) -> float:
    """The power (W) by which the liquid stores the compression of dummies, from filled fields."""
    fields, count = workspace.fields, state.position.shape[1]
    stored = (fields.weight * fields.force_term)[:count] * taken_up(now, state, workspace)
    return float(np.sum(stored[state.zone == 0]))


@spread
def dummy_powers(
    fields: Floats, counted: Floats, first: int, lists: Lists, constants: Constants, power: Array
) -> None:  # fmt: skip
    """The power (W) of each dummy, from column `first` on: minus w P times the rate at which the counted liquid
    compresses it.
    """
    kernel, scale, inverse = constants[0].kernel, constants[0].slope_factor, constants[0].inverse_length
    deep = constants[0].dimension == 3
    counts, start, neighbor = lists
    for place in prange(len(power)):
        i = first + place
        if fields[FIELD.force_term, i] == 0.0:
            continue
        total = 0.0
        for k in range(counts[i]):
            j = neighbor[start[i] + k]
            dx = fields[FIELD.position, j] - fields[FIELD.position, i]
            dy = fields[FIELD.position + 1, j] - fields[FIELD.position + 1, i]
            square = dx * dx + dy * dy
            radial = (fields[FIELD.velocity, j] - fields[FIELD.velocity, i]) * dx
            radial += (fields[FIELD.velocity + 1, j] - fields[FIELD.velocity + 1, i]) * dy
            if deep:
                dz = fields[FIELD.position + 2, j] - fields[FIELD.position + 2, i]
                square += dz * dz
                radial += (fields[FIELD.velocity + 2, j] - fields[FIELD.velocity + 2, i]) * dz
            total += slope_of(math.sqrt(square) * inverse, kernel) * fields[FIELD.weight, j] * counted[j] * radial
        power[place] = -scale * fields[FIELD.weight, i] * fields[FIELD.force_term, i] * total


def power_of_buffers(now: Parameters, state: State, workspace: Workspace) -> float:
    """The power (W) of the liquid behind inflows and outflows: the mean of gain and loss over the two particles of each
    pair.
    """
    real, liquid = len(workspace.lists.counts), workspace.rates.shape[1]
    root = np.concatenate([np.arange(real), roots_of(workspace.images, real)])
    held = np.zeros(real, np.int64)
    held[:liquid] = np.where(state.zone > 0, 1, 2)
    buffer, inside = (np.where(held[root] == kind, 0, -1) for kind in (1, 2))
    behind, before = np.flatnonzero(state.zone > 0), before_gates(now, state)
    lost = forces_on(now, workspace, behind, inside)[0]
    gained = forces_on(now, workspace, before, buffer)[0]
    d = now.dimension
    return 0.5 * float(np.sum(gained[:d] * state.velocity[:, before]) - np.sum(lost[:d] * state.velocity[:, behind]))


def before_gates(now: Parameters, state: State) -> Integers:
    """The liquid within reach of buffers."""
    near = np.zeros(len(state.zone), np.bool_)
    for opening in now.open_boundaries:
        near |= np.abs(state.position[opening.axis] - opening.place) < 2.0 * now.support
    return np.flatnonzero(near & (state.zone == 0))


def periodic_work(parameters: Parameters, state: State, out: NDArray[np.bool_], shift: Array) -> float:
    """The work (J) of moving liquid from one periodic side to the other."""
    who = out & (state.zone == 0)
    mass, position = state.mass[who], state.position[:, who]
    return potential_of(parameters, mass, position + shift[:, None]) - potential_of(parameters, mass, position)


def exchanged_energy(parameters: Parameters, state: State, entering: Array, leaving: Array) -> float:
    """The energy of entering particles minus that of leaving particles (J); NaN if a position is not finite."""
    with np.errstate(over="ignore", invalid="ignore"):
        return energy_of(parameters, state, entering) - energy_of(parameters, state, leaving)


def reflection_work(now: Parameters, state: State, before: Array) -> float:
    """The work (J) of moving sides on reflected particles, from the velocities before the reflection."""
    work, guard, d = 0.0, now.boundary.guard, now.dimension
    for side, _ in now.drives:
        row = guard.sheet.number[guard.owner == side][0]
        near = product(row[:d], state.position) - row[SIZE] < now.spacing
        change = product(row[:d], (state.velocity - before)[:, near])
        work += dot(row[SPEED : SPEED + d], row[:d]) * dot(state.mass[near], change)
    return work
