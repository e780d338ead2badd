"""Runs: simulations of scenes into directories, which can be resumed after any interruption.

ecume.run.run(scene, "runs/bowl")
ecume.run.resume("runs/bowl")
ecume.run.info("runs/bowl").frames

Start with `runner`. `directory` defines the files. `recording` writes frames (selected by `selection`), numbers
(`scalars`) and `samples`; `progress`, `checkpoints`, `constants` and `manifest` write and read the other files, in
`archives` of arrays or as records. `lock` deals with other processes and signals, `invariant_monitor` checks each
frame, `comparison` finds the difference of two frames. `reports` and `verification` read one or several runs.
`user_code` identifies user laws and actions. `research_object` describes a run as an RO-Crate.
"""

from ecume.run.directory import RunDirectory
from ecume.run.progress import Progress
from ecume.run.reports import Comparison, Info, RunSummary, compare, info, list_runs, repair
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
