"""Particles from a table, and the opening of all files that a scene names.

A table has one particle per line, and the unit of each column in its header, as in `radius [mm]`.
"""

from __future__ import annotations

import codecs
import csv
import gzip
import io
import math
import os
import pathlib
import re
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path as Folder
from typing import Any, NamedTuple

from ecume._plain_files import NotPlain, TooLarge, content_of
from ecume.scenes.faults import Complaints, Inconsistent, Path, echo, suggestion
from ecume.units import factor

TRUSTED = "ECUME_SCENE_FOLDERS"
"""The environment variable with further folders, separated as in PATH, that scenes from elsewhere may read."""


def beside(folder: pathlib.Path, name: str) -> pathlib.Path:
    """The path of the file or folder `name` relative to `folder`. It must be inside this folder or one that the user
    trusts.

    Links are resolved before this test. Raises ValueError.
    """
    if not name or "\0" in name or len(name) > 1000:
        raise ValueError("expected the path of a file")
    try:
        path = folder / pathlib.Path(name).expanduser()
    except RuntimeError as error:
        raise ValueError(f"cannot be followed: {error}") from None
    roots = [os.path.realpath(root) for root in (str(folder), *_trusted())]
    there = pathlib.Path(os.path.realpath(path))
    if not any(there.is_relative_to(root) for root in roots):
        raise ValueError(f"leads out of the scene's folder; copy it there, or name its folder in {TRUSTED}")
    return path


def _trusted() -> list[str]:
    return [place for place in os.environ.get(TRUSTED, "").split(os.pathsep) if place]


def require_there(path: pathlib.Path, folder: pathlib.Path) -> None:
    """Raise ValueError, with the folder that was searched, unless the path exists."""
    # Unlike pathlib.Path.exists, this raises no error for invalid names.
    if not os.path.exists(path):  # noqa: PTH110
        raise ValueError(f"does not exist; paths are relative to the scene's folder, {folder.resolve()}")


COMPRESSED = ".gz"
"""The end of the name of a text file that is compressed."""


def text_of(path: pathlib.Path, most_bytes: int) -> str:
    """The text of a plain UTF-8 file, up to a largest size; files with the extension of gzip are decompressed. Raises
    ValueError.
    """
    content = bytes_of(path, most_bytes)
    return decoded(_unpacked(content, most_bytes) if path.suffix.lower() == COMPRESSED else content)


