"""The sums over neighbors that move the liquid: continuity with density diffusion, and pressure with damping.

Each particle's sum is one loop over its row of neighbors with nothing stored inside, so that it is done eight pairs at
a time; all that a pair needs is gathered at its top. Each loop is written once and compiled for 2D and 3D, and for
each kernel type of `weights`. Sums may be taken in any order inside a row, always the same one; a NaN stays a NaN.

Signs: `displacement` is from i to j, F = (1/r) dW/dr is negative, and the gradient of W at i is -F displacement.
"""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import admit, compiled_inside, inlined, prange, summed_inside, summing
from ecume.engine.neighbor_rows import STRIDE, Lists
from ecume.laws import diffusion, viscous
from ecume.laws.kernels import shapes
from ecume.models.sph.fields import FIELD, RATE, Constants, Floats
from ecume.models.sph.kernels import KernelType, written_slope

admit(shapes, viscous, diffusion)
INDEX = np.uint64
"""Of all indexes: a signed one would be tested for being negative, pair by pair."""
BEFORE, DOWN = INDEX(STRIDE - 1), INDEX(2**64 - STRIDE)


@compiled_inside
def whole(count: int) -> np.uint64:
    """How long a row is up to a whole vector: the rest is the particle itself, and adds nothing."""
    return (INDEX(count) + BEFORE) & DOWN


@inlined
def _continuity(
    deep: bool, fields: Floats, lists: Lists, constants: Constants,
    kernel: KernelType, diffusing: Floats, rates: Floats,
) -> None:  # fmt: skip
    """Continuity, and the diffusion of s, which is density or enthalpy, beyond g.x_ij by which s changes along x when
    the liquid is at rest (Antuono et al. 2010, Fourtakas et al. 2019; see `ecume.laws.diffusion`). Dummies do not take
    part in that.
    """
    counts, neighbor = lists
    for particle in prange(constants[0].first, min(constants[0].last, rates.shape[1])):
        i, numbers = INDEX(particle), constants[0]
        x, y, z = fields[FIELD.position, i], fields[FIELD.position + 1, i], fields[FIELD.position + 2, i]
        u, v, w = fields[FIELD.velocity, i], fields[FIELD.velocity + 1, i], fields[FIELD.velocity + 2, i]
        own = diffusing[i]
        inverse, zero = numbers.inverse_length, numbers.zero
        gx, gy, gz = numbers.rise_x, numbers.rise_y, numbers.rise_z
        stretching, flow = zero, zero
        for k in range(whole(counts[i])):
            j = INDEX(neighbor[i, k])
            dx, dy = fields[FIELD.position, j] - x, fields[FIELD.position + 1, j] - y
            du, dv = fields[FIELD.velocity, j] - u, fields[FIELD.velocity + 1, j] - v
            weight, liquid, other = fields[FIELD.weight, j], fields[FIELD.liquid, j], diffusing[j]
            square, radial, rise = dx * dx + dy * dy, du * dx + dv * dy, gx * dx + gy * dy
            if deep:
                dz, dw = fields[FIELD.position + 2, j] - z, fields[FIELD.velocity + 2, j] - w
                square, radial, rise = square + dz * dz, radial + dw * dz, rise + gz * dz
            pull = written_slope(math.sqrt(square) * inverse, kernel) * weight
            stretching += stretched(pull, radial)
            flow += diffusion.flow(diffusion.beyond_rest(own, other, rise), pull) * liquid
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
def stretched(pull: float, radial: float) -> float:
    """A pair's part of -div v: w_j F (v_j - v_i).x_ij (Monaghan 1994)."""
    return pull * radial


@summed_inside
def pushed(pull: float, own: float, push: float, damp: float) -> float:
    """A pair's force over x_ij: w_j F (P_i + P_j + damping); see `PUSH` and `WEIGHT`."""
    return pull * (own + push + damp)


