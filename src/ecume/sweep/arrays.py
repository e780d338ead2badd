"""A job array of SLURM: each task runs its own points, with no server between them."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

from ecume.sweep.crews import ONE_THREAD
from ecume.sweep.directory import Sweeping
from ecume.sweep.working import work
from ecume.trajectories.durable import write_whole

FAREWELL = 120
"""Seconds before the end of a job at which its run leaves a checkpoint."""
MOST_TASKS = 1000
"""Of an array; a task takes each so many-th point."""


def write_array(sweeping: Sweeping) -> Path:
    """Write `array.sh`, for `sbatch`; a task that runs out of time leaves a checkpoint and is put in line again."""
    cluster, path = sweeping.spec.cluster, sweeping.path / "array.sh"
    tasks = min(len(sweeping.jobs), MOST_TASKS)
    options = [
        f"--array=0-{tasks - 1}%{cluster.jobs}",
        f"--time={cluster.walltime}",
        f"--mem={cluster.memory.removesuffix('B')}",
        "--cpus-per-task=1",
        "--requeue",
        f"--signal=B:USR1@{FAREWELL}",
        f"--output={sweeping.path.resolve() / 'array-%a.log'}",
        *([f"--partition={cluster.partition}"] if cluster.partition else []),
        *cluster.lines,
    ]
    command = [sys.executable, "-m", "ecume", "sweep", str(sweeping.path.resolve()), "--task"]
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


def work_task(sweeping: Sweeping, task: int, of: int) -> list[str]:
    """The points of one task: each so many-th; the words they end with."""
    return [work(str(job.folder)) for job in sweeping.jobs[task::of]]
