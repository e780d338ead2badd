"""The rates at the present positions: tables filled, neighbors summed, what they do stored."""

from __future__ import annotations

import numpy as np

from ecume.models.sph.bodies import delay, pulls_of, pushed
from ecume.models.sph.columns import fill_images, fill_liquid, fill_weights
from ecume.models.sph.dummies import read_liquid
from ecume.models.sph.fields import (
    ACC,
    DELTA,
    DIFFUSED,
    DRHO,
    FRICTION,
    NO_FRICTION,
    SCALE,
    W,
)
from ecume.models.sph.gates import still
from ecume.models.sph.gradients import add_gradient_diffusion, fill_density_gradients
from ecume.models.sph.loads import forces_on_dummies, total
from ecume.models.sph.methods import FRICTIONS, diffusion_of, pressure_of, row_of
from ecume.models.sph.motion import (
    store_acceleration,
    store_thickening,
)
from ecume.models.sph.motions import instant
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.shifting import shift
from ecume.models.sph.standoff import push_off_bodies, push_off_walls
from ecume.models.sph.state import (
    State,
    Workspace,
    put_dummies,
)
from ecume.models.sph.sums import sums_of
from ecume.models.sph.tension import pull
from ecume.models.sph.turbulence import stir
from ecume.models.sph.weights import require_kernel
from ecume.units import Array


