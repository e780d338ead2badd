"""Water and seawater at one atmosphere. Temperatures in kelvin; salinity is the mass of salt in a mass of seawater."""

from __future__ import annotations

import math

from ecume.units import Density, Number, Speed, SurfaceTension, Temperature, Viscosity

ICE_POINT = 273.15
WATER_CRITICAL = 647.096


def water_density(temperature: Temperature) -> Density:
    """Density of water, 0 to 100 degrees Celsius, within 4e-6 to 40 degrees. [kell1975].

    Its temperatures are on the scale of 1968, which at 100 degrees is 0.026 K and 2e-5 off today's.

    >>> round(water_density(298.15), 3)
    997.045
    """
    t = temperature - ICE_POINT
    falling = t * (-7.9870401e-3 + t * (-46.170461e-6 + t * (105.56302e-9 - 280.54253e-12 * t)))
    return (999.83952 + t * (16.945176 + falling)) / (1.0 + 16.879850e-3 * t)


def water_viscosity(temperature: Temperature) -> Viscosity:
    """Viscosity of water at 0.1 MPa, -20 to 110 degrees Celsius, within 1 % (0.2 % near 20). [patek2009].

    >>> round(water_viscosity(298.15) * 1e3, 4)
    0.89
    """
    ratio = temperature / 300.0
    terms = ((280.68, -1.9), (511.45, -7.7), (61.131, -19.6), (0.45903, -40.0))
    return 1e-6 * sum(weight * math.pow(ratio, power) for weight, power in terms)


def water_surface_tension(temperature: Temperature) -> SurfaceTension:
    """Surface tension of clean water, 0 degrees Celsius to the critical point, within 0.5 %. [iapws2014].

    >>> round(water_surface_tension(293.15) * 1e3, 2)
    72.74
    """
    below = 1.0 - temperature / WATER_CRITICAL
    return 235.8e-3 * math.pow(below, 1.256) * (1.0 - 0.625 * below)


def water_sound_speed(temperature: Temperature) -> Speed:
    """Speed of sound in water, 0 to 100 degrees Celsius, within 0.1 m/s. [bilaniuk1993].

    >>> round(water_sound_speed(293.15), 1)
    1482.4
    """
    t = temperature - ICE_POINT
    tail = t * (3.34638117e-4 + t * (-1.48259672e-6 + t * 3.16585020e-9))
    return 1402.38744 + t * (5.03836171 + t * (-5.81172916e-2 + tail))


def seawater_density(temperature: Temperature, salinity: Number) -> Density:
    """Density of seawater, -2 to 40 degrees Celsius, salinity up to 0.042, within 4e-6. [millero1981].

    >>> round(seawater_density(278.15, 0.035), 5)
    1027.67547
    """
    t, s = temperature - ICE_POINT, 1e3 * salinity
    tail = t * (1.001685e-4 + t * (-1.120083e-6 + t * 6.536332e-9))
    pure = 999.842594 + t * (6.793952e-2 + t * (-9.095290e-3 + tail))
    linear = 8.24493e-1 + t * (-4.0899e-3 + t * (7.6438e-5 + t * (-8.2467e-7 + t * 5.3875e-9)))
    rooted = -5.72466e-3 + t * (1.0227e-4 - t * 1.6546e-6)
    return pure + s * (linear + rooted * math.sqrt(s) + 4.8314e-4 * s)


def seawater_viscosity(temperature: Temperature, salinity: Number) -> Viscosity:
    """Viscosity of seawater, 0 to 100 degrees Celsius, salinity up to 0.15, within 1.5 %. [sharqawy2010].

    >>> seawater_viscosity(293.15, 0.0) == water_viscosity(293.15)
    True
    """
    t = temperature - ICE_POINT
    linear = 1.541 + t * (1.998e-2 - 9.52e-5 * t)
    squared = 7.974 + t * (-7.561e-2 + 4.724e-4 * t)
    return water_viscosity(temperature) * (1.0 + salinity * (linear + salinity * squared))


def seawater_surface_tension(temperature: Temperature, salinity: Number) -> SurfaceTension:
    """Surface tension of clean seawater, 0 to 92 degrees Celsius, salinity up to 0.131, within 0.3 %. [nayar2014].

    >>> seawater_surface_tension(293.15, 0.035) > water_surface_tension(293.15)
    True
    """
    t, s = temperature - ICE_POINT, 1e3 * salinity
    return water_surface_tension(temperature) * (1.0 + s * (3.766e-4 + 2.347e-6 * t))


def seawater_sound_speed(temperature: Temperature, salinity: Number) -> Speed:
    """Speed of sound at the surface of the sea, 2 to 30 degrees Celsius, salinity 0.025 to 0.040. [mackenzie1981].

    >>> round(seawater_sound_speed(298.15, 0.035), 3)
    1534.294
    """
    t, s = temperature - ICE_POINT, 1e3 * salinity
    fresh = 1448.96 + t * (4.591 + t * (-5.304e-2 + 2.374e-4 * t))
    return fresh + (s - 35.0) * (1.340 - 1.025e-2 * t)
