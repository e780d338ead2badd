"""Liquids by name and temperature: density, viscosity, surface tension and speed of sound at one atmosphere.

Temperatures of water and seawater are in kelvin, and salinity is the mass of salt in a mass of seawater. Fits of other
liquids take degrees Celsius or kelvin.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from ecume.errors import BadInput
from ecume.units import Density, KinematicViscosity, Number, Speed, SurfaceTension, Temperature, Viscosity

ICE_POINT = 273.15
WATER_CRITICAL = 647.096


def water_density(temperature: Temperature) -> Density:
    """Density of water, 0 to 100 degrees Celsius, within 4e-6 to 40 degrees. [kell1975].

    Temperatures are on the scale of 1968, which differs from the present one by 0.026 K at 100 degrees (2e-5 in
    density).

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

    One percent of water reduces it by a fifth.

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


ROOM_CELSIUS = 293.15
"""The temperature (K) for tabulated properties of kitchen liquids."""


def line(source: str, at_room: float, slope: float) -> Callable[[float], float]:
    """A property that changes linearly around 20 degrees Celsius, as a function of temperature with
    its source.

    >>> round(line("walstra2006", 1029.0, -0.3)(303.15), 1)
    1026.0
    """

    def value(temperature: Temperature) -> float:
        return at_room + slope * (temperature - ROOM_CELSIUS)

    value.__doc__ = f"A typical value at 20 degrees Celsius, linear around it. [{source}]."
    return value


def andrade(source: str, at_room: float, activation: float) -> Callable[[float], float]:
    """A viscosity as exp(A/T) around 20 degrees Celsius, as a function of temperature with its
    source.

    >>> round(andrade("white1975", 12.6, 10400.0)(298.15), 1)
    7.0
    """

    def value(temperature: Temperature) -> float:
        return at_room * math.exp(activation * (1.0 / temperature - 1.0 / ROOM_CELSIUS))

    value.__doc__ = f"A typical viscosity at 20 degrees Celsius, exp(A/T) around it. [{source}]."
    return value


def milk_surface_tension(temperature: Temperature) -> SurfaceTension:
    """Surface tension of whole and skim milk, 18 to 135 degrees Celsius, with a residual of 2.1 mN/m. [bertsch1983].

    >>> round(milk_surface_tension(293.15) * 1e3, 1)
    52.4
    """
    t = temperature - ICE_POINT
    return 1e-3 * (55.6 + t * (-0.163 + 1.8e-4 * t))


STANDARD_SALINITY = 0.035
SALINITIES = 0.025, 0.040
"""The range in which all correlations for seawater are valid."""


@dataclass(frozen=True)
class LiquidProperties:
    """The properties of a liquid at a temperature, in SI units."""

    name: str
    temperature: Temperature
    density: Density
    viscosity: Viscosity
    surface_tension: SurfaceTension
    """of a clean surface against air"""
    sound_speed: Speed
    """the real one; SPH uses a much smaller one"""

    @property
    def kinematic_viscosity(self) -> KinematicViscosity:
        """Viscosity over density."""
        return self.viscosity / self.density


class Correlations(NamedTuple):
    """The properties of a liquid as functions of temperature, and their common range of validity."""

    coldest: Temperature
    hottest: Temperature
    density: Callable[[float], float]
    viscosity: Callable[[float], float]
    surface_tension: Callable[[float], float]
    sound_speed: Callable[[float], float]


def liquid(name: str, temperature: Temperature, salinity: Number | None = None) -> LiquidProperties:
    """The properties of a liquid at a temperature in kelvin; salinity (kg of salt per kg) is for seawater only.

    >>> round(liquid("water", 293.15).density, 1)
    998.2
    """
    if name not in LIQUIDS:
        close = difflib.get_close_matches(str(name), LIQUIDS, n=1)
        guess = f"; did you mean {close[0]!r}?" if close else ""
        raise BadInput(f"no liquid is called {name!r}{guess} There are {', '.join(LIQUIDS)}")
    row = _seawater(salinity) if name == "seawater" else LIQUIDS[name]
    if salinity is not None and name != "seawater":
        raise BadInput(f"{name} has no salinity; omit it, or choose seawater")
    _require_range(name, temperature, row)
    return LiquidProperties(
        name,
        temperature,
        row.density(temperature),
        row.viscosity(temperature),
        row.surface_tension(temperature),
        row.sound_speed(temperature),
    )


