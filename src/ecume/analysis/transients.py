"""Transients of sheared packings: start-up of a flow, relaxation of its stress, and recovery of strain after creep."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume.analysis.rheology import SteadyState, steady_state
from ecume.analysis.series import number, series, times
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array, Number, Pressure, Rate, Time

FEWEST = 8
"""The smallest number of frames of a transient."""


def since(frames: Sequence[Frame], start: Time, end: Time = math.inf) -> Sequence[Frame]:
    """The frames from `start` (included) to `end` (excluded); a frame at the time of a jump shows the state after it.
    Raises BadInput if there are too few.
    """
    found = [frame for frame in frames if start * (1.0 - 1e-9) <= frame.time < end * (1.0 - 1e-9)]
    if len(found) < FEWEST:
        raise BadInput(f"expected {FEWEST} frames or more from {start:g} s to {end:g} s; got {len(found)}")
    return found


class StartUp(NamedTuple):
    """The shear stress after the start of a flow at a constant rate; Pa, in a layer N/m. Stresses are along the
    flow.
    """

    strain: Array
    """since the start"""
    stress: Array
    peak: Pressure
    """the largest stress"""
    peak_strain: Number
    steady: SteadyState
    """of the stress"""

    @property
    def overshoot(self) -> Number:
        """The peak over the steady stress, minus 1; NaN if the stress does not become stationary."""
        return self.peak / self.steady.mean.value - 1.0 if self.steady.settled else math.nan


def start_up(frames: Sequence[Frame]) -> StartUp:
    """The start-up of a flow, from frames evenly spaced in time that begin with it.

    >>> strain = np.linspace(0.0, 4.0, 41)
    >>> frames = [Frame(t, {}, {"strain": t, "shear_stress": 1.0 - np.exp(-4 * t) + t * np.exp(-2 * t)}, {})
    ...     for t in strain]
    >>> found = start_up(frames)
    >>> round(found.peak_strain, 1), round(found.peak, 3)
    (0.9, 1.121)
    """
    strain, stress = series(since(frames, frames[0].time), number("strain"), number("shear_stress"))
    along = math.copysign(1.0, strain[-1] - strain[0])
    strain, stress = along * (strain - strain[0]), along * stress
    top = int(np.argmax(stress))
    return StartUp(strain, stress, float(stress[top]), float(strain[top]), steady_state(stress))


class Relaxation(NamedTuple):
    """The shear stress at a constant strain after a flow; Pa, in a layer N/m. Stresses are along the preceding flow."""

    time: Array
    """since the flow has stopped (s)"""
    stress: Array
    left: Number
    """the last stress over the first"""
    half_time: Time
    """when half of the stress that relaxes until the end has relaxed"""
    rate: Rate
    """at which ln(stress) still falls in the last third (1/s): 0 where a yield stress remains"""


def relaxation(frames: Sequence[Frame]) -> Relaxation:
    """The relaxation of the stress, from frames that begin where the flow stops.

    >>> frames = [Frame(t, {}, {"shear_stress": 3.0 + np.exp2(-t)}, {}) for t in np.linspace(0.0, 20.0, 201)]
    >>> found = relaxation(frames)
    >>> round(found.left, 3), round(found.half_time, 2), found.rate < 1e-2
    (0.75, 1.0, True)
    """
    frames = since(frames, frames[0].time)
    now, (stress,) = times(frames) - frames[0].time, series(frames, number("shear_stress"))
    stress = math.copysign(1.0, stress[0]) * stress
    half = 0.5 * (stress[0] + stress[-1])
    after = int(np.argmax(stress <= half))
    pair = slice(after - 1, after + 1)
    half_time = float(np.interp(-half, -stress[pair], now[pair])) if after else math.nan
    late = 2 * len(stress) // 3
    fallen = math.log(stress[late] / stress[-1]) if min(stress[late], stress[-1]) > 0.0 else math.nan
    return Relaxation(now, stress, float(stress[-1] / stress[0]), half_time, fallen / float(now[-1] - now[late]))


class Recovery(NamedTuple):
    """The strain after the shear stress of a creep test has been removed."""

    time: Array
    """since then (s)"""
    recovered: Array
    """the strain that has returned since then, positive against the creep"""
    crept: Number
    """the strain of the creep before"""

    @property
    def part(self) -> Number:
        """The recovered part of the creep: 1 for an elastic packing, 0 for a liquid."""
        return float(self.recovered[-1] / self.crept)


def recovery(frames: Sequence[Frame], begun: Time, removed: Time) -> Recovery:
    """The recovery after a stress that has acted from the time `begun` until it was removed.

    >>> frames = [Frame(t, {}, {"strain": 0.1 * min(t, 10.0) - 0.4 * (t > 10.0) * (1 - np.exp2(10.0 - t))}, {})
    ...     for t in np.arange(0.0, 31.0)]
    >>> round(recovery(frames, 0.0, 10.0).part, 3)
    0.4

    The surfaces recover at once, so that the frame at the removal no longer contains their strain. The strain before
    the removal follows from the last two frames of the creep, and the strain before the creep from the last frame
    before it, if there is one.
    """
    before, after = since(frames, begun, removed), since(frames, removed)
    (crept,), (strain,) = series(before, number("strain")), series(after, number("strain"))
    rest = [frame.numbers["strain"] for frame in frames if frame.time < begun * (1.0 - 1e-9)]
    slope = (crept[-1] - crept[-2]) / (before[-1].time - before[-2].time)
    reached = crept[-1] + slope * (removed - before[-1].time)
    total = float(reached - (rest[-1] if rest else crept[0]))
    returned = math.copysign(1.0, total) * (reached - strain)
    return Recovery(times(after) - after[0].time, np.asarray(returned), abs(total))
