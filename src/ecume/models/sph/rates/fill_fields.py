"""The tables that sums read, filled: the entries of the liquid, of its images, and of the dummies of walls and bodies.

Dummies take pressure and velocity from the liquid before them: Adami, Hu and Adams, J. Comput. Phys. 231 (2012) 7057,
eqs. 22, 23 and 27. [adami2012]
"""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import admit, compiled_inside, inlined, prange, spread
from ecume.engine.cells import Integers
from ecume.engine.neighbor_rows import Lists
from ecume.laws import enthalpy as enthalpies
from ecume.laws import states
from ecume.models.sph.fields import FIELD, Constants, Floats, Tait
from ecume.models.sph.rates.kernels import value_of
from ecume.units import Array

admit(states, enthalpies)


@spread
def fill_liquid(
    fields: Floats, position: Array, velocity: Array, density: Array, mass: Array, tait: Tait, origin: Array,
    by_mass: bool,
) -> None:  # fmt: skip
    """Everything that sums read of the liquid, from its state."""
    dimension, count = position.shape
    c0, gamma, rho0 = tait.sound_speed, tait.exponent, tait.density
    for i in prange(count):
        for axis in range(dimension):
            fields[FIELD.position + axis, i] = position[axis, i] - origin[axis]
            fields[FIELD.velocity + axis, i] = velocity[axis, i]
            fields[FIELD.friction_velocity + axis, i] = velocity[axis, i]
        own = density[i]
        pressure = states.tait_pressure(own, rho0, c0, gamma)
        fields[FIELD.density, i] = own
        fields[FIELD.volume, i] = mass[i] / own
        fields[FIELD.pressure, i] = pressure
        fields[FIELD.enthalpy, i] = enthalpies.tait_enthalpy(own, rho0, c0, gamma)
        fields[FIELD.force_term, i] = pressure / (own * own) if by_mass else pressure
        fields[FIELD.weight, i] = mass[i] if by_mass else mass[i] / own


@spread
def fill_images(
    source: Integers, fields: Floats, first: int, start: Integers, sides: Array, pull: Array, tait: Tait
) -> None:
    """Images, side by side in order: an image may be the source of another.

    `sides` is (sides, 4 d + 2): point, normal, shift (of a periodic side) or velocity (of a mirror); whether it
    mirrors; whether it holds the liquid (no slip); acceleration.
    """
    dimension = len(pull)
    for side in range(len(start) - 1):
        mirrors, holds = sides[side, 3 * dimension] != 0.0, sides[side, 3 * dimension + 1] != 0.0
        for k in prange(start[side], start[side + 1]):
            if mirrors:
                _mirror(fields, source[k], first + k, sides[side], holds, pull, tait)
            else:
                _shift(fields, source[k], first + k, sides[side], dimension)


@inlined
def _shift(fields: Floats, i: int, image: int, side: Array, dimension: int) -> None:
    for row in range(fields.shape[0]):
        fields[row, image] = fields[row, i]
    for axis in range(dimension):
        fields[FIELD.position + axis, image] += side[2 * dimension + axis]


