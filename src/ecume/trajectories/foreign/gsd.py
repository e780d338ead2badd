"""GSD files of any program (HOOMD-blue's schema): a frame, with the chunks that it shares with the first frame."""

from __future__ import annotations

import contextlib
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from io import FileIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ecume.errors import StorageError
from ecume.trajectories.foreign.particles import MOST_PARTICLES, Particles, box_of, frame_number
from ecume.trajectories.gsd import TYPES, Index, read_whole_index

Chunk = NDArray[np.generic]
MOST_TYPES = 1000
MOST_NUMBERS = 4 * MOST_PARTICLES
"""The largest number of values in a chunk."""


def read(path: Path, index: int = -1) -> Particles:
    """The particles of a frame. Raises ValueError."""
    with _opened(path) as (file, found):
        return _particles(file, found, frame_number(index, found.frames))


def frames(path: Path) -> int:
    """The number of frames. Raises ValueError."""
    with _opened(path) as (_, index):
        return index.frames


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[tuple[FileIO, Index]]:
    """Open a file and read its index. Raises ValueError."""
    try:
        with path.open("rb", buffering=0) as file:
            yield file, read_whole_index(file, path)
    except (StorageError, OSError) as error:
        raise ValueError(f"cannot be read: {str(error).removeprefix(f'{path}: ')}") from None


def _particles(file: FileIO, index: Index, frame: int) -> Particles:
    announced = _chunk(file, index, frame, "particles/N")
    count = int(announced.flat[0]) if announced is not None and announced.size else 0
    if not 1 <= count <= MOST_PARTICLES:
        raise ValueError(f"has {count} particles in frame {frame}; expected 1 to {MOST_PARTICLES}")
    position = _of_particles(file, index, frame, "position", count, 3)
    if position is None:
        raise ValueError(f"has no positions of its {count} particles in frame {frame}")
    kind = _of_particles(file, index, frame, "typeid", count, 1)
    numbers = np.zeros(count, np.int64) if kind is None else kind[:, 0].astype(np.int64)
    names = _names(_chunk(file, index, frame, "particles/types"))
    if numbers.min() < 0 or numbers.max() >= len(names):
        raise ValueError(f"has a particle of type {int(numbers.max())} in frame {frame}; it names {len(names)} types")
    box = _chunk(file, index, frame, "configuration/box")
    sides = None if box is None or box.size != 6 else [float(value) for value in box.astype(np.float64).flat]
    density = _of_particles(file, index, frame, "density", count, 1, "log/particles")
    image = _of_particles(file, index, frame, "image", count, 3)
    diameter, mass = (_of_particles(file, index, frame, name, count, 1) for name in ("diameter", "mass"))
    return Particles(
        names,
        numbers,
        position,
        _of_particles(file, index, frame, "velocity", count, 3),
        None if diameter is None else diameter[:, 0],
        None if mass is None else mass[:, 0],
        None if density is None else density[:, 0],
        None if sides is None else box_of(sides[:3]),
        0.0 if sides is None else _tilt(sides),
        None if image is None else image.astype(np.int64),
        _step(file, index, frame),
    )


def _tilt(box: list[float]) -> float:
    """The largest shift of a side of a box (HOOMD's tilts are relative to height and depth)."""
    _, y, z, xy, xz, yz = box
    return max(abs(xy) * y, abs(xz) * z, abs(yz) * z)


def _step(file: FileIO, index: Index, frame: int) -> float | None:
    """The number of steps of a frame, or that of the first frame if it has none."""
    own = frame == 0 or _entry(index, frame, "configuration/step") is not None
    found = _chunk(file, index, frame, "configuration/step") if own else None
    return float(found.flat[0]) if found is not None and found.size else None


def _of_particles(
    file: FileIO, index: Index, frame: int, name: str, count: int, width: int, home: str = "particles"
) -> NDArray[np.float64] | None:
    """The values of a frame's particles; None if the file has no array for this number of particles."""
    found = _chunk(file, index, frame, f"{home}/{name}")
    if found is None or found.size != count * width:
        return None
    values = found.reshape(count, width).astype(np.float64)
    if not np.isfinite(values).all():
        raise ValueError(f"has NaN or infinity in {home}/{name} of frame {frame}")
    return values


def _names(types: Chunk | None) -> tuple[str, ...]:
    """The names of the types; by default one type A."""
    if types is None or not types.size:
        return ("A",)
    if len(types) > MOST_TYPES:
        raise ValueError(f"names {len(types)} types; expected at most {MOST_TYPES}")
    return tuple(row.tobytes().split(b"\0", 1)[0].decode(errors="replace") for row in types)


def _entry(index: Index, frame: int, name: str) -> Any:
    """The entry of a chunk of a frame; None if it does not exist. Entries are in the order of frames."""
    if name not in index.names:
        return None
    order = index.entries["frame"]
    own = index.entries[bisect_left(order, frame) : bisect_right(order, frame)]
    found = own[own["name"] == index.names.index(name)]
    return found[0] if len(found) else None


def _chunk(file: FileIO, index: Index, frame: int, name: str) -> Chunk | None:
    """A chunk of a frame, or that of the first frame. All chunks in the index are inside the file."""
    for number in (frame, 0):
        entry = _entry(index, number, name)
        if entry is not None:
            kind = TYPES[int(entry["type"])]
            rows, columns = int(entry["rows"]), int(entry["columns"])
            if rows * columns > MOST_NUMBERS:
                raise ValueError(f"has {rows * columns} numbers in the chunk {name} of frame {number}; expected fewer")
            file.seek(int(entry["location"]))
            data = file.read(rows * columns * kind.itemsize)
            if len(data) < rows * columns * kind.itemsize:
                raise ValueError(f"ends in the chunk {name} of frame {number}")
            return np.frombuffer(data, kind).reshape(rows, columns)
    return None
