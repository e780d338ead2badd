"""DCD files of LAMMPS, NAMD or CHARMM: positions in single precision, frame after frame, without types."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Iterator
from io import BufferedReader
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ecume.trajectories.foreign.particles import MOST_PARTICLES, Particles, frame_number

HEADER = 84
CELL = 48
"""Bytes of the record of the box: its sides A, B, C and the cosines or degrees of its angles."""
MARK = 4
"""Bytes of the length before and after a record."""
CELL_FLAG = 10
"""The word of the header that states whether frames have a box."""
LONGEST_TITLE = 2**20
UPRIGHT = (0.0, 90.0)
"""An angle of a rectangular box, as a cosine or in degrees."""
ALIKE = (1e-6, 1e-4)
"""How far rounding takes angles from them."""


class Layout(NamedTuple):
    """The positions of frames in a file."""

    start: int
    particles: int
    boxed: bool
    frames: int

    @property
    def frame_size(self) -> int:
        """Bytes of a frame."""
        return (CELL + 2 * MARK) * self.boxed + 3 * (4 * self.particles + 2 * MARK)


def read(path: Path, index: int = -1) -> Particles:
    """The particles of a frame, all of one type. Raises ValueError."""
    with _opened(path) as (file, layout):
        file.seek(layout.start + frame_number(index, layout.frames) * layout.frame_size)
        sides, tilted = _box(_record(file, CELL)) if layout.boxed else (None, 0.0)
        axes = [np.frombuffer(_record(file, 4 * layout.particles), "<f4") for _ in range(3)]
    position = np.column_stack(axes).astype(np.float64)
    if not np.isfinite(position).all():
        raise ValueError(f"has NaN or infinity in the positions of frame {index}")
    return Particles(("1",), np.zeros(layout.particles, np.int64), position, sides=sides, tilt=tilted)


def frames(path: Path) -> int:
    """The number of whole frames. Raises ValueError."""
    with _opened(path) as (_, layout):
        return layout.frames


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[tuple[BufferedReader, Layout]]:
    """Open a file and read its layout. Raises ValueError."""
    try:
        with path.open("rb") as file:
            yield file, layout_of(file, path.stat().st_size)
    except OSError as error:
        raise ValueError(f"cannot be read: {error.strerror or error}") from None


def layout_of(file: BufferedReader, size: int) -> Layout:
    """The layout of a file of this size. Raises ValueError."""
    head = file.read(2 * MARK + HEADER)
    if len(head) < 2 * MARK + HEADER or struct.unpack("<i4s", head[:8]) != (HEADER, b"CORD"):
        raise ValueError("is no DCD file with little-endian numbers")
    words = struct.unpack("<20i", head[8 : 8 + 80])
    (title,) = struct.unpack("<i", _bytes(file, MARK))
    if not 0 <= title <= LONGEST_TITLE:
        raise ValueError("has a damaged title")
    _bytes(file, title + MARK)
    (count,) = struct.unpack("<i", _record(file, 4))
    if not 1 <= count <= MOST_PARTICLES:
        raise ValueError(f"has {count} particles; expected 1 to {MOST_PARTICLES}")
    found = Layout(file.tell(), count, bool(words[CELL_FLAG]), 0)
    frames = (size - found.start) // found.frame_size
    if not frames:
        raise ValueError("has no whole frame")
    return found._replace(frames=frames)


def _box(record: bytes) -> tuple[tuple[float, float, float] | None, float]:
    """The sides, and 1 if the box is not rectangular, otherwise 0; no sides for a box without volume."""
    a, gamma, b, beta, alpha, c = struct.unpack("<6d", record)
    if not (np.isfinite([a, b, c]).all() and min(a, b, c) > 0.0):
        return None, 0.0
    return (a, b, c), 0.0 if all(map(_is_upright, (alpha, beta, gamma))) else 1.0


def _is_upright(angle: float) -> bool:
    return any(abs(angle - one) < off for one, off in zip(UPRIGHT, ALIKE, strict=True))


def _record(file: BufferedReader, size: int) -> bytes:
    """The content of a record of this size."""
    marks = struct.pack("<i", size)
    if _bytes(file, MARK) != marks:
        raise ValueError("has a record of another size than its header states")
    content = _bytes(file, size)
    if _bytes(file, MARK) != marks:
        raise ValueError("has a damaged record")
    return content


def _bytes(file: BufferedReader, size: int) -> bytes:
    content = file.read(size)
    if len(content) < size:
        raise ValueError("ends in a record")
    return content
