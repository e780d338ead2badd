"""The arrangement of particles: hexatic order, pair distribution, shapes and fractal dimension of rafts; and their
paths.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree
from scipy.spatial import cKDTree

from ecume.analysis.boxes import Box, Integers, box_of, copies, nearest
from ecume.analysis.clusters import Clusters
from ecume.analysis.series import inside
from ecume.engine.walls import Walls
from ecume.engine.walls.rings import inner_radius_of, outer_walls
from ecume.engine.walls.surfaces import outline
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array, Length, Number

Complexes = NDArray[np.complex128]
FIRST_SHELL = 1.4
"""The largest distance of neighbors over the touching distance: between the first shell of a lattice, 1, and the
second, sqrt(3).
"""


def neighbor_pairs(frame: Frame, reach: Number = FIRST_SHELL) -> Integers:
    """Pairs (i, j), i < j, whose centers are nearer than `reach` times R_i + R_j; shape (pairs, 2)."""
    position, radius = frame.arrays["position"], frame.arrays["radius"]
    if len(position) < 2:
        return np.empty((0, 2), dtype=np.int64)
    box, farthest = box_of(frame), 2.0 * reach * float(radius.max())
    around = copies(position, box, farthest)
    found = cKDTree(around.position).query_pairs(farthest, output_type="ndarray")
    # Pairs of two images repeat other pairs; only those with an original particle, which come first, remain.
    pairs = np.sort(around.owner[found[found.min(axis=1) < len(position)]], axis=1)
    pairs = np.unique(pairs[pairs[:, 0] < pairs[:, 1]], axis=0)
    i, j = pairs.T
    near = np.linalg.norm(nearest(position[j] - position[i], box), axis=1) < reach * (radius[i] + radius[j])
    near &= inside(frame)[pairs].all(axis=1)
    return np.asarray(pairs[near], dtype=np.int64)


def hexatic_order(frame: Frame, reach: Number = FIRST_SHELL) -> Complexes:
    """The complex order psi_6 of each float, the mean of exp(6 i phi) over the directions of its neighbors; 0 without
    neighbors.

    Its magnitude is 1 inside a triangular lattice, its phase six times the lattice's angle. The magnitude of the mean
    measures the global order; the mean magnitude measures the local order, independent of the orientation of lattices.
    """
    position = frame.arrays["position"]
    pairs = neighbor_pairs(frame, reach)
    both = np.concatenate([pairs, pairs[:, ::-1]])
    apart = nearest(position[both[:, 1]] - position[both[:, 0]], box_of(frame))
    turned = np.exp(6j * np.arctan2(apart[:, 1], apart[:, 0]))
    count = np.bincount(both[:, 0], minlength=len(position))
    total = np.zeros(len(position), np.complex128)
    np.add.at(total, both[:, 0], turned)
    return np.asarray(total / np.maximum(count, 1))


class Region(NamedTuple):
    """The region of the floats: a disc around the origin, a rectangle of this size around it, or a convex polygon with
    these corners, counterclockwise; or a periodic cell of this size.
    """

    radius: Length = 0.0
    size: tuple[Length, Length] = (0.0, 0.0)
    corners: tuple[tuple[Length, Length], ...] = ()
    periodic: bool = False
    inner_radius: Length = 0.0
    """of a disc without its middle"""

    @property
    def area(self) -> float:
        """The area of the region (m^2)."""
        if self.radius > 0.0:
            return float(np.pi * (self.radius**2 - self.inner_radius**2))
        x, y = self._polygon().T
        return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))

    @property
    def widest(self) -> float:
        """The largest shift (m) for which `overlap` holds."""
        if self.periodic:
            return 0.5 * min(self.size)
        if self.radius > 0.0:
            return 2.0 * self.radius
        start, side = self._sides()
        # From each corner to the sides that it does not belong to.
        along = np.einsum("kjd,jd->kj", start[:, None] - start, side) / (side**2).sum(axis=1)
        foot = start + np.clip(along, 0.0, 1.0)[:, :, None] * side
        apart = np.linalg.norm(start[:, None] - foot, axis=2)
        corner, other = np.indices(apart.shape)
        return float(apart[(other != corner) & ((other + 1) % len(start) != corner)].min())

    def overlap(self, shift: Array) -> Array:
        """The area that the region shares with itself after a displacement of this length, averaged over all directions
        (m^2).

        For a disc it is the lens of two circles; for a polygon A - P r/pi + r^2/(4 pi) sum_k (1 + (pi - t_k) cot t_k)
        with the perimeter P and the angles t_k, for r up to `widest`, which for a rectangle is a b - 2 (a + b) r/pi +
        r^2/pi.
        """
        if self.periodic:
            return np.full_like(shift, self.area)
        if self.radius > 0.0:
            outer, inner = self.radius, self.inner_radius
            whole = lens(shift, outer, outer)
            return whole if inner == 0.0 else whole - 2.0 * lens(shift, outer, inner) + lens(shift, inner, inner)
        side = self._sides()[1]
        before = np.roll(side, 1, axis=0)
        across, along = before[:, 0] * side[:, 1] - before[:, 1] * side[:, 0], (before * side).sum(axis=1)
        # cot of the interior angle is minus that of the exterior angle, pi minus the interior one.
        corners = np.sum(1.0 - np.arctan2(across, along) * along / across)
        perimeter = np.linalg.norm(side, axis=1).sum()
        return np.asarray(self.area - perimeter / np.pi * shift + corners / (4.0 * np.pi) * shift**2)

    def _polygon(self) -> Array:
        a, b = self.size
        rectangle = ((-0.5 * a, -0.5 * b), (0.5 * a, -0.5 * b), (0.5 * a, 0.5 * b), (-0.5 * a, 0.5 * b))
        return np.array(self.corners or rectangle)

    def _sides(self) -> tuple[Array, Array]:
        start = self._polygon()
        return start, np.roll(start, -1, axis=0) - start


def lens(apart: Array, one: Length, other: Length) -> Array:
    """The common area of two circles with these radii, whose centers are this far apart (m^2).

    >>> round(float(lens(np.array(0.5), 2.0, 1.0)) / np.pi, 12), float(lens(np.array(3.0), 2.0, 1.0))
    (1.0, 0.0)
    """
    small, large = min(one, other), max(one, other)
    # Where circles intersect, between the distances at which one contains the other and at which they touch.
    d = np.clip(apart, max(large - small, 1e-300), large + small)
    angles = [
        np.arccos(np.clip((d**2 + r**2 - s**2) / (2.0 * d * r), -1.0, 1.0)) for r, s in ((small, large), (large, small))
    ]
    sectors = small**2 * angles[0] + large**2 * angles[1]
    # Twice the triangle of both centers and an intersection.
    square = (large + small - d) * (d + small - large) * (d - small + large) * (d + small + large)
    return np.asarray(sectors - 0.5 * np.sqrt(np.maximum(square, 0.0)))


def region_in(walls: Walls) -> Region:
    """The region that walls enclose."""
    inner, walls = inner_radius_of(walls), outer_walls(walls)
    if inner > 0.0:
        return Region(radius=walls.disc_radius, inner_radius=inner)
    if len(walls.offset):
        return Region(corners=tuple((float(x), float(y)) for x, y in outline(walls)))
    return Region(radius=walls.disc_radius)


def pair_distribution(frames: Sequence[Frame], edges: Array, region: Region) -> Array:
    """The pair distribution g(r) between the edges (m), averaged over the frames: the number of pairs over that of as
    many random points.

    The random points are inside the region. Since distant pairs are rare in a finite region, this makes g equal to 1
    for random points up to the width of the region. In a periodic region distances are those of nearest images, up to
    half of its shorter side.
    """
    widest = region.widest
    if not (region.area > 0.0 and np.all(np.diff(edges) > 0.0) and edges[0] >= 0.0 and edges[-1] <= widest):
        raise BadInput(f"edges: expected distances that rise from 0 to at most {widest:g} m, the width of the region")
    middle, nodes = 0.5 * (edges[1:] + edges[:-1]), np.polynomial.legendre.leggauss(8)
    half = 0.5 * np.diff(edges)
    r = middle[:, None] + half[:, None] * nodes[0]
    random_pairs = half * ((2.0 * np.pi * r * region.overlap(r)) @ nodes[1]) / region.area**2
    counts = np.zeros(len(middle))
    pairs = 0.0
    for frame in frames:
        position = frame.arrays["position"][inside(frame)]
        if position.shape[1] != 2:
            raise BadInput(f"frames: got positions in {position.shape[1]} dimensions; expected 2, as of the region")
        count, size = len(position), np.array(region.size)
        tree = cKDTree(np.mod(np.mod(position, size), size), boxsize=size) if region.periodic else cKDTree(position)
        # The pairs of particles with themselves, at distance 0, cancel in the differences.
        counts += np.diff(tree.count_neighbors(tree, np.asarray(edges)))
        pairs += count * (count - 1.0)
    return np.asarray(counts / (pairs * random_pairs))


class Shapes(NamedTuple):
    """The sizes and lengths of clusters, with one entry per cluster."""

    center: Array
    """(C, 2) m, of the floats' centers"""
    gyration_radius: Array
    """m, the root mean square distance of the centers from their middle; 0 for single floats"""
    elongation: Array
    """1 for what is round, infinite for a straight row: the root of the ratio of the two squares of gyration"""
    angle: Array
    """rad, of the long axis; from -pi/2 to pi/2"""


