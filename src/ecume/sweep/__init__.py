"""Many runs of one scene: a table of points, a run directory each, and what was measured in them.

ecume.sweep.sweep("durations.toml", "sweeps/durations")
ecume.open_sweep("sweeps/durations").table()
"""

from ecume.sweep.executors import ExecutorOptions
from ecume.sweep.results import Sweep, open_sweep
from ecume.sweep.runner import Outcome, sweep

__all__ = ["ExecutorOptions", "Outcome", "Sweep", "open_sweep", "sweep"]
