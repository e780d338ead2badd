"""The fit of a scene's parameters to tracks: estimates with intervals and remarks.

Least squares over simulations: residuals, minimum, and uncertainty of the result.
"""

from __future__ import annotations

import copy
import math
import os
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline, make_interp_spline
from scipy.optimize import least_squares, linear_sum_assignment
from scipy.stats import t as student

from ecume.analysis.series import unwrapped
from ecume.errors import BadInput, Diverged
from ecume.fitting.parameters import Free, Quantity, free_parameters, quantities_of, with_values
from ecume.fitting.tracks import (
    Camera,
    Tracks,
    cut,
    first_frame,
    first_seen,
    first_speeds,
    keeps_kinds,
    matched,
    read_tracks,
    require_deterministic,
    require_starts,
    start_at,
)
from ecume.models import MODELS
from ecume.scenes.faults import suggestion
from ecume.scenes.load import load_scene
from ecume.scenes.schema import Scene, from_plain, to_plain
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array, with_prefix

STARTS = ("positions", "moving", "scene")
"""The fitted part of the initial state: positions, positions and velocities, or none."""
LEAST_FRAMES = 50
"""The least number of frames of a simulation. Between frames positions are interpolated by cubics, with the velocities
of the frames.
"""
FAR = 1e3
"""The residual, in units of the reach, for parameters without a possible simulation, which the fit therefore avoids."""


Law = Callable[..., float]


class Problem(NamedTuple):
    """The problem of a fit: tracks in the order of the scene's particles, and the varied parts of the scene."""

    plain: dict[str, Any]
    free: list[Free]
    tracks: Tracks
    start: str
    """one of STARTS"""
    reach: float
    """m: the scale of distances between objects and of their displacements, the unit of the initial coordinates"""
    first: Array
    """(N, 2) m: the positions for which the initial coordinates are zero"""
    speed: Array
    """(N, 2) m/s: the same for velocities"""
    laws: tuple[Law, ...] = ()
    """the user's"""

    @property
    def seen(self) -> Any:
        """Flags (T, N) of the measurements that exist."""
        return np.isfinite(self.tracks.position[:, :, 0])

    @property
    def starts(self) -> int:
        """The number of initial coordinates."""
        return {"positions": 1, "moving": 2, "scene": 0}[self.start] * self.first.size


def timed(plain: dict[str, Any], tracks: Tracks) -> dict[str, Any]:
    """The scene with the duration of the tracks, frames at least at the rate of the camera, and a
    constant time step.

    With a time step that depends on the parameters, the number of steps per frame, and therefore the residuals, would
    be discontinuous.
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
    """The coordinates at the start of the fit."""
    own = [free.coordinate(free.value) for free in problem.free]
    return np.concatenate([own, np.zeros(problem.starts)])


def values_at(problem: Problem, coordinates: Array) -> list[float]:
    """The parameters at these coordinates."""
    return [free.at(float(at)) for free, at in zip(problem.free, coordinates, strict=False)]


def scene_at(problem: Problem, coordinates: Array) -> Scene:
    """The scene at these coordinates. Raises BadInput for invalid scenes."""
    plain = with_values(copy.deepcopy(problem.plain), problem.free, values_at(problem, coordinates))
    if problem.start != "scene":
        shift = coordinates[len(problem.free) :].reshape(-1, *problem.first.shape) * problem.reach
        duration = float(problem.tracks.times[-1])
        velocity = problem.speed + shift[1] / duration if problem.start == "moving" else None
        start_at(plain, problem.first + shift[0], velocity)
    return from_plain(plain)


def simulated(scene: Scene, times: Array, laws: Sequence[Law] = ()) -> Array:
    """The simulated positions at these times (T, N, 2) (m)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # hide warnings on time steps, which were chosen here
        frames = list(simulate(scene, extra_laws=laws))
    return positions_at(frames, times)


def positions_at(frames: Sequence[Frame], times: Array) -> Array:
    """Positions interpolated between frames, by cubics if frames have velocities and linearly otherwise; continuous
    across the borders of a periodic cell.
    """
    instants = np.array([frame.time for frame in frames])
    position = np.stack([unwrapped(frame) for frame in frames])
    at = np.minimum(times, instants[-1])
    if "velocity" in frames[0].arrays:
        velocity = np.stack([frame.arrays["velocity"] for frame in frames])
        return np.asarray(CubicHermiteSpline(instants, position, velocity)(at))
    return np.asarray(make_interp_spline(instants, position, k=1)(at))


