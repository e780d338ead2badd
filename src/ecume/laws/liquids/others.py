"""Liquids besides water, at one atmosphere: short fits in the temperature t, in degrees Celsius or kelvin."""

from __future__ import annotations

import math

from ecume.laws.liquids.water import ICE_POINT
from ecume.units import Density, Speed, SurfaceTension, Temperature, Viscosity


def ethanol_density(temperature: Temperature) -> Density:
    """Density of ethanol, 0 to 60 degrees Celsius: a parabola through [schroeder2014], within 0.006 %.

    >>> round(ethanol_density(298.15), 1)
    785.2
    """
    t = temperature - ICE_POINT
    return 806.36 - t * (0.83167 + 6.565e-4 * t)


def ethanol_viscosity(temperature: Temperature) -> Viscosity:
    """Viscosity of ethanol, -70 to 160 degrees Celsius, within some percent. [perry2008, table 2-313].

    >>> round(ethanol_viscosity(298.15) * 1e3, 2)
    1.08
    """
    return math.exp(7.875 + 781.98 / temperature - 3.0418 * math.log(temperature))


def ethanol_surface_tension(temperature: Temperature) -> SurfaceTension:
    """Surface tension of ethanol, 10 to 70 degrees Celsius. [jasper1972].

    >>> round(ethanol_surface_tension(298.15) * 1e3, 2)
    21.97
    """
    return 1e-3 * (24.05 - 0.0832 * (temperature - ICE_POINT))


def ethanol_sound_speed(temperature: Temperature) -> Speed:
    """Speed of sound in ethanol, 0 to 60 degrees Celsius: a parabola through [schroeder2014], within 0.03 %.

    >>> round(ethanol_sound_speed(293.15))
    1159
    """
    t = temperature - ICE_POINT
    return 1228.47 - t * (3.55007 - 3.34e-3 * t)


def glycerol_density(temperature: Temperature) -> Density:
    """Density of glycerol, 17 to 100 degrees Celsius. [cheng2008].

    >>> round(glycerol_density(293.15), 2)
    1263.92
    """
    return 1277.0 - 0.654 * (temperature - ICE_POINT)


def glycerol_viscosity(temperature: Temperature) -> Viscosity:
    """Viscosity of glycerol without any water, 0 to 100 degrees Celsius, within some percent. [cheng2008].

    One percent of water makes it a fifth thinner.

    >>> round(glycerol_viscosity(293.15), 3)
    1.414
    """
    t = temperature - ICE_POINT
    return 12.1 * math.exp((t - 1233.0) * t / (9900.0 + 70.0 * t))


def glycerol_surface_tension(temperature: Temperature) -> SurfaceTension:
    """Surface tension of glycerol, 18 degrees Celsius and more. [vdi2010].

    >>> round(glycerol_surface_tension(298.15) * 1e3, 1)
    63.6
    """
    return 0.09019 * math.pow(1.0 - temperature / 850.05, 0.80707)


def glycerol_sound_speed(temperature: Temperature) -> Speed:
    """Speed of sound in glycerol, near 25 degrees Celsius. [crc2016].

    >>> glycerol_sound_speed(298.15)
    1904.0
    """
    return 1904.0 - 2.2 * (temperature - ICE_POINT - 25.0)


def mercury_density(temperature: Temperature) -> Density:
    """Density of mercury, 0 to 300 degrees Celsius, within 1e-5. [beattie1941].

    >>> round(mercury_density(293.15), 2)
    13545.88
    """
    t = temperature - ICE_POINT
    return 13595.08 / (1.0 + 1e-8 * t * (18144.01 + t * (0.7016 + t * (2.8625e-3 + 2.617e-6 * t))))


def mercury_viscosity(temperature: Temperature) -> Viscosity:
    """Viscosity of mercury, 17 to 107 degrees Celsius. [viswanath2007].

    >>> round(mercury_viscosity(298.15) * 1e3, 3)
    1.526
    """
    return 1e-3 * math.pow(10.0, -0.1105 + 51.209 / (temperature - 124.04))


def mercury_surface_tension(temperature: Temperature) -> SurfaceTension:
    """Surface tension of mercury, 5 to 200 degrees Celsius. [jasper1972].

    >>> round(mercury_surface_tension(298.15) * 1e3, 2)
    485.48
    """
    return 1e-3 * (490.6 - 0.2049 * (temperature - ICE_POINT))


def mercury_sound_speed(temperature: Temperature) -> Speed:
    """Speed of sound in mercury, 20 to 50 degrees Celsius. [crc2016].

    >>> mercury_sound_speed(298.15)
    1450.0
    """
    return 1450.0 - 0.46 * (temperature - ICE_POINT - 25.0)
