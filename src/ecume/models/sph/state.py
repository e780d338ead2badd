"""State and workspace of a tank."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ecume._columns import RECORD
from ecume.engine.cells import Images, Integers, images_of, positions_of_images
from ecume.engine.neighbor_rows import (
    STRIDE,
    Grid,
    Lists,
    Sorted,
    empty_lists,
    grid_around,
    neighbor_lists,
    sort_by_cell,
)
from ecume.models.sph.fields import Fields, Floats, Rates, zero_fields, zero_rates
from ecume.models.sph.integration.particle_loops import largest
from ecume.models.sph.parameters import Liquid, Parameters
from ecume.units import Array

SUBSTEPS, GUARD_HITS, RENEWALS, MOST_SUBSTEPS, ITERATIONS, MOST_ITERATIONS, RESIDUAL, WORST = range(8)
"""Indices of `State.tally`."""
WORK, RATE = range(2)
"""Indices of `State.budget`."""
ENTERED, LEFT, LOST, NEXT = range(4)
"""Indices of `State.population`."""
SORT_EVERY = 16
"""The number of renewals of the lists after which particles are sorted into cells."""


FIRST_SKIN, LEAST_SKIN, MOST_SKIN = 0.1, 0.03, 0.25
"""The skin of the first lists, the smallest and the largest skin, in supports."""
LIST_COST, CALL_COST = 1.5, 400.0
"""Coefficients of the cost of lists relative to that of pairs, measured: see `skin_for`."""


class State(NamedTuple):
    """All data that affect later bits. Particles are in the order of cells; `identity` contains their permanent
    numbers.
    """

    position: Array
    """(d, N) m: axis by axis, so that loops over neighbors read along contiguous rows"""
    velocity: Array
    """(d, N) m/s"""
    acceleration: Array
    """(d, N) m/s^2, at the end of the last step"""
    transport: Array
    """(d, N) m/s: the velocity with which particles move in addition to `velocity`"""
    density: Array
    """(N,) kg/m^3"""
    pressure: Array
    """(N,) Pa, of incompressible liquids only; the first guess of the next step"""
    density_rate: Array
    """(N,) kg/(m^3 s): the rate of density at the last evaluation, by which sound is damped"""
    mass: Array
    """(N,) kg"""
    identity: Integers
    """(N,) the permanent numbers of particles"""
    region: Integers
    """(N,)"""
    zone: Integers
    """(N,) 0 for liquid, otherwise the number of the buffer: see `open_boundaries`"""
    reference: Array
    """(d, N) positions when the lists were made, which determine the order of sums"""
    skin: Array
    """(1,) m: the distance beyond the support that the lists include"""
    pose: Array
    """(7, B) of rigid bodies: center and quaternion"""
    motion: Array
    """(6, B) of rigid bodies: velocity and spin"""
    body_acceleration: Array
    """(6, B) their linear and angular acceleration at the end of the last step"""
    delayed_body_acceleration: Array
    """(6, B) the same, relaxed over some steps, for the pressure of the bodies' dummies"""
    pose_reference: Array
    """(7, B) when the lists were made"""
    passive_position: Array
    """(d, C) m"""
    passive_velocity: Array
    """(d, C) m/s"""
    passive_clock: Integers
    """(1,) number of steps of passive particles, the counter of their random numbers"""
    clock: Array
    """(2,) s: the present time, also within a step; the time when the lists were made"""
    step: Integers
    """(1,)"""
    ready: Integers
    """(1,) whether `acceleration` is valid at the present positions"""
    tally: Array
    """substeps, hits of the guard, renewals of the lists, most substeps in a step; of incompressible liquids:
    iterations, most iterations in a substep, the last error of the solver, the particle where it is largest
    """
    hits: Integers
    """of the guard, by `Boundary.names`"""
    population: Integers
    """numbers of particles that entered, left and were lost; the number of the next particle"""
    budget: Array = np.zeros(2)
    """work from outside (J), and its rate by forces (W) at the end of the last step: see `report.energy_budget`"""
    image: Integers = np.zeros((0, 0), np.int64)
    """(d, N) the number of periods by which each particle has moved beyond its stored position; (0, 0) without periodic
    sides, and in runs of former versions
    """
    passive_image: Integers = np.zeros((0, 0), np.int64)
    """(d, C) the same of passive particles"""
    struck: Array = np.zeros((0, 6))
    """(names, 6) N and N m: the mean force and torque of reflected particles on walls and obstacles in the last step;
    (0, 6) in runs of former versions
    """
    numerical: Array = np.zeros(2)
    """the part of `budget` that is the work of the numerical method: of density diffusion and of compressed dummies"""


