"""Output of verbs: text, tables and JSON on the terminal, and records in files."""

from __future__ import annotations

import datetime
import json
import math
import os
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
import typer.core

from ecume.cli.options import option

if TYPE_CHECKING:
    from rich.text import Text


Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]
AS_WIDE_AS_IT_IS = 1000
"""Columns of the output to files and pipes: more than any table has."""
CONTROL: dict[int, str | None] = {
    **dict.fromkeys(code for code in (*range(0x20), *range(0x7F, 0xA0)) if code not in b"\t\n"),
    **dict.fromkeys((0x061C, 0x200E, 0x200F, 0x2028, 0x2029, *range(0x202A, 0x202F), *range(0x2066, 0x206A))),
    **dict.fromkeys(range(0xD800, 0xE000), "\N{REPLACEMENT CHARACTER}"),
}
"""Characters that act on a terminal: control characters, marks and overrides of the writing direction, line separators;
and lone surrogates, which no terminal can print.
"""


def cleaned(text: str) -> str:
    r"""Text without control characters, for titles, names and messages from files.

    >>> cleaned("a\x1b[31mred")
    'a[31mred'
    """
    return text.translate(CONTROL)


def echo(text: object = "", *, err: bool = False, nl: bool = True) -> None:
    """Print text. All output of verbs goes through this function or `print_table`."""
    typer.echo(cleaned(str(text)), err=err, nl=nl)


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str | Text]], *, numbers: Sequence[str] = ()) -> None:
    """Print rows under their columns; the columns in `numbers` are right-aligned."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False)
    for column in columns:
        table.add_column(column, justify="right" if column in numbers else "left")
    for row in rows:
        table.add_row(*(Text(cleaned(cell)) if isinstance(cell, str) else cell for cell in row))
    # In a file or a pipe, lines are neither wrapped nor truncated.
    Console(width=None if sys.stdout.isatty() else AS_WIDE_AS_IT_IS).print(table)


Record = Annotated[Path | None, option("--record", metavar="FILE", help="Also write the result to this JSON file.")]


def require_record(path: Path | None) -> None:
    """Raise StorageError, before anything is computed, for a record that cannot be read or written at this path."""
    from ecume.trajectories.records import json_of

    if path is not None:
        require_writable(path, path.parent)
        if path.exists():
            json_of(path)


def require_writable(path: Path, folder: Path) -> None:
    """Raise StorageError, before anything is computed, for a file that cannot be written in this folder, in which
    missing folders of its path are created.
    """
    import tempfile  # not needed by `ecume --help`

    from ecume.trajectories.records import replaceable, storing

    with storing(path):
        replaceable(path)
        with tempfile.TemporaryFile(dir=folder):
            pass


def keep(path: Path, name: str, entry: dict[str, Any]) -> None:
    """Write an entry to a record file, replacing the former entry with this name."""
    from ecume.run.manifest import circumstances
    from ecume.trajectories.records import json_of, write_json

    machine = {key: circumstances()[key] for key in ("ecume", "processor")}
    if hasattr(os, "getloadavg"):
        machine["load"] = round(os.getloadavg()[0], 1)
    machine |= commit()
    # Read immediately before writing, since another process may record at the same time.
    known = json_of(path) if path.exists() else {}
    known[name] = {"date": datetime.datetime.now(datetime.UTC).date().isoformat(), **machine, **entry}
    write_json(path, dict(sorted(known.items())))


def commit() -> dict[str, str]:
    """The commit of the checkout, with `-dirty` if files differ from it; empty for an installed package."""
    words = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty", "--abbrev=8", "--exclude=*"]
    try:
        found = subprocess.run(words, capture_output=True, text=True, check=True)  # noqa: S603  (fixed words)
    except (OSError, subprocess.CalledProcessError):
        return {}
    return {"commit": found.stdout.strip()}


RESULTS = "results"
"""The folder of a run directory for movies, figures and exports."""
Out = Annotated[
    Path | None, option("-o", "--out", metavar="FILE", help="Output file or folder; default: in DIR/results.")
]


def wrote(path: Path, *, quiet: bool) -> None:
    """Print the path of a written file."""
    if not quiet:
        echo(f"wrote {path}")


def print_json(value: object) -> None:
    """Print a value as JSON; NaN and infinity become null."""
    echo(json.dumps(_plain(value), indent=2))


def _plain(value: object) -> object:
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value
