"""Numbers that were sampled between frames: reading the table `samples.csv` of a run."""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import content_of
from ecume.errors import BadInput, StorageError
from ecume.trajectories.gsd import present_name
from ecume.trajectories.records import SUM, line_of, storing
from ecume.trajectories.tables import library

if TYPE_CHECKING:
    from pandas import DataFrame as PandasFrame
    from polars import DataFrame as PolarsFrame

FILE, SUMS = "samples.csv", "samples-checksums.jsonl"

LARGEST = 2**34
"""The largest size of a table in bytes."""
STATISTICS = ("", "_min", "_max", "_error")
"""The columns of a number in a table of blocks: mean, minimum, maximum, standard error of the mean."""
LEAD = ("step", "time [s]", "samples")
"""The first columns; tables without blocks lack the last of them."""


class Average(NamedTuple):
    """The mean of a number over several rows, and its standard error from the scatter of the rows."""

    mean: float
    error: float
    rows: int


def heading(names: Sequence[str], units: Mapping[str, str], *, blocks: bool) -> str:
    r"""The first line of the table.

    >>> heading(["contacts", "kinetic_energy"], {"contacts": "1", "kinetic_energy": "J"}, blocks=False)
    'step,time [s],contacts,kinetic_energy [J]\n'
    """
    ends = STATISTICS if blocks else STATISTICS[:1]
    marks = [f" [{units[name]}]" if units.get(name, "1") != "1" else "" for name in names]
    columns = [f"{name}{end}{mark}" for name, mark in zip(names, marks, strict=True) for end in ends]
    return ",".join([*(LEAD if blocks else LEAD[:2]), *columns]) + "\n"


def read_heading(line: str) -> tuple[list[str], dict[str, str], bool]:
    """The names of the numbers, their units, and whether rows are blocks. Raises ValueError for another line."""
    columns = [column.removesuffix("]").partition(" [") for column in line.rstrip("\n").split(",")]
    blocks = tuple(line.split(",")[:3]) == LEAD or line.rstrip("\n") == ",".join(LEAD)
    lead = 3 if blocks else 2
    found = columns[lead :: len(STATISTICS) if blocks else 1]
    names, units = [name for name, _, _ in found], {name: unit or "1" for name, _, unit in found}
    if heading(names, units, blocks=blocks).rstrip("\n") != line.rstrip("\n"):
        raise ValueError("not a heading of samples")
    return names, units, blocks


def sum_of(content: bytes, run: str) -> int:
    """The checksum of the beginning of a table of samples, including the identity of the run."""
    return zlib.crc32(content, zlib.crc32(run.encode()))


def rows_of(path: Path, run: str) -> bytes:
    """The complete rows of a table of samples that are visible to readers. Raises StorageError if they were changed.
    Rows of runs of earlier versions, without an identity, have no checksum.
    """
    entry = _last_sum(path.with_name(SUMS), run) if run else None
    with storing(path):
        content = content_of(path, LARGEST, path.parent)
    if not run:
        return content[: content.rfind(b"\n") + 1]
    size = entry["bytes"] if entry else 0
    done = (path.parent / "DONE.json").exists()  # otherwise rows may have been written after the last frame
    if len(content) < size or (done and len(content) > size):
        raise StorageError(f"{path}: damaged: has {len(content)} bytes; expected {size}")
    if entry and sum_of(content[:size], run) != entry["crc"]:
        raise StorageError(f"{path}: damaged: its checksum in {SUMS} does not fit its data")
    return content[:size]


def _last_sum(path: Path, run: str) -> dict[str, Any] | None:
    """The last entry of the checksums of samples, after testing all entries."""
    with storing(path):
        lines = content_of(path, LARGEST, path.parent).splitlines(keepends=True)
    if lines and not lines[-1].endswith(b"\n"):  # a run is writing at present, or was killed
        lines.pop()
    entry, before = None, 0
    for number, line in enumerate(lines, start=1):
        try:
            entry = line_of(line, SUM, checked=True, owner=f"{run} {path.name}")
            if entry["bytes"] <= before:
                raise ValueError("is out of order")
            before = entry["bytes"]
        except ValueError as error:
            raise StorageError(f"{path}: damaged: line {number}: {error}") from error
    return entry


