"""Sums whose kernel gradients are completed at a free surface, where neighbors are missing on one side.

There the divergence of velocity by `sums.sum_continuity` counts strain along and across the surface differently, and
the upper rows of particles have to move relative to each other in every wave, which costs energy. With the matrix B_i
of `fill_corrections`

    div v = sum_j V_j (v_j - v_i).B_i grad W,    F_i = -sum_j V_i V_j (p_i B_i + p_j B_j) grad W:

the divergence is exact for linear velocities, and the force is its adjoint, so that energy and momentum are conserved
(Bonet and Lok, Comput. Methods Appl. Mech. Eng. 180 (1999) 97). A dummy has no such matrix, and pairs with one are not
corrected. [bonet1999]

The rate at which damped sound decays in a lattice grows with the square of B: by a factor of 4 in the first row below a
flat surface, and up to 25 in drops of a few particles. Drops are not corrected (`kernels.correction_share`), and the
acoustic damping of a particle is divided by the square of its factor (`kernels.completion_factor`), so that the fastest
rate is that of the interior and the usual time step resolves it.
"""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import admit, prange, summed_inside, summing
from ecume.engine.neighbor_rows import Lists
from ecume.laws import diffusion, kernels
from ecume.models.sph.fields import FIELD, RATE, Constants, Fields, Floats
from ecume.models.sph.rates.sums import damping, pair_divergence, slope_of
from ecume.units import Array

admit(diffusion, kernels)
INDEX = np.uint64
SINGULAR = 1e-3
"""Below this determinant of its matrix a particle has too few neighbors for a gradient."""
Symmetric = tuple[float, float, float, float, float, float]
"""xx, yy, zz, xy, xz, yz"""
Vector = tuple[float, float, float]
Place = int | np.uint64


@summed_inside
def cofactors(matrix: Symmetric) -> tuple[Symmetric, float]:
    """The inverse of a symmetric matrix times its determinant, and the determinant."""
    xx, yy, zz, xy, xz, yz = matrix
    first, second, third = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    inverse = first, xx * zz - xz * xz, xx * yy - xy * xy, second, third, xy * xz - xx * yz
    return inverse, xx * first + xy * second + xz * third


