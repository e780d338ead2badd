"""Movies of a run, the pictures that they are made of by model, and the processes that draw them."""

from __future__ import annotations

import bisect
import itertools
import math
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume.errors import BadInput
from ecume.show.camera import WIDE, Aim, Eye, aimed
from ecume.show.encoders import encode, writable
from ecume.show.floating.bowl import Bowl
from ecume.show.picture import USUAL, Picture, Pixels, Size
from ecume.show.soft.picture import soft_picture
from ecume.show.sph.picture import liquid_picture
from ecume.show.tank import particles_picture
from ecume.show.tracers import tracers_picture
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import open_trajectory

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene

FILMS: dict[str, Callable[..., Picture]] = {
    "floating": Bowl,
    "soft": soft_picture,
    "sph": liquid_picture,
    "tracers": tracers_picture,
}
"""By model: what makes a picture of (scene, some frames of the run, size), and of what else may be asked of it.
Models that have no row show their particles."""
ASKED = {"color": ("sph",), "particles": ("sph",), "eye": ("sph", "soft", "tracers")}
"""Of which models pictures can be colored in several ways, by name, and seen from anywhere."""
REFUSED = {
    "color": "take no color; leave color {} out",
    "particles": "show particles anyway; particles is for tanks of liquid",
    "eye": "are seen from above alone; leave azimuth and elevation out",
}

FPS = 30
SMALL = Size(640, 480, trim=True)
"""Of a GIF, which stores nearly every pixel."""
SAMPLES = 25
"""How many frames of a run decide what there is to be seen, and the range of the colors."""

Reporter = Callable[[int, int], None]
"""Receives the number of finished pictures and their total."""


@dataclass(frozen=True, kw_only=True)
class MovieOptions:
    """The frames of a run that a movie shows, their rate, and their size."""

    fps: int = FPS
    """Frames per second."""
    every: int = 1
    """2 for each second frame, and so on."""
    size: tuple[int, int] | None = None
    """Pixels; by default 960 x 720, and 640 x 480 for a GIF, whose every pixel costs."""
    start: float = 0.0
    """Of the scene's time, s."""
    end: float = math.inf
    """Of the scene's time, s."""
    color: str | None = None
    """What colors mean, such as `pressure` or `speed`; by default what is usual for the model."""
    aim: Aim = WIDE
    """What is looked at, and how closely."""
    eye: Eye | None = None
    """The viewpoint in 3D; by default that of the model."""
    particles: bool = False
    """Draw the particles of a liquid one by one, instead of the region that they fill."""

    def __post_init__(self) -> None:
        if not 1 <= self.fps <= 240:
            raise BadInput(f"got fps = {self.fps}; expected 1 to 240 frames per second")
        if self.every < 1:
            raise BadInput(f"every is {self.every}; expected 1 for each frame, 2 for each second one, and so on")
        if self.size is not None and not all(64 <= side <= 8192 for side in self.size[:2]):
            raise BadInput(f"size is {self.size[0]} x {self.size[1]}; expected from 64 to 8192 pixels a side")
        if not 0.01 <= self.aim.zoom <= 1000.0:
            raise BadInput(f"zoom is {self.aim.zoom:g}; expected 2 for twice as large, and so on, from 0.01 to 1000")
        if not self.start <= self.end:
            raise BadInput(f"{self._span()} there is no time")

    def shown(self, frames: Sequence[Frame]) -> Sequence[Frame]:
        """The frames that are shown."""
        if not len(frames):
            raise BadInput("the run has no frames yet; there is nothing to show")
        first, last = frames[0].time, frames[-1].time
        begin = bisect.bisect_left(frames, self.start - _rounding(self.start), key=_time)
        end = bisect.bisect_right(frames, self.end + _rounding(self.end), key=_time)
        if begin >= end:
            raise BadInput(f"{self._span()} there is no frame; the run has frames from {first:g} s to {last:g} s")
        return frames[begin : end : self.every]

    def _span(self) -> str:
        return f"from {self.start:g} s {f'to {self.end:g} s' if math.isfinite(self.end) else 'on'}"

    def pixels(self, out: Path) -> Size:
        """The size of the pictures of this file."""
        if self.size is not None:
            return Size(*self.size)
        return SMALL if out.suffix.lower() == ".gif" else USUAL


