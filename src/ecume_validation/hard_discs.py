"""Brownian hard discs compared with Monte Carlo: pair distribution, pressure, walls; and bound pairs compared with
Boltzmann's weights.

The reference is Metropolis sampling in NumPy, which has neither time nor forces and shares no code with the model.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import quad
from scipy.special import k0

from ecume.laws.brownian_motion import thermal_energy
from ecume.models.floating.parameters import CAPILLARY_LENGTH
from ecume.models.floating.time_integration.step_size import StepWarning
from ecume.units import Array
from ecume_validation.hydrodynamics import Run
from ecume_validation.runner import Row, below, within

RADIUS, TEMPERATURE = 1e-6, 300.0
"""Radius (m) of the discs, and their temperature (K). Lengths below are in radii."""
COUNT, SHARES = 64, (0.3, 0.5)
"""Discs in a periodic square, and the shares of its area that they cover."""
EDGES = np.array([0.0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3])
"""Edges of the bins of gaps (R)."""
NEAR = 5
"""The bins from which the density at contact is extrapolated."""
DISH, INSIDE = 6.0, 12
"""The radius of a dish (R), and the discs in it."""
AT_WALL = np.array([0.0, 0.1, 0.4])
"""Edges of the bins of gaps between discs and the wall (R)."""
COPIES, MOVE = 200, 0.35
"""Independent copies of the Monte Carlo simulation, and the largest displacement of a move (R)."""
SWEEPS, BETWEEN = 2_000, 20
"""Moves of each disc, a fifth of them before the first sample, and moves between samples."""
SAMPLES, STEPS, BLOCKS = 15_000, 10, 20
"""Samples of a run, time steps between them, and blocks of samples for the standard errors."""
SLOWER = 4
"""How many times longer discs in a dish take to forget where they were: their number near the wall changes slowly."""
BOUND = (12e-6, 16e-6)
"""Radii of spheres that bind one another by menisci (m)."""
GAPS, FAR = (0.1, 0.5, 2.0), 1.0
"""Edges of gaps of bound pairs, over kT over the force at contact, and the gap up to which pairs count (R)."""
TENSION = 0.0728
TOLERANCE = 0.03


class Room(NamedTuple):
    """The region of discs with radius 1."""

    period: float
    """the side of a periodic square; 0 for none"""
    dish: float
    """the radius of a round wall; infinite for none"""

    def apart(self, one: Array, other: Array) -> Array:
        """The distances of centers."""
        away = one - other
        if self.period > 0.0:
            away -= self.period * np.round(away / self.period)
        return np.asarray(np.sqrt((away**2).sum(axis=-1)))


class Found(NamedTuple):
    """Mean numbers in bins, and their standard errors."""

    value: Array
    error: Array


def rows() -> list[Row]:
    """Compare discs in a periodic square, in a dish, and bound pairs."""
    return [*squares(), *dishes(), *pairs()]


def metropolis(start: Array, room: Room, sweeps: int) -> Iterator[Array]:
    """Configurations (copies, N, 2) of hard discs with equal probability for every allowed one: moves that lead to an
    overlap are rejected [metropolis1953].
    """
    dice, count = np.random.default_rng(1), len(start)
    place = np.repeat(start[None], COPIES, axis=0)
    for sweep in range(sweeps):
        for i in dice.integers(count, size=count):
            there = place[:, i] + dice.uniform(-MOVE, MOVE, (COPIES, 2))
            apart = room.apart(place, there[:, None])
            apart[:, i] = 2.0
            free = (apart.min(axis=1) >= 2.0) & (np.hypot(*there.T) <= room.dish - 1.0)
            place[free, i] = there[free]
        if sweep >= sweeps // 5 and sweep % BETWEEN == 0:
            yield place


def counted(place: Array, room: Room, *, walls: bool) -> Array:
    """The numbers of pairs in the bins of `EDGES` (copies, bins), followed by those of discs in the bins of `AT_WALL`
    if there are `walls`.
    """
    i, j = np.triu_indices(place.shape[1], 1)
    found = [binned(room.apart(place[:, i], place[:, j]) - 2.0, EDGES)]
    if walls:
        found.append(binned(room.dish - 1.0 - np.sqrt((place**2).sum(axis=-1)), AT_WALL))
    return np.concatenate(found, axis=1)


def binned(gap: Array, edges: Array) -> Array:
    """The numbers of gaps (copies, ...) in each bin (copies, bins). Gaps of discs in contact may differ from zero by
    rounding.
    """
    below_edges = [(gap < edge).sum(axis=1) for edge in edges[1:]]
    return np.diff(np.column_stack([np.zeros(len(gap)), *below_edges]), axis=1)


def expected(start: Array, room: Room) -> Found:
    """The mean counts of Monte Carlo, with the errors of independent copies."""
    walls = math.isfinite(room.dish)
    sampled = metropolis(start, room, SWEEPS * (SLOWER if walls else 1))
    each = np.mean([counted(place, room, walls=walls) for place in sampled], axis=0)
    return Found(each.mean(axis=0), each.std(axis=0, ddof=1) / math.sqrt(len(each)))


def simulated(start: Array, room: Room, samples: int, *, hydrodynamics: str = "none", longer: float = 1.0) -> Found:
    """The mean counts of Brownian discs in equilibrium, with errors by blocks; `longer` is the time step over the
    default one.
    """
    run, walls = run_of(start, room, hydrodynamics, longer), math.isfinite(room.dish)
    steps, found = STEPS * (SLOWER if walls else 1), []
    run.advance(samples * steps // 20)
    for _ in range(samples):
        run.advance(steps)
        found.append(counted(run.state.position[None] / RADIUS, room, walls=walls)[0])
    return by_blocks(np.array(found))


def by_blocks(found: Array) -> Found:
    """The means of series (samples, bins), with errors by their blocks."""
    parts = np.array([part.mean(axis=0) for part in np.array_split(found, BLOCKS)])
    return Found(found.mean(axis=0), parts.std(axis=0, ddof=1) / math.sqrt(BLOCKS))


def run_of(start: Array, room: Room, hydrodynamics: str, longer: float) -> Run:
    """Half-immersed Brownian spheres of radius 1 um without attraction, with `longer` times the default time step."""
    around: dict[str, Any] = {"cell": {"size": [room.period * RADIUS] * 2}}
    if room.period == 0.0:
        around = {"dish": {"radius": room.dish * RADIUS, "contact_angle": math.pi / 2, "law": "none"}}
    bead = {"radius": RADIUS, "density": 1000.0, "contact_angle": math.pi / 2, "positions": (start * RADIUS).tolist()}
    scene: dict[str, Any] = {
        "duration": 1e3, "frame_every": 10.0, "seed": 4, "particles": [bead], **around, "interaction": {"law": "none"},
        "liquid": {"density": 1000.0, "viscosity": 1e-3, "surface_tension": TENSION, "temperature": TEMPERATURE},
        "integration": {"integrator": "overdamped"},
        "hydrodynamics": {"brownian": True, "interaction": hydrodynamics},
    }  # fmt: skip
    if longer == 1.0:
        return Run(scene)
    step = 10.0 / math.ceil(10.0 / (longer * Run(scene).parameters.time_step))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StepWarning)
        return Run(scene | {"integration": {"integrator": "overdamped", "time_step": step}})


def compared(name: str, found: Found, reference: Found, bins: list[str]) -> Iterator[Row]:
    """Rows of the counts over those of Monte Carlo, and one of the largest standard error of these ratios."""
    ratio = found.value / reference.value
    error = ratio * np.hypot(found.error / found.value, reference.error / reference.value)
    for one, each in zip(bins, ratio.tolist(), strict=True):
        yield within(f"{name}: {one}", each, 1.0, TOLERANCE)
    yield below(f"{name}: the largest standard error of these ratios", float(error.max()), 0.5 * TOLERANCE)


def bins_of(what: str, edges: Array) -> list[str]:
    """The names of bins."""
    over = "over Monte Carlo"
    return [f"{what} with gaps of {low:g} to {high:g} R, {over}" for low, high in pairwise(edges)]


def squares() -> Iterator[Row]:
    """Compare discs in a periodic square at two densities, and at four times the default step."""
    for share in SHARES:
        side = math.sqrt(COUNT * math.pi / share)
        start, room = lattice(side) - 0.5 * side, Room(side, math.inf)
        reference = expected(start, room)
        for longer in (1.0, 4.0) if share == SHARES[0] else (1.0,):
            name = f"discs on {100.0 * share:g} %" + (f", {longer:g} times the default step" if longer > 1.0 else "")
            found = simulated(start, room, SAMPLES, longer=longer)
            yield from compared(name, found, reference, bins_of("pairs", EDGES))
            state = (1.0 + share**2 / 8.0) / (1.0 - share) ** 2
            over = pressure(found.value, side) / state
            yield within(f"{name}: pressure over that of Henderson's equation of state", over, 1.0, TOLERANCE)
        over = pressure(reference.value, side) / state
        yield within(f"Monte Carlo on {100.0 * share:g} %: pressure over the same", over, 1.0, TOLERANCE)


def pressure(counts: Array, side: float) -> float:
    """The pressure over that of an ideal gas: 1 + 2 n'/(2 N), with the number n' of pairs per gap at contact (1/R),
    extrapolated from the bins next to it.
    """
    area = math.pi * np.diff((2.0 + EDGES[: NEAR + 1]) ** 2)
    middle = 0.5 * (EDGES[:NEAR] + EDGES[1 : NEAR + 1])
    curve = np.polyfit(middle, np.log(counts[:NEAR] / area), 2, w=np.sqrt(counts[:NEAR]))
    return float(1.0 + math.exp(curve[-1]) * 4.0 * math.pi / COUNT)


def lattice(side: float) -> Array:
    """A square lattice of discs."""
    spots = (np.arange(math.isqrt(COUNT)) + 0.5) * side / math.isqrt(COUNT)
    return np.array([(x, y) for x in spots for y in spots])


def dishes() -> Iterator[Row]:
    """Compare discs in a round dish without and with hydrodynamic interaction."""
    spots = 2.4 * np.array([(x, y) for x in (-1.5, -0.5, 0.5, 1.5) for y in (-1.5, -0.5, 0.5, 1.5)])
    start, room = spots[np.argsort(np.hypot(*spots.T), kind="stable")[:INSIDE]], Room(0.0, DISH)
    reference = expected(start, room)
    bins = [*bins_of("pairs", EDGES), *bins_of("discs at the wall", AT_WALL)]
    for name, interaction in (("in a dish", "none"), ("with hydrodynamic interaction", "rotne-prager")):
        found = simulated(start, room, 2 * SAMPLES, hydrodynamics=interaction)
        yield from compared(name, found, reference, bins)


def pairs() -> Iterator[Row]:
    """Compare the fraction of time that two spheres spend near each other with Boltzmann's weights."""
    for interaction in ("none", "rotne-prager"):
        for radius in BOUND:
            yield from bound(radius, interaction)


