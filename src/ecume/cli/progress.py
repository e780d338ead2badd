"""Progress reports: a bar on a terminal, a plain line now and then in a log, or the table of numbers of `--thermo`."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from ecume._compiler_events import watch

if TYPE_CHECKING:
    from ecume.run.progress import Progress
    from ecume.trajectories.frame import Frame


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
            typer.echo(expectation(progress), err=True)
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
            typer.echo(said, err=True)


class Lines:
    """A plain line every ten seconds."""

    def __init__(self) -> None:
        self._last = time.monotonic()

    def __call__(self, progress: Progress) -> None:
        """Say how far it is, if it is time to."""
        now = time.monotonic()
        if now - self._last >= LINE_EVERY:
            self._last = now
            typer.echo(line(progress), err=True)


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
        sys.stdout.write(f"{row.rstrip()}\n")
        sys.stdout.flush()


def thermo_table(wanted: bool, columns: str | None, every: int | None) -> ThermoTable | None:
    """The table of the options; None where no option requests it."""
    if not wanted and columns is None and every is None:
        return None
    names = [name.strip() for name in (columns or "").split(",") if name.strip()]
    return ThermoTable(names, every or 1)


def main_numbers(model: str, frame: Frame) -> list[str]:
    """The main numbers of a model that a frame has."""
    from ecume.models import MODELS

    return [name for name in MODELS[model].main_numbers if name in frame.numbers]
