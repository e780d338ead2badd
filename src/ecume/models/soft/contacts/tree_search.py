"""Neighbor search among few spheres by a tree. `neighbor_search` finds the same pairs among many spheres."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ecume.engine.cells import Integers
from ecume.models.soft.cell import Box, box_of
from ecume.models.soft.contacts.neighbor_search import periodic_copies, search
from ecume.models.soft.parameters import Parameters
from ecume.models.soft.state import State
from ecume.units import Array

CELL_SEARCH_FROM = 1000
"""The number of spheres from which cells are used, with threads; the tree needs no compiled code."""

PairList = tuple[Integers, Integers, Array]
"""Pairs, images, and the vectors between the centers."""


def neighbors(parameters: Parameters, position: Array, box: Box) -> PairList:
    """All pairs whose gap without deflection is below the reach, in order, including periodic images.

    A pair with a periodic image is found twice; only the pair whose first sphere is in the box is kept.
    """
    radius = parameters.radius
    far = 2.0 * float(radius.max()) + parameters.contacts.fade_from
    if len(position) >= CELL_SEARCH_FROM and box.sides.any():
        copies = periodic_copies(wrapped(position, box), box.sides, _shifts(box, position.shape[1]), far)
        return search(radius, parameters.contacts.fade_from, copies, image_indices(position, box))
    place, owner, copy = _copies(position, box, far)
    from scipy.spatial import cKDTree

    found = cKDTree(place).query_pairs(far, output_type="ndarray")
    found = found[found[:, 0] < len(position)]
    first, second = owner[found[:, 0]], owner[found[:, 1]]
    found = found[(first < second) | ((first == second) & ~_negative(copy[found[:, 1]]))]
    between = place[found[:, 1]] - place[found[:, 0]]
    pair = owner[found]
    near = np.linalg.norm(between, axis=1) - radius[pair[:, 0]] - radius[pair[:, 1]] < parameters.contacts.fade_from
    pair, between, image = pair[near], between[near], copy[found[near, 1]]
    away = image_indices(position, box)
    image += away[pair[:, 0]] - away[pair[:, 1]]
    order = order_of(pair, image)
    return pair[order], image[order], between[order]


def box_in(parameters: Parameters, state: State) -> Box:
    """The present box."""
    return box_of(parameters.box, state.cell, state.position.shape[1])


def image_indices(position: Array, box: Box) -> Integers:
    """The periodic image that contains each position."""
    away = np.zeros(position.shape, np.int64)
    for axis in range(position.shape[1] - 1, -1, -1):
        if box.sides[axis] > 0.0:
            shift = box.tilt * away[:, 1] if axis == 0 else 0.0
            away[:, axis] = np.floor((position[:, axis] - shift) / box.sides[axis])
    return away


def wrapped(position: Array, box: Box) -> Array:
    """Positions wrapped into the box; unchanged without a box."""
    away = image_indices(position, box)
    places = position - away * box.sides
    places[:, 0] -= box.tilt * away[:, 1]
    return np.asarray(places)


def _copies(position: Array, box: Box, far: float) -> tuple[Array, Integers, Integers]:
    """The spheres in their box and copies of those near its borders: positions, owners, and images."""
    count, dimensions = position.shape
    home = np.zeros((count, dimensions), np.int64)
    if not box.sides.any():
        return position, np.arange(count), home
    places = wrapped(position, box)
    every, owners, copies = [places], [np.arange(count)], [home]
    for move, lean in zip(*_shifts(box, dimensions), strict=True):
        moved = places + move * box.sides
        moved[:, 0] += lean
        seen = ((box.sides == 0.0) | ((moved > -far) & (moved < box.sides + far))).all(axis=1)
        every.append(moved[seen])
        owners.append(np.flatnonzero(seen))
        copies.append(np.broadcast_to(move, (int(seen.sum()), dimensions)))
    return np.concatenate(every), np.concatenate(owners), np.concatenate(copies)


def _shifts(box: Box, dimensions: int) -> tuple[Integers, Array]:
    """The neighboring images of the box, and the displacement of each along the first axis by the tilt (m)."""
    moves = []
    for shift in np.ndindex(*(3,) * dimensions):
        move = np.array(shift) - 1
        if not move.any() or move[box.sides == 0.0].any():
            continue
        # Above and below, the tilt displaces the images; these are the three closest to the box.
        if box.tilt != 0.0:
            move[0] -= round(box.tilt * move[1] / box.sides[0])
        moves.append(move)
    every: Integers = np.array(moves, np.int64).reshape(-1, dimensions)
    return every, np.asarray(box.tilt * every[:, 1], np.float64)


def _negative(image: Integers) -> NDArray[np.bool_]:
    """Whether the first nonzero component is negative; only one of two opposite images is kept."""
    first = np.argmax(image != 0, axis=1)
    return np.asarray(image[np.arange(len(image)), first] < 0)


def order_of(pair: Integers, image: Integers) -> Integers:
    """The order of contacts: by the first sphere, the second, and the image."""
    order: Integers = np.lexsort((*image.T[::-1], pair[:, 1], pair[:, 0]))
    return order
