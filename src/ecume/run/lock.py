"""Locks and signals of a run: one writer per directory, which on request completes its current steps, writes a
checkpoint and ends.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import threading
from collections.abc import Callable, Iterator, Sequence
from io import FileIO
from pathlib import Path
from types import FrameType
from typing import Any

import portalocker
import psutil

from ecume._plain_files import content_of, opened
from ecume.errors import RunExists, StorageError
from ecume.run.directory import RunDirectory, clear, has_checksums, refuse_existing
from ecume.trajectories.records import OWNER, clean, line_of, sealed_line, storing

WIDTH = 512
"""The size of the lock in bytes: more than the identification of any process needs."""
MOST_BYTES = 2**16


@contextlib.contextmanager
def held(home: RunDirectory, *, quietly: bool = False) -> Iterator[None]:
    """Hold the lock of a run directory; raise RunExists if another process holds it. The operating system releases the
    lock when the process ends in any way.

    `quietly` does not write the name of this process into the lock.
    """
    with storing(home.lock):
        file = opened(home.lock, "a+", home.path)
    with file:
        _take(home, file, quietly=quietly)
        yield


def _take(home: RunDirectory, file: FileIO, *, quietly: bool) -> None:
    try:
        portalocker.lock(file, portalocker.LockFlags.EXCLUSIVE | portalocker.LockFlags.NON_BLOCKING)
    except portalocker.exceptions.LockException as error:
        raise RunExists(f"{home.path}: is being written by {_named(owner(home))}; wait, or stop it") from error
    if quietly:
        return
    with storing(home.lock):
        # Overwrite the former owner in one write, so that no partial name can be read.
        file.write(sealed_line(_self()).encode().ljust(WIDTH))


def owner(home: RunDirectory) -> dict[str, Any] | None:
    """The process that locked the directory last, whether or not it is still running."""
    try:
        return read_owner(home)
    except (OSError, ValueError):  # Windows does not allow others to read a locked file; or the writer was killed
        return None


def read_owner(home: RunDirectory) -> dict[str, Any] | None:
    """The process that locked the directory last; None if no process has written its name. Raises ValueError if the
    file is damaged, and OSError if it cannot be read.
    """
    content = content_of(home.lock, MOST_BYTES, home.path)
    if not content:
        return None
    if not has_checksums(home):
        return line_of(content.rstrip() + b"\n", OWNER, checked=False)
    if len(content) != WIDTH:
        raise ValueError(f"has {len(content)} bytes; expected {WIDTH}")
    return line_of(content.rstrip(b" "), OWNER, checked=True)


def require_free(home: RunDirectory) -> None:
    """Raise RunExists while a process writes the run, without writing anything."""
    if not home.lock.exists():
        return
    with storing(home.lock), opened(home.lock, "r", home.path) as file:
        try:
            portalocker.lock(file, portalocker.LockFlags.SHARED | portalocker.LockFlags.NON_BLOCKING)
        except portalocker.exceptions.LockException as error:
            raise RunExists(f"{home.path}: is being written by {_named(owner(home))}; wait, or stop it") from error


def put_in_place(complete: RunDirectory, home: RunDirectory, *, force: bool) -> None:
    """Move a complete run from a neighboring directory to its final position, the manifest last; with `force` it
    replaces an existing run.
    """
    with storing(home.path):
        home.path.mkdir(parents=True, exist_ok=True)
    with held(home):
        refuse_existing(home, force=force)
        clear(home)
        for part in complete.parts():
            if part.exists():
                with storing(home.path / part.name):
                    part.rename(home.path / part.name)


def stop(home: RunDirectory) -> bool:
    """Request that the process that writes the run write a checkpoint and end; return False if there is no such
    process.

    The name in the lock may be outdated. A signal is sent only to a process that has the lock open while it is held.
    """
    process = owner(home)
    if process is None or process["host"] != clean(socket.gethostname()) or not _has_open(process, home):
        return False
    try:
        with held(home, quietly=True):
            return False
    except RunExists:
        ask_to_stop(process["pid"])
        return True


def is_held(home: RunDirectory) -> bool:
    """Whether a process holds the lock of the run. If a process on another machine locked it last,
    this is assumed.

    Only the lock itself is reliable: process numbers are reused, and clocks may be changed.
    """
    process = owner(home)
    if process is not None and process["host"] != clean(socket.gethostname()):
        return True
    try:
        require_free(home)
    except RunExists:
        return True
    except StorageError:  # Windows, where others cannot open a locked file
        return os.name == "nt"
    return False


def _has_open(process: dict[str, Any], home: RunDirectory) -> bool:
    """Whether a process of this machine is running and has the lock open, as far as the operating system reports it."""
    try:
        found = psutil.Process(process["pid"])
        if os.name == "nt":  # on Windows open files are not listed reliably
            return bool(abs(found.create_time() - process["began"]) < 2.0)
        lock = home.lock.stat()
        return any(
            os.path.samestat(lock, Path(file.path).stat()) for file in found.open_files() if Path(file.path).exists()
        )
    except (psutil.NoSuchProcess, psutil.AccessDenied, OSError):
        return False


def _self() -> dict[str, Any]:
    began = psutil.Process().create_time()
    return {"pid": os.getpid(), "host": clean(socket.gethostname()), "began": began}


def _named(process: dict[str, Any] | None) -> str:
    return f"process {process['pid']} on {process['host']}" if process else "another process"


SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGUSR1", "SIGBREAK") if hasattr(signal, name))
"""The signals that request a stop: Ctrl-C, termination and the advance warning of batch systems, and those of Windows;
not every system has all of them.
"""

Handler = Callable[[int, FrameType | None], object] | signal.Handlers
PATIENT = tuple(number for number in SIGNALS if number.name in ("SIGTERM", "SIGUSR1"))
"""The signals of batch systems. Before the integration has begun only these wait for a checkpoint: a user who presses
Ctrl-C while laws are compiled has nothing to lose.
"""


def ask_to_stop(process: int) -> None:
    """Request that the process of a run, which may be this one, write a checkpoint and end."""
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
    """Handle signals inside this block, and restore the handlers after it. Only the main thread can do this; in other
    threads nothing changes.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    # None means a handler that was not installed from Python, such as that of faulthandler, and cannot be restored.
    before = {number: signal.signal(number, handler) for number in signals if signal.getsignal(number) is not None}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


@contextlib.contextmanager
def stop_requests(
    signals: Sequence[signal.Signals] = SIGNALS, request: StopRequest | None = None
) -> Iterator[StopRequest]:
    """Collect requests to stop inside this block, also earlier ones. Only the main thread receives signals."""
    request = StopRequest() if request is None else request
    with handled(request.take, signals):
        yield request
