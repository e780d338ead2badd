"""Eddies smaller than particles: a viscosity from the rate of strain (Smagorinsky), added to the liquid's own."""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import admit, prange, summing
from ecume.engine.neighbor_rows import Lists
from ecume.laws import viscous
from ecume.models.sph.fields import FIELD, Constants, Floats
from ecume.models.sph.gradients import solved
from ecume.models.sph.kernels import slope_of
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.state import Workspace

admit(viscous)

INDEX = np.uint64
LEAST = 1e-30
"""Pa s: a harmonic mean of two zeros is none."""


def stir(parameters: Parameters, workspace: Workspace) -> None:
    """Set the viscosity of the liquid and its images."""
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
    """Of the liquid's columns, by the renormalized gradient of the velocity that friction sees; walls have a say."""
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
