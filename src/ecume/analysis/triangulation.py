"""Neighbors in 2D by the radical triangulation, which is Delaunay's where all radii are equal.

A point belongs to the disc whose tangent to it is the shortest; two discs are neighbors where their regions share a
border. Discs that touch without overlapping are always neighbors, however unequal they are, which is not so in
Delaunay's triangulation of their centers. [gellatly1982].
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ecume.analysis.boxes import Box, Integers, box_of, copies
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array

MARGIN = 5.0
"""Of the mean spacing: copies so far around a box leave no trace of where they end."""
TOP = (0.0, 0.0, 10.0)
"""A point above all, so that the hull is a body even where all places are on one circle."""


class Neighbors(NamedTuple):
    """The pairs of neighbors at one instant, in order."""

    pairs: Integers
    """(E, 2), i < j"""
    border: Array
    """(E,) m: how long the border is that two regions share; infinite at an open edge"""


def neighbors_of(frame: Frame, box: Box | None = None) -> Neighbors:
    """The neighbors in a 2D frame of any model; without radii all particles count as equal.

    The box is that of the frame, if it has one. Two particles that meet in several copies count once, with their
    longest border: the box should be more than four spacings wide.
    """
    position = frame.arrays["position"]
    if position.shape[1] != 2:
        raise BadInput(f"neighbors are found in 2D; these frames have {position.shape[1]} dimensions")
    radius = np.asarray(frame.arrays.get("radius", np.zeros(len(position))), dtype=float)
    return radical_neighbors(position, radius, box or box_of(frame))


def radical_neighbors(position: Array, radius: Array, box: Box | None = None) -> Neighbors:
    """The pairs of neighbors among discs. They are edges of the lower hull of (x, y, x^2 + y^2 - r^2)."""
    count = len(position)
    margin = 0.0 if box is None else MARGIN * _spacing(position, box)
    around = copies(position, box, margin)
    place = around.position - around.position.mean(axis=0) if count else around.position
    unit = float(np.abs(place).max(initial=0.0)) or 1.0
    edges, border = _edges(place / unit, radius[around.owner] / unit)
    inside = (edges < count).any(axis=1)
    pairs = np.sort(around.owner[edges[inside]], axis=1)
    return _once(pairs, unit * border[inside])


def _spacing(position: Array, box: Box) -> float:
    """The mean distance between particles; along an open axis, in the length that they take up."""
    sides = np.where(box.sides > 0.0, box.sides, np.ptp(position, axis=0)) if len(position) else box.sides
    return float(np.sqrt(np.prod(sides) / max(len(position), 1)))


def _edges(place: Array, radius: Array) -> tuple[Integers, Array]:
    """Edges between places, each twice, and the lengths of the borders across them."""
    lifted = np.vstack([np.column_stack([place, (place**2).sum(axis=1) - radius**2]), TOP])
    try:
        hull = ConvexHull(lifted)
    except (QhullError, ValueError) as error:
        raise BadInput("neighbors need three particles or more that do not lie on one line") from error
    normal = hull.equations[:, :3]
    below = (normal[:, 2] < -1e-12) & (hull.simplices < len(place)).all(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        center = -0.5 * normal[:, :2] / normal[:, 2:]
    edges, border = [], []
    for corner in range(3):
        other = hull.neighbors[below, corner]
        length = np.linalg.norm(center[below] - center[other], axis=1)
        edges.append(np.delete(hull.simplices[below], corner, axis=1))
        border.append(np.where(below[other], length, np.inf))
    return np.concatenate(edges).astype(np.int64), np.concatenate(border)


def _once(pairs: Integers, border: Array) -> Neighbors:
    """Each pair once, with its longest border; no particle is a neighbor of its copy."""
    apart = pairs[:, 0] != pairs[:, 1]
    pairs, border = pairs[apart], border[apart]
    order = np.lexsort((-border, pairs[:, 1], pairs[:, 0]))
    pairs, border = pairs[order], border[order]
    first = np.ones(len(pairs), bool)
    first[1:] = (pairs[1:] != pairs[:-1]).any(axis=1)
    return Neighbors(pairs[first], border[first])
