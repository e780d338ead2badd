"""The verb movie."""

from __future__ import annotations

import contextlib
import math
import re
from pathlib import Path
from typing import Annotated, Any

import typer

from ecume.cli.endings import say
from ecume.cli.options import option
from ecume.cli.output import Out, echo, wrote
from ecume.cli.progress import counted
from ecume.cli.runs import HERE, Quiet, RunFolder
from ecume.cli.scenes import without_compiler_for
from ecume.errors import BadInput, install

NUMBER = re.compile(r"\s*[+-]?[0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?\s*")


def seconds(text: str) -> float:
    """The time in a text from the command line: `2.5`, `2 s`, `3 min`."""
    from ecume.units import parse

    try:
        return float(text) if NUMBER.fullmatch(text) else parse(text, "s")
    except ValueError as fault:
        raise typer.BadParameter(str(fault)) from None


def pixels(text: str) -> tuple[int, int]:
    """The size in a text from the command line: `1280x960`."""
    match = re.fullmatch(r"\s*([0-9]{1,6})\s*[x×]\s*([0-9]{1,6})\s*", text)
    if match is None:
        raise typer.BadParameter(f"got {text!r}; expected WIDTHxHEIGHT in pixels, such as 1280x960")
    return int(match[1]), int(match[2])


Fps = Annotated[int, typer.Option("--fps", metavar="N", help="Frames per second.")]
Speed = Annotated[
    float | None, option("--speed", min=1e-9, metavar="X", help="Speed over real time; sets --fps and --every.")
]
Every = Annotated[int, typer.Option("--every", metavar="N", help="Use every N-th frame of the run.")]
PictureSize = Annotated[
    Any,
    option(
        "--size",
        parser=pixels,
        metavar="WxH",
        help="Size of the picture in pixels; default: 960x720, 640x480 for a GIF.",
    ),
]
Begin = Annotated[Any, option("--from", parser=seconds, metavar="TIME", help="Start time: 2.5 or '2.5 s'.")]
End = Annotated[Any, option("--to", parser=seconds, metavar="TIME", help="End time.")]
Color = Annotated[
    str | None,
    option(
        "--color",
        metavar="WHAT",
        help="Color a liquid by pressure, dynamic-pressure, absolute-pressure, speed, density or region.",
    ),
]
Particles = Annotated[
    bool, typer.Option("--particles", help="Draw the particles of a liquid instead of a continuous surface.")
]
Zoom = Annotated[float, typer.Option("--zoom", metavar="Z", help="Zoom factor.")]
Follow = Annotated[
    int | None, option("--follow", metavar="N", help="Center the picture on particle N (the first is 0).")
]
Azimuth = Annotated[float | None, option("--azimuth", metavar="DEGREES", help="Azimuth of the camera (3D).")]
Elevation = Annotated[float | None, option("--elevation", metavar="DEGREES", help="Elevation of the camera (3D).")]
Workers = Annotated[int, typer.Option("--workers", metavar="N", help="Number of drawing processes.")]

MOST_RATE = 60.0
"""The largest number of pictures per second of a movie with a given speed."""


def frame_interval(directory: Path) -> float:
    """The time between two frames of a run (s); zero for a single frame."""
    from ecume.trajectories.reader import open_trajectory

    with open_trajectory(directory) as trajectory:
        times = trajectory.times
    return float(times[-1] - times[0]) / (len(times) - 1) if len(times) > 1 else 0.0


def pace(speed: float, interval: float) -> tuple[int, int]:
    """The pictures per second of a movie with this speed relative to real time, and the number of frames from picture
    to picture.

    >>> pace(0.5, 0.02), pace(1.0, 0.001), pace(0.01, 0.002)
    ((25, 1), (59, 17), (5, 1))
    """
    if interval <= 0.0:
        return 30, 1
    rate = speed / interval
    every = max(1, math.ceil(rate / MOST_RATE))
    return max(1, round(rate / every)), every


def eye(azimuth: float | None, elevation: float | None) -> Any:
    """The viewpoint; None if neither angle is given."""
    from ecume.show.picture import Eye

    asked = {"azimuth": azimuth, "elevation": elevation}
    given = {name: angle for name, angle in asked.items() if angle is not None}
    return Eye(**given) if given else None


def movie(
    directory: RunFolder = HERE,
    *,
    out: Out = None,
    fps: Fps = 30,
    every: Every = 1,
    speed: Speed = None,
    size: PictureSize = None,
    start: Begin = None,
    end: End = None,
    color: Color = None,
    particles: Particles = False,
    zoom: Zoom = 1.0,
    follow: Follow = None,
    azimuth: Azimuth = None,
    elevation: Elevation = None,
    workers: Workers = 1,
    quiet: Quiet = False,
) -> None:
    """Make a movie of a run.

    The file name selects the format: .mp4, .webm, .webp or .gif, or .png for numbered pictures.

    Examples: `ecume movie runs/bowl` · `ecume movie runs/bowl -o bowl.gif --every 2 --fps 20 --size 480x360`
    · `ecume movie runs/bowl --from "1 s" --to "3 s"` · `ecume movie runs/bowl --follow 3 --zoom 4`
    · `ecume movie runs/bowl --speed 0.2` · `ecume movie runs/dam --color speed --azimuth 60`
    · `ecume movie runs/bowl -o shots.png --every 10`
    """
    from ecume.run.directory import existing

    existing(directory)
    without_compiler_for(directory)
    from ecume.show.movies import MovieOptions
    from ecume.show.movies import movie as make
    from ecume.show.picture import Aim

    if speed is not None:
        fps, every = pace(speed, frame_interval(directory))
    asked: dict[str, Any] = {"start": start, "end": end, "size": size, "color": color, "eye": eye(azimuth, elevation)}
    asked["aim"] = Aim(zoom, follow)
    given = {name: value for name, value in asked.items() if value is not None}
    options = MovieOptions(fps=fps, every=every, particles=particles, **given)
    with counted("pictures", quiet=quiet) as reporter:
        made = make(directory, out, options, progress=reporter, workers=workers)
    if made.suffix == ".png" and not quiet:
        pictures = sorted(made.parent.glob(f"{made.stem[:-4]}[0-9][0-9][0-9][0-9].png"))
        echo(f"wrote {len(pictures)} pictures, {made} to {pictures[-1].name}")
    else:
        wrote(made, quiet=quiet)
    if not quiet:
        with contextlib.suppress(BadInput):
            pace_text = f"{fps * every * frame_interval(directory):.3g} × real time"
            say(pace_text if speed is not None else f"{pace_text}; --speed sets it")
    if made.suffix != (out or Path("movie.mp4")).suffix and not quiet:
        say(f"no ffmpeg was found, so this is a WebP; for MP4 and WebM install ffmpeg, or {install('movie')}")


VERBS = (movie,)