def residuals(problem: Problem, coordinates: Array) -> Array:
    """The differences of simulated and measured positions over the reach, for existing measurements."""
    try:
        there = simulated(scene_at(problem, coordinates), problem.tracks.times, problem.laws)
    except (BadInput, Diverged):  # floats sink, overlap or diverge
        return np.full(2 * int(problem.seen.sum()), FAR)
    return np.asarray((there - problem.tracks.position)[problem.seen].ravel() / problem.reach)


STEP = 1e-5
"""The relative step of coordinates for derivatives; simulations are smooth to about 1e-12."""
MOST_ROUNDS = 60
LOOSE = 0.7
"""The standard error of ln(p) above which a parameter counts as undetermined: a factor of two in either direction."""
CONFIDENCE = 0.95


class Solution(NamedTuple):
    """The minimum of the sum of squares."""

    coordinates: Array
    residuals: Array
    jacobian: Array
    converged: bool
    rounds: int

    @property
    def freedom(self) -> int:
        """The degrees of freedom: the number of measured values minus that of fitted ones."""
        return max(len(self.residuals) - len(self.coordinates), 1)

    @property
    def noise(self) -> float:
        """The standard deviation of a measured value, in the unit of the residuals."""
        return float(np.sqrt(np.sum(self.residuals**2) / self.freedom))


def solved(residuals: Callable[[Array], Array], start: Array) -> Solution:
    """The least-squares solution near a start, by a trust-region method; coordinates without influence on the residuals
    do not change.
    """

    def slopes(at: Array) -> Array:
        here = residuals(at)
        columns = [(residuals(at + STEP * unit) - here) / STEP for unit in np.eye(len(at))]
        return np.stack(columns, axis=1)

    found: Any = least_squares(
        residuals, start, slopes, method="trf", tr_solver="exact", max_nfev=MOST_ROUNDS, xtol=1e-7, ftol=1e-8
    )
    return Solution(found.x, found.fun, found.jac, bool(found.status > 0), int(found.nfev))


class Certainty(NamedTuple):
    """The uncertainty of the first coordinates, with all others fitted as well.

    `directions` are orthonormal rows in the space of these coordinates, `errors` the standard error along each.
    """

    directions: Array
    errors: Array
    quantile: float
    """of Student's distribution: the half width of an interval in standard errors"""

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
"""The largest fraction of a quantity's gradient along undetermined directions for which the quantity counts as
determined.
"""


def certainty(solution: Solution, first: int) -> Certainty:
    """The errors of the first coordinates from the Jacobian and the noise, with all others fitted as well.

    The columns of the first coordinates are made orthogonal to those of the others. Their singular values are noise
    over standard error.
    """
    own, others = solution.jacobian[:, :first], solution.jacobian[:, first:]
    if others.shape[1]:
        basis, sizes, _ = np.linalg.svd(others, full_matrices=False)
        basis = basis[:, sizes > 1e-12 * max(float(sizes[0]), 1e-300)]
        own = own - basis @ (basis.T @ own)
    _, sizes, directions = np.linalg.svd(own, full_matrices=False)
    errors = solution.noise / np.maximum(sizes, 1e-300)
    # Singular values below the accuracy of the derivatives count as zero, even without noise.
    errors = np.where(sizes < 1e-6 * sizes[0], np.inf, errors)
    return Certainty(directions, errors, float(student.ppf(0.5 + 0.5 * CONFIDENCE, solution.freedom)))


class Estimate(NamedTuple):
    """A number with its 95 % interval; without an interval if the tracks do not determine it."""

    name: str
    value: float
    low: float
    high: float
    unit: str

    @property
    def determined(self) -> bool:
        """Whether the tracks determine the parameter."""
        return math.isfinite(self.high)