class CellLists(NamedTuple):
    """All particles in cells, at the time when the neighbor lists were made."""

    grid: Grid
    sorted: Sorted
    skin: float
    """m; no particle has moved farther than half of it"""


@dataclass
class Workspace:
    """Scratch of one set of lists, which is replaced when lists are renewed."""

    images: Images
    lists: Lists
    fields: Fields
    rates: Rates
    records: Floats
    """(entries, 8 or 16) the numbers of each particle that a sum reads: see `rates.neighbor_sums`"""
    before: Array
    """(d + 1, N) rates of velocity and density at the last positions"""
    cells: CellLists | None
    """for the interpolation at passive particles; None without them"""
    user_acceleration: Array | None = None
    """(d, N) m/s^2 by laws of the user, at the last evaluation"""
    exchanged: dict[int, tuple[Array, Array]] | None = None
    """`touching_solids.exchanged_loads` of bodies at the last evaluation; None if it was with other lists"""
    records_loads: bool = True
    """whether this step ends in a frame, so that the mean loads of an incompressible liquid are of interest"""

    def give_lists(self) -> Lists:
        """The lists, which the caller may replace by larger ones: they are no longer in this workspace."""
        lists, self.lists = self.lists, empty_lists(0)
        return lists

    def take(self, other: Workspace) -> None:
        """Replace all arrays by those of another workspace."""
        self.images, self.lists, self.fields = other.images, other.lists, other.fields
        self.rates, self.records = other.rates, other.records
        self.before, self.cells, self.exchanged = other.before, other.cells, None


def make_state(parameters: Parameters, liquid: Liquid) -> State:
    """The state at time 0, in the order of the liquid's particles."""
    none = np.zeros_like(liquid.position)
    count = liquid.position.shape[1]
    pose, motion = parameters.bodies.pose, parameters.bodies.motion
    shape = (parameters.dimension,) if (parameters.boundary.sides.mirrors == 0).any() else (0, 0)
    passive = parameters.passive_tracers.position.shape[1]
    return State(
        position=liquid.position.copy(),
        velocity=liquid.velocity.copy(),
        acceleration=none,
        transport=np.zeros(none.shape),  # no memory until it is written
        density=liquid.density.copy(),
        pressure=np.zeros(count) if parameters.projection is None else liquid.pressure.copy(),
        density_rate=np.zeros(count),
        mass=liquid.mass.copy(),
        identity=np.arange(count),
        region=liquid.region.copy(),
        zone=np.zeros(count, np.int64),
        reference=liquid.position.copy(),
        skin=np.array([FIRST_SKIN * parameters.support]),
        pose=pose.copy(),
        motion=motion.copy(),
        body_acceleration=np.zeros_like(motion),
        delayed_body_acceleration=np.zeros_like(motion),
        pose_reference=pose.copy(),
        passive_position=parameters.passive_tracers.position.copy(),
        passive_velocity=np.zeros_like(parameters.passive_tracers.position),
        passive_clock=np.zeros(1, np.int64),
        clock=np.zeros(2),
        step=np.zeros(1, np.int64),
        ready=np.zeros(1, np.int64),
        tally=np.zeros(8),
        hits=np.zeros(len(parameters.boundary.names), np.int64),
        population=np.array([0, 0, 0, count]),
        budget=np.zeros(2),
        image=np.zeros((*shape, count)[:2], np.int64),
        passive_image=np.zeros((*shape, passive)[:2], np.int64),
        struck=np.zeros((len(parameters.boundary.names), 6)),
        numerical=np.zeros(2),
    )


PER_PARTICLE = (
    "position",
    "velocity",
    "acceleration",
    "transport",
    "density",
    "pressure",
    "density_rate",
    "mass",
    "identity",
    "region",
    "zone",
    "image",
)


def particle_arrays(state: State) -> dict[str, Any]:
    """The arrays of a state with one value per particle of the liquid."""
    count = state.position.shape[1]
    return {name: array for name in PER_PARTICLE if (array := getattr(state, name)).shape[-1] == count}


