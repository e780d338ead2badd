"""Liquids without sound waves, compared with weakly compressible ones: a tank at rest, vortices and a dam break."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume.scenes.load import load_scene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume_validation import dam_break, full_tanks
from ecume_validation.runner import DATA, Row, above, below, within

FOLDER = DATA / "incompressible"
TAIT = 'method.pressure="tait"'
LONGER = 5.0
"""Steps of the weakly compressible run, over those of the incompressible one."""
MOST_DENSITY, MOST_PRESSURE = 1e-3, 5e-3
SETTLED = 4.0
"""The time after which the tank at rest is averaged."""
SURFACE = 0.8
"""The height over H below which pressures are compared; only the four uppermost rows are above."""
DEEP = 40
"""Particles per height of the column."""
PEAK, PEAK_TOLERANCE = 3.04, 0.5
"""The peak at the lowest sensor over rho g H in the experiment [lobovsky2014], and its relative tolerance."""
WINDOW = 10
"""Frames of 0.01 over which the sensor is averaged: 0.1 sqrt(H/g), 17 ms in the experiment."""


class Dam(NamedTuple):
    """The quantities of a dam break, one entry per frame."""

    time: Array
    front: Array
    sensor: Array
    """Pa, over rho g H"""
    excess: Array
    """mean positive error of the density; NaN in weakly compressible runs"""
    steps: float


def rows() -> list[Row]:
    """Compare the tank at rest, the vortices and the dam break."""
    return [*at_rest(), *vortices(), *dam()]


def frames_of(name: str, changes: Sequence[str] = ()) -> list[Frame]:
    """All frames of a scene of the case."""
    return list(simulate(load_scene(FOLDER / f"{name}.toml", changes)))


def at_rest() -> list[Row]:
    """Compare the mean pressures on the floor, and in the liquid below the uppermost rows."""
    frames = [frame for frame in frames_of("rest") if frame.time >= SETTLED]
    error = np.array([frame.arrays["pressure"] - (1.0 - frame.arrays["position"][:, 1]) for frame in frames])
    deep = np.mean([frame.arrays["position"][:, 1] for frame in frames], axis=0) < SURFACE
    floor = float(np.mean([frame.numbers["floor_pressure"] for frame in frames]))
    last, later = frames[-1].numbers, error[:, deep]
    return [
        within("rest: mean pressure on the floor over rho g H", floor, 1.0, MOST_PRESSURE),
        below("rest: r.m.s. error below four rows", float(np.sqrt(np.mean(later**2))), MOST_PRESSURE),
        below("rest: largest error of a mean pressure there", float(abs(later.mean(axis=0)).max()), MOST_PRESSURE),
        within("rest: height of the center over H", last["center_y"], 0.5, 2e-3),
        below("rest: mean excess of the density", _mean(frames, "density_error"), MOST_DENSITY),
    ]


def vortices() -> list[Row]:
    """Compare the decay within the limits of the case taylor-green, and the number of steps with that at c0 = 10
    maximum speeds.
    """
    frames, others = frames_of("vortices"), frames_of("vortices", [TAIT])
    found, other = (full_tanks.Course(*np.array([full_tanks.judged(f) for f in run]).T) for run in (frames, others))
    momentum = np.array([[f.numbers["momentum_x"], f.numbers["momentum_y"]] for f in frames])
    return [
        below("vortices: largest error of the speed", float(found.error[1:].max()), 0.03),
        below("vortices: the same, over that with tait", float(found.error[1:].max() / other.error[1:].max()), 1.0),
        within("vortices: energy at the end over the exact one", float(found.energy[-1]), 1.0, 0.04),
        below("vortices: change of the momentum", float(abs(momentum - momentum[0]).max()), 1e-12),
        below("vortices: mean excess of the density", _mean(frames, "density_error"), MOST_DENSITY),
        above("vortices: steps with tait over steps", _steps(others) / _steps(frames), LONGER),
    ]


def dam() -> list[Row]:
    """Compare front, sensor, density and number of steps."""
    run, other = (broken(changes) for changes in ((), [TAIT]))
    averaged = np.convolve(run.sensor, np.full(WINDOW, 1.0 / WINDOW), "valid")
    when, where = dam_break.published("front", "wcsph-400")
    apart = np.abs(np.interp(when, run.time, run.front) - where)
    name = f"dam, H/{DEEP}"
    return [
        above(f"{name}: steps with tait over steps", other.steps / run.steps, LONGER),
        below(f"{name}: largest distance of the front over H", float(apart.max()), dam_break.MOST_FRONT[DEEP]),
        below(f"{name}: mean excess of the density", float(run.excess.mean()), MOST_DENSITY),
        within(f"{name}: peak of S1, averaged over 0.1 √(H/g)", float(averaged.max()), PEAK, PEAK_TOLERANCE * PEAK),
        within(f"{name}: peak of S1, unaveraged", float(run.sensor.max()), PEAK, PEAK_TOLERANCE * PEAK),
        below(f"{name}: the same, over that with tait", float(run.sensor.max() / other.sensor.max()), 1.0),
        above(f"{name}: least average of S1 over rho g H", float(averaged.min()), -0.5),
    ]


def broken(changes: Sequence[str]) -> Dam:
    """Run the dam."""
    frames = frames_of("dam", changes)
    read = [
        (f.time, f.numbers["front"], f.numbers["S1_pressure"], f.numbers.get("density_error", np.nan)) for f in frames
    ]
    time, front, sensor, excess = np.array(read).T
    return Dam(time, front, sensor, excess, _steps(frames))


def _steps(frames: list[Frame]) -> float:
    return frames[-1].numbers["substeps"]


def _mean(frames: list[Frame], name: str) -> float:
    return float(np.mean([frame.numbers[name] for frame in frames]))
