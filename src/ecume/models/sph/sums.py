"""The sums over neighbors that move the liquid: continuity with density diffusion, and pressure with damping.

Each particle's sum is one loop over its row of neighbors with nothing stored inside, so that it is done eight pairs at
a time; all that a pair needs is gathered at its top. The loop is written once for all kernels and dimensions, and
closed below by name for the two kernels most in use; the others share a blend. Sums may be taken in any order inside a
row, always the same one; a NaN stays a NaN.

Signs: `displacement` is from i to j, F = (1/r) dW/dr is negative, and the gradient of W at i is -F displacement.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import admit, compiled_inside, inlined, prange, summed_inside, summing
from ecume.engine.neighbor_rows import STRIDE
from ecume.laws import diffusion, viscous
from ecume.laws.kernels import KERNEL_CODES, KERNELS, Shape, shapes
from ecume.models.sph.fields import (
    ACC,
    ALPHA,
    DELTA,
    DIFFUSED,
    DIMENSION,
    DRHO,
    FIRST,
    G0,
    INVERSE,
    KERNEL,
    LAST,
    LIQUID,
    PUSH,
    SCALE,
    SHARE,
    SOUND,
    WEIGHT,
    ZERO,
    H,
    V,
    X,
)
from ecume.models.sph.weights import slope_of

admit(shapes, viscous, diffusion)
INDEX = np.uint64
"""Of all indexes: a signed one would be tested for being negative, pair by pair."""
BEFORE, DOWN = INDEX(STRIDE - 1), INDEX(2**64 - STRIDE)


@compiled_inside
def whole(count: Any) -> Any:
    """How long a row is up to a whole vector: the rest is the particle itself, and adds nothing."""
    return (INDEX(count) + BEFORE) & DOWN


@inlined
def stretch_with(
    slope: Any, choices: Any, deep: bool, fields: Any, count: Any, neighbor: Any, numbers: Any, soft: int, rates: Any
) -> None:
    """Continuity, and the diffusion of s, which is density or enthalpy, beyond g.x_ij by which s changes along x when
    the liquid is at rest (Antuono et al. 2010, Fourtakas et al. 2019; see `ecume.laws.diffusion`). Dummies do not take
    part in that.
    """
    kernel = choices[KERNEL]
    for particle in prange(choices[FIRST], min(choices[LAST], rates.shape[1])):
        i = INDEX(particle)
        x, y, z = fields[X, i], fields[X + 1, i], fields[X + 2, i]
        u, v, w = fields[V, i], fields[V + 1, i], fields[V + 2, i]
        own = fields[soft, i]
        inverse, zero = numbers[INVERSE], numbers[ZERO]
        gx, gy, gz = numbers[G0], numbers[G0 + 1], numbers[G0 + 2]
        stretching, diffusing = zero, zero
        for k in range(whole(count[i])):
            j = INDEX(neighbor[i, k])
            dx, dy = fields[X, j] - x, fields[X + 1, j] - y
            du, dv = fields[V, j] - u, fields[V + 1, j] - v
            weight, liquid, other = fields[WEIGHT, j], fields[LIQUID, j], fields[soft, j]
            square, radial, rise = dx * dx + dy * dy, du * dx + dv * dy, gx * dx + gy * dy
            if deep:
                dz, dw = fields[X + 2, j] - z, fields[V + 2, j] - w
                square, radial, rise = square + dz * dz, radial + dw * dz, rise + gz * dz
            pull = slope(math.sqrt(square) * inverse, kernel) * weight
            stretching += stretched(pull, radial)
            diffusing += diffusion.flow(diffusion.beyond_rest(own, other, rise), pull) * liquid
        rates[DRHO, i] = numbers[SCALE] * stretching
        rates[DIFFUSED, i] = numbers[SCALE] * numbers[DELTA] * diffusing


@summed_inside
def damping(approach: Any, square: Any, damper: Any) -> Any:
    """Artificial viscosity with the liquid's own density and sound speed for both of a pair, as delta-SPH has it
    (Antuono et al. 2012); positive for two that approach. `damper` is numbers H, SHARE, SOUND, ALPHA.
    """
    h, share, sound, alpha = damper
    return viscous.artificial_viscosity(viscous.approach_speed(approach, square, h), share, sound, alpha)


@summed_inside
def stretched(pull: Any, radial: Any) -> Any:
    """A pair's part of -div v: w_j F (v_j - v_i).x_ij (Monaghan 1994)."""
    return pull * radial


