"""Dummy particles of walls and bodies take what the liquid before them says: its pressure and its velocity.

Adami, Hu and Adams, J. Comput. Phys. 231 (2012) 7057, eqs. 22, 23 and 27. [adami2012]
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume._jit import compiled_inside, prange, spread
from ecume.laws import enthalpy as enthalpies
from ecume.laws import states
from ecume.models.sph.columns import C0, GAMMA, RHO0
from ecume.models.sph.fields import ENTHALPY, KERNEL, LIQUID, RHO, H, P, U, V, X
from ecume.models.sph.weights import value_of

NOTHING = 1e-12
"""Kernel sums below this part of W(0) mean that there is no liquid near."""
INDEX = np.uint64


@spread
def read_liquid(
    fields: Any, first: int, count: Any, neighbor: Any, numbers: Any, choices: Any, pull: Any, clip: bool, material: Any
) -> None:
    """Fill the columns of dummies, from `first` on, out of the liquid in their rows.

    Their positions, wall velocities (V) and slip (MU is zero on walls that do not hold the liquid) stand already.
    `pull` is (d, dummies): gravity less each one's own acceleration (eq. 27).
    """
    kernel, dimension, inverse = choices[KERNEL], len(pull), 1.0 / numbers[H]
    for dummy in prange(first, len(count)):
        total, enthalpy, speed = 0.0, 0.0, np.zeros(3)
        for k in range(count[dummy]):
            j = neighbor[dummy, k]
            square, depth = 0.0, 0.0
            for axis in range(dimension):
                along = fields[X + axis, j] - fields[X + axis, dummy]
                square += along * along
                depth -= pull[axis, dummy - first] * along
            weight = value_of(math.sqrt(square) * inverse, kernel) * fields[LIQUID, j]
            total += weight
            enthalpy += weight * (fields[ENTHALPY, j] + depth)
            for axis in range(dimension):
                speed[axis] += weight * fields[U + axis, j]
        near = total > NOTHING
        enthalpy = enthalpy / total if near else 0.0
        _set_state(fields, dummy, max(enthalpy, 0.0) if clip else enthalpy, material)
        for axis in range(dimension):
            wall = fields[V + axis, dummy]
            fields[U + axis, dummy] = 2.0 * wall - speed[axis] / total if near else wall


@compiled_inside
def _set_state(fields: Any, i: int, enthalpy: float, material: Any) -> None:
    c0, gamma, rho0 = material[C0], material[GAMMA], material[RHO0]
    density = enthalpies.density_at_enthalpy(enthalpy, rho0, c0, gamma)
    fields[ENTHALPY, i] = enthalpy
    fields[RHO, i] = density
    fields[P, i] = states.tait_pressure(density, rho0, c0, gamma)
