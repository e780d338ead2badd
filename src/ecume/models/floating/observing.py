"""From a state to a frame: copies of what floats are and do, and the numbers of the whole."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.engine.contact.contacts import Candidates
from ecume.engine.neighbors import Slots
from ecume.engine.walls import Walls, wall_count, wall_distance
from ecume.laws.dish_motion import sway_place
from ecume.models.floating.booking import is_driven
from ecume.models.floating.interacting import inertia_of, interaction_energies, sums_pairs, turns
from ecume.models.floating.many import Many
from ecume.models.floating.pair_choice import law_of, row_of
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    CUTOFF,
    OVERDAMPED,
    SURFACE_TENSION,
    Floats,
    PairParameters,
    Parameters,
)
from ecume.models.floating.polar import Polar
from ecume.models.floating.pulling import pair_energy
from ecume.models.floating.shaped.bodies import Shaped
from ecume.models.floating.state import COLLISIONS, DEEPEST, SWEEPS, UNCONVERGED, WORK, State, Workspace
from ecume.models.floating.walls.menisci import acts, wall_energy
from ecume.models.invariants import INJECTED
from ecume.trajectories.frame import Frame
from ecume.units import Array

ARRAY_UNITS = {
    "position": "m",
    "velocity": "m/s",
    "radius": "m",
    "mass": "kg",
    "charge": "m",
    "density": "kg/m^3",
    "contact_angle": "rad",
    "species": "1",
}
NUMBER_UNITS = {
    "kinetic_energy": "J",
    "pair_energy": "J",
    "wall_energy": "J",
    "total_energy": "J",
    "momentum_x": "kg*m/s",
    "momentum_y": "kg*m/s",
    "angular_momentum": "kg*m^2/s",
    "largest_speed": "m/s",
    "clusters": "1",
    "mean_cluster_size": "1",
    "contacts": "1",
    "largest_overlap": "m",
    "deepest_overlap": "m",
    "collisions": "1",
    "contact_sweeps": "1",
    "unconverged_steps": "1",
}
CONTACT_GAP = 1e-3
"""Floats whose gap is below this part of the smaller radius count as touching."""


@compiled
def sum_of_pair_energies(
    law: Any, position: Array, floats: Floats, pair: Array, rows: tuple[Integers, Slots, Integers]
) -> float:
    """Exact energies of all pairs within the cutoff, each less its value there, so that a pair that parts changes
    nothing.
    """
    first, neighbor, order = rows
    length, tension, cutoff = pair[CAPILLARY_LENGTH], pair[SURFACE_TENSION], pair[CUTOFF]
    radius, charge, total = floats.radius, floats.charge, 0.0
    for slot in range(len(order)):
        i = order[slot]
        own = 0.0
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
            distance = math.sqrt(x * x + y * y)
            if i < j and 0.0 < distance < cutoff:
                two = PairParameters(radius[i], radius[j], charge[i], charge[j], length, tension)
                own += pair_energy(distance, two, law) - pair_energy(cutoff, two, law)
        total += own
    return total


@compiled
def sum_of_wall_energies(parameters: Parameters, position: Array) -> float:
    """Energies of all floats in the walls' menisci."""
    strength, charge, total = parameters.wall_strength, parameters.floats.charge, 0.0
    if not acts(parameters):
        return total
    for i in range(position.shape[0]):
        place = (position[i, 0], position[i, 1])
        for number in range(wall_count(parameters.walls)):
            meniscus, image = wall_energy(parameters, number, place, strength[number, i], charge[i])
            total += meniscus
            total += image
    return total


@compiled
def touching_pairs(position: Array, radius: Array, candidates: Candidates, label: Integers) -> tuple[int, float]:
    """Label clusters by their lowest member; how many pairs touch, and the deepest overlap among them."""
    first, partner = candidates.first, candidates.partner
    contacts, deepest = 0, 0.0
    for i in range(position.shape[0]):
        label[i] = i
    for i in range(position.shape[0]):
        for place in range(first[i], first[i + 1]):
            j = partner[place]
            x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
            gap = math.sqrt(x * x + y * y) - radius[i] - radius[j]
            if gap < CONTACT_GAP * min(radius[i], radius[j]):
                contacts += 1
                deepest = max(deepest, -gap)
                _join(label, i, j)
    for i in range(position.shape[0]):
        label[i] = _root(label, i)
    return contacts, deepest


@compiled
def _root(label: Integers, i: int) -> int:
    while label[i] != i:
        label[i] = label[label[i]]
        i = label[i]
    return i


@compiled
def _join(label: Integers, i: int, j: int) -> None:
    low, high = _root(label, i), _root(label, j)
    label[max(low, high)] = min(low, high)


@compiled
def deepest_in_walls(walls: Walls, position: Array, radius: Array) -> float:
    """How far the worst float is inside a wall."""
    worst = 0.0
    for i in range(position.shape[0]):
        for number in range(wall_count(walls)):
            worst = max(worst, radius[i] - wall_distance(walls, number, position[i, 0], position[i, 1])[0])
    return worst