def shapes_of(frame: Frame, clusters: Clusters) -> Shapes:
    """The shapes of the clusters in a frame; in a periodic box each cluster is first made contiguous."""
    there = clusters.labels >= 0
    position, labels, sizes = whole(frame, clusters)[there], clusters.labels[there], np.maximum(clusters.sizes, 1)
    center = np.stack([np.bincount(labels, axis, len(sizes)) for axis in position.T], axis=1) / sizes[:, None]
    x, y = (position - center[labels]).T
    xx, xy, yy = (np.bincount(labels, product, len(sizes)) / sizes for product in (x * x, x * y, y * y))
    mean, apart = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(mean > 0.0, (mean + apart) / np.maximum(mean - apart, 0.0), 1.0)
    return Shapes(center, np.sqrt(2.0 * mean), np.sqrt(ratio), 0.5 * np.arctan2(2.0 * xy, xx - yy))


class Fit(NamedTuple):
    """A fitted exponent and its standard error."""

    value: float
    error: float


def fractal_dimension(sizes: Integers, gyration_radius: Array) -> Fit:
    """The exponent D of N ~ r^D with the number of floats N of rafts and their radius of gyration r (m): 2 for
    compact rafts, 1 for rows. A least-squares fit of ln N over ln r; single floats do not count.

    >>> round(fractal_dimension(np.array([1, 2, 8, 32]), np.array([0.0, 1.0, 2.0, 4.0])).value, 9)
    2.0
    """
    several = (sizes > 1) & (gyration_radius > 0.0)
    x, y = np.log(gyration_radius[several]), np.log(sizes[several])
    if len(np.unique(sizes[several])) < 3:
        raise BadInput("a fractal dimension needs rafts of three sizes or more")
    x, y = x - x.mean(), y - y.mean()
    slope = float(x @ y) / float(x @ x)
    rest = float(np.sum((y - slope * x) ** 2))
    return Fit(slope, float(np.sqrt(rest / (len(x) - 2) / (x @ x))))


