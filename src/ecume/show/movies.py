"""Movies of a run."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ecume.errors import BadInput
from ecume.show.bowl import USUAL, Bowl, Pixels, Size
from ecume.show.encoders import encode, writable
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import open_trajectory

FPS = 30
SMALL = Size(640, 480)
"""Of a GIF, which stores nearly every pixel."""
SAMPLES = 5
"""How many frames of a run decide the range of the colors."""


def movie(
    directory: str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
    *,
    fps: int = FPS,
    every: int = 1,
    size: tuple[int, int] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Make a movie of a run: `out` (.mp4, .webp or .gif), or its `results/movie.mp4`. Returns what was written.

    Every `every`-th frame is shown, `fps` of them a second, on `size` pixels: left out, 960 x 720, and 640 x 480 for a
    GIF, whose every pixel costs. Without an ffmpeg an MP4 becomes a WebP. `progress` is told how many pictures of how
    many are done.
    """
    with open_trajectory(directory) as trajectory:
        target = Path(directory) / "results" / "movie.mp4" if out is None else Path(out)
        return film(trajectory, trajectory.scene, target, fps=fps, every=every, size=size, progress=progress)


def film(
    frames: Sequence[Frame],
    scene: Any,
    out: str | os.PathLike[str],
    *,
    fps: int = FPS,
    every: int = 1,
    size: tuple[int, int] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Make a movie of frames that need not come from a run, as `movie` does of those that do."""
    target = writable(Path(out))
    shape = Size(*size) if size is not None else SMALL if target.suffix.lower() == ".gif" else USUAL
    _require(frames, fps, every, shape)
    shown = range(0, len(frames), every)
    bowl = Bowl(scene, _sample(frames), shape)

    def pictures() -> Iterator[Pixels]:
        for done, index in enumerate(shown, 1):
            yield bowl.pixels(frames[index])
            if progress is not None:
                progress(done, len(shown))

    return encode(pictures(), target, fps)


def _sample(frames: Sequence[Frame]) -> list[Frame]:
    """Frames from the first to the last, evenly."""
    return [frames[int(index)] for index in np.unique(np.linspace(0, len(frames) - 1, SAMPLES).round())]


def _require(frames: Sequence[Frame], fps: int, every: int, size: Size) -> None:
    if not len(frames):
        raise BadInput("the run has no frames yet; there is nothing to show")
    if not 1 <= fps <= 240:
        raise BadInput(f"fps is {fps}; wanted from 1 to 240 pictures a second")
    if every < 1:
        raise BadInput(f"every is {every}; wanted 1 for each frame, 2 for each second one, and so on")
    if not all(64 <= side <= 8192 for side in size):
        raise BadInput(f"size is {size[0]} x {size[1]}; wanted from 64 to 8192 pixels a side")
