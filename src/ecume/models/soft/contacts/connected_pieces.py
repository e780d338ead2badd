"""Connected pieces of a packing, and anchors of undetermined pieces.

Without drag, the position of a sphere without films (a rattler) is undetermined, and so is that of spheres that are
connected only with one another. If no force acts on such a piece, it moves with the box: its first sphere is anchored.
The forces on the piece balance, so that the anchor exerts no force. A piece may also rotate as a whole, unless its
films wind around the periodic cell: only then is the spin of its first sphere determined, and not anchored.

A sphere with a single film may roll around its neighbor without any resistance, and so may the spheres of a chain that
ends freely. If no force acts on them, they do not spin. This determines where they roll to, which rounding would
otherwise decide; the torque that it takes is zero.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ecume.engine.cells import Integers
from ecume.errors import Diverged
from ecume.models.soft.parameters import Parameters
from ecume.units import Array

UNBALANCED = 1e-9
"""The largest permitted sum of all forces on a free piece, over the largest force."""


def pieces(pair: Integers, touching: Integers) -> Integers:
    """The connected piece of the contact graph to which each sphere belongs; the last entry is that of the walls, if
    any.

    Spheres are connected by pairs (C, 2) and by the walls that they touch (N, walls).
    """
    count, beside = len(touching), np.flatnonzero(touching.any(axis=1))
    first, second = np.append(pair[:, 0], beside), np.append(pair[:, 1], np.full(len(beside), count))
    nodes = count + bool(touching.shape[1])
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(first)), (first, second)), shape=(nodes, nodes))
    found: Integers = connected_components(graph, directed=False)[1].astype(np.int64)
    return found


def loose_spheres(parameters: Parameters, pair: Integers, touching: Integers) -> tuple[Integers, Integers]:
    """The first sphere of each piece that neither walls nor drag hold, and which of these belong to pieces on which a
    force acts.

    If all spheres are one piece, none is returned: then only their common translation is undetermined.
    """
    none = np.zeros(0, np.int64)
    if parameters.drag.any():
        return none, none
    piece, count = pieces(pair, touching), len(touching)
    if piece.max() == 0:
        return none, none
    kinds, first = np.unique(piece[:count], return_index=True)
    if len(piece) > count:
        first = first[kinds != piece[count]]
    force = parameters.force + parameters.weight
    total = np.zeros((int(piece.max()) + 1, force.shape[1]))
    np.add.at(total, piece[:count], force)
    turned = np.zeros(len(total), np.bool_)
    turned[piece[:count][parameters.torque.any(axis=1)]] = True
    pulled = (np.abs(total).max(axis=1) > UNBALANCED * np.abs(force).max() * len(force)) | turned
    return first, first[pulled[piece[first]]]


def anchors(parameters: Parameters, pair: Integers, touching: Integers) -> Array:
    """The anchor stiffness of each sphere (N/m): that of a typical contact for the first sphere of a free piece,
    otherwise zero. Raises Diverged if a force acts on a free piece.
    """
    anchor = np.zeros(len(touching))
    first, pulled = loose_spheres(parameters, pair, touching)
    if len(pulled):
        message = f"sphere {pulled[0]} has lost its last film, and nothing balances the force on it"
        raise Diverged(f"{message}; set films.cutoff higher, or hydrodynamics.drag = 'stokes'")
    anchor[first] = parameters.modulus[first] * parameters.radius[first]
    return anchor


def dangling_spheres(parameters: Parameters, pair: Integers, touching: Integers, anchor: Array) -> NDArray[np.bool_]:
    """Whether each sphere is held by one film alone, after removal of others that are; no force acts on them.

    Anchored spheres are not among them, nor are spheres with drag, or those of clusters in unbounded liquid, which
    rotate as a whole.
    """
    found, bounded = np.zeros(len(touching), np.bool_), bool(parameters.box.any()) or touching.shape[1] > 0
    if parameters.drag.any() or not bounded:
        return found
    pulled = np.concatenate([parameters.force, parameters.weight, parameters.torque], axis=1).any(axis=1)
    may, here = ~pulled & (anchor == 0.0), np.ones(len(pair), np.bool_)
    films = np.bincount(pair.ravel(), minlength=len(touching)) + touching.sum(axis=1)
    while (ends := may & ~found & (films == 1)).any():
        joined = pair[here & ends[pair].all(axis=1)]
        ends[joined[:, 1]] = False
        found |= ends
        removed = here & ends[pair].any(axis=1)
        films -= np.bincount(pair[removed].ravel(), minlength=len(films))
        here &= ~removed
    return found


def turning_pieces(pair: Integers, image: Integers, anchor: Array) -> NDArray[np.bool_]:
    """Whether each anchored sphere is that of a piece which can rotate as a whole, since no closed loop of its films
    leads to a periodic image.
    """
    turning = anchor > 0.0
    if not turning.any() or not image.any():
        return turning
    piece = pieces(pair, np.zeros((len(anchor), 0), np.int64))
    cell, known = np.zeros((len(anchor), image.shape[1]), np.int64), np.zeros(len(anchor), np.bool_)
    known[np.unique(piece, return_index=True)[1]] = True
    ends = (pair[:, 0], pair[:, 1], image), (pair[:, 1], pair[:, 0], -image)
    while not known.all():
        for here, there, shift in ends:
            new = known[here] & ~known[there]
            cell[there[new]] = cell[here[new]] + shift[new]
            known[there[new]] = True
    winds = (cell[pair[:, 0]] + image != cell[pair[:, 1]]).any(axis=1)
    return turning & ~np.isin(piece, piece[pair[winds, 0]])
