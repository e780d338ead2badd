"""The frames of a run onto disk, also those of a run that was interrupted.

What a killed run wrote after its last checkpoint is computed again, and compared bit for bit instead of being written
again: each crash is a test of determinism. On another processor or with other versions of the libraries the last bits
may differ; then the old frames are replaced, and the run says by how much they differ.
"""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._plain_files import append
from ecume.errors import StorageError
from ecume.run.directory import RunDirectory
from ecume.run.manifest import changed, circumstances_of_frame, record
from ecume.run.numbers import continued, scalars_line
from ecume.run.progress import note
from ecume.run.selection import Selection
from ecume.scenes.common import Kind, colors_of
from ecume.trajectories.durable_files import storing
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import Trajectory
from ecume.trajectories.recorder import LARGEST, Recorder

EVERYTHING = Selection()
"""All quantities of frames, in double precision."""


class Recording:
    """The open trajectory and the open table of numbers of a run; `frames` of them are behind us.

    `strict` refuses frames that differ from those on disk, whatever the reason. Without `repeats` frames that are
    computed again have other bits, and replace those on disk.
    """

    def __init__(
        self,
        home: RunDirectory,
        frames: int,
        *,
        kinds: Sequence[Kind] = (),
        largest: int = LARGEST,
        strict: bool = False,
        selection: Selection = EVERYTHING,
        repeats: bool = True,
    ) -> None:
        self._repeats = repeats
        self._home, self.frames, self._strict, self._selection = home, frames, strict, selection
        names = [kind.name for kind in kinds]
        self._recorder = Recorder(
            home.trajectory, species=names, colors=colors_of(kinds), largest=largest, single=selection.single
        )
        self._former = Trajectory(home.trajectory)
        try:
            self._scalars = continued(home, self._former, frames)
        except BaseException:
            self._former.close()
            self._recorder.close()
            raise

    @property
    def on_disk(self) -> int:
        """How many frames the trajectory holds: more than `frames` if a killed run had continued after its last
        checkpoint.
        """
        return self._recorder.frames

    def take(self, frame: Frame, step: int) -> None:
        """Record a frame: compare it with that on disk if it exists, write it otherwise."""
        frame = self._selection.of(frame)
        if self.frames < self._recorder.frames:
            self._compare(frame)
        if self.frames >= self._recorder.frames:
            self._recorder.write(frame, step)
        with storing(self._home.scalars):
            append(self._scalars, scalars_line(step, frame).encode())
        self.frames += 1

    def settle(self) -> None:
        """See everything on the disk, before a checkpoint counts on it."""
        with storing(self._home.scalars):
            os.fsync(self._scalars.fileno())

    def close(self) -> None:
        """Close the files."""
        self._former.close()
        self._recorder.close()
        with storing(self._home.scalars):
            self._scalars.close()

    def _compare(self, frame: Frame) -> None:
        if not self._repeats:
            note(self._home, "frames are written again", first=self.frames, why="the engine does not repeat bits")
            self._cut()
            return
        try:
            former = self._former[self.frames]
        except StorageError as error:  # damaged, so there is nothing to compare with
            note(self._home, "frames are written again", first=self.frames, why=str(error))
            self._cut()
            return
        if (found := difference(former, frame)) is not None:
            self._replace(frame, found)

    def _replace(self, frame: Frame, found: Difference) -> None:
        """Drop the frames on disk from this one on. Raises StorageError where they should have been the same."""
        changes = changed(circumstances_of_frame(self._home, self.frames))
        which = f"{self._home.path}: frame {self.frames} (t = {frame.time:g} s)"
        where = f"{which}, computed again, differs from the one on disk"
        if not changes:
            raise StorageError(
                f"{where} in {found}, although the processor and all versions are the same: a fault in memory, on the "
                "disk or in the program; run the scene again with --force"
            )
        if self._strict:
            raise StorageError(
                f"{where} in {found} ({'; '.join(changes)}): resume it where it was begun, or without --strict"
            )
        # Recorded before the frames go: a process that is killed in between leaves frames that are replaced next time.
        replacement = {"frame": self.frames, "time": frame.time, "difference": str(found), "changed": changes}
        record(self._home, replaced=replacement)
        note(self._home, "frames replaced", **replacement)
        self._cut()
        warnings.warn(f"{where} in {found} ({'; '.join(changes)}); it and later ones are replaced", stacklevel=1)

    def _cut(self) -> None:
        """Drop the frames on disk from this one on: the present session writes them."""
        self._former.close()
        self._recorder.cut(self.frames)
        record(self._home, first_frame=self.frames)


class Difference(NamedTuple):
    """The difference between two frames: the first quantity that is not the same, and the number of others."""

    quantity: str
    size: float
    """in the quantity's unit; infinite where shapes, types or finite values differ"""
    relative: float
    """over its largest value"""
    unit: str
    others: int

    def __str__(self) -> str:
        """`position by 1.1e-17 m (1.3e-16 of its largest value) and 3 more quantities`."""
        unit = f" {self.unit}" if self.unit not in ("", "1") else ""
        size = f" by {self.size:.1e}{unit} ({self.relative:.1e} of its largest value)" if self.size < math.inf else ""
        others = f" and {self.others} more {'quantities' if self.others > 1 else 'quantity'}" if self.others else ""
        return f"{self.quantity}{size}{others}"


def difference(one: Frame, other: Frame) -> Difference | None:
    """The difference between two frames; None if they are the same bit for bit."""
    if list(one.arrays) != list(other.arrays) or list(one.numbers) != list(other.numbers):
        return Difference("the names of its quantities", math.inf, math.inf, "", 0)
    pairs = [("time", np.asarray(one.time), np.asarray(other.time))]
    pairs += [(name, array, other.arrays[name]) for name, array in one.arrays.items()]
    numbers = other.numbers
    pairs += [(name, np.asarray(value, float), np.asarray(numbers[name], float)) for name, value in one.numbers.items()]
    differing = [(name, here, there) for name, here, there in pairs if not _same(here, there)]
    if not differing:
        return None
    name, here, there = differing[0]
    return Difference(name, *_distance(here, there), str(one.units.get(name, "")), len(differing) - 1)


def _same(one: NDArray[Any], other: NDArray[Any]) -> bool:
    return (one.shape, one.dtype) == (other.shape, other.dtype) and one.tobytes() == other.tobytes()


def _distance(one: NDArray[Any], other: NDArray[Any]) -> tuple[float, float]:
    """The largest difference of two arrays, and that over their largest value."""
    if (one.shape, one.dtype) != (other.shape, other.dtype) or one.dtype.kind not in "fc":
        return math.inf, math.inf
    if not np.array_equal(np.isfinite(one), np.isfinite(other)):
        return math.inf, math.inf
    with np.errstate(invalid="ignore", over="ignore"):
        apart = np.abs(np.subtract(one, other, dtype=np.result_type(one, np.float64)))
        largest, scale = float(np.nanmax(apart, initial=0.0)), float(np.nanmax(np.abs(one), initial=0.0))
    return largest, largest / scale if 0.0 < scale < math.inf else largest
