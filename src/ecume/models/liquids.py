"""The liquid of the laws from the liquid of a scene, without compilation, for checks and pictures, too."""

from __future__ import annotations

from typing import Any, NamedTuple

from ecume.errors import BadInput, Fault, SceneError, nearest
from ecume.laws import flotation, liquids
from ecume.laws.liquids import LIQUIDS, LiquidProperties, liquid
from ecume.models.model import Source
from ecume.units import ROOM


class Material(NamedTuple):
    """A liquid's properties in SI units; zero where neither the scene nor a name gives one."""

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
    )


def correlations_of(name: str | None) -> list[Source]:
    """The correlations behind the properties of a liquid that a scene names."""
    known = liquids.LIQUIDS.get(name or "", ())
    return [getattr(part, "func", part) for part in known if callable(part)]
