"""The imposed loading over time: piecewise linear in time, with the components of the box that stresses control."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.scenes.soft import NO_WAIT, StageSpec, expanded, waits_of
from ecume.scenes.soft.protocol import SAME
from ecume.units import Array

LOAD, STRAIN, SCALE, HEIGHT, SHEAR, NORMAL, WALL_SHEAR = range(7)
"""Rows of `Protocol.courses`."""


class Protocol(NamedTuple):
    """Intervals, each of which lasts until the time of the next one; the last has no end."""

    times: Array
    """(T,) s, the first is 0"""
    courses: Array
    """(T, 7, 2) value at the start of the interval and slope (1/s) of: load, strain, scale, ln(height), shear stress,
    normal stress or pressure, and the shear of walls
    """
    waves: Array
    """(T, 3) amplitudes of the strain and of the shear stress, and the angular frequency (1/s)"""
    rules: Integers
    """(T, 4) the components that stresses control: `Rules`"""
    jumps: Integers
    """(T,) whether a value jumps at the start of the interval"""
    groups: Integers
    """(T,) the moment of the scene whose rates end when the stress is stationary; -1 for intervals that do not"""
    within: Array
    """(T,) the relative standard error of the mean stress at which they end: see `waiting`"""


class Drive(NamedTuple):
    """The imposed values at one time. For strain, scale and height it is the imposed part of their change."""

    load: float
    """factor of external forces"""
    strain: float
    """of the box, along x per height"""
    rate: float
    """of the strain (1/s)"""
    scale: float
    """factor of all sides of the box"""
    growth: float
    """rate of ln(scale) (1/s)"""
    height: float
    """logarithm of an additional factor of the height"""
    height_rate: float
    """its rate (1/s)"""
    shear_stress: float
    normal_stress: float
    """normal to top and bottom, or a pressure: compression is positive"""
    wall_shear: float
    """factor of the shear stresses of walls, in addition to the load"""


class Rules(NamedTuple):
    """Components of the box that respond to a stress (1) or are imposed (0)."""

    strain: int
    width: int
    height: int
    depth: int


class SizeControl(NamedTuple):
    """The sides of the box that a stress controls after a moment with this key."""

    sides: tuple[int, int, int]
    """1 for each of width, height and depth that the stress of the key controls, 0 where imposed"""


SIZE_CONTROLS = {
    "height_rate": SizeControl((0, 0, 0)),
    "normal_stress": SizeControl((0, 1, 0)),
    "pressure": SizeControl((1, 1, 1)),
}


def interval_at(protocol: Protocol, time: float) -> int:
    """The interval that contains a time; at a corner, to within rounding, the later one."""
    return max(int(np.searchsorted(protocol.times, time * (1.0 + SAME), side="right")) - 1, 0)


def drive_at(protocol: Protocol, time: float, interval: int | None = None) -> Drive:
    """The imposed values at a time, in the given interval; default: the one that contains it."""
    which = interval_at(protocol, time) if interval is None else interval
    since, course, wave = time - float(protocol.times[which]), protocol.courses[which], protocol.waves[which]
    now = course[:, 0] + course[:, 1] * since
    load, strain, scale, height = float(now[LOAD]), float(now[STRAIN]), float(now[SCALE]), float(now[HEIGHT])
    shear, normal, wall_shear = float(now[SHEAR]), float(now[NORMAL]), float(now[WALL_SHEAR])
    rate, pace, of_strain, of_stress = float(course[STRAIN, 1]), float(wave[2]), float(wave[0]), float(wave[1])
    if pace > 0.0:
        strain += of_strain * math.sin(pace * since)
        rate += pace * of_strain * math.cos(pace * since)
        shear += of_stress * math.sin(pace * since)
    growth, height_rate = float(course[SCALE, 1]) / scale, float(course[HEIGHT, 1])
    return Drive(load, strain, rate, scale, growth, height, height_rate, shear, normal, wall_shear)


def rules_at(protocol: Protocol, interval: int) -> Rules:
    """The components that stresses control in an interval."""
    return Rules(*(int(rule) for rule in protocol.rules[interval]))


def next_turn(protocol: Protocol, time: float) -> float:
    """The time of the next corner of the protocol, which no step crosses."""
    later = protocol.times[protocol.times > time * (1.0 + SAME)]
    return float(later[0]) if len(later) else math.inf


def at_frames(protocol: Protocol, ticks: int, tick: float, end: float) -> Protocol:
    """A protocol whose corners within rounding of a frame, or of the end, are moved to the frame. Otherwise a step
    between the two would be too short for its equations, and a jump in it would be missed.

    Frames are `ticks` ticks apart; `tick` and `end` are times (s).
    """
    times = protocol.times
    frames = np.minimum(np.rint(times / (ticks * tick)) * ticks * tick, end)
    return protocol._replace(times=np.where(np.abs(frames - times) <= SAME * times, frames, times))


class ProtocolState(NamedTuple):
    """The values and rates of a protocol at one time."""

    values: tuple[float, ...] = (1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    shear_rate: float = 0.0
    height_rate: float = 0.0
    stressed: int = 0
    """1 where a shear stress controls the strain"""
    size: str = "height_rate"
    """the row of `SIZE_CONTROLS`"""

    def rules(self) -> Rules:
        """The components that stresses control."""
        return Rules(self.stressed, *SIZE_CONTROLS[self.size].sides)


def protocol_of(stages: Sequence[StageSpec]) -> Protocol:
    """The moments of a scene as intervals. Moments within rounding of each other are a jump: `at_frames` may move both
    to one frame.
    """
    waits, stages = waits_of(stages), expanded(stages)
    if not stages or stages[0].time > 0.0:
        first = stages[0] if stages else StageSpec(time=0.0)
        reached = {name: getattr(first, name) for name in ("load", "strain", "scale", "wall_shear")}
        waits, stages = (NO_WAIT, *waits), (StageSpec(time=0.0, **reached), *stages)
    rows, course, before = [], ProtocolState(), ProtocolState()
    for stage, following, wait in zip(stages, (*stages[1:], None), waits, strict=True):
        course = begun(course, stage)
        span = math.inf if following is None else following.time - stage.time
        if span > 2.0 * SAME * stage.time:
            slopes = slopes_of(course, following, span)
            rows.append((stage.time, course, slopes, wave_of(stage), jumped(before, course), wait))
            if following is not None:
                course = course._replace(values=tuple(v + s * span for v, s in zip(course.values, slopes, strict=True)))
                before = course
    return Protocol(
        times=np.array([row[0] for row in rows]),
        courses=np.array([np.stack([row[1].values, row[2]], axis=1) for row in rows]),
        waves=np.array([row[3] for row in rows]),
        rules=np.array([row[1].rules() for row in rows], np.int64),
        jumps=np.array([row[4] for row in rows], np.int64),
        groups=np.array([row[5].group for row in rows], np.int64),
        within=np.array([row[5].within for row in rows]),
    )


def begun(course: ProtocolState, stage: StageSpec) -> ProtocolState:
    """The values and rates after a moment of the scene."""
    size = next((key for key in SIZE_CONTROLS if getattr(stage, key) is not None), course.size)
    sized = any(SIZE_CONTROLS[size].sides)
    normal = getattr(stage, size) if sized else None
    given = (stage.load, stage.strain, stage.scale, None, stage.shear_stress, normal, stage.wall_shear)
    values = tuple(old if new is None else new for old, new in zip(course.values, given, strict=True))
    stressed = course.stressed
    if stage.shear_stress is not None or stage.shear_rate is not None:
        stressed = int(stage.shear_stress is not None)
    shear_rate = course.shear_rate if stage.shear_rate is None else stage.shear_rate
    height_rate = course.height_rate if stage.height_rate is None else stage.height_rate
    return ProtocolState(values, 0.0 if stressed else shear_rate, 0.0 if sized else height_rate, stressed, size)


def slopes_of(course: ProtocolState, following: StageSpec | None, span: float) -> tuple[float, ...]:
    """The rates of load, strain, scale, height and stresses until the next moment, if any."""
    slopes = [0.0, course.shear_rate, 0.0, course.height_rate, 0.0, 0.0, 0.0]
    if following is None:
        return tuple(slopes)
    goals = {LOAD: following.load, STRAIN: following.strain, SCALE: following.scale, WALL_SHEAR: following.wall_shear}
    if course.stressed:
        goals[SHEAR] = following.shear_stress
    if any(SIZE_CONTROLS[course.size].sides):
        goals[NORMAL] = getattr(following, course.size)
    for row, goal in goals.items():
        if goal is not None:
            slopes[row] = (goal - course.values[row]) / span
    return tuple(slopes)


def wave_of(stage: StageSpec) -> tuple[float, float, float]:
    """Amplitudes of strain and stress, and the angular frequency."""
    wave = stage.oscillation
    return (0.0, 0.0, 0.0) if wave is None else (wave.amplitude or 0.0, wave.stress or 0.0, math.tau * wave.frequency)


def jumped(before: ProtocolState, course: ProtocolState) -> bool:
    """Whether a value jumps, or a stress takes control, at the start of an interval."""
    sized = any(SIZE_CONTROLS[course.size].sides)
    new_rule = course.stressed > before.stressed or (sized and course.size != before.size)
    far = [
        abs(new - old) > 1e-12 * (abs(new) + abs(old)) for old, new in zip(before.values, course.values, strict=True)
    ]
    counted = (
        far[LOAD], far[STRAIN], far[SCALE], far[WALL_SHEAR],
        far[SHEAR] and course.stressed > 0, far[NORMAL] and sized,
    )  # fmt: skip
    return new_rule or any(counted)
