"""The liquid of the laws from the liquid of a scene, without compilation, also for checks and pictures."""

from __future__ import annotations

from typing import Any, NamedTuple

from ecume.errors import BadInput, Fault, SceneError, nearest
from ecume.laws import drag, flotation, liquids
from ecume.laws.liquids import LIQUIDS, LiquidProperties, liquid
from ecume.models.model import Source
from ecume.units import ROOM

DENSEST_GAS = 0.1
"""The ratio of densities above which the gas counts as a liquid; gases at 30 bar are below it."""


class Material(NamedTuple):
    """The properties of a liquid in SI units; zero where neither the scene nor a name gives one."""

    density: float
    viscosity: float
    surface_tension: float


def named_liquid(given: Any) -> LiquidProperties | None:
    """The liquid that `[liquid]` names, at its temperature. Raises SceneError."""
    if not given.name:
        return None
    if given.name not in LIQUIDS:
        raise SceneError([Fault("liquid.name", f"got {given.name!r}; {nearest(given.name, list(LIQUIDS))}")])
    try:
        temperature = ROOM if given.temperature is None else given.temperature
        return liquid(given.name, temperature, getattr(given, "salinity", None))
    except BadInput as fault:
        key = "temperature" if "temperature" in str(fault) else "salinity"
        raise SceneError([Fault(f"liquid.{key}", str(fault))]) from None


def material_of(given: Any) -> Material:
    """The properties of `[liquid]`: specified values, otherwise those of the named liquid."""
    named = named_liquid(given)
    values = [
        getattr(named, key, 0.0) if getattr(given, key, None) is None else getattr(given, key)
        for key in Material._fields
    ]
    return Material(*values)


def liquid_of(scene: Any) -> flotation.Liquid:
    """The liquid of a scene with floats, as the laws define it."""
    given = material_of(scene.liquid)
    return flotation.Liquid(
        given.density,
        given.surface_tension,
        given.viscosity,
        gravity=scene.gravity,
        gas_density=scene.liquid.gas_density,
        gas_viscosity=scene.liquid.gas_viscosity,
    )


def is_under_liquid(liquid: flotation.Liquid) -> bool:
    """Whether the fluid above the surface is a liquid."""
    return liquid.gas_density > DENSEST_GAS * liquid.density


def inertia_over_viscosity(liquid: flotation.Liquid) -> float:
    """Density over viscosity of the liquids around a float (s/m^2), infinite without viscosity."""
    return drag.inverse_kinematic_viscosity(liquid.density, liquid.viscosity, liquid.gas_density, liquid.gas_viscosity)


def float_reynolds(speed: float, radius: float, liquid: flotation.Liquid) -> float:
    """The Reynolds number of a float, by its diameter."""
    return drag.particle_reynolds(speed, radius, inertia_over_viscosity(liquid), 1.0)


def correlations_of(name: str | None) -> list[Source]:
    """The sources of the properties of a named liquid."""
    known = liquids.LIQUIDS.get(name or "", ())
    return [getattr(part, "func", part) for part in known if callable(part)]
