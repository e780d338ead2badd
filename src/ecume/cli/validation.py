"""The verb validate: what ecume computes beside what others computed."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ecume.cli.exit_codes import say
from ecume.cli.output import Record, keep, print_table
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
            metavar="[NAME]...", help="Cases; by default all are listed.", autocompletion=_names, show_default=False
        ),
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="Every case.")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Leave out those that take minutes.")] = False,
    record: Record = None,
) -> None:
    """Compare what ecume computes with published numbers.

    Also with other methods and with bounds that must hold. Ends with 1 when a row is not met.

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
    results = [_compared(case, record) for case in asked]
    if not all(results):
        raise typer.Exit(NOT_MET)


def _chosen(names: Sequence[str], *, everything: bool) -> list[Case]:
    """The cases of these names, each once; all of them when there are none."""
    from ecume.scenes.faults import suggestion
    from ecume.validation import CASES

    if names and everything:
        raise BadInput("expected either names of cases or --all")
    for name in names:
        if name not in CASES:
            raise BadInput(f"there is no case {name!r}; {suggestion(name, CASES)}")
    return [CASES[name] for name in dict.fromkeys(names)] if names else list(CASES.values())


def _compared(case: Case, record: Path | None) -> bool:
    """Print one case's table; whether all of it is met. A case that breaks off is not met, and the others go on."""
    began, worked = time.monotonic(), time.process_time()
    if sys.stderr.isatty():
        typer.echo(f"{case.name} …", err=True)
    try:
        rows = case.rows()
    except EcumeError as error:
        say(f"{case.name}: NOT MET: {error}")
        return False
    print_table((case.name, *NUMBERS, ""), map(_cells, rows), numbers=NUMBERS)
    met = sum(row.met for row in rows)
    typer.echo(f"{case.name}: {met} of {len(rows)} met, {lasting(time.monotonic() - began)}\n")
    if record is not None:
        # Of the processor: what the wall clock says depends on what else the machine does.
        seconds = time.process_time() - worked
        keep(record, case.name, {"seconds": seconds, "rows": [_plain(row) for row in rows]})
    return bool(rows) and met == len(rows)


def _plain(row: Row) -> dict[str, Any]:
    from ecume.validation.rows import as_text

    return {**dict(zip(("name", *NUMBERS), as_text(row), strict=True)), "met": row.met}


def _cells(row: Row) -> tuple[str | Text, ...]:
    from rich.text import Text

    from ecume.validation.rows import as_text

    return (*as_text(row), Text("met", "green") if row.met else Text("NOT MET", "bold red"))


VERBS = (validate,)
