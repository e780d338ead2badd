"""Output of verbs: tables and JSON on the terminal, and results recorded in a file for the documentation."""

from __future__ import annotations

import datetime
import json
import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from rich.text import Text

Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]
AS_WIDE_AS_IT_IS = 1000
"""Columns; more than any table has."""


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str | Text]], *, numbers: Sequence[str] = ()) -> None:
    """Print rows under their columns; those named in `numbers` stand flush right."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False)
    for column in columns:
        table.add_column(column, justify="right" if column in numbers else "left")
    for row in rows:
        table.add_row(*(Text(cell) if isinstance(cell, str) else cell for cell in row))
    # Into a file or a pipe nothing is wrapped or cut off.
    Console(width=None if sys.stdout.isatty() else AS_WIDE_AS_IT_IS).print(table)


Record = Annotated[
    Path | None,
    typer.Option("--record", metavar="FILE", help="Also write the result to this JSON file.", show_default=False),
]


def keep(path: Path, name: str, entry: dict[str, Any]) -> None:
    """Put an entry into a file, in place of an earlier one of its name; the others stay."""
    from ecume.run.manifest import circumstances
    from ecume.trajectories.records import json_of, write_json

    known = json_of(path) if path.exists() else {}
    machine = {key: circumstances()[key] for key in ("ecume", "processor")}
    known[name] = {"date": datetime.datetime.now(datetime.UTC).date().isoformat(), **machine, **entry}
    write_json(path, dict(sorted(known.items())))


def print_json(value: object) -> None:
    """Print a value as JSON; NaN and infinity become null."""
    typer.echo(json.dumps(_plain(value), indent=2))


def _plain(value: object) -> object:
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value
