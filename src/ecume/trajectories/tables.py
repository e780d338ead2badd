"""Frames as tables of other libraries: a column per component of an array."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ecume.errors import BadInput, install
from ecume.trajectories.frame import Frame

Columns = dict[str, NDArray[Any]]
AXES = "xyz"


def library(name: str) -> Any:
    """A library that ecume itself does not need. Raises BadInput where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise BadInput(f"{name} is not installed: {install('tables')}") from error


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
