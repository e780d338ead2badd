"""The equation for the pressure of an incompressible liquid, A p = b, without a matrix: two sums over neighbors.

Signs as in `rates.sums`: displacements are from i to j, F = (1/r) dW/dr is negative, and g_ij = F x_ij is the gradient
of the kernel at j. Volumes V are constant. With T_i = sum_j V_j g_ij, where dummies count twice,

    acceleration   a_i = [p_i T_i + sum_j V_j p_j g_ij] / rho
    compression    c_i = sum_j V_j g_ij.v_j - T_i.v_i = -div v
    compact        l_i = (2/rho) [D_i p_i + sum_j V_j p_j F_ij].

The sums over j are over liquid and its images. At a dummy, pressure and velocity are those of the particle itself,
mirrored at the wall. With the weights V_i the compression is the adjoint of the acceleration, with opposite sign, so
that -c(a(p)) is symmetric and not negative: its projection is exact [ihmsen2014]. It does not see pressures that
alternate from particle to particle, which would grow without bound. l(p) is the Laplacian of [cummins1999], which sees
these best, but leaves a divergence behind. A is the mean of both, time^2 [-c(a(p)) + l(p)]/2. D_i = -sum_j V_j F_ij; at
a free surface, the value of a full lattice: what is missing is air, with a pressure of zero [nair2014].

Behind walls pressure continues as at rest under gravity G. That part of the pressures of images and dummies is known,
and so are its acceleration r and its Laplacian m. At rest div(r + a(p)) = -div G between mirrors, while m + l(p) = 0:
this is why the two have sources of their own, see `known_compression`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, prange, spread, summing
from ecume.engine.cells import Integers
from ecume.engine.neighbor_rows import Lists
from ecume.laws import incompressible
from ecume.models.sph.boundaries.forces_on_solids import chains_of, roots_of
from ecume.models.sph.fields import FIELD, Constants, Floats
from ecume.models.sph.parameters import Parameters, Projection
from ecume.models.sph.rates.kernels import slope_of, value_of
from ecume.models.sph.rates.sums import INDEX, whole
from ecume.models.sph.state import Workspace
from ecume.units import Array

admit(incompressible)


class System(NamedTuple):
    """The equation of one step; N particles of liquid, and columns for dummies and images too."""

    gradient: Array
    """(d + 1, N, room) 1/m^(d+1): g_ij, and F_ij in 1/m^(d+2)"""
    closing: Array
    """(d, N) 1/m: T_i"""
    compact: Array
    """(N,) 1/m^2: D_i"""
    summed: Array
    """(N,) sum of V_j W_ij, itself included"""
    steepness: Array
    """(N,) 1/m: |sum of V_j g_ij|, dummies included like liquid"""
    resting: Array
    """(d, N) m/s^2: the acceleration by the pressures of images and dummies where that of the liquid is zero"""
    held: Array
    """(N,) 1/s^2: l of these pressures"""
    diagonal: Array
    """(N,) 1/Pa: of A"""
    volume: Array
    """(N,)"""
    weight: Array
    """(columns,) volumes of liquid and images, zero for dummies"""
    root: Integers
    """(columns,) the particle of liquid that each column is, or is an image of; 0 for dummies"""
    sign: Array
    """(d, columns) -1 for components that mirrors turn around, 0 for dummies"""
    lists: Lists
    density: float
    time: float


def assemble(now: Parameters, settings: Projection, workspace: Workspace, time: float) -> System:
    """The equation at the present positions, from fields that were filled with a pressure of zero."""
    lists, table = workspace.lists, workspace.fields.table
    d, count, room = now.dimension, workspace.rates.shape[1], lists.neighbor.shape[1]
    gradient, closing, resting = np.empty((d + 1, count, room)), np.empty((d, count)), np.empty((d, count))
    compact, held, diagonal, summed = np.empty((4, count))
    slant = np.zeros((d, count))
    pull = np.concatenate([now.gravity, now.pull_center - now.origin, [now.pull_rate]])
    sum_gradients(
        closing, table, lists, now.constants, pull,
        (now.material.density, time, settings.full if settings.free_surface else 0.0),
        gradient, resting, slant, compact, summed, held, diagonal,
    )  # fmt: skip
    root, sign = mirrored(now, workspace)
    liquid = root < count
    root = np.where(liquid, root, 0)
    volume = workspace.fields.volume[:count].astype(np.float64)
    return System(
        gradient, closing, compact, summed, np.sqrt((slant**2).sum(axis=0)), resting, held, diagonal, volume,
        volume[root] * liquid, root, sign * liquid, lists, now.material.density, time,
    )  # fmt: skip


def mirrored(now: Parameters, workspace: Workspace) -> tuple[Integers, Array]:
    """The real particle of each column, and the signs that mirrors give the components of its vectors."""
    images, real, d = workspace.images, len(workspace.lists.counts), now.dimension
    root = np.concatenate([np.arange(real), roots_of(images, real)])
    sign, chains, sides = np.ones((d, len(root))), chains_of(images, real), now.boundary.sides
    for side in np.flatnonzero(sides.mirrors):
        turned = real + np.flatnonzero(chains >> side & 1)
        sign[:, turned] *= (1.0 - 2.0 * np.abs(sides.normal[side]))[:, None]
    return root, sign


@spread
def sum_gradients(
    closing: Array, fields: Floats, lists: Lists, constants: Constants, pull: Array,
    numbers: tuple[float, float, float], gradient: Array, resting: Array, slant: Array, compact: Array,
    summed: Array, held: Array, diagonal: Array,
) -> None:  # fmt: skip
    """Fill g_ij and F_ij, T_i, D_i, the sums of kernels, the acceleration where pressures are zero, the diagonal of A.

    `pull` is gravity, then the center and the rate of the central force; `numbers` are the density, the time, and the
    least D, dummies included.
    """
    kernel, dimension = constants[0].kernel, closing.shape[0]
    inverse, scale = constants[0].inverse_length, constants[0].slope_factor
    factor = scale / (inverse * inverse)  # of the kernel
    density, time, full = numbers
    counts, neighbor = lists
    for i in prange(closing.shape[1]):
        own = fields[FIELD.volume, i]
        total, squares, near, behind = own * value_of(0.0 * inverse, kernel), 0.0, 0.0, 0.0
        held[i] = 0.0
        for axis in range(dimension):
            closing[axis, i] = 0.0
            resting[axis, i] = 0.0
        for k in range(counts[i]):
            j = neighbor[i, k]
            volume, liquid = fields[FIELD.volume, j], fields[FIELD.liquid, j]
            square, hydrostatic = 0.0, 0.0
            for axis in range(dimension):
                along = fields[FIELD.position + axis, j] - fields[FIELD.position + axis, i]
                away = fields[FIELD.position + axis, j] - pull[dimension + axis]
                square += along * along
                hydrostatic += (pull[axis] - pull[2 * dimension] * pull[2 * dimension] * away) * along
            q = math.sqrt(square) * inverse
            slope = scale * slope_of(q, kernel)
            total += volume * value_of(q, kernel)
            squares += liquid * volume * slope * slope * square
            near -= liquid * volume * slope
            behind -= (1.0 - liquid) * volume * slope
            push = fields[FIELD.pressure, j] if liquid > 0.0 else density * hydrostatic
            held[i] += 2.0 * volume * slope * push / density
            gradient[dimension, i, k] = slope
            for axis in range(dimension):
                along = slope * (fields[FIELD.position + axis, j] - fields[FIELD.position + axis, i])
                gradient[axis, i, k] = along
                closing[axis, i] += (2.0 - liquid) * volume * along
                slant[axis, i] += volume * along
                resting[axis, i] += volume * along * push / density
        for k in range(counts[i], whole(counts[i])):
            for axis in range(dimension + 1):
                gradient[axis, i, k] = 0.0
        closed = 0.0
        for axis in range(dimension):
            closed += closing[axis, i] * closing[axis, i]
        summed[i] = factor * total
        compact[i] = max(near, full - behind)
        diagonal[i] = incompressible.diagonal(own * squares + closed, compact[i], density, time)


def accelerations(system: System, pressure: Array) -> Array:
    """(d, N) a(p), m/s^2."""
    return _sums_of_pressure(system, pressure)[:-1]


def _sums_of_pressure(system: System, pressure: Array) -> Array:
    """(d + 1, N) a(p) and l(p)."""
    found = np.empty((len(system.closing) + 1, len(pressure)))
    carried = system.weight * pressure[system.root]
    sum_pressure(
        found, system.gradient, system.closing, system.compact, pressure, carried, system.lists, system.density
    )
    return found


def applied(system: System, pressure: Array) -> Array:
    """A p: the relative decrease of density in the step."""
    sums = _sums_of_pressure(system, pressure)
    exact = -compressions(system, sums[:-1])
    return incompressible.decrease(exact, sums[-1], system.time)


def compressions(system: System, velocity: Array) -> Array:
    """(N,) c(v), 1/s, with walls at rest."""
    return compressions_of(system, velocity, system.weight * system.sign * velocity[:, system.root])


def known_compression(now: Parameters, system: System, position: Array) -> Array:
    """(N,) 1/s^2: the mean of the sources c(r) of -c(a(p)) and -c(G) - m of l(p)."""
    away = position - now.pull_center[:, None]
    gravity = now.gravity[:, None] - now.pull_rate**2 * away
    both = compressions(system, system.resting - gravity)
    found: Array = 0.5 * (both - system.held)
    return found


def compressions_of(system: System, velocity: Array, carried: Array) -> Array:
    """(N,) c(v), 1/s; `carried` is (d, columns), volume times velocity, twice that of dummies."""
    found = np.empty(velocity.shape[1])
    sum_compression(found, system.gradient, system.closing, velocity, carried, system.lists)
    return found


def moving_compressions(system: System, workspace: Workspace, velocity: Array) -> Array:
    """(N,) c(v), 1/s, with walls that move, from filled fields."""
    fields = workspace.fields
    carried = fields.volume * (2.0 - fields.liquid) * fields.velocity[: len(velocity)]
    return compressions_of(system, velocity, carried.astype(np.float64))


@summing
def sum_pressure(
    found: Array, gradient: Array, closing: Array, compact: Array, pressure: Array, carried: Array, lists: Lists,
    density: float,
) -> None:  # fmt: skip
    """Sum a_i = [p_i T_i + sum_j V_j p_j g_ij]/rho, and l_i = (2/rho)[D_i p_i + sum_j V_j p_j F_ij]."""
    counts, neighbor = lists
    dimension = INDEX(closing.shape[0])
    for particle in prange(closing.shape[1]):
        i = INDEX(particle)
        for axis in range(dimension):
            total = 0.0
            for k in range(whole(counts[i])):
                total += gradient[axis, i, k] * carried[INDEX(neighbor[i, k])]
            found[axis, i] = (total + pressure[i] * closing[axis, i]) / density
        total = 0.0
        for k in range(whole(counts[i])):
            total += gradient[dimension, i, k] * carried[INDEX(neighbor[i, k])]
        found[dimension, i] = 2.0 * (total + pressure[i] * compact[i]) / density


@summing
def sum_compression(
    found: Array, gradient: Array, closing: Array, velocity: Array, carried: Array, lists: Lists
) -> None:
    """Sum the compressions c_i = sum_j V_j g_ij.v_j - T_i.v_i."""
    counts, neighbor = lists
    for particle in prange(len(found)):
        i, total = INDEX(particle), 0.0
        for axis in range(INDEX(closing.shape[0])):
            for k in range(whole(counts[i])):
                total += gradient[axis, i, k] * carried[axis, INDEX(neighbor[i, k])]
            total -= closing[axis, i] * velocity[axis, i]
        found[i] = total
