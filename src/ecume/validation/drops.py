"""Drops that are drawn out and drops that swing, against the motion of an ellipse; how they are measured."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import curve_fit

from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume.validation.rows import Row, below, within
from ecume.validation.runner import frames_of, read_table


class Swing(NamedTuple):
    """One that dies as exp(-rate t)."""

    frequency: float
    """rad/s"""
    rate: float

    @property
    def period(self) -> float:
        """The period of one oscillation."""
        return 2.0 * np.pi / self.frequency


def axes_of_liquid(frame: Frame) -> float:
    """The logarithm of the ratio of the first axis to the (mean) other."""
    first, *others = frame.arrays["position"].std(axis=0)
    return float(np.log(first) - np.mean(np.log(others)))


def swing_of(frames: Sequence[Frame]) -> Swing:
    """The swing of the ratio of the axes; a drop of uneven particles rests at a ratio that is not quite one."""
    time, ratio = np.array([f.time for f in frames]), np.array([axes_of_liquid(f) for f in frames])

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


PERIOD = 4.5673738
SWINGING = (
    f"duration={PERIOD!r}",
    f"frame_every={PERIOD / 16!r}",
    "spacing=0.05",
    "liquid.sound_speed=14.0",
    "liquid.maximum_speed=1.4",
    "fluid[0].velocity_gradient=[[0.5, 0.0], [0.0, -0.5]]",
    "central_force={angular_frequency=1.0, center=[0.0, 0.0]}",
)
LATE = 0.0076
"""s, when PySPH was read."""


def rows() -> list[Row]:
    """Stretched, then swinging."""
    return [*stretched(), *swinging(), *damped()]


def stretched() -> list[Row]:
    """Compare a drop in a straining flow at a resolution of 40 in a radius."""
    frames = list(frames_of("drops"))
    found = [
        row
        for time, exact in table("stretched")
        for row in axes_at(f"stretched, t = {time:g}", frames, time, (exact, (0.02, 0.004)))
    ]
    bound = float(read_table("drops")[0]["value"])
    exact = dict(table("stretched"))[LATE]
    highest = at(frames, LATE).arrays["position"][:, 1].max() + 0.0125
    return [
        *found,
        below("stretched: height of the highest off by, below PySPH's", abs(highest / exact[1] - 1.0), bound),
    ]


def swinging() -> list[Row]:
    """Without viscosity."""
    frames = list(frames_of("drops", [*SWINGING, "method.artificial_viscosity=0.0"]))
    found = [
        row
        for time, exact in table("swinging")
        for row in axes_at(f"swinging, t = {time:.3g}", frames, time, (exact, (0.005, 0.005)))
    ]
    ratio = frames[-1].numbers["total_energy"] / frames[0].numbers["total_energy"]
    return [*found, within("swinging: energy after a period, over the first", ratio, 1.0, 0.001)]


def damped() -> list[Row]:
    """Compare an oscillating drop with the default viscosity."""
    frames = list(frames_of("drops", SWINGING))
    return axes_at("swinging, damped, after a period", frames, PERIOD, ((1.0, 1.0), (0.005, 0.005)))


def table(drop: str) -> list[tuple[float, tuple[float, float]]]:
    """Times, and half the width and height there."""
    cases = [case for case in read_table("drops", "independent") if case["drop"] == drop]
    return [(float(case["time"]), (float(case["width"]), float(case["height"]))) for case in cases]


def axes_at(
    name: str, frames: Sequence[Frame], time: float, expected: tuple[tuple[float, float], tuple[float, float]]
) -> list[Row]:
    """A row for each axis: its value and its tolerance, relative."""
    found = axes(at(frames, time)) / axes(frames[0])
    return [
        within(f"{name}: {axis}", float(value), exact, tolerance * exact)
        for axis, value, exact, tolerance in zip(("width", "height"), found, *expected, strict=True)
    ]


def at(frames: Sequence[Frame], time: float) -> Frame:
    """The frame of that time."""
    return min(frames, key=lambda frame: abs(frame.time - time))


def axes(frame: Frame) -> Array:
    """(2,) half the width and height of the ellipse with the drop's second moments."""
    mass, position = frame.arrays["mass"], frame.arrays["position"]
    half: Array = 2.0 * np.sqrt(mass @ position**2 / mass.sum())
    return half
