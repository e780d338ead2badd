"""Movies of a run: the table of pictures by model, the processes that draw them, and the encoders.

The encoders convert pictures to a movie file. MP4 and WebM require ffmpeg; animated WebP, GIF and numbered PNG files
are always available.
"""

from __future__ import annotations

import bisect
import contextlib
import itertools
import math
import os
import subprocess
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, cast

import numpy as np

from ecume.engine.ffmpeg import ffmpeg
from ecume.errors import BadInput, StorageError
from ecume.show.floating.bowl import Bowl
from ecume.show.picture import USUAL, WIDE, Aim, Eye, Picture, Pixels, Size, aimed
from ecume.show.soft.packing import soft_picture
from ecume.show.sph.picture import liquid_picture
from ecume.show.tank import particles_picture
from ecume.show.tracers import tracers_picture
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import open_trajectory
from ecume.trajectories.records import partial_of, remove_abandoned, replaceable

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene


CODECS = {
    ".mp4": {
        "libx264": ("-crf", "20", "-preset", "veryfast"),
        "libopenh264": ("-b:v", "4M"),
        "mpeg4": ("-q:v", "3"),
    },
    ".webm": {
        "libvpx-vp9": ("-crf", "32", "-b:v", "0", "-deadline", "realtime", "-cpu-used", "6", "-row-mt", "1"),
        "libsvtav1": ("-crf", "38", "-preset", "10"),
        "libvpx": ("-crf", "10", "-b:v", "4M", "-deadline", "realtime"),
    },
}
"""Video codecs by kind of file, best first; the last one is part of every ffmpeg, or of nearly every one."""
PICTURES = ".png"
"""The suffix of numbered pictures instead of a movie."""


def writable(out: Path) -> Path:
    """The file that is written for `out`: a WebP of the same name instead of an MP4 or WebM if there is no ffmpeg."""
    if out.suffix.lower() not in (*ENCODERS, PICTURES):
        known = ", ".join((*ENCODERS, PICTURES))
        raise BadInput(f"{out.name}: no such kind of movie as {out.suffix!r}; expected one of {known}")
    return out.with_suffix(".webp") if out.suffix.lower() in CODECS and ffmpeg() is None else out


def encode(pictures: Iterable[Pixels], out: Path, fps: int) -> Path:
    """Write the pictures, each (height, width, 3 or 4), as a movie; return the file, or the first of several.

    The file is renamed to its final name when it is complete. Raises StorageError if it cannot be written.
    """
    out = writable(out)
    if out.suffix.lower() == PICTURES:
        return _stills(pictures, out)[0]
    there = replaceable(out)
    partial = partial_of(there)
    try:
        there.parent.mkdir(parents=True, exist_ok=True)
        remove_abandoned(there)
        partial.touch(exist_ok=False)  # fail before drawing if the file cannot be written
        ENCODERS[out.suffix.lower()](iter(pictures), partial, fps)
        partial.replace(there)
    except OSError as error:
        raise StorageError(f"{out}: cannot be written ({error.strerror or error})") from error
    finally:
        with contextlib.suppress(OSError):  # a folder that could not be created need not be removed
            partial.unlink()
    return out


def _stills(pictures: Iterable[Pixels], out: Path) -> list[Path]:
    """Write each picture as a file, `name-0000.png` and so on; the files are renamed to these names when all are
    complete.
    """
    from PIL import Image

    partial: dict[Path, Path] = {}
    there = out
    try:
        for number, picture in enumerate(pictures):
            there = replaceable(out.with_name(f"{out.stem}-{number:04d}{out.suffix}"))
            there.parent.mkdir(parents=True, exist_ok=True)
            partial[there] = partial_of(there)
            Image.fromarray(picture[:, :, :3].copy()).save(partial[there], format="png")
        for there, complete in partial.items():
            complete.replace(there)
    except OSError as error:
        raise StorageError(f"{there}: cannot be written ({error.strerror or error})") from error
    finally:
        for each in partial.values():
            with contextlib.suppress(OSError):
                each.unlink(missing_ok=True)
    return list(partial)


