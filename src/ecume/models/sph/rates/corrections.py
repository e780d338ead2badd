"""Sums whose kernel gradients are completed at a free surface, where neighbors are missing on one side.

There the divergence of velocity by the sums of `sums` counts strain along and across the surface differently, and
the upper rows of particles have to move relative to each other in every wave, which costs energy. With the matrix B_i
of `CORRECTIONS`

    div v = sum_j V_j (v_j - v_i).B_i grad W,    F_i = -sum_j V_i V_j (p_i B_i + p_j B_j) grad W:

the divergence is exact for linear velocities, and the force is its adjoint, so that energy and momentum are conserved
(Bonet and Lok, Comput. Methods Appl. Mech. Eng. 180 (1999) 97). A dummy has no such matrix, and pairs with one are not
corrected. [bonet1999]

The force of a uniform pressure is then zero in first order at a surface, too, so that no force spreads particles evenly
there. A density that is integrated with completed gradients is not a function of the positions: disordered rows below a
surface, driven by their weight, move in cycles after which they are closer together at the same density. Therefore a
part of the pressure, p_s = rho g times a spacing with the largest initial acceleration g, is not completed:

    F_i = -sum_j V_i V_j [(p_i - p_s) B_i + (p_j - p_s) B_j + 2 p_s] grad W.

This part is the gradient of the energy p_s [sum_i sum_j V_i V_j W_ij + sum_i V_i] (`spreading_energy`), which is
constant in the interior.

The rate at which damped sound decays in a lattice grows with the square of B: by a factor of 4 in the first row below a
flat surface, and up to 25 in drops of a few particles. Drops are not corrected (`kernels.correction_share`), and the
acoustic damping of a particle is divided by the square of its factor (`kernels.completion_factor`), so that the fastest
rate is that of the interior and the usual time step resolves it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ecume._jit import admit, summed_inside
from ecume.engine.vectors import (
    Symmetric,
    Symmetric2,
    Symmetric3,
    Vector,
    Vector2,
    Vector3,
    adjugate,
    axpy,
    by_dimension,
    difference,
    dot,
    plus_square,
    times,
    trace,
    zero_matrix,
)
from ecume.laws import density_diffusion, kernels
from ecume.models.sph.fields import FIELD, Fields, Floats, Numbers
from ecume.models.sph.rates.neighbor_sums import NOTHING, Particle, Reading, neighbor_sum
from ecume.models.sph.rates.sums import (
    MOVED,
    VISCOUS,
    add_radial_friction,
    by_diffusing_field,
    damping,
    drag,
    given_continuity,
    given_pressure,
    no_continuity,
    no_vector,
    pair_divergence,
    store_continuity,
    store_pressure_force,
)
from ecume.units import Array

admit(density_diffusion, kernels)
SINGULAR = 1e-3
"""The determinant of a particle's matrix below which it has too few neighbors for a gradient."""
MATRIX = (*range(FIELD.correction, FIELD.correction + 6), NOTHING, NOTHING)


@summed_inside
def given_scale(numbers: Numbers, settings: Any, like: Vector) -> tuple[float, float]:
    """The factor of slopes, and the dimension."""
    return numbers.slope_factor, numbers.zero + numbers.dimension


@summed_inside
def no_matrix(zero: float, like: Vector) -> Symmetric:
    """The empty sum of matrices."""
    found: Symmetric = zero_matrix(zero, like)
    return found


@summed_inside
def pair_matrix(
    total: Symmetric, apart: Vector, slope: float, own: Particle, other: Particle, given: tuple[float, float]
) -> Symmetric:
    """-sum_j V_j F x_ij x_ij, the unit matrix in full surroundings."""
    found: Symmetric = plus_square(total, -given[0] * slope * other.weight, apart)
    return found


@summed_inside
def store_correction(
    rates: Floats, fields: Floats, i: int, total: Symmetric, own: Particle, given: tuple[float, float]
) -> None:  # fmt: skip
    """Store the correction matrix 1 + s (B - 1) with the share s of `kernels.correction_share`."""
    missing = kernels.missing_neighbors(trace(total), given[1])
    inverse, determinant = adjugate(total)
    share, inverted = 0.0, 1.0
    if determinant > SINGULAR:
        inverted = 1.0 / determinant
        share = kernels.correction_share(missing, kernels.completion_factor(off_unit(inverted, inverse)))
    store_matrix(fields, i, 1.0 - share, share * inverted, inverse)


@summed_inside
def _off_unit2(factor: float, a: Symmetric2) -> float:
    return (factor * a.xx - 1.0) ** 2 + (factor * a.yy - 1.0) ** 2 + 2.0 * factor * factor * a.xy * a.xy


@summed_inside
def _off_unit3(factor: float, a: Symmetric3) -> float:
    off = (factor * a.xx - 1.0) ** 2 + (factor * a.yy - 1.0) ** 2 + (factor * a.zz - 1.0) ** 2
    return off + 2.0 * factor * factor * (a.xy * a.xy + a.xz * a.xz + a.yz * a.yz)


off_unit = by_dimension(_off_unit2, _off_unit3)
"""off_unit(factor, a): the sum of the squares of all elements of factor a - 1."""


@summed_inside
def _store2(fields: Floats, i: int, rest: float, part: float, a: Symmetric2) -> None:
    fields[FIELD.correction, i] = rest + part * a.xx
    fields[FIELD.correction + 1, i] = rest + part * a.yy
    fields[FIELD.correction + 3, i] = part * a.xy


