"""Four spheres that exchange neighbors: the scene and its results.

Here the unknowns of the T1 process are the deflections, for forces so small that deflections are below the rounding
error of positions.

A cluster that is symmetric about two axes has a horizontal film, a vertical film, and diagonal films, which are equal.
Its state consists of their ln(gap), the angle of the diagonal gap vector G_d, and the closure C = (G_h/2, G_v/2) - G_d,
the sum of gap vectors around half a diamond. The closure is the difference between the deflections, has their
magnitude, and obeys a separate equation. The deflection of a diagonal is C plus half the horizontal and half the
vertical one, which balance the forces. Spheres do not rotate in a symmetric cluster. [rognon2009, eq. 1 to 16].
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ecume._portable import exp
from ecume.errors import Diverged
from ecume.laws.soft_pair import (
    Prefactors,
    SoftPair,
    contact_size,
    passage_time,
    shear_friction,
    squeeze_friction,
    surface_stiffness,
)
from ecume.models.soft.setup import prefactors_of
from ecume.scenes.soft import FilmSpec, IntegrationSpec, SoftLiquid, SoftScene, SphereSpec, StageSpec
from ecume.units import Array

APART, MET = 1.0, 0.2
"""The gap of diagonals (radii) at which a cluster has dissociated, and the gap of the vertical pair below which it had
exchanged neighbors before it was pulled apart.
"""
THRESHOLD = 0.9
"""The part of the forces at which the process is complete by default."""
LONGEST = 1e10
"""s: the longest duration of a scene."""
PATIENCE = 30.0
"""A process is blocked if it takes longer than PATIENCE times the closed-form time to separate the horizontal pair,
plus 60 units.
"""
SQRT3 = math.sqrt(3.0)
HORIZONTAL, DIAGONAL, VERTICAL = 0, 1, 5
"""Places of the contacts (0, 1), (0, 2) and (2, 3) among the six."""
DIAGONALS = (1, 2, 3, 4)
"""Places of the contacts of the diagonals."""


class Instant(NamedTuple):
    """The cluster at one time; the diagonal is the bond from sphere 0 to sphere 2."""

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
    """along the surfaces of the diagonals; positive resists the exchange"""


@dataclass(frozen=True)
class T1:
    """The result of a T1 process."""

    duration: float
    """until the vertical pair carries its part; infinite if it never does"""
    completed: bool
    """whether the vertical pair carried its part"""
    outcome: str
    """`t1`, `blocked` or `dissociated`; `t1` also if the cluster exchanged neighbors and was torn before completion"""
    durations: dict[float, float]
    """by threshold, in the given order"""
    reduced_force: float
    """kappa = F_N / (E R^2)"""
    steps: int
    rejected: int
    imbalance: float
    """the largest residual force (F_N) on a sphere at the end of a step"""
    turned: float
    """the largest angle (rad) by which a sphere has spun"""
    series: tuple[Instant, ...]

    @property
    def time(self) -> Array:
        """The times of the series."""
        return self.curve("time")

    def curve(self, name: str) -> Array:
        """A field of `Instant` over time: forces in F_N, gaps in radii."""
        return np.array([getattr(instant, name) for instant in self.series])


def parting(gap: float, kappa: float, prefactors: str) -> float:
    """The closed-form time to separate the horizontal pair to a radius (eta R^2 / F_N)."""
    pair = SoftPair(1.0, 1.0, kappa, prefactors_of(FilmSpec(prefactors=prefactors)))
    return passage_time(pair, kappa, gap, max(1.0, 2.0 * gap))


def horizon(gap: float, kappa: float, prefactors: str, ramp: float) -> float:
    """The time (eta R^2 / F_N) after which a cluster counts as blocked if it has not exchanged neighbors."""
    return PATIENCE * parting(gap, kappa, prefactors) + 60.0 + ramp


def seconds(end: float) -> float:
    """The unit of time of a scene with this end: 1 s, or less if the scene would exceed the longest duration."""
    return min(1.0, LONGEST / end)


def t1_scene(gap: float, forces: tuple[float, float], prefactors: str, ramp: float, rtol: float) -> SoftScene:
    """The scene of a cluster in units of radius, modulus and eta R^2 / F_N; the latter is `seconds` long."""
    horizontal, vertical = forces
    kappa = abs(horizontal - vertical / SQRT3)
    side = 2.0 + gap
    pulls = ((horizontal, 0.0), (-horizontal, 0.0), (0.0, -vertical), (0.0, vertical))
    places = ((-side / 2, 0.0), (side / 2, 0.0), (0.0, side * SQRT3 / 2), (0.0, -side * SQRT3 / 2))
    films = FilmSpec(prefactors=prefactors, tangential_law="secant", tension_law="symmetric")
    # Forces and viscosity are scaled so that the modulus is 1 and all numbers are within the limits of scenes.
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
    """the largest residual force (F_N) on a sphere at the end of a step"""
    turned: float = 0.0
    """the largest angle (rad) by which a sphere has spun"""


def result_of(
    series: Sequence[Instant], found: Sequence[float], thresholds: Sequence[float], kappa: float, effort: Effort
) -> T1:
    """The result for a cluster that reached its thresholds at the times `found`, which are infinite for thresholds
    never reached.
    """
    last = found[-1]
    least = min(instant.gap_vertical for instant in series)
    outcome = OUTCOMES[outcome_at(last, series[-1].gap_diagonal, least)]
    durations = dict(zip(thresholds, found, strict=True))
    return T1(last, math.isfinite(last), outcome, durations, kappa, *effort, tuple(series))


OUTCOMES = ("t1", "blocked", "dissociated")


def outcome_at(found: float, gap_diagonal: float, least_vertical: float) -> int:
    """The index in OUTCOMES of a cluster that completed at the time `found` (infinite if it never did) and ended with
    this diagonal gap; `least_vertical` is the smallest gap of the vertical pair during the process.
    """
    if found < math.inf or (gap_diagonal > APART and least_vertical < MET):
        return 0
    return 1 if gap_diagonal <= APART else 2


class ReachedGoals(NamedTuple):
    """The times at which goals were reached; infinite for goals not reached."""

    since: Array
    """since when the vertical pair has carried the force"""
    found: Array
    """since when it has also been the closer pair"""


def no_goals_reached(goals: Sequence[float]) -> ReachedGoals:
    """Infinite times: no goal is reached yet."""
    return ReachedGoals(np.full(len(goals), math.inf), np.full(len(goals), math.inf))


def goals_of(forces: tuple[float, float], thresholds: Sequence[float]) -> Array:
    """The goals of the thresholds: forces (F_N) of the vertical pair as parts of F_v - F_h/sqrt(3)."""
    horizontal, vertical = forces
    return np.array([one * (vertical - horizontal / SQRT3) / abs(horizontal - vertical / SQRT3) for one in thresholds])


def watch(
    goals: Sequence[float] | Array, seen: ReachedGoals, begin: Instant, end: Instant,
    crossing: Callable[[Any, float], float], given: Any,
) -> bool:  # fmt: skip
    """Record the goals reached in a step. Returns whether all are reached; `crossing(given, goal)` computes the time at
    which a force is reached.

    At first the distant vertical pair has a peak of force, since a wide film has a large contact with a stiff surface.
    Therefore a time counts only if the vertical pair is the closer one, and if the force does not decrease below the
    goal again. A goal that is not positive is never reached.
    """
    for k in range(len(goals)):
        goal = goals[k]
        if goal <= 0.0 or -end.tension_vertical < goal:
            seen.since[k] = math.inf
        elif -begin.tension_vertical < goal:
            seen.since[k] = crossing(given, goal)
        if end.gap_vertical < end.gap_horizontal:
            seen.found[k] = min(seen.found[k], seen.since[k])
    return bool(np.isfinite(seen.found).all())


REDUCED_RADIUS = 0.5
"""The reduced radius of equal spheres, in radii."""
MOST_ITERATIONS = 50
BALANCED, CLOSE = 1e-15, 1e-9
"""Convergence of the deflections: the last relative change, or CLOSE if the change no longer decreases."""
FIRST_STEP = 1e-6
"""The first step over the duration of the ramp."""
DIFFERENCE = 1e-6
"""The step of finite differences of the Jacobian."""
RELATIVE = 0.1
"""The relative tolerance of ln(gap) and angles, over the tolerance of a step."""


class Pull(NamedTuple):
    """The loading of a cluster."""

    horizontal: float
    vertical: float
    """inward forces, in units of the largest one"""
    scale: float
    """the largest force, in E R^2: the unit of deflections (R)"""
    viscosity: float
    """the viscosity that makes eta R^2 / F_N the unit of time"""
    ramp: float
    prefactors: Prefactors


class Contact(NamedTuple):
    """The normal response of a contact at a deflection."""

    tension: float
    stiffness: float
    """slope of the tension over the normal deflection"""
    size: float
    size_slope: float
    """of the contact size over the normal deflection"""


class Balance(NamedTuple):
    """A cluster in balance: forces and deflections in units of the largest force and deflection."""

    horizontal: float
    vertical: float
    """deflections"""
    contacts: tuple[Contact, Contact, Contact]
    """of the horizontal, the vertical and a diagonal pair"""
    sliding: float
    """the force along the diagonal's surface, from the horizontal to the vertical"""
    left: float
    """the largest residual force"""