def _video(pictures: Iterator[Pixels], out: Path, fps: int) -> None:
    program, kind = ffmpeg() or "ffmpeg", out.suffix.lower()
    first = next(pictures)
    # The codecs require even sides; a picture loses at most one row and one column.
    height, width = first.shape[0] // 2 * 2, first.shape[1] // 2 * 2
    form = "rgba" if first.shape[2] == 4 else "rgb24"
    given = ("-f", "rawvideo", "-pix_fmt", form, "-s", f"{width}x{height}", "-r", str(fps), "-i", "-")
    codec = _codec(program, kind)
    box = ("-movflags", "+faststart", "-f", "mp4") if kind == ".mp4" else ("-f", "webm")
    encoding = ("-an", "-c:v", codec, *CODECS[kind][codec], "-pix_fmt", "yuv420p", *box, str(out))
    command = [program, "-hide_banner", "-loglevel", "error", "-y", *given, *encoding]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:  # noqa: S603 - no shell; ecume makes the names
        complaint = _feed(process, (picture[:height, :width] for picture in itertools.chain([first], pictures)))
    if process.returncode != 0:
        raise StorageError(f"{out}: ffmpeg gave up ({complaint or f'exit {process.returncode}'})")


def _feed(process: subprocess.Popen[bytes], pictures: Iterator[Pixels]) -> str:
    """Send the pictures to ffmpeg; return its last line of output."""
    entrance = cast(IO[bytes], process.stdin)
    try:
        for picture in pictures:
            entrance.write(np.ascontiguousarray(picture).data)
    except BrokenPipeError:
        pass  # ffmpeg has ended early with an error, which is reported
    except BaseException:
        process.kill()
        raise
    said = process.communicate()[1].decode(errors="replace").strip()
    return said.splitlines()[-1] if said else ""


def _codec(program: str, kind: str) -> str:
    """The best available codec for this kind of file."""
    listed = subprocess.run([program, "-hide_banner", "-encoders"], capture_output=True, text=True, check=False)  # noqa: S603 - as above
    return next((codec for codec in CODECS[kind] if f" {codec} " in listed.stdout), list(CODECS[kind])[-1])


def _images(pictures: Iterator[Pixels]) -> Iterator[Any]:
    from PIL import Image

    return (Image.fromarray(picture[:, :, :3].copy()) for picture in pictures)


def _animated(images: Iterator[Any], out: Path, fps: int, **options: Any) -> None:
    next(images).save(out, save_all=True, append_images=images, duration=round(1000 / fps), loop=0, **options)


def _webp(pictures: Iterator[Pixels], out: Path, fps: int) -> None:
    _animated(_images(pictures), out, fps, quality=75, method=0)


def _gif(pictures: Iterator[Pixels], out: Path, fps: int) -> None:
    """Write a GIF with one palette for all pictures and without dithering, so that unchanged pixels need no space."""
    images = _images(pictures)
    first = next(images)
    palette = _palette(first)
    few = (image.quantize(palette=palette, dither=0) for image in itertools.chain([first], images))
    _animated(few, out, fps, optimize=False)