def bound(radius: float, hydrodynamics: str) -> Iterator[Row]:
    """Compare the shares of gaps below `FAR` for one kind of spheres."""
    run = pair_of(radius, hydrodynamics)
    length = float(run.parameters.pair[CAPILLARY_LENGTH]) / radius
    strength = 2.0 * math.pi * TENSION * float(run.parameters.floats.charge[0]) ** 2 / thermal_energy(TEMPERATURE)
    # The force at contact is nearly kT times the strength over the diameter.
    edges = np.append(2.0 / strength * np.array(GAPS), FAR)
    weight = weight_of(strength, length)
    exact = np.array([quad(weight, 2.0, 2.0 + edge, epsabs=0.0)[0] for edge in edges])
    reference = Found(exact[:-1] / exact[-1], np.zeros(len(GAPS)))
    with_flow = " with hydrodynamic interaction" if hydrodynamics != "none" else ""
    name = f"two spheres of {1e6 * radius:g} um, bound by {strength * float(k0(2.0 / length)):.0f} kT{with_flow}"
    bins = [f"time at gaps below {edge:.3f} R, over Boltzmann's weight" for edge in edges[:-1]]
    yield from compared(name, shares_of(run, radius, edges), reference, bins)


def shares_of(run: Run, radius: float, edges: Array) -> Found:
    """The shares of the samples of a pair with gaps below each edge except the last, among those below the last."""
    found = []
    for _ in range(6 * SAMPLES):
        run.advance(STEPS)
        one, other = run.state.position / radius
        found.append(np.hypot(*(one - other)) - 2.0 < edges)
    parts = np.array([part.mean(axis=0) for part in np.array_split(np.array(found, float), BLOCKS)])
    shares, whole = parts[:, :-1] / parts[:, -1:], parts.mean(axis=0)
    return Found(whole[:-1] / whole[-1], shares.std(axis=0, ddof=1) / math.sqrt(BLOCKS))