def _unpacked(content: bytes, most_bytes: int) -> bytes:
    """The decompressed content of a file, up to a largest size. Raises ValueError."""
    try:
        with gzip.open(io.BytesIO(content)) as file:
            found = file.read(most_bytes + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise ValueError(f"cannot be decompressed: {error}") from None
    if len(found) > most_bytes:
        raise ValueError(f"holds more than {most_bytes / 2**20:g} MiB")
    return found


def table_text(path: pathlib.Path, most_bytes: int) -> str:
    """The text of a table, which a spreadsheet may have written as UTF-16 or, on Windows, in its code page. Raises
    ValueError.
    """
    content = bytes_of(path, most_bytes)
    if path.suffix.lower() == COMPRESSED:
        content = _unpacked(content, most_bytes)
    for mark, name in ((codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be")):
        if content.startswith(mark):
            try:
                return content.removeprefix(mark).decode(name)
            except UnicodeDecodeError as error:
                raise ValueError(f"cannot be read as UTF-16: {error.reason}") from None
    try:
        return decoded(content)
    except NotText:
        if CONTROLS.search(content):
            raise
        return content.decode(CODE_PAGE, errors="replace")


CONTROLS = re.compile(rb"[\x00-\x08\x0e-\x1f]")
"""Bytes that no text contains."""
CODE_PAGE = "cp1252"
"""The characters of Windows in most European languages, with the same micro and degree signs as Latin-1."""


def bytes_of(path: pathlib.Path, most_bytes: int) -> bytes:
    """The content of a plain file, up to a largest size. Raises ValueError."""
    try:
        if path.is_dir():
            raise ValueError("is a folder; expected a file")
        return content_of(path, most_bytes)
    except TooLarge:
        raise ValueError(f"is larger than {most_bytes / 2**20:g} MiB") from None
    except NotPlain:
        raise ValueError("is not a regular file") from None
    except OSError as error:
        raise ValueError(f"cannot be read: {error.strerror or error}") from None


class NotText(ValueError):
    """Bytes that are not UTF-8, with the position of the first one."""

    def __init__(self, data: bytes, error: UnicodeDecodeError) -> None:
        before = data[: error.start]
        self.line = before.count(b"\n") + 1
        self.column = len(before.rpartition(b"\n")[2].decode()) + 1
        self.message = f"byte {data[error.start]:#04x} is not UTF-8 text"
        super().__init__(f"line {self.line}, column {self.column}: {self.message}")


def decoded(data: bytes) -> str:
    """Strict UTF-8, with or without a byte-order mark. Raises NotText."""
    data = data.removeprefix(codecs.BOM_UTF8)
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        raise NotText(data, error) from None


MOST_BYTES = 64 * 2**20
MOST_MESSAGES = 20
HEAD = re.compile(r"\s*([A-Za-z_]+)\s*(?:\[\s*([^\[\]()]*?)\s*\]|\(\s*([^\[\]()]*?)\s*\))?\s*")
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
"""The known columns and their SI units; `name` contains text."""
MULTIPLES = {"diameter": ("radius", 0.5)}
"""Columns that are another one apart from a factor."""
DECIMAL_COMMA = re.compile(r"\s*[+-]?\d*,\d+([eE][+-]?\d+)?\s*")


class Line(NamedTuple):
    """One line of a table: its number in the file, and the values of its columns in SI."""

    number: int
    values: dict[str, Any]


class Column(NamedTuple):
    """The name of a column, and the factor that converts its numbers to SI (0 for text)."""

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
    """Apply `follow`, which inserts the content of a file into the plain data of a scene; return its faults."""
    if not isinstance(name, str):
        return [(path, f"got {echo(name)}; expected text")]
    try:
        follow(into, name, folder)
    except TableFaults as faults:
        return [(path, f"{name}, {message}") for message in faults.messages[:MOST_MESSAGES]]
    except Inconsistent as faults:
        return list(faults.complaints)
    except ValueError as fault:
        return [(path, f"{echo(name)} {fault}")]
    return []


def lines_of(text: str, known: Mapping[str, str] = COLUMNS, required: Sequence[str] = ("x", "y")) -> list[Line]:
    """The lines of a table, whose columns are among the `known`. Raises TableFaults."""
    delimiter = _delimiter(text)
    cells = _cells(text, delimiter)
    number, head = next(cells, (1, []))
    columns = _columns(number, head, known, required)
    faults: list[str] = []
    lines = [_line(number, row, columns, faults, comma=delimiter != ",") for number, row in cells]
    if not lines:
        faults.append("has no rows below the header")
    if faults:
        raise TableFaults(faults)
    return lines


def names_of(text: str) -> set[str]:
    """The names of the columns of a table, as far as they can be read. Raises TableFaults for unreadable cells."""
    _, head = next(_cells(text, _delimiter(text)), (1, []))
    return {match[1] for match in map(HEAD.fullmatch, (cell[:200] for cell in head)) if match}


def _delimiter(text: str) -> str:
    """The separator of columns: the most frequent one in the header."""
    first = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    return max(",;\t", key=first.count)


def _cells(text: str, delimiter: str) -> Iterator[tuple[int, list[str]]]:
    """Each line's number and cells; empty lines and those that begin with `#` are skipped."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    try:
        for row in reader:
            if any(cell.strip() for cell in row) and not row[0].startswith("#"):
                yield reader.line_num, row
    except csv.Error as error:
        raise TableFaults([f"line {reader.line_num}: {error}"]) from None


def _columns(number: int, head: Sequence[str], known: Mapping[str, str], required: Sequence[str]) -> list[Column]:
    """The columns of the head. Raises TableFaults."""
    columns, faults = [], []
    for cell in head:
        try:
            columns.append(_column(cell, known))
        except ValueError as fault:
            faults.append(f"line {number}, column {echo(cell.strip())}: {fault}")
    names = [column.name for column in columns]
    faults += [f"line {number}: column {name} appears twice" for name in known if names.count(name) > 1]
    faults += [f"line {number}: no column {name}" for name in required if not faults and name not in names]
    if faults:
        raise TableFaults(faults)
    return columns


def _column(cell: str, known: Mapping[str, str]) -> Column:
    match = HEAD.fullmatch(cell[:200])
    if match is None:
        raise ValueError("expected a name, or a name with its unit as in 'radius [mm]'")
    unit = match[2] or match[3]
    name, scale = MULTIPLES.get(match[1], (match[1], 1.0))
    if name not in known:
        raise ValueError(f"no such column; {suggestion(match[1], known)}")
    if not unit:
        return Column(name, scale if known[name] else 0.0)
    if not known[name]:
        raise ValueError("text has no unit")
    return Column(name, scale * factor(unit, known[name]))


def _line(number: int, row: Sequence[str], columns: Sequence[Column], faults: list[str], *, comma: bool) -> Line:
    """One line in SI units; unreadable cells are added to `faults`. `comma`: whether a comma is the decimal
    separator.
    """
    if len(row) != len(columns):
        faults.append(f"line {number}: {len(row)} cells, expected {len(columns)} as in the head")
    values: dict[str, Any] = {}
    for column, cell in zip(columns, row, strict=False):
        try:
            values[column.name] = _number(cell, column.scale, comma=comma) if column.scale else cell.strip()
        except ValueError:
            faults.append(f"line {number}, column {column.name}: got {echo(cell.strip())}; expected a number")
    return Line(number, values)


def _number(cell: str, scale: float, *, comma: bool) -> float:
    """The number of a cell in SI units. Raises ValueError for infinities, and for notations that only Python accepts. A
    comma is the decimal separator if columns have another separator, as in spreadsheets of many languages; otherwise it
    could be a thousands separator.
    """
    if "_" in cell or not cell.isascii():
        raise ValueError
    number = float(cell.replace(",", ".") if comma and DECIMAL_COMMA.fullmatch(cell) else cell) * scale
    if not math.isfinite(number):
        raise ValueError
    return number
