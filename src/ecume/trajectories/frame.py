"""One instant of a run, and trajectories as tables.

Trajectories as tables: a column per number, or per component of an array.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._hooks import html_of
from ecume.errors import BadInput, install

if TYPE_CHECKING:
    from ecume.trajectories.reader import Trajectory


class RecordedArrays(dict[str, NDArray[Any]]):
    """The arrays of a frame that was recorded without some of them; reading one of these raises BadInput."""

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

    def with_arrays(self, arrays: Mapping[str, NDArray[Any]]) -> Frame:
        """The frame with these arrays; an array that was not recorded is still reported as such."""
        omitted = omitted_from(self)
        return self._replace(arrays=RecordedArrays(arrays, omitted) if omitted else arrays)

    def _repr_html_(self) -> str | None:
        """The notebook view: the particles, to turn and to click."""
        return html_of(self)


SHOWN = 5
"""Names in a `repr`."""


def _few(names: list[str]) -> str:
    """The first names, and how many more there are."""
    more = [f"{len(names) - SHOWN} more"] if len(names) > SHOWN else []
    return ", ".join([*names[:SHOWN], *more])


Columns = dict[str, NDArray[Any]]
AXES = "xyz"


def library(name: str) -> Any:
    """A library that ecume itself does not need. Raises BadInput where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise BadInput(f"{name} is not installed: {install('tables')}") from error


def of_numbers(trajectory: Trajectory) -> Columns:
    """The number of each frame, its time and its numbers; NaN where a frame lacks a number."""
    names = dict.fromkeys(name for frame in trajectory[:1] for name in frame.numbers)
    names |= dict.fromkeys(name for frame in trajectory[-1:] for name in frame.numbers)
    return {
        "frame": np.arange(len(trajectory)),
        "time": trajectory.times,
        **{name: trajectory.numbers(name) for name in names},
    }


def of_particles(frames: Sequence[Frame]) -> Columns:
    """A row per particle and frame, a column per component of each array that all frames have."""
    counts = [len(next(iter(frame.arrays.values()), ())) for frame in frames]
    shared = [name for name in (frames[0].arrays if frames else ()) if all(name in frame.arrays for frame in frames)]
    columns: Columns = {
        "frame": np.repeat(np.arange(len(counts)), counts),
        "time": np.repeat([frame.time for frame in frames], counts),
        "particle": np.concatenate([np.arange(count) for count in counts] or [np.zeros(0, int)]),
    }
    for name in shared:
        values = np.concatenate([frame.arrays[name] for frame in frames])
        columns |= dict(_components(name, values.reshape(len(values), -1), scalar=values.ndim == 1))
    return columns


def _components(name: str, values: NDArray[Any], *, scalar: bool) -> list[tuple[str, NDArray[Any]]]:
    if scalar:
        return [(name, values[:, 0])]
    width = values.shape[1]
    ends = AXES[:width] if width <= len(AXES) else map(str, range(width))
    return [(f"{name}_{end}", column) for end, column in zip(ends, values.T, strict=True)]