def touching_shapes(parameters: Parameters, state: State, label: Integers) -> tuple[int, float]:
    """The same for shapes, walls included in the deepest overlap."""
    from ecume.models.floating.shaped.building import overlaps

    radius, contacts, deepest = parameters.floats.radius, 0, 0.0
    label[:] = np.arange(len(radius))
    for i, j, gap in overlaps(parameters, state.position, state.turning[:, 0], CONTACT_GAP * float(radius.min())):
        deepest = max(deepest, -gap)
        if j < len(radius):
            contacts += 1
            _join(label, i, j)
    for i in range(len(label)):
        label[i] = _root(label, i)
    return contacts, deepest


def observe(parameters: Parameters, state: State, workspace: Workspace) -> Frame:
    """The frame of this instant."""
    floats = parameters.floats
    arrays = {
        "position": state.position.copy(),
        "velocity": state.velocity.copy(),
        **{name: getattr(floats, name).copy() for name in ARRAY_UNITS if hasattr(floats, name)},
    }
    units = dict(ARRAY_UNITS)
    if turns(parameters):
        arrays |= {"angle": state.turning[:, 0].copy(), "spin": state.turning[:, 1].copy()}
        units |= {"angle": "rad", "spin": "rad/s"}
    if isinstance(parameters.many, Polar):
        arrays["magnetic_moment"], units["magnetic_moment"] = parameters.many.moment.copy(), "A*m^2"
    numbers = {
        **energies(parameters, state, workspace),
        **motion(parameters, state),
        **crowd(parameters, state, workspace),
    }
    numbers = {name: float(numbers[name]) for name in NUMBER_UNITS}
    time = int(state.step[0]) * parameters.time_step
    if is_driven(parameters) and len(state.tally) > WORK:
        numbers[INJECTED], units[INJECTED] = float(state.tally[WORK]), "J"
    if parameters.drift.sway.moves:
        numbers |= place_of_dish(parameters, time)
        units |= {"dish_x": "m", "dish_y": "m"}
    return Frame(time, arrays, numbers, {**units, **NUMBER_UNITS})


def place_of_dish(parameters: Parameters, time: float) -> dict[str, float]:
    """Where a dish in motion is: floats are seen from it."""
    sway = parameters.drift.sway
    x, y = (
        speed * time + sway_place(far, sway.turning, time)
        for speed, far in zip(sway.velocity.tolist(), sway.amplitude.tolist(), strict=True)
    )
    return {"dish_x": x, "dish_y": y}


def energies(parameters: Parameters, state: State, workspace: Workspace) -> dict[str, float]:
    """Kinetic, pair and wall energies (J), and their sum: without the first where there is no inertia."""
    rows = workspace.lists.rows.first, workspace.lists.rows.neighbor, workspace.lists.cells.order
    kinetic = 0.5 * float(np.sum(parameters.floats.mass * np.sum(state.velocity**2, axis=1)))
    if turns(parameters):
        kinetic += 0.5 * float(np.sum(inertia_of(parameters) * state.turning[:, 1] ** 2))
    pairs, walls = interaction_energies(parameters, state, workspace)
    if sums_pairs(parameters) and row_of(parameters).energy is not None:
        pairs += sum_of_pair_energies(law_of(parameters), state.position, parameters.floats, parameters.pair, rows)
    if not isinstance(parameters.many, (Many, Shaped)):
        walls += sum_of_wall_energies(parameters, state.position)
    return {
        "kinetic_energy": kinetic,
        "pair_energy": pairs,
        "wall_energy": walls,
        "total_energy": (0.0 if parameters.scheme == OVERDAMPED else kinetic) + pairs + walls,
    }


def motion(parameters: Parameters, state: State) -> dict[str, float]:
    """Momenta and the largest speed."""
    mass, position, velocity = parameters.floats.mass, state.position, state.velocity
    turning = position[:, 0] * velocity[:, 1] - position[:, 1] * velocity[:, 0]
    spins = float(np.sum(inertia_of(parameters) * state.turning[:, 1])) if turns(parameters) else 0.0
    return {
        "momentum_x": float(np.sum(mass * velocity[:, 0])),
        "momentum_y": float(np.sum(mass * velocity[:, 1])),
        "angular_momentum": float(np.sum(mass * turning)) + spins,
        "largest_speed": float(np.sqrt(np.max(np.sum(velocity**2, axis=1)))),
    }


def crowd(parameters: Parameters, state: State, workspace: Workspace) -> dict[str, float]:
    """Clusters, contacts, overlaps, and what the contact solver did so far."""
    radius = parameters.floats.radius
    label = np.zeros(len(radius), np.int64)
    if isinstance(parameters.many, Shaped):
        contacts, deepest = touching_shapes(parameters, state, label)
    else:
        contacts, deepest = touching_pairs(state.position, radius, workspace.candidates, label)
        deepest = max(deepest, deepest_in_walls(parameters.walls, state.position, radius))
    clusters = len(np.unique(label))
    return {
        "clusters": clusters,
        "mean_cluster_size": len(radius) / clusters,
        "contacts": contacts,
        "largest_overlap": deepest,
        "deepest_overlap": state.tally[DEEPEST],
        "collisions": state.tally[COLLISIONS],
        "contact_sweeps": state.tally[SWEEPS],
        "unconverged_steps": state.tally[UNCONVERGED],
    }
