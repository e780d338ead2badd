"""The mobility matrix of all floats: velocities and spins by forces and torques."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, compiled
from ecume.laws import pair_mobility
from ecume.laws.pair_mobility import rotne_prager, spin_by_force, spin_by_torque, surface_divergence
from ecume.models.floating.parameters import Parameters
from ecume.units import Array

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


def make_coupled_scratch(part: CoupledKicks) -> CoupledScratch:
    """Return the workspace."""
    count = len(part.radius)
    size = 2 * count + len(part.spin)
    return CoupledScratch(np.zeros((size, size)), np.zeros(size), np.zeros(size), np.zeros((count, 2)))


def coupled_memory(part: CoupledKicks) -> float:
    """Bytes of the matrix, and of the motion by each contact of floats in a raft (three for each float)."""
    count, size = len(part.radius), 2 * len(part.radius) + len(part.spin)
    contacts = 3 * count * (2 if len(part.spin) else 1)
    return float(8 * size * (size + contacts))


def coupled_pairs(part: CoupledKicks) -> float:
    """The work of a time step, in pairs: to fill the matrix and to multiply by it, for thermal noise many times."""
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
            # At one place the mobilities are the same in all directions.
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
    """The velocity and the spin of a float by the force and the torque on itself."""
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
    """The spins of two floats by forces and torques on each other, and velocities by torques; `way` is the distance and
    the direction from the first to the second.
    """
    (i, j), (distance, x, y), radius, count = pair, way, part.radius, len(part.radius)
    unit = 1.0 / (3.0 * math.pi * part.viscosity)
    turned = unit * spin_by_torque(distance, radius[i], radius[j])
    mobility[2 * count + i, 2 * count + j], mobility[2 * count + j, 2 * count + i] = turned, turned
    for one, other, sign in ((i, j, -1.0), (j, i, 1.0)):
        # The spin F x d / (8 pi eta d^3), where d points from the force to the float that turns.
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
    """Add the drift kT div M: without it floats with thermal noise would gather where they move slowly. The divergence
    is known in closed form; it has no part along the spins.
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
