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


def _of_data(path: Path, text_of: Callable[[Path], str]) -> Series:
    text = text_of(path)
    return Series(1, lambda frame: lammps.read(text))


FORMATS: dict[str, Callable[[Path, Callable[[Path], str]], Series]] = {
    "gsd": lambda path, text_of: Series(gsd.frames(path), lambda frame: gsd.read(path, frame)),
    "xyz": lambda path, text_of: Series(*xyz.series(text_of(path))),
    "lammps": _of_data,
    "dump": lambda path, text_of: Series(*dumps.series(text_of(path))),
    "dcd": lambda path, text_of: Series(dcd.frames(path), lambda frame: dcd.read(path, frame)),
}
"""For each format, open(path, text_of), which returns its frames; `text_of` reads a text file. Raises ValueError."""
