"""The wall time of a command."""

from __future__ import annotations

import time

_began: list[float] = []


def start() -> None:
    """A command begins. The first of a process began with the process, which has computed ever since."""
    before = 0.0 if _began else time.process_time()
    _began[:] = [time.monotonic() - before]


def elapsed() -> float:
    """Seconds of wall time since the command began; 0 outside of commands."""
    return time.monotonic() - _began[0] if _began else 0.0
