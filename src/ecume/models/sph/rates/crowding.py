"""The gradient of the particle concentration, by which particles are shifted, and how full a neighborhood is."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ecume._jit import admit, summed_inside
from ecume.engine.vectors import Vector, dot, plus, store_vector, zeros
from ecume.laws import incompressible
from ecume.laws.incompressible import tensile_weight
from ecume.models.sph.fields import FIELD, RATE, Floats, Numbers
from ecume.models.sph.rates.kernel_loops import value_of
from ecume.models.sph.rates.neighbor_sums import Particle, Reading, neighbor_sum

admit(incompressible)


class Crowd(NamedTuple):
    """Sums of `CROWDING`."""

    fullness: Any
    crowding: Any
    even: Any


@summed_inside
def given_crowd(numbers: Numbers, settings: Any, like: Vector) -> Any:
    """The inverse of the kernel's value at one spacing, zero: all count alike; and constants of the kernel."""
    zero, reference = numbers.zero, numbers.reference_value
    inverse = zero if reference <= zero else 1.0 / reference
    return zero + inverse, numbers.kernel, numbers.inverse_length, zero, numbers.slope_factor


@summed_inside
def no_crowd(zero: float, like: Vector) -> Crowd:
    """Empty sums, in double precision."""
    return Crowd(0.0, zeros(0.0, like), zeros(0.0, like))


@summed_inside
def pair_crowd(total: Crowd, apart: Vector, slope: float, own: Particle, other: Particle, given: Any) -> Crowd:
    """The fullness -sum_j V_j F r^2, the reversed concentration gradient sum_j V_j F x_ij, zero in a lattice, in which
    each neighbor counts `tensile_weight` times, and an even sum, which counts dummies half (see `keep_volume`).
    """
    tensile, kernel, inverse, zero, _ = given
    square, pull = dot(apart, apart), slope * math.fabs(other.weight)
    weight = tensile_weight(value_of(math.sqrt(square) * inverse, kernel) * tensile)
    return Crowd(
        total.fullness - pull * square,
        plus(total.crowding, pull * weight, apart),
        plus(total.even, pull if other.weight > zero else 0.5 * pull, apart),
    )


@summed_inside
def store_crowd(rates: Floats, fields: Floats, i: int, total: Crowd, own: Particle, given: Any) -> None:
    """Store the three sums."""
    scale = given[4]
    rates[RATE.fullness, i] = scale * total.fullness
    store_vector(rates, RATE.crowding, i, scale, total.crowding)
    store_vector(rates, RATE.even_crowding, i, scale, total.even)


CROWDING = neighbor_sum(Reading(weight=FIELD.volume, signed=True), given_crowd, no_crowd, pair_crowd, store_crowd)
