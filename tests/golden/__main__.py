"""Makes the runs of this version: `python -m tests.golden`. Again only as long as this version is not released."""

from __future__ import annotations

import contextlib
import json
import os
import signal
from pathlib import Path

import ecume
from ecume.errors import Stopped
from ecume.run import Progress, RunDirectory, RunOptions, run
from ecume.scenes.load import load_scene
from tests.torture.trials import SCENES

HOME = Path(__file__).parent / ecume.__version__
SMALL = {
    "floating": ("0.4 s", ("count = 40", "count = 5")),
    "sph": ("30 ms", ("spacing = 0.02", "spacing = 0.05")),
    "soft": ("2 s", ("", "")),
    "tracers": ("60 ms", ("count = 200", "count = 5")),
}
"""Of each model how long, and what makes its scene smaller."""


def half_way(progress: Progress) -> None:
    """Request a stop in the middle of the run."""
    if progress.time >= 0.5 * progress.duration:
        os.kill(os.getpid(), signal.SIGTERM)


for model, (duration, (old, new)) in SMALL.items():
    text = SCENES[model][0].format(duration=duration).replace(old or "\0", new, 1)
    home = RunDirectory(HOME / model)
    with contextlib.suppress(Stopped):
        run(load_scene(text), home.path, force=True, options=RunOptions(threads=1, progress=half_way))
    manifest = json.loads(home.manifest.read_text())
    manifest |= {"sessions": [], "platform": "", "processor": ""}  # nothing of the machine
    home.manifest.write_text(json.dumps(manifest, indent=2) + "\n")
    for private in (home.lock, home.log, home.status):
        private.unlink()
