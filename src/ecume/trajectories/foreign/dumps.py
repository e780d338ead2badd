"""LAMMPS dumps of the styles atom, custom and yaml: frame after frame, each with the names of its columns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.trajectories.foreign.particles import (
    AXES,
    FileFault,
    Particles,
    box_of,
    count_of,
    edges_of,
    frame_number,
    instant_of,
    number,
    numbered,
    require_count,
    require_different,
)

START, YAML = "ITEM: TIMESTEP", "---"
BEFORE_START = ("ITEM: UNITS", "ITEM: TIME")
"""Items that LAMMPS writes before that of the time step, with `dump_modify units` and `time`."""
GENERAL = "abc"
"""The mark of a box that is given by its edges and its origin, with `dump_modify triclinic/general`."""
POSITIONS = (("x", "y", "z"), ("xu", "yu", "zu"), ("xs", "ys", "zs"), ("xsu", "ysu", "zsu"))
"""The names of the columns of positions: wrapped, unwrapped, and both of them in units of the box."""
IMAGES = ("ix", "iy", "iz")
KINDS = ("type", "element")
DENSITIES = ("density", "rho")


class Table(NamedTuple):
    """A frame: its box, and the words of each particle."""

    box: list[list[float]]
    """low and high along each axis, and the tilts behind them; or each edge, with the origin's coordinate behind it"""
    columns: list[str]
    rows: list[list[str]]
    line: int
    """of the first row"""
    instant: float | None = None
    timed: bool = False


def read(text: str, index: int = -1) -> Particles:
    """The particles of a frame, in the order of their ids. Raises FileFault, or ValueError without a line."""
    lines = text.splitlines()
    return _frame(lines, _starts(lines), index)


def series(text: str) -> tuple[int, Callable[[int], Particles]]:
    """The number of frames, and a function that reads a frame; the text is divided only once. Raises ValueError."""
    lines = text.splitlines()
    starts = _starts(lines)
    return len(starts), lambda index: _frame(lines, starts, index)


def _frame(lines: Sequence[str], starts: Sequence[int], index: int) -> Particles:
    chosen = frame_number(index, len(starts))
    end = starts[chosen + 1] if chosen + 1 < len(starts) else len(lines)
    table_at = _yaml_table if lines[0] == YAML else _table
    return _particles(table_at(lines, starts[chosen], end))


def _starts(lines: Sequence[str]) -> list[int]:
    """The lines at which frames begin."""
    start = YAML if lines[:1] == [YAML] else START
    found = [place for place, line in enumerate(lines) if line.strip() == start]
    if not found:
        raise ValueError("has no frame; expected a LAMMPS dump of the style atom, custom or yaml")
    return [_first_line(lines, place) for place in found]


def _first_line(lines: Sequence[str], place: int) -> int:
    """The first line of the frame whose time step is at a line."""
    while place >= 2 and lines[place - 2].strip() in BEFORE_START:
        place -= 2
    return place


def _table(lines: Sequence[str], place: int, end: int) -> Table:
    """The frame that begins at a line and ends before another."""
    items: dict[str, tuple[list[str], int]] = {}
    while place < end:
        words = lines[place].split()
        place += 1
        if words[:1] != ["ITEM:"]:
            continue
        name = "BOX BOUNDS" if words[1:3] == ["BOX", "BOUNDS"] else words[1] if len(words) > 1 else ""
        items[name] = words, place
    for name, called in (("NUMBER", "NUMBER OF ATOMS"), ("BOX BOUNDS", "BOX BOUNDS"), ("ATOMS", "ATOMS")):
        if name not in items or (name != "ATOMS" and items[name][1] >= end):
            raise ValueError(f"has a frame without ITEM: {called}")
    at = items["NUMBER"][1]
    count = count_of(lines[at].strip(), at + 1)
    bounds, (head, first) = items["BOX BOUNDS"][1], items["ATOMS"]
    require_count(count, end - first, at + 1)
    counts = (4,) if GENERAL in items["BOX BOUNDS"][0] else (2, 3)
    box = [
        _numbers(line.split(), bounds + axis + 1, counts)
        for axis, line in enumerate(lines[bounds : min(bounds + AXES, end)])
    ]
    rows = [line.split() for line in lines[first : first + count]]
    clock = items.get("TIME", items["TIMESTEP"])[1]
    return Table(box, head[2:], rows, first + 1, instant_of(lines[clock]) if clock < end else None, "TIME" in items)


def _yaml_table(lines: Sequence[str], place: int, end: int) -> Table:
    """The frame of the style yaml that begins at a line and ends before another."""
    keys = {
        line.split(":")[0]: at for at, line in enumerate(lines[place:end], place) if line[:1].isalpha() and ":" in line
    }
    for name in ("natoms", "box", "keywords", "data"):
        if name not in keys:
            raise ValueError(f"has a frame without {name}")
    count = count_of(lines[keys["natoms"]].split(":")[1].strip(), keys["natoms"] + 1)
    first = keys["data"] + 1
    require_count(count, end - first, keys["natoms"] + 1)
    at = keys["box"] + 1
    box = [_numbers(_items(line), at + axis + 1, (2, 3)) for axis, line in enumerate(lines[at : min(at + AXES, end)])]
    if len(box) == AXES and at + AXES < end and lines[at + AXES].lstrip().startswith("-"):  # the tilts xy, xz and yz
        tilts = _numbers(_items(lines[at + AXES]), at + AXES + 1, (3,))
        box = [[*ends[:2], tilt] for ends, tilt in zip(box, tilts, strict=True)]
    rows = [_items(line) for line in lines[first : first + count]]
    clock = keys.get("time", keys.get("timestep"))
    instant = None if clock is None else instant_of(lines[clock].partition(":")[2])
    return Table(box, _items(lines[keys["keywords"]].partition(":")[2]), rows, first + 1, instant, "time" in keys)


