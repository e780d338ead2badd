"""The sums that only some scenes ask for: viscosity, and pressure with the transport velocity."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume._jit import prange, summing
from ecume.models.sph.fields import (
    ACC,
    DIMENSION,
    FIRST,
    INVERSE,
    KERNEL,
    LAST,
    MU,
    RHO,
    SCALE,
    SOFT,
    VOLUME,
    ZERO,
    P,
    U,
    V,
    W,
    X,
)
from ecume.models.sph.weights import slope_of

INDEX = np.uint64


@summing
def rub(fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, rates: Any) -> None:
    """Add the viscous force, (2/rho_i) sum_j mu_ij F V_j (u_i - u_j), mu_ij the harmonic mean (Morris et al. 1997, eq.
    22; Adami et al. 2012, eq. 8). A wall that lets the liquid slip has no viscosity.
    """
    kernel, deep, inverse, zero = choices[KERNEL], choices[DIMENSION] == 3, numbers[INVERSE], numbers[ZERO]
    for particle in prange(choices[FIRST], min(choices[LAST], rates.shape[1])):
        i = INDEX(particle)
        x, y, z = fields[X, i], fields[X + 1, i], fields[X + 2, i]
        u, v, w = fields[U, i], fields[U + 1, i], fields[U + 2, i]
        own = fields[MU, i]
        ax, ay, az = zero, zero, zero
        for k in range(INDEX(count[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = fields[X, j] - x, fields[X + 1, j] - y, fields[X + 2, j] - z
            du, dv, dw = u - fields[U, j], v - fields[U + 1, j], w - fields[U + 2, j]
            volume, other = fields[VOLUME, j], fields[MU, j]
            square = dx * dx + dy * dy
            if deep:
                square += dz * dz
            drag = slope_of(math.sqrt(square) * inverse, kernel) * volume * other / (own + other)
            ax += drag * du
            ay += drag * dv
            az += drag * dw
        share = numbers[SCALE] * (own + own + own + own) / fields[RHO, i]
        rates[ACC, i] += share * ax
        rates[ACC + 1, i] += share * ay
        rates[ACC + 2, i] += share * az


@summing
def rub_radially(fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, rates: Any) -> None:
    """Add the viscous force along the lines between particles, (1/rho_i) sum_j Z_ij F V_j [(u_i - u_j).x_ij] x_ij/r^2,
    Z_ij = 2 (d + 2) times the harmonic mean of the viscosities (Monaghan 2005).
    """
    kernel, deep, inverse, zero = choices[KERNEL], choices[DIMENSION] == 3, numbers[INVERSE], numbers[ZERO]
    factor = numbers[SCALE] * 4.0 * (choices[DIMENSION] + 2)
    for particle in prange(choices[FIRST], min(choices[LAST], rates.shape[1])):
        i = INDEX(particle)
        x, y, z = fields[X, i], fields[X + 1, i], fields[X + 2, i]
        u, v, w = fields[U, i], fields[U + 1, i], fields[U + 2, i]
        own, soft = fields[MU, i], numbers[SOFT]
        ax, ay, az = zero, zero, zero
        for k in range(INDEX(count[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = fields[X, j] - x, fields[X + 1, j] - y, zero
            volume, other = fields[VOLUME, j], fields[MU, j]
            square, radial = dx * dx + dy * dy, (u - fields[U, j]) * dx + (v - fields[U + 1, j]) * dy
            if deep:
                dz = fields[X + 2, j] - z
                square, radial = square + dz * dz, radial + (w - fields[U + 2, j]) * dz
            drag = slope_of(math.sqrt(square) * inverse, kernel) * volume * other / (own + other)
            # Nobody is so near to another, but a particle may be to its own image.
            drag *= radial / max(square, soft)
            ax += drag * dx
            ay += drag * dy
            az += drag * dz
        share = factor * own / fields[RHO, i]
        rates[ACC, i] += share * ax
        rates[ACC + 1, i] += share * ay
        rates[ACC + 2, i] += share * az


@summing
def push_transported(fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, rates: Any) -> None:
    """Pressure weighted by densities, and the momentum that a transport velocity W carries beside the liquid's.

    (1/m_i) sum_j (V_i^2 + V_j^2) [p_ij - (1/2)(A_i + A_j).x_ij ...] F x_ij with p_ij = (rho_j p_i + rho_i p_j)/(rho_i +
    rho_j), A = rho v W (Adami et al. 2013, eqs. 5, 8 and 10). [adami2013]
    """
    kernel, deep, inverse, zero = choices[KERNEL], choices[DIMENSION] == 3, numbers[INVERSE], numbers[ZERO]
    for particle in prange(rates.shape[1]):
        i = INDEX(particle)
        x, y, z = fields[X, i], fields[X + 1, i], fields[X + 2, i]
        u, v, w = fields[V, i], fields[V + 1, i], fields[V + 2, i]
        a, b, c = fields[W, i], fields[W + 1, i], fields[W + 2, i]
        density, pressure, volume = fields[RHO, i], fields[P, i], fields[VOLUME, i]
        ax, ay, az = zero, zero, zero
        for k in range(INDEX(count[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = fields[X, j] - x, fields[X + 1, j] - y, fields[X + 2, j] - z
            other, space, push = fields[RHO, j], fields[VOLUME, j], fields[P, j]
            square = dx * dx + dy * dy
            own_flux = density * (a * dx + b * dy)
            flux = other * (fields[W, j] * dx + fields[W + 1, j] * dy)
            if deep:
                square += dz * dz
                own_flux += density * c * dz
                flux += other * fields[W + 2, j] * dz
            pull = slope_of(math.sqrt(square) * inverse, kernel) * (volume * volume + space * space)
            mean = (other * pressure + density * push) / (other + density)
            # Half of each flux: the other half is in the factor outside.
            ax += pull * (mean * dx + mean * dx - own_flux * u - flux * fields[V, j])
            ay += pull * (mean * dy + mean * dy - own_flux * v - flux * fields[V + 1, j])
            if deep:
                az += pull * (mean * dz + mean * dz - own_flux * w - flux * fields[V + 2, j])
        mass = density * volume
        share = numbers[SCALE] / (mass + mass)
        rates[ACC, i] = share * ax
        rates[ACC + 1, i] = share * ay
        rates[ACC + 2, i] = share * az
