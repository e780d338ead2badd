"""The sums that only some scenes ask for: viscosity, and pressure with the transport velocity."""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import prange, summing
from ecume.engine.neighbor_rows import Lists
from ecume.models.sph.fields import FIELD, RATE, Constants, Floats
from ecume.models.sph.kernels import slope_of

INDEX = np.uint64


@summing
def rub(fields: Floats, lists: Lists, constants: Constants, rates: Floats) -> None:
    """Add the viscous force, (2/rho_i) sum_j mu_ij F V_j (u_i - u_j), mu_ij the harmonic mean (Morris et al. 1997, eq.
    22; Adami et al. 2012, eq. 8). A wall that lets the liquid slip has no viscosity.
    """
    kernel, deep = constants[0].kernel, constants[0].dimension == 3
    inverse, zero = constants[0].inverse_length, constants[0].zero
    counts, neighbor = lists
    for particle in prange(constants[0].first, min(constants[0].last, rates.shape[1])):
        i = INDEX(particle)
        x, y, z = fields[FIELD.position, i], fields[FIELD.position + 1, i], fields[FIELD.position + 2, i]
        u, v, w = (
            fields[FIELD.friction_velocity, i],
            fields[FIELD.friction_velocity + 1, i],
            fields[FIELD.friction_velocity + 2, i],
        )
        own = fields[FIELD.viscosity, i]
        ax, ay, az = zero, zero, zero
        for k in range(INDEX(counts[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = (
                fields[FIELD.position, j] - x,
                fields[FIELD.position + 1, j] - y,
                fields[FIELD.position + 2, j] - z,
            )
            du, dv, dw = (
                u - fields[FIELD.friction_velocity, j],
                v - fields[FIELD.friction_velocity + 1, j],
                w - fields[FIELD.friction_velocity + 2, j],
            )
            volume, other = fields[FIELD.volume, j], fields[FIELD.viscosity, j]
            square = dx * dx + dy * dy
            if deep:
                square += dz * dz
            drag = slope_of(math.sqrt(square) * inverse, kernel) * volume * other / (own + other)
            ax += drag * du
            ay += drag * dv
            az += drag * dw
        share = constants[0].slope_factor * (own + own + own + own) / fields[FIELD.density, i]
        rates[RATE.acceleration, i] += share * ax
        rates[RATE.acceleration + 1, i] += share * ay
        rates[RATE.acceleration + 2, i] += share * az


@summing
def rub_radially(fields: Floats, lists: Lists, constants: Constants, rates: Floats) -> None:
    """Add the viscous force along the lines between particles, (1/rho_i) sum_j Z_ij F V_j [(u_i - u_j).x_ij] x_ij/r^2,
    Z_ij = 2 (d + 2) times the harmonic mean of the viscosities (Monaghan 2005).
    """
    kernel, deep = constants[0].kernel, constants[0].dimension == 3
    inverse, zero = constants[0].inverse_length, constants[0].zero
    factor = constants[0].slope_factor * 4.0 * (constants[0].dimension + 2)
    counts, neighbor = lists
    for particle in prange(constants[0].first, min(constants[0].last, rates.shape[1])):
        i = INDEX(particle)
        x, y, z = fields[FIELD.position, i], fields[FIELD.position + 1, i], fields[FIELD.position + 2, i]
        u, v, w = (
            fields[FIELD.friction_velocity, i],
            fields[FIELD.friction_velocity + 1, i],
            fields[FIELD.friction_velocity + 2, i],
        )
        own, soft = fields[FIELD.viscosity, i], constants[0].softening
        ax, ay, az = zero, zero, zero
        for k in range(INDEX(counts[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = fields[FIELD.position, j] - x, fields[FIELD.position + 1, j] - y, zero
            volume, other = fields[FIELD.volume, j], fields[FIELD.viscosity, j]
            square, radial = (
                dx * dx + dy * dy,
                (u - fields[FIELD.friction_velocity, j]) * dx + (v - fields[FIELD.friction_velocity + 1, j]) * dy,
            )
            if deep:
                dz = fields[FIELD.position + 2, j] - z
                square, radial = square + dz * dz, radial + (w - fields[FIELD.friction_velocity + 2, j]) * dz
            drag = slope_of(math.sqrt(square) * inverse, kernel) * volume * other / (own + other)
            # Nobody is so near to another, but a particle may be to its own image.
            drag *= radial / max(square, soft)
            ax += drag * dx
            ay += drag * dy
            az += drag * dz
        share = factor * own / fields[FIELD.density, i]
        rates[RATE.acceleration, i] += share * ax
        rates[RATE.acceleration + 1, i] += share * ay
        rates[RATE.acceleration + 2, i] += share * az


@summing
def push_transported(fields: Floats, lists: Lists, constants: Constants, rates: Floats) -> None:
    """Pressure weighted by densities, and the momentum that a transport velocity W carries beside the liquid's.

    (1/m_i) sum_j (V_i^2 + V_j^2) [p_ij - (1/2)(A_i + A_j).x_ij ...] F x_ij with p_ij = (rho_j p_i + rho_i p_j)/(rho_i +
    rho_j), A = rho v W (Adami et al. 2013, eqs. 5, 8 and 10). [adami2013]
    """
    kernel, deep = constants[0].kernel, constants[0].dimension == 3
    inverse, zero = constants[0].inverse_length, constants[0].zero
    counts, neighbor = lists
    for particle in prange(rates.shape[1]):
        i = INDEX(particle)
        x, y, z = fields[FIELD.position, i], fields[FIELD.position + 1, i], fields[FIELD.position + 2, i]
        u, v, w = fields[FIELD.velocity, i], fields[FIELD.velocity + 1, i], fields[FIELD.velocity + 2, i]
        a, b, c = fields[FIELD.transport, i], fields[FIELD.transport + 1, i], fields[FIELD.transport + 2, i]
        density, pressure, volume = fields[FIELD.density, i], fields[FIELD.pressure, i], fields[FIELD.volume, i]
        ax, ay, az = zero, zero, zero
        for k in range(INDEX(counts[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = (
                fields[FIELD.position, j] - x,
                fields[FIELD.position + 1, j] - y,
                fields[FIELD.position + 2, j] - z,
            )
            other, space, push = fields[FIELD.density, j], fields[FIELD.volume, j], fields[FIELD.pressure, j]
            square = dx * dx + dy * dy
            own_flux = density * (a * dx + b * dy)
            flux = other * (fields[FIELD.transport, j] * dx + fields[FIELD.transport + 1, j] * dy)
            if deep:
                square += dz * dz
                own_flux += density * c * dz
                flux += other * fields[FIELD.transport + 2, j] * dz
            pull = slope_of(math.sqrt(square) * inverse, kernel) * (volume * volume + space * space)
            mean = (other * pressure + density * push) / (other + density)
            # Half of each flux: the other half is in the factor outside.
            ax += pull * (mean * dx + mean * dx - own_flux * u - flux * fields[FIELD.velocity, j])
            ay += pull * (mean * dy + mean * dy - own_flux * v - flux * fields[FIELD.velocity + 1, j])
            if deep:
                az += pull * (mean * dz + mean * dz - own_flux * w - flux * fields[FIELD.velocity + 2, j])
        mass = density * volume
        share = constants[0].slope_factor / (mass + mass)
        rates[RATE.acceleration, i] = share * ax
        rates[RATE.acceleration + 1, i] = share * ay
        rates[RATE.acceleration + 2, i] = share * az