@summed_inside
def pushed(pull: Any, own: Any, push: Any, damp: Any) -> Any:
    """A pair's force over x_ij: w_j F (P_i + P_j + damping); see `PUSH` and `WEIGHT`."""
    return pull * (own + push + damp)


@inlined
def push_with(
    slope: Any, choices: Any, deep: bool, fields: Any, count: Any, neighbor: Any, numbers: Any, rates: Any
) -> None:
    """Pressure and damping; dummies do not damp."""
    kernel = choices[KERNEL]
    for particle in prange(choices[FIRST], min(choices[LAST], rates.shape[1])):
        i = INDEX(particle)
        x, y, z = fields[X, i], fields[X + 1, i], fields[X + 2, i]
        u, v, w = fields[V, i], fields[V + 1, i], fields[V + 2, i]
        own = fields[PUSH, i]
        inverse, zero = numbers[INVERSE], numbers[ZERO]
        damper = numbers[H], numbers[SHARE], numbers[SOUND], numbers[ALPHA]
        ax, ay, az = zero, zero, zero
        for k in range(whole(count[i])):
            j = INDEX(neighbor[i, k])
            dx, dy = fields[X, j] - x, fields[X + 1, j] - y
            du, dv = fields[V, j] - u, fields[V + 1, j] - v
            weight, liquid, push = fields[WEIGHT, j], fields[LIQUID, j], fields[PUSH, j]
            square, radial, dz = dx * dx + dy * dy, du * dx + dv * dy, zero
            if deep:
                dz = fields[X + 2, j] - z
                square, radial = square + dz * dz, radial + (fields[V + 2, j] - w) * dz
            pull = slope(math.sqrt(square) * inverse, kernel) * weight
            pull = pushed(pull, own, push, liquid * damping(radial, square, damper))
            ax += pull * dx
            ay += pull * dy
            if deep:
                az += pull * dz
        rates[ACC, i] = numbers[SCALE] * ax
        rates[ACC + 1, i] = numbers[SCALE] * ay
        rates[ACC + 2, i] = numbers[SCALE] * az


@inlined
def stretch_and_push_with(
    slope: Any, choices: Any, deep: bool, fields: Any, count: Any, neighbor: Any, numbers: Any, rates: Any
) -> None:
    """Both at once, without diffusion and dummies: each field is gathered once."""
    kernel = choices[KERNEL]
    for particle in prange(choices[FIRST], min(choices[LAST], rates.shape[1])):
        i = INDEX(particle)
        x, y, z = fields[X, i], fields[X + 1, i], fields[X + 2, i]
        u, v, w = fields[V, i], fields[V + 1, i], fields[V + 2, i]
        own = fields[PUSH, i]
        inverse, zero = numbers[INVERSE], numbers[ZERO]
        damper = numbers[H], numbers[SHARE], numbers[SOUND], numbers[ALPHA]
        stretching, ax, ay, az = zero, zero, zero, zero
        for k in range(whole(count[i])):
            j = INDEX(neighbor[i, k])
            dx, dy = fields[X, j] - x, fields[X + 1, j] - y
            du, dv = fields[V, j] - u, fields[V + 1, j] - v
            weight, push = fields[WEIGHT, j], fields[PUSH, j]
            square, radial, dz = dx * dx + dy * dy, du * dx + dv * dy, zero
            if deep:
                dz = fields[X + 2, j] - z
                square, radial = square + dz * dz, radial + (fields[V + 2, j] - w) * dz
            pull = slope(math.sqrt(square) * inverse, kernel) * weight
            stretching += stretched(pull, radial)
            pull = pushed(pull, own, push, damping(radial, square, damper))
            ax += pull * dx
            ay += pull * dy
            if deep:
                az += pull * dz
        rates[DRHO, i] = numbers[SCALE] * stretching
        rates[DIFFUSED, i] = zero
        rates[ACC, i] = numbers[SCALE] * ax
        rates[ACC + 1, i] = numbers[SCALE] * ay
        rates[ACC + 2, i] = numbers[SCALE] * az


