"""The table of numbers of a run, `scalars.csv`: one line per frame."""

from __future__ import annotations

import io
import math
import os
from collections.abc import Iterator, Mapping
from io import FileIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ecume._plain_files import opened
from ecume.errors import StorageError
from ecume.run.directory import RunDirectory, has_checksums, owner_of
from ecume.trajectories.frame import Frame
from ecume.trajectories.gsd import present_name
from ecume.trajectories.reader import Trajectory
from ecume.trajectories.records import LINE, line_of, sealed_line, storing, write_whole

if TYPE_CHECKING:
    pass

LONGEST = 2**20
"""The largest number of bytes of a line."""


def scalars_line(step: int, frame: Frame, owner: str = "") -> str:
    """The line of a frame; numbers that are not finite are null."""
    return sealed_line({"step": step, "time": frame.time, **_finite(frame.numbers)}, owner)


def _finite(numbers: Mapping[str, float]) -> dict[str, float | None]:
    return {name: float(value) if math.isfinite(value) else None for name, value in numbers.items()}


def lines_of(home: RunDirectory) -> Iterator[dict[str, Any]]:
    """The numbers of the frames by their present names. Raises StorageError at the first line that is damaged."""
    if not home.scalars.exists():
        return
    checked, owner = has_checksums(home), owner_of(home, home.scalars)
    for number, content in enumerate(split(home, home.scalars), start=1):
        try:
            line = line_of(content, LINE, checked=checked, owner=owner)
        except ValueError as error:
            raise StorageError(f"{home.scalars}: damaged: line {number}: {error}") from error
        yield {present_name(name): value for name, value in line.items()}


def split(home: RunDirectory, path: Path) -> Iterator[bytes]:
    """The lines of a file of a run with their line breaks."""
    with storing(path), io.BufferedReader(opened(path, "r", home.path)) as file:
        while line := file.readline(LONGEST):
            yield line


def good_lines(home: RunDirectory, most: int) -> tuple[int, int]:
    """The number of undamaged lines at the beginning, at most `most`, and their size in bytes."""
    count = size = 0
    owner = owner_of(home, home.scalars)
    try:
        for content in split(home, home.scalars):
            if count == most:
                break
            line_of(content, LINE, checked=True, owner=owner)
            count, size = count + 1, size + len(content)
    except (StorageError, ValueError):
        pass
    return count, size


def continued(home: RunDirectory, former: Trajectory, frames: int) -> FileIO:
    """The table, open for appending, with one line for each of this number of frames. If lines are missing or damaged,
    all are written again from the trajectory.
    """
    with storing(home.scalars):
        count, size = good_lines(home, frames)
        if count == frames:
            file = opened(home.scalars, "a", home.path)
            os.ftruncate(file.fileno(), size)
            return file
    steps, owner = former.steps, owner_of(home, home.scalars)
    lines = (scalars_line(int(steps[number]), former[number], owner) for number in range(frames))
    write_whole(home.scalars, "".join(lines), home.path)
    with storing(home.scalars):
        return opened(home.scalars, "a", home.path)
