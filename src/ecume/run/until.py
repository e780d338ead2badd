"""Conditions that end a run before its duration: a number that crosses a bound, or one that has become stationary."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ecume.engine.stationarity import is_stationary, is_tested
from ecume.errors import BadInput, nearest
from ecume.run.directory import RunDirectory
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import Trajectory
from ecume.trajectories.records import clean

UNTIL = "until"
"""The entry of a manifest with the condition of a run."""
EXPECTED = (
    "'stationary shear_stress', 'stationary shear_stress within 2 %', 'top > 0.3' or 'largest_speed < 1e-6', "
    "in SI units"
)
NUMBER = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
"""The pattern of a number without a sign."""
CROSSING = re.compile(rf"(\w+)\s*([<>])\s*([+-]?{NUMBER})")
STATIONARY = re.compile(rf"stationary\s+(\w+)(?:\s+within\s+({NUMBER})\s*%)?")
LONGEST = 200
"""The largest length of a condition in characters."""


class Condition(NamedTuple):
    """A condition on a number of frames."""

    text: str
    number: str
    below: bool
    """whether the number must fall below the bound instead of exceeding it"""
    bound: float
    """of the number; of a stationary one, that of the standard error of its mean over this mean, or infinite"""
    stationary: bool

    def met(self, values: list[float]) -> bool:
        """Whether the values of all frames so far meet it. A number crosses a bound from one frame to the next: floats
        that start at rest have not come to rest. A series is stationary as `engine.stationarity` defines it: after its
        transient, and not while it still has its first value. It is tested at `FEWEST` frames, and then whenever their
        number has grown by a tenth.

        >>> read_condition("top > 2").met([1.0, 3.0]), read_condition("top < 2").met([1.0])
        (True, False)
        """
        if not self.stationary:
            beyond = [value < self.bound if self.below else value > self.bound for value in values[-2:]]
            return beyond == [False, True]
        return is_tested(len(values)) and is_stationary(np.array(values), self.bound)


def read_condition(text: str) -> Condition:
    """The condition of a text. Raises BadInput for other texts.

    >>> read_condition("stationary shear_stress within 2 %")[1:]
    ('shear_stress', False, 0.02, True)
    """
    words = text.strip()
    if len(words) > LONGEST:
        raise BadInput(f"until: got {len(words)} characters; expected a condition such as {EXPECTED}")
    if match := STATIONARY.fullmatch(words):
        return Condition(words, match[1], False, float(match[2]) / 100.0 if match[2] else math.inf, True)
    if match := CROSSING.fullmatch(words):
        return Condition(words, match[1], match[2] == "<", float(match[3]), False)
    raise BadInput(f"until: got {clean(words)!r}; expected a condition such as {EXPECTED}")


class Awaited:
    """A condition with the values of its number in the frames so far."""

    def __init__(self, condition: Condition, values: Iterable[float] = ()) -> None:
        self.condition, self._values = condition, list(values)

    def take(self, frame: Frame) -> bool:
        """Add a frame; return whether the condition is now met."""
        self._values.append(frame.numbers[self.condition.number])
        return self.condition.met(self._values)


def require_awaited(text: str, frame: Frame) -> None:
    """Raise BadInput for a condition that cannot be read, or on a number that recorded frames do not have."""
    if not text:
        return
    name = read_condition(text).number
    if name not in frame.numbers:
        raise BadInput(f"until: got {name!r}, which is no number of the frames; {nearest(name, list(frame.numbers))}")


def awaited(text: str, home: RunDirectory, frames: int) -> Awaited | None:
    """The condition of a run, after reading the numbers of its first `frames` frames; None without a condition."""
    if not text:
        return None
    condition = read_condition(text)
    if not frames:
        return Awaited(condition)
    with Trajectory(home.trajectory) as former:
        return Awaited(condition, (former[place].numbers[condition.number] for place in range(frames)))
