"""Swirls in 3D that only fade."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from ecume.laws.flows import Pressures, Speeds
from ecume.units import Angles, Density, Real, Speed, Unit

SpeedSquared = Annotated[Real, Unit("m^2/s^2")]


def beltrami_velocity(phase_next: Angles, phase_last: Angles, speed: Speed) -> Speeds:
    """Velocity along one axis of 3D swirls, U (sin(k z) + cos(k y)) along x and so on around.

    Angles: k times the coordinates along the next axis and along the one after that: y and z for x, z and x for y, x
    and y for z. The flow of Arnold, Beltrami and Childress with equal parts: its curl is k times itself, so that
    friction makes it fade at the rate nu k^2 and does nothing else. [dombre1986].

    >>> float(beltrami_velocity(0.0, np.pi / 2.0, 1.0))
    2.0
    """
    velocity: Real = speed * (np.sin(phase_last) + np.cos(phase_next))
    return velocity


def beltrami_pressure(speed_squared: SpeedSquared, speed: Speed, density: Density) -> Pressures:
    """Gauge pressure in such swirls, rho (3 U^2 - v^2) / 2: Bernoulli's sum is one everywhere, and its mean zero.

    speed_squared: v^2 there; its mean is 3 U^2. [dombre1986].

    >>> float(beltrami_pressure(0.0, 1.0, 1000.0))
    1500.0
    """
    return 0.5 * density * (3.0 * speed**2 - speed_squared)
