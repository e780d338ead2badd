"""Whether a series of numbers has become stationary."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume.units import Array

FEWEST = 50
"""The number of values from which a series is tested."""
PART = 10
"""A series is tested again once its number of values has grown by one part in so many. Each test may accept a series
that is not stationary.
"""
SURE = 3.0
"""The largest difference of the means of two halves, in standard errors."""

BLOCKS = 8
"""The number of blocks behind a standard error."""


def standard_error(values: Array, blocks: int = BLOCKS) -> float:
    """The standard error of the mean of a stationary series, from the means of blocks: neighboring values are
    correlated, but blocks longer than the correlation time are independent. NaN with fewer values than two blocks need.

    >>> standard_error(np.array([1.0, 3.0] * 8), blocks=4), standard_error(np.ones(1))
    (0.0, nan)
    """
    parts = [part.mean() for part in np.array_split(values, min(blocks, max(len(values) // 2, 1)))]
    return float(np.std(parts, ddof=1) / np.sqrt(len(parts))) if len(parts) > 1 else math.nan


class SteadyPart(NamedTuple):
    """The stationary part of a series."""

    first: int
    """the index at which it begins"""
    settled: bool
    """whether the transient ends within the first third, and both halves of the steady part have the same mean within
    three standard errors
    """


def steady_part_of(values: Array) -> SteadyPart:
    """Detect the transient of an evenly spaced series: twice the cut in its first third that leaves the mean of the
    rest with the smallest standard error, sum (y - mean)^2 / n^2 [white1997]. At that cut the remaining transient
    changes the mean by about its error; at twice the cut it has decayed.

    >>> steady_part_of(np.array([9.0, 5.0, 1.0, 3.0, 1.0, 3.0, 1.0, 3.0, 1.0, 3.0, 1.0, 3.0])).first
    4
    """
    count = len(values)
    left = count - np.arange(count // 3 + 1)
    shifted = values - values.mean()
    total, square = (np.cumsum(part[::-1])[::-1][: len(left)] for part in (shifted, shifted**2))
    cut = int(np.argmin((square - total**2 / left) / left**2))
    rest = values[2 * cut :]
    early, late = rest[: len(rest) // 2], rest[len(rest) // 2 :]
    if not len(early):
        return SteadyPart(2 * cut, False)
    apart, spread = abs(late.mean() - early.mean()), math.hypot(standard_error(early), standard_error(late))
    alike = apart <= SURE * spread + 1e-12 * abs(early.mean())
    return SteadyPart(2 * cut, bool(cut < len(left) - 1 and alike))


def is_stationary(values: Array, bound: float = math.inf) -> bool:
    """Whether a series is stationary: its transient is its first third at most, both halves of the rest agree within
    three standard errors, and the standard error of their mean over this mean is at most `bound`. A series that
    still has its first value is not: it has not begun to change.

    >>> steady = 2.0 + np.array([0.1, -0.1] * 30)
    >>> is_stationary(steady), is_stationary(steady, 0.05), is_stationary(np.zeros(60)), is_stationary(np.arange(60.0))
    (True, True, False, False)
    """
    if len(values) < FEWEST or not np.isfinite(values).all() or values.min() == values.max():
        return False
    found = steady_part_of(values)
    rest, short = values[found.first :], 3 * found.first <= len(values)
    return found.settled and short and standard_error(rest) <= bound * abs(float(rest.mean()))


def is_tested(count: int) -> bool:
    """Whether a series of so many values is tested.

    >>> [count for count in range(80) if is_tested(count)]
    [50, 55, 61, 68, 75]
    """
    at = FEWEST
    while at < count:
        at += math.ceil(at / PART)
    return at == count
