"""The verb validate: what ecume computes beside what others computed."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ecume.cli.output import Json, Record, keep, print_json, print_table, say
from ecume.cli.progress import lasting
from ecume.errors import BadInput, EcumeError

if TYPE_CHECKING:
    from rich.text import Text

    from ecume.validation import Case
    from ecume.validation.rows import Row

NOT_MET = 1
"""The exit code when a number is not as expected."""
NUMBERS = ("computed", "expected", "tolerance")


def _names(incomplete: str) -> list[str]:
    """Cases that begin so, for the shell's completion."""
    from ecume.validation import CASES

    return [name for name in CASES if name.startswith(incomplete)]


def validate(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[NAME]...", help="Names of cases; default: list all.", autocompletion=_names, show_default=False
        ),
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="Run all cases.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Skip the cases that take minutes.")] = False,
    record: Record = None,
    json: Json = False,
) -> None:
    """Compare what ecume computes with published numbers.

    Also compares with other methods and with bounds. The exit code is 1 if a comparison fails.

    Examples: `ecume validate` · `ecume validate floating walls` · `ecume validate --all --quick`
    """
    from ecume.validation import CASES

    if not names and not everything and not quick:
        print_table(
            ("case", "what is compared", ""),
            [(case.name, case.summary, "takes minutes" if case.long else "") for case in CASES.values()],
        )
        return
    asked = [case for case in _chosen(names or [], everything=everything) if not (quick and case.long)]
    results = [_compared(case, record, shown=not json) for case in asked]
    if json:
        print_json(results)
    if not all(result["met"] for result in results):
        raise typer.Exit(NOT_MET)


def _chosen(names: Sequence[str], *, everything: bool) -> list[Case]:
    """The cases of these names, each once; by default, all of them."""
    from ecume.scenes.faults import suggestion
    from ecume.validation import CASES

    if names and everything:
        raise BadInput("expected either names of cases or --all")
    for name in names:
        if name not in CASES:
            raise BadInput(f"no case {name!r}; {suggestion(name, CASES)}")
    return [CASES[name] for name in dict.fromkeys(names)] if names else list(CASES.values())


def _compared(case: Case, record: Path | None, *, shown: bool) -> dict[str, Any]:
    """The result of one case, printed as a table if it is `shown`. A case that fails is not met."""
    began, worked = time.monotonic(), time.process_time()
    if sys.stderr.isatty():
        typer.echo(f"{case.name} …", err=True)
    try:
        rows = case.rows()
    except EcumeError as error:
        say(f"{case.name}: NOT MET: {error}")
        return {"case": case.name, "met": False, "error": str(error), "rows": []}
    met = sum(row.met for row in rows)
    if shown:
        print_table((case.name, *NUMBERS, ""), map(_cells, rows), numbers=NUMBERS)
        typer.echo(f"{case.name}: {met} of {len(rows)} met, {lasting(time.monotonic() - began)}\n")
    plain = [_plain(row) for row in rows]
    if record is not None:
        # Processor time: wall time depends on what else the machine does.
        keep(record, case.name, {"seconds": time.process_time() - worked, "rows": plain})
    return {"case": case.name, "met": bool(rows) and met == len(rows), "rows": plain}


def _plain(row: Row) -> dict[str, Any]:
    from ecume.validation.rows import as_text

    return {**dict(zip(("name", *NUMBERS), as_text(row), strict=True)), "met": row.met}


def _cells(row: Row) -> tuple[str | Text, ...]:
    from rich.text import Text

    from ecume.validation.rows import as_text

    return (*as_text(row), Text("met", "green") if row.met else Text("NOT MET", "bold red"))


VERBS = (validate,)
