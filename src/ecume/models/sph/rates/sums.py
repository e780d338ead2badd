"""Sums over neighbors that move the liquid: continuity with density diffusion, pressure with artificial viscosity, and
in scenes that select them the viscous force and the pressure force with transport velocity.

Each particle's sum is one loop over its row of neighbors without a store inside, so that the compiler vectorizes it
over eight pairs; all that a pair needs is gathered at its top. Continuity and pressure are written once and compiled
for 2D and 3D, and for each kernel type of `kernels`. The order of summation inside a row is not specified, but it is
the same in every run. NaN propagates.

Signs: `displacement` is from i to j, F = (1/r) dW/dr is negative, and the gradient of W at i is -F displacement.

The kernels in compiled loops, by their numbers in `ecume.laws.kernels.KERNEL_CODES`.

`slope_of(q, kernel)` is f'(q)/q and `value_of(q, kernel)` is f(q). Both are made from the table `KERNELS`, one branch
for each row, so that no kernel can be missing. They do not test for numbers that no kernel has: `require_kernel` does,
before any loop runs.

`written_slope(q, kernel)` is for loops that are compiled once for each kernel in `WRITTEN`, whose formula then stands
in the loop, and once for all others. The type of `kernel` says which: see `kernel_type`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ecume._columns import RECORD, fill_columns
from ecume._jit import admit, by_type, compiled_inside, inlined, prange, selection, spread, summed_inside, summing
from ecume.engine.neighbor_rows import STRIDE, Lists
from ecume.laws import diffusion, kernels, viscous
from ecume.laws.kernels import KERNEL_CODES, KERNELS, Shape
from ecume.models.sph.fields import FIELD, RATE, Constants, Floats, number
from ecume.units import Array

admit(kernels)

slope_of = selection("slope_of", {KERNEL_CODES[name]: form.slope for name, form in KERNELS.items()}, __name__, __file__)
value_of = selection("value_of", {KERNEL_CODES[name]: form.value for name, form in KERNELS.items()}, __name__, __file__)


class AnyKernel(NamedTuple):
    """A kernel whose formula a loop looks up by its number."""

    code: int


class WendlandC2(NamedTuple):
    """The default."""

    code: int


class CubicSpline(NamedTuple):
    """The second most in use."""

    code: int


KernelType = AnyKernel | WendlandC2 | CubicSpline


@summed_inside
def any_slope(q: float, kernel: AnyKernel) -> float:
    """Slope of the kernel with this number."""
    found: float = slope_of(q, kernel.code)
    return found


@summed_inside
def wendland_slope(q: float, kernel: WendlandC2) -> float:
    """Slope of Wendland's C2."""
    return kernels.wendland_c2_slope(q)


@summed_inside
def cubic_slope(q: float, kernel: CubicSpline) -> float:
    """Slope of the cubic spline."""
    return kernels.cubic_spline_slope(q)


SLOPES: dict[type, Callable[..., float]] = {
    AnyKernel: any_slope, WendlandC2: wendland_slope, CubicSpline: cubic_slope,
}  # fmt: skip
written_slope = by_type(SLOPES.__getitem__)
WRITTEN: dict[Shape, type[KernelType]] = {
    kernels.wendland_c2_slope: WendlandC2,
    kernels.cubic_spline_slope: CubicSpline,
}
KERNEL_TYPES = {KERNEL_CODES[name]: WRITTEN.get(form.slope, AnyKernel) for name, form in KERNELS.items()}


def kernel_type(constants: Constants) -> KernelType:
    """The kernel as a type that `written_slope` dispatches on; KeyError for an unknown kernel."""
    code = int(number(constants, "kernel"))
    return KERNEL_TYPES[code](code)


def require_kernel(constants: Constants) -> None:
    """Raise ValueError for a number that no kernel has."""
    code = int(number(constants, "kernel"))
    if code not in KERNEL_TYPES:
        raise ValueError(f"kernel: got {code}; expected a number of KERNEL_CODES, {KERNEL_CODES}")


admit(kernels, viscous, diffusion)
INDEX = np.uint64
"""Of all indexes: a signed one would be tested for being negative, pair by pair."""
BEFORE, DOWN = INDEX(STRIDE - 1), INDEX(2**64 - STRIDE)


@compiled_inside
def whole(count: int) -> np.uint64:
    """The length of a row rounded up to a whole vector: padding is the particle itself, and adds nothing."""
    return (INDEX(count) + BEFORE) & DOWN


CHUNK = 128
"""Particles that one thread takes at a time, with one set of columns."""
SPARE = 8
"""Entries between two columns, so that they do not all fall into the same lines of the cache."""


class Column(NamedTuple):
    """The numbers of a particle's record that continuity and pressure read."""

    position: int = 0
    velocity: int = 3
    weight: int = 6
    """what a neighbor counts, negative for dummies"""
    value: int = 7
    """what diffuses, or what the pressure force adds up of two particles"""


