"""Trajectories as sequences of frames, read from files.

`ExportedFrames` are the frames in the form of exports, with the arrays that follow from the recorded ones.
"""

from __future__ import annotations

import bisect
import contextlib
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, overload

import numpy as np
from numpy.typing import NDArray

from ecume._hooks import derived_arrays, html_of, scene_of
from ecume._plain_files import require_plain
from ecume.errors import BadInput, StorageError
from ecume.trajectories import gsd
from ecume.trajectories.frame import Frame
from ecume.trajectories.records import manifest_at, scene_at, storing
from ecume.trajectories.segments import Segment, require_own, segment_files
from ecume.trajectories.tables import library, of_particles

if TYPE_CHECKING:
    from pandas import DataFrame as PandasFrame
    from polars import DataFrame as PolarsFrame
from ecume.trajectories.samples import FILE, Samples

OF_A_RUN = ("manifest.json", "resolved.json")
"""The files beside the folder of frames of a run."""


def open_trajectory(path: str | os.PathLike[str]) -> Trajectory:
    """The frames of a run: a sequence, read from disk one by one on access, exact to the bit.

        with ecume.open_trajectory("runs/bowl") as trajectory:
            trajectory[-1].arrays["position"]

    `path` is the run's directory, or the folder `traj` in it. A run that is being written can be read; `refresh` adds
    newer frames.
    """
    given = Path(path)
    # A run that has just started has its scene, but no folder of frames yet.
    begun = (given / "traj").is_dir() or (given / "resolved.json").is_file()
    folder = given / "traj" if begun else given
    if not segment_files(folder) and folder == given:
        raise BadInput(f"{given}: contains no run; expected a directory from `ecume run`")
    return Trajectory(folder)


