"""Four spheres that exchange neighbors: the scene and its results."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ecume.laws.soft_pair import SoftPair, passage_time
from ecume.models.soft.setup import prefactors_of
from ecume.scenes.soft import FilmSpec, IntegrationSpec, SoftLiquid, SoftScene, SphereSpec, StageSpec
from ecume.units import Array

APART, MET = 1.0, 0.2
"""With a diagonal gap of one radius the cluster has dissociated. If the vertical pair was as close as this before, the
neighbors were exchanged nevertheless, and the cluster was pulled apart afterwards."""
LONGEST = 1e10
"""s: the longest duration of a scene."""
PATIENCE = 30.0
"""A process that takes this many times the closed-form time to part the horizontal pair, and 60 units, is blocked."""
SQRT3 = math.sqrt(3.0)
HORIZONTAL, DIAGONAL, VERTICAL = 0, 1, 5
"""Places of the contacts (0, 1), (0, 2) and (2, 3) among the six."""


class Instant(NamedTuple):
    """The cluster at one time; diagonal is the bond from sphere 0 to sphere 2."""

    time: float
    angle: float
    """of the diagonal from the horizontal (rad)"""
    gap_horizontal: float
    gap_vertical: float
    gap_diagonal: float
    tension_horizontal: float
    tension_vertical: float
    tension_diagonal: float
    sliding_force: float
    """along the diagonals' surfaces: positive holds the swap back"""


@dataclass(frozen=True)
class T1:
    """The result of a T1 process."""

    duration: float
    """until the vertical pair carries its part; infinite where it never does"""
    completed: bool
    """whether it ever did"""
    outcome: str
    """`t1`, `blocked` or `dissociated`; `t1` also where the cluster swapped neighbors and was torn before it completed
    """
    durations: dict[float, float]
    """for every given threshold, in the given order"""
    reduced_force: float
    """kappa = F_N / (E R^2)"""
    steps: int
    rejected: int
    imbalance: float
    """the largest force (F_N) that was left on a sphere at the end of a step"""
    turned: float
    """the largest angle (rad) by which a sphere has spun"""
    series: tuple[Instant, ...]

    @property
    def time(self) -> Array:
        """Times of the series."""
        return self.curve("time")

    def curve(self, name: str) -> Array:
        """A field of `Instant` over time: forces in F_N, gaps in radii."""
        return np.array([getattr(instant, name) for instant in self.series])


def parting(gap: float, kappa: float, prefactors: str) -> float:
    """The closed-form time to part the horizontal pair to a radius (eta R^2 / F_N)."""
    pair = SoftPair(1.0, 1.0, kappa, prefactors_of(FilmSpec(prefactors=prefactors)))
    return passage_time(pair, kappa, gap, max(1.0, 2.0 * gap))


def horizon(gap: float, kappa: float, prefactors: str, ramp: float) -> float:
    """The time (eta R^2 / F_N) at which a cluster that has not exchanged neighbors is blocked."""
    return PATIENCE * parting(gap, kappa, prefactors) + 60.0 + ramp


def seconds(end: float) -> float:
    """The unit of time of a scene that ends then: 1 s, or less where it would exceed the longest duration of a
    scene.
    """
    return min(1.0, LONGEST / end)


def t1_scene(gap: float, forces: tuple[float, float], prefactors: str, ramp: float, rtol: float) -> SoftScene:
    """The cluster in units of radius, modulus and eta R^2 / F_N, which are so many `seconds`."""
    horizontal, vertical = forces
    kappa = abs(horizontal - vertical / SQRT3)
    side = 2.0 + gap
    pulls = ((horizontal, 0.0), (-horizontal, 0.0), (0.0, -vertical), (0.0, vertical))
    places = ((-side / 2, 0.0), (side / 2, 0.0), (0.0, side * SQRT3 / 2), (0.0, -side * SQRT3 / 2))
    films = FilmSpec(prefactors=prefactors, tangential_law="secant", tension_law="symmetric")
    # A scene keeps its numbers within what is physical: forces and viscosity are in proportion, so that E is 1.
    end = horizon(gap, kappa, prefactors, ramp)
    second = seconds(end)
    return SoftScene(
        title="A T1 process",
        duration=second * end,
        frame_every=second * end,
        liquid=SoftLiquid(viscosity=second * kappa),
        particles=tuple(
            SphereSpec(name=f"{name}", radius=1.0, modulus=1.0, positions=(place,), force=pull)
            for name, place, pull in zip(("left", "right", "top", "bottom"), places, pulls, strict=True)
        ),
        films=films,
        protocol=(StageSpec(time=0.0, load=0.0), StageSpec(time=second * ramp, load=1.0)),
        integration=IntegrationSpec(tolerance=rtol),
    )


class Units(NamedTuple):
    """Units of the series (m, N, s)."""

    length: float
    force: float
    time: float


class Effort(NamedTuple):
    """The cost of an integration, and the residual of its force balance."""

    steps: int
    rejected: int
    imbalance: float
    """the largest force (F_N) that was left on a sphere at the end of a step"""
    turned: float = 0.0
    """the largest angle (rad) by which a sphere has spun"""


def result_of(
    series: Sequence[Instant], found: Sequence[float], thresholds: Sequence[float], kappa: float, effort: Effort
) -> T1:
    """The result for a cluster that reached its thresholds at the times `found`; infinite where it never did."""
    last = found[-1]
    outcome = "t1" if math.isfinite(last) else _end(series)
    durations = dict(zip(thresholds, found, strict=True))
    return T1(last, math.isfinite(last), outcome, durations, kappa, *effort, tuple(series))


def _end(series: Sequence[Instant]) -> str:
    """The result for a cluster whose vertical pair never carried its force."""
    if series[-1].gap_diagonal <= APART:
        return "blocked"
    return "t1" if min(instant.gap_vertical for instant in series) < MET else "dissociated"


class Seen(NamedTuple):
    """Times of each goal, infinite as long as it is not reached."""

    since: Array
    """from which on the vertical pair carries the force"""
    found: Array
    """the same, once the vertical pair is the closer one"""


def unseen(goals: Sequence[float]) -> Seen:
    """The beginning."""
    return Seen(np.full(len(goals), math.inf), np.full(len(goals), math.inf))


def watch(goals: Sequence[float], seen: Seen, begin: Instant, end: Instant, crossing: Callable[[float], float]) -> bool:
    """Take note of a step; whether all goals are found. `crossing` is the time in it at which a force is reached.

    At first the distant vertical pair has a peak of force: a wide film has a large contact, and its surface is stiff.
    So a time counts once the vertical pair is the closer one, and only if the force has not fallen below since. A goal
    that is not positive is never reached.
    """
    for k, goal in enumerate(goals):
        if goal <= 0.0 or -end.tension_vertical < goal:
            seen.since[k] = math.inf
        elif -begin.tension_vertical < goal:
            seen.since[k] = crossing(goal)
        if end.gap_vertical < end.gap_horizontal:
            seen.found[k] = min(seen.found[k], seen.since[k])
    return bool(np.isfinite(seen.found).all())
