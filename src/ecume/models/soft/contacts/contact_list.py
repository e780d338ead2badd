"""The list of contacts: the pairs of spheres, and of spheres and walls, that have a film.

`tree_search` finds the neighbors of few spheres, `neighbor_search` those of many.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ecume._jit import compiled, compiled_inside
from ecume._portable import log
from ecume.engine.cells import Integers
from ecume.engine.linear_solvers.block_matrix import near_order
from ecume.engine.walls import gaps, through
from ecume.errors import Diverged
from ecume.models.soft.cell import Box
from ecume.models.soft.contacts.tree_search import PairList, box_in, neighbors, wrapped
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.state import State
from ecume.units import Array

KEEPS_SCENE_ORDER = 36
"""The largest number of spheres that keep the order of the scene in the matrix."""


def update_contact_list(parameters: Parameters, state: State, opened: PairList | None = None) -> bool:
    """Open and close contacts at the present positions. Returns whether any changed. `opened` are the new pairs, if
    they are already known.
    """
    if np.isinf(parameters.contacts.fade_to):
        return False
    walls = state.touching.shape[1] > 0 and update_wall_contacts(parameters, state)
    kept = _kept(parameters, state)
    if opened is None:
        known = state.pair[: state.contacts[0]], state.image[: state.contacts[0]]
        opened = new_pairs(parameters, state.position, box_in(parameters, state), known)
    if kept.all() and not len(opened[0]):
        return walls
    _keep(state, np.flatnonzero(kept))
    _open(parameters, state, opened)
    return True


def new_pairs(parameters: Parameters, position: Array, box: Box, known: tuple[Integers, Integers]) -> PairList:
    """The pairs below the reach that are not in contact. `known` are the pairs in contact and their images, in order.

    If films never fade, all pairs are in contact from the start.
    """
    if np.isinf(parameters.contacts.fade_to):
        return np.zeros((0, 2), np.int64), np.zeros((0, position.shape[1]), np.int64), np.zeros((0, position.shape[1]))
    pair, image, between = neighbors(parameters, position, box)
    fresh = np.ones(len(pair), np.bool_)
    remove_known(np.concatenate([pair, image], axis=1), np.concatenate(known, axis=1), fresh)
    return pair[fresh], image[fresh], between[fresh]


@compiled
def remove_known(found: Integers, known: Integers, fresh: NDArray[np.bool_]) -> None:
    """Mark the rows that are also in `known` as not new; both lists are sorted and have no repetitions."""
    k = 0
    for row in range(len(found)):
        while k < len(known) and comes_before(known, k, found, row):
            k += 1
        fresh[row] = k == len(known) or comes_before(found, row, known, k)


@compiled_inside
def comes_before(rows: Integers, row: int, others: Integers, other: int) -> bool:
    """Whether one row precedes another in lexicographic order."""
    for k in range(rows.shape[1]):
        if rows[row, k] != others[other, k]:
            return bool(rows[row, k] < others[other, k])
    return False


@compiled
def merged_order(rows: Integers, here: int) -> Integers:
    """The order that sorts an array which consists of two sorted parts; the first part has `here` rows."""
    order = np.zeros(len(rows), np.int64)
    old, new = 0, here
    for place in range(len(rows)):
        if new == len(rows) or (old < here and comes_before(rows, old, rows, new)):
            order[place] = old
            old += 1
        else:
            order[place] = new
            new += 1
    return order


def open_all(parameters: Parameters, state: State) -> None:
    """Open the contacts at time 0."""
    glue_spheres(parameters, state)
    update_wall_contacts(parameters, state)
    if np.isinf(parameters.contacts.fade_to):
        pair = np.stack(np.triu_indices(len(state.position), 1), axis=1).astype(np.int64)
        between = state.position[pair[:, 1]] - state.position[pair[:, 0]]
        found: PairList = pair, np.zeros(between.shape, np.int64), between
    else:
        found = neighbors(parameters, state.position, box_in(parameters, state))
    _open(parameters, state, found)


def glue_spheres(parameters: Parameters, state: State) -> None:
    """Glue spheres to their walls at their present positions."""
    sphere, wall = np.nonzero(parameters.walls.glue)
    away = state.wall[wall, : state.position.shape[1]] - state.position[sphere]
    state.touching[sphere, wall] = 1
    state.slip[sphere, wall] = away / parameters.radius[sphere, None]


def wall_films(parameters: Parameters, state: State) -> NDArray[np.bool_]:
    """Whether there is a film between each sphere and each wall, (N, W); glued spheres have none to their wall."""
    return np.asarray(state.touching.astype(np.bool_) & (parameters.walls.glue == 0.0))


def update_wall_contacts(parameters: Parameters, state: State) -> bool:
    """Open and close contacts with walls at the present positions. Returns whether any changed."""
    touching, contacts = state.touching.astype(bool), parameters.contacts
    gap = wall_gaps(parameters, state.position, state.wall)
    fresh = ~touching & (gap < contacts.fade_from)
    gone = wall_films(parameters, state) & ~(state.wall_gap < log(contacts.fade_to))
    if not (fresh.any() or gone.any()):
        return False
    if (gap[fresh] <= 0.0).any():
        opened = int(np.nonzero((fresh & (gap <= 0.0)).any(axis=1))[0][0])
        raise Diverged(f"sphere {opened} met a wall without a film between them; set films.cutoff higher")
    state.touching[:] = (touching & ~gone) | fresh
    sphere, wall = np.nonzero(fresh)
    state.wall_gap[sphere, wall] = log(gap[sphere, wall])
    dimensions = state.position.shape[1]
    slip = (state.wall[wall, :dimensions] - state.position[sphere]) / parameters.radius[sphere, None]
    normal = parameters.walls.surfaces.place[wall, :dimensions]
    slip -= (slip * normal).sum(axis=1)[:, None] * normal
    state.slip[sphere, wall] = slip
    state.generation[0] += 1
    return True


def wall_gaps(parameters: Parameters, position: Array, wall: Array) -> Array:
    """Gaps from each undeformed sphere to each wall, (N, W) m; `wall` is a point of each wall."""
    return np.asarray(gaps(position, through(parameters.walls.surfaces, wall)) - parameters.radius[:, None])


def _open(parameters: Parameters, state: State, found: PairList) -> None:
    """Add contacts without a force, with gap vectors along the lines of centers, and sort all contacts."""
    pair, image, between = found
    here = int(state.contacts[0])
    total = here + len(pair)
    if total > len(state.pair):
        raise Diverged(f"{total} contacts are more than there is room for, {len(state.pair)}; set films.cutoff lower")
    length = np.linalg.norm(between, axis=1)
    gap = length - parameters.radius[pair].sum(axis=1)
    if not (gap > 0.0).all():
        first, second = pair[np.argmin(gap)]
        raise Diverged(f"spheres {first} and {second} met without a film between them; set films.cutoff higher")
    state.pair[here:total], state.image[here:total] = pair, image
    state.log_gap[here:total] = log(gap)
    state.direction[here:total] = between / length[:, None]
    state.contacts[0] = total
    _keep(state, merged_order(np.concatenate([state.pair[:total], state.image[:total]], axis=1), here))
    if len(state.position) > KEEPS_SCENE_ORDER:
        state.order[:] = near_order(wrapped(state.position, box_in(parameters, state)))
    state.generation[0] += 1


def _kept(parameters: Parameters, state: State) -> NDArray[np.bool_]:
    """Flags of the contacts whose films have not faded."""
    return np.asarray(state.log_gap[: state.contacts[0]] < log(parameters.contacts.fade_to))


def _keep(state: State, kept: Integers) -> None:
    for array in (state.pair, state.image, state.log_gap, state.direction):
        array[: len(kept)] = array[kept]
    state.contacts[0] = len(kept)
