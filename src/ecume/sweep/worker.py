"""One point in any process: a worker gets the name of a folder, and returns a short answer."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ecume.errors import EcumeError, RunExists, Stopped
from ecume.sweep.directory import Job, json_at
from ecume.sweep.points import Point
from ecume.trajectories.durable_files import storing, write_whole

if TYPE_CHECKING:
    from ecume.models.model import Engine

THREADS = 1
"""Of each run: many runs share the machine."""


def work(folder: str) -> str:
    """Simulate a point from where it stands; `done`, `failed`, or `busy` where another process has it."""
    job = Job(Point({}, 0), Path(folder), {})
    if job.state == "done":
        return "done"
    plan = json_at(job.asked, dict)
    with storing(job.failure):
        job.failure.unlink(missing_ok=True)
    try:
        if "process" in plan:
            _process(job, plan)
        else:
            _scene(job, plan)
    except RunExists:
        return "busy"
    except Stopped:
        raise
    except Exception as error:  # whatever it is, the other points go on
        _record_failure(job, error)
        return "failed"
    return "done"


def _record_failure(job: Job, error: Exception) -> None:
    """Keep in a line why a point failed; what is no answer to a user is named by its kind."""
    kind, why = type(error).__name__, " ".join(str(error).split())
    result = {"why": why if isinstance(error, EcumeError) else f"{kind}: {why}", "kind": kind}
    write_whole(job.failure, json.dumps(result), job.folder)


def _process(job: Job, plan: dict[str, object]) -> None:
    from ecume.sweep.processes import results_of

    result = results_of(str(plan["process"]), dict(plan["settings"]))  # type: ignore[call-overload]
    with storing(job.result):
        write_whole(job.result, json.dumps(result), job.folder)


def _scene(job: Job, plan: dict[str, object]) -> None:
    from ecume.run import RunOptions, resume, run
    from ecume.scenes.schema import from_plain

    with engine_of(plan) as engine:
        options = RunOptions(threads=THREADS, engine=engine)
        if (job.run / "manifest.json").exists():
            resume(job.run, options=options)
        else:
            run(from_plain(plan["scene"]), job.run, force=job.run.exists(), options=options)  # type: ignore[arg-type]


@contextlib.contextmanager
def engine_of(plan: Mapping[str, Any]) -> Iterator[Engine | None]:
    """The engine of a point. Raises BadInput where it is missing."""
    if "engine" not in plan:
        yield None
        return
    from ecume.lammps.engine import lammps_engine

    with lammps_engine(plan["ranks"]) as engine:
        yield engine
