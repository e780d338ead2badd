"""Renormalized gradients, exact for linear fields, also at a free surface; and the eddy viscosity made from one.

sum_j V_j F (A_j - A_i) x_ij = B grad A with B = sum_j V_j F x_ij x_ij (minus the unit matrix in full surroundings);
Randles and Libersky, Comput. Methods Appl. Mech. Eng. 139 (1996) 375. [randles1996]

The gradient of the density corrects the density diffusion; that of the velocity gives the viscosity of eddies smaller
than a particle, from the rate of strain (Smagorinsky), which is added to the viscosity of the liquid.
"""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import admit, prange, summed_inside, summing
from ecume.engine.neighbor_rows import Lists
from ecume.laws import diffusion, viscous
from ecume.models.sph.fields import FIELD, RATE, Constants, Floats
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.rates.corrections import SINGULAR, Symmetric, cofactors
from ecume.models.sph.rates.sums import slope_of
from ecume.models.sph.state import Workspace

admit(diffusion, viscous)
INDEX = np.uint64


@summing
def fill_density_gradients(fields: Floats, liquid: int, lists: Lists, constants: Constants) -> None:
    """Fill the density gradient of the liquid; walls and bodies do not contribute."""
    kernel, deep, inverse, scale = (
        constants[0].kernel,
        constants[0].dimension == 3,
        constants[0].inverse_length,
        constants[0].slope_factor,
    )
    counts, neighbor = lists
    for particle in prange(liquid):
        i = INDEX(particle)
        x, y, z, density = (
            fields[FIELD.position, i],
            fields[FIELD.position + 1, i],
            fields[FIELD.position + 2, i],
            fields[FIELD.density, i],
        )
        xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        sx, sy, sz = 0.0, 0.0, 0.0
        for k in range(INDEX(counts[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = (
                fields[FIELD.position, j] - x,
                fields[FIELD.position + 1, j] - y,
                fields[FIELD.position + 2, j] - z,
            )
            weight, more = fields[FIELD.volume, j] * fields[FIELD.liquid, j], fields[FIELD.density, j] - density
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
        fields[FIELD.density_gradient, i] = gx
        fields[FIELD.density_gradient + 1, i] = gy
        fields[FIELD.density_gradient + 2, i] = gz


@summed_inside
def solved(matrix: Symmetric, x: float, y: float, z: float) -> tuple[float, float, float]:
    """The solution of a symmetric system (xx, yy, zz, xy, xz, yz); zero where it is nearly singular."""
    (c00, c11, c22, c01, c02, c12), determinant = cofactors(matrix)
    inverse = 1.0 / determinant if math.fabs(determinant) > SINGULAR else 0.0
    return (
        inverse * (c00 * x + c01 * y + c02 * z),
        inverse * (c01 * x + c11 * y + c12 * z),
        inverse * (c02 * x + c12 * y + c22 * z),
    )


@summing
def add_gradient_diffusion(fields: Floats, lists: Lists, constants: Constants, factor: float, rates: Floats) -> None:
    """Antuono's correction of the diffusion: less what both particles' gradients say lies between them.

    `factor` is the diffusion's own (Antuono et al. 2010, eq. 6).
    """
    kernel, deep = constants[0].kernel, constants[0].dimension == 3
    inverse, zero = constants[0].inverse_length, constants[0].zero
    counts, neighbor = lists
    for particle in prange(rates.shape[1]):
        i = INDEX(particle)
        x, y, z = fields[FIELD.position, i], fields[FIELD.position + 1, i], fields[FIELD.position + 2, i]
        gx, gy, gz = (
            fields[FIELD.density_gradient, i],
            fields[FIELD.density_gradient + 1, i],
            fields[FIELD.density_gradient + 2, i],
        )
        total = zero
        for k in range(INDEX(counts[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = (
                fields[FIELD.position, j] - x,
                fields[FIELD.position + 1, j] - y,
                fields[FIELD.position + 2, j] - z,
            )
            weight = fields[FIELD.weight, j] * fields[FIELD.liquid, j]
            square = dx * dx + dy * dy
            own, other = (
                gx * dx + gy * dy,
                fields[FIELD.density_gradient, j] * dx + fields[FIELD.density_gradient + 1, j] * dy,
            )
            if deep:
                square += dz * dz
                own, other = own + gz * dz, other + fields[FIELD.density_gradient + 2, j] * dz
            slope = slope_of(math.sqrt(square) * inverse, kernel) * weight
            total += diffusion.flow(diffusion.beyond_rest(zero, zero, diffusion.mean_rise(own, other)), slope)
        rates[RATE.diffusion, i] += factor * total


LEAST = 1e-30
"""Pa s, a lower bound: the harmonic mean of two zeros is not a number."""


def set_eddy_viscosity(parameters: Parameters, workspace: Workspace) -> None:
    """Set the viscosity of the liquid and its images, with the eddy viscosity."""
    fields, lists, images = workspace.fields, workspace.lists, workspace.images
    viscosity = max(parameters.material.viscosity, LEAST)
    constants = parameters.constants
    fill_viscosities(fields.table, lists, constants, parameters.spacing, viscosity,
                     workspace.rates.table)  # fmt: skip
    real = len(lists.counts)
    for first, last in zip(images.start[:-1], images.start[1:], strict=True):
        fields.viscosity[real + first : real + last] = fields.viscosity[images.source[first:last]]


@summing
def fill_viscosities(
    fields: Floats,
    lists: Lists,
    constants: Constants,
    spacing: float,
    viscosity: float,
    rates: Floats,
) -> None:
    """Fill the viscosity of the liquid, by the renormalized gradient of the friction velocity; walls contribute."""
    kernel, deep, inverse, scale = (
        constants[0].kernel,
        constants[0].dimension == 3,
        constants[0].inverse_length,
        constants[0].slope_factor,
    )
    counts, neighbor = lists
    for particle in prange(rates.shape[1]):
        i = INDEX(particle)
        x, y, z = fields[FIELD.position, i], fields[FIELD.position + 1, i], fields[FIELD.position + 2, i]
        u, v, w = (
            fields[FIELD.friction_velocity, i],
            fields[FIELD.friction_velocity + 1, i],
            fields[FIELD.friction_velocity + 2, i],
        )
        xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        ux, uy, uz, vx, vy, vz, wx, wy, wz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(INDEX(counts[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = fields[FIELD.position, j] - x, fields[FIELD.position + 1, j] - y, 0.0
            du, dv, dw = fields[FIELD.friction_velocity, j] - u, fields[FIELD.friction_velocity + 1, j] - v, 0.0
            if deep:
                dz, dw = fields[FIELD.position + 2, j] - z, fields[FIELD.friction_velocity + 2, j] - w
            share = scale * slope_of(math.sqrt(dx * dx + dy * dy + dz * dz) * inverse, kernel) * fields[FIELD.volume, j]
            sx, sy, sz = share * dx, share * dy, share * dz
            xx += sx * dx
            yy += sy * dy
            zz += sz * dz
            xy += sx * dy
            xz += sx * dz
            yz += sy * dz
            ux += sx * du
            uy += sy * du
            uz += sz * du
            vx += sx * dv
            vy += sy * dv
            vz += sz * dv
            wx += sx * dw
            wy += sy * dw
            wz += sz * dw
        matrix = (xx, yy, zz, xy, xz, yz) if deep else (xx, yy, -1.0, xy, 0.0, 0.0)
        ux, uy, uz = solved(matrix, ux, uy, uz)
        vx, vy, vz = solved(matrix, vx, vy, vz)
        wx, wy, wz = solved(matrix, wx, wy, wz)
        shear = (uy + vx) * (uy + vx) + (uz + wx) * (uz + wx) + (vz + wy) * (vz + wy)
        strain = math.sqrt(2.0 * (ux * ux + vy * vy + wz * wz) + shear)
        fields[FIELD.viscosity, i] = viscosity + fields[FIELD.density, i] * viscous.eddy_viscosity(
            strain, spacing, viscous.SMAGORINSKY
        )
