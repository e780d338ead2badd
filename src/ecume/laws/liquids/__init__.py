"""Liquids by name and temperature: density, viscosity, surface tension and speed of sound at one atmosphere."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

from ecume.errors import BadInput
from ecume.laws.liquids import others, water
from ecume.laws.liquids.water import ICE_POINT
from ecume.units import Density, KinematicViscosity, Number, Speed, SurfaceTension, Temperature, Viscosity

STANDARD_SALINITY = 0.035
SALINITIES = 0.025, 0.040
"""Where all correlations for seawater hold."""


@dataclass(frozen=True)
class LiquidProperties:
    """What a liquid is like at a temperature, in SI units."""

    name: str
    temperature: Temperature
    density: Density
    viscosity: Viscosity
    surface_tension: SurfaceTension
    """of a clean surface against air"""
    sound_speed: Speed
    """the real one; SPH takes one far slower"""

    @property
    def kinematic_viscosity(self) -> KinematicViscosity:
        """Viscosity over density."""
        return self.viscosity / self.density


class Correlations(NamedTuple):
    """How a liquid's properties follow from its temperature, and where all four do."""

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
        partial(water.seawater_density, salinity=s),
        partial(water.seawater_viscosity, salinity=s),
        partial(water.seawater_surface_tension, salinity=s),
        partial(water.seawater_sound_speed, salinity=s),
    )


LIQUIDS: dict[str, Correlations] = {
    "water": Correlations(
        273.15, 373.12,
        water.water_density, water.water_viscosity, water.water_surface_tension, water.water_sound_speed,
    ),
    "seawater": _seawater(None),
    "ethanol": Correlations(
        273.15, 333.15,
        others.ethanol_density, others.ethanol_viscosity, others.ethanol_surface_tension, others.ethanol_sound_speed,
    ),
    "glycerol": Correlations(
        291.15, 323.15,
        others.glycerol_density, others.glycerol_viscosity,
        others.glycerol_surface_tension, others.glycerol_sound_speed,
    ),
    "mercury": Correlations(
        293.15, 323.15,
        others.mercury_density, others.mercury_viscosity, others.mercury_surface_tension, others.mercury_sound_speed,
    ),
}  # fmt: skip
"""By name, with the range of temperatures where all four properties are known."""