class Trajectory(Sequence[Frame]):
    """A sequence of frames, with their scene."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.directory = folder.parent if folder.name == "traj" else folder
        of_a_run = any((self.directory / name).exists() for name in OF_A_RUN)
        if (whole := self.directory if of_a_run else folder).is_dir():
            with storing(whole):
                require_plain(whole)
        self._segments: list[Segment] = []
        self._run = self._identity()
        self.refresh()

    def refresh(self) -> int:
        """Look for new frames of a running run; return the number of frames."""
        if self._segments:
            self._segments[-1].refresh()
        for path in segment_files(self.folder)[len(self._segments) :]:
            self._segments.append(Segment(path))
            if self._run is not None:
                require_own(self._segments[-1], self._run)
        return len(self)

    def _identity(self) -> str | None:
        """The identity of the run; None if its manifest is missing or damaged, in which case frames are read without
        this check.
        """
        try:
            return str(self.manifest.get("run", "")) if self.manifest else None
        except StorageError:
            return None

    @property
    def scene(self) -> Any:
        """The scene of the run, with all defaults filled in."""
        return scene_of(scene_at(self.directory, self.manifest))

    @property
    def manifest(self) -> dict[str, Any]:
        """The programs, the machine and the sessions of the run; empty if its manifest is missing."""
        return manifest_at(self.directory) if (self.directory / "manifest.json").exists() else {}

    @property
    def intact(self) -> int:
        """The number of frames before the first missing one; frames are missing if a segment lost its end."""
        end = 0
        for segment in self._segments:
            if segment.header.first != end:
                break
            end += segment.frames
        return end

    @property
    def times(self) -> NDArray[np.float64]:
        """The time of each frame (s)."""
        return self._column("log/time")

    @property
    def steps(self) -> NDArray[np.int64]:
        """The number of time steps before each frame."""
        return self._column("configuration/step").astype(np.int64)

    @property
    def units(self) -> dict[str, str]:
        """The unit of each array and number."""
        return gsd.units_of(self._segments[-1].header) if self._segments else {}

    @property
    def species(self) -> tuple[str, ...]:
        """The names of the species in the order of their numbers; empty without names."""
        return self._segments[-1].header.species if self._segments else ()

    def numbers(self, name: str) -> NDArray[np.float64]:
        """The values of a named number (`kinetic_energy`) in all frames."""
        known = {gsd.present_name(known) for segment in self._segments for known in segment.header.numbers}
        if (name := gsd.present_name(name)) not in known:
            raise BadInput(f"{self.directory}: no number {name}; expected one of {', '.join(sorted(known))}")
        return self._column(f"log/{name}")

    @property
    def samples(self) -> Samples:
        """The numbers sampled between frames that are on disk at present. Raises BadInput for a run without samples."""
        return Samples(self.directory / FILE, self._run or "")

    def __len__(self) -> int:
        """The number of frames."""
        return self._segments[-1].header.first + self._segments[-1].frames if self._segments else 0

    @overload
    def __getitem__(self, index: int) -> Frame: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[Frame]: ...

    def __getitem__(self, index: int | slice) -> Frame | Sequence[Frame]:
        """A frame, counted from the end if negative; or a slice of frames, which are read on access."""
        if isinstance(index, slice):
            return _Some(self, range(len(self))[index])
        if not -len(self) <= index < len(self):
            raise IndexError(f"{self.directory}: no frame {index}; the run has {len(self)} frames")
        segment, local = self._located(index % len(self))
        return segment.frame(local)

    def close(self) -> None:
        """Close the files."""
        for segment in self._segments:
            segment.close()
        self._segments = []

    def polars(self, *, particles: bool = False) -> PolarsFrame:
        """The numbers of all frames as a DataFrame of Polars, with a row per frame; with `particles`, the arrays
        instead.

        Each component of an array is a column (`position_x`); `frame` and `particle` count from 0.
        """
        return library("polars").DataFrame(self._table(particles))

    def pandas(self, *, particles: bool = False) -> PandasFrame:
        """The numbers of all frames as a DataFrame of Pandas: see `polars`."""
        return library("pandas").DataFrame(self._table(particles))

    def _table(self, particles: bool) -> dict[str, NDArray[Any]]:
        if particles:
            return of_particles(self)
        names = dict.fromkeys(name for each in self[:1] for name in each.numbers)
        names |= dict.fromkeys(name for each in self[-1:] for name in each.numbers)
        numbered = {name: self.numbers(name) for name in names}
        return {"frame": np.arange(len(self)), "time": self.times, **numbered}

    def __repr__(self) -> str:
        """A text such as `Trajectory('runs/bowl', 151 frames, 0 s to 12 s)`."""
        times = self.times
        span = f", {times[0]:.6g} s to {times[-1]:.6g} s" if len(times) else ""
        return f"Trajectory({str(self.directory)!r}, {len(self)} frames{span})"

    def _repr_html_(self) -> str | None:
        """The notebook view: the player of `ecume view`, in at most 4 MB."""
        return html_of(self)

    def __enter__(self) -> Self:
        """The trajectory itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the files."""
        self.close()

    def __del__(self) -> None:
        """Close the files that are still open."""
        with contextlib.suppress(AttributeError):  # if the construction failed
            self.close()

    def _located(self, index: int) -> tuple[Segment, int]:
        """The segment of a frame, and its index there."""
        place = bisect.bisect_right([segment.header.first for segment in self._segments], index) - 1
        segment = self._segments[max(place, 0)]
        local = index - segment.header.first
        if place < 0 or local >= segment.frames:
            raise StorageError(f"{segment.path}: frame {index} is missing: a segment was removed or lost its end")
        return segment, local

    def _column(self, name: str) -> NDArray[Any]:
        """The values of a number in all frames; NaN in segments without it."""
        columns = [np.zeros(0)]
        for segment in self._segments:
            numbers = segment.numbers()
            stored = {_present_chunk(chunk): chunk for chunk in numbers.dtype.names or ()}
            columns.append(numbers[stored[name]] if name in stored else np.full(segment.frames, np.nan))
        column = np.concatenate(columns)
        if len(column) != len(self):
            raise StorageError(f"{self.directory}: {len(self) - len(column)} frames are missing")
        return column


def _present_chunk(chunk: str) -> str:
    """The name of a chunk of a number in the present version."""
    folder, mark, number = chunk.rpartition("/")
    return folder + mark + gsd.present_name(number)


class _Some(Sequence[Frame]):
    """A selection of frames of a trajectory."""

    def __init__(self, trajectory: Trajectory, which: range) -> None:
        self._trajectory, self._which = trajectory, which

    def __len__(self) -> int:
        return len(self._which)

    @overload
    def __getitem__(self, index: int) -> Frame: ...

    @overload
    def __getitem__(self, index: slice) -> Sequence[Frame]: ...

    def __getitem__(self, index: int | slice) -> Frame | Sequence[Frame]:
        if isinstance(index, slice):
            return _Some(self._trajectory, self._which[index])
        return self._trajectory[self._which[index]]


def _as_it_is(frame: Frame) -> Frame:
    return frame


class ExportedFrames:
    """The frames of a trajectory in the form of exports."""

    def __init__(self, trajectory: Trajectory) -> None:
        self._trajectory = trajectory
        described = (trajectory.directory / "resolved.json").exists()  # a folder of frames may have no scene
        scene = trajectory.scene if described else None
        self._completed: Callable[[Frame], Frame] = derived_arrays(scene) if described else _as_it_is
        self.corner: tuple[float, ...] = tuple(getattr(getattr(scene, "tank", None), "low", None) or ())
        """The lowest corner of a tank (m); empty for other models, whose periodic boxes begin at zero."""

    @property
    def times(self) -> NDArray[np.float64]:
        """The time of each frame, s."""
        return self._trajectory.times

    @property
    def species(self) -> tuple[str, ...]:
        """The names of the species."""
        return self._trajectory.species

    @property
    def samples(self) -> Samples:
        """The numbers sampled between frames."""
        return self._trajectory.samples

    def numbers(self, name: str) -> NDArray[np.float64]:
        """The values of a named number in all frames."""
        return self._trajectory.numbers(name)

    def __len__(self) -> int:
        return len(self._trajectory)

    def __getitem__(self, index: int) -> Frame:
        return self._completed(self._trajectory[index])

    def __iter__(self) -> Iterator[Frame]:
        return (self[index] for index in range(len(self)))
