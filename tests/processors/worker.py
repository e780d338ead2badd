"""What one process does on one processor: begin runs that are killed, or resume runs that were begun elsewhere.

python -m tests.processors.worker begin FOLDER SCENE ...
python -m tests.processors.worker resume FOLDER COPY SCENE ...    # prints a line of JSON for each run
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from ecume.errors import Stopped
from ecume.run import Progress, RunDirectory, RunOptions, checkpoints, resume, run
from ecume.scenes.load import load_scene
from ecume.trajectories.reader import open_trajectory

from .settings import ROOT

FRAMES, STOP = 8, 3
"""How long the runs are, and after which frame they keep their last checkpoint."""
PLACES = (ROOT / "examples", ROOT / "src" / "ecume" / "templates")
SMALLER = {"colloids": ["particles[0].count=4000", "dish.radius=4 mm"]}
"""What makes scenes small enough."""


def scene_of(name: str) -> Any:
    """A scene of the gallery, or a template, a few frames long."""
    path = next(place / f"{name}.toml" for place in PLACES if (place / f"{name}.toml").exists())
    changes = SMALLER.get(name, [])
    every = load_scene(path, changes).frame_every
    return load_scene(path, [*changes, f"duration={FRAMES * every!r}"])


def begin(home: RunDirectory, name: str) -> None:
    """Leave a run as if it had been killed at its end, long after its last checkpoint."""

    def progress(at: Progress) -> None:
        if at.frames == STOP + 1:
            os.kill(os.getpid(), signal.SIGTERM)

    try:
        run(scene_of(name), home.path, options=RunOptions(threads=1, progress=progress))
    except Stopped:
        pass
    else:
        sys.exit(f"{name}: came to its end before it could be killed")
    saved = {path.name: path.read_bytes() for path in checkpoints.newest_first(home)}
    resume(home.path, options=RunOptions(threads=1))
    home.done.unlink()
    for path in checkpoints.newest_first(home):
        path.unlink()
    for file, content in saved.items():
        (home.checkpoints / file).write_bytes(content)


def resumed(home: RunDirectory) -> dict[str, Any]:
    """Resume a run: how many frames it has, what the warnings said, and how far it ended from where it ended before."""
    before = last_positions(home)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        done = resume(home.path, options=RunOptions(threads=1))
    after = last_positions(home)
    apart = float(np.abs(after - before).max() / np.abs(before).max())
    sessions = json.loads(home.manifest.read_text())["sessions"]
    return {
        "done": home.done.exists() and done.frames == FRAMES + 1,
        "apart": apart,
        "replaced": sessions[-1].get("replaced"),
        "warnings": [str(one.message) for one in caught if "replaced" in str(one.message)],
    }


def last_positions(home: RunDirectory) -> Any:
    """The positions in the last frame."""
    with open_trajectory(home.path) as trajectory:
        return trajectory[-1].arrays["position"].copy()


def main(verb: str, folder: str, *rest: str) -> None:
    """Do this for all scenes."""
    if verb == "begin":
        for name in rest:
            begin(RunDirectory(Path(folder) / name), name)
        return
    copy, *names = rest
    for name in names:
        shutil.copytree(Path(folder) / name, Path(copy) / name)
        print(json.dumps({"scene": name, **resumed(RunDirectory(Path(copy) / name))}), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
