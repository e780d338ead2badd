"""Clusters of floats in contact: rafts, the topologies of their contacts, and transitions between topologies."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Hashable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ecume.analysis.boxes import box_of
from ecume.analysis.series import Mean, inside
from ecume.engine.stationarity import BLOCKS
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array, Lengths, Number

TOLERANCE = 1e-3
"""The gap over the smaller radius below which two floats touch."""

Integers = NDArray[np.int64]


class Clusters(NamedTuple):
    """The assignment of floats to clusters; an isolated float is a cluster of one."""

    labels: Integers
    """The cluster of each float, numbered from 0; -1 for a particle that has left."""
    sizes: Integers
    """The number of floats in each cluster."""

    @property
    def mean_size(self) -> float:
        """The mean number of floats in a cluster, where single floats count as clusters; 0 without floats."""
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
    # The tree requires 0 <= x < L, but the remainder of a tiny negative number is rounded up to L.
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
    """The clusters of one instant; by default, `period` is that of the box of the frame, unless it is sheared.

    >>> arrays = {"position": np.array([[0.0, 0.0], [2.0, 0.0], [9.0, 0.0]]), "radius": np.ones(3)}
    >>> touching_clusters(Frame(0.0, arrays, {}, {})).sizes.tolist()
    [2, 1]
    """
    position, radius = frame.arrays["position"], frame.arrays["radius"]
    if period is None and (box := box_of(frame)) is not None and box.strain == 0.0:
        period = box.sides.tolist()
    there = inside(frame)
    pairs = touching_pairs(position[there], radius[there], tolerance=tolerance, period=period)
    found = components(pairs, int(there.sum()))
    labels = np.full(len(position), -1, np.int64)
    labels[there] = found.labels
    return found._replace(labels=labels)


def components(pairs: Integers, count: int) -> Clusters:
    """The connected components of the graph of `count` floats with these pairs as edges."""
    edges: Any = coo_array((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    clusters, found = connected_components(edges, directed=False)
    labels: Integers = np.asarray(found, dtype=np.int64)
    return Clusters(labels, np.bincount(labels, minlength=clusters).astype(np.int64))


def mean_raft(clusters: Clusters) -> float:
    """The mean size of the cluster of a randomly chosen float, sum n^2/sum n, in which large rafts
    have larger weights.
    """
    return float(np.sum(clusters.sizes**2) / max(int(clusters.sizes.sum()), 1))


def shares_by_size(clusters: Clusters, edges: Sequence[int]) -> Array:
    """The fractions of floats in clusters of edges[k] to edges[k + 1] - 1 floats; the last class has no upper limit.

    >>> shares_by_size(Clusters(np.array([0, 0, 0, 1]), np.array([3, 1])), [1, 2, 4]).tolist()
    [0.25, 0.75, 0.0]
    """
    classes = np.searchsorted(np.asarray(edges), clusters.sizes, side="right") - 1
    counted = classes >= 0
    floats = np.bincount(classes[counted], clusters.sizes[counted], len(edges))
    return np.asarray(floats / max(int(clusters.sizes.sum()), 1))


MOST_FLOATS = 64
"""The largest cluster that is labeled."""

Neighbors = tuple[frozenset[int], ...]


class Topology(NamedTuple):
    """The graph of contacts of a cluster, regardless of the order of its floats."""

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
    """The adjacency of each numbering that the search reaches, as one integer, with its number of
    occurrences.

    Colors are refined until floats of one color have the same numbers of neighbors of each color. Then each float of
    the first color that several share gets a separate color, one after the other. Numberings with the same adjacency
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
    """The number of occurrences of each topology of clusters with this number of floats, in descending order."""
    found = Counter(
        each for frame in frames for each in topologies(frame, tolerance=tolerance) if each.floats == floats
    )
    return dict(found.most_common())


