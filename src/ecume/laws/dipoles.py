"""Forces between magnets that stand upright in a liquid surface: they repel across millimeters, beyond menisci's reach.

An electric dipole p in the gas acts as a moment c p, with c the speed of light.
"""

from __future__ import annotations

import math
from typing import Annotated

from ecume.units import Energy, Force, Length, Number, Unit

Moment = Annotated[float, Unit("A*m^2")]
DipoleStrength = Annotated[float, Unit("J*m^3")]
FluxDensity = Annotated[float, Unit("T")]

PERMEABILITY = 1.25663706127e-6
"""N/A^2, of the vacuum; liquids that are no magnets change it by 1e-5."""


def dipole_strength(moment_i: Moment, moment_j: Moment) -> DipoleStrength:
    """mu_0 m_i m_j / (4 pi), with m the moments along the vertical: positive (repulsive) for moments of one direction.
    [jackson1999, par. 5.7].

    >>> round(dipole_strength(1.0, -1.0) * 1e7, 6)
    -1.0
    """
    return PERMEABILITY * moment_i * moment_j / (4.0 * math.pi)


def dipole_energy(distance: Length, strength: DipoleStrength) -> Energy:
    """Energy of two moments across their plane, zero when far apart: E = C / l^3, C the `dipole_strength`.

    For magnets much smaller than their distance, or homogeneous spheres at any. [jackson1999, par. 5.7].

    >>> dipole_energy(2.0, 4.0)
    0.5
    """
    return strength / distance**3


def dipole_force(distance: Length, strength: DipoleStrength) -> Force:
    """Force between them along the line of centers; positive repels: F = 3 C / l^4. [jackson1999, par. 5.7].

    >>> dipole_force(2.0, 16.0)
    3.0
    """
    return 3.0 * strength / distance**4


def oblique_dipole_energy(distance: Length, product: DipoleStrength, along: DipoleStrength) -> Energy:
    """Energy of two moments of any directions: E = (P - 3 A)/l^3 with P = mu_0 m_i.m_j/(4 pi) and
    A = mu_0 (m_i.n)(m_j.n)/(4 pi), where n is the direction from one to the other. [jackson1999, par. 5.7].

    Along the line of centers two moments attract twice as strongly as they repel across it.

    >>> oblique_dipole_energy(1.0, 1.0, 0.0), oblique_dipole_energy(1.0, 1.0, 1.0)
    (1.0, -2.0)
    """
    return (product - 3.0 * along) / distance**3


def induced_moment(radius: Length, susceptibility: Number, field: FluxDensity) -> Moment:
    """The moment of a sphere in a field: m = V chi_e B/mu_0, chi_e = 3 chi/(3 + chi), with the demagnetizing factor 1/3
    of a sphere; at most 3 for soft iron. [jackson1999, par. 5.11].

    >>> round(induced_moment(1e-3, 1e9, 1e-3) * 1e6, 3)
    10.0
    """
    volume = 4.0 / 3.0 * math.pi * radius**3
    return volume * 3.0 * susceptibility / (3.0 + susceptibility) * field / PERMEABILITY


def neglected_dipoles(cutoff: Number) -> Number:
    """Share of the force on the edge of a half-plane of magnets that pairs beyond the cutoff would give: 1/c^2.

    The cutoff is over the touching distance: int_c^inf r^-4 r dr over the same from one on. [jackson1999, par. 5.7].

    >>> neglected_dipoles(10.0)
    0.01
    """
    return 1.0 / (cutoff * cutoff)
