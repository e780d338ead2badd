"""The gradient of the particle concentration, for particle shifting, and the fullness of the neighborhood of a
particle.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ecume._jit import admit, summed_inside
from ecume.engine.vectors import Vector, axpy, dot, store_vector, zeros
from ecume.laws import incompressible
from ecume.laws.incompressible import tensile_weight
from ecume.models.sph.fields import FIELD, RATE, Floats, Numbers
from ecume.models.sph.rates.kernel_loops import value_of
from ecume.models.sph.rates.neighbor_sums import Particle, Reading, neighbor_sum

admit(incompressible)


class ConcentrationSums(NamedTuple):
    """The sums of `CONCENTRATION`."""

    fullness: Any
    concentration_gradient: Any
    even: Any


@summed_inside
def concentration_settings(numbers: Numbers, settings: Any, like: Vector) -> Any:
    """The inverse of the value of the kernel at one spacing (zero for equal weights), and constants of the kernel."""
    zero, reference = numbers.zero, numbers.reference_value
    inverse = zero if reference <= zero else 1.0 / reference
    return zero + inverse, numbers.kernel, numbers.inverse_length, zero, numbers.slope_factor


@summed_inside
def empty_concentration(zero: float, like: Vector) -> ConcentrationSums:
    """Sums of zero, in double precision."""
    return ConcentrationSums(0.0, zeros(0.0, like), zeros(0.0, like))


@summed_inside
def pair_concentration(
    total: ConcentrationSums, apart: Vector, slope: float, own: Particle, other: Particle, given: Any
) -> ConcentrationSums:
    """The sums with the terms of a pair: the fullness -sum_j V_j F r^2; the reversed concentration gradient sum_j V_j F
    x_ij, weighted by `tensile_weight`, which vanishes in a lattice; and this gradient with equal weights, in which
    dummies count half (see `correct_for_spreading`).
    """
    tensile, kernel, inverse, zero, _ = given
    square, pull = dot(apart, apart), slope * math.fabs(other.weight)
    weight = tensile_weight(value_of(math.sqrt(square) * inverse, kernel) * tensile)
    return ConcentrationSums(
        total.fullness - pull * square,
        axpy(total.concentration_gradient, pull * weight, apart),
        axpy(total.even, pull if other.weight > zero else 0.5 * pull, apart),
    )


@summed_inside
def store_concentration(
    rates: Floats, fields: Floats, i: int, total: ConcentrationSums, own: Particle, given: Any
) -> None:
    """Store the three sums."""
    scale = given[4]
    rates[RATE.fullness, i] = scale * total.fullness
    store_vector(rates, RATE.concentration_gradient, i, scale, total.concentration_gradient)
    store_vector(rates, RATE.even_concentration_gradient, i, scale, total.even)


CONCENTRATION = neighbor_sum(
    Reading(weight=FIELD.volume, signed=True),
    concentration_settings,
    empty_concentration,
    pair_concentration,
    store_concentration,
)