@summed_inside
def _store3(fields: Floats, i: int, rest: float, part: float, a: Symmetric3) -> None:
    fields[FIELD.correction, i] = rest + part * a.xx
    fields[FIELD.correction + 1, i] = rest + part * a.yy
    fields[FIELD.correction + 2, i] = rest + part * a.zz
    fields[FIELD.correction + 3, i] = part * a.xy
    fields[FIELD.correction + 4, i] = part * a.xz
    fields[FIELD.correction + 5, i] = part * a.yz


store_matrix = by_dimension(_store2, _store3)
"""store_matrix(fields, i, rest, part, a): set the matrix of particle i to rest + part a."""
CORRECTIONS = neighbor_sum(Reading(weight=FIELD.volume), given_scale, no_matrix, pair_matrix, store_correction)
"""The matrices of the liquid."""


def completion_factors(fields: Fields, count: int) -> Array:
    """The factors (N,) `kernels.completion_factor` of the first particles."""
    matrix = fields.correction[:, :count].astype(np.float64)
    off = ((matrix[:3] - 1.0) ** 2).sum(axis=0) + 2.0 * (matrix[3:] ** 2).sum(axis=0)
    factors: Array = 1.0 + np.sqrt(off)
    return factors


@summed_inside
def _matrix2(of: Particle, like: Vector2) -> Symmetric2:
    return Symmetric2(of.more[0], of.more[1], of.more[3])


@summed_inside
def _matrix3(of: Particle, like: Vector3) -> Symmetric3:
    return Symmetric3(of.more[0], of.more[1], of.more[2], of.more[3], of.more[4], of.more[5])


matrix_of = by_dimension(_matrix2, _matrix3)


@summed_inside
def completed(of: Particle, apart: Vector) -> Vector:
    """The vector B x with the matrix of a particle; x itself for a dummy, whose matrix is the unit matrix."""
    found: Vector = times(matrix_of(of, apart), apart)
    return found


@summed_inside
def pair_corrected_continuity(
    total: tuple[float, float], apart: Vector, slope: float, own: Particle, other: Particle, given: Any
) -> tuple[float, float]:
    """The sums of continuity by (v_j - v_i).B_i x_ij, and of the diffusion of `sums.pair_continuity`."""
    (rise, _, zero, _), (stretching, flow) = given, total
    change, liquid = difference(other.vector, own.vector), max(other.weight, zero)
    radial = dot(change, completed(own, apart)) if other.weight > zero else dot(change, apart)
    beyond = density_diffusion.beyond_rest(own.value, other.value, dot(rise, apart))
    more = pair_divergence(slope * abs(other.weight), radial)
    return stretching + more, flow + density_diffusion.flow(beyond, slope * liquid)


@summed_inside
def given_corrected_pressure(numbers: Numbers, settings: Any, like: Vector) -> Any:
    """The constants of `sums.given_pressure`, and the pressure p_s."""
    damper, zero, factor = given_pressure(numbers, settings, like)
    return damper, zero, settings[0], factor


@summed_inside
def pair_corrected_pressure(
    total: Vector, apart: Vector, slope: float, own: Particle, other: Particle, given: Any
) -> Vector:
    """The pressure force by (p_i - p_s) B_i + (p_j - p_s) B_j + 2 p_s, with the artificial viscosity of
    `sums.pair_pressure`.
    """
    damper, zero, spreading, _ = given
    damp = damping(dot(difference(other.vector, own.vector), apart), dot(apart, apart), damper)
    pull = slope * abs(other.weight)
    liquid = other.weight > zero
    uniform = spreading if liquid else zero
    corrected = pull * (own.value - uniform) if liquid else zero
    straight = pull * (uniform + uniform + damp) if liquid else pull * own.value
    found: Vector = axpy(
        axpy(axpy(total, corrected, completed(own, apart)), pull * (other.value - uniform), completed(other, apart)),
        straight, apart,
    )  # fmt: skip
    return found


@summed_inside
def completion(own: Particle, other: Particle, apart: Vector) -> float:
    """The factor x.(B_i + B_j) x of a pair: 2 r^2 times the weight that replaces missing friction."""
    found: float = dot(completed(own, apart), apart) + dot(completed(other, apart), apart)
    return found


@summed_inside
def given_corrected_friction(numbers: Numbers, settings: Any, like: Vector) -> tuple[float, float]:
    """The smallest squared distance, and factors: half of those of `sums.given_radial_friction`."""
    return numbers.softening, 0.5 * numbers.slope_factor * (numbers.dimension + 2)


@summed_inside
def pair_corrected_friction(
    total: Vector, apart: Vector, slope: float, own: Particle, other: Particle, given: tuple[float, float]
) -> Vector:
    """The viscous force of `sums.pair_radial_friction`, each pair times the `completion` over 2 r^2."""
    square = max(dot(apart, apart), given[0])
    radial = dot(difference(own.vector, other.vector), apart) / square
    found: Vector = axpy(total, drag(slope, own, other) * radial * (completion(own, other, apart) / square), apart)
    return found


CORRECTED_CONTINUITY = by_diffusing_field(
    neighbor_sum(
        MOVED._replace(more=MATRIX), given_continuity, no_continuity, pair_corrected_continuity, store_continuity
    ),
    MOVED._replace(more=MATRIX),
)
CORRECTED_PRESSURE = neighbor_sum(
    MOVED._replace(value=FIELD.force_term, more=MATRIX),
    given_corrected_pressure, no_vector, pair_corrected_pressure, store_pressure_force,
)  # fmt: skip
CORRECTED_FRICTION = neighbor_sum(
    VISCOUS._replace(more=MATRIX), given_corrected_friction, no_vector, pair_corrected_friction, add_radial_friction
)
