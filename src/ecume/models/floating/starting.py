"""Where floats start: at given places, on lattices and rings, at random; and whether they fit."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.contact import contacts
from ecume.engine.neighbors import build, make_lists
from ecume.engine.placement import Region, place_at_random, place_on_lattice, place_on_ring
from ecume.engine.walls import Walls, enclosures
from ecume.errors import BadInput, Fault, SceneError
from ecume.models.floating.contact_models import contacts_of, gaps_between
from ecume.models.floating.interactions import interactions_of
from ecume.models.floating.motions import inertia_of
from ecume.models.floating.parameters import Floats, Parameters
from ecume.models.floating.state import State, make_state
from ecume.models.floating.stepping import list_candidates
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene, FloatSpec

OPEN_COVERAGE = 0.15
"""Without a dish, floats are placed at random in a square that they cover to this part."""
TOUCHING = 1e-3
"""Overlaps up to this part of a radius are floats that touch: a raft of another run, from which a scene may start, is
as deep in itself as a run leaves it.
"""
MOST_FAULTS = 20
TURNS = 7
"""Keeps the angles' random numbers apart from those of the places."""


class Places(NamedTuple):
    """Where each float of the scene starts, and with which velocity; NaN where chance decides."""

    position: Array
    velocity: Array


def start(scene: FloatingScene, parameters: Parameters) -> State:
    """The state at time 0. Raises SceneError where floats overlap, lie outside, or find no room."""
    places = given_places(scene)
    free = np.isnan(places.position[:, 0])
    if contacts_of(parameters).gaps is not None:
        _check_shapes(scene, parameters, places.position, np.flatnonzero(~free))
    else:
        _check(scene, parameters, places.position, np.flatnonzero(~free).astype(np.int64))
    if np.any(free):
        radius = parameters.floats.radius
        taken = places.position[~free], radius[~free]
        try:
            places.position[free] = place_at_random(radius[free], region_of(parameters), taken, scene.seed)
        except BadInput as error:
            raise SceneError([Fault("particles", str(error))]) from None
    state = make_state(places.position, places.velocity)
    for part, row in interactions_of(parameters):
        state = row.state(part, state)
    return first_turns(contacts_of(parameters).state(state), scene, parameters)


def first_turns(state: State, scene: FloatingScene, parameters: Parameters) -> State:
    """The state with angles for floats that turn: given ones, or by chance."""
    if inertia_of(parameters) is None:
        return state
    angle, spin = first_angles(scene), np.zeros(len(state.position))
    spin[len(spin) - len(scene.rows) :] = [row.spin for row in scene.rows]
    return state._replace(turning=np.stack([angle, spin], axis=1))


def first_angles(scene: FloatingScene) -> Array:
    """Of all floats: given ones, or by chance."""
    count = sum(one.count for one in scene.particles)
    chance = np.random.default_rng([scene.seed, TURNS]).uniform(0.0, 2.0 * math.pi, count + len(scene.rows))
    turned = [species.shape or species.disc for species in scene.particles]
    given = [math.nan if one is None or one.angle is None else one.angle for one in turned]
    told = np.repeat(given, [one.count for one in scene.particles])
    told = np.concatenate([told, [row.angle for row in scene.rows]])
    return np.where(np.isnan(told), chance, told)


def given_places(scene: FloatingScene) -> Places:
    """What the scene itself says: the tables' floats first, then the rows."""
    positions = [_places_of(species) for species in scene.particles]
    velocities = [_velocities_of(species) for species in scene.particles]
    if scene.rows:
        positions.append(np.array([(row.x, row.y) for row in scene.rows]))
        velocities.append(np.array([(row.vx, row.vy) for row in scene.rows]))
    return Places(np.concatenate(positions), np.concatenate(velocities))


def _velocities_of(species: FloatSpec) -> Array:
    return np.array(species.velocities) if species.velocities else np.tile(species.velocity, (species.count, 1))


