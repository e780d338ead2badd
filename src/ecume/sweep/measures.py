"""Measures of a run: `final kinetic_energy`, `max top`, `first top > 0.3`; `MEASURES` is the table of kinds."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ecume.analysis.rheology import steady_state
from ecume.errors import BadInput
from ecume.run.until import NUMBER
from ecume.scenes.faults import echo
from ecume.units import Array

Measure = Callable[[Any], float]
"""A function from a trajectory to a number."""


def final(times: Array, values: Array) -> float:
    """The last value."""
    return float(values[-1])


def mean(times: Array, values: Array) -> float:
    """The time average: the integral of linear interpolation between frames, over the duration."""
    span = times[-1] - times[0]
    return float(np.trapezoid(values, times) / span) if span > 0.0 else float(values[-1])


def least(times: Array, values: Array) -> float:
    """The smallest value of all frames."""
    return float(np.nanmin(values))


def largest(times: Array, values: Array) -> float:
    """The largest value of all frames."""
    return float(np.nanmax(values))


def spread(times: Array, values: Array) -> float:
    """The standard deviation over all frames."""
    return float(np.std(values))


def steady(times: Array, values: Array) -> float:
    """The mean of the frames after the transient, which is detected automatically; NaN if the number does not become
    stationary.

    >>> now = np.arange(12.0)
    >>> steady(now, np.array([9.0, 5.0, 1.0, 3.0, 1.0, 3.0, 1.0, 3.0, 1.0, 3.0, 1.0, 3.0])), steady(now, now)
    (2.0, nan)
    """
    found = steady_state(values)
    return found.mean.value if found.settled else math.nan


MEASURES: dict[str, Callable[[Array, Array], float]] = {
    "final": final,
    "mean": mean,
    "min": least,
    "max": largest,
    "std": spread,
    "steady": steady,
}
"""Functions from times and values to a number, by name."""
FIRST = re.compile(rf"first\s+(\w+)\s*([<>])\s*([+-]?{NUMBER})")
USUAL = re.compile(r"(\w+)\s+(\w+)")


class Words(NamedTuple):
    """A measure as parsed: its kind, and the measured number."""

    way: str
    number: str
    above: bool = True
    bound: float = math.nan


def first_crossing(times: Array, values: Array, above: bool, bound: float) -> float:
    """The first time at which the values cross a bound (s), by linear interpolation between frames; infinite if they
    never do.

    >>> first_crossing(np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 3.0]), True, 2.0)
    1.5
    """
    beyond = values > bound if above else values < bound
    if not beyond.any():
        return math.inf
    place = int(np.argmax(beyond))
    if place == 0:
        return float(times[0])
    part = (bound - values[place - 1]) / (values[place] - values[place - 1])
    return float(times[place - 1] + part * (times[place] - times[place - 1]))


def read_measure(text: str) -> Words:
    """The measure of a text. Raises ValueError for other texts.

    >>> read_measure("first top > 0.3")
    Words(way='first', number='top', above=True, bound=0.3)
    """
    if match := FIRST.fullmatch(text.strip()):
        return Words("first", match[1], match[2] == ">", float(match[3]))
    match = USUAL.fullmatch(text.strip())
    if match is None or match[1] not in MEASURES:
        raise ValueError(
            f"expected {', '.join(MEASURES)} of a number, as in 'final kinetic_energy', or 'first top > 0.3'"
        )
    return Words(match[1], match[2])


def measure_of(text: str) -> Measure:
    """The measure that a text describes. Raises BadInput for other texts."""
    try:
        asked = read_measure(text)
    except ValueError as fault:
        raise BadInput(f"measures: got {echo(text)}; {fault}") from None
    if asked.way == "first":
        return lambda run: first_crossing(run.times, run.numbers(asked.number), asked.above, asked.bound)
    return lambda run: MEASURES[asked.way](run.times, run.numbers(asked.number))


def usual_measures(names: Sequence[str]) -> list[str]:
    """The default measures: the last value of every number."""
    return [f"final {name}" for name in names]