class Fit(NamedTuple):
    """The result of a fit."""

    scene: Scene
    """with the fitted parameters"""
    estimates: list[Estimate]
    """of the free parameters"""
    derived: list[Estimate]
    """of derived quantities"""
    noise: float
    """m: the standard deviation of the residuals of single measured numbers"""
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
    extra_laws: Sequence[Law] = (),
) -> Fit:
    """Fit parameters of a scene to tracks: least squares of the differences of simulated and
    measured positions.

    `free` are keys such as `contact_angle`, or paths such as `particles[0].radius`; the scene has their initial values
    and everything else. `start` selects what is fitted together with them: `positions` of all particles at the first
    instant, `moving` for velocities as well, `scene` for nothing. Observations later than `until` (s) are ignored, for
    example contacts. `extra_laws` are user-defined laws. Noise is assumed to be the same for all measured numbers, and
    independent.
    """
    measured = tracks if isinstance(tracks, Tracks) else read_tracks(tracks, camera)
    asked = load_scene(scene) if isinstance(scene, (str, Path)) else scene
    problem = posed(cut(measured, until), to_plain(asked), free, start)._replace(laws=tuple(extra_laws))
    simulated(
        scene_at(problem, origin(problem)), measured.times, problem.laws
    )  # the message on an invalid initial state is not changed
    solution = solved(lambda at: residuals(problem, at), origin(problem))
    return concluded(problem, solution)


def posed(measured: Tracks, plain: dict[str, Any], names: Sequence[str], start: str) -> Problem:
    """The problem of a fit. Raises BadInput if the tracks do not fit the scene."""
    if start not in STARTS:
        raise BadInput(f"start: got {start!r}; {suggestion(start, STARTS)}")
    free = free_parameters(plain, names)
    require_deterministic(plain)
    if start != "scene":
        require_starts(plain, moving=start == "moving")
    plain = timed(plain, measured)
    frame = first_frame(from_plain(plain | {"user_laws": []}))
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
    there = simulated(scene, problem.tracks.times, problem.laws)
    estimates = [_estimate(problem.free[n], float(at[n]), sure, n) for n in range(len(problem.free))]
    derived = derived_estimates(problem, at, sure)
    noise = solution.noise * problem.reach
    left = there - problem.tracks.position
    remarks = [
        *swapped(problem.tracks),
        *unsure(problem, at, sure),
        *met(scene, problem.tracks.times, there),
        *outlier(problem, left),
        *no_noise(problem, left),
    ]
    if not solution.converged:
        remarks.insert(0, f"the fit had not settled after {solution.rounds} rounds; begin nearer")
    return Fit(scene, estimates, derived, noise, remarks, problem.tracks, there, solution.rounds)


def _estimate(free: Free, at: float, sure: Certainty, number: int) -> Estimate:
    """The estimate of a parameter, with an interval that is symmetric in its coordinate."""
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


MEMORY = 0.5
"""The correlation of successive residuals above which they are not noise."""
TOUCHING = 0.005
"""The gap, over both radii, below which two particles count as touching."""
MOST_PAIRED = 1000
"""The largest number of particles all of whose pairs are tested."""
SHOWN = 0.1
"""The least exponent of a parameter in a combination that is printed."""
SHORTER = 0.3
"""The fraction of the sum of squared displacements that remains after an exchange of two names, below which the names
count as swapped.
"""
MOST_OUTLIERS = 0.1
"""The largest fraction of measurements that count as outliers; above it, the model is the likely cause."""
OUTLIER = 6.0
"""The ratio to the median residual above which a measurement is an outlier; Gaussian noise exceeds it once in 1e10."""


def swapped(tracks: Tracks) -> list[str]:
    """A remark if the names of objects seem to be exchanged, as after an error of a tracking program.

    With correct names, the sum of squared displacements between two instants is minimal.
    """
    if len(tracks.names) > MOST_PAIRED:
        return []
    for before, after in zip(range(len(tracks.times)), range(1, len(tracks.times)), strict=False):
        here, there = tracks.position[before], tracks.position[after]
        both = np.flatnonzero(np.isfinite(here[:, 0]) & np.isfinite(there[:, 0]))
        ways = np.sum((here[both][:, None] - there[both][None]) ** 2, axis=2)
        order = linear_sum_assignment(ways)[1]
        if ways[range(len(both)), order].sum() < SHORTER * np.trace(ways):
            names = ", ".join(tracks.names[both[place]] for place in range(len(both)) if order[place] != place)
            return [f"objects {names} seem to swap names at t = {tracks.times[after]:.4g} s; correct the tracks"]
    return []


