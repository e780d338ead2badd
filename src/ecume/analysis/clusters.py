"""Rafts: floats that touch, directly or through others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ecume.analysis.boxes import box_of
from ecume.trajectories.frame import Frame
from ecume.units import Array

TOLERANCE = 1e-3
"""Two floats touch when the gap between them is below this part of the smaller one's radius."""

Integers = NDArray[np.int64]


class Clusters(NamedTuple):
    """The assignment of floats to clusters; a float that touches no other is a cluster of one."""

    labels: Integers
    """The cluster of each float, numbered from 0."""
    sizes: Integers
    """The number of floats in each cluster."""

    @property
    def mean_size(self) -> float:
        """The mean number of floats in a cluster, single floats counted as clusters; 0 where there are no floats."""
        return float(self.sizes.mean()) if self.sizes.size else 0.0

    @property
    def largest(self) -> int:
        """The number of floats in the largest cluster."""
        return int(self.sizes.max(initial=0))


def touching_pairs(
    position: Array, radius: Array, *, tolerance: float = TOLERANCE, period: Sequence[float] | None = None
) -> Integers:
    """Pairs (i, j), i < j, whose gap is at most `tolerance` times the smaller radius; shape (pairs, 2).

    `period` is the length of a periodic box along each axis; 0 or less for an axis that is not periodic.
    """
    lengths = np.zeros(position.shape[1]) if period is None else np.maximum(np.asarray(period, dtype=float), 0.0)
    wrapped = np.where(lengths > 0, np.mod(position, np.where(lengths > 0, lengths, 1.0)), position)
    # The tree wants 0 <= x < L, and the modulus of a tiny negative number rounds up to L.
    wrapped = np.where((lengths > 0) & (wrapped >= lengths), 0.0, wrapped)
    if len(position) < 2:
        return np.empty((0, 2), dtype=np.int64)
    reach = (2 + tolerance) * float(radius.max())
    pairs = np.sort(cKDTree(wrapped, boxsize=lengths).query_pairs(reach, output_type="ndarray"), axis=1)
    i, j = pairs.T
    displacement = wrapped[j] - wrapped[i]
    displacement -= lengths * np.round(displacement / np.where(lengths > 0, lengths, 1.0))
    gap = np.linalg.norm(displacement, axis=1) - radius[i] - radius[j]
    touching: Integers = pairs[gap <= tolerance * np.minimum(radius[i], radius[j])].astype(np.int64)
    return touching


def touching_clusters(frame: Frame, *, tolerance: float = TOLERANCE, period: Sequence[float] | None = None) -> Clusters:
    """The clusters of one instant; `period` is by default that of the frame's box, unless it is sheared.

    >>> arrays = {"position": np.array([[0.0, 0.0], [2.0, 0.0], [9.0, 0.0]]), "radius": np.ones(3)}
    >>> touching_clusters(Frame(0.0, arrays, {}, {})).sizes.tolist()
    [2, 1]
    """
    position, radius = frame.arrays["position"], frame.arrays["radius"]
    if period is None and (box := box_of(frame)) is not None and box.strain == 0.0:
        period = box.sides.tolist()
    pairs = touching_pairs(position, radius, tolerance=tolerance, period=period)
    return components(pairs, len(position))


def components(pairs: Integers, count: int) -> Clusters:
    """The connected parts of the graph whose edges are these pairs, of `count` floats."""
    edges: Any = coo_array((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    clusters, found = connected_components(edges, directed=False)
    labels: Integers = np.asarray(found, dtype=np.int64)
    return Clusters(labels, np.bincount(labels, minlength=clusters).astype(np.int64))


def mean_raft(clusters: Clusters) -> float:
    """The mean number of floats in the cluster of a float, sum n^2/sum n: large rafts count by their floats."""
    return float(np.sum(clusters.sizes**2) / max(int(clusters.sizes.sum()), 1))


def shares_by_size(clusters: Clusters, edges: Sequence[int]) -> Array:
    """The share of the floats that are in clusters of edges[k] to edges[k + 1] - 1 floats; the last class has no end.

    >>> shares_by_size(Clusters(np.array([0, 0, 0, 1]), np.array([3, 1])), [1, 2, 4]).tolist()
    [0.25, 0.75, 0.0]
    """
    classes = np.searchsorted(np.asarray(edges), clusters.sizes, side="right") - 1
    counted = classes >= 0
    floats = np.bincount(classes[counted], clusters.sizes[counted], len(edges))
    return np.asarray(floats / max(int(clusters.sizes.sum()), 1))
