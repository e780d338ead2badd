"""One instant of a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from numpy.typing import NDArray

from ecume._hooks import html_of


class Frame(NamedTuple):
    """One instant: the time (s), named arrays, named numbers, and the unit of each. A frame owns its arrays.

    `arrays["position"]` has the shape (N, d); every other array has N as its first axis too. All are float64 or int64.
    """

    time: float
    arrays: Mapping[str, NDArray[Any]]
    numbers: Mapping[str, float]
    units: Mapping[str, str]

    def __repr__(self) -> str:
        """`Frame(time=0.5 s, 60 particles; arrays: position, velocity; numbers: clusters, kinetic_energy)`."""
        count = len(next(iter(self.arrays.values()), ()))
        arrays, numbers = _few(list(self.arrays)), _few(list(self.numbers))
        return f"Frame(time={self.time:.6g} s, {count} particles; arrays: {arrays}; numbers: {numbers})"

    def _repr_html_(self) -> str | None:
        """The notebook view: the particles, to turn and to click."""
        return html_of(self)


SHOWN = 5
"""Names in a `repr`."""


def _few(names: list[str]) -> str:
    """The first names, and how many more there are."""
    more = [f"{len(names) - SHOWN} more"] if len(names) > SHOWN else []
    return ", ".join([*names[:SHOWN], *more])
