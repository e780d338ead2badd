"""Forces on all floats: pairs through the neighbor lists, walls float by float."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from ecume._jit import compiled, inlined
from ecume.engine.cells import Integers
from ecume.engine.neighbors import NeighborLists, sort_positions
from ecume.engine.walls import wall_count
from ecume.models.floating.currents import current_at
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.pulling import pairs_of, pull
from ecume.models.floating.walls.menisci import acts, wall_force
from ecume.units import Array


class Sorted(NamedTuple):
    """Scratch in the order of the slots."""

    charge: Array
    radius: Array
    force: Array
    """(2, N)"""
    pair: Array
    """the pair law's constants; like the charges in the precision of the sums"""


@compiled
def sort_floats(parameters: Parameters, lists: NeighborLists, sorted_floats: Sorted) -> None:
    """Copy charges and radii into the order of the slots; after each new neighbor list."""
    floats, order = parameters.floats, lists.cells.order
    charge, radius = sorted_floats.charge, sorted_floats.radius
    for slot in range(len(order)):
        charge[slot], radius[slot] = floats.charge[order[slot]], floats.radius[order[slot]]


@inlined
def forces_with(
    pull_all: Callable[..., None],
    law: Any,
    parameters: Parameters,
    position: Array,
    lists: NeighborLists,
    scratch: tuple[Sorted, Array],
) -> None:
    """The forces on all floats at these positions; the neighbor lists must hold there."""
    sorted_floats, force = scratch
    sort_positions(lists, position)
    sorted_force, charges = sorted_floats.force, (sorted_floats.charge, sorted_floats.radius)
    pull_all(law, pairs_of(lists.rows), charges, sorted_floats.pair, sorted_force)
    unsort(lists.cells.order, sorted_force, force)
    add_wall_forces(parameters, position, force)
    if parameters.drift.flows:
        add_flow(parameters, position, force)


@compiled
def unsort(order: Integers, sorted_force: Array, force: Array) -> None:
    """Copy forces from the order of the slots into that of the floats."""
    for slot in range(len(order)):
        force[order[slot], 0], force[order[slot], 1] = sorted_force[0, slot], sorted_force[1, slot]


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


@compiled
def forces(law: Any, parameters: Parameters, position: Array, lists: NeighborLists, scratch: tuple[Any, Array]) -> None:
    """`forces_with` the loops of `pulling`; scratch is a `Sorted`, or has the same."""
    forces_with(pull, law, parameters, position, lists, scratch)