COLUMN = Column()


@spread
def fill_records(fields: Floats, records: Floats, value: Floats) -> None:
    """Fill the records (N, 8) of all particles, as `Column` names them, with this field as their last number."""
    for i in prange(fields.shape[1]):
        for axis in range(3):
            records[i, COLUMN.position + axis] = fields[FIELD.position + axis, i]
            records[i, COLUMN.velocity + axis] = fields[FIELD.velocity + axis, i]
        weight = fields[FIELD.weight, i]
        records[i, COLUMN.weight] = weight if fields[FIELD.liquid, i] > 0.0 else -weight
        records[i, COLUMN.value] = value[i]


@inlined
def _continuity(
    deep: bool, rates: Floats, records: Floats, lists: Lists, constants: Constants, kernel: KernelType
) -> None:
    """Continuity, and the diffusion of s, which is density or enthalpy, beyond g.x_ij by which s changes along x when
    the liquid is at rest (Antuono et al. 2010, Fourtakas et al. 2019; see `ecume.laws.diffusion`). Dummies do not take
    part in that.
    """
    counts, neighbor = lists
    begin, end = constants[0].first, min(constants[0].last, rates.shape[1])
    for chunk in prange((end - begin + CHUNK - 1) // CHUNK):
        columns, numbers = np.empty((RECORD, neighbor.shape[1] + SPARE), records.dtype), constants[0]
        inverse, zero = numbers.inverse_length, numbers.zero
        gx, gy, gz = numbers.rise_x, numbers.rise_y, numbers.rise_z
        for particle in range(begin + chunk * CHUNK, min(end, begin + (chunk + 1) * CHUNK)):
            i = INDEX(particle)
            count = whole(counts[i])
            fill_columns(columns, records, neighbor, i, count)
            x, y, z = records[i, COLUMN.position], records[i, COLUMN.position + 1], records[i, COLUMN.position + 2]
            u, v, w = records[i, COLUMN.velocity], records[i, COLUMN.velocity + 1], records[i, COLUMN.velocity + 2]
            own = records[i, COLUMN.value]
            stretching, flow = zero, zero
            for k in range(count):
                dx, dy = columns[COLUMN.position, k] - x, columns[COLUMN.position + 1, k] - y
                du, dv = columns[COLUMN.velocity, k] - u, columns[COLUMN.velocity + 1, k] - v
                signed, other = columns[COLUMN.weight, k], columns[COLUMN.value, k]
                square, radial, rise = dx * dx + dy * dy, du * dx + dv * dy, gx * dx + gy * dy
                if deep:
                    dz, dw = columns[COLUMN.position + 2, k] - z, columns[COLUMN.velocity + 2, k] - w
                    square, radial, rise = square + dz * dz, radial + dw * dz, rise + gz * dz
                slope = written_slope(math.sqrt(square) * inverse, kernel)
                stretching += pair_divergence(slope * math.fabs(signed), radial)
                flow += diffusion.flow(diffusion.beyond_rest(own, other, rise), slope * max(signed, zero))
            rates[RATE.continuity, i] = numbers.slope_factor * stretching
            rates[RATE.diffusion, i] = numbers.slope_factor * numbers.delta * flow


@summed_inside
def damping(approach: float, square: float, damper: tuple[float, float, float, float]) -> float:
    """Artificial viscosity with the liquid's own density and sound speed for both of a pair, as delta-SPH has it
    (Antuono et al. 2012); positive for two that approach. `damper` is (h, divisor, sound
    speed, alpha), see `Numbers`.
    """
    h, share, sound, alpha = damper
    return viscous.artificial_viscosity(viscous.approach_speed(approach, square, h), share, sound, alpha)


@summed_inside
def pair_divergence(pull: float, radial: float) -> float:
    """A pair's part of -div v: w_j F (v_j - v_i).x_ij (Monaghan 1994)."""
    return pull * radial


@summed_inside
def pair_force(pull: float, own: float, push: float, damp: float) -> float:
    """A pair's force over x_ij: w_j F (P_i + P_j + damping); see `Fields.force_term` and `Fields.weight`."""
    return pull * (own + push + damp)


@inlined
def _momentum(
    deep: bool, both: bool, rates: Floats, records: Floats, lists: Lists, constants: Constants, kernel: KernelType
) -> None:
    """Pressure and artificial viscosity, in which dummies take no part; with `both`, also continuity, in one pass, for
    tanks without diffusion and dummies. `deep` and `both` are literals: the compiler drops the other branches.
    """
    counts, neighbor = lists
    begin, end = constants[0].first, min(constants[0].last, rates.shape[1])
    for chunk in prange((end - begin + CHUNK - 1) // CHUNK):
        columns, numbers = np.empty((RECORD, neighbor.shape[1] + SPARE), records.dtype), constants[0]
        inverse, zero = numbers.inverse_length, numbers.zero
        damper = numbers.smoothing_length, numbers.damping_divisor, numbers.sound_speed, numbers.alpha
        for particle in range(begin + chunk * CHUNK, min(end, begin + (chunk + 1) * CHUNK)):
            i = INDEX(particle)
            count = whole(counts[i])
            fill_columns(columns, records, neighbor, i, count)
            x, y, z = records[i, COLUMN.position], records[i, COLUMN.position + 1], records[i, COLUMN.position + 2]
            u, v, w = records[i, COLUMN.velocity], records[i, COLUMN.velocity + 1], records[i, COLUMN.velocity + 2]
            own = records[i, COLUMN.value]
            stretching, ax, ay, az = zero, zero, zero, zero
            for k in range(count):
                dx, dy = columns[COLUMN.position, k] - x, columns[COLUMN.position + 1, k] - y
                du, dv = columns[COLUMN.velocity, k] - u, columns[COLUMN.velocity + 1, k] - v
                signed, other = columns[COLUMN.weight, k], columns[COLUMN.value, k]
                square, radial, dz = dx * dx + dy * dy, du * dx + dv * dy, zero
                if deep:
                    dz = columns[COLUMN.position + 2, k] - z
                    square, radial = square + dz * dz, radial + (columns[COLUMN.velocity + 2, k] - w) * dz
                slope = written_slope(math.sqrt(square) * inverse, kernel)
                damp = damping(radial, square, damper)
                pull = slope * math.fabs(signed)
                if both:
                    stretching += pair_divergence(pull, radial)
                    pull = pair_force(pull, own, other, damp)
                else:
                    pull = pair_force(pull, own, other, damp if signed > zero else zero)
                ax += pull * dx
                ay += pull * dy
                if deep:
                    az += pull * dz
            if both:
                rates[RATE.continuity, i] = numbers.slope_factor * stretching
                rates[RATE.diffusion, i] = zero
            rates[RATE.acceleration, i] = numbers.slope_factor * ax
            rates[RATE.acceleration + 1, i] = numbers.slope_factor * ay
            rates[RATE.acceleration + 2, i] = numbers.slope_factor * az


@summing
def sum_continuity(rates: Floats, records: Floats, lists: Lists, constants: Constants, kernel: KernelType) -> None:
    """Continuity and diffusion: see `_continuity`."""
    if constants[0].dimension == 3:
        _continuity(True, rates, records, lists, constants, kernel)
    else:
        _continuity(False, rates, records, lists, constants, kernel)


@summing
def sum_momentum(rates: Floats, records: Floats, lists: Lists, constants: Constants, kernel: KernelType) -> None:
    """Pressure and artificial viscosity: see `_momentum`."""
    if constants[0].dimension == 3:
        _momentum(True, False, rates, records, lists, constants, kernel)
    else:
        _momentum(False, False, rates, records, lists, constants, kernel)


@summing
def sum_both(rates: Floats, records: Floats, lists: Lists, constants: Constants, kernel: KernelType) -> None:
    """Continuity and momentum in one sum: see `_momentum`."""
    if constants[0].dimension == 3:
        _momentum(True, True, rates, records, lists, constants, kernel)
    else:
        _momentum(False, True, rates, records, lists, constants, kernel)


@summing
def sum_friction(fields: Floats, lists: Lists, constants: Constants, rates: Floats) -> None:
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
def sum_radial_friction(fields: Floats, lists: Lists, constants: Constants, rates: Floats) -> None:
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
            # No two particles are so near, but a particle may be to its image.
            drag *= radial / max(square, soft)
            ax += drag * dx
            ay += drag * dy
            az += drag * dz
        share = factor * own / fields[FIELD.density, i]
        rates[RATE.acceleration, i] += share * ax
        rates[RATE.acceleration + 1, i] += share * ay
        rates[RATE.acceleration + 2, i] += share * az


@summing
def sum_transported_pressure(fields: Floats, lists: Lists, constants: Constants, rates: Floats) -> None:
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


@spread
def store_thickening(thickening: Array, rates: Floats, density: Array, by_mass: bool) -> None:
    """D rho/dt: the sum is per density where neighbors count by their volumes."""
    for i in prange(len(density)):
        share = 1.0 if by_mass else density[i]
        thickening[i] = share * rates[RATE.continuity, i] + rates[RATE.diffusion, i]


@spread
def store_acceleration(acceleration: Array, rates: Floats, density: Array, pull: Array, per_volume: bool) -> None:
    """A = what neighbors do, and gravity."""
    for i in prange(acceleration.shape[1]):
        share = 1.0 / density[i] if per_volume else 1.0
        for axis in range(acceleration.shape[0]):
            acceleration[axis, i] = share * rates[RATE.acceleration + axis, i] + pull[axis]
