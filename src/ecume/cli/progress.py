"""The progress of a command: a bar on a terminal, or plain lines in a log."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ecume._compiler_events import watch

if TYPE_CHECKING:
    from rich.text import Text

    from ecume.run.progress import Progress
from ecume.cli.output import echo

_began: list[float] = []


def start() -> None:
    """Start the clock of a command. For the first command of a process, this includes the processor time since the
    process began.
    """
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
    """The reporter of a run's progress: nothing, a bar, or lines on stderr."""
    if quiet:
        yield None
    elif sys.stderr.isatty():
        with _bar() as reporter:
            yield WithExpectation(reporter)
    else:
        yield WithExpectation(Lines())


class WithExpectation:
    """A reporter whose first line is the expected duration of the run, as soon as steps have been timed."""

    def __init__(self, report: Reporter) -> None:
        self._report, self._said = report, False

    def __call__(self, progress: Progress) -> None:
        """Report the progress, once after the expected duration."""
        if not self._said and progress.remaining:
            self._said = True
            echo(expectation(progress), err=True)
        self._report(progress)


def expectation(progress: Progress) -> str:
    """The expected number of steps and duration: `30000 steps, about 4 min`."""
    steps = f"{progress.steps} steps" if progress.steps else "adaptive steps"
    return f"{steps}, about {lasting(progress.remaining or 0.0)}"


@contextmanager
def _bar() -> Iterator[Reporter]:
    from rich.console import Console
    from rich.progress import BarColumn, ProgressColumn, Task
    from rich.progress import Progress as Bars
    from rich.text import Text

    class Doing(ProgressColumn):
        """The activity before the first step, then the description of the task."""

        def render(self, task: Task) -> Text:
            return Text(task.description or waiting())

    # ecume estimates the remaining time: Rich would count compilation as slow integration.
    columns, console = (BarColumn(), Doing()), Console(stderr=True)
    # Redirect standard output only if it is the same terminal, so that its lines appear above the bar.
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
    """A reporter of the number of completed items, `12 of 300 points, 4 min left`: a bar on a terminal, plain lines
    elsewhere if requested.
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

    # ecume estimates the remaining time: Rich uses only the last half minute.
    with Bars(BarColumn(), TextColumn("{task.description}"), console=Console(stderr=True), transient=True) as bars:
        bar = bars.add_task(pace.what, total=None)
        yield lambda done, of: bars.update(bar, total=of, completed=done, description=pace(done, of))


class Pace:
    """The number of completed items, and the remaining time at the mean rate since the first report."""

    def __init__(self, what: str) -> None:
        self.what = what
        self._first: tuple[float, int] | None = None

    def __call__(self, done: int, of: int) -> str:
        """The text of a report: `12 of 300 points, 4 min left`."""
        now = time.monotonic()
        since, before = self._first = self._first or (now, done)
        left = f", {lasting((of - done) * (now - since) / (done - before))} left" if before < done < of else ""
        return f"{done} of {of} {self.what}{left}"


class CountLines:
    """A reporter that prints a plain line every ten seconds if items were completed."""

    def __init__(self, pace: Pace) -> None:
        self._pace = pace
        self._last = time.monotonic()

    def __call__(self, done: int, of: int) -> None:
        """Print the number of completed items if a line is due."""
        said, now = self._pace(done, of), time.monotonic()
        if now - self._last >= LINE_EVERY:
            self._last = now
            echo(said, err=True)


class Lines:
    """A reporter that prints a plain line every ten seconds."""

    def __init__(self) -> None:
        self._last = time.monotonic()

    def __call__(self, progress: Progress) -> None:
        """Print the progress if a line is due."""
        now = time.monotonic()
        if now - self._last >= LINE_EVERY:
            self._last = now
            echo(line(progress), err=True)


def line(progress: Progress) -> str:
    """The progress line, `12.35 s of 20 s, 3.1 x real time, 2.5 s left`, without quantities that are still unknown."""
    return ", ".join(part for part in (place(progress), ahead(progress.remaining)) if part)


def waiting() -> str:
    """The activity of a run before its first step, as a text."""
    return "compiling" if watch.compiling else "setting up"


def place(progress: Progress) -> str:
    """Simulated time and speed: `12.35 s of 20 s, 3.1 x real time`."""
    speed = f", {progress.speed:.3g} x real time" if progress.speed else ""
    return f"{progress.time:.4g} s of {progress.duration:.4g} s{speed}"


def ahead(remaining: float | None) -> str:
    """The remaining time, `4 min left`; empty while it is unknown."""
    return "" if remaining is None else f"{lasting(remaining)} left"


def lasting(seconds: float) -> str:
    """A wall time as a text: `12 s`, `4 min`, `3.5 h`."""
    for unit, size, below in (("s", 1.0, 100.0), ("min", 60.0, 100.0), ("h", 3600.0, 48.0)):
        if seconds < size * below:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 86400.0:.3g} days"