WHOLE = MovieOptions()


def movie(
    directory: str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
    options: MovieOptions = WHOLE,
    *,
    progress: Reporter | None = None,
    workers: int = 1,
) -> Path:
    """Make a movie of a run: `out` (.mp4, .webm, .webp, .gif, or .png for numbered pictures), or its
    `results/movie.mp4`. Returns what was written, of many pictures the first.

    Without an ffmpeg an MP4 becomes a WebP. With `workers` so many processes draw the pictures, which stay the same.
    """
    target = Path(directory) / "results" / "movie.mp4" if out is None else Path(out)
    with open_trajectory(directory) as trajectory:
        if workers <= 1 or len(options.shown(trajectory)) < 2 * workers:
            return film(trajectory, trajectory.scene, target, options, progress=progress)
        target = writable(target)
        drawn = drawn_by_many(Path(directory), options, target, workers)
        return encode(_counted(drawn, len(options.shown(trajectory)), progress), target, options.fps)


def film(
    frames: Sequence[Frame],
    scene: Scene,
    out: str | os.PathLike[str],
    options: MovieOptions = WHOLE,
    *,
    progress: Reporter | None = None,
) -> Path:
    """Make a movie of frames that need not come from a run, as `movie` does of those that do."""
    target = writable(Path(out))
    shown = options.shown(frames)
    picture = picture_of(scene, shown, options, target)
    return encode(_counted(map(picture.pixels, shown), len(shown), progress), target, options.fps)


def picture_of(scene: Scene, shown: Sequence[Frame], options: MovieOptions, target: Path) -> Picture:
    """The open picture in which these frames are shown."""
    asked: dict[str, Any] = {"color": options.color, "eye": options.eye, "particles": options.particles or None}
    given = {name: value for name, value in asked.items() if value is not None}
    for name in given:
        if scene.model not in ASKED[name]:
            raise BadInput(f"pictures of the model {scene.model!r} {REFUSED[name].format(given[name])}")
    film_of: Callable[..., Picture] = FILMS.get(scene.model, particles_picture)
    return aimed(film_of(scene, _sample(shown), options.pixels(target), **given), options.aim)


def _counted(pictures: Iterable[Pixels], count: int, progress: Reporter | None) -> Iterator[Pixels]:
    for done, picture in enumerate(pictures, 1):
        yield picture
        if progress is not None:
            progress(done, count)


def _sample(frames: Sequence[Frame]) -> list[Frame]:
    """Frames from the first to the last, evenly."""
    return [frames[int(index)] for index in np.unique(np.linspace(0, len(frames) - 1, SAMPLES).round())]


def _time(frame: Frame) -> float:
    return frame.time


def _rounding(time: float) -> float:
    """The time of a frame is a number of steps, and may differ from the given decimal by a bit."""
    return 1e-9 * abs(time) if time < math.inf else 0.0


AHEAD = 3
"""Pictures of each process that may wait to be taken: more would fill the memory."""

desk: dict[str, Any] = {}
"""What a process draws with."""


def drawn_by_many(directory: Path, options: MovieOptions, target: Path, workers: int) -> Iterator[Pixels]:
    """The pictures of a run, one after the other."""
    with ProcessPoolExecutor(
        workers, mp_context=get_context("spawn"), initializer=_set_up, initargs=(directory, options, target)
    ) as pool:
        waiting: deque[Future[Any]] = deque()
        coming = iter(itertools.count())
        for number in itertools.islice(coming, AHEAD * workers):
            waiting.append(pool.submit(_draw, number))
        while (picture := waiting.popleft().result()) is not None:
            waiting.append(pool.submit(_draw, next(coming)))
            yield picture


def _set_up(directory: Path, options: MovieOptions, target: Path) -> None:
    from ecume._jit import use_threads
    from ecume.trajectories.reader import open_trajectory

    use_threads(1)
    trajectory = open_trajectory(directory)
    shown = options.shown(trajectory)
    desk.update(shown=shown, picture=picture_of(trajectory.scene, shown, options, target))


def _draw(number: int) -> Any:
    """The picture of that number; None after the last one."""
    if number >= len(desk["shown"]):
        return None
    return np.ascontiguousarray(desk["picture"].pixels(desk["shown"][number])[..., :3])
