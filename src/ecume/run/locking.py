"""One writer a run directory."""

from __future__ import annotations

import contextlib
import json
import os
import socket
from collections.abc import Iterator
from io import FileIO
from typing import Any

import portalocker
import psutil

from ecume.errors import RunExists
from ecume.run.directory import RunDirectory
from ecume.trajectories.durable import storing


@contextlib.contextmanager
def held(home: RunDirectory) -> Iterator[None]:
    """Hold a run directory; RunExists when another process does. The system lets go of it however the process ends."""
    with storing(home.lock):
        file = home.lock.open("a+b", buffering=0)
    with file:
        _take(home, file)
        yield


def _take(home: RunDirectory, file: FileIO) -> None:
    try:
        portalocker.lock(file, portalocker.LockFlags.EXCLUSIVE | portalocker.LockFlags.NON_BLOCKING)
    except portalocker.exceptions.LockException as error:
        raise RunExists(f"{home.path}: is being written by {_named(owner(home))}; wait, or stop it") from error
    with storing(home.lock):
        file.truncate(0)
        file.write(json.dumps(_self()).encode())


def owner(home: RunDirectory) -> dict[str, Any] | None:
    """The process that locked the directory last, whether or not it still lives."""
    try:
        plain = json.loads(home.lock.read_bytes())
    except (OSError, ValueError):  # Windows lets nobody read what is locked; a process may have died while it wrote
        return None
    return plain if isinstance(plain, dict) and {"pid", "host", "began"} <= plain.keys() else None


def is_alive(process: dict[str, Any]) -> bool:
    """Whether that process still runs; one on another machine is believed to."""
    if process["host"] != socket.gethostname():
        return True
    try:
        return bool(abs(psutil.Process(process["pid"]).create_time() - process["began"]) < 2.0)
    except psutil.NoSuchProcess:
        return False
    except psutil.AccessDenied:  # it lives, and is somebody else's
        return True


def _self() -> dict[str, Any]:
    began = psutil.Process().create_time()
    return {"pid": os.getpid(), "host": socket.gethostname(), "began": began}


def _named(process: dict[str, Any] | None) -> str:
    return f"process {process['pid']} on {process['host']}" if process else "another process"
