"""The initial state of tracers: given positions, or random ones in the tank or in a part of it."""

from __future__ import annotations

import numpy as np

from ecume.engine.walls import Surfaces, clearance, described
from ecume.errors import Fault, SceneError
from ecume.models.layouts import Layout
from ecume.models.tracers.parameters import Parameters, State, make_state
from ecume.models.tracers.tank import bounds, periodic_of, surfaces_of
from ecume.scenes.sizes import largest_radius, radii_of
from ecume.scenes.tracers import ParticleSpec, TracersScene
from ecume.units import Array, with_prefix

TRIES = 2000
"""The number of rounds of random positions before a placement fails."""
TOGETHER = 1 << 16
"""The number of random positions whose distances from the surfaces are computed at once."""


def start(scene: TracersScene, parameters: Parameters) -> State:
    """The state at time 0. Raises SceneError for a particle outside the tank, or without room."""
    surfaces = surfaces_of(scene)
    rng = np.random.default_rng(scene.seed)
    faults: list[Fault] = []
    places: list[Array] = []
    for index, species in enumerate(scene.particles):
        if species.positions:
            placed = np.array(species.positions, np.float64)
            faults += outside(placed, species, surfaces, (scene.seed, index))
        else:
            placed = scattered(species, surfaces, rng, faults, index, scene)
        places.append(placed)
    if faults:
        raise SceneError(faults)
    velocity = np.concatenate([velocities(species, scene.dimensions) for species in scene.particles])
    made = make_state(np.concatenate(places), velocity.astype(np.float64), len(surfaces.kind), parameters.periodic)
    for axis, side in enumerate(parameters.periodic.sides[: scene.dimensions]):
        if side > 0.0:
            away = np.floor((made.position[:, axis] - parameters.periodic.low[axis]) / side).astype(np.int64)
            made.position[:, axis] -= side * away
            made.image[:, axis] = away
    return made


def layout(scene: TracersScene, parameters: Parameters, state: State) -> Layout:
    """The layout of a state with its number of particles, which enter through openings during a run."""
    count = min(max(state.left.size, _at_first(scene)), len(parameters.bodies.radius))
    zeros = np.zeros((count, scene.dimensions))
    surfaces = surfaces_of(scene)
    blank = make_state(zeros, zeros, len(surfaces.kind), parameters.periodic)
    return Layout(blank, {"left": (-1, len(surfaces.hole) - 1)})


def _at_first(scene: TracersScene) -> int:
    return sum(species.count for species in scene.particles)


def velocities(species: ParticleSpec, dimensions: int) -> Array:
    """The initial velocities of a species."""
    if species.velocities:
        return np.array(species.velocities, np.float64)
    return np.tile(species.velocity or (0.0,) * dimensions, (species.count, 1))


def outside(placed: Array, species: ParticleSpec, surfaces: Surfaces, at: tuple[int, int]) -> list[Fault]:
    """A fault for each position at which a particle would overlap a wall or be outside the tank; `at` is the seed and
    index of the species.
    """
    seed, index = at
    (clear, which), radius = clearance(placed, surfaces), radii_of(species, species.count, (seed, index))
    return [
        Fault(
            f"particles[{index}].positions[{i}]",
            f"{tuple(placed[i].tolist())} is {with_prefix(radius[i] - clear[i], 'm', 3)} beyond "
            f"{described(surfaces, int(which[i]))}; expected a position inside, its radius included",
        )
        for i in np.flatnonzero(clear < radius * (1.0 - 1e-9))[:20]
    ]


def scattered(
    species: ParticleSpec,
    surfaces: Surfaces,
    rng: np.random.Generator,
    faults: list[Fault],
    index: int,
    scene: TracersScene,
) -> Array:
    """Random positions, uniform in the tank or in the given part of it."""
    low, high = (np.array(corner) for corner in corners(species, scene))
    found, room = np.zeros((species.count, scene.dimensions)), largest_radius(species)
    placed, drawn = 0, 0
    # In parts, since the distances from all surfaces take much more memory than positions.
    while drawn < TRIES * 2 * species.count:
        many = min(TOGETHER, 2 * species.count - drawn % (2 * species.count))
        candidates = rng.uniform(low, np.maximum(low, high), (many, scene.dimensions))
        drawn += many
        if placed < species.count:
            good = candidates[clearance(candidates, surfaces)[0] >= room][: species.count - placed]
            found[placed : placed + len(good)] = good
            placed += len(good)
        if placed == species.count and drawn % (2 * species.count) == 0:
            return found
    faults.append(Fault(f"particles[{index}]", f"no room for {species.count} of radius {species.radius:g} m"))
    return found


def corners(species: ParticleSpec, scene: TracersScene) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The box for the random positions of a species."""
    low, high = bounds(scene)
    a, open_sides = largest_radius(species), np.array(periodic_of(scene).sides[: scene.dimensions]) > 0.0
    margin = np.where(open_sides, 0.0, a).tolist()
    return (
        species.low or tuple(value + gap for value, gap in zip(low, margin, strict=True)),
        species.high or tuple(value - gap for value, gap in zip(high, margin, strict=True)),
    )
