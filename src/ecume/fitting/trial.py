"""One simulation beside the measured tracks: from coordinates of what is fitted to residuals."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline, make_interp_spline

from ecume.errors import BadInput, Diverged
from ecume.fitting.free import Free, with_values
from ecume.fitting.starts import start_at
from ecume.fitting.tracks import Tracks
from ecume.models import MODELS
from ecume.scenes.schema import Scene, from_plain
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array

STARTS = ("positions", "moving", "scene")
"""What of the start is fitted along: where everyone is, also how fast, or nothing."""
LEAST_FRAMES = 50
"""Of a simulation: between them positions are those of cubics that have the right velocities at their ends."""
FAR = 1e3
"""The residual, in units of the reach, where a simulation is impossible: such parameters are never taken."""


class Problem(NamedTuple):
    """What is compared: tracks in the order of the scene's particles, and what of the scene may change."""

    plain: dict[str, Any]
    free: list[Free]
    tracks: Tracks
    start: str
    """one of STARTS"""
    reach: float
    """m: how far objects are from one another or go; the natural unit of the start's coordinates"""
    first: Array
    """(N, 2) m: where the start's coordinates are zero"""
    speed: Array
    """(N, 2) m/s: the same for velocities"""

    @property
    def seen(self) -> Any:
        """(T, N) where there is a measurement."""
        return np.isfinite(self.tracks.position[:, :, 0])

    @property
    def starts(self) -> int:
        """How many coordinates the start has."""
        return {"positions": 1, "moving": 2, "scene": 0}[self.start] * self.first.size


def timed(plain: dict[str, Any], tracks: Tracks) -> dict[str, Any]:
    """The scene as long as the tracks, with frames at least as often as the camera's, and steps that stay.

    A step that followed the parameters would jump where one more fits into a frame, and residuals with it.
    """
    duration = float(tracks.times[-1])
    frames = max(LEAST_FRAMES, round(duration / float(np.median(np.diff(tracks.times)))))
    plain |= {"duration": duration, "frame_every": duration / frames}
    if "time_step" in plain.get("motion", {}):
        plain["motion"]["time_step"] = None
        chosen = MODELS[plain["model"]].parameters(from_plain(plain))
        plain["motion"]["time_step"] = plain["frame_every"] / chosen.steps_per_frame
    return plain


def origin(problem: Problem) -> Array:
    """The coordinates at which the fit begins."""
    own = [free.coordinate(free.value) for free in problem.free]
    return np.concatenate([own, np.zeros(problem.starts)])


def values_at(problem: Problem, coordinates: Array) -> list[float]:
    """The parameters at these coordinates."""
    return [free.at(float(at)) for free, at in zip(problem.free, coordinates, strict=False)]


def scene_at(problem: Problem, coordinates: Array) -> Scene:
    """The scene at these coordinates. Raises BadInput where there is none."""
    plain = with_values(copy.deepcopy(problem.plain), problem.free, values_at(problem, coordinates))
    if problem.start != "scene":
        shift = coordinates[len(problem.free) :].reshape(-1, *problem.first.shape) * problem.reach
        duration = float(problem.tracks.times[-1])
        velocity = problem.speed + shift[1] / duration if problem.start == "moving" else None
        start_at(plain, problem.first + shift[0], velocity)
    return from_plain(plain)


def simulated(scene: Scene, times: Array) -> Array:
    """(T, N, 2) m: where everyone is at these times."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what is said of the steps of a trial is no news: they were chosen here
        frames = list(simulate(scene))
    return positions_at(frames, times)


def positions_at(frames: Sequence[Frame], times: Array) -> Array:
    """Positions between frames: by cubics where frames have velocities, by straight lines elsewhere."""
    instants = np.array([frame.time for frame in frames])
    position = np.stack([frame.arrays["position"] for frame in frames])
    at = np.minimum(times, instants[-1])
    if "velocity" in frames[0].arrays:
        velocity = np.stack([frame.arrays["velocity"] for frame in frames])
        return np.asarray(CubicHermiteSpline(instants, position, velocity)(at))
    return np.asarray(make_interp_spline(instants, position, k=1)(at))


def residuals(problem: Problem, coordinates: Array) -> Array:
    """Simulated less measured positions, over the reach, where there are measurements."""
    try:
        there = simulated(scene_at(problem, coordinates), problem.tracks.times)
    except (BadInput, Diverged):  # floats that sink, overlap or fly away: not here
        return np.full(2 * int(problem.seen.sum()), FAR)
    return np.asarray((there - problem.tracks.position)[problem.seen].ravel() / problem.reach)