def take_thickening(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """The rate of density at the present positions."""
    parameters = instant(parameters, state)
    fill(parameters, state, workspace)
    _sum_stretch(parameters, workspace)
    _store_thickening(parameters, state, workspace)


def take_forces(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """The acceleration at the present positions, and the transport for the next drift."""
    parameters = instant(parameters, state)
    fill(parameters, state, workspace)
    _sum_push(parameters, workspace)
    _store_acceleration(parameters, state, workspace, time)


def take_both(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Both of them; in a single sum where there is neither diffusion nor a wall's dummy."""
    parameters = instant(parameters, state)
    fill(parameters, state, workspace)
    choices, lists = parameters.choices, workspace.lists
    diffuses = diffusion_of(choices).excess is not None
    if not diffuses and len(lists.counts) == state.position.shape[1] and pressure_of(choices).loop is None:
        sums = sums_of(choices)
        sums.both(workspace.fields, lists.counts, lists.neighbor, parameters.numbers, choices, workspace.rates)
        hear(workspace, DRHO, DIFFUSED, ACC, ACC + 1, ACC + 2)
    else:
        _sum_stretch(parameters, workspace)
        _sum_push(parameters, workspace)
    _store_thickening(parameters, state, workspace)
    _store_acceleration(parameters, state, workspace, time)


def _sum_stretch(parameters: Parameters, workspace: Workspace) -> None:
    lists, choices, numbers = workspace.lists, parameters.choices, parameters.numbers
    diffusion = diffusion_of(choices)
    sums_of(choices).stretch(
        workspace.fields, lists.counts, lists.neighbor, numbers, choices, diffusion.field, workspace.rates
    )
    if diffusion.gradients:
        factor = numbers[DELTA] * numbers[SCALE]
        add_gradient_diffusion(
            workspace.fields, lists.counts, lists.neighbor, numbers, choices, factor, workspace.rates
        )
    hear(workspace, DRHO, DIFFUSED)


def hear(workspace: Workspace, *rows: int) -> None:
    """Where ranks share the sums out: what the others came to."""
    if workspace.share is not None:
        for row in rows:
            workspace.share.gather(workspace.rates[row], workspace.share.parts(workspace.rates.shape[1]))


def _sum_push(parameters: Parameters, workspace: Workspace) -> None:
    lists, choices = workspace.lists, parameters.choices
    push = pressure_of(choices).loop or sums_of(choices).push
    push(workspace.fields, lists.counts, lists.neighbor, parameters.numbers, choices, workspace.rates)
    hear(workspace, ACC, ACC + 1, ACC + 2)


def _store_thickening(parameters: Parameters, state: State, workspace: Workspace) -> None:
    store_thickening(state.thickening, workspace.rates, state.density, pressure_of(parameters.choices).by_mass)
    if parameters.gates:
        still(state)


def _store_acceleration(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Pressure is per weight, friction per mass; and gravity."""
    choices, lists = parameters.choices, workspace.lists
    per_volume = pressure_of(choices).per_volume
    store_acceleration(state.acceleration, workspace.rates, state.density, parameters.gravity, per_volume)
    if parameters.pull_rate > 0.0:
        state.acceleration[...] -= parameters.pull_rate**2 * (state.position - parameters.pull_center[:, None])
    if parameters.turbulence:
        stir(parameters, workspace)
    if choices[FRICTION] != NO_FRICTION:
        rubbing = row_of(FRICTIONS, choices[FRICTION]).loop
        workspace.rates[ACC : ACC + 3] = 0.0
        rubbing(workspace.fields, lists.counts, lists.neighbor, parameters.numbers, choices, workspace.rates)
        hear(workspace, ACC, ACC + 1, ACC + 2)
        state.acceleration[...] += workspace.rates[ACC : ACC + parameters.dimension]
    push_off_walls(parameters, state)
    _push_bodies(parameters, state, workspace)
    if parameters.tension != "none":
        pull(parameters, state, workspace)
    if parameters.transports:
        shift(parameters, state, workspace, time)
    if parameters.gates:
        still(state)


def _push_bodies(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """What the liquid does to each body's particles, summed in their order."""
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
    more = push_off_bodies(parameters, state)
    load = np.array([force for force, _ in sums]) + more[0], np.array([torque for _, torque in sums]) + more[1]
    state.push[...] = pushed(bodies, state.pose, state.motion, load, parameters.gravity)
    state.push[:d] -= parameters.pull_rate**2 * (state.pose[:d] - parameters.pull_center[:, None])
    state.felt[...] += (state.push - state.felt) / delay(bodies, parameters.material.density)


def table_of(parameters: Parameters) -> Array:
    """The sides' table, with points from where sums count."""
    table = parameters.boundary.table.copy()
    table[:, : parameters.dimension] -= parameters.origin
    return table


def fill(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """The liquid's columns, its images', the walls', and the images of those."""
    fields, lists = workspace.fields, workspace.lists
    numbers, choices = parameters.numbers, parameters.choices
    require_kernel(choices)
    count = state.position.shape[1]
    real = len(lists.counts)
    by_mass, gradients = pressure_of(choices).by_mass, diffusion_of(choices).gradients
    of_liquid = state.position, state.velocity, state.density, state.mass
    fill_liquid(fields, *of_liquid, parameters.constants, parameters.origin, by_mass)
    if parameters.background > 0.0:
        fields[W : W + parameters.dimension, :count] = state.transport
    images = workspace.images
    of_images = fields, real, images.start, table_of(parameters), parameters.gravity, parameters.constants
    if parameters.moves:
        put_dummies(parameters, fields, count)
    if len(images.source):
        fill_images(images.source, *of_images)
    if gradients:
        fill_density_gradients(fields, count, lists.counts, lists.neighbor, numbers, choices)
    if real > count:
        clip, constants, dummies = parameters.walls_clip, parameters.constants, parameters.boundary.dummies
        pulls = pulls_of(parameters.bodies, dummies, (state.pose, state.motion, state.felt), parameters.gravity)
        pulls -= parameters.pull_rate**2 * (dummies.position - parameters.pull_center[:, None])
        read_liquid(fields, count, lists.counts, lists.neighbor, numbers, choices, pulls, clip, constants)
    if len(images.source) and (real > count or gradients):
        fill_images(images.source, *of_images)
    if fields.shape[1] > count:
        fill_weights(fields, count, by_mass)
