"""Pictures in, a movie file out.

MP4 and WebM through ffmpeg where there is one; animated WebP and GIF need nothing, so that there is always a movie, and
neither do numbered PNG files.
"""

from __future__ import annotations

import contextlib
import itertools
import shutil
import subprocess
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import IO, Any, cast

import numpy as np
from numpy.typing import NDArray

from ecume.errors import BadInput, StorageError
from ecume.trajectories.durable_files import partial_of, remove_abandoned, replaceable

Pixels = NDArray[np.uint8]
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
"""Numbered pictures in place of a movie."""


def ffmpeg() -> str | None:
    """The path of an ffmpeg: the system's, or that of the imageio-ffmpeg package; None where there is neither."""
    found = shutil.which("ffmpeg")
    if found is not None:
        return found
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        path: str = get_ffmpeg_exe()
    except (ImportError, RuntimeError):  # the package is optional, and has no program for every machine
        return None
    return path


def writable(out: Path) -> Path:
    """The file that will be written for `out`: for an MP4 or WebM without an ffmpeg, a WebP of the same name."""
    if out.suffix.lower() not in (*ENCODERS, PICTURES):
        known = ", ".join((*ENCODERS, PICTURES))
        raise BadInput(f"{out.name}: no such kind of movie as {out.suffix!r}; expected one of {known}")
    return out.with_suffix(".webp") if out.suffix.lower() in CODECS and ffmpeg() is None else out


def encode(pictures: Iterable[Pixels], out: Path, fps: int) -> Path:
    """Write the pictures, each (height, width, 3 or 4), as a movie; the file that was written, or the first of many.

    It appears under its name when it is whole. Raises StorageError where it cannot be written.
    """
    out = writable(out)
    if out.suffix.lower() == PICTURES:
        written = [_still(picture, out, number) for number, picture in enumerate(pictures)]
        return written[0]
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
        with contextlib.suppress(OSError):  # what could not be made need not be removed
            partial.unlink()
    return out


def _still(picture: Pixels, out: Path, number: int) -> Path:
    """Each picture as a separate file: `name-0000.png`, and so on."""
    from PIL import Image

    there = out.with_name(f"{out.stem}-{number:04d}{out.suffix}")
    partial = partial_of(there)
    try:
        there.parent.mkdir(parents=True, exist_ok=True)
        Image.fromarray(picture[:, :, :3].copy()).save(partial, format="png")
        partial.replace(there)
    except OSError as error:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise StorageError(f"{there}: cannot be written ({error.strerror or error})") from error
    return there


def _video(pictures: Iterator[Pixels], out: Path, fps: int) -> None:
    program, kind = ffmpeg() or "ffmpeg", out.suffix.lower()
    first = next(pictures)
    # The codecs want even sides; a picture loses at most one row and one column.
    height, width = first.shape[0] // 2 * 2, first.shape[1] // 2 * 2
    form = "rgba" if first.shape[2] == 4 else "rgb24"
    given = ("-f", "rawvideo", "-pix_fmt", form, "-s", f"{width}x{height}", "-r", str(fps), "-i", "-")
    codec = _codec(program, kind)
    box = ("-movflags", "+faststart", "-f", "mp4") if kind == ".mp4" else ("-f", "webm")
    wanted = ("-an", "-c:v", codec, *CODECS[kind][codec], "-pix_fmt", "yuv420p", *box, str(out))
    command = [program, "-hide_banner", "-loglevel", "error", "-y", *given, *wanted]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:  # noqa: S603 - no shell; ecume makes the names
        complaint = _feed(process, (picture[:height, :width] for picture in itertools.chain([first], pictures)))
    if process.returncode != 0:
        raise StorageError(f"{out}: ffmpeg gave up ({complaint or f'exit {process.returncode}'})")


def _feed(process: subprocess.Popen[bytes], pictures: Iterator[Pixels]) -> str:
    """Send the pictures; what ffmpeg said, its last line."""
    entrance = cast(IO[bytes], process.stdin)
    try:
        for picture in pictures:
            entrance.write(np.ascontiguousarray(picture).data)
    except BrokenPipeError:
        pass  # ffmpeg has ended early, and says why
    except BaseException:
        process.kill()
        raise
    said = process.communicate()[1].decode(errors="replace").strip()
    return said.splitlines()[-1] if said else ""


def _codec(program: str, kind: str) -> str:
    """The best codec for this kind of file that this ffmpeg has."""
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
    """One palette for all pictures, without dithering: what stands still then costs nothing."""
    images = _images(pictures)
    first = next(images)
    palette = _palette(first)
    few = (image.quantize(palette=palette, dither=0) for image in itertools.chain([first], images))
    _animated(few, out, fps, optimize=False)


def _palette(first: Any) -> Any:
    """The colors of the first picture, and a coarse cube of all others for what comes later."""
    from PIL import Image

    shades = (0, 85, 170, 255)
    cube = [shade for color in itertools.product(shades, repeat=3) for shade in color]
    # The usual median cut spends all on large areas; a color bar shows what is yet to come, and would lose its ends.
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
