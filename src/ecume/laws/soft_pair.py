"""Two soft spheres in a viscous liquid: the film between them, the stiffness of their surfaces, and exact solutions.

A film is a disc of thickness h, the gap, and of radius a, the contact size. `squeeze_friction` and `shear_friction` are
its frictions. The surfaces share the contact size with the film: `contact_size` follows from gap and deflection, and
`surface_stiffness`, `surface_force` and the energies from the contact size. The deflection of a contact is that of both
surfaces together. Film and surfaces are in series and carry the same force, which may press or pull.

`SoftPair` and the functions after it solve simple motions exactly: opening and closing under a constant force,
relaxing at fixed centers, and the force that moves the spheres fastest. Simulations are compared with them. In terms of
p = a^3/(K R^3) - 1, where K = c_d F / (alpha_n E R^2), the gap is c_h h = R K^(2/3) p / (1 + p)^(1/3): p is large in
Poiseuille's regime and small in Hertz's. R is twice the reduced radius, the radius of equal spheres.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from ecume.laws.arguments import require_positive
from ecume.units import Energy, Force, Friction, Length, Number, Pressure, Speed, Time, Unit, Viscosity

DISC_SQUEEZE, DISC_SHEAR = 1.5 * math.pi, math.pi
"""The prefactors of two parallel discs: Stefan's for squeezing, Couette's for shear."""


def squeeze_friction(
    contact_size: Length, gap: Length, viscosity: Viscosity, prefactor: Number = DISC_SQUEEZE
) -> Friction:
    """Friction zeta_n = c_n eta a^4 / h^3 against a change of the gap: force over the speed of approach.

    a is the contact size, h the gap. With c_n = 3 pi/2 it is exact in both limits: for parallel discs [stefan1874], and
    with a^2 = R h for two rigid spheres of radius R, where it is 3 pi eta R^2 / (2 h) [brenner1961]. Gaps much smaller
    than a. [rognon2009, eq. 10].

    >>> squeeze_friction(0.1, 0.01, 1.0) == 1.5 * math.pi * 0.1**4 / 0.01**3
    True
    """
    return prefactor * viscosity * contact_size**4 / gap**3


def shear_friction(contact_size: Length, gap: Length, viscosity: Viscosity, prefactor: Number = DISC_SHEAR) -> Friction:
    """Friction zeta_t = c_t eta a^2 / h against sliding: force over the sliding speed.

    Couette flow between discs of radius a, a gap h apart. Two rigid spheres have the friction pi eta R ln(R/h): the
    model neglects the logarithm, a factor of 7 at h = R/1000. [rognon2009, eq. 11].

    >>> shear_friction(0.1, 0.01, 1.0) == math.pi * 0.1**2 / 0.01
    True
    """
    return prefactor * viscosity * contact_size**2 / gap


ENTRAINMENT = 0.75
"""The prefactor of `entrained_force` in the published law."""


def entrained_force(speed: Speed, compression: Force, contact_size: Length, viscosity: Viscosity) -> Force:
    """Elastohydrodynamic force T = sqrt(3/4 eta u N a) between soft surfaces in relative sliding.

    u is the sliding speed, N the compressive force, a the contact size. Sliding draws liquid into the contact until its
    pressure balances that of the surfaces: eta u a/h^2 ~ N/a^2. With this film thickness h, `shear_friction` gives T ~
    eta u a^2/h, the square root. The prefactor is that of soft particle glasses, T = sqrt(eta u C E* R*^3) eps^((2n +
    1)/4) for an elastic force N = 4/3 C E* R*^2 eps^n at the overlap eps R*, with a^2 = R*^2 eps; for Hertz's contact n
    = 3/2 and C = 1. [seth2011]; taken from the literature, since the text of the paper was not available: overlaps
    refer to R*, since the elastic law is Hertz's only then.

    >>> modulus, radius, overlap = 3.0, 0.5, 0.04
    >>> load = 4 / 3 * modulus * radius**2 * overlap**1.5
    >>> found = entrained_force(2.0, load, radius * math.sqrt(overlap), 7.0)
    >>> round(found / (math.sqrt(7.0 * 2.0 * modulus * radius**3) * overlap), 12)
    1.0
    """
    return math.sqrt(ENTRAINMENT * viscosity * speed * compression * contact_size)


Stiffness = Annotated[float, Unit("N/m")]


class Prefactors(NamedTuple):
    """The undetermined prefactors of the scaling laws of a contact."""

    squeeze: float = DISC_SQUEEZE
    """c_n of `squeeze_friction`"""
    shear: float = DISC_SHEAR
    """c_t of `shear_friction`"""
    normal: float = 1.0
    """alpha_n of `surface_stiffness`"""
    tangential: float = 1.0
    """alpha_t of `surface_stiffness`"""
    gap_weight: float = 1.0
    """c_h of `contact_size`"""
    deflection_weight: float = 1.0
    """c_d of `contact_size`"""


PREFACTORS = {"paper": Prefactors(), "physical": Prefactors(normal=8 / 9, tangential=8 / 9, deflection_weight=0.5)}
"""`paper`: as in [rognon2009]; `physical`: Hertz and Mindlin for incompressible spheres [johnson1985]."""


def reduced_radius(radius_i: Length, radius_j: Length) -> Length:
    """R* = R_i R_j / (R_i + R_j): half of equal radii, the radius itself at a wall. [johnson1985, eq. 4.18].

    >>> reduced_radius(2.0, 2.0), reduced_radius(2.0, math.inf)
    (1.0, 2.0)
    """
    return 1.0 / (1.0 / radius_i + 1.0 / radius_j)


def pair_modulus(modulus_i: Pressure, modulus_j: Pressure) -> Pressure:
    """Modulus E = 2 / (1/E_i + 1/E_j) of two surfaces in series; for a rigid partner, twice the modulus of the other
    surface.

    Both surfaces have the same Poisson ratio, which is contained in the prefactors. [johnson1985, eq. 4.18].

    >>> pair_modulus(3.0, 3.0), pair_modulus(3.0, math.inf)
    (3.0, 6.0)
    """
    return 2.0 / (1.0 / modulus_i + 1.0 / modulus_j)


def contact_size(
    reduced_radius: Length, gap: Length, deflection: Length, gap_weight: Number, deflection_weight: Number
) -> Length:
    """A = sqrt(2 R* (c_h h + c_d |delta|)), the radius of film and contact.

    R* is the reduced radius, h the gap, delta the normal deflection of either sign. Poiseuille's limit is delta << h,
    where c_h = 1 gives the rigid spheres' lubrication force; Hertz's is delta >> h, where c_d = 1/2 gives his contact.
    [rognon2009, eq. 14]; [johnson1985, eq. 4.22].

    >>> contact_size(0.5, 0.01, 0.0, 1.0, 0.5)
    0.1
    """
    return math.sqrt(2.0 * reduced_radius * (gap_weight * gap + deflection_weight * abs(deflection)))


def surface_stiffness(contact_size: Length, modulus: Pressure, prefactor: Number) -> Stiffness:
    """Stiffness k = alpha E a: force over deflection of the two surfaces, along the normal or along
    the surface.

    For incompressible spheres both alphas are 8/9: Hertz's F = 4/3 E* a delta, and Mindlin's k_t = 8 G* a.
    [rognon2009, eq. 12 and 13]; [johnson1985, eq. 4.22 and 7.42].

    >>> surface_stiffness(0.1, 50.0, 1.0)
    5.0
    """
    return prefactor * modulus * contact_size


def surface_force(
    compression: Length, *, gap: Length, reduced_radius: Length, modulus: Pressure, prefactors: Prefactors
) -> Force:
    """Normal force F = alpha_n E a delta of a contact; positive repels, and so does a positive compression delta.

    At a constant gap. [rognon2009, eq. 12 to 14].

    >>> surface_force(0.03, gap=0.01, reduced_radius=0.5, modulus=1.0, prefactors=Prefactors())
    0.006
    """
    size = contact_size(reduced_radius, gap, compression, prefactors.gap_weight, prefactors.deflection_weight)
    return surface_stiffness(size, modulus, prefactors.normal) * compression


def surface_energy(
    compression: Length, *, gap: Length, reduced_radius: Length, modulus: Pressure, prefactors: Prefactors
) -> Energy:
    """Energy of the deflection, the integral of `surface_force` at a constant gap; zero without
    deflection.

    U = 2/15 alpha_n E sqrt(2 R* c_h h) delta^2 (3 s^3 + 6 s^2 + 4 s + 2) / (s + 1)^2, where
    s^2 = 1 + c_d |delta| / (c_h h). F delta/2 for a wide gap, Hertz's 2/5 F delta for a narrow one.
    [rognon2009, eq. 12 to 14].

    >>> force = surface_force(0.3, gap=1e-9, reduced_radius=0.5, modulus=1.0, prefactors=Prefactors())
    >>> energy = surface_energy(0.3, gap=1e-9, reduced_radius=0.5, modulus=1.0, prefactors=Prefactors())
    >>> round(energy / (force * 0.3), 6)
    0.4
    """
    film = prefactors.gap_weight * gap
    ratio = prefactors.deflection_weight * abs(compression) / film
    stiffness = prefactors.normal * modulus * math.sqrt(2.0 * reduced_radius * film)
    return bent_energy(compression, stiffness, ratio)


def bent_energy(deflection: Length, stiffness: Stiffness, ratio: Number) -> Energy:
    """Energy U = 2/15 k delta^2 (3 s^3 + 6 s^2 + 4 s + 2) / (s + 1)^2 with s^2 = 1 + ratio, of a
    surface that stiffens.

    k is the stiffness without deflection; at delta it is k sqrt(1 + ratio), with a ratio proportional to |delta|.
    From [rognon2009, eq. 12 to 14].

    >>> bent_energy(2.0, 3.0, 0.0)
    6.0
    """
    root = math.sqrt(1.0 + ratio)
    shape = (((3.0 * root + 6.0) * root + 4.0) * root + 2.0) / (7.5 * (root + 1.0) ** 2)
    return stiffness * deflection**2 * shape


def gap_energy(deflection: Length, stiffness: Stiffness, ratio: Number) -> Energy:
    """Slope h dU/dh of `bent_energy` over the gap, at a constant deflection: k delta^2 (s + 2) / (3 (s + 1)^2).

    A wider film has a wider contact, which is stiffer, without a force on the film: force and gap have no common
    potential, and this is the energy that surfaces gain or lose in addition to the work on them. From [rognon2009, eq.
    12 to
    14].

    >>> gap_energy(2.0, 3.0, 0.0)
    3.0
    """
    root = math.sqrt(1.0 + ratio)
    return stiffness * deflection**2 * (root + 2.0) / (3.0 * (root + 1.0) ** 2)


@dataclass(frozen=True)
class SoftPair:
    """Two soft spheres and the liquid between them."""

    radius: Length
    """of equal spheres; twice the reduced radius of others"""
    modulus: Pressure
    viscosity: Viscosity
    prefactors: Prefactors = PREFACTORS["paper"]


def reduced_force(pair: SoftPair, force: Force) -> Number:
    """Reduced force K = c_d |F| / (alpha_n E R^2); the paper's kappa if the prefactors are 1.
    [rognon2009, eq. 28].

    >>> reduced_force(SoftPair(1.0, 1000.0, 1.0), 1.0)
    0.001
    """
    return pair.prefactors.deflection_weight * abs(force) / (pair.prefactors.normal * pair.modulus * pair.radius**2)


def crossover_gap(pair: SoftPair, force: Force) -> Length:
    """Gap R K^(2/3) / c_h, similar to the deflection: above it is Poiseuille's regime, below it Hertz's. [rognon2009,
    eq. 30].

    >>> round(crossover_gap(SoftPair(1.0, 1000.0, 1.0), 1.0), 12)
    0.01
    """
    return pair.radius * math.cbrt(reduced_force(pair, force)) ** 2 / pair.prefactors.gap_weight


def steepness(pair: SoftPair, gap: Length, force: Force) -> Number:
    """Parameter p of this gap under this force: the root of c_h h = R K^(2/3) p / (1 + p)^(1/3), whose right side
    increases. [rognon2009].

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
    """Contact size a under a force: the root of a^3 - R c_h h a - K R^3 = 0. [rognon2009, eq. 12
    and 14].

    >>> round(size_under_force(SoftPair(1.0, 1000.0, 1.0), 0.01, 1.0), 6)
    0.132472
    """
    return pair.radius * math.cbrt(reduced_force(pair, force) * (1.0 + steepness(pair, gap, force)))


