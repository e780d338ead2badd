"""Output of verbs: tables and JSON on the terminal, progress, and the end of a command with a message and an exit code.

Progress is a bar on a terminal, a plain line now and then in a log, or the table of numbers of `--thermo`.
"""

from __future__ import annotations

import datetime
import json
import math
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
import typer.core

from ecume._compiler_events import watch
from ecume.errors import BadInput, EcumeError, StorageError

if TYPE_CHECKING:
    from rich.text import Text

    from ecume.run.recording import Progress
    from ecume.trajectories.frame import Frame

Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]
AS_WIDE_AS_IT_IS = 1000
"""Columns; more than any table has."""


CONTROL: dict[int, str | None] = {
    **dict.fromkeys(code for code in (*range(0x20), *range(0x7F, 0xA0)) if code not in b"\t\n"),
    **dict.fromkeys((0x061C, 0x200E, 0x200F, 0x2028, 0x2029, *range(0x202A, 0x202F), *range(0x2066, 0x206A))),
    **dict.fromkeys(range(0xD800, 0xE000), "\N{REPLACEMENT CHARACTER}"),
}
"""Characters that act on a terminal: control characters, marks and overrides of the direction of writing, separators of
lines; and halves of characters, which no terminal can show.
"""


def cleaned(text: str) -> str:
    r"""Text without anything that acts on a terminal, as it may stand in titles, names and messages of files.

    >>> cleaned("a\x1b[31mred")
    'a[31mred'
    """
    return text.translate(CONTROL)


def echo(text: object = "", *, err: bool = False, nl: bool = True) -> None:
    """Print text; all that verbs print goes through here or through `print_table`."""
    typer.echo(cleaned(str(text)), err=err, nl=nl)


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str | Text]], *, numbers: Sequence[str] = ()) -> None:
    """Print rows under their columns; those named in `numbers` stand flush right."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False)
    for column in columns:
        table.add_column(column, justify="right" if column in numbers else "left")
    for row in rows:
        table.add_row(*(Text(cleaned(cell)) if isinstance(cell, str) else cell for cell in row))
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
    if hasattr(os, "getloadavg"):
        machine["load"] = round(os.getloadavg()[0], 1)
    machine |= commit()
    known[name] = {"date": datetime.datetime.now(datetime.UTC).date().isoformat(), **machine, **entry}
    write_json(path, dict(sorted(known.items())))


def commit() -> dict[str, str]:
    """That of the checkout, with `-dirty` where files differ from it. Empty for an installed package."""
    words = ["git", "-C", str(Path(__file__).parent), "describe", "--always", "--dirty", "--abbrev=8", "--exclude=*"]
    try:
        found = subprocess.run(words, capture_output=True, text=True, check=True)  # noqa: S603  (fixed words)
    except (OSError, subprocess.CalledProcessError):
        return {}
    return {"commit": found.stdout.strip()}


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
    (r"Missing (?:option|argument|parameter) '(.+?)'\. Choose from: (.+)", r"\1: is missing; expected one of \2"),
    (r"Missing (?:option|argument|parameter) '(.+?)'.*", r"\1: is missing"),
    (r"Got unexpected extra argument(?:s|\(s\))? \((.+)\)", r"got too many arguments: \1"),
    (r"Option '(.+?)' requires an argument", r"\1: expected a value"),
)
"""The messages of the command line parser in the style of all others."""


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
    message = " ".join(message.split())
    for pattern, wording in WORDINGS:
        message = re.sub(pattern, wording, message)
    return message.rstrip(".")


def say(message: str) -> None:
    """A message on stderr, each line with the prefix."""
    for line in cleaned(message).splitlines():
        echo(PREFIX + line, err=True)


def warned(message: Warning | str, *_: object, **__: object) -> None:
    """A warning as a line, in place of Python's two with a path in them."""
    say(f"warning: {message}")


_began: list[float] = []


def start() -> None:
    """A command begins. The first of a process began with the process, which has computed ever since."""
    before = 0.0 if _began else time.process_time()
    _began[:] = [time.monotonic() - before]


