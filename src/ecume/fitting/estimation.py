"""The fit of a scene's parameters to tracks: from tracks to estimates with intervals and remarks."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from ecume.errors import BadInput
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
    values_at,
)
from ecume.fitting.parameters import Free, Quantity, free_parameters, quantities_of
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
    require_no_chance,
    require_starts,
)
from ecume.scenes.faults import suggestion
from ecume.scenes.load import load_scene
from ecume.scenes.schema import Scene, from_plain, to_plain
from ecume.units import Array
from ecume.value_texts import with_prefix


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


MEMORY = 0.5
"""The correlation of neighboring residuals beyond which they are no noise."""
TOUCHING = 0.005
"""The gap, over both radii, below which two particles count as touching."""
MOST_PAIRED = 1000
"""Particles whose pairs are looked at one by one."""
SHOWN = 0.1
"""The least power of a parameter in a combination that is printed."""
SHORTER = 0.3
"""The part of their way, in squares, that is left where two objects exchange names: then they had been exchanged."""
MOST_ASTRAY = 0.1
"""Of the measurements; where more are far off it is not they that are wrong."""
ASTRAY = 6.0
"""So many times the median residual a measurement is no noise: of Gaussian noise one in 1e10 would be."""


def swapped(tracks: Tracks) -> list[str]:
    """A remark where objects seem to exchange names, as when a tracking program mixes them up.

    From instant to instant the sum of all displacements is the smallest possible, or a name is wrong.
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


def astray(problem: Problem, left: Array) -> list[str]:
    """A remark where single measurements lie far from where all others would have them."""
    off = np.linalg.norm(left, axis=2)
    far = np.flatnonzero(off[problem.seen] > ASTRAY * np.median(off[problem.seen]))
    if len(far) == 0 or len(far) > MOST_ASTRAY * problem.seen.sum():
        return []
    instants, objects = (places[far] for places in np.nonzero(problem.seen))
    worst = int(np.argmax(off[instants, objects]))
    who, when = problem.tracks.names[objects[worst]], problem.tracks.times[instants[worst]]
    more = f", and {len(far) - 1} more" if len(far) > 1 else ""
    size = f"{with_prefix(off[instants[worst], objects[worst]], 'm', 2)}"
    return [f"object {who} is {size} off at t = {when:.4g} s{more}: more than noise; delete such lines"]


def unsure(problem: Problem, at: Array, sure: Certainty) -> list[str]:
    """The combinations of the parameters that the tracks do not determine, and those that they do."""
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
    """A direction as a product of powers: its logarithm changes along it, and not across it.

    The logarithm of p1^a p2^b has the slopes a and b in ln(p); one coordinate's slope is a part of ln(p)'s.
    """
    values = values_at(problem, at)
    powers = [part / free.steepness(value) for part, free, value in zip(direction, problem.free, values, strict=True)]
    largest = max(powers, key=abs)
    shares = [(free.name, power / largest) for free, power in zip(problem.free, powers, strict=True)]
    shown = [(name, share) for name, share in shares if abs(share) >= SHOWN]
    return " ".join(name if abs(share - 1.0) < 5e-3 else f"{name}^{share:.2g}" for name, share in shown)


def met(scene: Scene, times: Array, there: Array) -> list[str]:
    """A remark where particles touch: when they do is known to a step, so that the residuals are rough from then on."""
    if scene.model != "floating":  # soft spheres deform, tracers do not feel one another
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
    """A remark if residuals are correlated in time: then the scene lacks an effect, and intervals are too narrow."""
    seen = problem.seen
    both = seen[1:] & seen[:-1]
    one, other = left[:-1][both].ravel(), left[1:][both].ravel()
    size = float(np.sqrt(np.sum(one**2) * np.sum(other**2)))
    if len(one) < 20 or size == 0.0 or float(np.sum(one * other)) / size < MEMORY:
        return []
    return ["the residuals are not noise but correlated in time: the scene lacks an effect; intervals are too narrow"]
