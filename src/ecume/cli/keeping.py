"""What validation and benchmarks came to, kept in a file for the documentation, with dates and machines."""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import Annotated, Any

import typer

Record = Annotated[
    Path | None,
    typer.Option("--record", metavar="FILE", help="Keep the result in this JSON file as well.", show_default=False),
]


def keep(path: Path, name: str, entry: dict[str, Any]) -> None:
    """Put an entry into a file, in place of an earlier one of its name; the others stay."""
    from ecume.run.directory import json_of, write_json
    from ecume.run.manifest import circumstances

    known = json_of(path) if path.exists() else {}
    machine = {key: circumstances()[key] for key in ("ecume", "processor")}
    known[name] = {"date": datetime.datetime.now(datetime.UTC).date().isoformat(), **machine, **entry}
    write_json(path, dict(sorted(known.items())))
