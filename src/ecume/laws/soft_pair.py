"""Two soft spheres in a viscous liquid, solved exactly: opening and closing under a constant force, relaxing at fixed
centers, and the force that moves them fastest. They are what simulations are held to.

In terms of p = a^3/(K R^3) - 1, where a is the contact size and K = c_d F / (alpha_n E R^2), the gap is
c_h h = R K^(2/3) p / (1 + p)^(1/3): p is large in Poiseuille's regime and small in Hertz's. R is twice the reduced
radius: the radius of equal spheres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ecume.laws.arguments import require_positive
from ecume.laws.elasticity import PREFACTORS, Prefactors
from ecume.units import Force, Length, Number, Pressure, Time, Viscosity


@dataclass(frozen=True)
class SoftPair:
    """Two spheres and what is between them."""

    radius: Length
    """Of equal spheres; twice the reduced radius of others."""
    modulus: Pressure
    viscosity: Viscosity
    prefactors: Prefactors = PREFACTORS["paper"]


def reduced_force(pair: SoftPair, force: Force) -> Number:
    """K = c_d |F| / (alpha_n E R^2); the paper's kappa where the prefactors are 1. [rognon2009, eq. 28].

    >>> reduced_force(SoftPair(1.0, 1000.0, 1.0), 1.0)
    0.001
    """
    return pair.prefactors.deflection_weight * abs(force) / (pair.prefactors.normal * pair.modulus * pair.radius**2)


def crossover_gap(pair: SoftPair, force: Force) -> Length:
    """The gap R K^(2/3) / c_h, like the deflection: above it Poiseuille, below it Hertz. [rognon2009, eq. 30].

    >>> round(crossover_gap(SoftPair(1.0, 1000.0, 1.0), 1.0), 12)
    0.01
    """
    return pair.radius * math.cbrt(reduced_force(pair, force)) ** 2 / pair.prefactors.gap_weight


def steepness(pair: SoftPair, gap: Length, force: Force) -> Number:
    """P of this gap under this force: the root of c_h h = R K^(2/3) p / (1 + p)^(1/3), which rises. [rognon2009].

    >>> p = steepness(SoftPair(1.0, 1000.0, 1.0), 0.01, 1.0)
    >>> round(p / (1 + p) ** (1 / 3), 12)
    1.0
    """
    level = gap / crossover_gap(pair, force)
    p = level + level * math.sqrt(level)
    for _ in range(60):
        root = math.cbrt(1.0 + p)
        change = (p / root - level) / ((1.0 + 2.0 * p / 3.0) / ((1.0 + p) * root))
        p -= change
        if abs(change) <= 1e-15 * p:
            break
    return p


def size_under_force(pair: SoftPair, gap: Length, force: Force) -> Length:
    """The contact size a: the root of a^3 - R c_h h a - K R^3 = 0. [rognon2009, eq. 12 and 14].

    >>> round(size_under_force(SoftPair(1.0, 1000.0, 1.0), 0.01, 1.0), 6)
    0.132472
    """
    return pair.radius * math.cbrt(reduced_force(pair, force) * (1.0 + steepness(pair, gap, force)))


def viscous_time(pair: SoftPair, force: Force) -> Time:
    """t_P = c_n c_h^2 eta R^2 / |F|: in Poiseuille's regime a gap grows or shrinks by e in it. [rognon2009, eq. 31].

    >>> viscous_time(SoftPair(1.0, 1000.0, 1.0), 1.0) == 1.5 * math.pi
    True
    """
    factors = pair.prefactors
    return factors.squeeze * factors.gap_weight**2 * pair.viscosity * pair.radius**2 / abs(force)


def passage_time(pair: SoftPair, force: Force, gap_from: Length, gap_to: Length) -> Time:
    """How long a constant force, with its deflection there from the start, takes from one gap to another.

    t = t_P/3 |2 ln(p1/p0) + 5 (1/p0 - 1/p1) + 3/2 (1/p0^2 - 1/p1^2)|. The exact law behind [rognon2009, eq. 31 to 34]:
    t_P ln(h1/h0) for p >> 1, and (t_P/2) K^(4/3) (R/h0)^2 for p << 1, where pulling harder is slower.

    >>> round(passage_time(SoftPair(1.0, 1000.0, 1.0), 1.0, 0.01, 0.1), 8)
    17.04001231
    """
    for name, gap in (("gap_from", gap_from), ("gap_to", gap_to)):
        require_positive(name, gap)
    start, end = (steepness(pair, gap, force) for gap in (gap_from, gap_to))
    powers = 5.0 * (1.0 / start - 1.0 / end) + 1.5 * (1.0 / start**2 - 1.0 / end**2)
    return viscous_time(pair, force) / 3.0 * abs(2.0 * math.log(end / start) + powers)


def optimal_force(pair: SoftPair, gap: Length) -> Force:
    """The force that changes this gap fastest: F = 2 sqrt(3) (alpha_n/c_d) E R^2 (c_h h/R)^(3/2). Its deflection is
    2 c_h/c_d gaps, and a^2 = 3 R c_h h. From [rognon2009, eq. 10, 12 and 14].

    >>> round(optimal_force(SoftPair(1.0, 1000.0, 1.0), 0.01), 5)
    3.4641
    """
    factors = pair.prefactors
    level = factors.gap_weight * gap / pair.radius
    scale = factors.normal / factors.deflection_weight * pair.modulus * pair.radius**2
    return 2.0 * math.sqrt(3.0) * scale * level * math.sqrt(level)
