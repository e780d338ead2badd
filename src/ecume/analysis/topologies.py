"""The graphs of contacts of clusters: labels that do not depend on the numbers of floats, symmetry numbers, and the
weights of rigid clusters in thermal equilibrium.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ecume.analysis.boxes import box_of
from ecume.analysis.clusters import TOLERANCE, Integers, components, touching_pairs
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array, Lengths, Number

MOST_FLOATS = 64
"""The largest cluster that is labeled."""

Neighbors = tuple[frozenset[int], ...]


class Topology(NamedTuple):
    """A graph of contacts up to the numbers of its floats."""

    label: str
    """floats, contacts and the adjacency of the canonical numbering in hexadecimal, such as `3-3-7` for a triangle"""
    floats: int
    contacts: int
    symmetry: int
    """symmetry number: the permutations of the floats that leave the graph unchanged. Of a rigid cluster in 2D they
    are its rotations and reflections.
    """


def topology_of(pairs: Integers | Sequence[tuple[int, int]], count: int) -> Topology:
    """The topology of a connected graph of `count` floats with these contacts.

    >>> topology_of([(0, 1), (1, 2), (0, 2)], 3)
    Topology(label='3-3-7', floats=3, contacts=3, symmetry=6)
    """
    if count > MOST_FLOATS:
        raise BadInput(f"the cluster has {count} floats; expected at most {MOST_FLOATS} for a label")
    beside: list[set[int]] = [set() for _ in range(count)]
    for i, j in pairs:
        beside[int(i)].add(int(j))
        beside[int(j)].add(int(i))
    neighbors = tuple(map(frozenset, beside))
    codes = _codes(neighbors, [0] * count)
    lowest = min(codes)
    contacts = sum(map(len, neighbors)) // 2
    return Topology(f"{count}-{contacts}-{lowest:X}", count, contacts, codes[lowest])


def _codes(neighbors: Neighbors, colors: list[int]) -> Counter[int]:
    """The adjacency of each numbering that the search reaches, as one integer, with how often it is reached.

    Colors are refined until floats of one color have the same numbers of neighbors of each color. A float of the first
    color that several share then gets a separate color, each of them in turn. Numberings with the same adjacency
    differ by an automorphism.
    """
    colors = _refined(neighbors, colors)
    shared = [color for color, uses in Counter(colors).items() if uses > 1]
    if not shared:
        return Counter([_code(neighbors, colors)])
    first = min(shared)
    found: Counter[int] = Counter()
    for chosen in (i for i, color in enumerate(colors) if color == first):
        found += _codes(neighbors, [2 * color + (i != chosen) for i, color in enumerate(colors)])
    return found


def _refined(neighbors: Neighbors, colors: list[int]) -> list[int]:
    while True:
        seen = [(color, *sorted(colors[j] for j in near)) for color, near in zip(colors, neighbors, strict=True)]
        order = {signature: rank for rank, signature in enumerate(sorted(set(seen)))}
        found = [order[signature] for signature in seen]
        if len(order) == len(set(colors)):
            return found
        colors = found


def _code(neighbors: Neighbors, numbers: list[int]) -> int:
    """The upper triangle of the adjacency matrix, row by row, as the bits of an integer."""
    return sum(
        1 << _bit(numbers[i], numbers[j]) for i, near in enumerate(neighbors) for j in near if numbers[i] < numbers[j]
    )


def _bit(low: int, high: int) -> int:
    return high * (high - 1) // 2 + low


def topologies(frame: Frame, *, tolerance: float = TOLERANCE) -> list[Topology]:
    """The topology of each cluster of a frame, in the order of its labels in `touching_clusters`.

    Two floats touch when their gap is at most `tolerance` times the smaller radius.
    """
    position, radius, box = frame.arrays["position"], frame.arrays["radius"], box_of(frame)
    period = None if box is None else box.sides.tolist()
    pairs = touching_pairs(position, radius, tolerance=tolerance, period=period)
    clusters = components(pairs, len(position))
    number = np.zeros(len(position), dtype=np.int64)
    found = []
    for label, count in enumerate(clusters.sizes):
        members = np.flatnonzero(clusters.labels == label)
        number[members] = np.arange(count)
        found.append(topology_of(number[pairs[clusters.labels[pairs[:, 0]] == label]], int(count)))
    return found


def arrangement(frame: Frame, *, tolerance: float = TOLERANCE) -> str:
    """The labels of all clusters of a frame, sorted and joined by `+`: the state of a few floats."""
    return "+".join(sorted(each.label for each in topologies(frame, tolerance=tolerance)))


def frequencies(frames: Iterable[Frame], floats: int, *, tolerance: float = TOLERANCE) -> dict[Topology, int]:
    """How often each topology of clusters of so many floats appears in the frames, most frequent first."""
    found = Counter(
        each for frame in frames for each in topologies(frame, tolerance=tolerance) if each.floats == floats
    )
    return dict(found.most_common())


def rigid_weight(position: Lengths, pairs: Integers) -> Number:
    """The weight of a rigid cluster of equal spheres with short-ranged contacts in 2D, among those with as many
    contacts: sqrt(I/(l^2 det' K))/sigma with the moment of inertia I of the centers, their distance l in contact, the
    stiffness matrix K for unit springs along contacts, det' its product of eigenvalues but the three of rigid motions,
    and the symmetry number sigma [perry2015].

    `position`: (N, 2) of touching spheres. Raises BadInput where the cluster is not rigid.
    """
    place = np.asarray(position, dtype=float)
    count = len(place)
    matrix = rigidity_matrix(place, pairs)
    eigenvalues = np.linalg.eigvalsh(matrix.T @ matrix)[3:]
    if count < 2 or not np.all(eigenvalues > 1e-9):
        raise BadInput(f"the cluster of {count} spheres and {len(pairs)} contacts is not rigid")
    apart = np.linalg.norm(place[pairs[0, 1]] - place[pairs[0, 0]])
    inertia = float(np.sum((place - place.mean(axis=0)) ** 2)) / apart**2
    return math.sqrt(inertia / float(np.prod(eigenvalues))) / topology_of(pairs, count).symmetry


def rigidity_matrix(position: Array, pairs: Integers) -> Array:
    """(contacts, 2 N): how the length of each contact changes with the coordinates of the centers."""
    matrix = np.zeros((len(pairs), *position.shape))
    for row, (i, j) in enumerate(pairs):
        along = (position[j] - position[i]) / np.linalg.norm(position[j] - position[i])
        matrix[row, i], matrix[row, j] = -along, along
    return matrix.reshape(len(pairs), -1)
