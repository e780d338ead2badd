"""The sums over neighbors that move the liquid: continuity with density diffusion, pressure with artificial viscosity,
and in scenes that select them the viscous force and the pressure force with transport velocity.

Each is a formula for a pair, the same in 2D and 3D: see `neighbor_sums`, also for signs.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ecume._jit import admit, prange, spread, summed_inside
from ecume.engine.vectors import Vector, add_vector, axpy, difference, dot, scaled, store_vector, vector_of, zeros
from ecume.laws import density_diffusion, viscous
from ecume.models.sph.fields import FIELD, RATE, Floats, Numbers
from ecume.models.sph.rates.neighbor_sums import NOTHING, NeighborSum, Particle, Reading, neighbor_sum, of_rows
from ecume.units import Array

admit(viscous, density_diffusion)
Damper = tuple[float, float, float, float]


@summed_inside
def damping(approach: float, square: float, damper: Damper) -> float:
    """The artificial viscosity of a pair, with the particle's own density and sound speed for both, as in delta-SPH
    (Antuono et al. 2012); positive for two that approach. `damper` is (h, divisor, sound speed, alpha), see `Numbers`.
    """
    h, share, sound, alpha = damper
    return viscous.artificial_viscosity(viscous.approach_speed(approach, square, h), share, sound, alpha)


@summed_inside
def pair_divergence(pull: float, radial: float) -> float:
    """The term of a pair in -div v: w_j F (v_j - v_i).x_ij (Monaghan 1994)."""
    return pull * radial


@summed_inside
def pair_force(pull: float, own: float, push: float, damp: float) -> float:
    """The force of a pair over x_ij: w_j F (P_i + P_j + damping); see `Fields.force_term` and `Fields.weight`."""
    return pull * (own + push + damp)


@summed_inside
def no_vector(zero: float, like: Vector) -> Vector:
    """An empty sum of vectors."""
    found: Vector = zeros(zero, like)
    return found


@summed_inside
def given_slope_factor(numbers: Numbers, settings: Any, like: Vector) -> float:
    """The slope factor of the kernel, by which most sums are multiplied at the end."""
    return numbers.slope_factor


@summed_inside
def store_pressure_force(rates: Floats, fields: Floats, i: int, total: Vector, own: Particle, given: Any) -> None:
    """Store the acceleration by pressure; the last constant is the slope factor."""
    store_vector(rates, RATE.acceleration, i, given[-1], total)


@summed_inside
def given_continuity(numbers: Numbers, settings: Any, like: Vector) -> Any:
    """Constants of continuity: the gradient of the diffusing field at rest, the strength of diffusion, and factors."""
    rise = vector_of(numbers.rise_x, numbers.rise_y, numbers.rise_z, like)
    return rise, numbers.delta, numbers.zero, numbers.slope_factor


@summed_inside
def no_continuity(zero: float, like: Vector) -> tuple[float, float]:
    """Zero compression and zero diffusion."""
    return zero, zero


@summed_inside
def pair_continuity(
    total: tuple[float, float], apart: Vector, slope: float, own: Particle, other: Particle, given: Any
) -> tuple[float, float]:
    """The sums with the terms of a pair: compression and diffusion. Dummies do not contribute to diffusion."""
    (rise, _, zero, _), (stretching, flow) = given, total
    radial = dot(difference(other.vector, own.vector), apart)
    beyond = density_diffusion.beyond_rest(own.value, other.value, dot(rise, apart))
    more = pair_divergence(slope * math.fabs(other.weight), radial)
    return stretching + more, flow + density_diffusion.flow(beyond, slope * max(other.weight, zero))


@summed_inside
def store_continuity(
    rates: Floats, fields: Floats, i: int, total: tuple[float, float], own: Particle, given: Any
) -> None:  # fmt: skip
    """Store continuity and diffusion."""
    (_, delta, _, factor), (stretching, flow) = given, total
    rates[RATE.continuity, i] = factor * stretching
    rates[RATE.diffusion, i] = factor * delta * flow


@summed_inside
def given_pressure(numbers: Numbers, settings: Any, like: Vector) -> Any:
    """Constants of the pressure force: see `damping`."""
    damper = numbers.smoothing_length, numbers.damping_divisor, numbers.sound_speed, numbers.alpha
    return damper, numbers.zero, numbers.slope_factor


@summed_inside
def pair_pressure(total: Vector, apart: Vector, slope: float, own: Particle, other: Particle, given: Any) -> Vector:
    """The acceleration with the term of a pair by pressure and artificial viscosity; dummies have no artificial
    viscosity.
    """
    damper, zero, _ = given
    damp = damping(dot(difference(other.vector, own.vector), apart), dot(apart, apart), damper)
    pull = slope * math.fabs(other.weight)
    found: Vector = axpy(total, pair_force(pull, own.value, other.value, damp if other.weight > zero else zero), apart)
    return found


class Both(NamedTuple):
    """The combined sums of continuity and of pressure."""

    stretching: Any
    flow: Any
    acceleration: Any


@summed_inside
def given_rates(numbers: Numbers, settings: Any, like: Vector) -> Any:
    """Constants of continuity, and of the pressure force."""
    return given_continuity(numbers, settings, like), given_pressure(numbers, settings, like)


@summed_inside
def no_rates(zero: float, like: Vector) -> Both:
    """The empty sum: zero compression, diffusion and acceleration."""
    return Both(zero, zero, zeros(zero, like))


@summed_inside
def pair_rates(total: Both, apart: Vector, slope: float, own: Particle, other: Particle, given: Any) -> Both:
    """Continuity and pressure in one sum, without diffusion."""
    damper, zero, _ = given[1]
    radial, pull = dot(difference(other.vector, own.vector), apart), slope * math.fabs(other.weight)
    damp = damping(radial, dot(apart, apart), damper)
    push = pair_force(pull, own.value, other.value, damp if other.weight > zero else zero)
    return Both(total.stretching + pair_divergence(pull, radial), total.flow, axpy(total.acceleration, push, apart))


@summed_inside
def pair_diffusing_rates(total: Both, apart: Vector, slope: float, own: Particle, other: Particle, given: Any) -> Both:
    """Continuity, diffusion and pressure in one sum."""
    (rise, _, zero, _), _ = given
    found = pair_rates(total, apart, slope, own, other, given)
    beyond = density_diffusion.beyond_rest(own.more, other.more, dot(rise, apart))
    flow = density_diffusion.flow(beyond, slope * max(other.weight, zero))
    return Both(found.stretching, found.flow + flow, found.acceleration)


@summed_inside
def store_rates(rates: Floats, fields: Floats, i: int, total: Both, own: Particle, given: Any) -> None:
    """Store continuity, diffusion and the acceleration by pressure."""
    store_continuity(rates, fields, i, (total.stretching, total.flow), own, given[0])
    store_pressure_force(rates, fields, i, total.acceleration, own, given[1])


def by_diffusing_field(taken: NeighborSum, reading: Reading) -> dict[int, NeighborSum]:
    """The sum for each field that may diffuse, by the row of the field: density and enthalpy."""
    return {row: of_rows(taken, reading._replace(value=row)) for row in (FIELD.density, FIELD.enthalpy)}


MOVED = Reading(FIELD.velocity, FIELD.weight, signed=True)
CONTINUITY = by_diffusing_field(
    neighbor_sum(MOVED, given_continuity, no_continuity, pair_continuity, store_continuity), MOVED
)
"""Continuity, and the diffusion of a field beyond g.x_ij by which it changes along x when the liquid is at rest
(Antuono et al. 2010, Fourtakas et al. 2019; see `ecume.laws.density_diffusion`).
"""
PRESSURE = neighbor_sum(
    MOVED._replace(value=FIELD.force_term),
    given_pressure, no_vector, pair_pressure, store_pressure_force,
)  # fmt: skip
PRESSED = MOVED._replace(value=FIELD.force_term)
DIFFUSING = PRESSED._replace(more=(FIELD.density,))
DIFFUSING_RATES = neighbor_sum(DIFFUSING, given_rates, no_rates, pair_diffusing_rates, store_rates)
RATES: dict[int | None, NeighborSum] = {
    None: neighbor_sum(PRESSED, given_rates, no_rates, pair_rates, store_rates),
    **{row: of_rows(DIFFUSING_RATES, DIFFUSING._replace(more=(row,))) for row in (FIELD.density, FIELD.enthalpy)},
}
"""Continuity and pressure in one sum, by the row of the field that diffuses."""


@summed_inside
def drag(slope: float, own: Particle, other: Particle) -> float:
    """The factor F V_j mu_j/(mu_i + mu_j) of a pair in the viscous force, without factors common to all neighbors. A
    wall with slip has no viscosity.
    """
    return slope * other.weight * other.value / (own.value + other.value)


@summed_inside
def pair_friction(total: Vector, apart: Vector, slope: float, own: Particle, other: Particle, given: Any) -> Vector:
    """The viscous acceleration (2/rho_i) sum_j mu_ij F V_j (u_i - u_j), where mu_ij is the harmonic mean (Morris et al.
    1997, eq. 22; Adami et al. 2012, eq. 8).
    """
    found: Vector = axpy(total, drag(slope, own, other), difference(own.vector, other.vector))
    return found


@summed_inside
def add_friction(rates: Floats, fields: Floats, i: int, total: Vector, own: Particle, factor: float) -> None:
    """Add the viscous acceleration; twice a harmonic mean has a factor of four."""
    share = factor * (own.value + own.value + own.value + own.value) / fields[FIELD.density, i]
    add_vector(rates, RATE.acceleration, i, share, total)


@summed_inside
def given_radial_friction(numbers: Numbers, settings: Any, like: Vector) -> tuple[float, float]:
    """The smallest squared distance, and factors."""
    return numbers.softening, numbers.slope_factor * (numbers.dimension + 2)


@summed_inside
def pair_radial_friction(
    total: Vector, apart: Vector, slope: float, own: Particle, other: Particle, given: tuple[float, float]
) -> Vector:
    """The viscous acceleration (1/rho_i) sum_j Z_ij F V_j [(u_i - u_j).x_ij] x_ij/r^2, where Z_ij is 2 (d + 2) times
    the harmonic mean of the viscosities (Monaghan 2005). The smallest distance has an effect only for a particle and
    its own image.
    """
    radial = dot(difference(own.vector, other.vector), apart) / max(dot(apart, apart), given[0])
    found: Vector = axpy(total, drag(slope, own, other) * radial, apart)
    return found


@summed_inside
def add_radial_friction(
    rates: Floats, fields: Floats, i: int, total: Vector, own: Particle, given: tuple[float, float]
) -> None:  # fmt: skip
    """Add the viscous acceleration."""
    add_friction(rates, fields, i, total, own, given[1])


VISCOUS = Reading(FIELD.friction_velocity, FIELD.volume, FIELD.viscosity)
FRICTION = neighbor_sum(VISCOUS, given_slope_factor, no_vector, pair_friction, add_friction)
RADIAL_FRICTION = neighbor_sum(VISCOUS, given_radial_friction, no_vector, pair_radial_friction, add_radial_friction)


@summed_inside
def pair_transported_pressure(
    total: Vector, apart: Vector, slope: float, own: Particle, other: Particle, given: Any
) -> Vector:
    """The acceleration by density-weighted pressure, and by the momentum that the transport
    velocity W carries.

    (1/m_i) sum_j (V_i^2 + V_j^2) [p_ij - (1/2)(A_i + A_j).x_ij ...] F x_ij with p_ij = (rho_j p_i + rho_i p_j)/(rho_i +
    rho_j), A = rho v W (Adami et al. 2013, eqs. 5, 8 and 10). The formula contains half of each flux; the other half is
    in the factor outside the sum. [adami2013]
    """
    (a, b, c, density, _, _, _, _), (e, f, g, thickness, _, _, _, _) = own.more, other.more
    own_flux = density * dot(vector_of(a, b, c, apart), apart)
    flux = thickness * dot(vector_of(e, f, g, apart), apart)
    pull = slope * (own.weight * own.weight + other.weight * other.weight)
    mean = (thickness * own.value + density * other.value) / (thickness + density)
    carried = axpy(scaled(pull * own_flux, own.vector), pull * flux, other.vector)
    found: Vector = difference(axpy(total, pull * (mean + mean), apart), carried)
    return found


@summed_inside
def store_transported_pressure(
    rates: Floats, fields: Floats, i: int, total: Vector, own: Particle, factor: float
) -> None:  # fmt: skip
    """Store the acceleration by pressure and transport."""
    mass = own.more[3] * own.weight
    store_vector(rates, RATE.acceleration, i, factor / (mass + mass), total)


TRANSPORTED_PRESSURE = neighbor_sum(
    Reading(
        FIELD.velocity, FIELD.volume, FIELD.pressure,
        more=(*range(FIELD.transport, FIELD.transport + 3), FIELD.density, *[NOTHING] * 4),
    ),
    given_slope_factor, no_vector, pair_transported_pressure, store_transported_pressure,
)  # fmt: skip


@spread
def store_density_rate(density_rate: Array, rates: Floats, density: Array, by_mass: bool) -> None:
    """Store the rate of density; with volumes as weights of neighbors, the sum is over the density."""
    for i in prange(len(density)):
        share = 1.0 if by_mass else density[i]
        density_rate[i] = share * rates[RATE.continuity, i] + rates[RATE.diffusion, i]


@spread
def store_acceleration(acceleration: Array, rates: Floats, density: Array, pull: Array, per_volume: bool) -> None:
    """Store the acceleration by neighbors plus gravity."""
    for i in prange(acceleration.shape[1]):
        share = 1.0 / density[i] if per_volume else 1.0
        for axis in range(acceleration.shape[0]):
            acceleration[axis, i] = share * rates[RATE.acceleration + axis, i] + pull[axis]
