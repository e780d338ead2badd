"""The frames of a trajectory as exports hold them: with the arrays that follow from the recorded ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from ecume._hooks import derived_arrays
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import Trajectory
from ecume.trajectories.samples import Samples


def _as_it_is(frame: Frame) -> Frame:
    return frame


class ExportedFrames:
    """A view of a trajectory."""

    def __init__(self, trajectory: Trajectory) -> None:
        self._trajectory = trajectory
        described = (trajectory.directory / "resolved.json").exists()  # a folder of frames may have no scene
        self._completed: Callable[[Frame], Frame] = derived_arrays(trajectory.scene) if described else _as_it_is

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
        """One of the named numbers, of all frames."""
        return self._trajectory.numbers(name)

    def __len__(self) -> int:
        return len(self._trajectory)

    def __getitem__(self, index: int) -> Frame:
        return self._completed(self._trajectory[index])

    def __iter__(self) -> Iterator[Frame]:
        return (self[index] for index in range(len(self)))
