"""Series: from the frames of a run to one number per instant."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

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
    """Where each float was: shape (frames, floats, 2), in m."""
    return np.stack([frame.arrays["position"] for frame in frames])
