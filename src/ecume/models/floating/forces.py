"""Forces on all floats: pairs through the neighbor lists, walls float by float."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import admit, compiled, compiled_inside, inlined, prange, threaded
from ecume.engine.neighbors import THREADS_FROM, NeighborLists, sort_positions
from ecume.engine.walls import wall_count, wall_distance
from ecume.laws import capillarity, screened, special
from ecume.laws.capillarity import dish_force, plane_wall_force, two_point_legacy_force
from ecume.laws.screened import ScreenedFit, k1_over_x
from ecume.models.floating import parameters as constants
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    CUTOFF,
    DISH,
    INVERSE_SQUARE,
    NO_WALL_LAW,
    PLANE,
    STRENGTH,
    SURFACE_TENSION,
    TABLED,
    PairParameters,
    Parameters,
    unpack_fit,
)
from ecume.models.floating.wall_tables import HEIGHT, IMAGE, tabled
from ecume.units import Array

admit(screened, special, capillarity, constants)

ROWS_PER_TASK = 32
PADDED = 8
"""Neighbors are padded to a multiple of the vector width, since what is left over runs one by one."""


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


@inlined
def pull_rows_with(
    pull_of: Callable[..., float],
    law_of: Callable[[Array], Any],
    start: int,
    stop: int,
    rows: tuple[Any, Any, Any, Any],
    floats: tuple[Array, Array],
    pair: Array,
    force: Array,
) -> None:
    """Pair forces on the slots from `start` to `stop`, by a law's pull over the distance.

    Three plain loops instead of one: gather the neighbors, work out all their forces (this one vectorizes, without
    changing a bit), add them up in order. The middle one is in the precision of `pair` and of the charges; distances
    are taken and forces added up in double. Laws that look at no radius are given none.
    """
    first, neighbor, x, y = rows
    charge, radius = floats
    law, cutoff, length, tension = law_of(pair), pair[CUTOFF], pair[CAPILLARY_LENGTH], pair[SURFACE_TENSION]
    nothing = cutoff - cutoff
    longest = 0
    for slot in range(start, stop):
        longest = max(longest, first[slot + 1] - first[slot])
    room, kind = longest + PADDED, charge.dtype
    apart_x, apart_y, charges, radii = np.empty(room, kind), np.empty(room, kind), np.zeros(room, kind), np.ones(room)
    for slot in range(start, stop):
        begin, found = np.uint64(first[slot]), np.uint64(first[slot + 1] - first[slot])
        own_x, own_y, own_charge, own_radius = x[slot], y[slot], charge[slot], 0.0
        for k in range(found):
            j = np.uint64(neighbor[begin + k])
            apart_x[k], apart_y[k], charges[k] = x[j] - own_x, y[j] - own_y, charge[j]
        if len(radius) > 0:
            own_radius = radius[slot]
            for k in range(found):
                radii[k] = radius[neighbor[begin + k]]
        padded = (found + np.uint64(PADDED - 1)) // np.uint64(PADDED) * np.uint64(PADDED)
        for k in range(found, padded):
            apart_x[k], apart_y[k] = cutoff + cutoff, nothing
        for k in range(padded):
            square = apart_x[k] * apart_x[k] + apart_y[k] * apart_y[k]
            own = PairParameters(own_radius, radii[k], own_charge, charges[k], length, tension)
            factor = pull_of(square, own, law)
            factor = factor if square < cutoff * cutoff else nothing
            apart_x[k] *= factor
            apart_y[k] *= factor
        total_x, total_y = 0.0, 0.0
        for k in range(found):
            total_x += apart_x[k]
            total_y += apart_y[k]
        force[0, slot], force[1, slot] = total_x, total_y


@compiled
def _pull_rows(start: int, stop: int, rows: Any, floats: Any, pair: Array, force: Array) -> None:
    charge, radius = floats
    pull_rows_with(screened_pull, screened_of, start, stop, rows, (charge, radius[:0]), pair, force)


@threaded
def _pull_in_threads(tasks: int, rows: Any, floats: Any, pair: Array, force: Array) -> None:
    for task in prange(tasks):
        # Signed as outside of threads, so that one compilation serves both.
        start = int(np.int64(task)) * ROWS_PER_TASK
        _pull_rows(start, min(start + ROWS_PER_TASK, force.shape[1]), rows, floats, pair, force)


@compiled
def pull(rows: Any, floats: Any, pair: Array, force: Array) -> None:
    """Pair forces on all slots."""
    count = force.shape[1]
    if count >= THREADS_FROM:
        _pull_in_threads((count + ROWS_PER_TASK - 1) // ROWS_PER_TASK, rows, floats, pair, force)
    else:
        _pull_rows(0, count, rows, floats, pair, force)


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
    rows, order = lists.rows, lists.cells.order
    x, y = rows.sorted_position[0], rows.sorted_position[1]
    sorted_force = sorted_floats.force
    charges = (sorted_floats.charge, sorted_floats.radius)
    pull_all((rows.first, rows.neighbor, x, y), charges, sorted_floats.pair, sorted_force)
    for slot in range(len(order)):
        force[order[slot], 0], force[order[slot], 1] = sorted_force[0, slot], sorted_force[1, slot]
    add_wall_forces(parameters, position, force)
    if parameters.drift.flows:
        add_flow(parameters, position, force)


@compiled
def add_flow(parameters: Parameters, position: Array, force: Array) -> None:
    """The flowing surface drags at each float: zeta u, where u is its velocity at the float's center."""
    flow, mass, relaxation = parameters.drift.flow, parameters.floats.mass, parameters.floats.relaxation_time
    for i in range(position.shape[0]):
        friction, x, y = mass[i] / relaxation[i], position[i, 0], position[i, 1]
        force[i, 0] += friction * (flow[0] + flow[2] * x + flow[3] * y)
        force[i, 1] += friction * (flow[1] + flow[4] * x + flow[5] * y)


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