def whole(frame: Frame, clusters: Clusters) -> Array:
    """Positions (m) at which each cluster is contiguous, also across the borders of a periodic box.

    Each float is at the image nearest to a neighbor that is already placed, starting from the first float of the
    cluster.
    """
    position, box = frame.arrays["position"].copy(), box_of(frame)
    if box is None:
        return position
    for label in np.flatnonzero(clusters.sizes > 1):
        members = np.flatnonzero(clusters.labels == label)
        apart = nearest((position[members] - position[members][:, None]).reshape(-1, 2), box)
        distance = np.linalg.norm(apart, axis=1).reshape(len(members), -1)
        tree = minimum_spanning_tree(distance)
        order, before = breadth_first_order(tree, 0, directed=False)
        for member in order[1:]:
            one, other = members[before[member]], members[member]
            position[other] = position[one] + nearest((position[other] - position[one])[None], box)[0]
    return position


def mean_square_displacement(tracks: Array, lags: Sequence[int]) -> Array:
    """The mean square displacement (m^2) for each lag in frames, (lags,), over all particles and start frames.
    Particles are included while they are inside; NaN if no particle is inside for this long.

    `tracks`: (frames, particles, d), as `ecume.analysis.series.tracks` makes them.
    """
    if np.ndim(tracks) != 3:
        raise BadInput("tracks: expected positions (frames, particles, d): ecume.analysis.series.tracks(frames)")
    if any(not 0 <= lag < len(tracks) for lag in lags):
        raise BadInput(f"lags: got {list(lags)}; expected numbers of frames from 0 to {len(tracks) - 1}")
    gone = [tracks[lag:] - tracks[: len(tracks) - lag] for lag in lags]
    square = (np.sum(each**2, axis=-1) for each in gone)
    return np.array([each[there].mean() if (there := ~np.isnan(each)).any() else np.nan for each in square])


def approach(tracks: Array, radius: Array, pair: tuple[int, int], box: Box | None = None) -> Array:
    """The gap between two floats over time, (frames,) m, between nearest images in a periodic box."""
    i, j = pair
    return np.asarray(np.linalg.norm(nearest(tracks[:, j] - tracks[:, i], box), axis=1) - radius[i] - radius[j])
