"""Reading and writing films through the program ffmpeg."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.errors import BadInput, StorageError, install


def ffmpeg() -> str | None:
    """The path of ffmpeg, from the system or from the package imageio-ffmpeg; None if neither exists."""
    found = shutil.which("ffmpeg")
    if found is not None:
        return found
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        path: str = get_ffmpeg_exe()
    except (ImportError, RuntimeError):  # the package is optional, and does not contain ffmpeg for all machines
        return None
    return path


class Film(NamedTuple):
    """The properties of a film."""

    width: int
    height: int
    rate: float
    """pictures a second"""


HEADER = re.compile(rb"YUV4MPEG2 W([0-9]+) H([0-9]+) F([0-9]+):([0-9]+)")
DEPTHS = {"gray": 1, "rgb24": 3}


def film_of(path: str | os.PathLike[str]) -> Film:
    """The size and the rate of a film. Raises BadInput for a file that is not a film."""
    command = [*_reading(path), "-frames:v", "1", "-f", "yuv4mpegpipe", "-pix_fmt", "yuv420p", "-"]
    done = subprocess.run(command, capture_output=True, check=False)  # noqa: S603  # no shell
    match = HEADER.match(done.stdout[:200])
    if match is None:
        said = done.stderr.decode("utf-8", "replace").strip().splitlines() or ["no pictures"]
        raise BadInput(f"{path}: cannot be read as a film: {said[-1]}")
    width, height, frames, seconds = (int(part) for part in match.groups())
    return Film(width, height, frames / seconds)


def pictures_of(path: str | os.PathLike[str], form: str = "gray") -> Iterator[NDArray[np.uint8]]:
    """The pictures of a film, (rows, columns), or (rows, columns, 3) for "rgb24". Raises BadInput for other files."""
    facts, depth = film_of(path), DEPTHS[form]
    shape = (facts.height, facts.width) if depth == 1 else (facts.height, facts.width, depth)
    size = facts.height * facts.width * depth
    command = [*_reading(path), "-f", "rawvideo", "-pix_fmt", form, "-"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:  # noqa: S603
        source = process.stdout
        while source is not None and len(data := source.read(size)) == size:
            yield np.frombuffer(data, np.uint8).reshape(shape)


def _reading(path: str | os.PathLike[str]) -> list[str]:
    program = ffmpeg()
    if program is None:
        raise BadInput(f"films need ffmpeg, which was not found: install it, or {install('movie')}")
    if not Path(path).is_file():
        raise StorageError(f"{path}: no such file")
    return [program, "-hide_banner", "-loglevel", "error", "-nostdin", "-i", os.fspath(Path(path).absolute())]