def _items(line: str) -> list[str]:
    """The items of a list in brackets."""
    inside = line.partition("[")[2].rpartition("]")[0]
    return [word for part in inside.split(",") if (word := part.strip())]


def _numbers(words: Sequence[str], line: int, counts: Sequence[int]) -> list[float]:
    if len(words) not in counts:
        of_counts = {4: "an edge of the box and a coordinate of its origin", 3: "the tilts xy, xz and yz of the box"}
        expected = of_counts.get(counts[0], "the low and the high end of the box")
        raise FileFault(f"got {len(words)} numbers; expected {expected}", line)
    return [number(word, line) for word in words]


def _particles(table: Table) -> Particles:
    for place, row in enumerate(table.rows):
        if len(row) != len(table.columns):
            raise FileFault(f"got {len(row)} columns; expected {len(table.columns)}", table.line + place)
    place_of = {name: place for place, name in enumerate(table.columns)}
    order = _order(table, place_of)
    low, lattice = _lattice(table.box)
    kinds = next((name for name in KINDS if name in place_of), None)
    words = [table.rows[row][place_of[kinds]] if kinds else "1" for row in order]
    names, kind = numbered(sorted(set(words), key=lambda word: (len(word), word)) + words)
    given = {name: _column(table, place_of, name, order) for name in ("radius", "diameter", "mass", *DENSITIES)}
    radius, density = given["radius"], given["density"] if given["density"] is not None else given["rho"]
    diameter = given["diameter"] if radius is None else 2.0 * radius
    velocity = _vectors(table, place_of, ("vx", "vy", "vz"), order)
    columns = _columns_of_positions(table, place_of)
    position = _vectors(table, place_of, columns, order)
    if position is None:
        raise FileFault(f"got the columns {' '.join(table.columns)[:60]}; expected x y z or xs ys zs", table.line - 1)
    if "s" in columns[0]:
        position = low + position @ lattice.T
    images = _images(table, place_of, order, columns)
    if len(table.box[0]) > AXES:  # edges may have any direction
        sides, tilt, turned = edges_of(lattice.T)
        images = None if images is None else images @ turned
    else:
        x, y, z = lattice.diagonal().tolist()
        sides, tilt = (x, y, z), float(np.abs(lattice - np.diag(lattice.diagonal())).max())
    return Particles(
        names, kind[len(names) :], position, velocity, diameter, given["mass"], density,
        box_of(sides), tilt, images, table.instant, table.timed,
    )  # fmt: skip


def _order(table: Table, place_of: Mapping[str, int]) -> NDArray[np.int64]:
    """The rows in the order of ids; in a dump they may have any order."""
    ids = _column(table, place_of, "id", np.arange(len(table.rows)))
    if ids is None:
        return np.arange(len(table.rows))
    require_different(ids, table.line)
    return np.argsort(ids, kind="stable")


def _lattice(box: Sequence[Sequence[float]]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The corner of the box (3,), and its edges as columns (3, 3). The bounds of a tilted box, with xy, xz and yz
    behind them, contain the tilts.
    """
    if len(box) < AXES:
        raise ValueError("ends in the bounds of a box")
    if len(box[0]) > AXES:
        return np.array([edge[AXES] for edge in box]), np.array([edge[:AXES] for edge in box]).T
    xy, xz, yz = (ends[2] if len(ends) > 2 else 0.0 for ends in box)
    shifts = [(0.0, xy, xz, xy + xz), (0.0, yz), (0.0,)]
    low = np.array([ends[0] - min(own) for ends, own in zip(box, shifts, strict=True)])
    high = np.array([ends[1] - max(own) for ends, own in zip(box, shifts, strict=True)])
    lattice = np.diag(high - low)
    lattice[0, 1], lattice[0, 2], lattice[1, 2] = xy, xz, yz
    return low, lattice


def _columns_of_positions(table: Table, place_of: Mapping[str, int]) -> tuple[str, str, str]:
    """The names of the columns of positions; those of unwrapped positions if wrapped ones have no image numbers."""
    there = [names for names in POSITIONS if names[0] in place_of and names[1] in place_of] or [POSITIONS[0]]
    known = IMAGES[0] in place_of and IMAGES[1] in place_of
    return next((names for names in there if "u" in names[0] and not known), there[0])


def _images(
    table: Table, place_of: Mapping[str, int], order: NDArray[np.int64], columns: tuple[str, str, str]
) -> NDArray[np.int64] | None:
    """The image numbers of wrapped positions; zero for positions that are not wrapped, None where they are unknown."""
    if "u" in columns[0]:
        return np.zeros((len(order), AXES), np.int64)
    found = _vectors(table, place_of, IMAGES, order)
    return None if found is None else np.rint(found).astype(np.int64)


def _vectors(
    table: Table, place_of: Mapping[str, int], names: Sequence[str], order: NDArray[np.int64]
) -> NDArray[np.float64] | None:
    """Three columns; zero for z where a dump of two dimensions has none."""
    found = [_column(table, place_of, name, order) for name in names]
    if found[0] is None or found[1] is None:
        return None
    return np.column_stack([found[0], found[1], np.zeros(len(order)) if found[2] is None else found[2]])


def _column(
    table: Table, place_of: Mapping[str, int], name: str, order: NDArray[np.int64]
) -> NDArray[np.float64] | None:
    if name not in place_of:
        return None
    at = place_of[name]
    return np.array([number(row[at], table.line + place) for place, row in enumerate(table.rows)])[order]