@summed_inside
def wendland(q: Any, kernel: int) -> Any:
    """The kernel most in use."""
    return shapes.wendland_c2_slope(q)


@summed_inside
def cubic(q: Any, kernel: int) -> Any:
    """The second."""
    return shapes.cubic_spline_slope(q)


@summing
def stretch_wendland(fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, soft: int, rates: Any) -> None:
    """`stretch_with` Wendland's C2."""
    if choices[DIMENSION] == 3:
        stretch_with(wendland, choices, True, fields, count, neighbor, numbers, soft, rates)
    else:
        stretch_with(wendland, choices, False, fields, count, neighbor, numbers, soft, rates)


@summing
def stretch_cubic(fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, soft: int, rates: Any) -> None:
    """`stretch_with` the cubic spline."""
    if choices[DIMENSION] == 3:
        stretch_with(cubic, choices, True, fields, count, neighbor, numbers, soft, rates)
    else:
        stretch_with(cubic, choices, False, fields, count, neighbor, numbers, soft, rates)


@summing
def stretch_any(fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, soft: int, rates: Any) -> None:
    """`stretch_with` any kernel."""
    if choices[DIMENSION] == 3:
        stretch_with(slope_of, choices, True, fields, count, neighbor, numbers, soft, rates)
    else:
        stretch_with(slope_of, choices, False, fields, count, neighbor, numbers, soft, rates)


@summing
def push_wendland(fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, rates: Any) -> None:
    """`push_with` Wendland's C2."""
    if choices[DIMENSION] == 3:
        push_with(wendland, choices, True, fields, count, neighbor, numbers, rates)
    else:
        push_with(wendland, choices, False, fields, count, neighbor, numbers, rates)


@summing
def push_cubic(fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, rates: Any) -> None:
    """`push_with` the cubic spline."""
    if choices[DIMENSION] == 3:
        push_with(cubic, choices, True, fields, count, neighbor, numbers, rates)
    else:
        push_with(cubic, choices, False, fields, count, neighbor, numbers, rates)


@summing
def push_any(fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, rates: Any) -> None:
    """`push_with` any kernel."""
    if choices[DIMENSION] == 3:
        push_with(slope_of, choices, True, fields, count, neighbor, numbers, rates)
    else:
        push_with(slope_of, choices, False, fields, count, neighbor, numbers, rates)


@summing
def both_wendland(fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, rates: Any) -> None:
    """`stretch_and_push_with` Wendland's C2."""
    if choices[DIMENSION] == 3:
        stretch_and_push_with(wendland, choices, True, fields, count, neighbor, numbers, rates)
    else:
        stretch_and_push_with(wendland, choices, False, fields, count, neighbor, numbers, rates)


@summing
def both_cubic(fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, rates: Any) -> None:
    """`stretch_and_push_with` the cubic spline."""
    if choices[DIMENSION] == 3:
        stretch_and_push_with(cubic, choices, True, fields, count, neighbor, numbers, rates)
    else:
        stretch_and_push_with(cubic, choices, False, fields, count, neighbor, numbers, rates)


@summing
def both_any(fields: Any, count: Any, neighbor: Any, numbers: Any, choices: Any, rates: Any) -> None:
    """`stretch_and_push_with` any kernel."""
    if choices[DIMENSION] == 3:
        stretch_and_push_with(slope_of, choices, True, fields, count, neighbor, numbers, rates)
    else:
        stretch_and_push_with(slope_of, choices, False, fields, count, neighbor, numbers, rates)


class Sums(NamedTuple):
    """The three sums with one kernel."""

    stretch: Any
    push: Any
    both: Any


ANY = Sums(stretch_any, push_any, both_any)
CLOSED: dict[Shape, Sums] = {
    shapes.wendland_c2_slope: Sums(stretch_wendland, push_wendland, both_wendland),
    shapes.cubic_spline_slope: Sums(stretch_cubic, push_cubic, both_cubic),
}
"""Faster loops for one kernel, by the formula that is written into them."""
SUMS = {KERNEL_CODES[name]: CLOSED.get(form.slope, ANY) for name, form in KERNELS.items()}


def sums_of(choices: Any) -> Sums:
    """The sums with the kernel of a scene."""
    return SUMS[int(choices[KERNEL])]
