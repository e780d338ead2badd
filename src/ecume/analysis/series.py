"""Series: from the frames of a run to one number per instant."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from ecume.analysis.boxes import box_of, nearest
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array


def times(frames: Iterable[Frame]) -> Array:
    """The instants (s)."""
    return np.array([frame.time for frame in frames], dtype=float)


def series(frames: Iterable[Frame], *measures: Callable[[Frame], float]) -> Array:
    """One row of values per measure, one column per frame. The frames are read once, however many the measures.

    >>> frames = [Frame(0.5 * n, {}, {"kinetic_energy": float(n)}, {}) for n in range(3)]
    >>> series(frames, number("kinetic_energy"))
    array([[0., 1., 2.]])
    """
    rows = [[measure(frame) for measure in measures] for frame in frames]
    return np.array(rows, dtype=float).reshape(len(rows), len(measures)).T


def number(name: str) -> Callable[[Frame], float]:
    """The measure that reads a frame's own number of that name."""

    def measure(frame: Frame) -> float:
        if name not in frame.numbers:
            raise BadInput(f"the frames have no number {name!r}; they have {', '.join(sorted(frame.numbers))}")
        return frame.numbers[name]

    return measure


def tracks(frames: Iterable[Frame]) -> Array:
    """The positions of floats over time: shape (frames, floats, 2), in m.

    In a periodic box each path continues at the image nearest to the previous position, so that paths do not
    jump at borders. Frames must be so close in time that no float moves by half a side between them.
    """
    found: list[Array] = []
    for frame in frames:
        position, box = frame.arrays["position"], box_of(frame)
        if found and box is not None:
            position = found[-1] + nearest(position - found[-1], box)
        found.append(position)
    return np.stack(found)


class Mean(NamedTuple):
    """A mean and its standard error."""

    value: float
    error: float


BLOCKS = 8


def steady_mean(values: Array, blocks: int = BLOCKS) -> Mean:
    """The mean of a steady series; its error is that of block means, since neighboring values are alike.

    Blocks that are longer than the series' memory are independent of one another. Fewer values than two blocks hold
    have no error: not a number.

    >>> steady_mean(np.array([1.0, 3.0] * 8), blocks=4)
    Mean(value=2.0, error=0.0)
    """
    parts = [part.mean() for part in np.array_split(values, min(blocks, max(len(values) // 2, 1)))]
    error = np.std(parts, ddof=1) / np.sqrt(len(parts)) if len(parts) > 1 else np.nan
    return Mean(float(np.mean(values)), float(error))