def viscous_time(pair: SoftPair, force: Force) -> Time:
    """Time t_P = c_n c_h^2 eta R^2 / |F| in which a gap grows or shrinks by a factor e in Poiseuille's regime.
    [rognon2009, eq. 31].

    >>> viscous_time(SoftPair(1.0, 1000.0, 1.0), 1.0) == 1.5 * math.pi
    True
    """
    factors = pair.prefactors
    return factors.squeeze * factors.gap_weight**2 * pair.viscosity * pair.radius**2 / abs(force)


def passage_time(pair: SoftPair, force: Force, gap_from: Length, gap_to: Length) -> Time:
    """Time between two gaps under a constant force, with its deflection present from the start.

    t = t_P/3 |2 ln(p1/p0) + 5 (1/p0 - 1/p1) + 3/2 (1/p0^2 - 1/p1^2)|. The exact law behind [rognon2009, eq. 31 to 34]:
    t_P ln(h1/h0) for p >> 1, and (t_P/2) K^(4/3) (R/h0)^2 for p << 1, where a larger force takes longer.

    >>> round(passage_time(SoftPair(1.0, 1000.0, 1.0), 1.0, 0.01, 0.1), 8)
    17.04001231
    """
    for name, gap in (("gap_from", gap_from), ("gap_to", gap_to)):
        require_positive(name, gap)
    start, end = (steepness(pair, gap, force) for gap in (gap_from, gap_to))
    powers = 5.0 * (1.0 / start - 1.0 / end) + 1.5 * (1.0 / start**2 - 1.0 / end**2)
    return viscous_time(pair, force) / 3.0 * abs(2.0 * math.log(end / start) + powers)


def optimal_force(pair: SoftPair, gap: Length) -> Force:
    """Force that changes this gap fastest: F = 2 sqrt(3) (alpha_n/c_d) E R^2 (c_h h/R)^(3/2). Its deflection is 2
    c_h/c_d gaps, and a^2 = 3 R c_h h. From [rognon2009, eq. 10, 12 and 14].

    >>> round(optimal_force(SoftPair(1.0, 1000.0, 1.0), 0.01), 5)
    3.4641
    """
    factors = pair.prefactors
    level = factors.gap_weight * gap / pair.radius
    scale = factors.normal / factors.deflection_weight * pair.modulus * pair.radius**2
    return 2.0 * math.sqrt(3.0) * scale * level * math.sqrt(level)
