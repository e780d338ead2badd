"""The executors of a sweep's points, and the worker that runs one point in any process.

Points run in this process, in Dask workers on this machine or of a running scheduler, in SLURM jobs, or in the tasks of
a SLURM job array.
"""

from __future__ import annotations

import contextlib
import logging
import os
import re
import shlex
import signal
import sys
from asyncio import CancelledError
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ecume.errors import BadInput, EcumeError, RunExists, Stopped, beside_ecume, install
from ecume.run.lock import handled
from ecume.scenes.faults import echo
from ecume.sweep.directory import Job, Sweeping, json_at, written
from ecume.sweep.spec import Cluster, Point
from ecume.trajectories.records import storing, write_whole

if TYPE_CHECKING:
    from ecume.models.model import Engine


THREADS = 1
"""The number of threads of each run, since many runs share the machine."""


def work(folder: str, laws: Sequence[str] = ()) -> str:
    """Simulate or resume a point. Returns `done`, `failed`, or `busy` if another process has locked it. `laws` are
    files of user-defined laws.
    """
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
            _scene(job, plan, laws)
    except RunExists:
        return "busy"
    except Stopped:
        raise
    except Exception as error:  # the other points continue after any error
        _record_failure(job, error)
        return "failed"
    return "done"


def _record_failure(job: Job, error: Exception) -> None:
    """Record the reason of a failed point in one line; for unexpected errors, with their type."""
    kind, why = type(error).__name__, " ".join(str(error).split())
    result = {"why": why if isinstance(error, EcumeError) else f"{kind}: {why}", "kind": kind}
    write_whole(job.failure, written(result, job.failure), job.folder)


def _process(job: Job, plan: dict[str, object]) -> None:
    from ecume.sweep.spec import results_of

    result = results_of(str(plan["process"]), dict(plan["settings"]))  # type: ignore[call-overload]
    with storing(job.result):
        write_whole(job.result, written(result, job.result), job.folder)


def _scene(job: Job, plan: dict[str, object], laws: Sequence[str]) -> None:
    from ecume.run import RunOptions, resume, run
    from ecume.run.user_code import laws_from
    from ecume.scenes.schema import from_plain

    own = laws_from(laws)
    with engine_of(plan) as engine:
        options = RunOptions(threads=THREADS, engine=engine, until=str(plan.get("until", "")))
        if (job.run / "manifest.json").exists():
            resume(job.run, extra_laws=own, options=options)
        else:
            scene = from_plain(plan["scene"])  # type: ignore[arg-type]
            run(scene, job.run, extra_laws=own, force=job.run.exists(), options=options)


@contextlib.contextmanager
def engine_of(plan: Mapping[str, Any]) -> Iterator[Engine | None]:
    """The engine of a point. Raises BadInput if it is not installed."""
    if "engine" not in plan:
        yield None
        return
    with beside_ecume():
        from ecume_lammps.engine import lammps_engine
    with lammps_engine(plan["ranks"]) as engine:
        yield engine


