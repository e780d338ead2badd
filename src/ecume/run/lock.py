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
from ecume.trajectories.durable_files import storing

WIDTH = 512
"""Bytes of the lock: more than any process needs to say who it is."""


@contextlib.contextmanager
def held(home: RunDirectory) -> Iterator[None]:
    """Hold a run directory; RunExists when another process does. The system lets go of it however the process ends."""
    with storing(home.lock):
        home.lock.touch()
        file = home.lock.open("r+b", buffering=0)
    with file:
        _take(home, file)
        yield


def _take(home: RunDirectory, file: FileIO) -> None:
    try:
        portalocker.lock(file, portalocker.LockFlags.EXCLUSIVE | portalocker.LockFlags.NON_BLOCKING)
    except portalocker.exceptions.LockException as error:
        raise RunExists(f"{home.path}: is being written by {_named(owner(home))}; wait, or stop it") from error
    with storing(home.lock):
        file.write(json.dumps(_self()).encode().ljust(WIDTH))  # over the former owner in one go: never half a name


def owner(home: RunDirectory) -> dict[str, Any] | None:
    """The process that locked the directory last, whether or not it still lives."""
    try:
        plain = json.loads(home.lock.read_bytes())
    except (OSError, ValueError):  # Windows does not let others read a locked file; or the writer died
        return None
    return plain if isinstance(plain, dict) and {"pid", "host", "began"} <= plain.keys() else None


def is_held(home: RunDirectory) -> bool:
    """Whether the process that locked the directory last still runs; one on another machine is believed to."""
    if (process := owner(home)) is None:
        return os.name == "nt" and home.lock.exists()
    return process["host"] != socket.gethostname() or _is_alive(process)


def _is_alive(process: dict[str, Any]) -> bool:
    try:
        found = psutil.Process(process["pid"])
        same = abs(found.create_time() - process["began"]) < 2.0
        return bool(same and found.status() != psutil.STATUS_ZOMBIE)
    except psutil.NoSuchProcess:
        return False
    except psutil.AccessDenied:  # it runs, and belongs to another user
        return True


def _self() -> dict[str, Any]:
    began = psutil.Process().create_time()
    return {"pid": os.getpid(), "host": socket.gethostname(), "began": began}


def _named(process: dict[str, Any] | None) -> str:
    return f"process {process['pid']} on {process['host']}" if process else "another process"
