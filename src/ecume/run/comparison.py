"""The difference between two frames, bit for bit."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.trajectories.frame import Frame

if TYPE_CHECKING:
    pass


class Difference(NamedTuple):
    """The difference between two frames: the first quantity that differs, and the number of other such quantities."""

    quantity: str
    size: float
    """in the quantity's unit; infinite where shapes, types or finite values differ"""
    relative: float
    """over its largest value"""
    unit: str
    others: int

    def __str__(self) -> str:
        """The text `position by 1.1e-17 m (1.3e-16 of its largest value) and 3 more quantities`."""
        unit = f" {self.unit}" if self.unit not in ("", "1") else ""
        size = f" by {self.size:.1e}{unit} ({self.relative:.1e} of its largest value)" if self.size < math.inf else ""
        others = f" and {self.others} more {'quantities' if self.others > 1 else 'quantity'}" if self.others else ""
        return f"{self.quantity}{size}{others}"


def difference(one: Frame, other: Frame) -> Difference | None:
    """The difference between two frames; None if they are the same bit for bit."""
    if list(one.arrays) != list(other.arrays) or list(one.numbers) != list(other.numbers):
        return Difference("the names of its quantities", math.inf, math.inf, "", 0)
    pairs = [("time", np.asarray(one.time), np.asarray(other.time))]
    pairs += [(name, array, other.arrays[name]) for name, array in one.arrays.items()]
    numbers = other.numbers
    pairs += [(name, np.asarray(value, float), np.asarray(numbers[name], float)) for name, value in one.numbers.items()]
    differing = [(name, here, there) for name, here, there in pairs if not _same(here, there)]
    if not differing:
        return None
    name, here, there = differing[0]
    return Difference(name, *_distance(here, there), str(one.units.get(name, "")), len(differing) - 1)


def _same(one: NDArray[Any], other: NDArray[Any]) -> bool:
    return (one.shape, one.dtype) == (other.shape, other.dtype) and one.tobytes() == other.tobytes()


def _distance(one: NDArray[Any], other: NDArray[Any]) -> tuple[float, float]:
    """The largest difference of two arrays, and its ratio to their largest value."""
    if (one.shape, one.dtype) != (other.shape, other.dtype) or one.dtype.kind not in "fc":
        return math.inf, math.inf
    if not np.array_equal(np.isfinite(one), np.isfinite(other)):
        return math.inf, math.inf
    with np.errstate(invalid="ignore", over="ignore"):
        apart = np.abs(np.subtract(one, other, dtype=np.result_type(one, np.float64)))
        largest, scale = float(np.nanmax(apart, initial=0.0)), float(np.nanmax(np.abs(one), initial=0.0))
    return largest, largest / scale if 0.0 < scale < math.inf else largest