@inlined
def _momentum(
    deep: bool, fields: Floats, lists: Lists, constants: Constants,
    kernel: KernelType, rates: Floats,
) -> None:  # fmt: skip
    """Pressure and damping; dummies do not damp."""
    counts, neighbor = lists
    for particle in prange(constants[0].first, min(constants[0].last, rates.shape[1])):
        i, numbers = INDEX(particle), constants[0]
        x, y, z = fields[FIELD.position, i], fields[FIELD.position + 1, i], fields[FIELD.position + 2, i]
        u, v, w = fields[FIELD.velocity, i], fields[FIELD.velocity + 1, i], fields[FIELD.velocity + 2, i]
        own = fields[FIELD.force_term, i]
        inverse, zero = numbers.inverse_length, numbers.zero
        damper = numbers.smoothing_length, numbers.damping_divisor, numbers.sound_speed, numbers.alpha
        ax, ay, az = zero, zero, zero
        for k in range(whole(counts[i])):
            j = INDEX(neighbor[i, k])
            dx, dy = fields[FIELD.position, j] - x, fields[FIELD.position + 1, j] - y
            du, dv = fields[FIELD.velocity, j] - u, fields[FIELD.velocity + 1, j] - v
            weight, liquid, push = fields[FIELD.weight, j], fields[FIELD.liquid, j], fields[FIELD.force_term, j]
            square, radial, dz = dx * dx + dy * dy, du * dx + dv * dy, zero
            if deep:
                dz = fields[FIELD.position + 2, j] - z
                square, radial = square + dz * dz, radial + (fields[FIELD.velocity + 2, j] - w) * dz
            pull = written_slope(math.sqrt(square) * inverse, kernel) * weight
            pull = pushed(pull, own, push, liquid * damping(radial, square, damper))
            ax += pull * dx
            ay += pull * dy
            if deep:
                az += pull * dz
        rates[RATE.acceleration, i] = numbers.slope_factor * ax
        rates[RATE.acceleration + 1, i] = numbers.slope_factor * ay
        rates[RATE.acceleration + 2, i] = numbers.slope_factor * az


@inlined
def _both(
    deep: bool, fields: Floats, lists: Lists, constants: Constants,
    kernel: KernelType, rates: Floats,
) -> None:  # fmt: skip
    """Both at once, without diffusion and dummies: each field is gathered once."""
    counts, neighbor = lists
    for particle in prange(constants[0].first, min(constants[0].last, rates.shape[1])):
        i, numbers = INDEX(particle), constants[0]
        x, y, z = fields[FIELD.position, i], fields[FIELD.position + 1, i], fields[FIELD.position + 2, i]
        u, v, w = fields[FIELD.velocity, i], fields[FIELD.velocity + 1, i], fields[FIELD.velocity + 2, i]
        own = fields[FIELD.force_term, i]
        inverse, zero = numbers.inverse_length, numbers.zero
        damper = numbers.smoothing_length, numbers.damping_divisor, numbers.sound_speed, numbers.alpha
        stretching, ax, ay, az = zero, zero, zero, zero
        for k in range(whole(counts[i])):
            j = INDEX(neighbor[i, k])
            dx, dy = fields[FIELD.position, j] - x, fields[FIELD.position + 1, j] - y
            du, dv = fields[FIELD.velocity, j] - u, fields[FIELD.velocity + 1, j] - v
            weight, push = fields[FIELD.weight, j], fields[FIELD.force_term, j]
            square, radial, dz = dx * dx + dy * dy, du * dx + dv * dy, zero
            if deep:
                dz = fields[FIELD.position + 2, j] - z
                square, radial = square + dz * dz, radial + (fields[FIELD.velocity + 2, j] - w) * dz
            pull = written_slope(math.sqrt(square) * inverse, kernel) * weight
            stretching += stretched(pull, radial)
            pull = pushed(pull, own, push, damping(radial, square, damper))
            ax += pull * dx
            ay += pull * dy
            if deep:
                az += pull * dz
        rates[RATE.continuity, i] = numbers.slope_factor * stretching
        rates[RATE.diffusion, i] = zero
        rates[RATE.acceleration, i] = numbers.slope_factor * ax
        rates[RATE.acceleration + 1, i] = numbers.slope_factor * ay
        rates[RATE.acceleration + 2, i] = numbers.slope_factor * az


@summing
def sum_continuity(
    fields: Floats, lists: Lists, constants: Constants, kernel: KernelType,
    diffusing: Floats, rates: Floats,
) -> None:  # fmt: skip
    """Continuity and diffusion: see `_continuity`."""
    if constants[0].dimension == 3:
        _continuity(True, fields, lists, constants, kernel, diffusing, rates)
    else:
        _continuity(False, fields, lists, constants, kernel, diffusing, rates)


@summing
def sum_momentum(
    fields: Floats, lists: Lists, constants: Constants, kernel: KernelType,
    rates: Floats,
) -> None:  # fmt: skip
    """Pressure and damping: see `_momentum`."""
    if constants[0].dimension == 3:
        _momentum(True, fields, lists, constants, kernel, rates)
    else:
        _momentum(False, fields, lists, constants, kernel, rates)


@summing
def sum_both(
    fields: Floats, lists: Lists, constants: Constants, kernel: KernelType,
    rates: Floats,
) -> None:  # fmt: skip
    """Both in one sum: see `_both`."""
    if constants[0].dimension == 3:
        _both(True, fields, lists, constants, kernel, rates)
    else:
        _both(False, fields, lists, constants, kernel, rates)
