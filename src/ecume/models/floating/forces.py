"""Forces on all floats: pairs through the neighbor lists, walls float by float."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from ecume._jit import admit, compiled, compiled_inside, inlined, prange, threaded
from ecume.engine.cells import Integers
from ecume.engine.neighbors import NeighborLists, sort_positions
from ecume.engine.walls import wall_count, wall_distance
from ecume.laws import capillarity, screened, special
from ecume.laws.capillarity import dish_force, plane_wall_force, two_point_legacy_force
from ecume.laws.screened import ScreenedFit, k1_over_x
from ecume.models.floating import parameters as constants
from ecume.models.floating.currents import current_at
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    DISH,
    INVERSE_SQUARE,
    NO_WALL_LAW,
    PLANE,
    STRENGTH,
    TABLED,
    PairParameters,
    Parameters,
    unpack_fit,
)
from ecume.models.floating.pulling import pairs_of, pull_all_with, pull_pairs_with
from ecume.models.floating.wall_tables import HEIGHT, IMAGE, tabled
from ecume.units import Array

admit(screened, special, capillarity, constants)


class Screened(NamedTuple):
    """Constants of the capillary pair law as its loop wants them, in the precision of the sums."""

    scale: float
    """N/m per square of a charge: 2 pi gamma / L^2"""
    inverse_square: float
    """1/m^2: of the capillary length"""
    fit: ScreenedFit


@compiled_inside
def screened_of(pair: Array) -> Screened:
    """Unpack the constants."""
    return Screened(pair[STRENGTH] * pair[INVERSE_SQUARE], pair[INVERSE_SQUARE], unpack_fit(pair))


@compiled_inside
def screened_pull(square: float, own: PairParameters, law: Screened) -> float:
    """The pull (N) over the distance (m): towards the neighbor where the charges agree; the same for both of a pair, so
    that their forces cancel to the bit.
    """
    return law.scale * (own.charge_i * own.charge_j) * k1_over_x(square * law.inverse_square, law.fit)


@compiled
def _pull_stretch(stretch: Any, rows: Any, floats: Any, pair: Array, window: Any) -> None:
    charge, radius = floats
    pull_pairs_with(screened_pull, screened_of, stretch, rows, (charge, radius[:0]), pair, window)


@threaded
def _pull_in_threads(edge: Any, place: Any, rows: Any, floats: Any, pair: Array, along: Array, across: Array) -> None:
    for k in prange(len(edge) - 1):
        window = along[place[k] : place[k + 1]], across[place[k] : place[k + 1]]
        _pull_stretch((edge[k], edge[k + 1]), rows, floats, pair, window)


@compiled
def pull(rows: Any, floats: Any, pair: Array, force: Array) -> None:
    """Pair forces on all slots."""
    pull_all_with(_pull_stretch, _pull_in_threads, rows, floats, pair, force)


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
    parameters: Parameters,
    position: Array,
    lists: NeighborLists,
    scratch: tuple[Sorted, Array],
) -> None:
    """The forces on all floats at these positions; the neighbor lists must hold there."""
    sorted_floats, force = scratch
    sort_positions(lists, position)
    sorted_force, charges = sorted_floats.force, (sorted_floats.charge, sorted_floats.radius)
    pull_all(pairs_of(lists.rows), charges, sorted_floats.pair, sorted_force)
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
    walls, strength, length = parameters.walls, parameters.wall_strength, parameters.pair[CAPILLARY_LENGTH]
    charge = parameters.floats.charge
    if parameters.wall_law == NO_WALL_LAW:
        return
    for i in range(position.shape[0]):
        for number in range(wall_count(walls)):
            x, y = position[i, 0], position[i, 1]
            distance, inward_x, inward_y = wall_distance(walls, number, x, y)
            if parameters.wall_law == PLANE:
                away = plane_wall_force(distance, strength[number, i], length)
            elif parameters.wall_law == DISH:
                away = dish_force(math.sqrt(x * x + y * y), strength[number, i], length, walls.disc_radius)
            elif parameters.wall_law == TABLED:
                mirrored = parameters.image_strength * charge[i] * charge[i]
                away = -strength[number, i] * tabled(parameters.wall_table, HEIGHT, distance)[1]
                away -= mirrored * tabled(parameters.wall_table, IMAGE, distance)[1]
            else:
                away = two_point_legacy_force(math.sqrt(x * x + y * y), strength[number, i], length, walls.disc_radius)
            force[i, 0] += away * inward_x
            force[i, 1] += away * inward_y


@compiled
def forces(parameters: Parameters, position: Array, lists: NeighborLists, scratch: tuple[Any, Array]) -> None:
    """`forces_with` ecume's own pair law alone; scratch is a `Sorted`, or has the same."""
    forces_with(pull, parameters, position, lists, scratch)