def rigid_weight(position: Lengths, pairs: Integers) -> Number:
    """The weight of a rigid cluster of equal spheres with short-ranged contacts in 2D, among clusters with as many
    contacts: sqrt(I/(l^2 det' K))/sigma, where I is the moment of inertia of the centers, l the distance of centers in
    contact, K the stiffness matrix for unit springs along contacts, det' the product of the eigenvalues except the
    three of rigid motions, and sigma the symmetry number [perry2015].

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
    """The (contacts, 2 N) derivatives of the contact lengths by the coordinates of the centers."""
    matrix = np.zeros((len(pairs), *position.shape))
    for row, (i, j) in enumerate(pairs):
        along = (position[j] - position[i]) / np.linalg.norm(position[j] - position[i])
        matrix[row, i], matrix[row, j] = -along, along
    return matrix.reshape(len(pairs), -1)


class Transitions(NamedTuple):
    """The number of transitions between each pair of states in a sequence."""

    states: tuple[str, ...]
    """most frequent first"""
    visits: Integers
    """(S,) instants in each state"""
    counts: Integers
    """(S, S) changes from the row's state to the column's between neighboring instants; the diagonal counts stays"""

    @property
    def probabilities(self) -> Array:
        """The probability of the state of the column at the next instant, (S, S); 0 for states without a successor."""
        total = self.counts.sum(axis=1, keepdims=True)
        return np.asarray(np.divide(self.counts, total, out=np.zeros(self.counts.shape), where=total > 0))

    @property
    def currents(self) -> Integers:
        """The net numbers of changes from the state of the row to that of the column, (S, S); zero on average in
        equilibrium.
        """
        return np.asarray(self.counts - self.counts.T)


def transitions(sequence: Sequence[Hashable]) -> Transitions:
    """Count the transitions of a sequence of states.

    >>> transitions(["dimer", "dimer", "trimer", "dimer"]).counts.tolist()
    [[1, 1], [1, 0]]
    """
    states, numbers, visits = _numbered(sequence)
    return Transitions(tuple(map(str, states)), visits, _counts(numbers, len(states)))


def entropy_production(sequences: Sequence[Sequence[Hashable]], every: float, blocks: int = BLOCKS) -> Mean:
    """The entropy production rate of steady sequences of states at distances of `every` seconds (k_B/s).

    The rate is the sum over pairs of states of the net current times ln(n_ij/n_ji), with the numbers n_ij of changes
    [schnakenberg1976]. It is a lower bound, since changes that the states do not resolve are not included. The product
    of a current and a ratio from the same changes is positive even in equilibrium. Therefore each sequence is cut into
    blocks, and the current of each block is multiplied by the ratio, with 1/2 added to each count, of all others. In
    equilibrium the mean is zero if blocks are longer than the correlation time of the sequences. The error is that of
    the mean over blocks; one block suffices where there are several independent sequences.
    """
    if blocks * len(sequences) < 2 or any(len(each) < 4 * blocks for each in sequences):
        raise BadInput(
            f"got {len(sequences)} sequences, the shortest of {min(map(len, sequences), default=0)} states, for "
            f"{blocks} blocks each; expected 2 blocks or more, and 4 states for each"
        )
    states, numbers, _ = _numbered([state for each in sequences for state in each])
    ends = np.cumsum([len(each) for each in sequences])[:-1]
    cut = [part for each in np.split(numbers, ends) for part in np.array_split(each, blocks)]
    parts = [_counts(part, len(states)) for part in cut]
    total = np.sum(parts, axis=0)
    rates = []
    for part in parts:
        other = total - part + 0.5
        affinity = np.log(other / other.T)
        rates.append(0.5 * float(np.sum((part - part.T) * affinity)) / (every * int(part.sum())))
    return Mean(float(np.mean(rates)), float(np.std(rates, ddof=1) / np.sqrt(len(rates))))


class Cycle(NamedTuple):
    """A cycle of three states, and its net number of turns."""

    states: tuple[str, str, str]
    turns: float
    """smallest of the three net currents, all of them in this direction; 0 where they differ in sign"""
    affinity: float
    """ln of the product of counts in this direction over that in the opposite one, with 1/2 added to each"""


def cycles(found: Transitions) -> list[Cycle]:
    """The cycles of three states, in the direction of their net currents, in descending order of turns."""
    net, counts = found.currents, found.counts + 0.5
    triples = []
    for a in range(len(net)):
        for b in range(a + 1, len(net)):
            for c in range(b + 1, len(net)):
                around = (a, b, c) if net[a, b] + net[b, c] + net[c, a] >= 0 else (a, c, b)
                steps = list(zip(around, (*around[1:], around[0]), strict=True))
                affinity = sum(float(np.log(counts[i, j] / counts[j, i])) for i, j in steps)
                i, j, k = around
                names = (found.states[i], found.states[j], found.states[k])
                triples.append(Cycle(names, float(max(min(net[step] for step in steps), 0)), affinity))
    return sorted(triples, key=lambda cycle: -cycle.turns)


def _numbered(sequence: Sequence[Hashable]) -> tuple[list[Hashable], Integers, Integers]:
    """The states, most frequent first, the sequence as their numbers, and the instants in each."""
    visits: dict[Hashable, int] = {}
    for state in sequence:
        visits[state] = visits.get(state, 0) + 1
    states = sorted(visits, key=lambda state: -visits[state])
    number = {state: index for index, state in enumerate(states)}
    numbers = np.array([number[state] for state in sequence], dtype=np.int64)
    return states, numbers, np.array([visits[state] for state in states], dtype=np.int64)


def _counts(numbers: Integers, states: int) -> Integers:
    pairs = numbers[:-1] * states + numbers[1:]
    return np.bincount(pairs, minlength=states * states).reshape(states, states).astype(np.int64)
