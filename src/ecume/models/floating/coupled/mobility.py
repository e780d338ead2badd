"""The mobility of floats as an operator from forces to velocities: of single floats, or with hydrodynamic interaction,
by a matrix or by products on a grid.

`MOBILITIES` has a row for each form, so that films, integrators and contacts are the same for all of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import admit, compiled, selected
from ecume.engine.contact.contacts import Contacts
from ecume.engine.linear_solvers.lanczos import root_by_products, root_product
from ecume.laws import pair_mobility
from ecume.laws.pair_mobility import rotne_prager, spin_by_force, spin_by_torque, surface_divergence
from ecume.models.floating.coupled.many_floats import ERROR, FlowGrid, flow_divergence, flow_product, place_flow_grid
from ecume.models.floating.parameters import Parameters
from ecume.units import Array

admit(pair_mobility)


class MobilityOfEach(NamedTuple):
    """The mobility of floats without hydrodynamic interaction."""

    gain: Array
    """(N,) velocity per force"""


@compiled
def multiply_each(mobility: MobilityOfEach, load: Array, velocity: Array) -> None:
    """Write the velocities by forces."""
    for i in range(len(mobility.gain)):
        velocity[2 * i], velocity[2 * i + 1] = mobility.gain[i] * load[2 * i], mobility.gain[i] * load[2 * i + 1]


@compiled
def closing_of_each(mobility: MobilityOfEach, pair: tuple[int, int], along: tuple[float, float]) -> float:
    """The relative velocity of a pair by opposite unit forces along its line of centers."""
    closing: float = mobility.gain[pair[0]] + mobility.gain[pair[1]]
    return closing


class CoupledKicks(NamedTuple):
    """Constants of floats that interact through the flow of the liquid."""

    radius: Array
    """(N,) m: of the half-immersed sphere with the same drag, 2 f R"""
    spin: Array
    """(N,) 1/(N m s): what the spin of a single float has in addition to that of this sphere; (0,) if no float turns"""
    viscosity: float
    thermal: float
    """J: kT, of the drift kT div M; zero without thermal noise"""


class GridKicks(CoupledKicks):
    """The constants of floats that are too many for a matrix, so that products with the mobility replace it."""


def hydrodynamic_radius(parameters: Parameters, viscosity: float) -> Array:
    """The radius of the half-immersed sphere with the same drag as each float: zeta/(3 pi eta)."""
    floats = parameters.floats
    return np.asarray(floats.mass / floats.relaxation_time / (3.0 * math.pi * viscosity))


class MobilityMatrix(NamedTuple):
    """The mobility as a full matrix."""

    matrix: Array
    """(M, M) velocities (x, y of each float), then spins if floats turn, by forces and torques"""


def make_matrix(part: CoupledKicks) -> MobilityMatrix:
    """Return a matrix of zeros."""
    size = 2 * len(part.radius) + len(part.spin)
    return MobilityMatrix(np.zeros((size, size)))


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


@compiled
def fill_mobility(mobility: MobilityMatrix, part: CoupledKicks, position: Array) -> bool:
    """Compute the mobility matrix at these positions: twice that of whole spheres in unbounded liquid, by the mirror
    symmetry of the flat surface.
    """
    matrix, radius, count, turning = mobility.matrix, part.radius, len(part.radius), len(part.spin) > 0
    unit = 1.0 / (3.0 * math.pi * part.viscosity)
    for i in range(count):
        fill_own_block(part, unit, i, matrix)
        for j in range(i):
            x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
            distance = math.sqrt(x * x + y * y)
            # At zero distance the mobility is isotropic.
            x, y = (x / distance, y / distance) if distance > 0.0 else (1.0, 0.0)
            across, along = rotne_prager(distance, radius[i], radius[j])
            mixed = unit * (along - across) * x * y
            for one, other in ((2 * i, 2 * j), (2 * j, 2 * i)):
                matrix[one, other] = unit * (across + (along - across) * x * x)
                matrix[one + 1, other + 1] = unit * (across + (along - across) * y * y)
                matrix[one, other + 1], matrix[one + 1, other] = mixed, mixed
            if turning:
                fill_spins(part, (i, j), (distance, x, y), matrix)
    return True


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
def multiply(mobility: MobilityMatrix, load: Array, velocity: Array) -> None:
    """Write the velocities and spins by forces and torques: row by row, since sums along a row do not vectorize."""
    matrix = mobility.matrix
    velocity[:] = 0.0
    for row in range(len(matrix)):
        share = load[row]
        for column in range(len(velocity)):
            velocity[column] += share * matrix[row, column]


@compiled
def closing_mobility(mobility: MobilityMatrix, pair: tuple[int, int], along: tuple[float, float]) -> float:
    """The relative velocity of a pair by opposite unit forces along its line of centers."""
    (i, j), matrix, total = pair, mobility.matrix, 0.0
    for one in range(2):
        for other in range(2):
            both = matrix[2 * i + one, 2 * i + other] + matrix[2 * j + one, 2 * j + other]
            both -= matrix[2 * i + one, 2 * j + other] + matrix[2 * j + one, 2 * i + other]
            total += along[one] * both * along[other]
    return total


@compiled
def add_divergence(mobility: Any, part: CoupledKicks, position: Array, motion: Array) -> None:
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


@compiled
def multiply_by_root(mobility: MobilityMatrix, part: CoupledKicks, noise: Array, moved: Array) -> None:
    """Write B z for M = B B^T."""
    root_product(mobility.matrix, noise, moved)


@compiled
def closing_shares(mobility: MobilityMatrix, contacts: Contacts, position: Array) -> Array:
    """The velocities of both floats of each contact by opposite unit forces along its normal; walls are at rest."""
    matrix, count, share = mobility.matrix, len(position), np.zeros((contacts.total[0], 2))
    for row in range(len(share)):
        i, j, normal = contacts.first[row], contacts.second[row], contacts.normal
        for one in range(2):
            for other in range(2):
                along = normal[row, one] * normal[row, other]
                share[row, 0] += along * matrix[2 * i + one, 2 * i + other]
                if j < count:
                    mutual = along * matrix[2 * i + one, 2 * j + other]
                    share[row, 0] -= mutual
                    share[row, 1] += along * matrix[2 * j + one, 2 * j + other] - mutual
    return share


PRODUCTS = 60.0
"""Products of a time step in a growing raft."""
NEIGHBORS, POINTS = 140.0, 10.0
"""Near pairs and grid points for each float, about."""


class MobilityOnGrid(NamedTuple):
    """The mobility as an operator on a grid."""

    grid: list[FlowGrid]
    """one grid, placed in each step"""


def make_products() -> MobilityOnGrid:
    """Return a mobility whose grid is not placed yet."""
    return MobilityOnGrid([])


def grid_memory(part: GridKicks) -> float:
    """Bytes of the near pairs and of the grid."""
    return len(part.radius) * (40.0 * NEIGHBORS + 200.0 * POINTS)


def grid_pairs(part: GridKicks) -> float:
    """The work of a time step in units of one pair: one for a near pair and about ten for a grid point, in each
    product.
    """
    return PRODUCTS * len(part.radius) * (NEIGHBORS + 10.0 * POINTS)


def place_products(mobility: MobilityOnGrid, part: GridKicks, position: Array) -> bool:
    """Place the grid around these positions. Returns False if one is not finite."""
    if not np.isfinite(position).all():
        return False
    mobility.grid[:] = [place_flow_grid(position, part.radius, part.viscosity, part.thermal > 0.0)]
    return True


def multiply_on_grid(mobility: MobilityOnGrid, load: Array, velocity: Array) -> None:
    """Write the velocities by forces."""
    velocity[:] = flow_product(mobility.grid[0], load.reshape(-1, 2)).ravel()


def add_drift_on_grid(mobility: MobilityOnGrid, part: GridKicks, position: Array, velocity: Array) -> None:
    """Add the drift kT div M."""
    velocity += part.thermal * flow_divergence(mobility.grid[0], position).ravel()


def root_on_grid(mobility: MobilityOnGrid, part: GridKicks, noise: Array, moved: Array) -> None:
    """Write B z for M = B B^T."""
    grid = mobility.grid[0]
    scale = np.repeat(np.sqrt(grid.unit / part.radius), 2)
    moved[:] = root_by_products(lambda force: flow_product(grid, force.reshape(-1, 2)).ravel(), scale, noise, ERROR)


def shares_on_grid(mobility: MobilityOnGrid, contacts: Contacts, position: Array) -> Array:
    """The velocities of both floats of each contact by opposite unit forces along its normal; walls are at rest."""
    return pair_shares(contacts, position, mobility.grid[0].radius, mobility.grid[0].unit)


@compiled
def pair_shares(contacts: Contacts, position: Array, radius: Array, unit: float) -> Array:
    """The velocities of both bodies of each contact by opposite unit forces, without other bodies."""
    share = np.zeros((contacts.total[0], 2))
    for row in range(len(share)):
        i, j = contacts.first[row], contacts.second[row]
        share[row, 0] = unit / radius[i]
        if j < len(radius):
            x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
            along = unit * rotne_prager(math.sqrt(x * x + y * y), radius[i], radius[j])[1]
            share[row, 0] -= along
            share[row, 1] = unit / radius[j] - along
    return share


class Mobility(NamedTuple):
    """A row of the table of mobilities: the functions of one form."""

    apply: Callable[..., None]
    """apply(mobility, load, velocity): write the velocities and spins by forces and torques"""
    closing: Callable[..., float] | None = None
    """closing(mobility, pair, along): the relative velocity of two floats by opposite unit forces along their line"""
    place: Callable[..., bool] | None = None
    """place(mobility, part, position): prepare products at these positions; false if they are not finite"""
    add_drift: Callable[..., None] | None = None
    """add_drift(mobility, part, position, velocity): add kT div M"""
    root: Callable[..., None] | None = None
    """root(mobility, part, noise, moved): write B z for M = B B^T"""
    shares: Callable[..., Array] | None = None
    """shares(mobility, contacts, position): the velocities of both floats of each contact by opposite unit forces along
    its normal
    """


MOBILITIES: dict[type, Mobility] = {
    MobilityOfEach: Mobility(multiply_each, closing_of_each),
    MobilityMatrix: Mobility(
        multiply, closing_mobility, fill_mobility, add_divergence, multiply_by_root, closing_shares
    ),
    MobilityOnGrid: Mobility(multiply_on_grid, None, place_products, add_drift_on_grid, root_on_grid, shares_on_grid),
}
"""The mobilities by their type."""
apply = selected(MOBILITIES, "apply")
closing = selected(MOBILITIES, "closing")
place = selected(MOBILITIES, "place")
add_drift = selected(MOBILITIES, "add_drift")
root = selected(MOBILITIES, "root")
shares = selected(MOBILITIES, "shares")
