"""XYZ and extended XYZ: a number of particles, a comment, and a line per particle; frame after frame.

The comment of an extended file names the columns (`Properties=species:S:1:pos:R:3:velo:R:3:radius:R:1`) and the box
(`Lattice="10 0 0 0 10 0 0 0 10"`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.trajectories.foreign.particles import (
    AXES,
    FileFault,
    Particles,
    Sides,
    box_of,
    count_of,
    edges_of,
    frame_number,
    instant_of,
    number,
    numbered,
    require_count,
    require_different,
    whole,
)

PLAIN = "species:S:1:pos:R:3"
PAIR = re.compile(r'(?<![\w-])([A-Za-z_][\w-]*+)\s*+=\s*(?:"([^"]*)"|\'([^\']*)\'|(\S+))')
MOST_COLUMNS = 200
MEANINGS = {
    "position": ("pos", "position", "positions"),
    "velocity": ("velo", "vel", "velocity", "velocities"),
    "momentum": ("momenta", "momentum"),
    "radius": ("radius", "radii"),
    "diameter": ("diameter", "diameters"),
    "mass": ("mass", "masses"),
    "density": ("density", "densities"),
    "species": ("species", "type", "element"),
    "id": ("id",),
    "image": ("image",),
}
"""The names of columns that are read, in lower case."""
VECTORS = {"position", "velocity", "momentum"}
PLANAR = {"image"}
"""Vectors that may have two components."""


class Column(NamedTuple):
    """Columns of one property."""

    first: int
    width: int


def read(text: str, index: int = -1) -> Particles:
    """The particles of a frame. Raises FileFault, or ValueError without a line."""
    lines = text.splitlines()
    return _frame(lines, _starts(lines), index)


def series(text: str) -> tuple[int, Callable[[int], Particles]]:
    """The number of frames, and a function that reads a frame; the text is divided only once. Raises FileFault or
    ValueError.
    """
    lines = text.splitlines()
    starts = _starts(lines)
    return len(starts), lambda index: _frame(lines, starts, index)


def _frame(lines: Sequence[str], starts: Sequence[int], index: int) -> Particles:
    start = starts[frame_number(index, len(starts))]
    comment = {key.lower(): double or single or bare for key, double, single, bare in PAIR.findall(lines[start + 1])}
    columns, width = _columns(comment.get("properties", PLAIN), start + 2)
    exact = "properties" in comment
    rows = [line.split() for line in lines[start + 2 : start + 2 + int(lines[start])]]
    for place, row in enumerate(rows, start + 3):
        if len(row) < width or (exact and len(row) != width):
            raise FileFault(f"got {len(row)} columns; expected {width}", place)
    if place_of_id := columns.pop("id", None):  # programs write particles in any order
        ids = _values(rows, place_of_id, start + 3)[:, 0]
        require_different(ids, start + 3)
        rows = [rows[row] for row in np.argsort(ids, kind="stable")]
    species = columns.get("species")
    words = [row[species.first] for row in rows] if species else ["1"] * len(rows)
    values = {name: _values(rows, one, start + 3) for name, one in columns.items() if name != "species"}
    single = {name: array[:, 0] for name, array in values.items() if name not in VECTORS | PLANAR}
    diameter = single.get("diameter", 2.0 * single["radius"] if "radius" in single else None)
    names, kind = numbered(words)
    box, image = _box(comment, start + 2), _images(values.get("image"))
    mass, density = single.get("mass"), single.get("density")
    velocity = _velocities(values, start + 2)
    instant = instant_of(comment.get("time", ""))
    return Particles(
        names, kind, values["position"], velocity, diameter, mass, density, box.sides, box.tilt,
        None if image is None else image @ box.images, instant, instant is not None,
    )  # fmt: skip


def _images(found: NDArray[np.float64] | None) -> NDArray[np.int64] | None:
    """The image numbers (N, 3), zero along axes that have none; None if the file has none."""
    if found is None or found.shape[1] > AXES:
        return None
    images = np.zeros((len(found), AXES), np.int64)
    images[:, : found.shape[1]] = np.rint(found)
    return images


def _velocities(values: Mapping[str, NDArray[np.float64]], line: int) -> NDArray[np.float64] | None:
    """Velocities, or momenta over masses, which ASE writes instead."""
    if "velocity" in values or "momentum" not in values:
        return values.get("velocity")
    if "mass" in values:
        return values["momentum"] / values["mass"]
    if not values["momentum"].any():
        return values["momentum"]
    raise FileFault("got momenta without masses; expected a column masses:R:1, or velocities as velo:R:3", line)


def _starts(lines: Sequence[str]) -> list[int]:
    """The lines at which frames begin."""
    found, place = [], 0
    while place < len(lines):
        if not lines[place].strip():
            place += 1
            continue
        count = count_of(lines[place].strip(), place + 1)
        require_count(count, len(lines) - place - 2, place + 1)
        found.append(place)
        place += count + 2
    if not found:
        raise ValueError("is empty")
    return found


def _columns(properties: str, line: int) -> tuple[dict[str, Column], int]:
    """The columns of each property that is read, and the number of all columns."""
    parts = properties.split(":")
    if len(parts) % 3 or len(parts) > 3 * MOST_COLUMNS:
        raise FileFault(f"got Properties={properties[:60]}; expected name:type:columns, repeated", line)
    found: dict[str, Column] = {}
    width = 0
    for name, _, count in zip(parts[::3], parts[1::3], parts[2::3], strict=True):
        columns = whole(count, line, least=1)
        if columns > MOST_COLUMNS:
            raise FileFault(f"got {columns} columns of {name[:40]}; expected at most {MOST_COLUMNS}", line)
        meaning = next((key for key, names in MEANINGS.items() if name.lower() in names), None)
        if meaning is not None:
            expected = AXES if meaning in VECTORS else 1
            if meaning not in PLANAR and columns != expected:
                raise FileFault(f"got {columns} columns of {name}; expected {expected}", line)
            found.setdefault(meaning, Column(width, columns))
        width += columns
    if "position" not in found:
        raise FileFault("got no column pos; expected pos:R:3 in Properties", line)
    return found, width


def _values(rows: Sequence[Sequence[str]], column: Column, line: int) -> NDArray[np.float64]:
    cells = (number(row[column.first + k], line + place) for place, row in enumerate(rows) for k in range(column.width))
    return np.fromiter(cells, np.float64).reshape(len(rows), column.width)


class Box(NamedTuple):
    """A box, without sides if it is not periodic."""

    sides: Sides | None
    tilt: float
    images: NDArray[np.int64]
    """(3, 3) the sides along each axis of an image along each edge"""


def _box(comment: dict[str, str], line: int) -> Box:
    if "lattice" not in comment or not {"t", "1"} & {*comment.get("pbc", "T").lower()}:
        return Box(None, 0.0, np.eye(AXES, dtype=np.int64))
    words = comment["lattice"].split()
    if len(words) != 9:
        raise FileFault(f"got a Lattice of {len(words)} numbers; expected 9", line)
    found = edges_of(np.array([number(word, line) for word in words]).reshape(3, 3))
    return Box(box_of(found.sides, line), found.tilt, found.images)
