"""Tanks that roll about a pivot, in the frame of the tank.

The tank is turned by the angle q about an axis a through a pivot P. In its frame, gravity is turned by -q, and liquid
at the arm r = x - P with the velocity v has the further acceleration - q'' a x r - q'^2 a x (a x r) - 2 q' a x v:
Euler's, the centrifugal one and Coriolis's. Images and dummies behind walls continue the pressure with the turned
gravity alone: over half a spacing, what Euler's acceleration adds to it is far below the pressure of one layer.
"""

from __future__ import annotations

import numpy as np

from ecume.models.sph.boundaries.rigid_bodies import drive_at
from ecume.models.sph.parameters import Roll
from ecume.units import Array


def inertial_accelerations(roll: Roll, time: float, position: Array, velocity: Array) -> Array:
    """Euler's, centrifugal and Coriolis's accelerations (d, N) at positions and velocities in the frame of the tank."""
    _, rate, second = drive_at(roll.drive, time)
    spin, spun = float(rate[0]) * roll.axis, float(second[0]) * roll.axis
    dimension = len(position)
    arm, speed = (np.pad(each, ((0, 3 - dimension), (0, 0))).T for each in (position, velocity))
    arm = arm - roll.pivot
    found = -np.cross(spun, arm) - np.cross(spin, np.cross(spin, arm)) - 2.0 * np.cross(spin, speed)
    return found.T[:dimension]
