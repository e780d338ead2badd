"""How a liquid follows a dish that is tilted by hand: its first sloshing mode, and the current that goes with it.

The surface swings about the level with the mode's own frequency; in the middle of the dish, where the mode is plane,
the liquid runs with u = s' g / omega^2, s being the surface's slope against the dish: from (dh/dt) = phi_z and u =
phi_x of the potential J1(k r) cos(phi) cosh(k (z + H)) [lamb1932, art. 191]. Floats are carried by that current.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ecume.laws.waves import wave_frequency
from ecume.models.floating.walls.shapes import sloshing_wavenumber

DEPTH = 0.02
"""m, of the liquid: scenes of floats say none."""
DAMPING = 0.08
"""Of the swing, over the critical one: what is seen in bowls of some centimeters."""


class Slosh(NamedTuple):
    """The slope of the surface against the dish along x and y, and how fast each changes (1/s)."""

    slope: tuple[float, float] = (0.0, 0.0)
    rate: tuple[float, float] = (0.0, 0.0)


def slosh_frequency(scene: Any) -> float:
    """Angular, of the first mode (1/s)."""
    liquid, dish = scene.liquid, scene.dish
    tension = liquid.surface_tension / liquid.density
    return float(wave_frequency(sloshing_wavenumber(dish), DEPTH, liquid.gravity, tension))


def swung(slosh: Slosh, tilt: tuple[float, float], scene: Any, seconds: float) -> Slosh:
    """The swing a while later, exactly, under a tilt (radians, small) that stays meanwhile."""
    omega = slosh_frequency(scene)
    both = [_swung(s, v, aim, omega, seconds) for s, v, aim in zip(slosh.slope, slosh.rate, tilt, strict=True)]
    return Slosh((both[0][0], both[1][0]), (both[0][1], both[1][1]))


def _swung(slope: float, rate: float, aim: float, omega: float, seconds: float) -> tuple[float, float]:
    """S'' = -omega^2 (s - aim) - 2 zeta omega s', solved over the time."""
    decay, swing = DAMPING * omega, omega * math.sqrt(1.0 - DAMPING**2)
    away = slope - aim
    along = (rate + decay * away) / swing
    fade, c, s = math.exp(-decay * seconds), math.cos(swing * seconds), math.sin(swing * seconds)
    later = fade * (away * c + along * s)
    return aim + later, -decay * later + fade * swing * (along * c - away * s)


def current(slosh: Slosh, scene: Any) -> tuple[float, float]:
    """How the liquid runs in the middle of the dish (m/s)."""
    per_rate = scene.liquid.gravity / slosh_frequency(scene) ** 2
    return slosh.rate[0] * per_rate, slosh.rate[1] * per_rate
