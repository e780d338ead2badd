"""Frames of other runs, which scenes name as `RUN@FRAME`."""

from __future__ import annotations

import os
import re
from pathlib import Path as Folder
from typing import Any

from ecume.errors import EcumeError
from ecume.scenes.faults import echo
from ecume.scenes.tables import beside, require_there
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import open_trajectory


def _run_and_frame(folder: Folder, name: str) -> tuple[Folder, int]:
    """The run and the frame of `RUN@FRAME`; the last frame by default. Raises ValueError."""
    whole = beside(folder, name)
    run, at, frame = name.rpartition("@")
    if not at or os.path.isdir(whole):  # noqa: PTH112  # a directory may have an @ in its name, or none can have this one
        require_there(whole, folder)
        return whole, -1
    if re.fullmatch(r"-?[0-9]{1,9}", frame) is None:
        raise ValueError(
            f"{echo(frame)} is not a frame number; expected RUN@FRAME, such as runs/bowl@0 or runs/bowl@-1"
        )
    whole = beside(folder, run)
    require_there(whole, folder)
    return whole, int(frame)


def frame_of_run(folder: Folder, name: str) -> tuple[Frame, Any]:
    """The frame of `RUN@FRAME`, relative to a folder, and the run's scene. Raises ValueError."""
    run, index = _run_and_frame(folder, name)
    try:
        with open_trajectory(run) as trajectory:
            if not -len(trajectory) <= index < len(trajectory):
                raise ValueError(f"has no frame {index}; {_numbered(len(trajectory))}")
            return trajectory[index], trajectory.scene
    except EcumeError as error:
        raise ValueError(f"cannot be opened: {error}") from None


def _numbered(frames: int) -> str:
    """A phrase on the range of frames."""
    return f"there are 0 to {frames - 1}, and -1 for the last" if frames else "the run has no frames yet"
