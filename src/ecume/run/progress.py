"""The progress of a run: in memory, and in `status.json`; and its log."""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING, Any, NamedTuple

from ecume._plain_files import append, opened
from ecume.errors import StorageError
from ecume.run.directory import RunDirectory, owner_of, write
from ecume.run.manifest import now
from ecume.trajectories.records import clean, sealed_line, storing

if TYPE_CHECKING:
    from ecume.simulation import Moment

SETTLED = 1.0
"""Seconds of integration after which its speed is used to predict the remaining time."""
STATUS_EVERY = 1.0
"""Seconds of wall time between two replacements of `status.json`, at least."""


class Progress(NamedTuple):
    """The progress of a run in time steps, simulated time (s) and frames; `speed` is simulated time per wall time."""

    step: int
    steps: int | None
    """None while the total is unknown, for adaptive time steps."""
    time: float
    duration: float
    frames: int
    speed: float
    steps_per_second: float
    remaining: float | None
    """Predicted seconds of wall time; None while unknown."""

    @property
    def begun(self) -> bool:
        """Whether any step was taken in this session."""
        return self.speed > 0.0

    @property
    def place(self) -> str:
        """The text `at step 25 of 100`, or `at t = 0.5 s (step 25)` if the total is unknown."""
        return f"at step {self.step} of {self.steps}" if self.steps else f"at t = {self.time:.6g} s (step {self.step})"


class Pace:
    """The speed of the integration since the first steps of this process, without compilation times."""

    def __init__(self, duration: float) -> None:
        self._duration = duration
        self._start = (0.0, 0, 0.0)
        self._heard = 0
        self.integrating = 0.0
        """Seconds of wall time in time steps, without the first, for which code is read or compiled."""

    def progress(self, moment: Moment, frames: int) -> Progress:
        """The progress at this time."""
        clock = time.monotonic()
        self._heard += 1
        if self._heard <= 2:
            self._start = (moment.done, moment.taken, clock)
        done, step, began = self._start
        self.integrating = spent = clock - began
        rate = (moment.done - done) / spent if moment.done > done and spent > 0.0 else 0.0
        known = rate and spent >= SETTLED
        return Progress(
            step=moment.taken,
            steps=moment.planned,
            time=moment.done * self._duration,
            duration=self._duration,
            frames=frames,
            speed=rate * self._duration,
            steps_per_second=(moment.taken - step) / spent if rate else 0.0,
            remaining=0.0 if moment.ended else (1.0 - moment.done) / rate if known else None,
        )


class StatusFile:
    """The file `status.json`, which is replaced as a whole, at most once per second except for the last state."""

    def __init__(self, home: RunDirectory) -> None:
        self._home, self._written = home, -STATUS_EVERY
        self.last_checkpoint: int | None = None

    def write(self, state: str, progress: Progress, *, last: bool = False) -> None:
        """Write the progress of the run."""
        clock = time.monotonic()
        if not last and clock - self._written < STATUS_EVERY:
            return
        self._written = clock
        report = {"state": state, **progress._asdict(), "last_checkpoint": self.last_checkpoint, "at": now()}
        try:
            write(self._home, self._home.status, report, settled=False)
        # On Windows, while another process reads the file; it is written again within a second.
        except StorageError as error:
            if os.name != "nt" or not isinstance(error.__cause__, PermissionError):
                raise


def note(home: RunDirectory, event: str, **details: Any) -> None:
    """Add an event to the log."""
    facts = {"at": now(), "event": event, **{name: _cleaned(value) for name, value in details.items()}}
    line = sealed_line(facts, owner_of(home, home.log))
    with storing(home.log), opened(home.log, "a", home.path) as file:
        append(file, line.encode())


def _cleaned(value: Any) -> Any:
    """The details of an event without control characters, since they may quote a damaged file."""
    if isinstance(value, list | tuple):
        return [_cleaned(each) for each in value]
    return clean(value) if isinstance(value, str) else value