@summing
def fill_corrections(fields: Floats, liquid: int, lists: Lists, constants: Constants) -> None:
    """Fill the matrices of the liquid: 1 + s (B - 1) with the share s of `kernels.correction_share`."""
    kernel, deep, inverse, scale = (
        constants[0].kernel,
        constants[0].dimension == 3,
        constants[0].inverse_length,
        constants[0].slope_factor,
    )
    counts, neighbor = lists
    for particle in prange(liquid):
        i = INDEX(particle)
        x, y, z = fields[FIELD.position, i], fields[FIELD.position + 1, i], fields[FIELD.position + 2, i]
        xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(INDEX(counts[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = (
                fields[FIELD.position, j] - x,
                fields[FIELD.position + 1, j] - y,
                fields[FIELD.position + 2, j] - z,
            )
            square = dx * dx + dy * dy
            if deep:
                square += dz * dz
            share = -scale * slope_of(math.sqrt(square) * inverse, kernel) * fields[FIELD.volume, j]
            xx += share * dx * dx
            yy += share * dy * dy
            zz += share * dz * dz
            xy += share * dx * dy
            xz += share * dx * dz
            yz += share * dy * dz
        missing = kernels.missing_neighbors(xx + yy + zz, 3.0 if deep else 2.0)
        if not deep:
            zz, xz, yz = 1.0, 0.0, 0.0
        (c00, c11, c22, c01, c02, c12), determinant = cofactors((xx, yy, zz, xy, xz, yz))
        share, part = 0.0, 0.0
        if determinant > SINGULAR:
            inverted = 1.0 / determinant
            off = (inverted * c00 - 1.0) ** 2 + (inverted * c11 - 1.0) ** 2 + (inverted * c22 - 1.0) ** 2
            off += 2.0 * inverted * inverted * (c01 * c01 + c02 * c02 + c12 * c12)
            share = kernels.correction_share(missing, kernels.completion_factor(off))
            part = share * inverted
        fields[FIELD.correction, i] = 1.0 - share + part * c00
        fields[FIELD.correction + 1, i] = 1.0 - share + part * c11
        fields[FIELD.correction + 2, i] = 1.0 - share + part * c22
        fields[FIELD.correction + 3, i] = part * c01
        fields[FIELD.correction + 4, i] = part * c02
        fields[FIELD.correction + 5, i] = part * c12


def completion_factors(fields: Fields, count: int) -> Array:
    """(N,) `kernels.completion_factor` of the first particles."""
    matrix = fields.correction[:, :count].astype(np.float64)
    off = ((matrix[:3] - 1.0) ** 2).sum(axis=0) + 2.0 * (matrix[3:] ** 2).sum(axis=0)
    factors: Array = 1.0 + np.sqrt(off)
    return factors


@summed_inside
def completed(fields: Floats, i: Place, x: float, y: float, z: float) -> Vector:
    """B_i x."""
    xx, yy, zz = fields[FIELD.correction, i], fields[FIELD.correction + 1, i], fields[FIELD.correction + 2, i]
    xy, xz, yz = fields[FIELD.correction + 3, i], fields[FIELD.correction + 4, i], fields[FIELD.correction + 5, i]
    return xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z


@summed_inside
def between(share: float, x: Vector, other: Vector) -> Vector:
    """X where the share is zero, the other vector where it is one."""
    (a, b, c), (d, e, f) = x, other
    return a + share * (d - a), b + share * (e - b), c + share * (f - c)


@summing
def sum_corrected_continuity(
    fields: Floats, lists: Lists, constants: Constants, diffusing: Floats, rates: Floats
) -> None:  # fmt: skip
    """Continuity by (v_j - v_i).B_i x_ij, and the diffusion of `sums.sum_continuity`."""
    kernel = constants[0].kernel
    counts, neighbor = lists
    for particle in prange(constants[0].first, min(constants[0].last, rates.shape[1])):
        i, numbers = INDEX(particle), constants[0]
        x, y, z = fields[FIELD.position, i], fields[FIELD.position + 1, i], fields[FIELD.position + 2, i]
        u, v, w = fields[FIELD.velocity, i], fields[FIELD.velocity + 1, i], fields[FIELD.velocity + 2, i]
        own = diffusing[i]
        inverse, zero = numbers.inverse_length, numbers.zero
        gx, gy, gz = numbers.rise_x, numbers.rise_y, numbers.rise_z
        stretching, flow = zero, zero
        for k in range(INDEX(counts[i])):
            j = INDEX(neighbor[i, k])
            dx, dy = fields[FIELD.position, j] - x, fields[FIELD.position + 1, j] - y
            dz = fields[FIELD.position + 2, j] - z
            du, dv = fields[FIELD.velocity, j] - u, fields[FIELD.velocity + 1, j] - v
            dw = fields[FIELD.velocity + 2, j] - w
            weight, liquid, other = fields[FIELD.weight, j], fields[FIELD.liquid, j], diffusing[j]
            rise = gx * dx + gy * dy + gz * dz
            pull = slope_of(math.sqrt(dx * dx + dy * dy + dz * dz) * inverse, kernel) * weight
            bx, by, bz = between(liquid, (dx, dy, dz), completed(fields, i, dx, dy, dz))
            stretching += pair_divergence(pull, bx * du + by * dv + bz * dw)
            flow += diffusion.flow(diffusion.beyond_rest(own, other, rise), pull) * liquid
        rates[RATE.continuity, i] = numbers.slope_factor * stretching
        rates[RATE.diffusion, i] = numbers.slope_factor * numbers.delta * flow


@summing
def sum_corrected_pressure(fields: Floats, lists: Lists, constants: Constants, rates: Floats) -> None:
    """Pressure by p_i B_i + p_j B_j, and the artificial viscosity of `sums.sum_momentum`."""
    kernel = constants[0].kernel
    counts, neighbor = lists
    for particle in prange(constants[0].first, min(constants[0].last, rates.shape[1])):
        i, numbers = INDEX(particle), constants[0]
        x, y, z = fields[FIELD.position, i], fields[FIELD.position + 1, i], fields[FIELD.position + 2, i]
        u, v, w = fields[FIELD.velocity, i], fields[FIELD.velocity + 1, i], fields[FIELD.velocity + 2, i]
        own = fields[FIELD.force_term, i]
        inverse, zero = numbers.inverse_length, numbers.zero
        damper = numbers.smoothing_length, numbers.damping_divisor, numbers.sound_speed, numbers.alpha
        ax, ay, az = zero, zero, zero
        for k in range(INDEX(counts[i])):
            j = INDEX(neighbor[i, k])
            dx, dy = fields[FIELD.position, j] - x, fields[FIELD.position + 1, j] - y
            dz = fields[FIELD.position + 2, j] - z
            du, dv = fields[FIELD.velocity, j] - u, fields[FIELD.velocity + 1, j] - v
            dw = fields[FIELD.velocity + 2, j] - w
            weight, liquid, push = fields[FIELD.weight, j], fields[FIELD.liquid, j], fields[FIELD.force_term, j]
            square, radial = dx * dx + dy * dy + dz * dz, du * dx + dv * dy + dw * dz
            pull = slope_of(math.sqrt(square) * inverse, kernel) * weight
            damp = damping(radial, square, damper) * liquid
            bx, by, bz = between(liquid, (dx, dy, dz), completed(fields, i, dx, dy, dz))
            cx, cy, cz = completed(fields, j, dx, dy, dz)
            ax += pull * (own * bx + push * cx + damp * dx)
            ay += pull * (own * by + push * cy + damp * dy)
            az += pull * (own * bz + push * cz + damp * dz)
        rates[RATE.acceleration, i] = numbers.slope_factor * ax
        rates[RATE.acceleration + 1, i] = numbers.slope_factor * ay
        rates[RATE.acceleration + 2, i] = numbers.slope_factor * az


@summed_inside
def completion(fields: Floats, i: Place, j: Place, apart: Vector) -> float:
    """x.(B_i + B_j) x / 2 of a pair: by how much it counts for the friction that is missing, times r^2."""
    x, y, z = apart
    (ax, ay, az), (bx, by, bz) = completed(fields, i, x, y, z), completed(fields, j, x, y, z)
    return ((ax + bx) * x + (ay + by) * y + (az + bz) * z) / 2


@summing
def sum_corrected_friction(fields: Floats, lists: Lists, constants: Constants, rates: Floats) -> None:
    """Add the viscous force of `sums.sum_radial_friction`, each pair times the `completion` over r^2."""
    kernel = constants[0].kernel
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
            dx, dy = fields[FIELD.position, j] - x, fields[FIELD.position + 1, j] - y
            dz = fields[FIELD.position + 2, j] - z
            du, dv = u - fields[FIELD.friction_velocity, j], v - fields[FIELD.friction_velocity + 1, j]
            dw = w - fields[FIELD.friction_velocity + 2, j]
            volume, other = fields[FIELD.volume, j], fields[FIELD.viscosity, j]
            square = max(dx * dx + dy * dy + dz * dz, soft)
            drag = slope_of(math.sqrt(dx * dx + dy * dy + dz * dz) * inverse, kernel) * volume * other / (own + other)
            drag *= (du * dx + dv * dy + dw * dz) / square * (completion(fields, i, j, (dx, dy, dz)) / square)
            ax += drag * dx
            ay += drag * dy
            az += drag * dz
        share = factor * own / fields[FIELD.density, i]
        rates[RATE.acceleration, i] += share * ax
        rates[RATE.acceleration + 1, i] += share * ay
        rates[RATE.acceleration + 2, i] += share * az
