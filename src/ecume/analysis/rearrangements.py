"""T1 events: two neighbors part, and two others, that both had for neighbors, meet between them.

In 2D every particle's region borders on others, and the number of borders is fixed: neighbors change by swaps.
Where four regions nearly meet in a point the borders flicker; so a pair counts as parted only when the pair that takes
its place has a border that is not short, and as long as no border is, nothing has happened.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ecume.analysis.boxes import Box, Integers, box_of, nearest
from ecume.analysis.contacts import near_pairs
from ecume.analysis.triangulation import neighbors_of
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array

FIRM = 0.1
"""Of the mean distance of neighbors: a longer border counts. In a honeycomb all are 0.58 long, at a swap zero."""

Pair = tuple[int, int]
Around = dict[int, set[int]]


class Swap(NamedTuple):
    """A T1 event, and the four particles in it."""

    time: float
    """s: when the border of the old pair has shrunk to nothing (contacts: half-way between loss and gain)"""
    lost: Pair
    """the pair that parts"""
    gained: Pair
    """the pair that meets"""
    loss: float
    """s: when the old pair last had a firm border (contacts: when it parted)"""
    gain: float
    """s: when the new pair first has one (contacts: when it met)"""
    place: tuple[float, ...]
    """m: the middle of the new pair, then"""

    @property
    def duration(self) -> float:
        """The time from loss to gain (s); negative where the new contact closed before the old one opened."""
        return self.gain - self.loss


class Swaps(NamedTuple):
    """The T1 events of some frames, in the order of gains, and how many changes of neighbors were no such event."""

    events: tuple[Swap, ...]
    unpaired: int
    """Pairs that met or parted without another pair to go with: at open edges, or several swaps between two frames."""

    @property
    def times(self) -> Array:
        """(K,) s"""
        return np.array([event.time for event in self.events])

    @property
    def durations(self) -> Array:
        """(K,) s"""
        return np.array([event.duration for event in self.events])

    @property
    def places(self) -> Array:
        """(K, d) m"""
        return np.array([event.place for event in self.events])

    @property
    def particles(self) -> Integers:
        """(K, 4): the old pair, then the new one"""
        return np.array([(*event.lost, *event.gained) for event in self.events], np.int64).reshape(-1, 4)


class _Seen(NamedTuple):
    """The last that was seen of a pair as neighbors: when, how long its border was, and when it was last firm."""

    time: float
    border: float
    firm: float


_Found = dict[Pair, tuple[float, bool]]
"""The neighbors of a frame: their border over the usual distance, and whether it is firm."""


def neighbor_swaps(frames: Iterable[Frame], *, firm: float = FIRM, box: Box | None = None) -> Swaps:
    """The T1 events in 2D frames of any model, by the radical triangulation.

    `firm` is the border that counts, over the median distance of neighbors: fluctuations that leave all borders of a
    meeting of four below it are no events. Times of loss and gain are those of frames; the time of the event is
    interpolated. Between two frames expect at most one swap per neighborhood; `unpaired` counts the exceptions.
    """
    linked: dict[Pair, _Seen] = {}
    events: list[Swap] = []
    unpaired = 0
    for number, frame in enumerate(frames):
        found = _found(frame, firm, box)
        if number == 0:
            # Four that meet in a point have no defined neighbors: they make no event.
            linked = {pair: _Seen(frame.time, w, frame.time if sure else math.nan) for pair, (w, sure) in found.items()}
            continue
        place = _place_of(frame, box)
        swapped, lonely = _swapped(place, found, linked)
        for new, old in swapped.items():
            seen = linked.pop(old)
            if not math.isnan(seen.firm):
                events.append(_event(frame.time, (old, new), seen, found[new][0], place))
        unpaired += lonely
        _see(frame.time, found, linked)
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
    """Which old pair each new one took the place of; pairs that are gone otherwise are forgotten, and counted."""
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


def _see(time: float, found: _Found, linked: dict[Pair, _Seen]) -> None:
    for pair, (width, sure) in found.items():
        if sure or pair in linked:
            linked[pair] = _Seen(time, width, time if sure else linked[pair].firm)


def _event(now: float, pairs: tuple[Pair, Pair], seen: _Seen, border: float, place: _Place) -> Swap:
    """A swap that has just become firm."""
    part = seen.border / (seen.border + border) if math.isfinite(seen.border + border) else 0.5
    time = seen.time + part * (now - seen.time)
    return Swap(time, *pairs, seen.firm, now, tuple(place.middle(pairs[1]).tolist()))


def around_of(pairs: Iterable[Pair]) -> Around:
    """The neighbors of each."""
    around: Around = {}
    for a, b in pairs:
        around.setdefault(a, set()).add(b)
        around.setdefault(b, set()).add(a)
    return around


def matched(place: _Place, fresh: Iterable[Pair], absent: Iterable[Pair], known: Iterable[Pair]) -> dict[Pair, Pair]:
    """Which pair each new one took the place of: one whose two were both neighbors of both that meet; the nearest."""
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
    """The positions of particles."""

    position: Array
    box: Box | None

    def middle(self, pair: Pair) -> Array:
        """Half-way from one to the other's nearest copy."""
        first, second = self.position[pair[0]], self.position[pair[1]]
        return np.asarray(first + 0.5 * nearest((second - first)[None], self.box)[0])

    def between(self, one: Pair, other: Pair) -> float:
        """The distance between the middles of two pairs."""
        return float(np.linalg.norm(nearest((self.middle(other) - self.middle(one))[None], self.box)))


