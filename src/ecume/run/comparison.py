"""Two runs compared: their scenes, the programs that computed them, and their frames."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.run.directory import existing, manifest_of
from ecume.run.manifest import circumstances
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import open_trajectory
from ecume.trajectories.records import scene_at

SAME_TIME = 1e-9
"""Frames belong together whose times differ by less than this fraction of the longer run."""


class Change(NamedTuple):
    """A value that two runs do not share; None where a run does not have it."""

    name: str
    first: object
    second: object


class QuantityDifference(NamedTuple):
    """How a quantity differs between the frames of two runs."""

    name: str
    unit: str
    from_time: float
    """of the first frame in which it differs, s"""
    largest: float
    """largest difference in any frame, in the quantity's unit; infinite where shapes or finite values differ"""
    relative: float
    """the same over the quantity's largest value in the first run"""


class Comparison(NamedTuple):
    """What distinguishes two runs."""

    scene: list[Change]
    programs: list[Change]
    """versions and processor"""
    frames: tuple[int, int]
    common: int
    """how many frames have the same time in both"""
    quantities: list[QuantityDifference]

    @property
    def same(self) -> bool:
        """Whether all frames are in both runs, bit for bit."""
        return not self.quantities and self.frames == (self.common, self.common)


def compare(first: str | os.PathLike[str], second: str | os.PathLike[str]) -> Comparison:
    """Compare two runs: keys of their scenes, versions, and each quantity in all frames of the same time."""
    homes = existing(first), existing(second)
    manifests = [manifest_of(home) for home in homes]
    names = circumstances()
    programs = [{name: manifest.get(name) for name in names} for manifest in manifests]
    with open_trajectory(homes[0].path) as one, open_trajectory(homes[1].path) as other:
        pairs = _same_times(one.times, other.times)
        quantities = _differences((one[i], other[j]) for i, j in pairs)
        frames = len(one), len(other)
    return Comparison(
        scene=_changes(*(dict(_flat(scene_at(home.path, one))) for home, one in zip(homes, manifests, strict=True))),
        programs=_changes(*programs),
        frames=frames,
        common=len(pairs),
        quantities=quantities,
    )


def _flat(value: object, path: str = "") -> Iterator[tuple[str, object]]:
    """The values of nested tables by their paths: `particles[0].radius`."""
    if isinstance(value, dict):
        for key, each in value.items():
            yield from _flat(each, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list) and any(isinstance(each, dict) for each in value):
        for number, each in enumerate(value):
            yield from _flat(each, f"{path}[{number}]")
    else:
        yield path, value


def _changes(first: Mapping[str, object], second: Mapping[str, object]) -> list[Change]:
    names = dict.fromkeys((*first, *second))
    pairs = [Change(name, first.get(name), second.get(name)) for name in names]
    return [pair for pair in pairs if pair.first != pair.second]


def _same_times(first: NDArray[np.float64], second: NDArray[np.float64]) -> list[tuple[int, int]]:
    """The numbers of frames that have the same time."""
    if not len(first) or not len(second):
        return []
    limit = SAME_TIME * max(first[-1], second[-1])
    place = np.clip(np.searchsorted(first, second - limit), 0, len(first) - 1)
    return [(int(i), j) for j, i in enumerate(place) if abs(first[i] - second[j]) <= limit]


def _differences(pairs: Iterator[tuple[Frame, Frame]]) -> list[QuantityDifference]:
    """One entry for each quantity that differs in some pair of frames."""
    found: dict[str, QuantityDifference] = {}
    scales: dict[str, float] = {}
    for first, second in pairs:
        mine, theirs = _quantities(first), _quantities(second)
        for name in dict.fromkeys((*mine, *theirs)):
            one, other = mine.get(name), theirs.get(name)
            if one is not None:
                scales[name] = max(scales.get(name, 0.0), _largest(one))
            if (size := _distance(one, other)) is None:
                continue
            before = found.get(name)
            largest = max(size, before.largest if before else 0.0)
            start = before.from_time if before else first.time
            found[name] = QuantityDifference(name, str(first.units.get(name, "")), start, largest, math.nan)
    return [one._replace(relative=_over(one.largest, scales.get(name, 0.0))) for name, one in found.items()]


def _quantities(frame: Frame) -> dict[str, NDArray[Any]]:
    return {**frame.arrays, **{name: np.asarray(value, float) for name, value in frame.numbers.items()}}


def _largest(values: NDArray[Any]) -> float:
    finite = values[np.isfinite(values)] if values.dtype.kind in "fi" else np.zeros(0)
    return float(np.abs(finite).max(initial=0.0))


def _distance(one: NDArray[Any] | None, other: NDArray[Any] | None) -> float | None:
    """The largest difference of two arrays; None if they are equal, infinite if they cannot be subtracted."""
    if one is None or other is None or (one.shape, one.dtype) != (other.shape, other.dtype):
        return math.inf
    if one.tobytes() == other.tobytes():
        return None
    if not np.array_equal(np.isfinite(one), np.isfinite(other)):
        return math.inf
    with np.errstate(invalid="ignore"):
        apart = np.abs(one - other)
    return float(np.nanmax(apart, initial=0.0)) or None


def _over(size: float, scale: float) -> float:
    return size / scale if scale > 0.0 else size
