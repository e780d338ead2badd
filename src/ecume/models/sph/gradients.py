"""Renormalized gradients: exact for whatever grows linearly, at a surface too.

sum_j V_j F (A_j - A_i) x_ij = B grad A with B = sum_j V_j F x_ij x_ij (minus the unit matrix in full surroundings);
Randles and Libersky, Comput. Methods Appl. Mech. Eng. 139 (1996) 375. [randles1996]
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume._jit import admit, prange, summed_inside, summing
from ecume.laws import diffusion
from ecume.models.sph.fields import DIFFUSED, DIMENSION, INVERSE, KERNEL, LIQUID, RHO, SCALE, VOLUME, ZERO, G, X
from ecume.models.sph.weights import slope_of

admit(diffusion)
INDEX = np.uint64
SINGULAR = 1e-3
"""Below this determinant of -B a particle has too few neighbors for a gradient."""


@summing
def fill_density_gradients(fields: Any, liquid: int, count: Any, neighbor: Any, numbers: Any, choices: Any) -> None:
    """Rows G of the liquid's columns; walls and bodies have no say."""
    kernel, deep, inverse, scale = choices[KERNEL], choices[DIMENSION] == 3, numbers[INVERSE], numbers[SCALE]
    for particle in prange(liquid):
        i = INDEX(particle)
        x, y, z, density = fields[X, i], fields[X + 1, i], fields[X + 2, i], fields[RHO, i]
        xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        sx, sy, sz = 0.0, 0.0, 0.0
        for k in range(INDEX(count[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = fields[X, j] - x, fields[X + 1, j] - y, fields[X + 2, j] - z
            weight, more = fields[VOLUME, j] * fields[LIQUID, j], fields[RHO, j] - density
            square = dx * dx + dy * dy
            if deep:
                square += dz * dz
            share = slope_of(math.sqrt(square) * inverse, kernel) * scale * weight
            xx += share * dx * dx
            yy += share * dy * dy
            zz += share * dz * dz
            xy += share * dx * dy
            xz += share * dx * dz
            yz += share * dy * dz
            sx += share * more * dx
            sy += share * more * dy
            sz += share * more * dz
        if not deep:
            zz, xz, yz, sz = -1.0, 0.0, 0.0, 0.0
        gx, gy, gz = solved((xx, yy, zz, xy, xz, yz), sx, sy, sz)
        fields[G, i] = gx
        fields[G + 1, i] = gy
        fields[G + 2, i] = gz


@summed_inside
def solved(matrix: Any, x: float, y: float, z: float) -> Any:
    """The solution of a symmetric system (xx, yy, zz, xy, xz, yz); zero where it is nearly singular."""
    m00, m11, m22, m01, m02, m12 = matrix
    c00, c01, c02 = m11 * m22 - m12 * m12, m02 * m12 - m01 * m22, m01 * m12 - m02 * m11
    c11, c12, c22 = m00 * m22 - m02 * m02, m01 * m02 - m00 * m12, m00 * m11 - m01 * m01
    determinant = m00 * c00 + m01 * c01 + m02 * c02
    inverse = 1.0 / determinant if math.fabs(determinant) > SINGULAR else 0.0
    return (
        inverse * (c00 * x + c01 * y + c02 * z),
        inverse * (c01 * x + c11 * y + c12 * z),
        inverse * (c02 * x + c12 * y + c22 * z),
    )


@summing
def add_gradient_diffusion(
    fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, factor: float, rates: Any
) -> None:
    """Antuono's correction of the diffusion: less what both particles' gradients say lies between them.

    `factor` is the diffusion's own (Antuono et al. 2010, eq. 6).
    """
    kernel, deep, inverse, zero = choices[KERNEL], choices[DIMENSION] == 3, numbers[INVERSE], numbers[ZERO]
    for particle in prange(rates.shape[1]):
        i = INDEX(particle)
        x, y, z = fields[X, i], fields[X + 1, i], fields[X + 2, i]
        gx, gy, gz = fields[G, i], fields[G + 1, i], fields[G + 2, i]
        total = zero
        for k in range(INDEX(count[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = fields[X, j] - x, fields[X + 1, j] - y, fields[X + 2, j] - z
            weight = fields[VOLUME, j] * fields[LIQUID, j]
            square = dx * dx + dy * dy
            own, other = gx * dx + gy * dy, fields[G, j] * dx + fields[G + 1, j] * dy
            if deep:
                square += dz * dz
                own, other = own + gz * dz, other + fields[G + 2, j] * dz
            slope = slope_of(math.sqrt(square) * inverse, kernel) * weight
            total += diffusion.flow(diffusion.beyond_rest(zero, zero, diffusion.mean_rise(own, other)), slope)
        rates[DIFFUSED, i] += factor * total
