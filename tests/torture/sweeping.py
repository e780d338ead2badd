"""Sweeps whose workers, schedulers and main processes die: all points in the end, and the table of a quiet one."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from ecume.errors import Stopped
from ecume.run import verify
from ecume.sweep import open_sweep, sweep
from ecume.sweep.executors import ExecutorOptions

from .trials import Outcome, Trial, ended, forked, times, until, warmed

SWEEP = """
template = "cereal-bowl"
[fixed]
duration = "4 s"
"particles[0].count" = 30
[[axes]]
key = "seed"
values = {seeds}
"""


def swept(scale: float, folder: Path) -> Outcome:
    """A sweep whose worker is killed, then its main process, again and again; the table is that of a quiet one."""
    points = times(scale, 40)
    file = folder / "bowls.toml"
    file.write_text(SWEEP.format(seeds=list(range(1, points + 1))))
    warmed("floating")
    alone = ExecutorOptions(workers=1)
    chance = random.Random(5)
    for _ in range(max(2, points // 4)):
        child = forked(lambda: sweep(file, folder / "killed", alone))
        time.sleep(chance.uniform(0.2, 0.8))
        os.kill(child, signal.SIGKILL)
        if ended(child) == 0:
            break
    done = sweep(file, folder / "killed", alone)
    sweep(file, folder / "quiet", alone)
    same = (folder / "killed" / "table.csv").read_bytes() == (folder / "quiet" / "table.csv").read_bytes()
    states = open_sweep(folder / "killed").states()
    return Outcome(points, states.count("done") if same and not done.failed else 0, "table of an undisturbed sweep")


def killed_between(scale: float, folder: Path) -> Outcome:
    """A sweep that is killed as soon as a point is done, each time: the next one is not begun, or just so."""
    points = times(scale, 20)
    file, home = folder / "bowls.toml", folder / "killed"
    file.write_text(SWEEP.format(seeds=list(range(1, points + 1))))
    warmed("floating")
    alone, kills = ExecutorOptions(workers=1), 0
    while (before := done_in(home)) < points:
        child = forked(lambda: sweep(file, home, alone))
        until(lambda before=before: done_in(home) > before)
        os.kill(child, signal.SIGKILL)
        kills += ended(child) == -signal.SIGKILL
    done = sweep(file, home, alone)
    sweep(file, folder / "quiet", alone)
    same = (home / "table.csv").read_bytes() == (folder / "quiet" / "table.csv").read_bytes()
    sound = all(verify(run).sound for run in open_sweep(home).runs)
    return Outcome(points, points if same and sound and not done.failed else 0, f"{kills} kills, each after a point")


def done_in(directory: Path) -> int:
    """How many points of a sweep of scenes are done."""
    return len(list(directory.glob("points/*/run/DONE.json")))


T1 = """
process = "t1"
[[axes]]
key = "gap"
span = {{ start = 2e-2, stop = 1e-1, count = {gaps}, log = true }}
[[axes]]
key = "reduced_force"
values = [1e-3, 2e-3, 5e-3, 1e-2]
"""


def swept_by_dask(scale: float, folder: Path) -> Outcome:
    """Points of the T1 process on two workers of a scheduler. A worker is killed, then the scheduler, then all there
    is; issued again, the sweep comes to all points, and to the table of one that nobody disturbed.
    """
    file, killed = folder / "durations.toml", folder / "killed"
    file.write_text(T1.format(gaps=times(scale, 50)))
    points = sweep(file, folder / "alone", ExecutorOptions(workers=1)).done
    codes = []
    for kills in (((0.2, "worker"), (0.4, "scheduler")), ((0.6, "everything"),)):
        with options(folder) as (found, address):
            found["sweep"] = [issued(file, killed, "--scheduler", address)]
            for part, victim in kills:
                until(lambda part=part: points_done(killed) >= part * points)
                dead = [found[victim].pop()] if victim in found else [one for some in found.values() for one in some]
                for process in dead:
                    process.kill()
            codes += [found["sweep"][0].wait(60)]
    between = points_done(killed)
    last = issued(file, killed, "--workers", "2").wait()
    same = (killed / "table.csv").read_bytes() == (folder / "alone" / "table.csv").read_bytes()
    done = open_sweep(killed).states().count("done")
    good = same and 0 < between < points and codes == [Stopped.exit_code, -signal.SIGKILL] and last == 0
    note = f"same table as in one process; {between} were done when all processes were killed"
    return Outcome(
        points, done if good else 0, note if good else f"codes {codes}, {last}; same table: {same}; {between}"
    )


def points_done(directory: Path) -> int:
    """How many points have a result."""
    return len(list(directory.glob("points/*/result.json")))


Processes = dict[str, list["subprocess.Popen[bytes]"]]


@contextlib.contextmanager
def options(folder: Path) -> Iterator[tuple[Processes, str]]:
    """A scheduler of Dask with two workers, in processes of their own, and its address; in the end all are dead."""
    known = folder / "scheduler.json"
    known.unlink(missing_ok=True)
    found: Processes = {}
    try:
        here = ("--host", "127.0.0.1", "--no-dashboard")
        found["scheduler"] = [
            started("distributed.cli.dask_scheduler", *here, "--port", "0", "--scheduler-file", known)
        ]
        until(known.exists)
        address = open_address(known)
        alone = ("--nthreads", "1", "--no-nanny", *here)
        found["worker"] = [started("distributed.cli.dask_worker", address, *alone) for _ in range(2)]
        yield found, address
    finally:
        for process in (one for some in found.values() for one in some):
            process.kill()
            process.wait()


def open_address(known: Path) -> str:
    """What a scheduler wrote of itself."""
    import json

    return str(json.loads(known.read_text(encoding="utf-8"))["address"])


def issued(file: Path, directory: Path, *words: object) -> subprocess.Popen[bytes]:
    """The verb, in a process of its own."""
    return started("ecume", "sweep", file, "-o", directory, "--quiet", *words)


def started(module: str, *words: object) -> subprocess.Popen[bytes]:
    """A module as a program, one thread each; what it says goes nowhere."""
    command: Sequence[str] = [sys.executable, "-m", module, *map(str, words)]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.Popen(command, env={**os.environ, "NUMBA_NUM_THREADS": "1"}, **quiet)


TRIALS = (
    Trial("R15 sweeps", "a sweep killed repeatedly", swept),
    Trial("R15 sweeps, between points", "a sweep killed after each point", killed_between),
    Trial("R15 sweeps, Dask", "a worker, the scheduler, then everything killed", swept_by_dask),
)
