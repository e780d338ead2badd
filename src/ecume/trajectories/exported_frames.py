"""The frames of a trajectory as exports hold them: with the arrays that follow from the recorded ones."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ecume._hooks import derived_arrays
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import Trajectory


def _as_it_is(frame: Frame) -> Frame:
    return frame


class ExportedFrames:
    """A view of a trajectory."""

    def __init__(self, trajectory: Trajectory) -> None:
        self._trajectory = trajectory
        known = (trajectory.directory / "resolved.json").is_file()  # a bare folder of frames has no scene
        self._completed = derived_arrays(trajectory.scene) if known else _as_it_is

    @property
    def times(self) -> NDArray[np.float64]:
        """The time of each frame, s."""
        return self._trajectory.times

    @property
    def species(self) -> tuple[str, ...]:
        """The names of the species."""
        return self._trajectory.species

    def numbers(self, name: str) -> NDArray[np.float64]:
        """One of the named numbers, of all frames."""
        return self._trajectory.numbers(name)

    def __len__(self) -> int:
        return len(self._trajectory)

    def __getitem__(self, index: int) -> Frame:
        frame: Frame = self._completed(self._trajectory[index])
        return frame

    def __iter__(self) -> Iterator[Frame]:
        return (self[index] for index in range(len(self)))
