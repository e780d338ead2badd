"""Tanks that roll about a pivot, in the frame of the tank.

The tank is turned by the angle q about an axis a through a pivot P. In its frame, gravity is turned by -q, and liquid
at the arm r = x - P with the velocity v has the further acceleration - q'' a x r - q'^2 a x (a x r) - 2 q' a x v:
Euler's, the centrifugal one and Coriolis's. Images and dummies behind walls continue the pressure with the turned
gravity alone: over half a spacing, what Euler's acceleration adds to it is far below the pressure of one layer.
"""

from __future__ import annotations

import numpy as np

from ecume._portable import dot
from ecume.models.sph.boundaries.rigid_bodies import drive_at
from ecume.models.sph.parameters import Roll
from ecume.units import Array


def inertial_accelerations(
    roll: Roll, time: float, position: Array, velocity: Array, half_kick: tuple[float, Array] | None = None
) -> Array:
    """Euler's, centrifugal and Coriolis's accelerations (d, N) at positions and velocities in the frame of the tank.

    With a `half_kick`, a time (s) and all others (d, N) until its end, Coriolis's is that at its end: of
    v' = v + time (a - 2 q' a x v'), solved for v'. Half kicks before and after that moment (the trapezoidal rule) turn
    the velocity and keep its length; with v itself it would grow by 2 (2 q' time)^2 per step.
    """
    _, rate, second = drive_at(roll.drive, time)
    spin, spun = float(rate[0]) * roll.axis, float(second[0]) * roll.axis
    arm, speed = _wide(position) - roll.pivot, _wide(velocity)
    found = -np.cross(spun, arm) - np.cross(spin, np.cross(spin, arm))
    if half_kick is not None:
        speed = speed + half_kick[0] * (_wide(half_kick[1]) + found)
        k = 2.0 * half_kick[0] * spin
        along = (k[0] * speed[:, 0] + k[1] * speed[:, 1] + k[2] * speed[:, 2])[:, None]
        speed = (speed - np.cross(k, speed) + along * k) / (1.0 + dot(k, k))
    found = found - 2.0 * np.cross(spin, speed)
    return found.T[: len(position)]


def _wide(vectors: Array) -> Array:
    """Vectors (d, N) as (N, 3)."""
    wide: Array = np.pad(vectors, ((0, 3 - len(vectors)), (0, 0))).T
    return wide
