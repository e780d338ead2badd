"""Rearrangements of packings: neighbors by triangulation, T1 events, and non-affine motion.

In 2D, neighbors follow from the radical triangulation, which is Delaunay's for equal radii. A point belongs to the disc
with the shortest tangent from this point; two discs are neighbors if their regions share a border. Discs that touch
without overlapping are always neighbors for any ratio of radii, which does not hold in the Delaunay triangulation of
their centers. [gellatly1982].

T1 events: two neighbors separate, and two others, which were neighbors of both, meet between them. In 2D the number of
borders is fixed, so that neighbors change by such swaps. If four regions nearly meet in a point, the borders fluctuate;
therefore a pair counts as separated only when the pair that replaces it has a border that is not short.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError, cKDTree

from ecume.analysis.boxes import Box, Integers, box_of, copies, nearest
from ecume.analysis.close_pairs import near_pairs
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array, Length

MARGIN = 5.0
"""The width of the layer of copies around a box, in mean spacings; with more, results do not change."""
TOP = (0.0, 0.0, 10.0)
"""A point above all others, so that the hull has a volume even if all points are on one circle."""


class Neighbors(NamedTuple):
    """The pairs of neighbors at one instant, in order."""

    pairs: Integers
    """(E, 2), i < j"""
    border: Array
    """(E,) m: the length of the common border of two regions; infinite at an open edge"""


def neighbors_of(frame: Frame, box: Box | None = None) -> Neighbors:
    """The neighbors in a 2D frame of any model; without radii all particles count as equal.

    The box is that of the frame, if it has one. Two particles that are neighbors in several copies count once, with
    their longest border: the box should be more than four spacings wide.
    """
    position = frame.arrays["position"]
    if position.shape[1] != 2:
        raise BadInput(f"neighbors are found in 2D; these frames have {position.shape[1]} dimensions")
    radius = np.asarray(frame.arrays.get("radius", np.zeros(len(position))), dtype=float)
    return radical_neighbors(position, radius, box or box_of(frame))


def radical_neighbors(position: Array, radius: Array, box: Box | None = None) -> Neighbors:
    """The pairs of neighbors among discs, which are the edges of the lower hull of (x, y, x^2 + y^2 - r^2)."""
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
    """The mean distance between particles; along an open axis, the extent of all particles is used."""
    sides = np.where(box.sides > 0.0, box.sides, np.ptp(position, axis=0)) if len(position) else box.sides
    return float(np.sqrt(np.prod(sides) / max(len(position), 1)))


def _edges(place: Array, radius: Array) -> tuple[Integers, Array]:
    """The edges of the triangulation, each twice, and the lengths of the borders across them."""
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
    """Each pair once, with its longest border; pairs of a particle with its own copy are omitted."""
    apart = pairs[:, 0] != pairs[:, 1]
    pairs, border = pairs[apart], border[apart]
    order = np.lexsort((-border, pairs[:, 1], pairs[:, 0]))
    pairs, border = pairs[order], border[order]
    first = np.ones(len(pairs), bool)
    first[1:] = (pairs[1:] != pairs[:-1]).any(axis=1)
    return Neighbors(pairs[first], border[first])


FIRM = 0.1
"""The length of a border, over the mean distance of neighbors, above which it counts. In a honeycomb all borders have
the length 0.58, at a swap one has the length zero.
"""

Pair = tuple[int, int]
Around = dict[int, set[int]]


class Swap(NamedTuple):
    """A T1 event with its four particles."""

    time: float
    """s: when the border of the old pair has length zero (contacts: the mean of loss and gain)"""
    lost: Pair
    """the pair that separates"""
    gained: Pair
    """the pair that becomes neighbors"""
    loss: float
    """s: when the old pair had a firm border for the last time (contacts: when it separated)"""
    gain: float
    """s: when the new pair has a firm border for the first time (contacts: when it touched)"""
    place: tuple[float, ...]
    """m: the middle of the new pair at that time"""

    @property
    def duration(self) -> float:
        """The time from loss to gain (s); negative where the new contact closed before the old one opened."""
        return self.gain - self.loss


class Swaps(NamedTuple):
    """The T1 events of some frames in the order of gains, and the number of other changes of neighbors."""

    events: tuple[Swap, ...]
    unpaired: int
    """The number of pairs gained or lost without a matching pair: at open edges, or with several swaps between two
    frames.
    """

    @property
    def times(self) -> Array:
        """The times of the events, (K,) s."""
        return np.array([event.time for event in self.events])

    @property
    def durations(self) -> Array:
        """The durations of the events, (K,) s."""
        return np.array([event.duration for event in self.events])

    @property
    def places(self) -> Array:
        """The positions of the events, (K, d) m."""
        return np.array([event.place for event in self.events])

    @property
    def particles(self) -> Integers:
        """The four particles of each event, (K, 4): the old pair, then the new one."""
        return np.array([(*event.lost, *event.gained) for event in self.events], np.int64).reshape(-1, 4)


class _Seen(NamedTuple):
    """The last state of a pair as neighbors: the time, the length of the border, and the last time at which it was
    firm.
    """

    time: float
    border: float
    firm: float


_Found = dict[Pair, tuple[float, bool]]
"""The neighbors of a frame: their border over the usual distance, and whether it is firm."""


def neighbor_swaps(frames: Iterable[Frame], *, firm: float = FIRM, box: Box | None = None) -> Swaps:
    """The T1 events in 2D frames of any model, by the radical triangulation.

    `firm` is the smallest border that counts, over the median distance of neighbors: fluctuations of four particles
    whose borders all remain below it are not events. Times of loss and gain are those of frames; the time of the event
    is interpolated. The method assumes at most one swap per neighborhood between two frames; `unpaired` counts the
    exceptions.
    """
    linked: dict[Pair, _Seen] = {}
    events: list[Swap] = []
    unpaired = 0
    for number, frame in enumerate(frames):
        found = _found(frame, firm, box)
        if number == 0:
            # Four cells that meet in a point have no defined neighbors, and do not cause an event.
            linked = {pair: _Seen(frame.time, w, frame.time if sure else math.nan) for pair, (w, sure) in found.items()}
            continue
        place = _place_of(frame, box)
        swapped, lonely = _swapped(place, found, linked)
        for new, old in swapped.items():
            seen = linked.pop(old)
            if not math.isnan(seen.firm):
                events.append(_event(frame.time, (old, new), seen, found[new][0], place))
        unpaired += lonely
        _update_linked(frame.time, found, linked)
    return Swaps(tuple(events), unpaired)


def _found(frame: Frame, firm: float, box: Box | None) -> _Found:
    seen = neighbors_of(frame, box)
    i, j = seen.pairs.T
    position = frame.arrays["position"]
    distance = np.linalg.norm(nearest(position[j] - position[i], box or box_of(frame)), axis=1)
    border = seen.border / np.median(distance)
    rows = zip(seen.pairs.tolist(), border.tolist(), strict=True)
    return {(a, b): (width, width > firm) for (a, b), width in rows}


def _swapped(place: _Place, found: _Found, linked: dict[Pair, _Seen]) -> tuple[dict[Pair, Pair], int]:
    """The old pair that each new pair replaces; other lost pairs are removed, and counted."""
    fresh = {pair for pair, (_, sure) in found.items() if sure and pair not in linked}
    absent = {pair for pair in linked if pair not in found}
    if not fresh and not absent:
        return {}, 0
    swapped = matched(place, fresh, absent, {*found, *linked})
    around = around_of(found)
    gone = [old for old in absent - set(swapped.values()) if not _flickers(old, around, found, linked)]
    for old in gone:
        del linked[old]
    return swapped, len(fresh) - len(swapped) + len(gone)


def _flickers(pair: Pair, around: Around, found: _Found, linked: dict[Pair, _Seen]) -> bool:
    """Whether a pair is separated only by a short border of two others that are both neighbors of it."""
    beside = sorted(around.get(pair[0], set()) & around.get(pair[1], set()))
    others = itertools.combinations(beside, 2)
    return any(other in found and not found[other][1] and other not in linked for other in others)


def _update_linked(time: float, found: _Found, linked: dict[Pair, _Seen]) -> None:
    for pair, (width, sure) in found.items():
        if sure or pair in linked:
            linked[pair] = _Seen(time, width, time if sure else linked[pair].firm)


def _event(now: float, pairs: tuple[Pair, Pair], seen: _Seen, border: float, place: _Place) -> Swap:
    """A swap that has just become firm."""
    part = seen.border / (seen.border + border) if math.isfinite(seen.border + border) else 0.5
    time = seen.time + part * (now - seen.time)
    return Swap(time, *pairs, seen.firm, now, tuple(place.middle(pairs[1]).tolist()))


def around_of(pairs: Iterable[Pair]) -> Around:
    """The set of neighbors of each particle."""
    around: Around = {}
    for a, b in pairs:
        around.setdefault(a, set()).add(b)
        around.setdefault(b, set()).add(a)
    return around


def matched(place: _Place, fresh: Iterable[Pair], absent: Iterable[Pair], known: Iterable[Pair]) -> dict[Pair, Pair]:
    """The old pair that each new pair replaces: both particles of the old pair were neighbors of both particles of the
    new pair; if there are several such pairs, the nearest.
    """
    around, left = around_of(known), set(absent)
    candidates = []
    for new in fresh:
        between = around.get(new[0], set()) & around.get(new[1], set())
        found = [old for old in itertools.combinations(sorted(between), 2) if old in left]
        candidates += [(place.between(new, old), new, old) for old in found]
    chosen: dict[Pair, Pair] = {}
    for _, new, old in sorted(candidates):
        if new not in chosen and old in left:
            chosen[new] = old
            left.remove(old)
    return chosen


class _Place(NamedTuple):
    """The positions of particles at one instant."""

    position: Array
    box: Box | None

    def middle(self, pair: Pair) -> Array:
        """The middle between a particle and the nearest copy of another."""
        first, second = self.position[pair[0]], self.position[pair[1]]
        return np.asarray(first + 0.5 * nearest((second - first)[None], self.box)[0])

    def between(self, one: Pair, other: Pair) -> float:
        """The distance between the middles of two pairs."""
        return float(np.linalg.norm(nearest((self.middle(other) - self.middle(one))[None], self.box)))


def _place_of(frame: Frame, box: Box | None) -> _Place:
    return _Place(frame.arrays["position"], box or box_of(frame))


class _Contacts(NamedTuple):
    """The present contacts, and the gained and lost pairs that are not matched yet, with times."""

    linked: set[Pair]
    parted: dict[Pair, float]
    met: dict[Pair, float]


class _Gaps(NamedTuple):
    """The gaps at one instant of pairs that are not far apart."""

    time: float
    gap: dict[Pair, float]
    far: float

    def of(self, pair: Pair) -> float:
        """The gap (m); for distant pairs only a lower bound."""
        return self.gap.get(pair, self.far)


def contact_swaps(frames: Iterable[Frame], *, touch: float, apart: float, box: Box | None = None) -> Swaps:
    """The T1 events by contacts: from the separation of one pair to the contact of the two particles between them.

    Two particles come into contact when their gap decreases below `touch`, and separate when it increases above `apart`
    (m). Between these values contacts do not change, so that they do not fluctuate. The gap is that of undeformed
    surfaces. Moments are interpolated between frames. For films and in 3D, where borders do not define neighbors.
    """
    if not touch <= apart:
        raise BadInput(f"two meet below a gap of {touch:g} m and part above {apart:g} m; expected touch <= apart")
    contacts = _Contacts(set(), {}, {})
    events: list[Swap] = []
    before: _Gaps | None = None
    for frame in frames:
        gaps = _gaps(frame, 2.0 * abs(apart) + abs(touch), box)
        if before is None:
            contacts.linked.update(pair for pair, gap in gaps.gap.items() if gap < touch)
            before = gaps
        _remove_contacts(contacts, (before, gaps), apart)
        _add_contacts(contacts, (before, gaps), touch)
        place = _place_of(frame, box)
        for new, old in matched(place, contacts.met, contacts.parted, contacts.linked).items():
            loss, gain = contacts.parted.pop(old), contacts.met.pop(new)
            events.append(Swap(0.5 * (loss + gain), old, new, loss, gain, tuple(place.middle(new).tolist())))
        before = gaps
    return Swaps(tuple(events), len(contacts.parted) + len(contacts.met))


def _remove_contacts(contacts: _Contacts, span: tuple[_Gaps, _Gaps], apart: float) -> None:
    for pair in [pair for pair in contacts.linked if span[1].of(pair) > apart]:
        contacts.linked.remove(pair)
        if contacts.met.pop(pair, None) is None:
            contacts.parted[pair] = _crossing(span, pair, apart)


def _add_contacts(contacts: _Contacts, span: tuple[_Gaps, _Gaps], touch: float) -> None:
    for pair in [pair for pair, gap in span[1].gap.items() if gap < touch and pair not in contacts.linked]:
        contacts.linked.add(pair)
        if contacts.parted.pop(pair, None) is None:
            contacts.met[pair] = _crossing(span, pair, touch)


def _crossing(span: tuple[_Gaps, _Gaps], pair: Pair, level: float) -> float:
    """The time at which a gap crosses a level."""
    start, end = (gaps.of(pair) - level for gaps in span)
    part = start / (start - end) if start != end else 1.0
    return span[0].time + min(max(part, 0.0), 1.0) * (span[1].time - span[0].time)


def _gaps(frame: Frame, reach: float, box: Box | None) -> _Gaps:
    near = near_pairs(frame, reach, box)
    rows = zip(near.pairs.tolist(), near.gap.tolist(), strict=True)
    return _Gaps(frame.time, {(i, j): gap for (i, j), gap in rows}, reach)


class LocalDeformation(NamedTuple):
    """The deformation of the neighborhood of each particle between two frames."""

    gradient: Array
    """(N, d, d): the uniform deformation F that best maps old vectors to neighbors onto new ones; d x_k / d X_m"""
    rest: Array
    """(N,) m^2: the mean square residual over neighbors; D^2_min"""
    neighbors: Integers
    """(N,) the number of neighbors; below d the fit is undefined, and both others are NaN"""


def local_deformation(
    before: Frame, after: Frame, reach: Length, boxes: tuple[Box, Box] | None = None
) -> LocalDeformation:
    """The best affine deformation and its residual D^2_min, for neighbors within `reach` of the center of each
    particle.

    D^2_min is divided by the number of neighbors, unlike in [falk1998]. Vectors to neighbors are the shortest, before
    and after: the reach should be well below half a box, and particles must be the same ones in both frames.
    """
    start, end = _boxes(before, after, boxes)
    position = before.arrays["position"]
    around = copies(position, start, reach)
    near = cKDTree(around.position).query_pairs(reach, output_type="ndarray")
    near = np.concatenate([near, near[:, ::-1]])
    near = near[near[:, 0] < len(position)]
    first, second = near[:, 0], around.owner[near[:, 1]]
    old = around.position[near[:, 1]] - around.position[first]
    then = after.arrays["position"]
    new = nearest(then[second] - then[first], end)
    return _fitted(len(position), first, old, new)


def _fitted(count: int, first: Integers, old: Array, new: Array) -> LocalDeformation:
    """The least-squares fits of all particles at once."""
    dimensions = old.shape[1]
    onto, square = np.zeros((2, count, dimensions, dimensions))
    np.add.at(onto, first, new[:, :, None] * old[:, None, :])
    np.add.at(square, first, old[:, :, None] * old[:, None, :])
    number = np.bincount(first, minlength=count)
    spread = np.linalg.eigvalsh(square)
    solvable = spread[:, 0] > 1e-9 * spread[:, -1]
    gradient = np.full((count, dimensions, dimensions), np.nan)
    gradient[solvable] = onto[solvable] @ np.linalg.inv(square[solvable])
    left = new - np.einsum("nkm,nm->nk", gradient[first], old)
    rest = np.bincount(first, (left**2).sum(axis=1), minlength=count)
    return LocalDeformation(gradient, np.where(solvable, rest / np.maximum(number, 1), np.nan), number)


def nonaffine_displacement(before: Frame, after: Frame, boxes: tuple[Box, Box] | None = None) -> Array:
    """The displacement of each particle relative to the deformation of the box, (N, d) m, with a mean of zero.

    The box must be periodic, and may be sheared or compressed; no particle may have moved by more than half of the box
    relative to its deformation.
    """
    start, end = _boxes(before, after, boxes)
    if start is None or end is None or not (start.closed and end.closed):
        raise BadInput("an even deformation is that of a periodic box; these frames have none: see local_deformation")
    position = before.arrays["position"]
    even = position @ (end.tilt @ np.linalg.inv(start.tilt)).T
    moved = nearest(after.arrays["position"] - even, end)
    # The mean depends on the choice of copies; it is therefore computed again relative to the median.
    moved = nearest(moved - np.median(moved, axis=0), end)
    return np.asarray(moved - moved.mean(axis=0))


def nonaffine_velocity(before: Frame, after: Frame, boxes: tuple[Box, Box] | None = None) -> Array:
    """The non-affine displacement over the time between the two frames, (N, d) m/s."""
    if not after.time > before.time:
        raise BadInput(f"a velocity takes time: the frames are at {before.time:g} s and {after.time:g} s")
    return nonaffine_displacement(before, after, boxes) / (after.time - before.time)


def _boxes(before: Frame, after: Frame, boxes: tuple[Box, Box] | None) -> tuple[Box | None, Box | None]:
    if before.arrays["position"].shape != after.arrays["position"].shape:
        raise BadInput("the frames contain different particles; expected the same ones in both")
    return boxes or (box_of(before), box_of(after))
