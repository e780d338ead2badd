"""The runner of a sweep: all missing points, one after the other or on many workers."""

from __future__ import annotations

import os
import signal
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from types import FrameType
from typing import NamedTuple

from ecume.errors import Stopped
from ecume.run.lock import handled
from ecume.sweep.directory import Job, Sweeping, begun_or_laid_out, distinct
from ecume.sweep.executors import ExecutorOptions, hands
from ecume.sweep.results import require_numbers, write_table


class Outcome(NamedTuple):
    """The outcome of a sweep."""

    directory: Path
    done: int
    failed: list[tuple[Path, str]]
    """folders, and why"""
    busy: int
    """points that another process is working on"""
    lost: int = 0
    """points that were begun again and again, and whose worker died each time"""


USUAL = ExecutorOptions()


def sweep(file: str | os.PathLike[str], directory: str | os.PathLike[str], options: ExecutorOptions = USUAL) -> Outcome:
    """Run the missing points of a sweep and write its table. After any interruption the same call continues.

    Raises Stopped after a signal: the same call continues.
    """
    sweeping = begun_or_laid_out(Path(file), Path(directory))
    jobs = distinct(sweeping.jobs)
    missing = [job for job in jobs if job.state != "done"]
    if missing:
        require_numbers(sweeping)
    try:
        with handled(_stop):
            words = _worked(options, sweeping, missing)
    except Stopped as stopped:
        done = sum(job.state == "done" for job in jobs)
        why = str(stopped).partition(" at step ")[0].partition(";")[0]
        raise Stopped(f"{why}; {done} of {len(jobs)} points are done; the same command continues") from stopped
    write_table(sweeping)
    return outcome_of(sweeping)._replace(busy=words["busy"], lost=words["lost"])


def _worked(options: ExecutorOptions, sweeping: Sweeping, missing: Sequence[Job]) -> Counter[str]:
    """Run these points, and tell what becomes of them; how many ended with which word."""
    words: Counter[str] = Counter()
    count = len(distinct(sweeping.jobs))
    report = options.progress or (lambda done, of: None)
    with hands(options, sweeping, len(missing)) as results:
        report(count - len(missing), count)
        for job, word in results(missing):
            words[word] += 1
            if word == "failed" and options.failed is not None:
                options.failed(job.folder, job.why)
            report(count - len(missing) + words.total(), count)
    return words


def _stop(number: int, _: FrameType | None) -> None:
    raise Stopped(f"stopped by {signal.Signals(number).name}")


def outcome_of(sweeping: Sweeping) -> Outcome:
    """The present state of a sweep, as an outcome."""
    jobs = distinct(sweeping.jobs)
    failed = [(job.folder, job.why) for job in jobs if job.state == "failed"]
    return Outcome(sweeping.path, sum(job.state == "done" for job in jobs), failed, 0)