def sort_state(parameters: Parameters, state: State) -> None:
    """Sort particles by cell, so that neighbors are close in memory. Zeros that were never written remain no memory."""
    order = sort_by_cell(state.position, grid_around(state.position, parameters.support)).order
    for array in particle_arrays(state).values():
        if array.any():
            array[...] = np.take(array, order, axis=-1)


def skin_for(parameters: Parameters, state: State) -> float:
    """The skin of the next lists (m). Lists with a larger skin are valid for longer, but contain more pairs.

    The fastest particle determines how long lists are valid. Building them takes about as long as two and a half sums,
    and in small systems as the sums over some hundred additional particles.
    """
    way = largest(state.velocity) * parameters.time_step / parameters.support
    if not math.isfinite(way):
        return float(state.skin[0])
    balance = LIST_COST + CALL_COST / state.position.shape[1]
    return parameters.support * min(max(math.sqrt(balance * way), LEAST_SKIN), MOST_SKIN)


def workspace_at(parameters: Parameters, state: State, before: Workspace | None = None) -> Workspace:
    """The workspace at the state's reference positions; the arrays of the previous workspace are reused, or given up
    before larger ones take their place.

    `parameters` are those at the reference: see `boundaries.rigid_bodies`.
    """
    boundary, skin = parameters.boundary, float(state.skin[0])
    real = np.concatenate([state.reference, boundary.dummies.position], axis=1)
    images = images_of(real, boundary.sides, max(parameters.support, parameters.color_reach) + skin)
    all_positions = np.concatenate([real, positions_of_images(real, images, boundary.sides)], axis=1)
    liquid, count = state.reference.shape[1], real.shape[1]
    del real
    lists = neighbor_lists(
        all_positions, (liquid, count), parameters.support + skin, before.give_lists() if before else empty_lists(count)
    )
    cells = cells_of(all_positions, parameters.support, skin) if parameters.passive_tracers.start[-1] else None
    del all_positions
    columns = count + len(images.source)
    if before and before.fields.shape[1] == columns:
        put_kinds(parameters, state, before.fields)
        return Workspace(images, lists, before.fields, before.rates, before.records, before.before, cells)
    width = RECORD
    if before:
        width = before.records.shape[1]
        before.fields, before.records = zero_fields(0, parameters.precision), before.records[:0].copy()
    fields = zero_fields(columns, parameters.precision, parameters.corrects)
    fields.liquid[:liquid], fields.viscosity[:liquid] = 1.0, parameters.material.viscosity
    put_kinds(parameters, state, fields)
    put_dummies(parameters, fields, liquid)
    records = np.zeros((columns, width), parameters.precision)
    if before and before.rates.shape[1] == liquid:
        return Workspace(images, lists, fields, before.rates, records, before.before, cells)
    rates, rates_before = zero_rates(liquid, parameters.precision), np.zeros((parameters.dimension + 1, liquid))
    return Workspace(images, lists, fields, rates, records, rates_before, cells)


def cells_of(all_positions: Array, support: float, skin: float) -> CellLists | None:
    """All particles in cells as wide as the reach of the lists."""
    if not all_positions.shape[1]:
        return None
    grid = grid_around(all_positions, support + skin)
    return CellLists(grid, sort_by_cell(all_positions, grid), skin)


def put_kinds(parameters: Parameters, state: State, fields: Fields) -> None:
    """Fill the constant fields of two liquids; sorting moves particles, so the fields must be filled again."""
    if parameters.second is not None:
        count = len(state.region)
        fields.kind[:count] = parameters.second.kind[state.region]
        fields.viscosity[:count] = parameters.of_each("viscosity", state.region)


def put_dummies(parameters: Parameters, fields: Fields, first: int) -> None:
    """Fill the constant fields of dummies."""
    dummies, dimension = parameters.boundary.dummies, parameters.dimension
    here = slice(first, first + dummies.position.shape[1])
    fields.position[:dimension, here] = dummies.position - parameters.origin[:, None]
    fields.velocity[:dimension, here] = dummies.velocity
    fields.friction_velocity[:dimension, here] = dummies.velocity
    fields.volume[here] = dummies.volume
    fields.viscosity[here] = dummies.viscosity


def likely_neighbors(dimension: int, reach: float) -> float:
    """The mean length of a row of neighbors in a full lattice, padding included; `reach` in spacings."""
    return float(np.pi * reach**2 * (4.0 / 3.0 * reach if dimension == 3 else 1.0)) + 0.5 * STRIDE
