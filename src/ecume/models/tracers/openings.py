"""Particles that enter through openings: their number, times, positions and velocities, computed before the run starts.

Each position and time is a function of the scene's seed, the opening and the number of the particle (Philox), so that
neither pauses nor threads change them. One particle enters an opening in each interval of 1/rate, at a random time in
it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume._portable import product
from ecume.engine.cells import Integers
from ecume.engine.philox import counter_of, uniforms
from ecume.engine.walls import Entrance, Surfaces, clearance, entrance
from ecume.errors import BadInput, Fault, SceneError
from ecume.models.tracers.liquid_flow import LiquidFlow
from ecume.scenes.quantities import MOST_PARTICLES
from ecume.scenes.sizes import largest_radius
from ecume.scenes.tracers import OpeningSpec, TracersScene
from ecume.units import Array

TRIES = 1000
"""The number of rounds of random positions after which an opening has no room."""
PURPOSE = 16
"""The first purpose of random numbers of openings, see `counter_of`: four for each opening. The
motion uses lower ones.
"""


class Stream(NamedTuple):
    """The flow that entering particles follow."""

    flow: LiquidFlow
    settling: Array
    """(species,) m/s, downwards"""


class Arrivals(NamedTuple):
    """All particles that enter during the run, in order."""

    step: Integers
    """(A,) the step at whose end the particle is in the tank"""
    position: Array
    """(A, d) m"""
    velocity: Array
    """(A, d) m/s"""
    opening: Integers
    """(A,) the opening through which it enters"""


class Inflow(NamedTuple):
    """The entering particles of a run, before the assignment to steps."""

    time: Array
    """(A,) s, ascending"""
    position: Array
    """(A, d) m, where they cross the wall"""
    velocity: Array
    """(A, d) m/s"""
    species: Integers
    opening: Integers


def inflow_of(scene: TracersScene, surfaces: Surfaces, stream: Stream) -> Inflow:
    """All particles that will enter. Raises SceneError for an opening through which no particle can enter."""
    faults, found, d = list[Fault](), [], scene.dimensions
    for index, hole in enumerate(scene.openings):
        try:
            if hole.rate is not None or hole.concentration is not None:
                found.append(_through(scene, surfaces, stream, index))
        except BadInput as error:
            faults.append(Fault(f"openings[{index}]", str(error)))
    if faults:
        raise SceneError(faults)
    none = Inflow(np.zeros(0), np.zeros((0, d)), np.zeros((0, d)), np.zeros(0, np.int64), np.zeros(0, np.int64))
    every = Inflow(*(np.concatenate(parts) for parts in zip(none, *found, strict=True)))
    order = np.argsort(every.time, kind="stable")
    return Inflow._make(part[order] for part in every)


def _through(scene: TracersScene, surfaces: Surfaces, stream: Stream, index: int) -> Inflow:
    hole, door = scene.openings[index], entrance(surfaces, index)
    species = species_of(scene, hole)
    if hole.concentration is not None and not stream.flow.steady:
        raise BadInput("concentration: the flow changes in time; give rate")
    instants = stream.flow.instants(scene.duration)
    speeds = [inward_speed(door, velocity_at(_inner(door), hole, stream, species, now)) for now in instants]
    varies = stream.flow.loops is not None
    middle = inward_speed(door, velocity_at(door.middle[None], hole, stream, species))[0]
    speed, slowest = float(speeds[0].mean()) if varies else middle, float(np.min(speeds))
    if slowest <= 0.0:
        way = ", ".join(f"{part:.3g}" for part in door.normal)
        entered_count = f"what comes in goes {slowest:.3g} m/s along the inward normal ({way})"
        raise BadInput(f"{entered_count}; expected above 0 in all of the opening at all times: set velocity, or flow")
    rate = hole.rate if hole.rate is not None else (hole.concentration or 0.0) * speed * door.area()
    count = math.floor(rate * scene.duration)
    if count > MOST_PARTICLES:
        raise BadInput(f"{count:.3g} particles would enter; expected at most {MOST_PARTICLES:.0e}")
    who = np.arange(count)
    time = (who + _draws(who, 0, (scene.seed, PURPOSE + 4 * index))[:, 0]) / rate
    position = _places(scene, surfaces, stream, index, count)
    velocity = velocity_at(position, hole, stream, species, 0.0 if stream.flow.steady else time)
    return Inflow(time, position, velocity, np.full(count, species), np.full(count, index))


def species_of(scene: TracersScene, hole: OpeningSpec) -> int:
    """The species number of entering particles."""
    return [species.name for species in scene.particles].index(hole.species) if hole.species else 0


def velocity_at(places: Array, hole: OpeningSpec, stream: Stream, species: int, time: float | Array = 0.0) -> Array:
    """The (n, d) velocities of entering particles, at one time or at one for each."""
    if hole.velocity is not None:
        return np.tile(np.array(hole.velocity, np.float64), (len(places), 1))
    velocity = stream.flow.velocity(places, time)
    velocity[:, -1] -= stream.settling[species]
    return velocity


def inward_speed(door: Entrance, velocity: Array) -> Array:
    """The speed of particles through an opening into the tank (n,) (m/s)."""
    speed: Array = product(velocity, door.normal)
    return speed


ROWS = 64
"""The number of points along an opening at which the inflow is sampled."""


def _inner(door: Entrance) -> Array:
    """The midpoints of equal parts of an opening, over which the mean of a flow is accurate to order 1/ROWS^2."""
    middles = (np.arange(ROWS) + 0.5) / ROWS
    return door.at(_combinations(middles, len(door.half)))


def _corners(door: Entrance) -> Array:
    return door.at(_combinations(np.array([0.0, 1.0]), len(door.half)))


def _combinations(values: Array, count: int) -> Array:
    return np.array(np.meshgrid(*[values] * count, indexing="ij")).reshape(count, -1).T


def _places(scene: TracersScene, surfaces: Surfaces, stream: Stream, index: int, count: int) -> Array:
    """The positions of entering particles (count, d), a radius inside the wall; with a given concentration, distributed
    as the flux.
    """
    hole, door = scene.openings[index], entrance(surfaces, index)
    species, d = species_of(scene, hole), scene.dimensions
    radius = largest_radius(scene.particles[species])
    fastest = inward_speed(door, velocity_at(_corners(door), hole, stream, species)).max()
    if stream.flow.loops is not None:
        fastest = 1.001 * inward_speed(door, velocity_at(_inner(door), hole, stream, species)).max()
    places, left = np.zeros((count, d)), np.arange(count)
    for attempt in range(TRIES):
        rng = _draws(left, attempt, (scene.seed, PURPOSE + 4 * index + 1))
        wall = door.at(rng[:, : d - 1])
        inside = wall + radius * (1.0 + 1e-9) * door.normal
        fits = door.holds(wall) & (clearance(inside, surfaces)[0] >= radius)
        if hole.concentration is not None:
            fits &= rng[:, 2] * fastest <= inward_speed(door, velocity_at(wall, hole, stream, species))
        places[left[fits]] = inside[fits]
        left = left[~fits]
        if not len(left):
            return places
    raise BadInput(f"no room for a radius of {radius:g} m in the opening; expected a wider one")


def _draws(who: Integers, when: int, key: tuple[int, int]) -> Array:
    """Random numbers (n, 4) in (0, 1); key = (seed, purpose), of which two consecutive purposes are used."""
    drawn = np.empty((len(who), 4))
    draw(who, when, key, drawn)
    return drawn


@compiled
def draw(who: Integers, when: int, key: tuple[int, int], drawn: Array) -> None:
    """Fill (n, 4) with random numbers in (0, 1) for each particle."""
    seed, purpose = key
    for i in range(len(who)):
        drawn[i, 0], drawn[i, 1] = uniforms(counter_of(int(who[i]), when, purpose), seed)
        drawn[i, 2], drawn[i, 3] = uniforms(counter_of(int(who[i]), when, purpose + 1), seed)


def arrivals_of(inflow: Inflow, surfaces: Surfaces, radius: Array, time_step: float) -> Arrivals:
    """Assign entering particles to steps. At the end of this step a particle is at the position that it reaches with
    its velocity, or in the opening if that position is blocked.
    """
    step = np.maximum(np.ceil(inflow.time / time_step).astype(np.int64), 1)
    advanced = inflow.position + (step * time_step - inflow.time)[:, None] * inflow.velocity
    blocked = clearance(advanced, surfaces)[0] < radius if len(step) else np.zeros(0, bool)
    position = np.where(blocked[:, None], inflow.position, advanced)
    return Arrivals(step, np.ascontiguousarray(position), np.ascontiguousarray(inflow.velocity), inflow.opening)
