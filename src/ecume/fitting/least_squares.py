"""Least squares over simulations: the residuals of one simulation, the minimum, and the uncertainty of the result."""

from __future__ import annotations

import copy
import warnings
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline, make_interp_spline
from scipy.optimize import least_squares
from scipy.stats import t as student

from ecume.errors import BadInput, Diverged
from ecume.fitting.parameters import Free, with_values
from ecume.fitting.tracks import Tracks, start_at
from ecume.models import MODELS
from ecume.scenes.schema import Scene, from_plain
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array

STARTS = ("positions", "moving", "scene")
"""The part of the initial state that is fitted: positions, positions and velocities, or nothing."""
LEAST_FRAMES = 50
"""Of a simulation: between them positions are those of cubics that have the right velocities at their ends."""
FAR = 1e3
"""The residual, in units of the reach, where a simulation is impossible: such parameters are never taken."""


class Problem(NamedTuple):
    """The problem of a fit: tracks in the order of the scene's particles, and the parts of the scene that vary."""

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
        """The number of coordinates of the start."""
        return {"positions": 1, "moving": 2, "scene": 0}[self.start] * self.first.size


def timed(plain: dict[str, Any], tracks: Tracks) -> dict[str, Any]:
    """The scene as long as the tracks, with frames at least as often as the camera's, and steps that stay.

    A step that followed the parameters would jump where one more fits into a frame, and residuals with it.
    """
    duration = float(tracks.times[-1])
    frames = max(LEAST_FRAMES, round(duration / float(np.median(np.diff(tracks.times)))))
    plain |= {"duration": duration, "frame_every": duration / frames}
    if "time_step" in plain.get("integration", {}):
        plain["integration"]["time_step"] = None
        chosen = MODELS[plain["model"]].parameters(from_plain(plain))
        plain["integration"]["time_step"] = plain["frame_every"] / chosen.steps_per_frame
    return plain


def origin(problem: Problem) -> Array:
    """The coordinates at which the fit begins."""
    own = [free.coordinate(free.value) for free in problem.free]
    return np.concatenate([own, np.zeros(problem.starts)])


def values_at(problem: Problem, coordinates: Array) -> list[float]:
    """The parameters at these coordinates."""
    return [free.at(float(at)) for free, at in zip(problem.free, coordinates, strict=False)]


def scene_at(problem: Problem, coordinates: Array) -> Scene:
    """The scene at these coordinates. Raises BadInput if no scene has them."""
    plain = with_values(copy.deepcopy(problem.plain), problem.free, values_at(problem, coordinates))
    if problem.start != "scene":
        shift = coordinates[len(problem.free) :].reshape(-1, *problem.first.shape) * problem.reach
        duration = float(problem.tracks.times[-1])
        velocity = problem.speed + shift[1] / duration if problem.start == "moving" else None
        start_at(plain, problem.first + shift[0], velocity)
    return from_plain(plain)


def simulated(scene: Scene, times: Array) -> Array:
    """(T, N, 2) m: the positions at these times."""
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


STEP = 1e-5
"""Of a coordinate, for slopes: simulations are smooth to about 1e-12."""
MOST_ROUNDS = 60
LOOSE = 0.7
"""The standard error of ln(p) beyond which something is called undetermined: a factor of two either way."""
CONFIDENCE = 0.95


class Solution(NamedTuple):
    """The minimum of the squares."""

    coordinates: Array
    residuals: Array
    jacobian: Array
    converged: bool
    rounds: int

    @property
    def freedom(self) -> int:
        """Numbers measured less numbers fitted."""
        return max(len(self.residuals) - len(self.coordinates), 1)

    @property
    def noise(self) -> float:
        """The standard deviation of a measured number, in the unit of the residuals."""
        return float(np.sqrt(np.sum(self.residuals**2) / self.freedom))


def solved(residuals: Callable[[Array], Array], start: Array) -> Solution:
    """The least squares near a start, by a trust region; directions that change nothing are left as they are."""

    def slopes(at: Array) -> Array:
        here = residuals(at)
        columns = [(residuals(at + STEP * unit) - here) / STEP for unit in np.eye(len(at))]
        return np.stack(columns, axis=1)

    found: Any = least_squares(
        residuals, start, slopes, method="trf", tr_solver="exact", max_nfev=MOST_ROUNDS, xtol=1e-7, ftol=1e-8
    )
    return Solution(found.x, found.fun, found.jac, bool(found.status > 0), int(found.nfev))


class Certainty(NamedTuple):
    """The uncertainty of the first coordinates, whatever the values of the others.

    `directions` are orthonormal rows in the space of these coordinates, `errors` the standard error along each.
    """

    directions: Array
    errors: Array
    quantile: float
    """of Student's distribution: this many standard errors make an interval"""

    @property
    def determined(self) -> Any:
        """The directions that the tracks determine."""
        return self.errors < LOOSE

    def error_of(self, slope: Array) -> float:
        """The standard error of a quantity with this slope in the coordinates; infinite where it is undetermined."""
        along = self.directions @ slope
        loose = np.linalg.norm(along[~self.determined])
        if loose > MOST_LOOSE * np.linalg.norm(slope):
            return float("inf")
        return float(np.linalg.norm(along[self.determined] * self.errors[self.determined]))


MOST_LOOSE = 0.02
"""The part of a quantity's slope that may lie along what is undetermined."""


def certainty(solution: Solution, first: int) -> Certainty:
    """The errors of the first coordinates from the Jacobian and the noise, with all others fitted as well.

    The singular values of their columns, less what the others' columns can make up for, are noise over error.
    """
    own, others = solution.jacobian[:, :first], solution.jacobian[:, first:]
    if others.shape[1]:
        basis, sizes, _ = np.linalg.svd(others, full_matrices=False)
        basis = basis[:, sizes > 1e-12 * max(float(sizes[0]), 1e-300)]
        own = own - basis @ (basis.T @ own)
    _, sizes, directions = np.linalg.svd(own, full_matrices=False)
    errors = solution.noise / np.maximum(sizes, 1e-300)
    # What is below the accuracy of the slopes is nothing, however little noise there is.
    errors = np.where(sizes < 1e-6 * sizes[0], np.inf, errors)
    return Certainty(directions, errors, float(student.ppf(0.5 + 0.5 * CONFIDENCE, solution.freedom)))
