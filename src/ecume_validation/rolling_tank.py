"""Impacts of water in a tank that rolls: the first four peaks of the pressure at a sensor in the wall, beside their
statistics over about a hundred repetitions of the experiment [soutoiglesias2011].
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume.models.step_counts import BEFORE
from ecume.simulation import moments
from ecume.units import Array
from ecume_validation.runner import Row, read_table, sph_scene, within

CASE = "rolling_tank"
PERIOD = 1.63
"""The period of the roll (s)."""
FIRST, AROUND = (1.8, 2.8), 0.4
"""The interval of the first impact, and half of that of each later one (s)."""
DEVIATIONS = 2.0
"""The tolerance of peaks, in standard deviations of the experiment."""
LATENESS = 0.03
"""The tolerance of the time between impacts, over the period."""


class Struck(NamedTuple):
    """The quantities of a run."""

    times: Array
    pressure: Array
    """at the sensor (Pa)"""
    left: float
    """particles at the end over those at the start"""


def rows() -> list[Row]:
    """Compare the peaks, and the time between them."""
    return rows_of(struck())


def rows_of(run: Struck) -> list[Row]:
    """Rows on one run."""
    found, times = [], []
    for number, line in enumerate(read_table(CASE)):
        mean, deviation = float(line["mean"]), float(line["deviation"])
        time, peak = impact(run, number)
        times.append(time)
        found.append(within(f"impact {number + 1}: peak (Pa)", peak, mean, DEVIATIONS * deviation))
    between = float(np.mean(np.diff(times)))
    return [
        *found,
        within("time between impacts (s)", between, PERIOD, LATENESS * PERIOD),
        within("particles left", run.left, 1.0, 0.0),
    ]


def impact(run: Struck, number: int) -> tuple[float, float]:
    """The time and the peak of an impact, counted from 0."""
    during = (run.times >= FIRST[0]) & (run.times <= FIRST[1])
    first = float(run.times[during][run.pressure[during].argmax()])
    if number:
        during = np.abs(run.times - first - number * PERIOD) <= AROUND
    most = int(run.pressure[during].argmax())
    return float(run.times[during][most]), float(run.pressure[during][most])


def struck(changes: Sequence[str] = ()) -> Struck:
    """Run the scene with these changes."""
    samples, counts = [], []
    for moment in moments(sph_scene(CASE, changes), sampled=BEFORE):
        if moment.sample is not None:
            samples.append((moment.sample.time, moment.sample.numbers["sensor_pressure"]))
        if moment.frame is not None:
            counts.append(len(moment.frame.arrays["density"]))
    times, pressure = np.array(samples).T
    return Struck(times, pressure, counts[-1] / counts[0])