def elapsed() -> float:
    """Seconds of wall time since the command began; 0 outside of commands."""
    return time.monotonic() - _began[0] if _began else 0.0


LINE_EVERY = 10.0
"""Seconds between two plain lines."""

Reporter = Callable[["Progress"], None]


@contextmanager
def shown(*, quiet: bool) -> Iterator[Reporter | None]:
    """The reporter of a run's progress: none, a bar, or lines on stderr."""
    if quiet:
        yield None
    elif sys.stderr.isatty():
        with _bar() as reporter:
            yield WithExpectation(reporter)
    else:
        yield WithExpectation(Lines())


class WithExpectation:
    """A reporter whose first line is how long the run is expected to take, as soon as its steps have been timed."""

    def __init__(self, report: Reporter) -> None:
        self._report, self._said = report, False

    def __call__(self, progress: Progress) -> None:
        """Report, after the expectation."""
        if not self._said and progress.remaining:
            self._said = True
            echo(expectation(progress), err=True)
        self._report(progress)


def expectation(progress: Progress) -> str:
    """`30000 steps, about 4 min`."""
    steps = f"{progress.steps} steps" if progress.steps else "adaptive steps"
    return f"{steps}, about {lasting(progress.remaining or 0.0)}"


@contextmanager
def _bar() -> Iterator[Reporter]:
    from rich.console import Console
    from rich.progress import BarColumn, ProgressColumn, Task
    from rich.progress import Progress as Bars
    from rich.text import Text

    class Doing(ProgressColumn):
        """The task's description; what is done before the first step, as long as that lasts."""

        def render(self, task: Task) -> Text:
            return Text(task.description or waiting())

    # The time that is left is the run's own: Rich would count the wait for the compiler as slow integration.
    columns, console = (BarColumn(), Doing()), Console(stderr=True)
    # Lines for the same terminal appear above the bar; lines for a file or a pipe go there.
    with Bars(*columns, console=console, transient=True, redirect_stdout=sys.stdout.isatty()) as bars:
        bar = bars.add_task("", total=None)
        yield lambda progress: bars.update(
            bar,
            total=progress.duration,
            completed=progress.time,
            description=line(progress) if progress.begun else "",
        )


@contextmanager
def counted(what: str, *, quiet: bool, lines: bool = False) -> Iterator[Callable[[int, int], None] | None]:
    """What counts things that are done, `12 of 300 points, 4 min left`: a bar on a terminal; elsewhere `lines`, or
    nothing if the end is near.
    """
    if quiet or not (lines or sys.stderr.isatty()):
        yield None
    elif sys.stderr.isatty():
        with _counting_bar(Pace(what)) as reporter:
            yield reporter
    else:
        yield CountLines(Pace(what))


@contextmanager
def _counting_bar(pace: Pace) -> Iterator[Callable[[int, int], None]]:
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn
    from rich.progress import Progress as Bars

    # ecume estimates the remaining time: Rich only uses the last half minute.
    with Bars(BarColumn(), TextColumn("{task.description}"), console=Console(stderr=True), transient=True) as bars:
        bar = bars.add_task(pace.what, total=None)
        yield lambda done, of: bars.update(bar, total=of, completed=done, description=pace(done, of))


class Pace:
    """The number of things done, and the time left at the pace since the first report."""

    def __init__(self, what: str) -> None:
        self.what = what
        self._first: tuple[float, int] | None = None

    def __call__(self, done: int, of: int) -> str:
        """`12 of 300 points, 4 min left`."""
        now = time.monotonic()
        since, before = self._first = self._first or (now, done)
        left = f", {lasting((of - done) * (now - since) / (done - before))} left" if before < done < of else ""
        return f"{done} of {of} {self.what}{left}"


class CountLines:
    """A plain line every ten seconds in which something was done."""

    def __init__(self, pace: Pace) -> None:
        self._pace = pace
        self._last = time.monotonic()

    def __call__(self, done: int, of: int) -> None:
        """Say how many are done, if it is time to."""
        said, now = self._pace(done, of), time.monotonic()
        if now - self._last >= LINE_EVERY:
            self._last = now
            echo(said, err=True)