def weight_of(strength: float, length: float, dish: float = DISH) -> Any:
    """The probability density of a distance in a dish, not normalized: the energy is -strength kT K0(r/L), and the
    number of positions of two centers at the distance r is proportional to the overlap of two circles.
    """
    free = dish - 1.0

    def weight(distance: float) -> float:
        half = 0.5 * distance
        overlap = 2.0 * free**2 * math.acos(half / free) - distance * math.sqrt(free**2 - half**2)
        energy = strength * (float(k0(distance / length)) - float(k0(2.0 / length)))
        return distance * overlap * math.exp(energy)

    return weight


def pair_of(radius: float, hydrodynamics: str) -> Run:
    """Two heavy half-immersed spheres in a dish without a meniscus."""
    bead = {
        "radius": radius, "density": 2000.0, "contact_angle": math.pi / 2,
        "positions": [[-1.05 * radius, 0.0], [1.05 * radius, 0.0]],
    }  # fmt: skip
    return Run({
        "duration": 1e6, "frame_every": 1e3, "seed": 4, "particles": [bead],
        "dish": {"radius": DISH * radius, "contact_angle": math.pi / 2, "law": "none"},
        "liquid": {"density": 1000.0, "viscosity": 1e-3, "surface_tension": TENSION, "temperature": TEMPERATURE},
        "integration": {"integrator": "overdamped"},
        "hydrodynamics": {"brownian": True, "interaction": hydrodynamics},
    })  # fmt: skip
