"""The impact of a dam break on the far wall, at the sensors of an experiment: peak, rise time, impulse, arrival.

Sensors have the experiment's heights, diameter and rate. Quantities are in units of rho g H and sqrt(H/g).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ecume.models.step_counts import BEFORE
from ecume.simulation import moments
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume_validation.runner import Row, above, below, read_table, sph_scene, within

FAR_WALL = 5.366
SENSORS = {"S1": 0.01, "S2": 0.05, "S3": 0.1, "S4": 80.0 / 300.0}
"""Heights on the far wall: 3, 15, 30 and 80 mm with H = 300 mm."""
DIAMETER, INTERVAL = 4.2 / 300.0, 2.859e-4
"""The diameter of a sensor, 4.2 mm, and its sampling interval, 50 microseconds, shorter than a time step."""
CHORDS = np.sqrt(1.0 - np.linspace(-0.8, 0.8, 5) ** 2)
"""Weights of five points over the height of a disc."""
LASTING = 3.5
"""The end time; the uppermost sensor is reached at 2.75."""
WET = 0.1
"""The pressure at which a sensor has been reached."""
IMPACT = 0.5
"""The time after the arrival over which the impulse is integrated: twice the times from half of the peak to the peak
and back, the experiment's time of impact.
"""
WINDOW = 0.1
"""The time over which pressures are averaged: 17 ms in the experiment."""
MOST_PEAK, LEAST = 1.5, -0.5
"""The largest peak over that of the experiment, and the lowest pressure over rho g H."""
ARRIVAL, RISE, IMPULSE = 0.08, 0.5, 0.25
"""Relative tolerances."""


class Impact(NamedTuple):
    """Pressures of the sensors, one entry per time step."""

    times: Array
    pressures: Array
    """(times, sensors), averaged over their area"""
    center: Array
    """at the center of the lowest sensor"""


def sensors() -> str:
    """The change of a scene that adds each sensor, as a row of five points over its height."""
    reach = 0.4 * DIAMETER
    rows = [
        f'{{name="{name}",position=[{FAR_WALL},{height - reach!r}],end=[{FAR_WALL},{height + reach!r}],count=5}}'
        for name, height in SENSORS.items()
    ]
    return f"gauges=[{','.join(rows)}]"


def frames_and_samples(changes: list[str], samples: list[Frame]) -> Iterator[Frame]:
    """The frames of a dam break; appends the samples of each time step to `samples`."""
    scene = sph_scene("dam_break", [*changes, sensors(), f"output.samples={{every={INTERVAL}}}"])
    for moment in moments(scene, sampled=BEFORE):
        if moment.sample is not None:
            samples.append(moment.sample._replace(arrays={}))
        if moment.frame is not None:
            yield moment.frame


def read(samples: list[Frame]) -> Impact:
    """The pressures in samples."""
    points = np.array([[[s.numbers[f"{name}_{n}_pressure"] for n in range(1, 6)] for name in SENSORS] for s in samples])
    return Impact(np.array([s.time for s in samples]), points @ CHORDS / CHORDS.sum(), points[:, 0, 2])


def struck(changes: list[str]) -> Impact:
    """Run a dam break until all sensors have been reached."""
    samples: list[Frame] = []
    for _ in frames_and_samples([*changes, f"duration={LASTING}"], samples):
        pass
    return read(samples)


def arrival(times: Array, pressure: Array) -> float:
    """The time at which a sensor is reached; NaN if it stays dry."""
    wet = pressure > WET
    return float(times[wet.argmax()]) if wet.any() else np.nan


def rise_time(times: Array, pressure: Array) -> float:
    """Twice the time from half of the peak to the peak [lobovsky2014]."""
    peak = int(pressure.argmax())
    low = np.flatnonzero(pressure[:peak] < 0.5 * pressure[peak])
    return 2.0 * float(times[peak] - times[low[-1]]) if len(low) else 0.0


def impulse(times: Array, pressure: Array) -> float:
    """The integral of the pressure over the time of impact."""
    during = (times >= (start := arrival(times, pressure))) & (times <= start + IMPACT)
    return float(np.trapezoid(pressure[during], times[during]))


def averaged(times: Array, pressure: Array) -> Array:
    """Moving averages over the time `WINDOW`."""
    even = np.arange(times[0], times[-1], INTERVAL)
    count = round(WINDOW / INTERVAL)
    found: Array = np.convolve(np.interp(even, times, pressure), np.full(count, 1.0 / count), "valid")
    return found


def published(table: str, name: str) -> float:
    """A published number of the impact."""
    (found,) = [row for row in read_table("dam_break") if row["table"] == table and row["name"] == name]
    return float(found["value"])


def rows_of(name: str, run: Impact, other: float) -> list[Row]:
    """Rows that compare an impact with the experiment; `other` is the peak of another code."""
    times, lowest = run.times, run.pressures[:, 0]
    peak, rise, push = (published(f"impact_{what}", "S1") for what in ("peak", "rise", "impulse"))
    beside = f"(experiment: {peak:.3g}, other code: {other:.3g})"
    smooth = averaged(times, lowest)
    found = [
        below(f"{name}: peak of S1 {beside}", float(lowest.max()), MOST_PEAK * peak),
        below(f"{name}: the same at its center", float(run.center.max()), MOST_PEAK * peak),
        below(f"{name}: the same, averaged over {WINDOW:g} √(H/g)", float(smooth.max()), MOST_PEAK * peak),
        above(f"{name}: least pressure of S1", float(lowest.min()), LEAST),
        above(f"{name}: the same, averaged over {WINDOW:g} √(H/g)", float(smooth.min()), LEAST),
        within(f"{name}: rise time of S1", rise_time(times, lowest), rise, RISE * rise),
        within(f"{name}: impulse of S1 in {IMPACT:g} √(H/g)", impulse(times, lowest), push, IMPULSE * push),
    ]
    for number, sensor in enumerate(SENSORS):
        expected = published("arrival", sensor)
        came = arrival(times, run.pressures[:, number])
        found.append(within(f"{name}: arrival at {sensor}", came, expected, ARRIVAL * expected))
    return found