def contact_at(pull: Pull, gap: float, deflection: float) -> Contact:
    """The normal response of two spheres."""
    factors = pull.prefactors
    depth = pull.scale * deflection
    size = contact_size(REDUCED_RADIUS, gap, depth, factors.gap_weight, factors.deflection_weight)
    stiffness = surface_stiffness(size, 1.0, factors.normal)
    slope = math.copysign(REDUCED_RADIUS * factors.deflection_weight * pull.scale / size, deflection)
    return Contact(stiffness * deflection, stiffness * (1.0 + deflection * slope / size), size, slope)


def balanced(pull: Pull, time: float, state: Array, guess: Array) -> Balance:
    """Solve for the horizontal and the vertical deflection by Newton's method, at constant gaps. `guess` is the initial
    guess, and receives the solution.
    """
    load = min(time / pull.ramp, 1.0)
    gaps = exp(state[:3])
    cosine, sine = math.cos(state[3]), math.sin(state[3])
    last = math.inf
    for _ in range(MOST_ITERATIONS):
        horizontal, vertical = contact_at(pull, gaps[0], guess[0]), contact_at(pull, gaps[1], guess[1])
        x, y = state[4] + 0.5 * guess[0], state[5] + 0.5 * guess[1]
        diagonal, shear = contact_at(pull, gaps[2], x * cosine + y * sine), y * cosine - x * sine
        tangential = surface_stiffness(diagonal.size, 1.0, pull.prefactors.tangential)
        sliding = tangential * shear
        left_x = load * pull.horizontal + horizontal.tension + 2.0 * (diagonal.tension * cosine - sliding * sine)
        left_y = load * pull.vertical + vertical.tension + 2.0 * (diagonal.tension * sine + sliding * cosine)
        found = Balance(guess[0], guess[1], (horizontal, vertical, diagonal), sliding, max(abs(left_x), abs(left_y)))
        by_normal = sliding * diagonal.size_slope / diagonal.size
        # Slopes of normal and tangential force over half the horizontal and half the vertical deflection.
        normal_x, normal_y = diagonal.stiffness * cosine, diagonal.stiffness * sine
        along_x, along_y = by_normal * cosine - tangential * sine, by_normal * sine + tangential * cosine
        xx = horizontal.stiffness + normal_x * cosine - along_x * sine
        xy = normal_y * cosine - along_y * sine
        yx = normal_x * sine + along_x * cosine
        yy = vertical.stiffness + normal_y * sine + along_y * cosine
        determinant = xx * yy - xy * yx
        change = (yy * left_x - xy * left_y) / determinant, (xx * left_y - yx * left_x) / determinant
        guess -= change
        size = max(map(abs, change)) / max(1.0, *np.abs(guess))
        if size <= BALANCED or size >= last < CLOSE:
            return found
        last = size
    raise Diverged(f"at t = {time:g} the deflections of the cluster cannot balance its forces")