def outlier(problem: Problem, left: Array) -> list[str]:
    """A remark on single measurements that are far from the positions implied by all others."""
    off = np.linalg.norm(left, axis=2)
    far = np.flatnonzero(off[problem.seen] > OUTLIER * np.median(off[problem.seen]))
    if len(far) == 0 or len(far) > MOST_OUTLIERS * problem.seen.sum():
        return []
    instants, objects = (places[far] for places in np.nonzero(problem.seen))
    worst = int(np.argmax(off[instants, objects]))
    who, when = problem.tracks.names[objects[worst]], problem.tracks.times[instants[worst]]
    more = f", and {len(far) - 1} more" if len(far) > 1 else ""
    size = f"{with_prefix(off[instants[worst], objects[worst]], 'm', 2)}"
    return [f"object {who} is {size} off at t = {when:.4g} s{more}: more than noise; delete such lines"]


def unsure(problem: Problem, at: Array, sure: Certainty) -> list[str]:
    """Remarks on combinations of parameters that the tracks do not determine, and on those that they do."""
    loose, count = ~sure.determined, len(sure.errors)
    if not loose.any():
        return []
    message = (
        f"the tracks determine {count - int(loose.sum())} of {count} combinations; "
        f"undetermined: {'; '.join(_combination(problem, at, row) for row in sure.directions[loose])}"
    )
    known = [
        f"{_combination(problem, at, row)} to {100.0 * sure.quantile * error:.2g} %"
        for row, error in zip(sure.directions[~loose], sure.errors[~loose], strict=True)
    ]
    hint = ["hold one of them fixed to know the others"] if count > 1 else []
    return [message, *([f"determined: {'; '.join(known)}"] if known else []), *hint]


def _combination(problem: Problem, at: Array, direction: Array) -> str:
    """The product of powers of the parameters whose logarithm changes along a direction, and not
    perpendicular to it.

    The logarithm of p1^a p2^b has the derivatives a and b by ln(p); `steepness` converts from coordinates to ln(p).
    """
    values = values_at(problem, at)
    powers = [part / free.steepness(value) for part, free, value in zip(direction, problem.free, values, strict=True)]
    largest = max(powers, key=abs)
    shares = [(free.name, power / largest) for free, power in zip(problem.free, powers, strict=True)]
    shown = [(name, share) for name, share in shares if abs(share) >= SHOWN]
    return " ".join(name if abs(share - 1.0) < 5e-3 else f"{name}^{share:.2g}" for name, share in shown)


def met(scene: Scene, times: Array, there: Array) -> list[str]:
    """A remark if particles touch: the time of contact is resolved only to one step, so that residuals are not smooth
    afterwards.
    """
    if scene.model != "floating":  # soft spheres deform, and tracers do not interact
        return []
    radius = first_frame(scene).arrays["radius"]
    if len(radius) > MOST_PAIRED:
        return []
    one, other = np.triu_indices(len(radius), 1)
    gap = np.linalg.norm(there[:, one] - there[:, other], axis=2) - radius[one] - radius[other]
    touching = (gap < TOUCHING * (radius[one] + radius[other])).any(axis=1)
    if not touching.any():
        return []
    when = float(times[np.argmax(touching)])
    return [f"particles touch at t = {when:.4g} s; later data say little and make the fit rough; use --until"]


def no_noise(problem: Problem, left: Array) -> list[str]:
    """A remark if residuals are correlated in time: the scene then neglects an effect, and intervals are too narrow."""
    seen = problem.seen
    both = seen[1:] & seen[:-1]
    one, other = left[:-1][both].ravel(), left[1:][both].ravel()
    size = float(np.sqrt(np.sum(one**2) * np.sum(other**2)))
    if len(one) < 20 or size == 0.0 or float(np.sum(one * other)) / size < MEMORY:
        return []
    return ["the residuals are not noise but correlated in time: the scene lacks an effect; intervals are too narrow"]
