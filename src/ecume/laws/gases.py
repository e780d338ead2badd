"""Gases: density, viscosity and mean free path at one atmosphere, over temperature."""

from __future__ import annotations

import math
from typing import Annotated

from ecume.units import Density, Length, Unit, Viscosity

Temperature = Annotated[float, Unit("K")]
Pressure = Annotated[float, Unit("Pa")]
ATMOSPHERE: Pressure = 101325.0
GAS_CONSTANT = 8.31446261815324
"""J/(mol K)"""
MOLAR_MASS_OF_AIR = 0.0289644
"""kg/mol, dry"""
DENSEST = 20.0
"""kg/m^3: denser media are liquids, or gases under pressure."""


def air_density(temperature: Temperature) -> Density:
    """Density of dry air at one atmosphere, p M/(R T): an ideal gas. [ussa1976].

    >>> round(air_density(293.15), 3)
    1.204
    """
    return ATMOSPHERE * MOLAR_MASS_OF_AIR / (GAS_CONSTANT * temperature)


def air_viscosity(temperature: Temperature) -> Viscosity:
    """Viscosity of air by Sutherland's law, 1.458e-6 T^(3/2)/(T + 110.4 K); from 100 to 1900 K.
    [ussa1976].

    >>> round(air_viscosity(293.15) * 1e6, 2)
    18.13
    """
    return 1.458e-6 * temperature * math.sqrt(temperature) / (temperature + 110.4)


def mean_free_path(density: Density, viscosity: Viscosity, pressure: Pressure) -> Length:
    """Mean free path of a gas, sqrt(pi/8) eta/(0.4987445 sqrt(rho p)). [jennings1988].

    >>> round(mean_free_path(air_density(293.15), air_viscosity(293.15), ATMOSPHERE) * 1e9, 1)
    65.2
    """
    return math.sqrt(math.pi / 8.0) * viscosity / (0.4987445 * math.sqrt(density * pressure))
