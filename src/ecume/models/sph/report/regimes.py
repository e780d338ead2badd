"""Which parts of the physics matter in a tank, by its dimensionless numbers, and whether they are switched on."""

from __future__ import annotations

import math

from ecume.laws.viscous import viscosity_of_alpha
from ecume.models.check_report import Row
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.setup.choices import (
    artificial_viscosity_of,
    filled,
    gravity_of,
    sides_of,
    smallest_extent,
    smoothing_of,
    tension_of,
)
from ecume.models.sph.setup.walls_and_bodies import holds
from ecume.scenes.sph import SphScene
from ecume.value_texts import with_prefix

IRRELEVANT, RELEVANT = 1000.0, 100.0
"""Bond and Weber numbers above which surface tension has no visible effect, and below which it has."""
DOMINANT = 10.0
"""Times the liquid's own viscosity: an artificial viscosity above which the flow is not that of the liquid."""
VISCOUS = 1e4
"""A Reynolds number below which the liquid's viscosity may matter outside boundary layers."""


def regime_rows(scene: SphScene, parameters: Parameters) -> list[Row]:
    """The Bond number (without gravity, the Weber number) and the Reynolds number, and what follows from them."""
    return [*_tension(scene, parameters), *_viscosity(scene, parameters)]


def _tension(scene: SphScene, parameters: Parameters) -> list[Row]:
    tension, material = filled(scene.liquid).surface_tension or 0.0, parameters.material
    if tension == 0.0:
        return []
    extent, pull = smallest_extent(scene), math.hypot(*gravity_of(scene))
    if pull > 0.0:
        name, number = "Bond number", material.density * pull * extent**2 / tension
    elif tension_of(scene) == "none":
        name, number = "Weber number", material.density * material.fastest**2 * extent / tension
    else:  # the speed to be expected is that of the surface tension itself
        return []
    return [(name, f"{number:.3g}", _tension_remark(number, tension_of(scene)))]


def _tension_remark(number: float, model: str) -> str:
    """Whether surface tension matters, and how to switch it."""
    if model != "none" and number > IRRELEVANT:
        return 'surface tension has no visible effect; method.surface_tension_model = "none" is faster'
    if model == "none" and number < RELEVANT:
        return 'surface tension matters and is off; method.surface_tension_model = "csf" includes it'
    return "surface tension acts" if model != "none" else "surface tension is off"


def _viscosity(scene: SphScene, parameters: Parameters) -> list[Row]:
    material = parameters.material
    if material.viscosity == 0.0:
        return []
    extent = smallest_extent(scene)
    number = material.density * material.fastest * extent / material.viscosity
    return [("Reynolds number", f"{number:.3g}", _viscosity_remark(scene, parameters, number, extent))]


def _viscosity_remark(scene: SphScene, parameters: Parameters, number: float, extent: float) -> str:
    """Whether the flow has the liquid's viscosity, and whether boundary layers are resolved."""
    material, alpha, length = parameters.material, artificial_viscosity_of(scene), smoothing_of(scene)
    added = material.density * viscosity_of_alpha(alpha, length, material.sound_speed, parameters.dimension)
    if number < VISCOUS and added > DOMINANT * material.viscosity:
        ratio = f"{added / material.viscosity:.2g} times the liquid's viscosity"
        return f"artificial viscosity acts like {ratio}; method.artificial_viscosity = 0 leaves the liquid's own"
    layer = extent / math.sqrt(number)
    no_slip = any(side.kind == "wall" and holds(side, scene) for side in sides_of(scene))
    if no_slip and layer < scene.spacing:
        cause = f"boundary layers of {with_prefix(layer, 'm', 2)} are thinner than the spacing"
        return f'{cause}; slip = "free" suits such walls better'
    return ""
