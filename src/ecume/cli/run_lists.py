"""Verbs about several runs: list, compare."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ecume.cli.output import Json, print_json, print_table

if TYPE_CHECKING:
    from ecume.run import Comparison, RunSummary

DIFFERENT = 1
"""The exit code of `compare` when two runs are not equal."""
Folder = Annotated[Path, typer.Argument(metavar="[DIR]", help="Folder to search; default: the current one.")]
FirstRun = Annotated[Path, typer.Argument(metavar="RUN", help="Directory of a run.", show_default=False)]
SecondRun = Annotated[Path, typer.Argument(metavar="RUN", help="Directory of another run.", show_default=False)]


def list_runs(folder: Folder = Path(), json: Json = False) -> None:
    """List the runs in a folder and its subfolders.

    Examples: `ecume list` · `ecume list sweeps/durations --json`
    """
    from ecume.run import list_runs as found_in

    runs = found_in(folder)
    if json:
        print_json([run._asdict() for run in runs])
    elif runs:
        columns = ("run", "model", "title", "state", "simulated", "frames", "size")
        print_table(columns, map(_row, runs), numbers=("simulated", "frames", "size"))
    else:
        typer.echo(f"no runs in {folder}")


def _row(run: RunSummary) -> tuple[str, ...]:
    simulated = f"{run.time:.6g} of {run.duration:.6g} s"
    return (str(run.directory), run.model, run.title, run.state, simulated, str(run.frames), f"{run.size / 1e6:.3g} MB")


def compare(first: FirstRun, second: SecondRun, json: Json = False) -> None:
    """Compare two runs.

    Prints differences of their scenes, versions, and all quantities in frames of equal time.

    The exit code is 0 if all frames are equal bit for bit, else 1.

    Example: `ecume compare runs/bowl runs/syrup`
    """
    from ecume.run import compare as differences

    found = differences(first, second)
    if json:
        plain = {key: [one._asdict() for one in getattr(found, key)] for key in ("scene", "programs", "quantities")}
        print_json({**found._asdict(), **plain, "same": found.same})
    else:
        _print(found)
    if not found.same:
        raise typer.Exit(DIFFERENT)


def _print(found: Comparison) -> None:
    for title, changes in (("scene", found.scene), ("program", found.programs)):
        if changes:
            print_table((title, "first", "second"), [tuple(map(_text, change)) for change in changes])
            typer.echo()
    one, other = found.frames
    typer.echo(f"frames: {one} and {other}, {found.common} of them at equal times")
    if found.quantities:
        rows = [
            (row.name, f"{row.from_time:.6g} s", f"{row.largest:.2e} {row.unit}".rstrip(), f"{row.relative:.1e}")
            for row in found.quantities
        ]
        print_table(("quantity", "differs from", "by at most", "relative"), rows)
    elif found.common:
        typer.echo("all quantities are equal, bit for bit")


def _text(value: object) -> str:
    return "-" if value is None else str(value)


VERBS = (list_runs, compare)
