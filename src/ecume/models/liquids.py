"""From a scene's liquid to that of the laws; compiles nothing, so that pictures and checks may ask, too."""

from __future__ import annotations

from typing import Any

from ecume.laws import flotation, liquids
from ecume.models.model import Source


def liquid_of(scene: Any) -> flotation.Liquid:
    """The liquid of a scene that has one, as the laws know it."""
    given = scene.liquid
    return flotation.Liquid(
        given.density, given.surface_tension, given.viscosity, gravity=given.gravity, gas_density=given.gas_density
    )


def correlations_of(name: str | None) -> list[Source]:
    """The correlations behind the properties of a liquid that a scene names."""
    known = liquids.LIQUIDS.get(name or "", ())
    return [getattr(part, "func", part) for part in known if callable(part)]
