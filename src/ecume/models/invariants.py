"""The invariants of a run, given by each model as rows of names, limits and measures.

A measure depends only on the numbers of frames: of the first and the present one, and on the smallest and largest
values so far. A resumed run reads these from disk, and therefore gives the same results as an uninterrupted one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

Numbers = Mapping[str, float]

ENERGY = "energy"
INJECTED = "injected_work"
"""The name of the number with the injected work (J), in models with an energy budget."""
NUMERICAL = "numerical_work"
"""The name of the part of the injected work (J) that the numerical method does, in models that compute it."""
DISSIPATED = "dissipated_work"
"""The name of the number with the dissipated energy (J), in models that compute it."""
OWN = "energy_less_work"
"""The name of the number that is checked: the total energy less the injected work."""


class NumberHistory(NamedTuple):
    """The numbers of the first and the present frame of a run, and the extremes so far, including `step`."""

    first: Numbers
    now: Numbers
    least: Numbers
    largest: Numbers


class Invariant(NamedTuple):
    """A quantity with a limit, computed from numbers of frames."""

    name: str
    says: str
    """a description of the compared quantity"""
    limit: float
    value: Callable[[NumberHistory], float]


def energy_never_rises(
    limit: float,
    floor: Callable[[NumberHistory], float] = lambda seen: 0.0,
    motion: Sequence[str] = ("kinetic_energy",),
) -> Invariant:
    """The invariant that the energy minus the injected work never rises, relative to the motion, loss and work; values
    below `floor` (J) count as zero. `motion` names the kinetic energy, if any.
    """

    def rise(seen: NumberHistory) -> float:
        worked = seen.largest.get(INJECTED, 0.0) - seen.least.get(INJECTED, 0.0)
        scale = sum(seen.largest[name] for name in motion) + seen.largest[OWN] - seen.least[OWN] + worked + floor(seen)
        return part_of(seen.now[OWN] - seen.least[OWN], scale)

    return Invariant(ENERGY, "its rise above the least so far, over the energy that moved", limit, rise)


def with_own(numbers: dict[str, float]) -> dict[str, float]:
    """The numbers with the difference of energy and injected work, if there is an energy.

    >>> with_own({"total_energy": 5.0, "injected_work": 2.0})["energy_less_work"]
    3.0
    """
    if "total_energy" not in numbers:
        return numbers
    return {**numbers, OWN: numbers["total_energy"] - numbers.get(INJECTED, 0.0)}


def kept(name: str, keys: Sequence[str], scale: Callable[[NumberHistory], float], limit: float) -> Invariant:
    """The invariant that numbers keep their initial values within a part of a scale."""

    def change(seen: NumberHistory) -> float:
        return part_of(math.hypot(*(seen.now[key] - seen.first[key] for key in keys)), scale(seen))

    return Invariant(name, "its change since the start, over its scale", limit, change)


def at_most(name: str, says: str, key: str, limit: float, over: float = 1.0) -> Invariant:
    """The invariant that a number remains below a limit."""
    return Invariant(name, says, limit, lambda seen: seen.now[key] / over)


def part_of(value: float, whole: float) -> float:
    """The ratio of a value to a total; 0 for 0/0.

    >>> part_of(1.0, 4.0), part_of(0.0, 0.0)
    (0.25, 0.0)
    """
    if whole > 0.0:
        return value / whole
    return 0.0 if value == 0.0 else math.inf


def nothing(scene: Any, parameters: Any) -> list[Invariant]:
    """No invariants."""
    return []
