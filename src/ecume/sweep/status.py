"""The status of a sweep, seen from outside: from the files alone."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from ecume.run.directory import RunDirectory
from ecume.run.lock import is_held
from ecume.sweep.directory import Job, distinct, existing_sweep

RECENT = 50
"""The number of last points whose rate is reported."""
SILENT = 10.0
"""Factor over the usual time between two points, and seconds: without a new point for longer, no worker is active."""


class Standing(NamedTuple):
    """The number of points in each state."""

    done: int
    failed: list[tuple[Path, str]]
    """folders, and why"""
    running: int
    """runs that a process holds; what processes such as `t1` do is not seen from outside"""
    missing: int
    remaining: float | None
    """s, until all are done; None where that is not known"""


def standing(directory: Path) -> Standing:
    """The status of a sweep. Raises BadInput if it does not exist."""
    jobs = distinct(existing_sweep(directory).jobs)
    states = [job.state for job in jobs]
    failed = [(job.folder, job.why) for job, state in zip(jobs, states, strict=True) if state == "failed"]
    waiting = [job for job, state in zip(jobs, states, strict=True) if state == "missing"]
    running = sum(is_held(RunDirectory(job.run)) for job in waiting)
    ended = sorted(_ended(job) for job, state in zip(jobs, states, strict=True) if state == "done")
    return Standing(len(ended), failed, running, len(waiting) - running, remaining(ended, len(waiting), time.time()))


def _ended(job: Job) -> float:
    """The time at which a point was completed."""
    marker = job.result if job.result.exists() else RunDirectory(job.run).done
    return marker.stat().st_mtime


def remaining(ended: Sequence[float], waiting: int, now: float) -> float | None:
    """The time that so many points take at the pace of those completed last (s).

    >>> remaining([0.0, 10.0, 20.0], waiting=6, now=24.0)
    72.0
    """
    recent = ended[-RECENT:]
    if not waiting or len(recent) < 2:
        return None
    usual = (recent[-1] - recent[0]) / (len(recent) - 1)
    if now - recent[-1] > SILENT * (1.0 + usual):
        return None
    return waiting * (now - recent[0]) / (len(recent) - 1)
