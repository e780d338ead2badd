"""Frames, and trajectories of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from some_frames import frame_at

from ecume.trajectories.frame import Frame
from ecume.trajectories.segments import Recorder

Frames = Callable[..., list[Frame]]


@pytest.fixture
def frames() -> Frames:
    """Makes so many frames, of six particles in two dimensions by default."""
    return lambda count, **shape: [frame_at(number, **shape) for number in range(count)]


@pytest.fixture
def recorded(tmp_path: Path, frames: Frames) -> Callable[..., Path]:
    """The folder of a trajectory with so many frames."""

    def record(count: int, largest: int = 2**29, **shape: int) -> Path:
        with Recorder(tmp_path / "run" / "traj", largest=largest) as recorder:
            for number, frame in enumerate(frames(count, **shape)):
                recorder.write(frame, 10 * number)
        return tmp_path / "run" / "traj"

    return record
