"""Small runs of each model, made once a process."""

import functools
import shutil
import tempfile
from pathlib import Path

from ecume.run import RunOptions, run
from ecume.scenes.load import load_scene
from ecume.scenes.templates import copy_template

SMALL = {
    "floating": ("two-spheres", {"duration": "0.2 s", "frame_every": "0.02 s"}),
    "tracers": ("bouncing-particles", {"duration": "0.2 s", "frame_every": "0.02 s"}),
    "sph": ("tank-at-rest", {"duration": "0.1 s", "frame_every": "0.01 s"}),
    "soft": ("t1", {"duration": "2 s", "frame_every": "0.1 s"}),
}


@functools.cache
def _made(model, title):
    name, changes = SMALL[model]
    folder = Path(tempfile.mkdtemp())
    copy_template(name, folder / "scene.toml")
    asked = load_scene(folder / "scene.toml", [f"{key}={value}" for key, value in changes.items()])
    if title:
        import dataclasses

        asked = dataclasses.replace(asked, title=title)
    run(asked, folder / "run", options=RunOptions(threads=1))
    return folder / "run"


def run_of(model, folder, title=None):
    """A copy of a small run."""
    target = folder / "run"
    shutil.copytree(_made(model, title), target)
    return target
