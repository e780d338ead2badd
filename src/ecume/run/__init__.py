"""A run: a scene that is simulated into a directory, and survives whatever happens to the process.

ecume.run.run(scene, "runs/bowl")
ecume.run.resume("runs/bowl")
ecume.run.info("runs/bowl").frames
"""

from ecume.run.catalog import RunSummary, list_runs
from ecume.run.comparison import Comparison, compare
from ecume.run.directory import RunDirectory
from ecume.run.driving import Habits, RunResult, resume, run
from ecume.run.progress import Progress
from ecume.run.reports import Info, info, repair

__all__ = [
    "Comparison",
    "Habits",
    "Info",
    "Progress",
    "RunDirectory",
    "RunResult",
    "RunSummary",
    "compare",
    "info",
    "list_runs",
    "repair",
    "resume",
    "run",
]
