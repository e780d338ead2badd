"""The film of liquid between two soft spheres: the friction of squeezing it, and of shearing it.

A film is a disc of thickness h, the gap, and of radius a, the contact size, which it shares with the deflected
surfaces (`ecume.laws.elasticity`).
"""

from __future__ import annotations

import math

from ecume.units import Force, Friction, Length, Number, Speed, Viscosity

DISC_SQUEEZE, DISC_SHEAR = 1.5 * math.pi, math.pi
"""The prefactors of two parallel discs: Stefan's squeeze, Couette's shear."""


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

    Couette flow between discs of radius a, a gap h apart. Two rigid spheres slide against pi eta R ln(R/h): the model
    drops the logarithm, a factor of 7 at h = R/1000. [rognon2009, eq. 11].

    >>> shear_friction(0.1, 0.01, 1.0) == math.pi * 0.1**2 / 0.01
    True
    """
    return prefactor * viscosity * contact_size**2 / gap


ENTRAINMENT = 0.75
"""The prefactor of `entrained_force` for which it is the published law."""


def entrained_force(speed: Speed, compression: Force, contact_size: Length, viscosity: Viscosity) -> Force:
    """Elastohydrodynamic force T = sqrt(3/4 eta u N a) between soft surfaces that slide along each other.

    u is the sliding speed, N the compressive force, a the contact size. Sliding draws liquid into the contact until
    the pressure that it builds up there balances that of the surfaces: eta u a/h^2 ~ N/a^2. With this film thickness h,
    `shear_friction` gives T ~ eta u a^2/h, the square root. The prefactor is that of soft particle glasses, T =
    sqrt(eta u C E* R*^3) eps^((2n + 1)/4) for an elastic force N = 4/3 C E* R*^2 eps^n at the overlap eps R*, with
    a^2 = R*^2 eps; for Hertz's contact n = 3/2 and C = 1. [seth2011]; restated from the literature, without the text
    of the paper at hand: overlaps refer to R*, since the elastic law is Hertz's only then.

    >>> modulus, radius, overlap = 3.0, 0.5, 0.04
    >>> load = 4 / 3 * modulus * radius**2 * overlap**1.5
    >>> found = entrained_force(2.0, load, radius * math.sqrt(overlap), 7.0)
    >>> round(found / (math.sqrt(7.0 * 2.0 * modulus * radius**3) * overlap), 12)
    1.0
    """
    return math.sqrt(ENTRAINMENT * viscosity * speed * compression * contact_size)
