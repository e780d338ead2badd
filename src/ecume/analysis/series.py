"""Series: from the frames of a run to one number per instant."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.analysis.boxes import box_of, nearest
from ecume.engine.stationarity import BLOCKS, standard_error
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame, omitted_from
from ecume.units import Array

Flags = NDArray[np.bool_]


def times(frames: Iterable[Frame]) -> Array:
    """The instants (s)."""
    return np.array([frame.time for frame in frames], dtype=float)


def series(frames: Iterable[Frame], *measures: Callable[[Frame], float]) -> Array:
    """One row of values per measure and one column per frame. The frames are read only once.

    >>> frames = [Frame(0.5 * n, {}, {"kinetic_energy": float(n)}, {}) for n in range(3)]
    >>> series(frames, number("kinetic_energy"))
    array([[0., 1., 2.]])
    """
    rows = [[measure(frame) for measure in measures] for frame in frames]
    return np.array(rows, dtype=float).reshape(len(rows), len(measures)).T


def number(name: str) -> Callable[[Frame], float]:
    """A measure that returns the number with this name in a frame."""

    def measure(frame: Frame) -> float:
        if name not in frame.numbers:
            raise BadInput(f"the frames have no number {name!r}; they have {', '.join(sorted(frame.numbers))}")
        return frame.numbers[name]

    return measure


FAR = 0.4
"""The fraction of a periodic side above which the displacement between two frames is ambiguous."""


class PathWarning(UserWarning):
    """Paths across periodic borders may be wrong."""


def inside(frame: Frame) -> Flags:
    """Flags (N,) of the particles that are inside; those that left through an opening remain in the
    arrays of frames.
    """
    if "left" in (*frame.arrays, *omitted_from(frame)) and "position" in frame.arrays:
        return np.asarray(frame.arrays["left"] < 0)
    return np.ones(len(frame.arrays["position"]), bool)


def tracks(frames: Sequence[Frame] | Iterable[Frame], kept: Sequence[int] | None = None) -> Array:
    """The positions of particles over time, of shape (frames, particles, d), in m; NaN before a particle enters and
    after it leaves. `kept` contains the indices of the frames to return, in ascending order; by default all.

    In a periodic box paths do not jump at borders: frames contain image numbers. In frames of former versions, which
    have none, each path continues at the image nearest to the previous position; a PathWarning reports that particles
    may move by half a side between frames.
    """
    frames = frames if isinstance(frames, Sequence) else list(frames)
    kept = range(len(frames)) if kept is None else kept
    if not len(frames):
        return np.zeros((0, 0, 0))
    named = box_of(frames[0]) is None or "image" in frames[0].arrays
    if named:
        seen = [(unwrapped(frame), inside(frame)) for frame in (frames[k] for k in kept)]
        places, there = [place for place, _ in seen], [present for _, present in seen]
    else:
        places, there = _followed(frames, set(kept)), [inside(frames[k]) for k in kept]
    found = np.full((len(there), max(map(len, places)), places[0].shape[1]), np.nan)
    for row, position, present, k in zip(found, places, there, kept, strict=True):
        if len(position) != len(row) and "left" not in frames[k].arrays:
            counts = f"got {len(position)} particles at {frames[k].time:g} s and {len(row)} at another time"
            raise BadInput(f"{counts}; expected frames that say which particle is which")
        row[: len(position)][present] = position[present]
    return found


def unwrapped(frame: Frame) -> Array:
    """The unwrapped positions (m) of particles in periodic boxes."""
    position, box = frame.arrays["position"], box_of(frame)
    if box is None or "image" not in frame.arrays:
        return position
    return np.asarray(position + frame.arrays["image"] @ box.tilt.T)


def _followed(frames: Sequence[Frame], kept: set[int]) -> list[Array]:
    """The unwrapped positions in the frames that are kept, followed from frame to frame by nearest images."""
    found: list[Array] = []
    last, reached, when = frames[0].arrays["position"], 0.0, 0.0
    for number, frame in enumerate(frames):
        box, position = box_of(frame), frame.arrays["position"]
        if box is not None and number:
            moved = nearest(position - last, box)
            far = float(np.max(np.abs(moved) / np.where(box.sides > 0.0, box.sides, np.inf), initial=0.0))
            last = last + moved
            reached, when = max((reached, when), (far, frame.time))
        if number in kept:
            found.append(last)
    warn_of_far_moves(reached, when)
    return found


def warn_of_far_moves(reached: float, when: float) -> None:
    """Warn if paths without image numbers may be wrong; `reached` is the largest displacement between frames, over the
    side.
    """
    if reached > FAR:
        message = f"a particle moves by {reached:.2g} of a side of the periodic box up to {when:.4g} s; paths without "
        message += "image numbers are right up to half a side from frame to frame: write frames more often"
        warnings.warn(message, PathWarning, stacklevel=3)


class Mean(NamedTuple):
    """A mean and its standard error."""

    value: float
    error: float


def steady_mean(values: Array, blocks: int = BLOCKS) -> Mean:
    """The mean of a stationary series, with its standard error from the means of blocks.

    >>> steady_mean(np.array([1.0, 3.0] * 8), blocks=4)
    Mean(value=2.0, error=0.0)
    >>> steady_mean(np.array([]))
    Mean(value=nan, error=nan)
    """
    if not len(values):
        return Mean(math.nan, math.nan)
    return Mean(float(np.mean(values)), standard_error(values, blocks))
