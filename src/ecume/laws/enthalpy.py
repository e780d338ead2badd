"""The enthalpy of a Tait liquid: what gravity's potential balances at rest, exactly.

A column at rest obeys grad h = g, with h the integral of dp/rho; in this quantity a compressible column is a straight
line, whatever Tait's exponent. Density diffusion that acts on its difference less g . x leaves a liquid at rest alone.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from ecume.laws.states import power
from ecume.units import Density, Number, Real, Speed, Unit

SpecificEnergy = Annotated[float, Unit("m^2/s^2")]
SpecificEnergies = Annotated[Real, Unit("m^2/s^2")]
Densities = Annotated[Real, Unit("kg/m^3")]


def tait_enthalpy(density: Density, reference_density: Density, sound_speed: Speed, exponent: Number) -> SpecificEnergy:
    """H = c0^2/(gamma-1) [(rho/rho0)^(gamma-1) - 1], positive where the liquid is compressed; c0^2 ln(rho/rho0) for
    gamma = 1. The integral of dp/rho over Tait's pressure [cole1948].

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
    """Rho = rho0 [1 + (gamma-1) h/c0^2]^(1/(gamma-1)), the inverse of `tait_enthalpy`; rho0 exp(h/c0^2) for gamma = 1.
    Below h = -c0^2/(gamma-1) there is no liquid, and the density is zero.

    >>> round(density_at_enthalpy(tait_enthalpy(1010.0, 1e3, 10.0, 7.0), 1e3, 10.0, 7.0), 9)
    1010.0
    """
    scaled = enthalpy / (sound_speed * sound_speed)
    if exponent == 1.0:
        return reference_density * math.exp(scaled)
    inside = max(1.0 + (exponent - 1.0) * scaled, 0.0)
    return float(reference_density * inside ** (1.0 / (exponent - 1.0)))


def tait_energy(
    density: Densities, reference_density: Density, sound_speed: Speed, exponent: Number
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
