"""Equations of state in other forms, the color of a surface, and the constant of Smagorinsky's model."""

from __future__ import annotations

import math

from ecume.laws.states import WATER_EXPONENT, Densities, Pressures, Speeds, power
from ecume.units import Density, Number, Speed, Value


def tait_sound_speed(
    density: Densities[Value], reference_density: Density, sound_speed: Speed, exponent: Number = WATER_EXPONENT
) -> Speeds[Value]:
    """Sound speed at a density, c = c_0 (rho/rho_0)^((gamma-1)/2), from c^2 = dp/drho. [monaghan1994].

    >>> tait_sound_speed(1000.0, 1000.0, 10.0)
    10.0
    """
    return sound_speed * power(density / reference_density, 0.5 * (exponent - 1.0))


def linear_pressure(density: Densities[Value], reference_density: Density, sound_speed: Speed) -> Pressures[Value]:
    """Gauge pressure p = c_0^2 (rho - rho_0): Tait with the exponent 1, preferred at low Reynolds numbers.

    [morris1997].

    >>> linear_pressure(1010.0, 1000.0, 10.0)
    1000.0
    """
    return sound_speed * sound_speed * (density - reference_density)


def linear_density(pressure: Pressures[Value], reference_density: Density, sound_speed: Speed) -> Densities[Value]:
    """The density rho_0 + p/c_0^2 that has a gauge pressure under the linear law. [morris1997].

    >>> linear_density(1000.0, 1000.0, 10.0)
    1010.0
    """
    return reference_density + pressure / (sound_speed * sound_speed)


def surface_share(color: Number) -> Number:
    """Psi(c) = int_0^c psi = 6c^2 - 8c^3 + 3c^4: the energy, in sigmas, of a plane between the colors 0 and c.

    A solid of the color c_s has Psi(c_s) against the gas and 1 - Psi(c_s) against the liquid; so a surface meets it at
    the angle with cos(theta) = 2 Psi(c_s) - 1 (Young's law). [brackbill1992, young1805].

    >>> surface_share(0.0), surface_share(1.0)
    (0.0, 1.0)
    """
    return color * color * (6.0 + color * (-8.0 + 3.0 * color))


def inertial_range_coefficient(kolmogorov: Number = 1.5) -> Number:
    """Lilly's C_s = (1/pi) (2 / (3 C_K))^(3/4) from a spectrum C_K eps^(2/3) k^(-5/3). [lilly1967].

    >>> round(inertial_range_coefficient(), 3)
    0.173
    """
    return math.pow(2.0 / (3.0 * kolmogorov), 0.75) / math.pi
