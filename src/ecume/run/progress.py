"""The progress of a run: for people, for machines (`status.json`), and for later (`log.jsonl`)."""

from __future__ import annotations

import json
import time
from typing import Any, NamedTuple

from ecume.run.directory import RunDirectory, as_json
from ecume.run.manifest import now
from ecume.trajectories.durable_files import storing

SETTLED = 1.0
"""Seconds of marching after which its speed tells how long the rest takes."""
STATUS_EVERY = 1.0
"""Seconds of wall time between two replacements of `status.json`, at least."""


class Progress(NamedTuple):
    """The progress of a run in steps, simulated time (s) and frames; `speed` is simulated time per wall time."""

    step: int
    steps: int
    time: float
    duration: float
    frames: int
    speed: float
    steps_per_second: float
    remaining: float | None
    """Seconds of wall time; None while nothing is known."""


class Pace:
    """The speed of the integration since the first steps of this process, without the time spent compiling."""

    def __init__(self, duration: float) -> None:
        self._duration = duration
        self._start = (0, 0.0)
        self._heard = 0

    def progress(self, step: int, steps: int, frames: int) -> Progress:
        """The progress at this step."""
        clock = time.monotonic()
        self._heard += 1
        if self._heard <= 2:
            self._start = (step, clock)
        first, began = self._start
        rate = (step - first) / (clock - began) if step > first and clock > began else 0.0
        done = step / steps if steps else 1.0
        known = rate and clock - began >= SETTLED
        remaining = 0.0 if step >= steps else (steps - step) / rate if known else None
        speed = rate * self._duration / steps if steps else 0.0
        return Progress(step, steps, done * self._duration, self._duration, frames, speed, rate, remaining)


class StatusFile:
    """`status.json`: replaced as a whole, at most once a second, whatever its state but the last."""

    def __init__(self, home: RunDirectory) -> None:
        self._home, self._written = home, -STATUS_EVERY
        self.last_checkpoint: int | None = None

    def write(self, state: str, progress: Progress, *, last: bool = False) -> None:
        """Write how far the run is."""
        clock = time.monotonic()
        if not last and clock - self._written < STATUS_EVERY:
            return
        self._written = clock
        report = {"state": state, **progress._asdict(), "last_checkpoint": self.last_checkpoint, "at": now()}
        part = self._home.status.with_name("status.json.part")
        with storing(self._home.status):
            part.write_text(as_json(report))
            try:
                part.replace(self._home.status)
            except PermissionError:  # Windows, while somebody reads it: the next second is soon enough
                part.unlink(missing_ok=True)


def note(home: RunDirectory, event: str, **details: Any) -> None:
    """Add an event to the log."""
    line = json.dumps({"at": now(), "event": event, **details}) + "\n"
    with storing(home.log), home.log.open("a") as file:
        file.write(line)