class Lines:
    """A plain line every ten seconds."""

    def __init__(self) -> None:
        self._last = time.monotonic()

    def __call__(self, progress: Progress) -> None:
        """Say how far it is, if it is time to."""
        now = time.monotonic()
        if now - self._last >= LINE_EVERY:
            self._last = now
            echo(line(progress), err=True)


def line(progress: Progress) -> str:
    """The whole progress line: `12.35 s of 20 s, 3.1 x real time, 2.5 s left`, without what is not known yet."""
    return ", ".join(part for part in (place(progress), ahead(progress.remaining)) if part)


def waiting() -> str:
    """What a run does before its first step."""
    return "compiling" if watch.compiling else "setting up"


def place(progress: Progress) -> str:
    """Simulated time and speed: `12.35 s of 20 s, 3.1 x real time`."""
    speed = f", {progress.speed:.3g} x real time" if progress.speed else ""
    return f"{progress.time:.4g} s of {progress.duration:.4g} s{speed}"


def ahead(remaining: float | None) -> str:
    """The time left, `4 min left`; nothing while it is unknown."""
    return "" if remaining is None else f"{lasting(remaining)} left"


def lasting(seconds: float) -> str:
    """A wall time for people: `12 s`, `4 min`, `3.5 h`."""
    for unit, size, below in (("s", 1.0, 100.0), ("min", 60.0, 100.0), ("h", 3600.0, 48.0)):
        if seconds < size * below:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 86400.0:.3g} days"


LEAST_WIDTH = 12
"""Characters of a column: six digits with sign, point and exponent."""
LEAD = {"step": "", "time": "s"}
"""The first columns, and their units."""

Thermo = Annotated[bool, typer.Option("--thermo", help="Print a table of numbers with one line per frame.")]
Columns = Annotated[
    str | None,
    typer.Option(
        "--thermo-columns",
        metavar="NAMES",
        help="Columns of --thermo, separated by commas; default: the main numbers of the model.",
        show_default=False,
    ),
]
ThermoEvery = Annotated[
    int | None,
    typer.Option(
        "--thermo-every", metavar="N", min=1, help="Frames per line of --thermo; default: 1.", show_default=False
    ),
]


class ThermoTable:
    """Prints the chosen numbers of every N-th frame, with a heading at the first."""

    def __init__(self, names: Sequence[str], every: int) -> None:
        """`names` are the columns; by default those main numbers of the model that its frames have."""
        self.names, self._every = tuple(names), every
        self._widths: list[int] = []
        self._columns: list[str] = []
        self._frames = 0

    def __call__(self, model: str, frame: Frame, step: int) -> None:
        """Print the line of a frame, if it is its turn."""
        due, self._frames = self._frames % self._every == 0, self._frames + 1
        if not self._columns:
            self._columns = list(self.names) or main_numbers(model, frame)
            units = {**LEAD, **{name: frame.units.get(name, "1") for name in self._columns}}
            self._widths = [max(LEAST_WIDTH, len(name), len(unit)) for name, unit in units.items()]
            self._print(list(units))
            self._print(["" if unit == "1" else unit for unit in units.values()])
        if due:
            numbers = [frame.numbers.get(name) for name in self._columns]
            cells = ["-" if number is None else f"{number:.6g}" for number in numbers]
            self._print([str(step), f"{frame.time:.6g}", *cells])

    def _print(self, cells: Sequence[str]) -> None:
        """A line; a progress bar on the same terminal stays below it."""
        row = " ".join(f"{cell:>{width}}" for cell, width in zip(cells, self._widths, strict=True))
        echo(row.rstrip())
        sys.stdout.flush()


def thermo_table(enabled: bool, columns: str | None, every: int | None) -> ThermoTable | None:
    """The table of the options; None where no option requests it."""
    if not enabled and columns is None and every is None:
        return None
    names = [name.strip() for name in (columns or "").split(",") if name.strip()]
    return ThermoTable(names, every or 1)


def main_numbers(model: str, frame: Frame) -> list[str]:
    """The main numbers of a model that a frame has."""
    from ecume.models import MODELS

    return [name for name in MODELS[model].main_numbers if name in frame.numbers]
