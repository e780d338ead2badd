"""The recorder of frames: segments that only grow, so that a killed process leaves all that it committed."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path
from typing import Self

from ecume.trajectories import gsd_schema, segments
from ecume.trajectories.durable_files import storing
from ecume.trajectories.frame import Frame
from ecume.trajectories.segments import GrowingSegment, Segment

LARGEST = 512 * 2**20
"""Bytes after which a new segment is begun."""


def segment_files(folder: Path) -> list[Path]:
    """The segments of a trajectory, in order."""
    return sorted(path for path in folder.glob("*.gsd") if path.stem.isdecimal())


class Recorder:
    """An open trajectory that frames are added to: a folder with `0000.gsd`, `0001.gsd` and so on.

    A folder that holds frames is continued. When `write` returns, the frame is on the disk, whole.
    """

    def __init__(
        self,
        folder: Path,
        *,
        species: Sequence[str] = (),
        colors: Sequence[str] = (),
        largest: int = LARGEST,
        single: bool = False,
    ) -> None:
        """`species` are their names, in the order of their numbers, and `colors` theirs, `#rrggbb`, for viewers of the
        files. `single` is the precision of arrays.
        """
        self.folder, self._species, self._colors, self._largest = folder, tuple(species), tuple(colors), largest
        self._single = single
        with storing(folder):
            folder.mkdir(parents=True, exist_ok=True)
        self._segment: GrowingSegment | None = None
        self._attach()

    def write(self, frame: Frame, step: int) -> None:
        """Commit one frame, taken at this time step."""
        if self._segment is None or not self._appended(self._segment, frame, step):
            self._begin(frame, step)
        self.frames += 1

    def cut(self, frames: int) -> None:
        """Forget all but the first frames."""
        self.close()
        for path in reversed(segment_files(self.folder)):
            with contextlib.closing(Segment(path)) as segment:
                first, held = segment.header.first, segment.frames
            if first + held > frames:
                segments.cut(path, max(0, frames - first))
        self._attach()

    def close(self) -> None:
        """Close the file."""
        if self._segment is not None:
            self._segment.close()
        self._segment = None

    def __enter__(self) -> Self:
        """The recorder itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self.close()

    def _attach(self) -> None:
        """Go on with the last segment, cut back to its whole frames."""
        files = segment_files(self.folder)
        self._number, self.frames = int(files[-1].stem) + 1 if files else 0, 0
        if files:
            with contextlib.closing(Segment(files[-1])) as segment:
                held = segment.frames
            self._segment = GrowingSegment(files[-1], held)
            self.frames = self._segment.header.first + held

    def _appended(self, segment: GrowingSegment, frame: Frame, step: int) -> bool:
        """Whether this segment has room for the frame, and now has it."""
        header = gsd_schema.header_of(frame, segment.header.first, self._species, single=self._single)
        chunks = gsd_schema.chunks_of(frame, step, header, self._colors)
        if not segment.takes(chunks) or segment.size + sum(chunk.nbytes for chunk in chunks.values()) > self._largest:
            return False
        segment.append(chunks)
        return True

    def _begin(self, frame: Frame, step: int) -> None:
        """A new segment, that begins with this frame."""
        self.close()
        path = self.folder / f"{self._number:04d}.gsd"
        header = gsd_schema.header_of(frame, self.frames, self._species, single=self._single)
        segments.create(path, gsd_schema.chunks_of(frame, step, header, self._colors))
        self._segment = GrowingSegment(path, 1)
        self._number += 1
