"""The sums of continuity and pressure for two liquids in one tank.

The weights are volumes instead of masses (Colagrossi and Landrini 2003), so that a neighbor of another density does not
change the volume of a particle. The pressure between two particles i and j is weighted by the reference densities, and
so are velocities:

    2 p_ij = 2 (rho_j p_i + rho_i p_j) / (rho_i + rho_j) = w_i p_i + w_j p_j,   w_i = 2 rho_j / (rho_i + rho_j)

(Adami et al. 2013, eq. 5). Then grad p / rho is continuous between them, as it must be where both move together, and
stacked liquids of any densities are at rest. With the plain sum p_i + p_j the pressure on the lighter liquid has an
error of the order of the weight of the denser one, which separates the liquids by a fraction of a spacing. Continuity
has the same factor, which makes it the adjoint of the force: the two conserve energy. In one liquid w = 1.
[colagrossi2003, adami2013]

Density diffuses only within each liquid, since it is discontinuous at the interface. Other factors of the diffusion,
which depend on the liquid, are applied where its rate is stored (see `right_hand_side`).
"""

from __future__ import annotations

import math
from typing import Any

from ecume._jit import admit, summed_inside
from ecume.engine.vectors import Vector, axpy, difference, dot
from ecume.laws import density_diffusion
from ecume.models.sph.fields import FIELD, Numbers
from ecume.models.sph.rates.neighbor_sums import NOTHING, NeighborSum, Particle, neighbor_sum, of_rows
from ecume.models.sph.rates.sums import (
    MOVED,
    Both,
    given_continuity,
    no_continuity,
    no_rates,
    no_vector,
    pair_divergence,
    pair_force,
    store_continuity,
    store_pressure_force,
    store_rates,
)

admit(density_diffusion)


@summed_inside
def excess_share(own: float, other: float, contrast: float) -> float:
    """The excess weight w_i - 1 of two particles of these kinds; the contrast is (rho_1 - rho_2)/(rho_1 + rho_2)."""
    return contrast * (own - other)


@summed_inside
def share_within(own: float, other: float, pull: float, zero: float) -> float:
    """The weight `pull` of a pair within one liquid, or zero for a pair of two liquids."""
    return pull if own == other else zero


@summed_inside
def given_two_continuity(numbers: Numbers, settings: Any, like: Vector) -> Any:
    """Constants of continuity, and the contrast."""
    return given_continuity(numbers, settings, like), settings[0]


@summed_inside
def pair_two_continuity(
    total: tuple[float, float], apart: Vector, slope: float, own: Particle, other: Particle, given: Any
) -> tuple[float, float]:
    """The sums with the terms of a pair: compression and diffusion."""
    ((rise, _, zero, _), contrast), (stretching, flow) = given, total
    pull = slope * math.fabs(other.weight)
    more = pull + pull * excess_share(own.more, other.more, contrast)
    beyond = density_diffusion.beyond_rest(own.value, other.value, dot(rise, apart))
    diffused = density_diffusion.flow(beyond, share_within(own.more, other.more, pull, zero))
    return stretching + pair_divergence(more, dot(difference(other.vector, own.vector), apart)), flow + diffused


@summed_inside
def store_two_continuity(
    rates: Any, fields: Any, i: int, total: tuple[float, float], own: Particle, given: Any
) -> None:  # fmt: skip
    """Store continuity and diffusion."""
    store_continuity(rates, fields, i, total, own, given[0])


@summed_inside
def given_two_pressure(numbers: Numbers, settings: Any, like: Vector) -> Any:
    """The contrast, and the factor of slopes."""
    return settings[0], numbers.slope_factor


@summed_inside
def weighted_force(pull: float, own: float, push: float, share: float, zero: float) -> float:
    """The force of a pair over x_ij from the force terms P_i and P_j, w_i P_i + w_j P_j."""
    return pair_force(pull, own + share * own, push - share * push, zero)


@summed_inside
def pair_two_pressure(total: Vector, apart: Vector, slope: float, own: Particle, other: Particle, given: Any) -> Vector:
    """The acceleration with the term of a pair by pressure."""
    share = excess_share(own.more, other.more, given[0])
    pull = slope * math.fabs(other.weight)
    found: Vector = axpy(total, weighted_force(pull, own.value, other.value, share, share - share), apart)
    return found


@summed_inside
def given_two_rates(numbers: Numbers, settings: Any, like: Vector) -> Any:
    """Constants of continuity, with the contrast, and of the pressure force."""
    return given_two_continuity(numbers, settings, like), given_two_pressure(numbers, settings, like)


@summed_inside
def pair_two_rates(total: Both, apart: Vector, slope: float, own: Particle, other: Particle, given: Any) -> Both:
    """The sums of continuity, diffusion and pressure with the terms of a pair; `more` contains the field that diffuses,
    and the kind.
    """
    (rise, _, zero, _), contrast = given[0]
    (mine, kind, _, _, _, _, _, _), (there, another, _, _, _, _, _, _) = own.more, other.more
    pull, share = slope * math.fabs(other.weight), excess_share(kind, another, contrast)
    more = pair_divergence(pull + pull * share, dot(difference(other.vector, own.vector), apart))
    beyond = density_diffusion.beyond_rest(mine, there, dot(rise, apart))
    flow = density_diffusion.flow(beyond, share_within(kind, another, pull, zero))
    push = weighted_force(pull, own.value, other.value, share, zero)
    return Both(total.stretching + more, total.flow + flow, axpy(total.acceleration, push, apart))


@summed_inside
def store_two_rates(rates: Any, fields: Any, i: int, total: Both, own: Particle, given: Any) -> None:
    """Store continuity, diffusion and the acceleration by pressure."""
    store_rates(rates, fields, i, total, own, (given[0][0], given[1]))


BESIDE = MOVED._replace(more=(FIELD.kind,))
CONTINUITY_OF_TWO = neighbor_sum(BESIDE, given_two_continuity, no_continuity, pair_two_continuity, store_two_continuity)
CONTINUITIES_OF_TWO: dict[int, NeighborSum] = {
    row: of_rows(CONTINUITY_OF_TWO, BESIDE._replace(value=row)) for row in (FIELD.density, FIELD.enthalpy)
}
PRESSURE_OF_TWO = neighbor_sum(
    BESIDE._replace(value=FIELD.force_term), given_two_pressure, no_vector, pair_two_pressure, store_pressure_force
)
BOTH = MOVED._replace(value=FIELD.force_term, more=(FIELD.density, FIELD.kind, *[NOTHING] * 6))
RATES_OF_TWO = neighbor_sum(BOTH, given_two_rates, no_rates, pair_two_rates, store_two_rates)
ALL_RATES_OF_TWO: dict[int | None, NeighborSum] = {
    None: RATES_OF_TWO,
    **{
        row: of_rows(RATES_OF_TWO, BOTH._replace(more=(row, *BOTH.more[1:]))) for row in (FIELD.density, FIELD.enthalpy)
    },
}
"""Continuity and pressure in one sum, by the row of the field that diffuses."""
