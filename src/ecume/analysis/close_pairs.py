"""Close pairs of particles: gaps, their distribution, contacts, coordination numbers and volume fraction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ecume.analysis.boxes import Box, Integers, box_of, copies, nearest
from ecume.analysis.series import inside
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame, omitted_from
from ecume.units import Array, Force, Length


class Near(NamedTuple):
    """Pairs of particles, each listed once."""

    pairs: Integers
    """(C, 2)"""
    gap: Array
    """(C,) m between surfaces"""


class Distribution(NamedTuple):
    """The distribution of gaps: the integral of `density` over ln(gap) is 1."""

    edges: Array
    """(B + 1,) m"""
    density: Array
    """(B,)"""
    density_error: Array
    """(B,) of counting"""

    @property
    def middles(self) -> Array:
        """The centers of the bins on a logarithmic scale, (B,) m."""
        return np.asarray(np.sqrt(self.edges[1:] * self.edges[:-1]))


def near_pairs(frame: Frame, reach: Length, box: Box | None = None) -> Near:
    """The pairs whose undeformed surfaces are less than `reach` apart, in frames of any model with radii.

    The box is that of the frame, if it has one. Overlapping surfaces have negative gaps.
    """
    position, radius = frame.arrays["position"], frame.arrays["radius"]
    box = box or box_of(frame)
    far = 2.0 * float(radius.max(initial=0.0)) + reach
    around = copies(position, box, far)
    if len(position) < 2 or far <= 0.0:
        return Near(np.zeros((0, 2), np.int64), np.zeros(0))
    found = cKDTree(around.position).query_pairs(far, output_type="ndarray")
    found = found[(found < len(position)).any(axis=1)]
    length = np.linalg.norm(around.position[found[:, 1]] - around.position[found[:, 0]], axis=1)
    pairs = np.sort(around.owner[found], axis=1)
    gap = length - radius[pairs].sum(axis=1)
    near = (gap < reach) & (pairs[:, 0] != pairs[:, 1]) & inside(frame)[pairs].all(axis=1)
    return _once(pairs[near], gap[near])


def _once(pairs: Integers, gap: Array) -> Near:
    """Each pair only once, with its narrowest gap."""
    order = np.lexsort((gap, pairs[:, 1], pairs[:, 0]))
    pairs, gap = pairs[order], gap[order]
    first = np.ones(len(pairs), bool)
    first[1:] = (pairs[1:] != pairs[:-1]).any(axis=1)
    return Near(pairs[first], gap[first])


def films(frame: Frame) -> Near:
    """The films between soft spheres in a frame: their gaps are those of deflected surfaces."""
    if "neighbor" not in (*frame.arrays, *omitted_from(frame)):
        raise BadInput("the frames contain no films; near_pairs finds close pairs")
    first, slot = np.nonzero(frame.arrays["neighbor"] >= 0)
    pairs = np.stack([first, frame.arrays["neighbor"][first, slot]], axis=1)
    return Near(pairs, frame.arrays["gap"][first, slot])


class ContactTable(NamedTuple):
    """All contacts between spheres in a frame, with a row each; forces act on the first sphere of a pair."""

    pairs: Integers
    """(C, 2)"""
    image: Integers
    """(C, d) the periodic image of the second sphere"""
    gap: Array
    normal_force: Array
    """(C, d) N; along the vector from the first to the second in tension"""
    tangential_force: Array
    """(C, d) N"""
    deflection: Array
    """(C, d) m, of both surfaces together: the vector between the centers less the gap vector"""

    @property
    def force(self) -> Array:
        """The force on the first sphere, (C, d) N."""
        return np.asarray(self.normal_force + self.tangential_force)


def contact_table(frame: Frame) -> ContactTable:
    """The contacts of a frame of a scene with `films.output = "vectors"`, complete if `unlisted_contacts` is 0."""
    if "normal_force" not in (*frame.arrays, *omitted_from(frame)):
        raise BadInput('the frames contain no force vectors; set films.output = "vectors" and run the scene again')
    first, slot = np.nonzero(frame.arrays["neighbor"] >= 0)
    pairs = np.stack([first, frame.arrays["neighbor"][first, slot]], axis=1)
    names = ("contact_image", "gap", "normal_force", "tangential_force", "deflection")
    return ContactTable(pairs, *(frame.arrays[name][first, slot] for name in names))


def gap_distribution(gap: Array, bins: int = 30, span: tuple[Length, Length] | None = None) -> Distribution:
    """The distribution of ln(gap), for positive gaps between the ends of `span`.

    >>> found = gap_distribution(np.geomspace(1e-6, 1e-2, 4001), bins=4)
    >>> (found.density * np.log(10.0)).round(2).tolist()
    [0.25, 0.25, 0.25, 0.25]
    """
    gap = gap[gap > 0.0]
    if not len(gap):
        raise BadInput("the frames contain no gaps")
    low, high = span or (float(gap.min()), float(gap.max()))
    if not low < high:
        low, high = low / 1.1, high * 1.1
    edges = np.geomspace(low, high, bins + 1)
    edges[0], edges[-1] = low, high  # set exactly, so that the smallest and the largest gap are inside
    counts = np.histogram(gap, edges)[0]
    weight = max(int(counts.sum()), 1) * np.diff(np.log(edges))
    return Distribution(edges, counts / weight, np.sqrt(counts) / weight)


def coordination(
    frame: Frame, *, gap: Length | None = None, force: Force | None = None, box: Box | None = None
) -> Array:
    """The number of neighbors of each particle, (N,).

    `gap`: count neighbors with a narrower gap, from the films of a frame if it contains them. `force`: count neighbors
    whose film exerts a larger repulsive force, in frames of soft spheres.
    """
    if (gap is None) == (force is None):
        raise BadInput("a neighbor is one that is closer than a gap, or presses with more than a force: give one")
    if gap is None:
        pressed = films(frame).pairs
        first, slot = np.nonzero(frame.arrays["neighbor"] >= 0)
        pairs = pressed[-frame.arrays["tension"][first, slot] > force]
    else:
        near = films(frame) if "neighbor" in frame.arrays else near_pairs(frame, gap, box)
        pairs = near.pairs[near.gap < gap]
    return np.bincount(pairs.ravel(), minlength=len(frame.arrays["position"])).astype(float)


def volume_fraction(frame: Frame, box: Box | None = None) -> float:
    """The fraction of the box that undeformed spheres (3D) or discs (2D) occupy; overlaps count twice."""
    box = box or box_of(frame)
    if box is None:
        raise BadInput("a volume fraction needs a box; these frames have no box")
    radius = frame.arrays["radius"][inside(frame)]
    flat = frame.arrays["position"].shape[1] == 2
    each = np.pi * radius**2 if flat else 4.0 / 3.0 * np.pi * radius**3
    return float(each.sum()) / box.volume


def branches(frame: Frame, pairs: Integers, box: Box | None = None) -> Array:
    """The branch vectors from each pair's first center to the nearest copy of the second's, (C, d) m."""
    position = frame.arrays["position"]
    return nearest(position[pairs[:, 1]] - position[pairs[:, 0]], box or box_of(frame))
