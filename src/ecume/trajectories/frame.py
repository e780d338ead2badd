"""The record of one instant of a run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from numpy.typing import NDArray

from ecume._hooks import html_of
from ecume.errors import BadInput


class RecordedArrays(dict[str, NDArray[Any]]):
    """The arrays of a frame that was recorded without some arrays; access to an omitted array raises BadInput."""

    def __init__(self, arrays: Mapping[str, NDArray[Any]], omitted: Iterable[str]) -> None:
        super().__init__(arrays)
        self.omitted = tuple(omitted)

    def __missing__(self, name: str) -> NDArray[Any]:
        """Raise BadInput for an omitted array, and KeyError for one that never existed."""
        if name in self.omitted:
            raise BadInput(
                f"the frames contain no {name}, which is needed here: the scene omits it from output.quantities; "
                f'add "{name}" there and run the scene again'
            )
        raise KeyError(name)


def omitted_from(frame: Frame) -> tuple[str, ...]:
    """The names of the arrays that were not recorded."""
    return frame.arrays.omitted if isinstance(frame.arrays, RecordedArrays) else ()


class Frame(NamedTuple):
    """One instant: the time (s), named arrays, named numbers, and the unit of each. A frame owns
    its arrays.

    `arrays["position"]` has the shape (N, d); every other array has N as its first axis too. All are float64 or int64.
    """

    time: float
    arrays: Mapping[str, NDArray[Any]]
    numbers: Mapping[str, float]
    units: Mapping[str, str]

    def __repr__(self) -> str:
        """A text such as `Frame(time=0.5 s, 60 particles; arrays: position, velocity; numbers: clusters,
        kinetic_energy)`.
        """
        count = len(next(iter(self.arrays.values()), ()))
        arrays, numbers = _few(list(self.arrays)), _few(list(self.numbers))
        return f"Frame(time={self.time:.6g} s, {count} particles; arrays: {arrays}; numbers: {numbers})"

    def with_arrays(self, arrays: Mapping[str, NDArray[Any]]) -> Frame:
        """The frame with these arrays; an array that was not recorded is still reported as such."""
        omitted = omitted_from(self)
        return self._replace(arrays=RecordedArrays(arrays, omitted) if omitted else arrays)

    def _repr_html_(self) -> str | None:
        """The notebook view: the particles, which can be rotated and clicked."""
        return html_of(self)


SHOWN = 5
"""The number of names in a `repr`."""


def _few(names: list[str]) -> str:
    """The first names, and the number of the remaining ones."""
    more = [f"{len(names) - SHOWN} more"] if len(names) > SHOWN else []
    return ", ".join([*names[:SHOWN], *more])
