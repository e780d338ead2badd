"""The requirements of a second liquid on other options: options that support only one liquid are refused, with the
reason.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

from ecume.errors import Fault, SceneError
from ecume.models.sph.setup.choices import filled, sides_of
from ecume.scenes.sph import SphScene

MOST_RATIO = 1000.0
"""The largest ratio of the densities of two liquids."""


class Limit(NamedTuple):
    """Options that cannot be combined with two liquids."""

    found: Callable[[SphScene], Iterable[tuple[str, str]]]
    """the paths of options of this kind in a scene, and what they are"""
    reason: str


def _named(part: str, key: str, *harmless: str) -> Callable[[SphScene], Iterator[tuple[str, str]]]:
    """A function that yields the name in a table of the scene, if it is not one of the given names."""

    def found(scene: SphScene) -> Iterator[tuple[str, str]]:
        value = getattr(getattr(scene, part), key)
        if value not in harmless:
            yield f"{part}.{key}", f"got {value!r}; "

    return found


def _given(part: str, *keys: str) -> Callable[[SphScene], Iterator[tuple[str, str]]]:
    """A function that yields the keys in a table of the scene that have a value."""
    return lambda scene: ((f"{part}.{key}", "") for key in keys if getattr(getattr(scene, part), key))


def _sides(scene: SphScene) -> Iterator[tuple[str, str]]:
    for name, side in zip(scene.sides, sides_of(scene), strict=True):
        if side.kind in ("inflow", "outflow"):
            yield f"tank.{name}.kind", f"got {side.kind!r}; "
        if side.contact_angle is not None:
            yield f"tank.{name}.contact_angle", ""


def _gauges(scene: SphScene) -> Iterator[tuple[str, str]]:
    for index, gauge in enumerate(scene.gauges):
        for name in ("hydrostatic_pressure", "dynamic_pressure"):
            if name in gauge.quantities:
                yield f"gauges[{index}].quantities", f"got {name!r}; "


LIMITS = (
    Limit(_named("method", "pressure", "tait"), "its solver has one density; with [second_liquid] use 'tait'"),
    Limit(_named("method", "pressure_force", "sum"), "only 'sum' weighs pressures by the densities of two liquids"),
    Limit(_named("method", "pressure_split", "none"), "it knows one density; with [second_liquid] use 'none'"),
    Limit(_named("method", "density_diffusion", "automatic", "hydrostatic", "none"),
          "with [second_liquid] only 'hydrostatic' knows how each density rises"),
    Limit(_named("method", "viscosity_model", "automatic", "morris", "monaghan"),
          "it completes pairs at the surface of one liquid; with [second_liquid] use 'monaghan' or 'morris'"),
    Limit(_named("method", "surface_tension_model", "automatic", "csf", "none"),
          "it attracts liquids of one density; with [second_liquid] use 'csf'"),
    Limit(_named("method", "turbulence", "none"),
          "eddies at interfaces were not measured; with [second_liquid] use 'none'"),
    Limit(_given("method", "artificial_viscosity"),
          "it has the density of one liquid; with [second_liquid] give both a viscosity instead"),
    Limit(_given("liquid", "rheology"), "with [second_liquid] viscosities are constant; remove it"),
    Limit(_given("liquid", "surface_tension", "contact_angle"),
          "with [second_liquid] only the interface has a tension, second_liquid.interface_tension; remove it"),
    Limit(_named("tank", "walls", "mirror"), "dummies and guards know one liquid; with [second_liquid] use 'mirror'"),
    Limit(_sides, "with [second_liquid] the liquid of buffers, and angles at walls, are not known; remove it"),
    Limit(lambda scene: ((f"{name}[0]", "") for name in ("obstacles", "bodies") if getattr(scene, name)),
          "dummies know one liquid; remove it, or [second_liquid]"),
    Limit(lambda scene: ((f"passive_tracers[{index}].radius", "") for index, each in enumerate(scene.passive_tracers)
                         if each.radius > 0.0),
          "the drag on grains is that of one liquid; with [second_liquid] use tracers of radius 0"),
    Limit(_gauges, "it is of one density; with [second_liquid] record 'pressure'"),
    Limit(lambda scene: [("central_force", "")] if scene.central_force is not None else (),
          "its pressure at the start is that of one liquid; remove it, or [second_liquid]"),
)  # fmt: skip
"""Options that two liquids do not have, by what they need."""


def require_two_liquids(scene: SphScene) -> None:
    """Raise SceneError for options that support only one liquid, and for liquids that differ too much."""
    faults = [Fault(path, got + limit.reason) for limit in LIMITS for path, got in limit.found(scene)]
    faults += _of_properties(scene)
    if faults:
        raise SceneError(faults)


def _of_properties(scene: SphScene) -> Iterator[Fault]:
    """Faults of the densities and viscosities of both liquids together."""
    if scene.second_liquid is None:
        return
    one, other = filled(scene.liquid), filled(scene.second_liquid.alone)
    lightest, densest = sorted([one.density or 0.0, other.density or 0.0])
    if densest > MOST_RATIO * lightest:
        got = f"the densities are {lightest:g} and {densest:g} kg/m^3"
        yield Fault("second_liquid.density", f"{got}; expected a ratio of at most {MOST_RATIO:g}")
    if bool(one.viscosity) != bool(other.viscosity):
        path = "liquid.viscosity" if other.viscosity else "second_liquid.viscosity"
        yield Fault(path, "only one of the liquids has a viscosity; give both one, or neither")
