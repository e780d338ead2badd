"""What a trial is, and what trials share: scenes, processes that can be killed, results to the byte."""

from __future__ import annotations

import copy
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from ecume.errors import EcumeError
from ecume.run import RunDirectory, RunOptions, checkpoints, resume, run
from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder as templates

DEFECT, SURPRISED = 70, 71
"""How a process ends in which something went wrong that is no answer to a user."""


PATIENCE = 120.0
"""Seconds to wait for what has to come."""
ERRORS = os.environ.get("ECUME_TORTURE_ERRORS", os.devnull)
"""A file that takes the tracebacks of processes that were forked."""
CHILDREN: set[int] = set()
"""Processes that were begun here and did not end yet."""


class Outcome(NamedTuple):
    """How often something was tried, and how often it was survived."""

    tried: int
    survived: int
    note: str = ""


class Trial(NamedTuple):
    """One kind of hard times: from a scale, of which 1 is the whole, and an empty folder to what became of it."""

    name: str
    says: str
    run: Callable[[float, Path], Outcome]


FLOATING = """
model = "floating"
duration = "{duration}"
frame_every = "50 ms"
seed = 4
[liquid]
viscosity = "2 mPa*s"
[[particles]]
count = 40
radius = "1.5 mm"
density = 600
contact_angle = "70 deg"
[dish]
radius = "2.5 cm"
"""
SPH = """
model = "sph"
duration = "{duration}"
frame_every = "5 ms"
spacing = 0.02
[tank]
low = [0.0, 0.0]
high = [0.6, 0.4]
[[fluid]]
low = [0.0, 0.0]
high = [0.3, 0.3]
"""
SOFT = """
model = "soft"
duration = "{duration}"
frame_every = "0.4 s"
[liquid]
viscosity = 1e-6
[[particles]]
radius = 1.0
modulus = 1.0
positions = [[-1.0005, 0.0]]
force = [-1e-6, 0.0]
[[particles]]
radius = 1.0
modulus = 1.0
positions = [[1.0005, 0.0]]
force = [1e-6, 0.0]
[films]
prefactors = "paper"
"""
TRACERS = """
model = "tracers"
duration = "{duration}"
frame_every = "10 ms"
seed = 2
gravity = 9.81
[liquid]
viscosity = 0.0
[[particles]]
count = 200
radius = "1 mm"
density = 2500.0
[tank]
high = [0.2, 0.2]
[hydrodynamics]
drag = "none"
"""
T1 = (Path(str(templates())) / "t1.toml").read_text(encoding="utf-8").replace('"60 s"', '"{duration}"')
SCENES = {
    "t1": (T1, "60 s"),
    "floating": (FLOATING, "30 s"),
    "sph": (SPH, "0.5 s"),
    "soft": (SOFT, "8 s"),
    "tracers": (TRACERS, "4 s"),
}
"""Of each model a scene, and how long it lasts in the whole."""
ONE_THREAD = RunOptions(threads=1, checkpoint_every=0.05)


def scene_of(model: str, duration: str | None = None) -> Any:
    """The scene of a model."""
    text, whole = SCENES[model]
    return load_scene(text.format(duration=duration or whole))


def copied(state: Any) -> Any:
    """A state of its own."""
    return copy.deepcopy(state)


@cache
def warmed(model: str) -> bool:
    """Compile, or load, what a process that is forked from this one will need."""
    from ecume.simulation import moments

    return any(moment.step > 0 for moment in moments(scene_of(model)))


def forked(work: Callable[[], object]) -> int:
    """Do this in a process of its own, which begins at once; its number."""
    sys.stdout.flush()
    if child := os.fork():
        CHILDREN.add(child)
        return child
    code = SURPRISED
    try:
        os.dup2(os.open(ERRORS, os.O_WRONLY | os.O_CREAT | os.O_APPEND), 2)
        work()
        code = 0
    except EcumeError as error:
        code = error.exit_code if "\n" not in str(error) else DEFECT
    except BaseException:  # whatever it is, the exit code reports it
        traceback.print_exc()
        code = DEFECT
    finally:
        os._exit(code)


def ended(child: int) -> int:
    """Wait for a process; its exit code, or minus the signal that killed it."""
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    CHILDREN.discard(child)
    return code


def leave_nobody() -> None:
    """End what a trial that broke off left behind."""
    for child in list(CHILDREN):
        os.kill(child, signal.SIGKILL)
        ended(child)


def until(condition: Callable[[], bool]) -> None:
    """Wait for it."""
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError
        time.sleep(0.005)


def go_on(scene: Any, folder: Path, options: RunOptions = ONE_THREAD) -> None:
    """Resume a run, or begin it where it did not come to a manifest."""
    if RunDirectory(folder).manifest.exists():
        resume(folder, options=options)
    else:
        run(scene, folder, force=folder.exists(), options=options)


def results(folder: Path) -> dict[str, bytes]:
    """All bytes of a run's results: frames, numbers, the resolved scene, the last state."""
    home = RunDirectory(folder)
    files = [*home.trajectory.glob("*"), home.scalars, home.resolved, checkpoints.newest_first(home)[0]]
    return {path.name: path.read_bytes() for path in files}


COUNT: int | None = None
"""How many of each are tried, if the command line says so."""


def times(scale: float, whole: int) -> int:
    """So many of a whole, one at least."""
    return max(1, COUNT if COUNT is not None else round(scale * whole))
