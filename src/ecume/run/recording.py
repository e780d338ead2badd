"""The recording of a run: each frame is written to the trajectory and to the table of numbers."""

from __future__ import annotations

import os
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ecume._plain_files import append
from ecume.errors import StorageError
from ecume.run.directory import RunDirectory, identity_of, owner_of
from ecume.run.manifest import changed, circumstances_of_frame, record
from ecume.scenes.common import Kind, colors_of
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import Trajectory
from ecume.trajectories.records import storing
from ecume.trajectories.segments import LARGEST, Recorder

if TYPE_CHECKING:
    pass
from ecume.run.comparison import Difference, difference
from ecume.run.progress import note
from ecume.run.scalars import continued, scalars_line
from ecume.run.selection import EVERYTHING, Selection


class Recording:
    """The open trajectory and the open table of numbers of a run; `frames` is the number of frames
    recorded so far.

    With `strict`, frames that differ from those on disk are always refused. Without `repeats`, frames that are computed
    again may have other bits, and replace those on disk.
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
        self._owner, run = owner_of(home, home.scalars), identity_of(home)
        self._recorder = Recorder(
            home.trajectory, species=names, colors=colors_of(kinds), largest=largest, single=selection.single, run=run
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
        """The number of frames in the trajectory, which is larger than `frames` if a killed run had continued after its
        last checkpoint.
        """
        return self._recorder.frames

    def take(self, frame: Frame, step: int) -> None:
        """Record a frame: compare it with that on disk if it exists, otherwise write it."""
        frame = self._selection.of(frame)
        if self.frames < self._recorder.frames:
            self._compare(frame)
        if self.frames >= self._recorder.frames:
            self._recorder.write(frame, step)
        with storing(self._home.scalars):
            append(self._scalars, scalars_line(step, frame, self._owner).encode())
        self.frames += 1

    def settle(self) -> None:
        """Wait until everything is on disk, before a checkpoint refers to it."""
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
        except StorageError as error:  # the frame on disk is damaged and cannot be compared
            note(self._home, "frames are written again", first=self.frames, why=str(error))
            self._cut()
            return
        if (found := difference(former, frame)) is not None:
            self._replace(frame, found)

    def _replace(self, frame: Frame, found: Difference) -> None:
        """Remove the frames on disk from this one on. Raises StorageError if they should have been equal."""
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
        # Recorded before the frames are removed: if the process is killed in between, the remaining frames are replaced
        # next time.
        replacement = {"frame": self.frames, "time": frame.time, "difference": str(found), "changed": changes}
        record(self._home, replaced=replacement)
        note(self._home, "frames replaced", **replacement)
        self._cut()
        warnings.warn(f"{where} in {found} ({'; '.join(changes)}); it and later ones are replaced", stacklevel=1)

    def _cut(self) -> None:
        """Remove the frames on disk from this one on, which the present session writes again."""
        self._former.close()
        self._recorder.cut(self.frames)
        record(self._home, first_frame=self.frames)
