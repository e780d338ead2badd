"""The fit of a scene's parameters to tracks: from tracks to estimates with intervals."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecume.errors import BadInput
from ecume.fitting.initial_conditions import (
    first_frame,
    first_seen,
    first_speeds,
    keeps_kinds,
    matched,
    require_no_chance,
    require_starts,
)
from ecume.fitting.least_squares import (
    STARTS,
    STEP,
    Certainty,
    Problem,
    Solution,
    certainty,
    origin,
    residuals,
    scene_at,
    simulated,
    solved,
    timed,
)
from ecume.fitting.parameters import Free, Quantity, free_parameters, quantities_of
from ecume.fitting.remarks import astray, met, no_noise, swapped, unsure
from ecume.fitting.tracks import Camera, Tracks, cut, read_tracks
from ecume.scenes.faults import suggestion
from ecume.scenes.load import load_scene
from ecume.scenes.schema import Scene, from_plain, to_plain
from ecume.units import Array


class Estimate(NamedTuple):
    """A number with its 95 percent interval; without one where the tracks do not determine it."""

    name: str
    value: float
    low: float
    high: float
    unit: str

    @property
    def determined(self) -> bool:
        """Whether the tracks say anything of it."""
        return math.isfinite(self.high)


class Fit(NamedTuple):
    """The result of a fit."""

    scene: Scene
    """with what was fitted"""
    estimates: list[Estimate]
    """of the parameters that were free"""
    derived: list[Estimate]
    """of what follows from them"""
    noise: float
    """m: the standard deviation of what is left of each measured number"""
    remarks: list[str]
    tracks: Tracks
    """in the order of the scene's particles"""
    simulated: Array
    """(T, N, 2) m, at the times of the tracks"""
    rounds: int


def fit(
    tracks: Tracks | str | os.PathLike[str],
    scene: Scene | str | Path,
    free: Sequence[str],
    *,
    start: str = "positions",
    until: float = math.inf,
    camera: Camera = Camera(),  # noqa: B008  # it cannot change
) -> Fit:
    """The parameters of a scene with which its simulation is nearest to tracks, by least squares.

    `free` are keys such as `contact_angle`, or paths such as `particles[0].radius`; the scene has their initial values
    and everything else. `start` selects what is fitted together with them: `positions` of all particles at the first
    instant, `moving` for velocities as well, `scene` for nothing. Observations later than `until` (s) are ignored, for
    example contacts. Noise is assumed to be the same for all measured numbers, and independent.
    """
    measured = tracks if isinstance(tracks, Tracks) else read_tracks(tracks, camera)
    asked = load_scene(scene) if isinstance(scene, (str, Path)) else scene
    problem = posed(cut(measured, until), to_plain(asked), free, start)
    simulated(scene_at(problem, origin(problem)), measured.times)  # faults of the initial state are reported unchanged
    solution = solved(lambda at: residuals(problem, at), origin(problem))
    return concluded(problem, solution)


def posed(measured: Tracks, plain: dict[str, Any], names: Sequence[str], start: str) -> Problem:
    """The problem that a fit solves. Raises BadInput where the tracks do not fit the scene."""
    if start not in STARTS:
        raise BadInput(f"start: got {start!r}; {suggestion(start, STARTS)}")
    free = free_parameters(plain, names)
    require_no_chance(plain)
    if start != "scene":
        require_starts(plain, moving=start == "moving")
    plain = timed(plain, measured)
    frame = first_frame(from_plain(plain))
    found = start != "scene"
    if not (found and keeps_kinds(plain) and len(measured.names) == len(frame.arrays["position"])):
        measured = matched(measured, frame, centered=found)
    there = first_seen(measured) if found else frame.arrays["position"]
    seen = measured.position[np.isfinite(measured.position[:, :, 0])]
    reach = float(np.ptp(seen, axis=0).max())
    problem = Problem(plain, free, measured, start, reach, there, first_speeds(measured))
    if (numbers := 2 * int(problem.seen.sum())) <= len(origin(problem)):
        raise BadInput(f"{numbers} measured numbers are too few to fit {len(origin(problem))}")
    return problem


def concluded(problem: Problem, solution: Solution) -> Fit:
    """The result of a solved problem."""
    scene, at = scene_at(problem, solution.coordinates), solution.coordinates
    sure = certainty(solution, len(problem.free))
    there = simulated(scene, problem.tracks.times)
    estimates = [_estimate(problem.free[n], float(at[n]), sure, n) for n in range(len(problem.free))]
    derived = derived_estimates(problem, at, sure)
    noise = solution.noise * problem.reach
    left = there - problem.tracks.position
    remarks = [
        *swapped(problem.tracks),
        *unsure(problem, at, sure),
        *met(scene, problem.tracks.times, there),
        *astray(problem, left),
        *no_noise(problem, left),
    ]
    if not solution.converged:
        remarks.insert(0, f"the fit had not settled after {solution.rounds} rounds; begin nearer")
    return Fit(scene, estimates, derived, noise, remarks, problem.tracks, there, solution.rounds)


def _estimate(free: Free, at: float, sure: Certainty, number: int) -> Estimate:
    """A parameter; its interval is computed on the scale on which it varies."""
    unit = np.zeros(sure.directions.shape[1])
    unit[number] = 1.0
    off = sure.quantile * sure.error_of(unit)
    if not math.isfinite(off):
        return Estimate(free.name, free.at(at), 0.0, math.inf, free.unit)
    low, high = sorted((free.at(at - off), free.at(at + off)))
    return Estimate(free.name, free.at(at), low, high, free.unit)


def derived_estimates(problem: Problem, at: Array, sure: Certainty) -> list[Estimate]:
    """The estimates of quantities that follow from the parameters, by the slopes of their logarithms."""
    here = quantities_of(scene_at(problem, at))
    count = len(problem.free)
    slopes = np.zeros((len(here), count))
    for number, unit in enumerate(np.eye(len(at))[:count]):
        there = quantities_of(scene_at(problem, at + STEP * unit))
        slopes[:, number] = [math.log(moved.value / one.value) / STEP for one, moved in zip(here, there, strict=True)]
    return [_derived(one, slope, sure) for one, slope in zip(here, slopes, strict=True)]


def _derived(quantity: Quantity, slope: Array, sure: Certainty) -> Estimate:
    name, value, unit = quantity
    if not np.any(np.abs(slope) > 1e-9):
        return Estimate(name, value, value, value, unit)
    off = sure.quantile * sure.error_of(slope)
    if not math.isfinite(off):
        return Estimate(name, value, 0.0, math.inf, unit)
    return Estimate(name, value, value * math.exp(-off), value * math.exp(off), unit)
