"""Information about a run from outside, whatever became of it."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from ecume._hooks import html_of
from ecume.errors import StorageError
from ecume.run.directory import RunDirectory, existing, manifest_of, read
from ecume.run.invariant_monitor import summary_line as watched
from ecume.run.lock import held, is_held
from ecume.run.recovery import mended
from ecume.trajectories.durable_files import storing
from ecume.trajectories.reader import Trajectory
from ecume.trajectories.records import FAILED, STATUS
from ecume.trajectories.repair import Repaired

T = TypeVar("T")


class Info(NamedTuple):
    """A run as it stands: `state` is running, killed, stopped, interrupted, failed or done."""

    directory: Path
    state: str
    why: str
    """What went wrong, and what cures it; or nothing."""
    step: int
    """Time steps taken."""
    steps: int | None
    """Time steps of the whole run; None while that is unknown."""
    time: float
    """Simulated so far, s."""
    duration: float
    frames: int
    """On disk."""
    checkpoint: int | None
    """The step of the newest checkpoint."""
    size: int
    """Bytes on disk."""
    remaining: float | None
    """Seconds of wall time until it is done, while it runs."""
    manifest: dict[str, Any]
    watch: str = ""
    """Whether what must hold has held, in a line."""

    def _repr_html_(self) -> str | None:
        """The notebook view: the player of `ecume view`, in at most 4 MB."""
        return html_of(self.directory)


def info(directory: str | os.PathLike[str]) -> Info:
    """Information about a run; also while it is written, and after it was killed."""
    home = existing(directory)
    unsaid: dict[str, Any] = {}
    status, no_status = _read(lambda: _status(home), unsaid, home)
    watch, no_watch = _read(lambda: watched(home), "", home)
    frames, no_frames = _frames(home)
    state, reason = _state(home, status)
    return Info(
        directory=home.path,
        state=state,
        why="; ".join(part for part in (no_status, no_watch, no_frames, reason) if part),
        step=int(status.get("step", 0)),
        steps=status.get("steps"),
        time=float(status.get("time", 0.0)),
        duration=float(status.get("duration", 0.0)),
        frames=frames,
        checkpoint=_newest_step(home),
        size=_size(home),
        remaining=status.get("remaining") if state == "running" else None,
        manifest=manifest_of(home),
        watch=watch,
    )


def repair(directory: str | os.PathLike[str]) -> Repaired:
    """Make what is left of a damaged run readable: whole frames stay, each damaged one is named; files beside them are
    made again or set aside.
    """
    home = existing(directory)
    with held(home):
        return mended(home)


def _read(what: Callable[[], T], otherwise: T, home: RunDirectory) -> tuple[T, str]:
    """A part of the run's own records, or a default and the reason where that part is damaged."""
    try:
        return what(), ""
    except StorageError as error:
        return otherwise, f"{error}; `ecume repair {home.path}` sets it aside"


def _state(home: RunDirectory, status: dict[str, Any]) -> tuple[str, str]:
    """The state of the run, and the reason for it."""
    if home.done.exists():
        return "done", ""
    if home.failed.exists():
        return "failed", _why_failed(home)
    state = str(status.get("state", "running"))
    if state == "running":
        state = "running" if is_held(home) else "killed"
    return state, "" if state == "running" else f"to continue: ecume resume {home.path}"


def _why_failed(home: RunDirectory) -> str:
    try:
        return str(read(home, home.failed, FAILED).get("message", ""))
    except StorageError as error:
        return f"{error}; `ecume repair {home.path}` sets it aside"


def _status(home: RunDirectory) -> dict[str, Any]:
    """The contents of the status file; empty for a run that was killed before it wrote one."""
    return read(home, home.status, STATUS) if home.status.exists() else {}


def _frames(home: RunDirectory) -> tuple[int, str]:
    try:
        with Trajectory(home.trajectory) as trajectory:
            return len(trajectory), ""
    except StorageError as error:
        return 0, f"{error}; `ecume repair {home.path}` keeps what is whole"


def _size(home: RunDirectory) -> int:
    """The size of all files; those that a process removes meanwhile have none."""
    size = 0
    for path in home.path.rglob("*"):
        with contextlib.suppress(FileNotFoundError):
            size += path.lstat().st_size if path.is_file() else 0
    return size


def _newest_step(home: RunDirectory) -> int | None:
    with storing(home.checkpoints):
        steps = [int(path.stem) for path in home.checkpoints.glob("*.npz") if path.stem.isdecimal()]
    return max(steps, default=None)
