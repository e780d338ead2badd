"""Measurements of oscillating drops."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import curve_fit

from ecume.trajectories.frame import Frame
from ecume.units import Array


class Swing(NamedTuple):
    """One that dies as exp(-rate t)."""

    frequency: float
    """rad/s"""
    rate: float

    @property
    def period(self) -> float:
        """The period of one oscillation."""
        return 2.0 * np.pi / self.frequency


def axes(frame: Frame) -> float:
    """The logarithm of the ratio of the first axis to the (mean) other."""
    first, *others = frame.arrays["position"].std(axis=0)
    return float(np.log(first) - np.mean(np.log(others)))


def swing_of(frames: Sequence[Frame]) -> Swing:
    """The swing of the ratio of the axes; a drop of uneven particles rests at a ratio that is not quite one."""
    time, ratio = np.array([f.time for f in frames]), np.array([axes(f) for f in frames])

    def damped(t: Array, a: float, b: float, w: float, rate: float, rest: float) -> Array:
        swung: Array = np.exp(-rate * t) * (a * np.cos(w * t) + b * np.sin(w * t)) + rest
        return swung

    found, _ = curve_fit(damped, time, ratio, p0=(0.0, np.ptp(ratio) / 2.0, 2.5, 0.1, 0.0))
    return Swing(abs(float(found[2])), float(found[3]))


def longest_rise(frames: Sequence[Frame]) -> float:
    """The largest rise of the total energy from one frame to a later one, over the largest kinetic energy."""
    energy = np.array([frame.numbers["total_energy"] for frame in frames])
    moving = max(frame.numbers["kinetic_energy"] for frame in frames)
    return float((energy - np.minimum.accumulate(energy)).max()) / moving
