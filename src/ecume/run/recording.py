"""The frames of a run onto disk, also those of a run that was interrupted.

What a killed run wrote after its last checkpoint is computed again, and compared bit for bit instead of being written
again: each crash is a test of determinism.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence

from ecume.errors import StorageError
from ecume.run.directory import RunDirectory, json_of
from ecume.run.manifest import changed
from ecume.run.progress import note
from ecume.scenes.common import Kind, colors_of
from ecume.trajectories.durable import storing, write_whole
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import Trajectory
from ecume.trajectories.recorders import LARGEST, Recorder


class Recording:
    """The open trajectory and the open table of numbers of a run; `frames` of them are behind us."""

    def __init__(self, home: RunDirectory, frames: int, *, kinds: Sequence[Kind] = (), largest: int = LARGEST) -> None:
        self._home, self.frames = home, frames
        names = [kind.name for kind in kinds]
        self._recorder = Recorder(home.trajectory, species=names, colors=colors_of(kinds), largest=largest)
        self._former = Trajectory(home.trajectory)
        with storing(home.scalars):
            _cut_scalars(home, self._former, frames)
            self._scalars = home.scalars.open("a", newline="\n")

    def take(self, frame: Frame, step: int) -> None:
        """Record a frame: compare it with that on disk where there is one, write it where there is none."""
        if self.frames < self._recorder.frames:
            self._compare(frame)
        if self.frames >= self._recorder.frames:
            self._recorder.write(frame, step)
        with storing(self._home.scalars):
            self._scalars.write(scalars_line(step, frame))
            self._scalars.flush()
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
        try:
            former = self._former[self.frames]
        except StorageError as error:  # damaged, so worth no comparison
            note(self._home, "frames are written anew", first=self.frames, why=str(error))
            self._former.close()
            self._recorder.cut(self.frames)
            return
        if differing := difference(former, frame):
            now = "; ".join(changed(json_of(self._home.manifest))) or "the same programs on the same kind of processor"
            raise StorageError(
                f"{self._home.path}: frame {self.frames} (t = {frame.time:g} s) came out otherwise than before, in "
                f"{differing} ({now}): go on with what it was begun with, or run the scene again with --force"
            )


def difference(one: Frame, other: Frame) -> str:
    """The first thing in which two frames are not the same bit for bit, or nothing."""
    if float(one.time).hex() != float(other.time).hex():
        return "time"
    if list(one.arrays) != list(other.arrays) or list(one.numbers) != list(other.numbers):
        return "the names of its quantities"
    for name, array in one.arrays.items():
        twin = other.arrays[name]
        if (array.shape, array.dtype, array.tobytes()) != (twin.shape, twin.dtype, twin.tobytes()):
            return name
    numbers = ((name, float(value), float(other.numbers[name])) for name, value in one.numbers.items())
    return next((name for name, here, there in numbers if here.hex() != there.hex()), "")


def scalars_line(step: int, frame: Frame) -> str:
    """One line of `scalars.jsonl`; what is no finite number is null."""
    return json.dumps({"step": step, "time": frame.time, **_finite(frame.numbers)}) + "\n"


def _finite(numbers: Mapping[str, float]) -> dict[str, float | None]:
    return {name: float(value) if math.isfinite(value) else None for name, value in numbers.items()}


def _cut_scalars(home: RunDirectory, former: Trajectory, frames: int) -> None:
    """Leave a line for each of so many frames; where lines are missing, all are taken from the trajectory."""
    whole = home.scalars.read_bytes() if home.scalars.exists() else b""
    lines = whole.splitlines(keepends=True)[:frames]
    if len(lines) == frames and all(line.startswith(b"{") and line.endswith(b"}\n") for line in lines):
        if home.scalars.exists():
            os.truncate(home.scalars, sum(map(len, lines)))
        return
    steps = former.steps
    write_whole(home.scalars, "".join(scalars_line(int(steps[number]), former[number]) for number in range(frames)))
