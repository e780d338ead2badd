"""Equations of state of weakly compressible liquids: pressure, density and enthalpy.

`tait_pressure` and `tait_density` are Tait's law and its inverse. Pressures are gauge pressures, zero at the reference
density. The hydrostatic part is rho_0 g (H - y); in a liquid with weight the equation of state includes that part
already, and adding it would count it twice: see `absolute_pressure`.

The enthalpy h is the integral of dp/rho. At rest it balances the potential of gravity exactly, grad h = g: in a
compressible column it is linear in the height, for any exponent of Tait's law. Density diffusion of h - g . x does not
change a liquid at rest.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from ecume.units import Acceleration, Density, Length, Number, Pressure, Real, Speed, Unit, Value

WATER_EXPONENT = 7.0
Densities = Annotated[Value, Unit("kg/m^3")]
Pressures = Annotated[Value, Unit("Pa")]
Speeds = Annotated[Value, Unit("m/s")]
Pure = Annotated[Value, Unit("1")]


def power(ratio: Pure[Value], exponent: Number) -> Pure[Value]:
    """Power x^a, by products for the exponents of water in Tait's law, 7, and in the enthalpy, 6:
    ten times as fast.

    Within three units in the last place of the general one. [monaghan1994].

    >>> power(2.0, 7.0), power(2.0, 6.0), power(4.0, 0.5)
    (128.0, 64.0, 2.0)
    """
    if exponent == 7.0 or exponent == 6.0:  # a tuple of exponents would be compiled
        cube = ratio * ratio * ratio
        return cube * cube * ratio if exponent == 7.0 else cube * cube
    general: Value = ratio**exponent
    return general


def tait_pressure(
    density: Densities[Value], reference_density: Density, sound_speed: Speed, exponent: Number = WATER_EXPONENT
) -> Pressures[Value]:
    """Gauge pressure p = b ((rho/rho_0)^gamma - 1), b = rho_0 c_0^2 / gamma; positive when compressed.

    rho_0: reference_density; c_0: sound_speed at rho_0; gamma: exponent, 7 for water, 1 for the linear law.
    [monaghan1994], after [cole1948]. Texts that print (rho/rho_0) gamma - 1 have a misprint: its pressure at rest is b
    (gamma - 1). Some call it absolute: it is zero at rho_0, and therefore a gauge pressure.

    >>> round(tait_pressure(1010.0, 1000.0, 10.0, 7.0), 6)
    1030.50503
    """
    stiff = reference_density * sound_speed * sound_speed / exponent
    return stiff * (power(density / reference_density, exponent) - 1.0)


def tait_density(
    pressure: Pressures[Value], reference_density: Density, sound_speed: Speed, exponent: Number = WATER_EXPONENT
) -> Densities[Value]:
    """Density rho = rho_0 (1 + p/b)^(1/gamma) at a gauge pressure; the inverse of `tait_pressure`.

    It holds for p > -b, the limit of tension. [monaghan1994].

    >>> round(tait_density(tait_pressure(1010.0, 1000.0, 10.0), 1000.0, 10.0), 9)
    1010.0
    """
    stiff = reference_density * sound_speed * sound_speed / exponent
    root: Value = (1.0 + pressure / stiff) ** (1.0 / exponent)
    return reference_density * root


def stiffness(reference_density: Density, sound_speed: Speed, exponent: Number = WATER_EXPONENT) -> Pressure:
    """Stiffness b = rho_0 c_0^2 / gamma of Tait's law. [monaghan1994].

    >>> stiffness(1000.0, 14.0, 7.0)
    28000.0
    """
    return reference_density * sound_speed * sound_speed / exponent


def speed_of_stiffness(stiff: Pressure, reference_density: Density, exponent: Number = WATER_EXPONENT) -> Speed:
    """Sound speed c_0 = sqrt(gamma b / rho_0) at the reference density. [monaghan1994].

    >>> speed_of_stiffness(28000.0, 1000.0, 7.0)
    14.0
    """
    return math.sqrt(exponent * stiff / reference_density)


def numerical_sound_speed(depth: Length, largest_speed: Speed, gravity: Acceleration) -> Speed:
    """Sound speed 10 max(sqrt(g H), u) that keeps changes of density below 1 %. [monaghan1994].

    Such a low sound speed permits long time steps, and the effect of compressibility on the flow remains small: the
    change of density is the square of the Mach number. A column of the depth H is 0.49 % shorter than H.

    >>> numerical_sound_speed(1.0, 2.0, 9.0)
    30.0
    """
    return 10.0 * max(math.sqrt(gravity * depth), largest_speed)


SpecificEnergy = Annotated[float, Unit("m^2/s^2")]
SpecificEnergies = Annotated[Real, Unit("m^2/s^2")]
RealDensities = Annotated[Real, Unit("kg/m^3")]


def tait_enthalpy(density: Density, reference_density: Density, sound_speed: Speed, exponent: Number) -> SpecificEnergy:
    """Enthalpy h = c0^2/(gamma-1) [(rho/rho0)^(gamma-1) - 1], positive where the liquid is compressed; c0^2
    ln(rho/rho0) for gamma = 1. The integral of dp/rho over Tait's pressure [cole1948].

    >>> round(tait_enthalpy(1010.0, 1000.0, 10.0, 1.0), 6)
    0.995033
    """
    ratio = density / reference_density
    square = sound_speed * sound_speed
    if exponent == 1.0:
        return square * math.log(ratio)
    return square / (exponent - 1.0) * (power(ratio, exponent - 1.0) - 1.0)


def density_at_enthalpy(
    enthalpy: SpecificEnergy, reference_density: Density, sound_speed: Speed, exponent: Number
) -> Density:
    """Density rho = rho0 [1 + (gamma-1) h/c0^2]^(1/(gamma-1)), the inverse of `tait_enthalpy`; rho0 exp(h/c0^2) for
    gamma = 1. Below h = -c0^2/(gamma-1) there is no liquid, and the density is zero.

    >>> round(density_at_enthalpy(tait_enthalpy(1010.0, 1e3, 10.0, 7.0), 1e3, 10.0, 7.0), 9)
    1010.0
    """
    scaled = enthalpy / (sound_speed * sound_speed)
    if exponent == 1.0:
        return reference_density * math.exp(scaled)
    inside = max(1.0 + (exponent - 1.0) * scaled, 0.0)
    return float(reference_density * inside ** (1.0 / (exponent - 1.0)))


def tait_energy(
    density: RealDensities, reference_density: Density, sound_speed: Speed, exponent: Number
) -> SpecificEnergies:
    """Energy of compression per mass, e = integral of p/rho^2 drho from rho0, with the gauge pressure; never negative.

    e = c0^2/gamma [(x^(gamma-1) - 1)/(gamma-1) + 1/x - 1] with x = rho/rho0; c0^2 (ln x + 1/x - 1) for gamma = 1; about
    (c0^2/2)(x - 1)^2. From Tait's equation [cole1948].

    >>> round(float(tait_energy(1010.0, 1000.0, 10.0, 7.0)) / 0.005, 3)
    1.007
    """
    ratio = density / reference_density
    square = sound_speed * sound_speed
    if exponent == 1.0:
        return square * (np.log(ratio) + 1.0 / ratio - 1.0)
    return square / exponent * ((ratio ** (exponent - 1.0) - 1.0) / (exponent - 1.0) + 1.0 / ratio - 1.0)
