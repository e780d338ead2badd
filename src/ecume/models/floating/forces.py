"""Superposed menisci: forces of a pair law between floats, and of the walls' menisci on each float."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.engine.neighbors import NeighborLists
from ecume.engine.walls import wall_count
from ecume.models.floating.currents import current_at
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.pulling import pairs_of, pull
from ecume.models.floating.state import State, Workspace
from ecume.models.floating.walls.wall_laws import acts, wall_force
from ecume.units import Array


class Sorted(NamedTuple):
    """Scratch in the order of the slots."""

    charge: Array
    radius: Array
    force: Array
    """(2, N)"""
    pair: Array
    """the pair law's constants; like the charges in the precision of the sums"""


class Superposed(NamedTuple):
    """The part of floats that interact by a pair law, and with walls one by one."""

    law: Any
    """constants of the pair law, in the precision of the sum over pairs"""


def make_sorted(part: Superposed, parameters: Parameters, state: State, workspace: Workspace) -> Sorted:
    """Its workspace."""
    count, kind = len(state.position), np.float32 if parameters.single else np.float64
    return Sorted(np.zeros(count, kind), np.zeros(count), np.zeros((2, count)), parameters.pair.astype(kind))


@compiled
def superposed_forces(
    part: Superposed, own: Sorted, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
) -> None:
    """Add the forces of all pairs and of the walls."""
    pull(part.law, pairs_of(lists.rows), (own.charge, own.radius), own.pair, own.force)
    add_from_slots(lists.cells.order, own.force, force)
    add_wall_forces(parameters, position, force)


@compiled
def sort_floats(part: Any, own: Sorted, parameters: Parameters, lists: NeighborLists) -> None:
    """Copy charges and radii into the order of the slots; after each new neighbor list."""
    floats, order = parameters.floats, lists.cells.order
    charge, radius = own.charge, own.radius
    for slot in range(len(order)):
        charge[slot], radius[slot] = floats.charge[order[slot]], floats.radius[order[slot]]


@compiled
def add_from_slots(order: Integers, sorted_force: Array, force: Array) -> None:
    """Add forces in the order of the slots to those in the order of the floats."""
    for slot in range(len(order)):
        force[order[slot], 0] += sorted_force[0, slot]
        force[order[slot], 1] += sorted_force[1, slot]


@compiled
def add_flow(parameters: Parameters, position: Array, force: Array) -> None:
    """The flowing surface drags at each float: zeta u, where u is its velocity at the float's center."""
    mass, relaxation = parameters.floats.mass, parameters.floats.relaxation_time
    for i in range(position.shape[0]):
        friction, (along, across) = (
            mass[i] / relaxation[i],
            current_at(parameters.drift, position[i, 0], position[i, 1]),
        )
        force[i, 0] += friction * along
        force[i, 1] += friction * across


@compiled
def add_wall_forces(parameters: Parameters, position: Array, force: Array) -> None:
    """The meniscus at the walls pushes or pulls each float."""
    strength, charge = parameters.wall_strength, parameters.floats.charge
    if not acts(parameters):
        return
    for i in range(position.shape[0]):
        place = (position[i, 0], position[i, 1])
        for number in range(wall_count(parameters.walls)):
            away, inward_x, inward_y = wall_force(parameters, number, place, strength[number, i], charge[i])
            force[i, 0] += away * inward_x
            force[i, 1] += away * inward_y
