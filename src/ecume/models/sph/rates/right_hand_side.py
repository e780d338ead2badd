"""Rates of density and velocity at the present positions: fill the tables, sum over neighbors, store the rates."""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from ecume._jit import admit
from ecume._portable import dot
from ecume.laws import incompressible
from ecume.models.sph.boundaries.driven_bodies import drive_bodies
from ecume.models.sph.boundaries.forces_on_solids import forces_on_dummies, total
from ecume.models.sph.boundaries.open_boundaries import carry_outflows, zero_buffer_rates
from ecume.models.sph.boundaries.rigid_bodies import accelerations_of, apparent_gravity, delay, with_moved_solids
from ecume.models.sph.boundaries.rolling import inertial_accelerations
from ecume.models.sph.boundaries.touching_solids import exchanged_loads
from ecume.models.sph.boundaries.walls import brake_at_walls, repel_from_bodies, repel_from_drawn, repel_from_walls
from ecume.models.sph.fields import number
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.rates.corrections import CORRECTIONS
from ecume.models.sph.rates.dummy_compression import taken_up, takes_up
from ecume.models.sph.rates.fill_fields import fill_images, fill_liquid, fill_weights, read_liquid
from ecume.models.sph.rates.gradients import DENSITY_GRADIENT, GRADIENT_DIFFUSION, set_viscosity
from ecume.models.sph.rates.kernel_loops import require_kernel
from ecume.models.sph.rates.shifting import UNIT, shift
from ecume.models.sph.rates.sum_evaluation import evaluate_sum
from ecume.models.sph.rates.sums import PRESSURE, store_acceleration, store_density_rate
from ecume.models.sph.rates.surface_tension import add_surface_tension
from ecume.models.sph.state import State, Workspace, put_dummies
from ecume.units import Array

admit(incompressible)


