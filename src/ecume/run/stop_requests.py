"""Signals: a run that receives one finishes its current steps and writes a checkpoint."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from types import FrameType

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGUSR1", "SIGBREAK") if hasattr(signal, name))
"""Ctrl-C, the batch system's farewell, its warning beforehand, and Windows' own; not every system has each."""

Handler = Callable[[int, FrameType | None], object] | signal.Handlers
PATIENT = tuple(number for number in SIGNALS if number.name in ("SIGTERM", "SIGUSR1"))
"""The signals of batch systems. Before the integration has begun only these wait for a checkpoint: a user who presses
Ctrl-C while laws are compiled has nothing to lose.
"""


def ask_to_stop(process: int) -> None:
    """Ask the process of a run, which may be this one, to leave a checkpoint and end."""
    os.kill(process, signal.SIGTERM)


class StopRequest:
    """The signal that requested a stop, if any."""

    def __init__(self) -> None:
        self.signal: signal.Signals | None = None

    def __bool__(self) -> bool:
        return self.signal is not None

    @property
    def name(self) -> str:
        """The name of the signal."""
        return self.signal.name if self.signal else "none"

    def take(self, number: int, _: FrameType | None) -> None:
        """Note the signal. A second Ctrl-C stops at once."""
        self.signal = signal.Signals(number)
        if self.signal is signal.SIGINT:
            signal.signal(signal.SIGINT, signal.default_int_handler)


@contextlib.contextmanager
def handled(handler: Handler, signals: Sequence[signal.Signals] = SIGNALS) -> Iterator[None]:
    """Handle signals inside this block, and as before after it. Only the main thread can: elsewhere nothing changes."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, handler) for number in signals}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


@contextlib.contextmanager
def stop_requests(
    signals: Sequence[signal.Signals] = SIGNALS, request: StopRequest | None = None
) -> Iterator[StopRequest]:
    """Collect requests to stop inside this block, or from before it. Only the main thread receives signals."""
    request = StopRequest() if request is None else request
    with handled(request.take, signals):
        yield request