@inlined
def _mirror(fields: Floats, i: int, image: int, side: Array, holds: bool, pull: Array, tait: Tait) -> None:
    """The mirrored particle, at rest under gravity where its source is: its enthalpy is the source's, and what the
    way between adds. A wall that holds the liquid turns the velocity around for friction, and lets only the normal
    part turn for the equation of continuity.
    """
    dimension = len(pull)
    c0, gamma, rho0 = tait.sound_speed, tait.exponent, tait.density
    away, through, drift, pull_through, steep = 0.0, 0.0, 0.0, 0.0, 0.0
    for axis in range(dimension):
        normal = side[dimension + axis]
        away += (fields[FIELD.position + axis, i] - side[axis]) * normal
        through += (fields[FIELD.velocity + axis, i] - side[2 * dimension + axis]) * normal
        drift += fields[FIELD.transport + axis, i] * normal
        pull_through += (pull[axis] - side[3 * dimension + 2 + axis]) * normal
        steep += fields[FIELD.density_gradient + axis, i] * normal
    for axis in range(dimension):
        normal = side[dimension + axis]
        fields[FIELD.position + axis, image] = fields[FIELD.position + axis, i] - 2.0 * away * normal
        fields[FIELD.velocity + axis, image] = fields[FIELD.velocity + axis, i] - 2.0 * through * normal
        fields[FIELD.transport + axis, image] = fields[FIELD.transport + axis, i] - 2.0 * drift * normal
        turned = 2.0 * side[2 * dimension + axis] - fields[FIELD.friction_velocity + axis, i]
        fields[FIELD.friction_velocity + axis, image] = turned if holds else fields[FIELD.velocity + axis, image]
        # The hydrostatic part continues through the wall, the rest is mirrored.
        fields[FIELD.density_gradient + axis, image] = (
            fields[FIELD.density_gradient + axis, i] - 2.0 * (steep - rho0 / (c0 * c0) * pull_through) * normal
        )
    enthalpy = fields[FIELD.enthalpy, i] - 2.0 * away * pull_through
    mass = fields[FIELD.volume, i] * fields[FIELD.density, i]
    density = enthalpies.density_at_enthalpy(enthalpy, rho0, c0, gamma)
    fields[FIELD.enthalpy, image] = enthalpy
    fields[FIELD.density, image] = density
    fields[FIELD.pressure, image] = states.tait_pressure(density, rho0, c0, gamma)
    fields[FIELD.volume, image] = mass / density
    fields[FIELD.viscosity, image] = fields[FIELD.viscosity, i]
    fields[FIELD.liquid, image] = fields[FIELD.liquid, i]


@spread
def fill_weights(fields: Floats, first: int, by_mass: bool) -> None:
    """Fill the pressure term and the weight of neighbors, from column `first` on: see `Fields`."""
    for i in prange(first, fields.shape[1]):
        density = fields[FIELD.density, i]
        fields[FIELD.force_term, i] = (
            fields[FIELD.pressure, i] / (density * density) if by_mass else fields[FIELD.pressure, i]
        )
        fields[FIELD.weight, i] = fields[FIELD.volume, i] * density if by_mass else fields[FIELD.volume, i]


NOTHING = 1e-12
"""Kernel sums below this part of W(0) mean that there is no liquid near."""
INDEX = np.uint64


@spread
def read_liquid(
    fields: Floats,
    first: int,
    lists: Lists,
    constants: Constants,
    pull: Array,
    clip: bool,
    tait: Tait,
) -> None:
    """Fill the columns of dummies, from `first` on, out of the liquid in their rows.

    Their positions, wall velocities and slip (their viscosity is zero on slippery walls) are set already.
    `pull` is (d, dummies): gravity less each one's own acceleration (eq. 27).
    """
    kernel, dimension, inverse = constants[0].kernel, len(pull), 1.0 / constants[0].smoothing_length
    counts, neighbor = lists
    for dummy in prange(first, len(counts)):
        total, enthalpy, speed = 0.0, 0.0, np.zeros(3)
        for k in range(counts[dummy]):
            j = neighbor[dummy, k]
            square, depth = 0.0, 0.0
            for axis in range(dimension):
                along = fields[FIELD.position + axis, j] - fields[FIELD.position + axis, dummy]
                square += along * along
                depth -= pull[axis, dummy - first] * along
            weight = value_of(math.sqrt(square) * inverse, kernel) * fields[FIELD.liquid, j]
            total += weight
            enthalpy += weight * (fields[FIELD.enthalpy, j] + depth)
            for axis in range(dimension):
                speed[axis] += weight * fields[FIELD.friction_velocity + axis, j]
        near = total > NOTHING
        enthalpy = enthalpy / total if near else 0.0
        _set_state(fields, dummy, max(enthalpy, 0.0) if clip else enthalpy, tait)
        for axis in range(dimension):
            wall = fields[FIELD.velocity + axis, dummy]
            fields[FIELD.friction_velocity + axis, dummy] = 2.0 * wall - speed[axis] / total if near else wall


@compiled_inside
def _set_state(fields: Floats, i: int, enthalpy: float, tait: Tait) -> None:
    c0, gamma, rho0 = tait.sound_speed, tait.exponent, tait.density
    density = enthalpies.density_at_enthalpy(enthalpy, rho0, c0, gamma)
    fields[FIELD.enthalpy, i] = enthalpy
    fields[FIELD.density, i] = density
    fields[FIELD.pressure, i] = states.tait_pressure(density, rho0, c0, gamma)
