"""Runs: a scene that is simulated into a directory, and survives whatever happens to the process.

ecume.run.run(scene, "runs/bowl")
ecume.run.resume("runs/bowl")
ecume.run.info("runs/bowl").frames

Start with `runner`. `directory` names the files; `recording`, `numbers`, `checkpoints`, `archives`, `constants`,
`manifest` and `progress` write and read them; `selection` and `sampling` determine what is written; `lock` and
`stop_requests` deal with other processes and signals; `invariant_monitor` checks each frame; `reports`, `verification`
and `recovery` look at runs from outside, `catalog` and `comparison` at several of them; `user_code` identifies a user's
laws and actions; `crate` describes a run as a research object.
"""

from ecume.run.catalog import RunSummary, list_runs
from ecume.run.comparison import Comparison, compare
from ecume.run.directory import RunDirectory
from ecume.run.progress import Progress
from ecume.run.reports import Info, info, repair
from ecume.run.runner import RunOptions, RunResult, resume, run
from ecume.run.verification import Verification, verify

__all__ = [
    "Comparison",
    "Info",
    "Progress",
    "RunDirectory",
    "RunOptions",
    "RunResult",
    "RunSummary",
    "Verification",
    "compare",
    "info",
    "list_runs",
    "repair",
    "resume",
    "run",
    "verify",
]
