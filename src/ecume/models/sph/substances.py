"""The liquid as a material: what a name and a temperature say of it, where the scene says nothing."""

from __future__ import annotations

import dataclasses

from ecume.errors import Fault, SceneError
from ecume.laws.liquids import LiquidProperties
from ecume.laws.liquids.water import ICE_POINT
from ecume.models.liquids import named_liquid
from ecume.scenes.sph import FluidSpec

WATER = 1000.0
"""kg/m^3, of a liquid without a name or a density."""
FILLED = ("density", "viscosity", "surface_tension")


def substance_of(given: FluidSpec) -> LiquidProperties | None:
    """The named liquid at its temperature. Raises SceneError."""
    if not given.name:
        told = [key for key in ("temperature", "salinity") if getattr(given, key) is not None]
        if told:
            raise SceneError([Fault(f"liquid.{told[0]}", 'says nothing without a name; write name = "water"')])
    return named_liquid(given)


def filled(given: FluidSpec) -> FluidSpec:
    """The liquid with density, viscosity and surface tension: what the scene says wins over what the name says."""
    named = substance_of(given)
    density, viscosity, tension = (WATER, 0.0, 0.0) if named is None else [getattr(named, key) for key in FILLED]
    return dataclasses.replace(
        given,
        density=density if given.density is None else given.density,
        viscosity=viscosity if given.viscosity is None else given.viscosity,
        surface_tension=tension if given.surface_tension is None else given.surface_tension,
    )


def told(given: FluidSpec) -> list[tuple[str, str, str]]:
    """What `check` says of the material: where each number comes from."""
    named, full = substance_of(given), filled(given)
    units = {"density": "kg/m^3", "viscosity": "Pa s", "surface_tension": "N/m"}
    origin = "usual" if named is None else f"{named.name} at {named.temperature - ICE_POINT:.4g} degrees Celsius"
    return [
        (key.replace("_", " "), f"{getattr(full, key):.5g} {units[key]}", origin if getattr(given, key) is None else "")
        for key in FILLED
        if named is not None or getattr(full, key)
    ]
