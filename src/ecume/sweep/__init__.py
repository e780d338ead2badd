"""Sweeps: many runs of one scene, a run directory for each point, and a table of measures.

ecume.sweep.sweep("durations.toml", "sweeps/durations")
ecume.open_sweep("sweeps/durations").table()

Start with `runner.sweep`. `spec` is the schema of the file and its points, `executors` runs the points, `results` and
`measures` make the table, `directory` also reads the status of a running sweep, and `figures` draws.
"""

from ecume.sweep.executors import ExecutorOptions
from ecume.sweep.results import Outcome, Sweep, open_sweep, sweep

__all__ = ["ExecutorOptions", "Outcome", "Sweep", "open_sweep", "sweep"]
