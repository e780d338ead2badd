"""Measured curves with errors: branches of rising and falling argument, and the largest difference of two curves."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume.analysis.series import Mean
from ecume.errors import BadInput
from ecume.units import Array


class Curve(NamedTuple):
    """Mean values as a function of an argument."""

    at: Array
    """(P,) the argument"""
    means: tuple[Mean, ...]
    """(P) with standard errors"""


class Difference(NamedTuple):
    """The point where two curves differ most, relative to their errors."""

    at: float
    """the argument"""
    relative: float
    """the second value over the first, minus 1; infinite where the first is zero"""
    errors: float
    """the difference in standard errors of it; infinite where neither value has an error"""


def largest_difference(first: Curve, second: Curve) -> Difference:
    """The largest difference of two curves, in standard errors, among their common arguments. Raises BadInput without
    common arguments.

    >>> one, two = (Curve(np.array([1.0]), (Mean(value, 0.3),)) for value in (2.0, 3.0))
    >>> largest_difference(one, two)._replace(errors=0.0)
    Difference(at=1.0, relative=0.5, errors=0.0)
    """
    found = []
    for at, one in zip(first.at, first.means, strict=True):
        for other in (mean for place, mean in zip(second.at, second.means, strict=True) if place == at):
            apart, error = abs(other.value - one.value), float(np.hypot(one.error, other.error))
            errors = apart / error if error > 0.0 else (np.inf if apart else 0.0)
            relative = (other.value - one.value) / one.value if one.value else math.copysign(math.inf, other.value)
            found.append(Difference(float(at), relative if apart else 0.0, float(errors)))
    if not found:
        raise BadInput("the two curves have no value of the axis in common")
    return max(found, key=lambda one: (one.errors, abs(one.relative)))


class Branch(NamedTuple):
    """A part of a sequence in which its values only rise, or only fall. The value at a turn belongs to both parts."""

    rises: bool
    first: int
    last: int
    """the index of its last value, included"""

    @property
    def places(self) -> range:
        """The range of indices of the values."""
        return range(self.first, self.last + 1)


def branches(values: Sequence[float]) -> list[Branch]:
    """The rising and falling parts of a sequence, in order; equal consecutive values do not start a new part.

    >>> [(one.rises, one.first, one.last) for one in branches([1.0, 2.0, 5.0, 2.0, 1.0])]
    [(True, 0, 2), (False, 2, 4)]
    >>> branches([3.0])
    []
    """
    found: list[Branch] = []
    rises: bool | None = None
    for place, (one, other) in enumerate(itertools.pairwise(values)):
        rises = rises if one == other else other > one
        if found and rises in (found[-1].rises, None):
            found[-1] = found[-1]._replace(last=place + 1)
        else:
            found.append(Branch(bool(rises), place, place + 1))
    return found
