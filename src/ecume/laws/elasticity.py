"""The surfaces of two soft spheres: how large a contact is, and how stiffly it is deflected.

The deflection of a contact is that of both surfaces together. All of its force passes through the film and through the
surfaces: they are in series, and share one contact size. A film presses as well as it pulls, so that both signs occur.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from ecume.laws.lubrication import DISC_SHEAR, DISC_SQUEEZE
from ecume.units import Energy, Force, Length, Number, Pressure, Unit

Stiffness = Annotated[float, Unit("N/m")]


class Prefactors(NamedTuple):
    """The numbers that the scaling laws of a contact leave open."""

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
    """E = 2 / (1/E_i + 1/E_j): two surfaces deform in series; a rigid one leaves twice the other's.

    Of equal Poisson ratios, which the prefactors hold. [johnson1985, eq. 4.18].

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
    """K = alpha E a: force over deflection of the two surfaces, along the normal or along the surface.

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

    At a gap that is held. [rognon2009, eq. 12 to 14].

    >>> surface_force(0.03, gap=0.01, reduced_radius=0.5, modulus=1.0, prefactors=Prefactors())
    0.006
    """
    size = contact_size(reduced_radius, gap, compression, prefactors.gap_weight, prefactors.deflection_weight)
    return surface_stiffness(size, modulus, prefactors.normal) * compression


def surface_energy(
    compression: Length, *, gap: Length, reduced_radius: Length, modulus: Pressure, prefactors: Prefactors
) -> Energy:
    """Energy of the deflection, the integral of `surface_force` at a gap that is held; zero without deflection.

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
    """U = 2/15 k delta^2 (3 s^3 + 6 s^2 + 4 s + 2) / (s + 1)^2 with s^2 = 1 + ratio: a surface that stiffens.

    k is its stiffness undeflected; at delta it is k sqrt(1 + ratio), with a ratio that grows in proportion to |delta|.
    From [rognon2009, eq. 12 to 14].

    >>> bent_energy(2.0, 3.0, 0.0)
    6.0
    """
    root = math.sqrt(1.0 + ratio)
    shape = (((3.0 * root + 6.0) * root + 4.0) * root + 2.0) / (7.5 * (root + 1.0) ** 2)
    return stiffness * deflection**2 * shape


def gap_energy(deflection: Length, stiffness: Stiffness, ratio: Number) -> Energy:
    """The slope h dU/dh of `bent_energy` over the gap, at a deflection that is held: k delta^2 (s + 2) / (3 (s + 1)^2).

    A wider film has a wider contact, which is stiffer. The film feels nothing of that: force and gap have no potential
    in common, and this is what surfaces take or give beside the work that is done on them. From [rognon2009, eq. 12 to
    14].

    >>> gap_energy(2.0, 3.0, 0.0)
    3.0
    """
    root = math.sqrt(1.0 + ratio)
    return stiffness * deflection**2 * (root + 2.0) / (3.0 * (root + 1.0) ** 2)