def evaluate_density_rate(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Evaluate the rate of density at the present positions."""
    parameters = with_moved_solids(parameters, state)
    fill(parameters, state, workspace)
    _sum_stretch(parameters, state, workspace)
    _store_density_rate(parameters, state, workspace)


def evaluate_accelerations(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Evaluate the accelerations at the present positions, and the transport velocity of the next drift. Acoustic
    damping uses the state's rate of density.
    """
    parameters = with_moved_solids(parameters, state)
    fill(parameters, state, workspace)
    _sum_pressure(parameters, workspace)
    _store_acceleration(parameters, state, workspace, time, 0.5 * time)


def take_other_forces(parameters: Parameters, state: State, workspace: Workspace, time: float, kick: float) -> None:
    """Evaluate the accelerations at the present positions without the pressure for a kick (s), and the transport
    velocity of the next drift.
    """
    parameters = with_moved_solids(parameters, state)
    fill(parameters, state, workspace)
    workspace.fields.force_term[...] = 0.0
    workspace.rates.acceleration[...] = 0.0
    if number(parameters.constants, "alpha") > 0.0:
        evaluate_sum(PRESSURE, parameters, workspace)
    _store_acceleration(parameters, state, workspace, time, 0.5 * kick)


def take_shift(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Evaluate only the transport velocity of the next drift."""
    now = with_moved_solids(parameters, state)
    fill(now, state, workspace)
    shift(now, state, workspace, time)


def evaluate_rates(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Evaluate the rates of density and velocity, in a combined sum if there is one. Acoustic damping uses the previous
    rate of density in the state.
    """
    parameters = with_moved_solids(parameters, state)
    fill(parameters, state, workspace)
    both = parameters.pressure_force.both
    if both is None:
        _sum_stretch(parameters, state, workspace)
        _sum_pressure(parameters, workspace)
    else:
        diffusion = parameters.density_diffusion
        chosen = both[None if diffusion.excess is None else diffusion.row]
        evaluate_sum(chosen, parameters, workspace, settings=parameters.contrast)
        _correct_diffusion(parameters, state, workspace)
    _store_density_rate(parameters, state, workspace)
    _store_acceleration(parameters, state, workspace, time, 0.0)


def _sum_stretch(parameters: Parameters, state: State, workspace: Workspace) -> None:
    chosen = parameters.pressure_force.continuity[parameters.density_diffusion.row]
    evaluate_sum(chosen, parameters, workspace, settings=parameters.contrast)
    _correct_diffusion(parameters, state, workspace)


def _correct_diffusion(parameters: Parameters, state: State, workspace: Workspace) -> None:
    if parameters.density_diffusion.gradients:
        evaluate_sum(GRADIENT_DIFFUSION, parameters, workspace)
    if parameters.second is not None:  # the diffusion of enthalpy is 2 delta h rho/c
        first = parameters.material.density / parameters.material.sound_speed
        for liquid, who in parameters.parts(state.region):
            workspace.rates.diffusion[who] *= liquid.density / liquid.sound_speed / first


def _sum_pressure(parameters: Parameters, workspace: Workspace) -> None:
    settings = parameters.contrast
    if parameters.pressure_force.corrected:
        settings = (cast(float, parameters.precision(parameters.spreading_pressure)),)
    evaluate_sum(parameters.pressure_force.sum, parameters, workspace, settings=settings)


def _store_density_rate(parameters: Parameters, state: State, workspace: Workspace) -> None:
    if parameters.bodies.shapes and takes_up(parameters):
        workspace.rates.continuity[...] += taken_up(parameters, state, workspace)
    store_density_rate(state.density_rate, workspace.rates.table, state.density, parameters.pressure_force.by_mass)
    if parameters.fixed_volume:
        conserve_volume(state, workspace)
    if parameters.open_boundaries:
        zero_buffer_rates(state)


def conserve_volume(state: State, workspace: Workspace) -> None:
    """Add a uniform strain rate to all particles, so that sum m/rho is constant in a full, closed tank. It is treated
    as a part of the diffusion, which does work.

    The density follows sum_j m_j W by integration. While a disordered arrangement settles, this sum decreases although
    the tank stays full. The pressure would then decrease by c0^2 times this amount and become negative at the lid,
    where particles would attract each other and clump.
    """
    volume = state.mass / state.density
    excess = state.density * (dot(volume, state.density_rate / state.density) / float(volume.sum()))
    state.density_rate[...] -= excess
    workspace.rates.diffusion[: len(excess)] -= excess


def _store_acceleration(
    parameters: Parameters, state: State, workspace: Workspace, time: float, half_kick: float
) -> None:
    """Store the sum of the accelerations by pressure, gravity, friction, repulsion, bodies, surface tension, and user
    laws. `half_kick` (s) is how far the velocities are behind the positions.
    """
    per_volume, rates = parameters.pressure_force.per_volume, workspace.rates
    density = workspace.fields.density[: len(state.density)].astype(np.float64, copy=False)
    store_acceleration(state.acceleration, rates.table, density, parameters.gravity, per_volume)
    if parameters.pull_rate > 0.0:
        state.acceleration[...] -= parameters.pull_rate**2 * (state.position - parameters.pull_center[:, None])
    if parameters.viscosity_varies:
        set_viscosity(parameters, workspace)
    if parameters.friction is not None:
        workspace.rates.acceleration[:3] = 0.0
        evaluate_sum(parameters.friction.sum, parameters, workspace)
        state.acceleration[...] += workspace.rates.acceleration[: parameters.dimension]
    if parameters.roll is not None:
        moving = float(state.clock[0]), state.position, state.velocity, (half_kick, state.acceleration)
        state.acceleration[...] += inertial_accelerations(parameters.roll, *moving)
    repel_from_walls(parameters, state)
    repel_from_drawn(parameters, state)
    brake_at_walls(parameters, state)
    _push_bodies(parameters, state, workspace)
    if parameters.tension != "none":
        add_surface_tension(parameters, state, workspace)
    if parameters.user_forces is not None:
        workspace.user_acceleration = parameters.user_forces(parameters, state, workspace)
        state.acceleration[...] += workspace.user_acceleration
    if parameters.transports:
        shift(parameters, state, workspace, time)
    if parameters.open_boundaries:
        zero_buffer_rates(state)
        carry_outflows(parameters, state)


def _push_bodies(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Set the accelerations of bodies from the forces on their particles, summed in order."""
    bodies, dummies, d = parameters.bodies, parameters.boundary.dummies, parameters.dimension
    if not bodies.shapes:
        return
    force, place = forces_on_dummies(parameters, workspace, bodies.first)
    owner = dummies.owner[bodies.first :]
    names = len(parameters.boundary.names)
    sums = [
        total(force[:, owner == number], place[:, owner == number], state.pose[:3, body])
        for body, number in enumerate(range(names - len(bodies.shapes), names))
    ]
    exchanged = workspace.exchanged = exchanged_loads(parameters, state, workspace, movers=True)
    for body in range(len(bodies.shapes)):
        if (extra := exchanged.get(names - len(bodies.shapes) + body)) is not None:
            sums[body] = sums[body][0] + extra[0], sums[body][1] + extra[1]
    more = repel_from_bodies(parameters, state)
    load = np.array([force for force, _ in sums]) + more[0], np.array([torque for _, torque in sums]) + more[1]
    state.body_acceleration[...] = accelerations_of(bodies, state.pose, state.motion, load, parameters.gravity)
    state.body_acceleration[:d] -= parameters.pull_rate**2 * (state.pose[:d] - parameters.pull_center[:, None])
    state.delayed_body_acceleration[...] += (state.body_acceleration - state.delayed_body_acceleration) / delay(
        bodies, parameters.material.density
    )
    drive_bodies(parameters, state)


def table_of(parameters: Parameters) -> Array:
    """The table of sides, with points relative to the origin of the sums."""
    table = parameters.boundary.table.copy()
    table[:, : parameters.dimension] -= parameters.origin
    return table


def fill(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Fill the fields of the liquid and its images, then of the dummies and their images."""
    fields, lists = workspace.fields, workspace.lists
    table = fields.table
    require_kernel(parameters.constants)
    count = state.position.shape[1]
    real = len(lists.counts)
    by_mass, gradients = parameters.pressure_force.by_mass, parameters.density_diffusion.gradients
    rate = damped_rate(parameters, state)
    of_liquid = state.position, state.velocity, state.density, rate, state.pressure, state.mass
    fill_liquid(table, *of_liquid, parameters.origin, by_mass, parameters.bulk_viscosity, parameters.equation_of_state)
    if parameters.background > 0.0:
        fields.transport[: parameters.dimension, :count] = state.transport
    images = workspace.images
    of_images = table, real, images.start, table_of(parameters), parameters.gravity, parameters.equation_of_state
    if parameters.moves:
        put_dummies(parameters, fields, count)
    if len(images.source):
        fill_images(images.source, *of_images)
    if gradients:
        evaluate_sum(DENSITY_GRADIENT, parameters, workspace)
    if real > count:
        _read_liquid(parameters, state, workspace)
    if parameters.corrects:
        evaluate_sum(CORRECTIONS, parameters, workspace)
        if parameters.open_boundaries:
            fields.correction[:, :count][:, state.zone > 0] = UNIT
        _share_damping(parameters, state, workspace, of_images)
    if len(images.source) and (real > count or gradients or parameters.corrects):
        fill_images(images.source, *of_images)
    if fields.shape[1] > count:
        fill_weights(table, count, by_mass)


def damped_rate(parameters: Parameters, state: State) -> Array:
    """The rate of density times the ratio of the bulk viscosity of each liquid to that of liquid 1."""
    if parameters.second is None:
        return state.density_rate
    rate = state.density_rate.copy()
    for liquid, who in parameters.parts(state.region):
        rate[who] *= parameters.damping_ratio(liquid)
    return rate


def _read_liquid(parameters: Parameters, state: State, workspace: Workspace) -> None:
    dummies = parameters.boundary.dummies
    pulls = apparent_gravity(
        parameters.bodies, dummies, (state.pose, state.motion, state.delayed_body_acceleration), parameters.gravity
    )
    pulls -= parameters.pull_rate**2 * (dummies.position - parameters.pull_center[:, None])
    read_liquid(
        workspace.fields.table, state.position.shape[1], workspace.lists, parameters.constants, pulls,
        parameters.walls_clip, parameters.equation_of_state,
    )  # fmt: skip


def _share_damping(parameters: Parameters, state: State, workspace: Workspace, of_images: tuple[Any, ...]) -> None:
    """Reduce the acoustic damping where completed gradients make it stronger: see `corrections`."""
    if parameters.bulk_viscosity == 0.0 or not parameters.pressure_force.corrected:
        return
    fields, count = workspace.fields, state.position.shape[1]
    fields.damping[:count] *= parameters.pressure_force.damping_shares(fields, count)
    fields.force_term[:count] = fields.pressure[:count] + fields.damping[:count]
    if len(workspace.images.source):
        fill_images(workspace.images.source, *of_images)
    if len(workspace.lists.counts) > count:
        _read_liquid(parameters, state, workspace)