def _palette(first: Any) -> Any:
    """The colors of the first picture, and a coarse cube of all colors for later pictures."""
    from PIL import Image

    shades = (0, 85, 170, 255)
    cube = [shade for color in itertools.product(shades, repeat=3) for shade in color]
    # The usual median cut assigns all colors to large areas; the ends of the color bar, which later pictures need,
    # would be missing.
    own = first.quantize(256 - len(cube) // 3, method=Image.Quantize.MAXCOVERAGE, dither=0).getpalette()
    made = Image.new("P", (1, 1))
    made.putpalette(own + cube)
    return made


ENCODERS: dict[str, Callable[[Iterator[Pixels], Path, int], None]] = {
    ".mp4": _video,
    ".webm": _video,
    ".webp": _webp,
    ".gif": _gif,
}


FILMS: dict[str, Callable[..., Picture]] = {
    "floating": Bowl,
    "soft": soft_picture,
    "sph": liquid_picture,
    "tracers": tracers_picture,
}
"""For each model, the function that makes a picture of (scene, some frames of the run, size) and further options.
Models without a row show their particles.
"""
ASKED = {"color": ("sph",), "particles": ("sph",), "eye": ("sph", "soft", "tracers")}
"""For each option of pictures, the models that support it: colorings, and the viewpoint."""
REFUSED = {
    "color": "take no color; leave color {} out",
    "particles": "show particles anyway; particles is for tanks of liquid",
    "eye": "are seen from above alone; leave azimuth and elevation out",
}

FPS = 30
SMALL = Size(640, 480, trim=True)
"""The default size of a GIF, which stores nearly every pixel."""
SAMPLES = 25
"""The number of frames that determine the shown region and the range of the colors."""

Reporter = Callable[[int, int], None]
"""Receives the number of finished pictures and their total."""


@dataclass(frozen=True, kw_only=True)
class MovieOptions:
    """The frames of a run in a movie, their rate, and their size."""

    fps: int = FPS
    """Frames per second."""
    every: int = 1
    """Interval of the shown frames: 2 for every second frame."""
    size: tuple[int, int] | None = None
    """Size in pixels; default: 960 x 720, for a GIF 640 x 480."""
    start: float = 0.0
    """Start in the scene's time (s)."""
    end: float = math.inf
    """End in the scene's time (s)."""
    color: str | None = None
    """The quantity that colors show, such as `pressure` or `speed`; default: that of the model."""
    aim: Aim = WIDE
    """The shown region and its magnification."""
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
    """Make a movie of a run: `out` (.mp4, .webm, .webp, .gif, or .png for numbered pictures), or `results/movie.mp4` of
    the run. Returns the written file, or the first of several pictures.

    Without ffmpeg the result is a WebP instead of an MP4. `workers` is the number of processes that draw the pictures;
    it does not change them.
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
    """Make a movie of frames, which need not belong to a run."""
    target = writable(Path(out))
    shown = options.shown(frames)
    picture = picture_of(scene, shown, options, target)
    return encode(_counted(map(picture.pixels, shown), len(shown), progress), target, options.fps)


def picture_of(scene: Scene, shown: Sequence[Frame], options: MovieOptions, target: Path) -> Picture:
    """The open picture for these frames."""
    asked: dict[str, Any] = {"color": options.color, "eye": options.eye, "particles": options.particles or None}
    given = {name: value for name, value in asked.items() if value is not None}
    for name in given:
        if scene.model not in ASKED[name]:
            raise BadInput(f"pictures of the model {scene.model!r} {REFUSED[name].format(given[name])}")
    film_of: Callable[..., Picture] = FILMS.get(scene.model, particles_picture)
    picture = film_of(scene, _sample(shown), options.pixels(target), **given)
    picture.pace = pace_text(shown, options.fps) if target.suffix.lower() != PICTURES else ""
    return aimed(picture, options.aim)


def pace_text(shown: Sequence[Frame], fps: int) -> str:
    """The text for the speed of a movie relative to real time, which is drawn next to the time; empty for a single
    frame.
    """
    span = shown[-1].time - shown[0].time if len(shown) > 1 else 0.0
    return f"   {span / (len(shown) - 1) * fps:.2g} × real time" if span > 0.0 else ""


def _counted(pictures: Iterable[Pixels], count: int, progress: Reporter | None) -> Iterator[Pixels]:
    for done, picture in enumerate(pictures, 1):
        yield picture
        if progress is not None:
            progress(done, count)


def _sample(frames: Sequence[Frame]) -> list[Frame]:
    """Frames from the first to the last at equal distances."""
    return [frames[int(index)] for index in np.unique(np.linspace(0, len(frames) - 1, SAMPLES).round())]


def _time(frame: Frame) -> float:
    return frame.time


def _rounding(time: float) -> float:
    """The tolerance of the times of frames, which are whole numbers of steps and may differ from the given decimals by
    a bit.
    """
    return 1e-9 * abs(time) if time < math.inf else 0.0


AHEAD = 3
"""The number of pictures of each process that may wait; more would fill the memory."""

desk: dict[str, Any] = {}
"""The drawing objects of a worker process."""


def drawn_by_many(directory: Path, options: MovieOptions, target: Path, workers: int) -> Iterator[Pixels]:
    """The pictures of a run in order, drawn by several processes."""
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
    """The picture with this number; None after the last one."""
    if number >= len(desk["shown"]):
        return None
    return np.ascontiguousarray(desk["picture"].pixels(desk["shown"][number])[..., :3])