def _place_of(frame: Frame, box: Box | None) -> _Place:
    return _Place(frame.arrays["position"], box or box_of(frame))


class _Contacts(NamedTuple):
    """The present contacts, and the pairs that parted or met without another pair to match yet, with times."""

    linked: set[Pair]
    parted: dict[Pair, float]
    met: dict[Pair, float]


class _Gaps(NamedTuple):
    """The gaps at one instant of pairs that are not far apart."""

    time: float
    gap: dict[Pair, float]
    far: float

    def of(self, pair: Pair) -> float:
        """M; of those further away only the least it may be."""
        return self.gap.get(pair, self.far)


def contact_swaps(frames: Iterable[Frame], *, touch: float, apart: float, box: Box | None = None) -> Swaps:
    """The T1 events by contacts: from the moment in which two part to that in which the two between them meet.

    Two meet when their gap falls below `touch` and part when it rises above `apart` (m): what lies between leaves
    contacts as they are, so that they do not flicker. The gap is that of undeformed surfaces. Moments are interpolated
    between frames. For films and in 3D, where borders do not define neighbors.
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
        _part(contacts, (before, gaps), apart)
        _meet(contacts, (before, gaps), touch)
        place = _place_of(frame, box)
        for new, old in matched(place, contacts.met, contacts.parted, contacts.linked).items():
            loss, gain = contacts.parted.pop(old), contacts.met.pop(new)
            events.append(Swap(0.5 * (loss + gain), old, new, loss, gain, tuple(place.middle(new).tolist())))
        before = gaps
    return Swaps(tuple(events), len(contacts.parted) + len(contacts.met))


def _part(contacts: _Contacts, span: tuple[_Gaps, _Gaps], apart: float) -> None:
    for pair in [pair for pair in contacts.linked if span[1].of(pair) > apart]:
        contacts.linked.remove(pair)
        if contacts.met.pop(pair, None) is None:
            contacts.parted[pair] = _crossing(span, pair, apart)


def _meet(contacts: _Contacts, span: tuple[_Gaps, _Gaps], touch: float) -> None:
    for pair in [pair for pair, gap in span[1].gap.items() if gap < touch and pair not in contacts.linked]:
        contacts.linked.add(pair)
        if contacts.parted.pop(pair, None) is None:
            contacts.met[pair] = _crossing(span, pair, touch)


def _crossing(span: tuple[_Gaps, _Gaps], pair: Pair, level: float) -> float:
    """The time at which a gap passed a level."""
    start, end = (gaps.of(pair) - level for gaps in span)
    part = start / (start - end) if start != end else 1.0
    return span[0].time + min(max(part, 0.0), 1.0) * (span[1].time - span[0].time)


def _gaps(frame: Frame, reach: float, box: Box | None) -> _Gaps:
    near = near_pairs(frame, reach, box)
    rows = zip(near.pairs.tolist(), near.gap.tolist(), strict=True)
    return _Gaps(frame.time, {(i, j): gap for (i, j), gap in rows}, reach)
