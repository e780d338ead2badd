"""Eddies smaller than particles: a viscosity from the rate of strain (Smagorinsky), added to the liquid's own."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume._jit import admit, prange, summing
from ecume.laws import viscous
from ecume.models.sph.fields import DIMENSION, INVERSE, KERNEL, MU, RHO, SCALE, VOLUME, U, X
from ecume.models.sph.gradients import solved
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.state import Workspace
from ecume.models.sph.weights import slope_of

admit(viscous)

INDEX = np.uint64
LEAST = 1e-30
"""Pa s: a harmonic mean of two zeros is none."""


def stir(parameters: Parameters, workspace: Workspace) -> None:
    """Set the row MU of the liquid and its images."""
    fields, lists, images = workspace.fields, workspace.lists, workspace.images
    viscosity = max(parameters.material.viscosity, LEAST)
    numbers, choices = parameters.numbers, parameters.choices
    fill_viscosities(fields, lists.counts, lists.neighbor, numbers, choices, parameters.spacing, viscosity,
                     workspace.rates)  # fmt: skip
    real = len(lists.counts)
    for first, last in zip(images.start[:-1], images.start[1:], strict=True):
        fields[MU, real + first : real + last] = fields[MU, images.source[first:last]]


@summing
def fill_viscosities(
    fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, spacing: float, viscosity: float, rates: Any
) -> None:
    """Of the liquid's columns, by the renormalized gradient of the velocity that friction sees; walls have a say."""
    kernel, deep, inverse, scale = choices[KERNEL], choices[DIMENSION] == 3, numbers[INVERSE], numbers[SCALE]
    for particle in prange(rates.shape[1]):
        i = INDEX(particle)
        x, y, z = fields[X, i], fields[X + 1, i], fields[X + 2, i]
        u, v, w = fields[U, i], fields[U + 1, i], fields[U + 2, i]
        xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        ux, uy, uz, vx, vy, vz, wx, wy, wz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(INDEX(count[i])):
            j = INDEX(neighbor[i, k])
            dx, dy, dz = fields[X, j] - x, fields[X + 1, j] - y, 0.0
            du, dv, dw = fields[U, j] - u, fields[U + 1, j] - v, 0.0
            if deep:
                dz, dw = fields[X + 2, j] - z, fields[U + 2, j] - w
            share = scale * slope_of(math.sqrt(dx * dx + dy * dy + dz * dz) * inverse, kernel) * fields[VOLUME, j]
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
        fields[MU, i] = viscosity + fields[RHO, i] * viscous.eddy_viscosity(strain, spacing, viscous.SMAGORINSKY)
