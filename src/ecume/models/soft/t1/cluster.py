"""Four spheres that exchange neighbors: the scene and its results."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ecume.laws.soft_pair import SoftPair, passage_time
from ecume.models.soft.setup.building import prefactors_of
from ecume.scenes.soft import FilmSpec, IntegrationSpec, SoftLiquid, SoftScene, SphereSpec, StageSpec
from ecume.units import Array

APART, MET = 1.0, 0.2
"""With a diagonal gap of one radius the cluster has dissociated. If the vertical pair was as close as this before, the
neighbors were exchanged nevertheless, and the cluster was pulled apart afterwards."""
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
    """for every given threshold"""
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


def t1_scene(gap: float, forces: tuple[float, float], prefactors: str, ramp: float, rtol: float) -> SoftScene:
    """The cluster in units of radius, modulus and eta R^2 / F_N."""
    horizontal, vertical = forces
    kappa = abs(horizontal - vertical / SQRT3)
    side = 2.0 + gap
    pulls = ((horizontal, 0.0), (-horizontal, 0.0), (0.0, -vertical), (0.0, vertical))
    places = ((-side / 2, 0.0), (side / 2, 0.0), (0.0, side * SQRT3 / 2), (0.0, -side * SQRT3 / 2))
    films = FilmSpec(prefactors=prefactors, tangential_law="secant", tension_law="symmetric")
    # A scene keeps its numbers within what is physical: forces and viscosity are in proportion, so that E is 1.
    parting = passage_time(SoftPair(1.0, 1.0, kappa, prefactors_of(films)), kappa, gap, max(1.0, 2.0 * gap))
    horizon = min(PATIENCE * parting + 60.0 + ramp, 1e10)
    return SoftScene(
        title="A T1 process",
        duration=horizon,
        frame_every=horizon,
        liquid=SoftLiquid(viscosity=kappa),
        particles=tuple(
            SphereSpec(name=f"{name}", radius=1.0, modulus=1.0, positions=(place,), force=pull)
            for name, place, pull in zip(("left", "right", "top", "bottom"), places, pulls, strict=True)
        ),
        films=films,
        protocol=(StageSpec(time=0.0, load=0.0), StageSpec(time=ramp, load=1.0)),
        integration=IntegrationSpec(tolerance=rtol),
    )


class Units(NamedTuple):
    """Units of the series (m, N)."""

    length: float
    force: float


class Effort(NamedTuple):
    """The cost of an integration, and the residual of its force balance."""

    steps: int
    rejected: int
    imbalance: float
    """the largest force (F_N) that was left on a sphere at the end of a step"""
    turned: float = 0.0
    """the largest angle (rad) by which a sphere has spun"""


def told(
    series: Sequence[Instant], found: Sequence[float], thresholds: Sequence[float], kappa: float, effort: Effort
) -> T1:
    """The result for a cluster that crossed the first of these thresholds at the times `found`."""
    missing = [math.inf] * (len(thresholds) - len(found))
    durations = dict(zip(thresholds, [*found, *missing], strict=True))
    last = durations[thresholds[-1]]
    outcome = "t1" if math.isfinite(last) else _end(series)
    return T1(last, math.isfinite(last), outcome, durations, kappa, *effort, tuple(series))


def _end(series: Sequence[Instant]) -> str:
    """The result for a cluster whose vertical pair never carried its force."""
    if series[-1].gap_diagonal <= APART:
        return "blocked"
    return "t1" if min(instant.gap_vertical for instant in series) < MET else "dissociated"


def reached(instant: Instant, goal: float) -> bool:
    """Whether the vertical pair, once it is the closer one, carries that force; a negative goal is never reached.

    At first the distant vertical pair has a peak of force: a wide film has a large contact, and its surface is stiff.
    """
    swapped = instant.gap_vertical < instant.gap_horizontal
    return goal > 0.0 and swapped and -instant.tension_vertical >= goal
