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

from ecume._jit import admit, prange, summing
from ecume.engine.cells import Integers
from ecume.engine.neighbor_rows import Lists
from ecume.laws import incompressible
from ecume.models.sph.boundaries.forces_on_solids import chains_of, roots_of
from ecume.models.sph.fields import FIELD, Constants, Floats
from ecume.models.sph.parameters import Parameters, Projection
from ecume.models.sph.rates.kernels import KernelType, kernel_type, value_of, written_slope
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
    compact, held, diagonal, summed, slant = np.empty((5, count))
    pull = np.concatenate([now.gravity, now.pull_center - now.origin, [now.pull_rate]])
    sum_gradients(
        closing, table, lists, now.constants, kernel_type(now.constants), pull,
        (now.material.density, time, settings.full if settings.free_surface else 0.0),
        gradient, resting, slant, compact, summed, held, diagonal,
    )  # fmt: skip
    root, sign = mirrored(now, workspace)
    liquid = root < count
    root = np.where(liquid, root, 0)
    volume = workspace.fields.volume[:count].astype(np.float64)
    return System(
        gradient, closing, compact, summed, slant, resting, held, diagonal, volume,
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


@summing
def sum_gradients(
    closing: Array, fields: Floats, lists: Lists, constants: Constants, kernel: KernelType, pull: Array,
    numbers: tuple[float, float, float], gradient: Array, resting: Array, slant: Array, compact: Array,
    summed: Array, held: Array, diagonal: Array,
) -> None:  # fmt: skip
    """Fill g_ij and F_ij, T_i, D_i, the sums of kernels, the acceleration where pressures are zero, the diagonal of A.

    `pull` is gravity, then the center and the rate of the central force; `numbers` are the density, the time, and the
    least D, dummies included.
    """
    code, dimension = constants[0].kernel, INDEX(closing.shape[0])
    inverse, scale = constants[0].inverse_length, constants[0].slope_factor
    factor = scale / (inverse * inverse)  # of the kernel
    density, time, full = numbers
    rate = pull[2 * dimension] * pull[2 * dimension]
    zero, one, lighter, deep = 0.0, 1.0, 1.0 / density, closing.shape[0] == 3
    counts, neighbor = lists
    for particle in prange(closing.shape[1]):
        i = INDEX(particle)
        count = INDEX(counts[i])
        for k in range(whole(counts[i])):
            gradient[dimension, i, k] = 0.0
        for axis in range(dimension):
            x = fields[FIELD.position + axis, i]
            for k in range(whole(counts[i])):
                along = fields[FIELD.position + axis, INDEX(neighbor[i, k])] - x
                gradient[axis, i, k] = along
                gradient[dimension, i, k] += along * along
        own = fields[FIELD.volume, i]
        total = own * value_of(zero * inverse, code)
        for k in range(count):
            value = value_of(math.sqrt(gradient[dimension, i, k]) * inverse, code)
            total += fields[FIELD.volume, INDEX(neighbor[i, k])] * value
        squares, near, behind, rest = zero, zero, zero, zero
        tx, ty, tz, sx, sy, sz, rx, ry, rz = zero, zero, zero, zero, zero, zero, zero, zero, zero
        for k in range(count):
            j, square = INDEX(neighbor[i, k]), gradient[dimension, i, k]
            volume, liquid = fields[FIELD.volume, j], fields[FIELD.liquid, j]
            slope = scale * written_slope(math.sqrt(square) * inverse, kernel)
            counted, dummy = volume * slope, one - liquid
            dx, dy, dz = gradient[0, i, k], gradient[1, i, k], zero
            rise = (pull[0] - rate * (fields[FIELD.position, j] - pull[dimension])) * dx
            rise += (pull[1] - rate * (fields[FIELD.position + 1, j] - pull[dimension + 1])) * dy
            if deep:
                dz = gradient[2, i, k]
                rise += (pull[2] - rate * (fields[FIELD.position + 2, j] - pull[dimension + 2])) * dz
                gradient[2, i, k] = slope * dz
            gradient[0, i, k] = slope * dx
            gradient[1, i, k] = slope * dy
            gradient[dimension, i, k] = slope
            push = counted * (liquid * fields[FIELD.pressure, j] * lighter + dummy * rise)
            twice = counted * (one + dummy)
            tx, ty, tz = tx + twice * dx, ty + twice * dy, tz + twice * dz
            sx, sy, sz = sx + counted * dx, sy + counted * dy, sz + counted * dz
            rx, ry, rz = rx + push * dx, ry + push * dy, rz + push * dz
            squares += liquid * counted * slope * square
            near -= liquid * counted
            behind -= dummy * counted
            rest += push
        closing[0, i], closing[1, i] = tx, ty
        resting[0, i], resting[1, i] = rx, ry
        if deep:
            closing[2, i], resting[2, i] = tz, rz
        closed, steep = tx * tx + ty * ty + tz * tz, sx * sx + sy * sy + sz * sz
        slant[i] = math.sqrt(steep)
        held[i] = rest + rest
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
    dimension, deep = INDEX(closing.shape[0]), closing.shape[0] == 3
    for particle in prange(closing.shape[1]):
        i = INDEX(particle)
        ax, ay, az, laplacian = 0.0, 0.0, 0.0, 0.0
        for k in range(whole(counts[i])):
            other = carried[INDEX(neighbor[i, k])]
            ax += gradient[0, i, k] * other
            ay += gradient[1, i, k] * other
            laplacian += gradient[dimension, i, k] * other
            if deep:
                az += gradient[2, i, k] * other
        own = pressure[i]
        found[0, i] = (ax + own * closing[0, i]) / density
        found[1, i] = (ay + own * closing[1, i]) / density
        if deep:
            found[2, i] = (az + own * closing[2, i]) / density
        found[dimension, i] = 2.0 * (laplacian + own * compact[i]) / density


@summing
def sum_compression(
    found: Array, gradient: Array, closing: Array, velocity: Array, carried: Array, lists: Lists
) -> None:
    """Sum the compressions c_i = sum_j V_j g_ij.v_j - T_i.v_i."""
    counts, neighbor = lists
    deep = closing.shape[0] == 3
    for particle in prange(len(found)):
        i, total = INDEX(particle), 0.0
        for k in range(whole(counts[i])):
            j = INDEX(neighbor[i, k])
            total += gradient[0, i, k] * carried[0, j] + gradient[1, i, k] * carried[1, j]
            if deep:
                total += gradient[2, i, k] * carried[2, j]
        own = closing[0, i] * velocity[0, i] + closing[1, i] * velocity[1, i]
        if deep:
            own += closing[2, i] * velocity[2, i]
        found[i] = total - own
