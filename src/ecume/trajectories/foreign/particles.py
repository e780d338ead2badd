"""Particles of a file of another program, and errors in such files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

MOST_PARTICLES = 1_000_000
LONGEST_WORD = 40
AXES = 3


class Particles(NamedTuple):
    """Particles in the units of their file; missing quantities are `None`."""

    names: tuple[str, ...]
    """The types, in the order of their numbers."""
    kind: NDArray[np.int64]
    """(N,) the number of each particle's type"""
    position: NDArray[np.float64]
    """(N, 3)"""
    velocity: NDArray[np.float64] | None = None
    """(N, 3)"""
    diameter: NDArray[np.float64] | None = None
    mass: NDArray[np.float64] | None = None
    density: NDArray[np.float64] | None = None
    sides: tuple[float, float, float] | None = None
    """The periodic box."""
    tilt: float = 0.0
    """The largest of the tilts of the box; 0 for a rectangular one."""
    image: NDArray[np.int64] | None = None
    """(N, 3) the number of sides of the box by which each particle is beyond its stored position; zero for unwrapped
    positions
    """
    instant: float | None = None
    """The time or the number of steps, in the unit of the file; only differences are used."""
    timed: bool = False
    """whether `instant` is a time"""


class FileFault(ValueError):
    """A fault of a file, with its line."""

    def __init__(self, message: str, line: int | None = None) -> None:
        self.line = line
        super().__init__(f"line {line}: {message}" if line is not None else message)


def number(word: str, line: int) -> float:
    """The finite number in a text. Raises FileFault."""
    try:
        value = float(word) if word.isascii() and "_" not in word else math.nan
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FileFault(f"got {word[:LONGEST_WORD]!r}; expected a number", line)
    return value


def instant_of(text: str) -> float | None:
    """The time or time step in a text, in the unit of the file; None if it is not a number."""
    try:
        value = float(text.strip().rstrip(",;"))
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def whole(word: str, line: int, least: int = 0) -> int:
    """The integer in a text. Raises FileFault."""
    if not (word.isascii() and word.isdigit() and len(word) < 19 and int(word) >= least):
        raise FileFault(f"got {word[:LONGEST_WORD]!r}; expected a whole number of {least} or more", line)
    return int(word)


def count_of(word: str, line: int) -> int:
    """The number of particles of a frame, in a text. Raises FileFault."""
    if word == "0":
        raise FileFault("has a frame without particles; expected one particle or more in each", line)
    return whole(word, line, least=1)


def require_count(count: int, lines: int, line: int) -> None:
    """Raise FileFault if a file states more particles than its lines can contain."""
    if count > MOST_PARTICLES:
        raise FileFault(f"announces {count} particles; at most {MOST_PARTICLES} can be read", line)
    if count > lines:
        raise FileFault(f"announces {count} particles, and {lines} lines follow", line)


def frame_number(index: int, frames: int) -> int:
    """The index of a frame; negative indices count from the end. Raises ValueError."""
    if not -frames <= index < frames:
        raise ValueError(f"has no frame {index}; there are 0 to {frames - 1}, and -1 for the last")
    return index % frames


def numbered(words: Sequence[str]) -> tuple[tuple[str, ...], NDArray[np.int64]]:
    """The different words in the order of their first use, and the number of each."""
    names = tuple(dict.fromkeys(words))
    place = {name: number for number, name in enumerate(names)}
    return names, np.array([place[word] for word in words], np.int64)


Sides = tuple[float, float, float]


def box_of(sides: Sequence[float], line: int | None = None) -> Sides | None:
    """The sides of a box; None if its area is zero, as for an open system. Raises FileFault for impossible sides."""
    x, y, z = map(float, sides)
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z) and min(x, y, z) >= 0.0):
        raise FileFault(f"got a box with the sides {x:g}, {y:g} and {z:g}; expected positive ones", line)
    return (x, y, z) if x > 0.0 and y > 0.0 else None


class Edges(NamedTuple):
    """A box that is given by its three edges."""

    sides: tuple[float, float, float]
    """along x, y and z"""
    tilt: float
    """The largest component of an edge that makes the box no rectangular one along the axes; 0 without."""
    images: NDArray[np.int64]
    """(3, 3) the sides along each axis that one image along each edge is; edges may be turned by right angles"""


def edges_of(edges: NDArray[np.float64]) -> Edges:
    """The box with these edges (3, 3), one per row: along the axes in any order and direction, or tilted.

    >>> edges_of(np.array([[0.0, 2.0, 0.0], [-3.0, 0.0, 0.0], [0.0, 0.0, 1.0]])).sides
    (3.0, 2.0, 1.0)
    """
    size = np.abs(edges)
    images, diagonal = np.eye(AXES, dtype=np.int64), size.diagonal()
    # The row of the largest number in each column; these rows differ for a box along the axes. An edge of 0 is that of
    # z.
    order = (size + np.finfo(np.float64).tiny * np.eye(AXES)).argmax(axis=0)
    if sorted(order.tolist()) == [*range(AXES)]:
        images[...] = 0
        images[order, np.arange(AXES)] = np.where(edges[order, np.arange(AXES)] < 0.0, -1, 1)
        diagonal = size[order, np.arange(AXES)]
    x, y, z = diagonal.tolist()
    return Edges((x, y, z), float((size * (images == 0)).max()), images)


def require_different(ids: Sequence[float] | NDArray[np.float64], line: int) -> None:
    """Raise FileFault where two particles have one id; `line` is that of the first."""
    known: set[float] = set()
    for place, one in enumerate(ids):
        if one in known:
            raise FileFault(f"got the id {one:g} for the second time", line + place)
        known.add(one)
