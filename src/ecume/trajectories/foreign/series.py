"""Files of other programs as sequences of frames."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from ecume.trajectories.foreign import dcd, dumps, gsd, lammps, xyz
from ecume.trajectories.foreign.particles import Particles


class Series(NamedTuple):
    """The frames of a file."""

    frames: int
    read: Callable[[int], Particles]
    """read(number): the particles of a frame, in the units of the file. Raises ValueError"""


def _of_dump(path: Path, text_of: Callable[[Path], str]) -> Series:
    return Series(*dumps.series(text_of(path)))


def _of_xyz(path: Path, text_of: Callable[[Path], str]) -> Series:
    return Series(*xyz.series(text_of(path)))


def _of_data(path: Path, text_of: Callable[[Path], str]) -> Series:
    text = text_of(path)
    return Series(1, lambda frame: lammps.read(text))


def _of_gsd(path: Path, text_of: Callable[[Path], str]) -> Series:
    return Series(gsd.frames(path), lambda frame: gsd.read(path, frame))


def _of_dcd(path: Path, text_of: Callable[[Path], str]) -> Series:
    return Series(dcd.frames(path), lambda frame: dcd.read(path, frame))


FORMATS: dict[str, Callable[[Path, Callable[[Path], str]], Series]] = {
    "gsd": _of_gsd,
    "xyz": _of_xyz,
    "lammps": _of_data,
    "dump": _of_dump,
    "dcd": _of_dcd,
}
"""For each format, open(path, text_of), which returns its frames; `text_of` reads a text file. Raises ValueError."""