def _places_of(species: FloatSpec) -> Array:
    if species.positions:
        return np.array(species.positions)
    if species.placement == "lattice" and species.spacing is not None:
        return place_on_lattice(species.count, species.spacing, species.center)
    if species.placement == "ring" and species.ring_radius is not None:
        return place_on_ring(species.count, species.ring_radius, species.center)
    return np.full((species.count, 2), np.nan)


def region_of(parameters: Parameters) -> Region:
    """Where floats may be placed at random."""
    low, high = enclosures.bounds(parameters.walls)
    side = 0.5 * math.sqrt(math.pi * float(np.sum(parameters.floats.radius**2)) / OPEN_COVERAGE)
    if math.inf in high:
        low, high = (-side, -side), (side, side)
    return Region(low, high, parameters.walls)


def _check(scene: FloatingScene, parameters: Parameters, position: Array, which: Integers) -> None:
    """All floats with given places that overlap, or are not inside the dish."""
    names = float_names(scene)
    faults = [*_outside(parameters, position, which, names), *_overlapping(parameters.floats, position, which, names)]
    if faults:
        more = [Fault("", f"and {len(faults) - MOST_FAULTS} more of these")] if len(faults) > MOST_FAULTS else []
        raise SceneError(faults[:MOST_FAULTS] + more)


def _check_shapes(scene: FloatingScene, parameters: Parameters, position: Array, which: Any) -> None:
    """The same for shapes, as they are turned at the start."""
    names, radius, faults = float_names(scene), parameters.floats.radius, []
    # Whoever is placed by chance is out of the way.
    far = 4.0 * (np.abs(np.nan_to_num(position)).max() + radius.sum()) * (1.0 + np.arange(len(position)))
    there = np.where(np.isnan(position), far[:, None], position)
    for i, j, gap in gaps_between(parameters, there, first_angles(scene), 0.0):
        if i in which and (j in which or j >= len(radius)) and -gap > TOUCHING * radius[i]:
            other = f"{names[j]}" if j < len(radius) else "the dish's wall"
            faults.append(Fault(names[i], f"overlaps {other} by {-gap:.3g} m"))
    if faults:
        raise SceneError(faults[:MOST_FAULTS])


def float_names(scene: FloatingScene) -> list[str]:
    """Each float's path in the scene."""
    names = [
        f"particles[{k}].positions[{n}]" for k, species in enumerate(scene.particles) for n in range(species.count)
    ]
    return names + [f"rows[{k}]" for k in range(len(scene.rows))]


def _outside(parameters: Parameters, position: Array, which: Integers, names: list[str]) -> list[Fault]:
    faults = []
    for i in which:
        sunk_in = _into_walls(parameters.walls, position[i], parameters.floats.radius[i])
        if sunk_in > TOUCHING * parameters.floats.radius[i]:
            x, y = position[i]
            faults.append(
                Fault(
                    names[i], f"({x:g} m, {y:g} m) is not inside the dish: {sunk_in:.3g} m of the float are in the wall"
                )
            )
    return faults


def _into_walls(walls: Walls, place: Array, radius: float) -> float:
    return radius - min(enclosures.clearances(walls, place), default=math.inf)


def _overlapping(floats: Floats, position: Array, which: Integers, names: list[str]) -> list[Fault]:
    if len(which) < 2:
        return []
    places, radius = np.ascontiguousarray(position[which]), floats.radius[which]
    capacity = 64 * len(which)
    lists, candidates = make_lists(len(which), 2, capacity), contacts.make_candidates(len(which), capacity)
    reach = 2.0 * float(radius.max())
    if not (build(lists, places, reach) and list_candidates(candidates, lists, radius, 0.0)):
        return [Fault("particles", f"more than {capacity} pairs of floats overlap")]
    faults = []
    for i in range(len(which)):
        for j in candidates.partner[candidates.first[i] : candidates.first[i + 1]]:
            overlap = radius[i] + radius[j] - math.dist(places[i], places[j])
            if overlap > TOUCHING * min(radius[i], radius[j]):
                faults.append(Fault(names[which[i]], f"overlaps {names[which[j]]} by {overlap:.3g} m"))
    return faults
