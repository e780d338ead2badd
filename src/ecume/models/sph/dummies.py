"""Dummy particles of walls and bodies take what the liquid before them says: its pressure and its velocity.

Adami, Hu and Adams, J. Comput. Phys. 231 (2012) 7057, eqs. 22, 23 and 27. [adami2012]
"""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import compiled_inside, prange, spread
from ecume.engine.lists import Lists
from ecume.laws import enthalpy as enthalpies
from ecume.laws import states
from ecume.models.sph.fields import FIELD, Constants, Floats, Tait
from ecume.models.sph.weights import value_of
from ecume.units import Array

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