ONE_THREAD = {"NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
"""The environment of a worker with one thread; there are as many workers as cores."""
BEFORE_THE_END = 300
"""A worker starts no points in the last BEFORE_THE_END seconds of its job."""

WAIT = "10 s"
"""The longest time to the first answer of a scheduler."""
UNWATCHED = {"distributed.worker.profile.enabled": False}
"""Disables the profiler of Dask's threads, whose dashboard is not used here; workers inherit the setting."""


@dataclass(frozen=True, kw_only=True)
class ExecutorOptions:
    """The executor of a sweep, and the functions to which it reports."""

    workers: int | None = None
    """default: one per core; 1 works in this process and needs no Dask"""
    scheduler: str | None = None
    """the address of a running Dask scheduler"""
    slurm: bool = False
    """workers are jobs of SLURM"""
    retries: int = 2
    """of a point after its worker died"""
    progress: Callable[[int, int], None] | None = None
    """receives the number of finished points and their total"""
    failed: Callable[[Path, str], None] | None = None
    """receives each failed point and its cause, while the others continue"""
    laws: tuple[str, ...] = ()
    """files of user-defined laws, as absolute paths: `FILE.py` or `FILE.py:NAME`"""


Results = Callable[[Sequence[Job]], Iterator[tuple[Job, str]]]
"""A function from jobs to pairs of a job and its outcome, in the order of completion."""


@contextlib.contextmanager
def executor(options: ExecutorOptions, sweeping: Sweeping, missing: int) -> Iterator[Results]:
    """The function that runs jobs with an executor and yields each job with its outcome."""
    cores = (os.cpu_count() or 1) // sweeping.spec.ranks
    workers = min(options.workers or max(cores, 1), max(missing, 1))
    if not missing:
        yield lambda jobs: iter(())
    elif options.scheduler is None and not options.slurm and workers == 1:
        yield lambda jobs: ((job, work(str(job.folder), options.laws)) for job in jobs)
    else:
        with _client(options, sweeping, workers) as client:
            yield lambda jobs: _spread(client, jobs, options)


def _spread(client: Any, jobs: Sequence[Job], options: ExecutorOptions) -> Iterator[tuple[Job, str]]:
    """Run the jobs on the workers of a Dask client. Each worker receives the name of a folder and
    returns an outcome.
    """
    import distributed

    library: Any = distributed  # the library has no type annotations
    folders = {str(job.folder.resolve()): job for job in jobs}
    kept = {"retries": options.retries, "pure": False}
    futures = {client.submit(work, folder, options.laws, **kept): job for folder, job in folders.items()}
    ended = library.as_completed(list(futures))
    while (next_one := next_outcome(ended)) is not None:
        future, word = next_one
        yield futures[future], word


def next_outcome(ended: Iterator[Any]) -> tuple[Any, str] | None:
    """The next job that ended, and its outcome; None after the last. Raises Stopped if the
    scheduler does not answer.

    Errors of jobs are part of their outcome. Any other exception means that the connection to the scheduler is lost,
    for which Dask has several exceptions.
    """
    try:
        future = next(ended, None)
        if future is None:
            return None
        lost = not future.cancelled() and future.exception() is not None
        return future, "lost" if lost else str(future.result())
    except Stopped:  # a signal stops the sweep
        raise
    except (Exception, CancelledError) as error:
        raise Stopped("lost the scheduler; finished points are kept; the same command continues the sweep") from error


@contextlib.contextmanager
def _client(options: ExecutorOptions, sweeping: Sweeping, workers: int) -> Iterator[Any]:
    try:
        import dask.config
        import distributed
    except ImportError as error:
        raise BadInput(f"many workers need Dask, which is not installed: {install('sweep')}, or --workers 1") from error
    library: Any = distributed  # the library has no type annotations
    for name in ("distributed", "distributed.client"):  # ecume reports failures itself, in one line
        logging.getLogger(name).setLevel(logging.CRITICAL)
    if options.scheduler is not None:
        require_safe(options.scheduler)
        with connected(library, options.scheduler) as client:
            yield client
    elif options.slurm:
        spec = sweeping.spec
        with slurm_cluster(spec.cluster, sweeping.path, spec.ranks) as found, library.Client(found) as client:
            yield client
    else:
        # The scheduler always has a dashboard: with port 0, simultaneous sweeps do not compete for a port.
        page = {"dashboard": False, "dashboard_address": "127.0.0.1:0"}
        local = {"threads_per_worker": 1, "scheduler_kwargs": page, "env": ONE_THREAD, "silence_logs": 50}
        with dask.config.set(UNWATCHED):
            # Ctrl-C reaches all processes of a terminal. Workers ignore it, since this process ends them.
            with handled(signal.SIG_IGN, (signal.SIGINT,)):
                # Other users of this machine can connect to the ports of the scheduler; connections therefore require
                # the key of this sweep.
                keys = {"security": library.Security.temporary(), "protocol": "tls://"}
                cluster = library.LocalCluster(n_workers=workers, host="127.0.0.1", **keys, **local)
            with cluster as found, library.Client(found) as client:
                yield client


def connected(library: Any, address: str) -> Any:
    """A client of a running scheduler. Raises BadInput if the scheduler does not respond, which Dask reports by one of
    four exceptions.
    """
    try:
        return library.Client(address, timeout=WAIT)
    except (OSError, TypeError, ValueError, RuntimeError) as error:
        keys = (
            "; its certificates are read from Dask's own settings, such as DASK_DISTRIBUTED__COMM__TLS__CLIENT__CERT"
            if address.startswith("tls://")
            else ""
        )
        raise BadInput(f"--scheduler {address}: no scheduler answers there{keys}") from error


def require_safe(address: str) -> None:
    """Raise BadInput for a scheduler without encryption that is accessed over a network, in which others could run code
    on this machine and on the workers.
    """
    kind, _, place = address.rpartition("://")
    host = place.rpartition(":")[0].strip("[]")
    here = host == "localhost" or host == "::1" or re.fullmatch(r"127(\.[0-9]{1,3}){3}", host) is not None
    if kind not in ("tls", "wss", "inproc") and not here:
        raise BadInput(
            f"--scheduler {address}: not encrypted, and not on this machine; start the scheduler with TLS, and name it tls://..."
        )


@contextlib.contextmanager
def slurm_cluster(asked: Cluster, folder: Path, cores: int = 1) -> Iterator[Any]:
    """Workers in SLURM jobs, with encrypted connections; each worker ends before its job.

    While they work, their key is stored in the folder of the sweep, where only the owner can read it.
    """
    try:
        import dask_jobqueue
        import distributed
    except ImportError as error:
        raise BadInput(f"--slurm needs dask-jobqueue: {install('sweep')}") from error
    hours, minutes, seconds = map(int, asked.walltime.split(":"))
    lifetime = max(3600 * hours + 60 * minutes + seconds - BEFORE_THE_END, 30)
    jobqueue: Any = dask_jobqueue
    library: Any = distributed
    made = jobqueue.SLURMCluster(
        queue=asked.partition or None,
        cores=1,
        job_cpu=cores,
        processes=1,
        memory=asked.memory,
        walltime=asked.walltime,
        job_extra_directives=list(asked.lines),
        job_script_prologue=[f"export {name}={value}" for name, value in ONE_THREAD.items()],
        worker_extra_args=["--lifetime", f"{lifetime}s", "--lifetime-stagger", "60s"],
        security=library.Security.temporary(),
        shared_temp_directory=str(folder.resolve()),
    )
    with made as cluster:
        cluster.scale(jobs=asked.jobs)
        yield cluster


FAREWELL = 120
"""A run writes a checkpoint this many seconds before the end of its job."""
MOST_TASKS = 1000
"""The largest number of tasks of an array; each takes every n-th point."""


def write_array(sweeping: Sweeping, laws: Sequence[str] = ()) -> Path:
    """Write `array.sh`, for `sbatch`. A task that reaches its time limit writes a checkpoint and is queued again."""
    cluster, path = sweeping.spec.cluster, sweeping.path / "array.sh"
    if not str(sweeping.path.resolve()).isprintable():
        raise BadInput(f"{echo(str(sweeping.path))}: has characters that no line of a job script can have; rename it")
    tasks = min(len(sweeping.jobs), MOST_TASKS)
    options = [
        f"--array=0-{tasks - 1}%{cluster.jobs}",
        f"--time={cluster.walltime}",
        f"--mem={cluster.memory.removesuffix('B')}",
        f"--cpus-per-task={sweeping.spec.ranks}",
        "--requeue",
        f"--signal=B:USR1@{FAREWELL}",
        f"--output={sweeping.path.resolve() / 'array-%a.log'}",
        *([f"--partition={cluster.partition}"] if cluster.partition else []),
        *cluster.lines,
    ]
    command = [sys.executable, "-m", "ecume", "sweep", str(sweeping.path.resolve())]
    command += [*(word for law in laws for word in ("--laws", law)), "--task"]
    lines = [
        "#!/bin/sh",
        *(f"#SBATCH {option}" for option in options),
        *(f"export {name}={value}" for name, value in ONE_THREAD.items()),
        f'{shlex.join(command)} "$SLURM_ARRAY_TASK_ID/{tasks}" &',
        "child=$!",
        "trap 'kill -USR1 $child' USR1",
        "wait $child; ended=$?",
        "[ $ended -gt 128 ] && { wait $child; ended=$?; }  # the first wait ends with the signal",
        '[ $ended -eq 75 ] && scontrol requeue "${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}"',
        "exit $ended",
        "",
    ]
    write_whole(path, "\n".join(lines).encode())
    path.chmod(0o755)
    return path


def work_task(sweeping: Sweeping, task: int, of: int, laws: Sequence[str] = ()) -> list[str]:
    """Run the points of one task: every `of`-th one. Returns their outcomes."""
    return [work(str(job.folder), laws) for job in sweeping.jobs[task::of]]
