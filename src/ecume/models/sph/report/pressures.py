"""The four pressures of a liquid. Frames hold the gauge pressure; the others are derived from it and the position.

| name | definition |
|---|---|
| `pressure` | gauge pressure p, zero at the reference density |
| `hydrostatic_pressure` | p_h = rho_0 g (H - y): that of a liquid at rest up to the initial level H; negative above H |
| `dynamic_pressure` | p - p_h: zero at rest |
| `absolute_pressure` | p + p_atm |

Heights are measured against gravity, whatever its direction. Along periodic sides nothing balances gravity, and its
component there does not count. [batchelor1967]
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ecume._portable import product
from ecume.laws.states import hydrostatic_pressure
from ecume.models.sph.parameters import PressureReference
from ecume.models.sph.setup.choices import filled, held_pull
from ecume.models.sph.setup.shapes import part_of
from ecume.scenes.sph import SphScene
from ecume.units import Array


def reference_of(scene: SphScene) -> PressureReference:
    """The reference of a scene's pressures."""
    liquid, gravity = filled(scene.liquid), held_pull(scene)
    up = upward(gravity)
    levels = []
    for region in scene.fluid:
        low, high = part_of(region, scene.spacing).bounds()
        levels.append(float(np.sum(np.maximum(low * up, high * up))))
    return PressureReference(liquid.density or 0.0, gravity, max(levels), liquid.atmospheric_pressure)


def upward(gravity: Array) -> Array:
    """(d,) the direction against gravity; zero without gravity."""
    size = float(np.linalg.norm(gravity))
    up: Array = -gravity / size if size > 0.0 else np.zeros(len(gravity))
    return up


def hydrostatic(reference: PressureReference, position: Array) -> Array:
    """The hydrostatic pressure (Pa) at positions (N, d)."""
    gravity = reference.gravity
    height = product(upward(gravity), position.T)
    return hydrostatic_pressure(height, reference.level, reference.density, float(np.linalg.norm(gravity)))


Kind = Callable[[PressureReference, Array, Array], Array]
"""A pressure (Pa) from the reference, the gauge pressure (N,) and the position (N, d)."""

PRESSURES: Mapping[str, Kind] = {
    "pressure": lambda reference, gauge, position: gauge,
    "hydrostatic_pressure": lambda reference, gauge, position: hydrostatic(reference, position),
    "dynamic_pressure": lambda reference, gauge, position: gauge - hydrostatic(reference, position),
    "absolute_pressure": lambda reference, gauge, position: gauge + reference.atmospheric,
}
"""By name, as gauges, figures, pages and exports take them."""
