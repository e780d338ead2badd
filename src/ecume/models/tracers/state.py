"""What the physics of tracers moves, the scratch beside it, and what actions may change.

Where the tracers start: at given places, or at random in the tank or a part of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.walls import Surfaces, clearance, described
from ecume.errors import Fault, SceneError
from ecume.models.actions import Access
from ecume.models.model import Layout
from ecume.models.tracers.parameters import Parameters, surfaces_of
from ecume.scenes.tracers import ParticleSpec, TracersScene
from ecume.units import Array
from ecume.value_texts import with_prefix

CAPPED = 0
"""The place in `State.tally` of flights cut short."""


class State(NamedTuple):
    """Everything that can change a later bit: randomness follows from the seed, the particle and the step."""

    position: Array
    """(N, d) m"""
    velocity: Array
    """(N, d) m/s"""
    step: Integers
    """(1,)"""
    left: Integers
    """(N,) the opening through which a particle left, or -1"""
    hits: Integers
    """(K,) how often each wall was hit"""
    tally: Integers
    """(1,) flights with more bounces than a step may have"""
    work: Array = np.zeros(1)
    """(1,) J of work from outside: see `energy_budget`"""


class Workspace(NamedTuple):
    """Scratch of one step."""

    origin: Array
    """(N, d) previous positions"""
    travel: Array
    """(N, d) the velocity with which the step begins"""
    push: Array
    """(N, d) the acceleration of the parabola that ends where the exact motion does"""
    kick: Array
    """(N, d) what the exact velocity has more than the parabola's, as long as no wall is met"""
    noise: Array
    """(N, d) the part of that which is chance, and stays"""
    shift: Array
    """(N, d) the part of the way that is chance"""
    external: Array
    """(N, d) m/s^2: the acceleration by laws of the user"""
    radius: Array
    hits: Integers
    """(N,)"""
    fate: Integers
    """(N,)"""


def make_state(position: Array, velocity: Array, surfaces: int) -> State:
    """The state at time 0."""
    count = len(position)
    return State(
        np.ascontiguousarray(position),
        np.ascontiguousarray(velocity),
        np.zeros(1, np.int64),
        np.full(count, -1, np.int64),
        np.zeros(surfaces, np.int64),
        np.zeros(1, np.int64),
        np.zeros(1),
    )


def came(parameters: Parameters, state: State) -> int:
    """The number of particles that have entered."""
    return len(state.position) - (len(parameters.bodies.radius) - len(parameters.arrivals.step))


def workspace(parameters: Parameters, state: State, room: float) -> Workspace:
    """The workspace, which cannot overflow."""
    count, shape = len(state.position), state.position.shape
    a, b, c, d, e, f, g = (np.zeros(shape) for _ in range(7))
    radius = np.ascontiguousarray(parameters.bodies.radius[:count])
    return Workspace(a, b, c, d, e, f, g, radius, np.zeros(count, np.int64), np.zeros(count, np.int64))


TOUCHING = 1e-6
"""Of a radius: tracers that touch a wall may be this far in it."""


def faults(scene: TracersScene, parameters: Parameters, state: State) -> list[str]:
    """The tracers that are neither inside nor have left."""
    surfaces, radius = surfaces_of(scene), parameters.bodies.radius[: len(state.position)]
    if not len(surfaces.kind):
        return []
    clear, which = clearance(state.position, surfaces)
    beyond = np.flatnonzero((clear < radius * (1.0 - TOUCHING)) & (state.left < 0))
    return [
        f"particle {i} is {radius[i] - clear[i]:.3g} m beyond {described(surfaces, int(which[i]))}; "
        "expected a position inside, its radius included"
        for i in beyond
    ]


TRACERS = Access(
    arrays=lambda state: {"position": state.position, "velocity": state.velocity},
    faults=faults,
    work=lambda state: state.work,
)


TRIES = 2000
"""Rounds of dice after which there is no room."""


def start(scene: TracersScene, parameters: Parameters) -> State:
    """The state at time 0. Raises SceneError where a particle starts outside, or finds no room."""
    surfaces = surfaces_of(scene)
    dice = np.random.default_rng(scene.seed)
    faults: list[Fault] = []
    places: list[Array] = []
    for index, species in enumerate(scene.particles):
        if species.positions:
            placed = np.array(species.positions, np.float64)
            faults += outside(placed, species, surfaces, index)
        else:
            placed = scattered(species, surfaces, dice, faults, index, scene)
        places.append(placed)
    if faults:
        raise SceneError(faults)
    velocity = np.concatenate([velocities(species, scene.dimensions) for species in scene.particles])
    return make_state(np.concatenate(places), velocity.astype(np.float64), len(surfaces.kind))


def layout(scene: TracersScene, parameters: Parameters, state: State) -> Layout:
    """What a state with as many particles looks like: they enter through openings."""
    count = min(max(state.left.size, _at_first(scene)), len(parameters.bodies.radius))
    zeros = np.zeros((count, scene.dimensions))
    blank = make_state(zeros, zeros, len(surfaces_of(scene).kind))
    return Layout(blank, {"left": (-1, len(scene.openings) - 1)})


def _at_first(scene: TracersScene) -> int:
    return sum(species.count for species in scene.particles)


def velocities(species: ParticleSpec, dimensions: int) -> Array:
    """The initial velocities of a species."""
    if species.velocities:
        return np.array(species.velocities, np.float64)
    return np.tile(species.velocity or (0.0,) * dimensions, (species.count, 1))


def outside(placed: Array, species: ParticleSpec, surfaces: Surfaces, index: int) -> list[Fault]:
    """A fault for each position that is not in the tank, its radius included."""
    clear, which = clearance(placed, surfaces)
    return [
        Fault(
            f"particles[{index}].positions[{i}]",
            f"{tuple(placed[i].tolist())} is {with_prefix(species.radius - clear[i], 'm', 3)} beyond "
            f"{described(surfaces, int(which[i]))}; expected a position inside, its radius included",
        )
        for i in np.flatnonzero(clear < species.radius * (1.0 - 1e-9))[:20]
    ]


def scattered(
    species: ParticleSpec,
    surfaces: Surfaces,
    dice: np.random.Generator,
    faults: list[Fault],
    index: int,
    scene: TracersScene,
) -> Array:
    """Random positions, uniform in the tank or in the given part of it."""
    low, high = (np.array(corner) for corner in corners(species, scene))
    found = np.zeros((0, scene.dimensions))
    for _ in range(TRIES):
        thrown = dice.uniform(low, np.maximum(low, high), (2 * species.count, scene.dimensions))
        found = np.concatenate([found, thrown[clearance(thrown, surfaces)[0] >= species.radius]])
        if len(found) >= species.count:
            return found[: species.count]
    faults.append(Fault(f"particles[{index}]", f"no room for {species.count} of radius {species.radius:g} m"))
    return found


def corners(species: ParticleSpec, scene: TracersScene) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The box in which a species is thrown."""
    low, high = bounds(scene)
    a = species.radius
    return (
        species.low or tuple(value + a for value in low),
        species.high or tuple(value - a for value in high),
    )


def bounds(scene: TracersScene) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The box around the tank; a unit box without one."""
    tank, d = scene.tank, scene.dimensions
    if tank is None:
        return (0.0,) * d, (1.0,) * d
    if tank.high is not None:
        return tank.low or (0.0,) * d, tank.high
    if tank.radius is not None:
        return (-tank.radius,) * d, (tank.radius,) * d
    corner = np.array(tank.vertices)
    return tuple(corner.min(axis=0).tolist()), tuple(corner.max(axis=0).tolist())
