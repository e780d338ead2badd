"""Numbers sampled between frames: averaged in blocks, and written to `samples.csv` of a run.

A checkpoint contains the length of the file and the block that is not complete yet. A resumed run cuts the file there
and continues the block, so the bytes are those of a run without interruption.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import opened
from ecume.models.step_counts import BEFORE
from ecume.trajectories.durable_files import storing
from ecume.trajectories.samples import heading, read_heading

if TYPE_CHECKING:
    from ecume.scenes.output import SamplesSpec
    from ecume.trajectories.frame import Frame

Kept = Mapping[str, NDArray[np.float64]]
"""The position of the sampling as a checkpoint holds it."""
NOTHING: Kept = {}


class Block:
    """The average of samples that are added one after the other (Welford's algorithm): mean, minimum, maximum and
    standard error, without storing the samples.

    >>> block = Block(1)
    >>> for time in range(4):
    ...     block.add(time, np.array([float(time)]))
    >>> block.cells()
    [1.5, 4, 1.5, 0.0, 3.0, 0.6454972243679028]
    """

    def __init__(self, width: int, kept: Kept = NOTHING) -> None:
        """An empty block, or one that a checkpoint holds."""
        self.count = int(kept["count"][0]) if kept else 0
        self.time = float(kept["block_time"][0]) if kept else 0.0
        empty = np.zeros(width)
        self.mean, self.squares = kept.get("mean", empty).copy(), kept.get("squares", empty).copy()
        self.least, self.largest = kept.get("least", empty).copy(), kept.get("largest", empty).copy()

    def add(self, time: float, values: NDArray[np.float64]) -> None:
        """Include a sample."""
        self.count += 1
        self.time += (time - self.time) / self.count
        with np.errstate(invalid="ignore", over="ignore"):
            ahead = values - self.mean
            self.mean = self.mean + ahead / self.count
            self.squares = self.squares + ahead * (values - self.mean)
        first = self.count == 1
        self.least = values if first else np.minimum(self.least, values)
        self.largest = values if first else np.maximum(self.largest, values)

    def cells(self) -> list[float]:
        """The mean time, the number of samples, and of each number the mean, minimum, maximum and standard error."""
        with np.errstate(invalid="ignore"):
            variance = self.squares / (self.count - 1) if self.count > 1 else np.full(len(self.mean), math.nan)
            error = np.sqrt(variance / self.count)
        rows = np.stack([self.mean, self.least, self.largest, error], axis=1)
        return [self.time, self.count, *rows.ravel().tolist()]

    def kept(self) -> dict[str, NDArray[np.float64]]:
        """The block as arrays."""
        numbers = {"count": float(self.count), "block_time": self.time}
        arrays = {"mean": self.mean, "squares": self.squares, "least": self.least, "largest": self.largest}
        return {name: np.array([value]) for name, value in numbers.items()} | arrays


class SampleFile:
    """The open table of samples of a run."""

    def __init__(self, path: Path, asked: SamplesSpec, kept: Kept = NOTHING) -> None:
        """Continue the table at a checkpoint, or begin it."""
        self._path, self._asked = path, asked
        self.last = int(kept["last"][0]) if kept else BEFORE
        """The position of the last sample on the model's clock."""
        self._size = int(kept["bytes"][0]) if kept else 0
        self._names: list[str] = []
        self._pending: list[str] = []
        with storing(path):
            self._file = opened(path, "a+", path.parent)
            self._file.truncate(self._size)
            if self._size:
                self._names = read_heading(self._file.readline().decode())[0]
            self._file.seek(self._size)
        self._block = Block(len(self._names), kept if self._names else NOTHING)

    def take(self, frame: Frame, step: int, last: int) -> None:
        """Include a sample; `last` is its position on the model's clock."""
        if not self._names:
            self._names = list(self._asked.numbers or frame.numbers)
            self._pending.append(heading(self._names, frame.units, blocks=self._asked.block > 1))
            self._block = Block(len(self._names))
        self.last = last
        values = np.array([frame.numbers.get(name, math.nan) for name in self._names], dtype=np.float64)
        if self._asked.block == 1:
            self._pending.append(_row(step, [frame.time, *values.tolist()]))
            return
        self._block.add(frame.time, values)
        if self._block.count == self._asked.block:
            self.end_block(step)

    def end_block(self, step: int) -> None:
        """Write the average of the samples since the last row, if there are any."""
        if self._block.count:
            self._pending.append(_row(step, self._block.cells()))
            self._block = Block(len(self._names))

    def flush(self) -> None:
        """Write complete rows."""
        left = memoryview("".join(self._pending).encode())
        self._pending = []
        with storing(self._path):
            while left:
                written = self._file.write(left)
                self._size += written
                left = left[written:]

    def settle(self) -> None:
        """Write complete rows to the disk, before a checkpoint refers to them."""
        self.flush()
        with storing(self._path):
            os.fsync(self._file.fileno())

    def kept(self) -> Kept:
        """The position of the sampling, after `settle`."""
        position = {"last": np.array([float(self.last)]), "bytes": np.array([float(self._size)])}
        return position | (self._block.kept() if self._names else {})

    def close(self) -> None:
        """Close the file; rows after the last checkpoint are computed again by a resumed run."""
        self._file.close()


def missing_rows(path: Path, kept: Kept) -> str:
    """The fault of a checkpoint whose samples are not on the disk; empty where all are there."""
    there = path.stat().st_size if path.exists() else 0
    return "samples before it are missing" if kept and kept["bytes"][0] > there else ""


def _row(step: int, cells: Iterable[float]) -> str:
    return ",".join([str(step), *map(repr, cells)]) + "\n"