def _require_range(name: str, temperature: float, row: Correlations) -> None:
    if row.coldest <= temperature <= row.hottest:
        return
    celsius = row.coldest <= temperature + ICE_POINT <= row.hottest
    guess = f"; did you mean {temperature + ICE_POINT:g} K, {temperature:g} degrees Celsius?" if celsius else ""
    raise BadInput(
        f"the temperature of {name} is {temperature!r} K; its properties are known from {row.coldest:g} to "
        f"{row.hottest:g} K ({row.coldest - ICE_POINT:.4g} to {row.hottest - ICE_POINT:.4g} degrees Celsius){guess}"
    )


def _seawater(salinity: float | None) -> Correlations:
    s = STANDARD_SALINITY if salinity is None else salinity
    if not (SALINITIES[0] <= s <= SALINITIES[1] and math.isfinite(s)):
        grams = SALINITIES[0] <= 1e-3 * s <= SALINITIES[1]
        hint = f"; did you mean {1e-3 * s:g}, {s:g} grams a kilogram?" if grams else ""
        raise BadInput(
            f"the salinity is {s!r}; expected {SALINITIES[0]:g} to {SALINITIES[1]:g} kg of salt per kg{hint}"
        )
    return Correlations(
        275.15,
        303.15,
        partial(seawater_density, salinity=s),
        partial(seawater_viscosity, salinity=s),
        partial(seawater_surface_tension, salinity=s),
        partial(seawater_sound_speed, salinity=s),
    )


LIQUIDS: dict[str, Correlations] = {
    "water": Correlations(
        273.15, 373.12,
        water_density, water_viscosity, water_surface_tension, water_sound_speed,
    ),
    "seawater": _seawater(None),
    "ethanol": Correlations(
        273.15, 333.15,
        ethanol_density, ethanol_viscosity, ethanol_surface_tension, ethanol_sound_speed,
    ),
    "glycerol": Correlations(
        291.15, 323.15,
        glycerol_density, glycerol_viscosity,
        glycerol_surface_tension, glycerol_sound_speed,
    ),
    "mercury": Correlations(
        293.15, 323.15,
        mercury_density, mercury_viscosity, mercury_surface_tension, mercury_sound_speed,
    ),
    # Kitchen liquids: typical values; products differ by 5 % in density and tension, and by more in viscosity.
    "milk": Correlations(
        278.15, 313.15,
        line("walstra2006", 1029.0, -0.37), andrade("walstra2006", 2.1e-3, 2060.0),
        milk_surface_tension, line("walstra2006", 1510.0, 2.3),
    ),
    "soapy water": Correlations(
        283.15, 313.15,  # with sodium dodecyl sulfate above the concentration at which micelles form
        line("elworthy1966", 999.0, -0.25), andrade("elworthy1966", 1.05e-3, 2000.0),
        line("elworthy1966", 0.039, -1e-4), line("bilaniuk1993", 1483.0, 2.9),
    ),
    "olive oil": Correlations(
        283.15, 313.15,
        line("coupland1997", 913.0, -0.66), andrade("coupland1997", 0.082, 3600.0),
        line("sahasrabudhe2017", 0.0322, -7e-5), line("coupland1997", 1465.0, -3.2),
    ),
    "sunflower oil": Correlations(
        283.15, 313.15,
        line("coupland1997", 919.0, -0.66), andrade("coupland1997", 0.063, 3300.0),
        line("sahasrabudhe2017", 0.0330, -7e-5), line("coupland1997", 1470.0, -3.2),
    ),
    "honey": Correlations(
        283.15, 313.15,  # with 17 % of water; with 20 % its viscosity is a third
        line("white1975", 1420.0, -0.6), andrade("white1975", 12.6, 10400.0),
        line("white1975", 0.056, -1e-4), line("white1975", 2000.0, -2.0),
    ),
    "coffee": Correlations(
        283.15, 313.15,
        line("ferrari2007", 1002.0, -0.25), andrade("ferrari2007", 1.07e-3, 2000.0),
        line("ferrari2007", 0.050, -1.5e-4), line("bilaniuk1993", 1485.0, 2.9),
    ),
    "syrup": Correlations(
        283.15, 313.15,  # sucrose and water, 60 to 40 by mass
        line("crc2016", 1286.0, -0.5), andrade("crc2016", 0.0585, 4650.0),
        line("crc2016", 0.0765, -1.2e-4), line("crc2016", 1790.0, -0.5),
    ),
}  # fmt: skip
"""The correlations of liquids by name, each with the temperature range in which all four properties are known."""
