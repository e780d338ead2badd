"""Numbers sampled between frames: averaged in blocks, and written to `samples.csv`.  A checkpoint contains the length
of the file and the incomplete block. A resumed run truncates the file to this length and continues the block, so
that the bytes are those of a run without interruption.
"""

from __future__ import annotations

import contextlib
import math
import os
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import append, opened, read_at
from ecume.models.step_counts import BEFORE
from ecume.run.directory import RunDirectory, identity_of
from ecume.trajectories.frame import Frame
from ecume.trajectories.gsd import present_name
from ecume.trajectories.records import SUM, line_of, sealed_line, storing
from ecume.trajectories.samples import SUMS, heading, read_heading, sum_of

if TYPE_CHECKING:
    from ecume.scenes.common import SamplesSpec
from ecume.run.scalars import LONGEST

Kept = Mapping[str, NDArray[np.float64]]
"""The position of the sampling as a checkpoint holds it."""
NOTHING: Kept = {}


class Block:
    """The running average of samples (Welford's algorithm): mean, minimum, maximum and standard error, without storing
    the samples.

    >>> block = Block(1)
    >>> for time in range(4):
    ...     block.add(time, np.array([float(time)]))
    >>> block.cells()
    [1.5, 4, 1.5, 0.0, 3.0, 0.6454972243679028]
    """

    def __init__(self, width: int, kept: Kept = NOTHING) -> None:
        """An empty block, or the block of a checkpoint."""
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
        """The mean time and the number of samples, followed by mean, minimum, maximum and standard error of each
        number.
        """
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

    def __init__(self, path: Path, asked: SamplesSpec, kept: Kept = NOTHING, run: str = "") -> None:
        """Continue the table from a checkpoint, or start it; `run` is the identity of the run."""
        self._path, self._asked = path, asked
        self._crc = int(kept["crc"][0]) if "crc" in kept else sum_of(b"", run)
        self.last = int(kept["last"][0]) if kept else BEFORE
        """The position of the last sample on the model's clock."""
        self._size = int(kept["bytes"][0]) if kept else 0
        self._names: list[str] = []
        self._pending: list[str] = []
        self._sums = SumFile(path.with_name(SUMS), self._size, run) if run else None  # created before the samples
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
        values = np.array([frame.numbers.get(present_name(name), math.nan) for name in self._names], dtype=np.float64)
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
                self._crc = zlib.crc32(left[:written], self._crc)
                left = left[written:]

    def show(self) -> None:
        """Write complete rows and their checksum, after which readers can see them."""
        self.flush()
        if self._sums is not None:
            self._sums.add(self._size, self._crc)

    def settle(self) -> None:
        """Write complete rows to the disk, before a checkpoint refers to them."""
        self.flush()
        with storing(self._path):
            os.fsync(self._file.fileno())
        if self._sums is not None:
            self._sums.settle()

    def kept(self) -> Kept:
        """The position of the sampling, after `settle`."""
        position = {"last": np.array([float(self.last)]), "bytes": np.array([float(self._size)])}
        if self._sums is not None:
            position["crc"] = np.array([float(self._crc)])
        return position | (self._block.kept() if self._names else {})

    def close(self) -> None:
        """Close the files; a resumed run computes rows after the last checkpoint again."""
        self._file.close()
        if self._sums is not None:
            self._sums.close()


class SumFile:
    """The open file with the checksums of a table of samples: a line after each frame that has new rows."""

    def __init__(self, path: Path, size: int, run: str) -> None:
        """Continue the file for a table of this size."""
        self._path, self._owner, self._last = path, f"{run} {path.name}", 0
        with storing(path):
            self._file = opened(path, "a+", path.parent)
            content, place = read_at(self._file, 0, os.fstat(self._file.fileno()).st_size), 0
            with contextlib.suppress(ValueError):  # lines after a damaged one are written again
                for line in content.splitlines(keepends=True):
                    entry = line_of(line, SUM, checked=True, owner=self._owner)
                    if entry["bytes"] > size:
                        break
                    self._last, place = entry["bytes"], place + len(line)
            self._file.truncate(place)
            self._file.seek(place)

    def add(self, size: int, crc: int) -> None:
        """Add the checksum of this number of bytes."""
        if size > self._last:
            with storing(self._path):
                append(self._file, sealed_line({"bytes": size, "crc": crc}, self._owner).encode())
            self._last = size

    def settle(self) -> None:
        """Write all lines to the disk."""
        with storing(self._path):
            os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file."""
        self._file.close()


SINGLE, BLOCK = ("last", "bytes", "crc", "count"), ("mean", "squares", "least", "largest")
"""The integers of the position of a sampling, and the numbers of an incomplete average."""
LARGEST_COUNT = 2.0**53


def misfit(kept: Kept) -> str:
    """The reason why arrays are not a valid position of a sampling; empty if they are."""
    names = {*SINGLE[:3], "count", "block_time", *BLOCK} if "count" in kept else set(SINGLE[:3])
    if kept.keys() | {"crc"} != names:
        return "its samples have other parts than a run writes"
    counts = [kept[name] for name in SINGLE if name in kept]
    if any(one.shape != (1,) or not BEFORE <= one[0] <= LARGEST_COUNT or one[0] % 1 for one in counts):
        return "the counts of its samples are not whole numbers"
    if "count" in kept and (kept["block_time"].shape != (1,) or kept["count"][0] < 0.0):
        return "its average of samples has no count or time"
    if len({kept[name].shape for name in BLOCK if name in kept} | {(0,)}) > 2 or any(
        kept[one].ndim != 1 for one in BLOCK if one in kept
    ):
        return "its average of samples has several sizes"
    return ""


def missing_rows(home: RunDirectory, kept: Kept) -> str:
    """The fault of a checkpoint whose samples are missing on disk or damaged; empty otherwise."""
    if not kept:
        return ""
    if fault := misfit(kept):
        return fault
    size = int(kept["bytes"][0])
    if size > (home.samples.stat().st_size if home.samples.exists() else 0):
        return "samples before it are missing"
    if "crc" not in kept or not size:
        return ""
    with storing(home.samples), opened(home.samples, "r", home.path) as file:
        crc, left = sum_of(b"", identity_of(home)), size
        while left > 0 and (part := file.read(min(left, LONGEST))):
            crc, left = zlib.crc32(part, crc), left - len(part)
        if crc != int(kept["crc"][0]):
            return "samples before it are damaged"
        file.seek(0)
        try:
            width = len(read_heading(file.readline().decode())[0])
        except ValueError as error:
            return f"samples before it are damaged: {error}"
    return "" if kept.get("mean", np.zeros(width)).shape == (width,) else "its average of samples has another size"


def _row(step: int, cells: Iterable[float]) -> str:
    return ",".join([str(step), *map(repr, cells)]) + "\n"
