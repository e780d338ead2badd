"""Pieces of a packing that films hold together, and what holds a piece that nothing else does.

Without drag, the place of a sphere without films, a rattler, is not determined, and neither is that of several that are
tied to each other only. If nothing pulls at such a piece it stays where it is, and goes with the box: its first sphere
is anchored. Forces on it are in balance, so that the anchor bears nothing.
"""

from __future__ import annotations

import numpy as np

from ecume.engine.cells import Integers
from ecume.errors import Diverged
from ecume.models.soft.parameters import Parameters
from ecume.units import Array

UNBALANCED = 1e-9
"""Of the largest force: what the sum of all forces may be where nothing holds the spheres."""


def pieces(pair: Integers, touching: Integers) -> Integers:
    """The connected piece of the contact graph that each sphere belongs to; at the end that of all walls, if any.

    Spheres are connected by pairs (C, 2), and by walls that they touch (N, walls).
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
    """The first sphere of each piece that neither walls nor drag hold, and of those at whose piece something pulls.

    Nothing of it is loose where all spheres are one piece: only their common place is then undetermined.
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
    """The stiffness that holds each sphere (N/m): of the size of a contact's for the first of a loose piece, or zero.
    Raises Diverged where something pulls at a loose piece.
    """
    anchor = np.zeros(len(touching))
    first, pulled = loose_spheres(parameters, pair, touching)
    if len(pulled):
        message = f"sphere {pulled[0]} has lost its last film, and nothing balances the force on it"
        raise Diverged(f"{message}; set films.cutoff higher, or hydrodynamics.drag = 'stokes'")
    anchor[first] = parameters.modulus[first] * parameters.radius[first]
    return anchor
