"""What a scene's motion hangs on beside the parameters that are fitted; `QUANTITIES`, the table by model."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ecume.models import MODELS


class Quantity(NamedTuple):
    """A positive number that follows from a scene."""

    name: str
    value: float
    unit: str


def of_floats(scene: Any) -> list[Quantity]:
    """Kind by kind: the charge, and all through which it shows in the motion.

    Equal floats far apart move by m x'' = -2 pi gamma A^2 / L K1(r/L) - zeta x': angle and density enter through the
    charge A, the mass m and the friction zeta, and these through 2 pi gamma A^2 / m and zeta / m alone. In a viscous
    liquid, whose floats have no inertia, there is their ratio only.
    """
    floats = MODELS["floating"].parameters(scene).floats
    names = [kind.name for kind in scene.kinds]
    several, found = len(names) > 1, []
    for number, name in enumerate(names):
        place = int(np.argmax(floats.species == number))
        charge, mass, coasting = (
            abs(float(values[place])) for values in (floats.charge, floats.mass, floats.relaxation_time)
        )
        pull = 2.0 * math.pi * scene.liquid.surface_tension * charge**2
        told = [("charge", charge, "m"), ("pull/mass", pull / mass, "m^2/s^2")]
        if math.isfinite(coasting):
            told += [("friction/mass", 1.0 / coasting, "1/s"), ("pull/friction", pull / mass * coasting, "m^2/s")]
        found += [Quantity(f"{word} of {name}" if several else word, value, unit) for word, value, unit in told]
    return found


def of_tracers(scene: Any) -> list[Quantity]:
    """Kind by kind: the speed at which it settles (or rises), and friction over mass, through which inertia shows.

    Where inertia is over before the first picture, density, radius and viscosity show in the speed alone.
    """
    bodies = MODELS["tracers"].parameters(scene).bodies
    names, found = [kind.name for kind in scene.kinds], []
    for number, name in enumerate(names):
        place = int(np.argmax(bodies.species == number))
        of = f" of {name}" if len(names) > 1 else ""
        speed, rate = abs(float(bodies.settling[place])), float(bodies.friction[place] / bodies.mass[place])
        found += [Quantity(f"{word}{of}", value, unit) for word, value, unit in (
            ("settling speed", speed if math.isfinite(speed) else 0.0, "m/s"),
            ("friction/mass", 0.0 if bodies.overdamped[place] else rate, "1/s"),
        )]  # fmt: skip
    return found


QUANTITIES: dict[str, Callable[[Any], list[Quantity]]] = {"floating": of_floats, "tracers": of_tracers}


def quantities_of(scene: Any) -> list[Quantity]:
    """The quantities of a scene; none where nobody wrote them down for its model. Zeros have no logarithm: left out."""
    if scene.model not in QUANTITIES:
        return []
    return [quantity for quantity in QUANTITIES[scene.model](scene) if quantity.value > 0.0]
