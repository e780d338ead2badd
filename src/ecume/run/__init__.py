"""Runs: a scene that is simulated into a directory, and survives whatever happens to the process.

ecume.run.run(scene, "runs/bowl")
ecume.run.resume("runs/bowl")
ecume.run.info("runs/bowl").frames

Start with `runner`. `directory` names the files; `recording`, `checkpoints`, `constants`, `manifest` and `progress`
write them; `lock` and `stop_requests` deal with other processes and signals; `invariant_monitor` checks each frame;
`selection` and
`sampling` determine what is written; `reports` and `recovery` look at runs from outside, `catalog` and `comparison` at
several of them; `user_laws` identifies a user's laws; `crate` describes a run as a research object; `ranks` is MPI.
"""

from ecume.run.catalog import RunSummary, list_runs
from ecume.run.comparison import Comparison, compare
from ecume.run.directory import RunDirectory
from ecume.run.progress import Progress
from ecume.run.reports import Info, info, repair
from ecume.run.runner import RunOptions, RunResult, resume, run

__all__ = [
    "Comparison",
    "Info",
    "Progress",
    "RunDirectory",
    "RunOptions",
    "RunResult",
    "RunSummary",
    "compare",
    "info",
    "list_runs",
    "repair",
    "resume",
    "run",
]
