"""Dam break in 3D against a box: pressures on the box and levels of the water, compared with an experiment
[kleefsman2005].
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume.models.step_counts import BEFORE
from ecume.simulation import moments
from ecume.units import Array
from ecume_validation.runner import Row, above, below, read_table, sph_scene, within

CASE = "dam_break_obstacle"
FRONT, TOP = ("P1", "P2", "P3", "P4"), ("P5", "P7")
"""Sensors on the front of the box, from the lowest one on, and on its top."""
LEVELS = ("H1", "H2", "H3", "H4")
DEPTH = 0.55
"""The initial depth of the water (m)."""
REACHED = 0.25
"""The pressure at which water has reached a sensor, over the measured peak."""
IMPACT, LATER = (0.3, 1.2), (1.3, 2.0)
"""Intervals (s) of the impulse, and of the mean pressure under the returning water."""
MOST_PEAK, LEAST_PEAK = 1.5, 0.5
"""Tolerated peaks over the measured peak."""
ARRIVAL, IMPULSE, MEAN = 0.08, 0.25, 0.25
"""Relative tolerances."""
LEVEL = 0.05
"""The tolerated mean distance of a level from the experiment, over `DEPTH`."""


class Struck(NamedTuple):
    """The quantities of a run."""

    times: Array
    pressures: dict[str, Array]
    """by sensor, every millisecond as in the experiment (Pa)"""
    frame_times: Array
    levels: dict[str, Array]
    """by gauge (m)"""
    left: float
    """particles at the end over those at the start"""


def rows() -> list[Row]:
    """Compare the impact on the box, the water that returns over it, and the levels."""
    run = struck()
    return [*impact(run), *returning(run), *levels(run), within("particles left", run.left, 1.0, 0.0)]


def struck(changes: Sequence[str] = ()) -> Struck:
    """Run the scene with these changes."""
    samples, frames = [], []
    for moment in moments(sph_scene(CASE, changes), sampled=BEFORE):
        if moment.sample is not None:
            samples.append((moment.sample.time, moment.sample.numbers))
        if moment.frame is not None:
            frames.append((moment.frame.time, moment.frame.numbers, len(moment.frame.arrays["density"])))
    return Struck(
        np.array([time for time, _ in samples]),
        {name: np.array([numbers[f"{name}_pressure"] for _, numbers in samples]) for name in (*FRONT, *TOP)},
        np.array([time for time, *_ in frames]),
        {name: np.array([numbers[f"{name}_level"] for _, numbers, _ in frames]) for name in LEVELS},
        frames[-1][2] / frames[0][2],
    )


def published(table: str, name: str) -> Array:
    """Times and values, (n, 2), of a published table."""
    return np.array([
        (float(row["time"] or "nan"), float(row["value"]))
        for row in read_table(CASE)
        if row["table"] == table and row["name"] == name
    ])  # fmt: skip


def impact(run: Struck) -> list[Row]:
    """Compare peak, arrival time and impulse on the front of the box."""
    during, found = (run.times > IMPACT[0]) & (run.times < IMPACT[1]), []
    for name in FRONT:
        peak, arrival, impulse = (float(published(table, name)[0, 1]) for table in ("peak", "arrival", "impulse"))
        times, pressure = run.times[during], run.pressures[name][during]
        reached = pressure > REACHED * peak
        came = float(times[reached.argmax()]) if reached.any() else np.nan
        ratio = float(pressure.max()) / peak
        found += [
            below(f"{name}: peak over the measured one", ratio, MOST_PEAK),
            above(f"{name}: peak over the measured one", ratio, LEAST_PEAK),
            within(f"{name}: arrival (s)", came, arrival, ARRIVAL * arrival),
            within(f"{name}: impulse (Pa s)", float(np.trapezoid(pressure, times)), impulse, IMPULSE * impulse),
        ]
    return found


def returning(run: Struck) -> list[Row]:
    """Compare mean pressures while the water returns over the box."""
    during, found = (run.times > LATER[0]) & (run.times < LATER[1]), []
    for name in (*FRONT, *TOP):
        mean = float(published("mean", name)[0, 1])
        found.append(
            within(f"{name}: mean pressure later (Pa)", float(run.pressures[name][during].mean()), mean, MEAN * mean)
        )
    return found


def levels(run: Struck) -> list[Row]:
    """Compare the levels with the measured ones."""
    found = []
    for name in LEVELS:
        times, depths = published("level", name).T
        apart = np.abs(np.interp(times, run.frame_times, run.levels[name]) - depths).mean()
        found.append(
            below(f"{name}: mean distance from the experiment, over the first depth", float(apart) / DEPTH, LEVEL)
        )
    return found
