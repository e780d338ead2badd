"""Output of verbs: tables and JSON on the terminal, and the end of a command: one clear message and an exit code."""

from __future__ import annotations

import datetime
import json
import math
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
import typer.core

from ecume.errors import BadInput, EcumeError, StorageError

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


INTERRUPTED, MISUSED = 130, 2
USAGE_ERROR: type[Exception] = typer.BadParameter.__mro__[1]
"""The base of all faults in options and arguments."""
PREFIX = "ecume: "
"""Begins every line of a message."""
WORDINGS = (
    (r"Invalid value for '?(.+?)'?: ", r"\1: "),
    (r"Input should be a valid integer.*", "expected an integer"),
    (r"Input should be a valid number.*", "expected a number"),
    (r"Input should be greater than or equal to (\S+)", r"expected \1 or more"),
    (r"Input should be less than or equal to (\S+)", r"expected \1 or less"),
    (r"(?:Value error, )?'([^']*)' is not one of (.+)", r"got '\1'; expected one of \2"),
    (r"No such (option|command):? '?([^\s']+)'?", r"\2: no such \1"),
    (r"\(Possible options: (.+)\)", r"(did you mean \1?)"),
    (r"Missing (?:option|argument|parameter) '(.+?)'.*", r"\1: is missing"),
    (r"Got unexpected extra argument(?:s|\(s\))? \((.+)\)", r"got too many arguments: \1"),
    (r"Option '(.+?)' requires an argument", r"\1: expected a value"),
)
"""The messages of the command line parser in the style of all others."""
CONTROL = {code: None for code in (*range(0x20), 0x7F, *range(0x80, 0xA0)) if code != ord("\n")}


class Ending(typer.core.TyperGroup):
    """The group of all commands. Errors of use become messages; a defect of ecume keeps its traceback."""

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        """Read the options before the command."""
        with _usage_errors_as_messages():
            return super().make_context(*arguments, **options)

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        try:
            with _usage_errors_as_messages():
                return super().invoke(ctx)
        except EcumeError as error:
            ended = error
        except BrokenPipeError:
            raise
        except OSError as error:
            ended = StorageError(": ".join(str(part) for part in (error.filename, error.strerror or error) if part))
        except MemoryError:
            ended = BadInput("this needs more memory than the machine has")
        except KeyboardInterrupt:
            say("interrupted")
            raise typer.Exit(INTERRUPTED) from None
        say(str(ended))
        raise typer.Exit(ended.exit_code) from None


@contextmanager
def _usage_errors_as_messages() -> Iterator[None]:
    """Faults of options and arguments in one line each, like all other messages."""
    try:
        yield
    except USAGE_ERROR as error:
        context: Any = getattr(error, "ctx", None)
        if type(error).__name__ == "NoArgsIsHelpError":  # the help itself
            raise
        message: Any = getattr(error, "format_message")  # noqa: B009  # an attribute of the usage errors alone
        say(f"{_in_style(message())}; see {context.command_path if context else 'ecume'} --help")
        raise typer.Exit(MISUSED) from None


def _in_style(message: str) -> str:
    """A message of the parser, reworded.

    >>> _in_style("Invalid value for '--fps': Input should be greater than or equal to 1")
    '--fps: expected 1 or more'
    """
    for pattern, wording in WORDINGS:
        message = re.sub(pattern, wording, message)
    return message.rstrip(".")


def say(message: str) -> None:
    """A message on stderr, each line with the prefix; text from files cannot control the terminal."""
    for line in message.translate(CONTROL).splitlines():
        typer.echo(PREFIX + line, err=True)


def warned(message: Warning | str, *_: object, **__: object) -> None:
    """A warning as a line, in place of Python's two with a path in them."""
    say(f"warning: {message}")