def rates(pull: Pull, guess: Array, time: float, state: Array) -> Array:
    """The rates of the logarithmic gaps, angle and closure. The force of its surfaces drives each film."""
    balance, factors = balanced(pull, time, state, guess), pull.prefactors
    gaps = exp(state[:3])
    opening = np.array(
        [
            contact.tension / squeeze_friction(contact.size, gap, pull.viscosity, factors.squeeze)
            for contact, gap in zip(balance.contacts, gaps, strict=True)
        ]
    )
    slide = balance.sliding / shear_friction(balance.contacts[2].size, gaps[2], pull.viscosity, factors.shear)
    cosine, sine = math.cos(state[3]), math.sin(state[3])
    closing = (
        0.5 * opening[0] - opening[2] * cosine + slide * sine,
        0.5 * opening[1] - opening[2] * sine - slide * cosine,
    )
    return np.array([*opening / gaps, slide / (2.0 + gaps[2]), closing[0] / pull.scale, closing[1] / pull.scale])


def jacobian(pull: Pull, guess: Array, time: float, state: Array) -> Array:
    """The Jacobian of the rates by finite differences.

    The closure relaxes within a time kappa. Finite differences with increments of the order of the tolerance would be
    lost in rounding.
    """
    here, columns = rates(pull, guess, time, state), []
    for k in range(len(state)):
        there = state.copy()
        there[k] += DIFFERENCE * max(1.0, abs(state[k]))
        columns.append((rates(pull, guess, time, there) - here) / (there[k] - state[k]))
    return np.array(columns).T


