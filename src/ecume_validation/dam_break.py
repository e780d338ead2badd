"""Dam breaks: front, impact and pressure on the far wall, levels and volume, compared with other codes and
experiments.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ecume.analysis.gauges import filled, points_along, values_at, water_level
from ecume.engine.interpolation import THIN
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume_validation import impact
from ecume_validation.runner import Row, above, below, read_table, sph_scene, within

FAR_WALL = impact.FAR_WALL
SENSORS = {"P1": 0.01, "P2": 0.05, "P3": 0.1, "P4": 0.267}
"""Heights of sensors on the far wall."""
GAUGES = {"H1": 1.0, "H2": 2.8833, "H3": 3.7133, "H4": 4.5417}
"""Positions of gauges along the floor."""
PRESSURES = (3.0, 5.0)
"""The interval over which pressures are averaged."""
MOST_FRONT = {40: 0.1, 80: 0.05}
"""The tolerated distance from the front in the finest run of another code, by particles per height of the column."""
COARSE = 20
"""Particles per height of the column, in the coarsest run of the impact."""
MOST_PRESSURE = {40: 0.1, 80: 0.05}
"""Relative tolerances of the pressure. The other code itself is 8 % off with 40 particles, and 4 % with 80."""
MOST_LEVEL, MOST_VOLUME = 0.05, 0.01
MOST_AHEAD = 0.6
"""The tolerated lead of the front over experiments, which have friction and a gate, over the width of the column."""
TALL = ("fluid[0].high=[1.0, 2.0]", "tank.high=[4.5, 5.0]", "liquid.sound_speed=28.0", "duration=2.2")
TALL_SPACING = 0.04


class Broken(NamedTuple):
    """The quantities of a dam break, one entry per instant."""

    times: Array
    fronts: Array
    volumes: Array
    """from the densities, over the initial volume"""
    pressures: Array
    """(times, sensors), over rho g H"""
    levels: Array
    """(times, gauges), over H"""
    tops: Array
    """level at the back wall, over the initial one"""


def rows() -> list[Row]:
    """Compare the wide column at two resolutions and its impact at three, then the tall column."""
    both = {deep: struck(deep) for deep in MOST_FRONT}
    runs = {deep: run for deep, (run, _) in both.items()}
    impacts = {COARSE: impact.struck([f"spacing={1.0 / COARSE!r}"])} | {deep: run for deep, (_, run) in both.items()}
    fronts = [row for deep, run in runs.items() for row in front(run, deep)]
    sharper = [order(runs[40], runs[80])]
    others = [row for deep, run in runs.items() for row in (*pressure(run, deep), *level(run, deep), volume(run, deep))]
    hits = [row for deep, run in impacts.items() for row in hit(run, deep)]
    return [*fronts, *sharper, *others, *tall(), *hits]


def struck(deep: int) -> tuple[Broken, impact.Impact]:
    """Run the wide column, with its impact sampled in each time step."""
    samples: list[Frame] = []
    frames = impact.frames_and_samples([f"spacing={1.0 / deep!r}"], samples)
    return gauged(frames, FAR_WALL, 4.0 / deep), impact.read(samples)


def hit(run: impact.Impact, deep: int) -> list[Row]:
    """Compare the impact with the experiment, and with the peak of another code, whose coarsest run
    has spacing H/40.
    """
    other = impact.published("impact_peak", f"wcsph-{max(deep, min(MOST_FRONT))}")
    return impact.rows_of(f"H/{deep}", run, other)


def broken(changes: Sequence[str], reach: float) -> Broken:
    """Run the changed scene and read the gauges in each frame."""
    scene = sph_scene("dam_break", changes)
    return gauged(simulate(scene), scene.tank.high[0], reach)


def gauged(frames: Iterable[Frame], wide: float, reach: float) -> Broken:
    """Read the gauges in each frame of a tank of this width."""
    read = [_read(frame, wide, reach) for frame in frames]
    times, front_, volume_, pressure_, level_, top = (np.array(column) for column in zip(*read, strict=True))
    return Broken(times, front_, volume_ / volume_[0], pressure_, level_, top / top[0])


def _read(frame: Frame, wide: float, reach: float) -> tuple[float, float, float, Array, Array, float]:
    sensors = np.array([(wide, height) for height in SENSORS.values()])
    wet = filled(frame, sensors, reach) > THIN
    pressure_ = np.where(wet, values_at(frame, "pressure", sensors, reach), 0.0)
    levels = water_level(frame, np.array(list(GAUGES.values())), reach)
    return frame.time, frame.numbers["front"], frame.numbers["volume"], pressure_, levels, _height(frame, reach)


def _height(frame: Frame, reach: float) -> float:
    """The height of the liquid near the back wall: the highest point at which half of the volume is filled."""
    line = points_along((reach, 0.0), (reach, 2.5), 501)
    return float(line[np.flatnonzero(filled(frame, line, reach) >= 0.49)].max(initial=0.0))


def published(table: str, name: str) -> tuple[Array, Array]:
    """Times and values of a published table."""
    found = [row for row in read_table("dam_break") if row["table"] == table and row["name"] == name]
    return (
        np.array([float(row["time"] or math.nan) for row in found]),
        np.array([float(row["value"]) for row in found]),
    )


def front(run: Broken, deep: int) -> list[Row]:
    """Compare the front with that of another code at ten times the resolution."""
    times, places = published("front", "wcsph-400")
    ours = np.interp(times, run.times, run.fronts)
    return [
        within(f"H/{deep}: front over H at T = {time:g}", here, there, MOST_FRONT[deep])
        for time, here, there in zip(times, ours, places, strict=True)
    ]


def order(coarse: Broken, fine: Broken) -> Row:
    """The order of convergence of the front: log2 of the ratio of mean errors at the published times."""
    times, places = published("front", "wcsph-400")
    errors = [np.abs(np.interp(times, run.times, run.fronts) - places).mean() for run in (coarse, fine)]
    return above("order of convergence of the front", float(np.log2(errors[0] / errors[1])), 0.7)


def pressure(run: Broken, deep: int) -> list[Row]:
    """Mean pressures on the far wall."""
    during = (run.times > PRESSURES[0]) & (run.times < PRESSURES[1])
    found = []
    for sensor, mean in zip(SENSORS, run.pressures[during].mean(axis=0), strict=True):
        expected = float(published(f"mean_pressure_{sensor}", "wcsph-400")[1][0])
        tolerance = MOST_PRESSURE[deep] * expected
        found.append(within(f"H/{deep}: mean pressure {sensor} over rho g H", float(mean), expected, tolerance))
    return found


def level(run: Broken, deep: int) -> list[Row]:
    """Compare the level at each gauge with the experiment, up to T = 5."""
    found = []
    for number, gauge in enumerate(GAUGES):
        times, depths = published(f"level_{gauge}", "run-A")
        apart = np.interp(times, run.times, run.levels[:, number]) - depths
        name = f"H/{deep}: level {gauge}, largest distance from the experiment, over H"
        found.append(below(name, float(np.abs(apart[times <= 5.0]).max()), MOST_LEVEL))
    return found


def volume(run: Broken, deep: int) -> Row:
    """Compare the volume with its initial value."""
    return below(f"H/{deep}: change of volume", float(np.abs(run.volumes - 1.0).max()), MOST_VOLUME)


def tall() -> list[Row]:
    """Compare the tall column with two experiments, and with a code; simulations without friction and gate are ahead of
    experiments.
    """
    run = broken([*TALL, f"spacing={TALL_SPACING}"], 4.0 * TALL_SPACING)
    # The front of the liquid is half a spacing beyond the center of the last particle.
    times, fronts = run.times * math.sqrt(2.0), run.fronts + 0.5 * TALL_SPACING
    found = []
    for who, name in (("Martin and Moyce", "n2-2"), ("Koshizuka and Oka", "2D")):
        when, where = published("tall_front", name)
        early = when < times[-1]
        ahead = np.interp(when[early], times, fronts) - where[early]
        found += [
            above(f"tall column: least lead on {who}, over its width", float(ahead.min()), -0.05),
            below(f"tall column: largest lead on {who}, over its width", float(ahead.max()), MOST_AHEAD),
        ]
    when, where = published("tall_front", "wcsph-33")
    # Later their front has reached the wall of a narrower tank. Their data are positions of particles, without half a
    # spacing.
    free = when <= 2.5
    apart = np.interp(when, times, run.fronts)[free] - where[free]
    found.append(below("tall column: distance from another code's front", float(np.abs(apart).max()), 0.1))
    when, heights = published("tall_height", "n2-2")
    early = when < run.times[-1]
    apart = np.interp(when[early], run.times, run.tops) - heights[early]
    return [*found, below("tall column: distance from the measured heights", float(np.abs(apart).max()), 0.05)]
