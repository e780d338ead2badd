"""Rafts of touching particles under compression: their elasticity, the pressure at which they buckle, and the decay of
the pressure between rough walls.

A raft is an elastic plate on the surface of a liquid. With its bending modulus B, the surface pressure Pi and the
weight of the displaced liquid, the energy per area of a wave of wavenumber q is proportional to

    B q^4 + (gamma - Pi) q^2 + rho g,

in which gamma - Pi is the remaining tension. At the onset of buckling, the minimum over q is zero.
"""

from __future__ import annotations

import math
from typing import Annotated

from ecume.laws.arguments import require_not_negative, require_positive
from ecume.laws.flotation import Liquid
from ecume.units import Energy, Length, Number, SurfaceTension, Unit

YoungModulus = Annotated[float, Unit("Pa")]
PACKED = math.pi / math.sqrt(12.0)
"""The area fraction of touching discs on a triangular lattice."""
POISSON = 1.0 / math.sqrt(3.0)
"""Poisson's ratio of a triangular lattice of touching particles [vella2004]."""


def young_modulus(tension: SurfaceTension, diameter: Length) -> YoungModulus:
    """Young's modulus of a raft, E = (1 - nu)/(1 - phi) gamma/d. [vella2004].

    The particles do not deform: stretching a raft increases the area of liquid surface between them.

    >>> round(young_modulus(0.072, 1e-3) / (0.072 / 1e-3), 2)
    4.54
    """
    require_positive("diameter", diameter)
    return (1.0 - POISSON) / (1.0 - PACKED) * tension / diameter


def bending_modulus(tension: SurfaceTension, diameter: Length) -> Energy:
    """The bending modulus of a raft as of a plate with the thickness d, B = E d^3/(12 (1 - nu^2)). [vella2004].

    >>> bending_modulus(0.072, 1e-3) > bending_modulus(0.036, 1e-3)
    True
    """
    return young_modulus(tension, diameter) * diameter**3 / (12.0 * (1.0 - POISSON**2))


def buckling_wavelength(liquid: Liquid, diameter: Length) -> Length:
    """The wavelength at the onset of buckling, 2 pi (B/(rho g))^(1/4) = pi (4/(3 (1 - phi)(1 + nu)))^(1/4) sqrt(L d).
    [vella2004].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> constant = (4.0 / (3.0 * (1.0 - PACKED) * (1.0 + POISSON))) ** 0.25
    >>> closed = math.pi * constant * math.sqrt(water.capillary_length * 1e-3)
    >>> math.isclose(buckling_wavelength(water, 1e-3), closed)
    True
    """
    foundation = liquid.surface_tension / liquid.capillary_length**2
    return 2.0 * math.pi * math.sqrt(math.sqrt(bending_modulus(liquid.surface_tension, diameter) / foundation))


def buckling_pressure(liquid: Liquid, diameter: Length) -> SurfaceTension:
    """The surface pressure at the onset of buckling, gamma + 2 sqrt(B rho g), at which the minimum of the energy over
    the wavenumber is zero. Derived here with the bending modulus of [vella2004].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> 1.0 < buckling_pressure(water, 1e-5) / 0.072 < 1.01
    True
    """
    foundation = liquid.surface_tension / liquid.capillary_length**2
    return liquid.surface_tension + 2.0 * math.sqrt(bending_modulus(liquid.surface_tension, diameter) * foundation)


def pressure_left(distance: Length, width: Length, friction: Number, ratio: Number) -> Number:
    """The part exp(-2 mu k x/W) of the pressure of a barrier that remains at a distance from it between two rough
    walls.

    Each wall carries the friction mu k Pi per length where all contacts slide: k is the pressure on the walls over that
    along the trough. This is Janssen's law of silos without weight, applied to rafts [cicuta2009].

    >>> round(pressure_left(0.1, 0.1, 0.5, 1.0), 6)
    0.367879
    """
    require_positive("width", width)
    require_not_negative("friction", friction)
    return math.exp(-2.0 * friction * ratio * distance / width)