class Samples:
    """The table of a run's samples."""

    def __init__(self, path: Path, run: str = "") -> None:
        """Read the table. Raises BadInput if the run has no samples, and StorageError if the table is damaged."""
        self.path = path
        if not path.is_file():
            raise BadInput(f"{path.parent}: the run has no samples; its scene has no table [output.samples]")
        self.content = rows_of(path, run)
        """The table as text."""
        lines = self.content.splitlines()
        try:
            names, units, self.blocks = read_heading(lines[0].decode() if lines else ",".join(LEAD[:2]))
            self.names = [present_name(name) for name in names]
            self.units = {present_name(name): unit for name, unit in units.items()}
            rows = [[float(cell) for cell in line.split(b",")] for line in lines[1:]]
            self._values = np.array(rows, dtype=np.float64).reshape(len(rows), self._width)
        except ValueError as error:
            raise StorageError(f"{path}: damaged: {error}") from error

    @property
    def _lead(self) -> int:
        return len(LEAD) if self.blocks else len(LEAD) - 1

    @property
    def _width(self) -> int:
        return self._lead + len(self.names) * (len(STATISTICS) if self.blocks else 1)

    @property
    def steps(self) -> NDArray[np.int64]:
        """The number of time steps before the last sample of each row."""
        return self._values[:, 0].astype(np.int64)

    @property
    def times(self) -> NDArray[np.float64]:
        """The mean time of the samples of each row (s)."""
        return self._values[:, 1]

    @cached_property
    def counts(self) -> NDArray[np.int64]:
        """The number of samples of each row."""
        return self._values[:, 2].astype(np.int64) if self.blocks else np.ones(len(self), np.int64)

    def mean(self, name: str) -> NDArray[np.float64]:
        """The mean of a number in each row; the sample itself without blocks."""
        return self._column(name, 0)

    def minimum(self, name: str) -> NDArray[np.float64]:
        """The smallest value in each row."""
        return self._column(name, 1 if self.blocks else 0)

    def maximum(self, name: str) -> NDArray[np.float64]:
        """The largest value in each row."""
        return self._column(name, 2 if self.blocks else 0)

    def error(self, name: str) -> NDArray[np.float64]:
        """The standard error of the mean in each row, for independent samples; NaN for a single one."""
        return self._column(name, 3) if self.blocks else np.full(len(self._column(name, 0)), np.nan)

    def average(self, name: str, start: float = 0.0, end: float = math.inf) -> Average:
        """The mean over all samples between two times (s). Its standard error follows from the scatter of the rows, and
        is therefore also correct for correlated samples if blocks are longer than the correlation time.
        """
        chosen = (self.times >= start) & (self.times <= end)
        values, weights = self.mean(name)[chosen], self.counts[chosen]
        if not len(values):
            raise BadInput(f"{self.path}: no samples between {start:g} s and {end:g} s")
        mean = float(np.average(values, weights=weights))
        scatter = float(np.average((values - mean) ** 2, weights=weights))
        return Average(mean, math.sqrt(scatter / (len(values) - 1)) if len(values) > 1 else math.nan, len(values))

    def polars(self) -> PolarsFrame:
        """The table as a DataFrame of Polars."""
        return library("polars").DataFrame(self.columns())

    def pandas(self) -> PandasFrame:
        """The table as a DataFrame of Pandas."""
        return library("pandas").DataFrame(self.columns())

    def columns(self) -> dict[str, NDArray[Any]]:
        """All columns by name: `step`, `time`, `kinetic_energy`; for blocks also `samples`, `kinetic_energy_min` ..."""
        ends = STATISTICS if self.blocks else STATISTICS[:1]
        names = [f"{name}{end}" for name in self.names for end in ends]
        lead: dict[str, NDArray[Any]] = {"step": self.steps, "time": self.times}
        lead |= {"samples": self.counts} if self.blocks else {}
        return lead | dict(zip(names, self._values[:, self._lead :].T, strict=True))

    def __len__(self) -> int:
        """The number of rows."""
        return len(self._values)

    def __repr__(self) -> str:
        """A text such as `Samples('runs/bowl', 120 rows, 0 s to 12 s: kinetic_energy, contacts)`."""
        span = f", {self.times[0]:.6g} s to {self.times[-1]:.6g} s" if len(self) else ""
        return f"Samples({str(self.path.parent)!r}, {len(self)} rows{span}: {', '.join(self.names)})"

    def _column(self, name: str, statistic: int) -> NDArray[np.float64]:
        name = present_name(name)
        if name not in self.names:
            known = ", ".join(self.names)
            raise BadInput(f"{self.path}: got the name {name!r}; expected one of {known} (output.samples.numbers)")
        width = len(STATISTICS) if self.blocks else 1
        return self._values[:, self._lead + width * self.names.index(name) + statistic]
