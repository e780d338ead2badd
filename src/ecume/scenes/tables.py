"""Particles from a table: one a line, the unit of each column in its head, as in `radius [mm]`."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path as Folder
from typing import Any, NamedTuple

from ecume.scenes.faults import Complaints, Path, echo, suggestion
from ecume.units import factor

MOST_BYTES = 64 * 2**20
MOST_MESSAGES = 20
HEAD = re.compile(r"\s*([A-Za-z_]+)\s*(?:\[\s*([^\[\]]*?)\s*\])?\s*")
LENGTH, SPEED, TEXT = "m", "m/s", ""
COLUMNS = {
    "x": LENGTH,
    "y": LENGTH,
    "vx": SPEED,
    "vy": SPEED,
    "radius": LENGTH,
    "density": "kg/m^3",
    "contact_angle": "rad",
    "magnetic_moment": "A*m^2",
    "name": TEXT,
}
"""The columns there are, and their SI units; `name` holds text."""


class Line(NamedTuple):
    """One line of a table: its number in the file, and what stands in the columns, in SI."""

    number: int
    values: dict[str, Any]


class Column(NamedTuple):
    """A column: its name, and what its numbers are multiplied with to be SI (0 for text)."""

    name: str
    scale: float


class TableFaults(ValueError):
    """The faults of a table, one message each."""

    def __init__(self, messages: Sequence[str]) -> None:
        self.messages = tuple(messages)
        super().__init__("\n".join(messages))


def followed(
    path: Path, follow: Callable[[Any, str, Folder], None], into: Any, name: object, folder: Folder
) -> Complaints:
    """Let `follow` put what stands in a file into a scene's plain data; what is wrong with it comes back."""
    if not isinstance(name, str):
        return [(path, f"got {echo(name)}; expected text")]
    try:
        follow(into, name, folder)
    except TableFaults as faults:
        return [(path, f"{name}, {message}") for message in faults.messages[:MOST_MESSAGES]]
    except ValueError as fault:
        return [(path, f"{echo(name)} {fault}")]
    return []


def lines_of(text: str, known: Mapping[str, str] = COLUMNS) -> list[Line]:
    """The lines of a table, whose columns are among the `known`. Raises TableFaults."""
    cells = _cells(text)
    number, head = next(cells, (1, []))
    columns = _columns(number, head, known)
    faults: list[str] = []
    lines = [_line(number, row, columns, faults) for number, row in cells]
    if not lines:
        faults.append("has no rows below the header")
    if faults:
        raise TableFaults(faults)
    return lines


def _cells(text: str) -> Iterator[tuple[int, list[str]]]:
    """Each line's number and cells; empty lines and those that begin with `#` are skipped."""
    first = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    delimiter = max(",;\t", key=first.count)
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    try:
        for row in reader:
            if any(cell.strip() for cell in row) and not row[0].startswith("#"):
                yield reader.line_num, row
    except csv.Error as error:
        raise TableFaults([f"line {reader.line_num}: {error}"]) from None


def _columns(number: int, head: Sequence[str], known: Mapping[str, str]) -> list[Column]:
    """The columns of the head. Raises TableFaults."""
    columns, faults = [], []
    for cell in head:
        try:
            columns.append(_column(cell, known))
        except ValueError as fault:
            faults.append(f"line {number}, column {echo(cell.strip())}: {fault}")
    names = [column.name for column in columns]
    faults += [f"line {number}: column {name} appears twice" for name in known if names.count(name) > 1]
    faults += [f"line {number}: no column {name}" for name in ("x", "y") if not faults and name not in names]
    if faults:
        raise TableFaults(faults)
    return columns


def _column(cell: str, known: Mapping[str, str]) -> Column:
    match = HEAD.fullmatch(cell[:200])
    if match is None:
        raise ValueError("expected a name, or a name with its unit as in 'radius [mm]'")
    name, unit = match[1], match[2]
    if name not in known:
        raise ValueError(f"no such column; {suggestion(name, known)}")
    if not unit:
        return Column(name, 1.0 if known[name] else 0.0)
    if not known[name]:
        raise ValueError("text has no unit")
    return Column(name, factor(unit, known[name]))


def _line(number: int, row: Sequence[str], columns: Sequence[Column], faults: list[str]) -> Line:
    """One line in SI; unreadable cells are added to `faults`."""
    if len(row) != len(columns):
        faults.append(f"line {number}: {len(row)} cells, expected {len(columns)} as in the head")
    values: dict[str, Any] = {}
    for column, cell in zip(columns, row, strict=False):
        try:
            values[column.name] = _number(cell, column.scale) if column.scale else cell.strip()
        except ValueError:
            faults.append(f"line {number}, column {column.name}: got {echo(cell.strip())}; expected a number")
    return Line(number, values)


def _number(cell: str, scale: float) -> float:
    """A plain number in SI. Raises ValueError for infinities, and for what Python alone takes for a number."""
    if "_" in cell or not cell.isascii():
        raise ValueError
    number = float(cell) * scale
    if not math.isfinite(number):
        raise ValueError
    return number
