"""How far a liquid has come, and how high it stands: what dam breaks are measured by."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ecume.engine.shapes import Flags
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array, Length

TOGETHER = 1.6
"""Particles closer than this many spacings belong to one liquid."""


def front_position(frame: Frame, spacing: Length, *, below: Length = np.inf) -> float:
    """The largest x that the liquid has reached (m), its edge and not its last particle's center; drops that have come
    off do not count. `below` is the height under which to look.
    """
    position = frame.arrays["position"]
    near = largest_piece(position, spacing) & (position[:, 1] < below)
    if not near.any():
        raise BadInput(f"there is no liquid below {below:g} m")
    return float(position[near, 0].max()) + 0.5 * spacing


def largest_piece(position: Array, spacing: Length) -> Flags:
    """(N,) which particles belong to the largest connected piece of liquid."""
    pairs = cKDTree(position).query_pairs(TOGETHER * spacing, output_type="ndarray")
    count = len(position)
    graph = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    _, piece = connected_components(graph, directed=False)
    mine: Flags = piece == np.bincount(piece).argmax()
    return mine


def level_by_column(frame: Frame, edges: Array) -> Array:
    """How deep the liquid in each column would stand (m): its volume over the column's ground.

    `edges` are those of the columns along x, one more than columns, in the plane.
    """
    if np.any(np.diff(edges) <= 0.0):
        raise BadInput("edges of columns must grow from one to the next")
    volume = frame.arrays["mass"] / frame.arrays["density"]
    found, _ = np.histogram(frame.arrays["position"][:, 0], edges, weights=volume)
    depth: Array = found / np.diff(edges)
    return depth


def top_by_column(frame: Frame, edges: Array, spacing: Length) -> Array:
    """How high the liquid reaches in each column (m), spray and all; not a number where there is none."""
    position = frame.arrays["position"]
    column = np.digitize(position[:, 0], edges) - 1
    tops = np.full(len(edges) - 1, -np.inf)
    inside = (column >= 0) & (column < len(tops))
    np.maximum.at(tops, column[inside], position[inside, 1] + 0.5 * spacing)
    return np.where(np.isfinite(tops), tops, np.nan)