def follow_symmetric(
    gap: float, forces: tuple[float, float], thresholds: Sequence[float], how: tuple[str, float, float]
) -> T1:
    """Integrate a cluster; `how` contains the set of prefactors, the ramp and the tolerance."""
    prefactors, ramp, tolerance = how
    kappa, scale = abs(forces[0] - forces[1] / SQRT3), max(map(abs, forces))
    factors = prefactors_of(FilmSpec(prefactors=prefactors))
    pull = Pull(forces[0] / scale, forces[1] / scale, scale, kappa / scale, ramp, factors)
    goals = goals_of(forces, thresholds).tolist()
    series, seen = [_instant(pull, 0.0, _start(gap), np.zeros(2))], no_goals_reached(goals)
    steps, left = 0, 0.0
    for end, between, residual in _steps(pull, gap, horizon(gap, kappa, prefactors, ramp), tolerance):
        begin, steps, left = series[-1], steps + 1, max(left, residual)
        series.append(end)
        if watch(goals, seen, begin, end, _crossing, (pull, begin, end, between)) or end.gap_diagonal > APART:
            break
    return result_of(series, list(seen.found), thresholds, kappa, Effort(steps, 0, left))


def _start(gap: float) -> Array:
    """The variables of the cluster without deflections."""
    far = SQRT3 * (2.0 + gap) - 2.0
    return np.array([math.log(gap), math.log(far), math.log(gap), math.pi / 3.0, 0.0, 0.0])


Between = Callable[[float], Array]
"""The state at a time within a step."""


def _steps(pull: Pull, gap: float, end: float, tolerance: float) -> Iterator[tuple[Instant, Between, float]]:
    """Integrate by Radau's implicit method. Yields the instant at the end of each step, the states in it, and the
    residual.
    """
    from scipy.integrate import Radau

    guess, state, begin = np.zeros(2), _start(gap), 0.0
    for stop in (pull.ramp, end):
        first = FIRST_STEP * min(pull.ramp, stop - begin)
        functions = partial(rates, pull, guess), partial(jacobian, pull, guess)
        solver = Radau(
            functions[0], begin, state, stop,
            jac=functions[1], rtol=RELATIVE * tolerance, atol=tolerance, first_step=first,
        )  # fmt: skip
        while solver.status == "running":
            if complaint := solver.step():
                raise Diverged(f"at t = {solver.t:g} no step is short enough; {complaint}")
            balance = balanced(pull, solver.t, solver.y, guess)
            yield _instant(pull, solver.t, solver.y, guess), solver.dense_output(), balance.left / pull.viscosity
        begin, state = solver.t, solver.y


def _instant(pull: Pull, time: float, state: Array, guess: Array) -> Instant:
    """The quantities of a series for a state."""
    balance, gaps = balanced(pull, time, state, guess), exp(state[:3])
    across = 2.0 + gaps[0] + pull.scale * balance.horizontal
    along = 2.0 + gaps[1] + pull.scale * balance.vertical
    horizontal, vertical, diagonal = (contact.tension / pull.viscosity for contact in balance.contacts)
    return Instant(
        time=time,
        angle=math.atan2(along, across),
        gap_horizontal=float(gaps[0]),
        gap_vertical=float(gaps[1]),
        gap_diagonal=float(gaps[2]),
        tension_horizontal=float(horizontal),
        tension_vertical=float(vertical),
        tension_diagonal=float(diagonal),
        sliding_force=float(-balance.sliding / pull.viscosity),
    )


def _crossing(given: tuple[Pull, Instant, Instant, Between], goal: float) -> float:
    """The time within a step at which the vertical pair carries the force `goal`."""
    from scipy.optimize import brentq

    (pull, begin, end, between), guess = given, np.zeros(2)

    def missing(time: float) -> float:
        return goal + _instant(pull, time, between(time), guess).tension_vertical

    if not missing(begin.time) > 0.0 > missing(end.time):
        return end.time
    return float(brentq(missing, begin.time, end.time, xtol=CLOSE * (end.time - begin.time)))
