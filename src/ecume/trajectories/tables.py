"""Frames as tables of other libraries, with a column per component of an array, and rows as CSV."""

from __future__ import annotations

import csv
import importlib
import math
import re
from collections.abc import Iterable, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ecume.errors import BadInput, install
from ecume.trajectories.frame import Frame

Columns = dict[str, NDArray[Any]]
AXES = "xyz"
FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""Spreadsheets evaluate cells that begin with these."""
QUANTITY = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?( [\w/^*.°%]+)?|[+-]?(inf|nan)")
"""Text that begins with a sign and is no formula."""


class Written(Protocol):
    """A text file that is open for writing."""

    def write(self, text: str, /) -> object:
        """Write text."""


def write_rows(file: Written, rows: Iterable[Iterable[object]]) -> None:
    """Write rows as CSV, with text that spreadsheets do not evaluate."""
    csv.writer(file, lineterminator="\n").writerows([cell(value) for value in row] for row in rows)


def write_cells(file: Written, rows: Iterable[Iterable[float]]) -> None:
    """Write rows of numbers as CSV."""
    csv.writer(file, lineterminator="\n").writerows(rows)


def cell(value: object) -> object:
    """A value for a CSV file; an apostrophe precedes text that a spreadsheet would evaluate.

    >>> [cell(value) for value in ("=1+1", "-1.5e-3 mm", "-a", -2.0)]
    ["'=1+1", '-1.5e-3 mm', "'-a", -2.0]
    """
    evaluated = isinstance(value, str) and value.startswith(FORMULA) and not QUANTITY.fullmatch(value)
    return f"'{value}" if evaluated else value


def library(name: str) -> Any:
    """The module of an optional library. Raises BadInput if it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise BadInput(f"{name} is not installed: {install('tables')}") from error


def of_particles(frames: Sequence[Frame]) -> Columns:
    """A table with a row per particle and frame, and a column per component of each array that all frames have."""
    counts = [len(next(iter(frame.arrays.values()), ())) for frame in frames]
    shared = [name for name in (frames[0].arrays if frames else ()) if all(name in frame.arrays for frame in frames)]
    columns: Columns = {
        "frame": np.repeat(np.arange(len(counts)), counts),
        "time": np.repeat([frame.time for frame in frames], counts),
        "particle": np.concatenate([np.arange(count) for count in counts] or [np.zeros(0, int)]),
    }
    for name in shared:
        values = np.concatenate([frame.arrays[name] for frame in frames])
        rows = values.reshape(len(values), math.prod(values.shape[1:]))
        columns |= dict(_components(name, rows, scalar=values.ndim == 1))
    return columns


def _components(name: str, values: NDArray[Any], *, scalar: bool) -> list[tuple[str, NDArray[Any]]]:
    if scalar:
        return [(name, values[:, 0])]
    width = values.shape[1]
    ends = AXES[:width] if width <= len(AXES) else map(str, range(width))
    return [(f"{name}_{end}", column) for end, column in zip(ends, values.T, strict=True)]
