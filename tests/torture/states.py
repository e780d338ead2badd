"""States: gone on with from anywhere, spread over threads, poisoned, compiled from bad caches, integrated for long."""

from __future__ import annotations

import dataclasses
import os
import random
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from ecume._jit import FEW
from ecume.errors import Diverged
from ecume.models.floating.time_integration.integrators import SCHEMES as FLOATING_SCHEMES
from ecume.models.soft.integration.dirk_schemes import SCHEMES as SOFT_SCHEMES
from ecume.run.comparison import difference
from ecume.scenes.load import load_scene
from ecume.simulation import moments

from .trials import SCENES, Outcome, Trial, copied, scene_of, times, warmed

WAYS: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "floating": ("integration", "integrator", FLOATING_SCHEMES),
    "sph": ("integration", "integrator", ("symplectic", "verlet")),
    "soft": ("integration", "integrator", tuple(SOFT_SCHEMES)),
    "tracers": ("integration", "integrator", ("inertial", "overdamped")),
}
"""Of each model the part of its scene that names an integrator, and all that there are."""
SHORT = {"floating": "2 s", "sph": "0.05 s", "soft": "8 s", "tracers": "0.2 s"}


def continued(model: str) -> Callable[[float, Path], Outcome]:
    """From the state of each frame the rest of a run comes out the same, with each integrator of a model."""

    def trial(scale: float, folder: Path) -> Outcome:
        tried = survived = 0
        part, key, every = WAYS[model]
        ways = every[: times(scale, len(every))]
        for way in ways:
            scene = scene_with(model, part, key, way)
            whole = [(copied(one.state), one.frame) for one in moments(scene) if one.frame is not None]
            for number in range(0, len(whole) - 1, max(1, len(whole) // 6)):
                again = (one.frame for one in moments(scene, state=copied(whole[number][0])) if one.frame is not None)
                tried += 1
                survived += all(
                    not difference(there, here) for here, (_, there) in zip(again, whole[number:], strict=True)
                )
        return Outcome(tried, survived, ", ".join(ways))

    return trial


def scene_with(model: str, part: str, key: str, way: str) -> Any:
    """A short scene with an integrator; what has no inertia needs a liquid that drags."""
    text, _ = SCENES[model]
    text = text.format(duration=SHORT[model])
    if model == "tracers":
        text = text.replace("viscosity = 0.0", "viscosity = 1e-3").replace('drag = "none"', 'drag = "stokes"')
    if f"[{part}]" in text:
        return load_scene(text.replace(f"[{part}]", f'[{part}]\n{key} = "{way}"'))
    return load_scene(f'{text}\n[{part}]\n{key} = "{way}"\n')


THREADED = """
import hashlib, sys
from ecume import _jit
_jit.FEW = int(sys.argv[3])  # before any loop is declared
from ecume._jit import use_threads
from ecume.scenes.load import load_scene
from ecume.simulation import moments
use_threads(int(sys.argv[1]))
digest = hashlib.sha256()
for one in moments(load_scene(sys.argv[2])):
    if one.frame is not None:
        for array in one.frame.arrays.values(): digest.update(array.tobytes())
print(digest.hexdigest())
"""
CROWDS = {
    "floating": ("count = 40", "count = 2500", "2.5 cm", "20 cm", "0.1 s"),
    "sph": ("spacing = 0.02", "spacing = 0.004", "", "", "10 ms"),
    "tracers": ("count = 200", "count = 5000", "", "", "0.1 s"),
}
"""Of a model what makes its scene large enough for threads."""
PACKING = """
model = "soft"
duration = "20 ms"
frame_every = "10 ms"
[liquid]
viscosity = 1.0
[hydrodynamics]
drag = "stokes"
[[particles]]
radius = "1 mm"
modulus = "10 kPa"
count = 75
[[particles]]
radius = "1.4 mm"
modulus = "10 kPa"
count = 75
[cell]
size = ["30.3 mm", "30.3 mm"]
minimum_gap = "20 um"
[[protocol]]
time = "0 s"
[[protocol]]
time = "20 ms"
strain = 0.005
[integration]
integrator = "tr-bdf2"
tolerance = 1e-3
"""
"""Passes over contacts take threads from 4,000 of them on; here the threshold is one."""


def threads(scale: float, folder: Path) -> Outcome:
    """One, two and four threads give the same bits."""
    tried = survived = 0
    chosen = list(crowds())[: times(scale, len(crowds()))]
    for model in chosen:
        file = folder / f"{model}.toml"
        file.write_text(crowds()[model])
        found = {digest_of(file, count, few=1 if model == "soft" else FEW) for count in (1, 2, 4)}
        tried, survived = tried + 3, survived + (3 if len(found) == 1 else 0)
    return Outcome(tried, survived, ", ".join(chosen))


def crowds() -> dict[str, str]:
    """Of each model a scene that is large enough for threads."""
    found = {}
    for model, (old, new, narrow, wide, duration) in CROWDS.items():
        text = SCENES[model][0].format(duration=duration).replace(old, new).replace(narrow or "\0", wide)
        found[model] = text.replace("50 ms", duration).replace("5 ms", duration)
    return {**found, "soft": PACKING}


def digest_of(file: Path, count: int, few: int = FEW, **environment: str) -> str:
    """Of all bits of the frames that a process of its own computes of a scene with so many threads."""
    environment = {**os.environ, "NUMBA_NUM_THREADS": "4", **environment}
    command = [sys.executable, "-c", THREADED, str(count), str(file), str(few)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.strip()


LATEST = 50
"""Steps within which something that is no number has to be found."""
PARTED = 1e-6
"""Of their distance: how far two spheres are then from where they were; a film of the trial opens by less in a step."""


def poisoned(model: str) -> Callable[[float, Path], Outcome]:
    """Something that is no number gets into the state: found soon, with the particle named, and the time."""

    def trial(scale: float, folder: Path) -> Outcome:
        warmed(model)
        chance, tried, survived, latest = random.Random(model), times(scale, 30), 0, 0
        for _ in range(tried):
            late = _found_after(model, chance)
            survived += late is not None and late <= LATEST
            latest = max(latest, late if late is not None else 10**9)
        return Outcome(tried, survived, f"found after {latest} steps at most")

    return trial


def _found_after(model: str, chance: random.Random) -> int | None:
    """After how many steps it is found; None where it is not, or where nobody is named."""
    scene, wanted = scene_of(model, SHORT[model]), chance.randrange(3, 60)
    # Who has left is no part of the march any more; a step of the soft model may go over many ticks.
    state = next(copied(one.state) for one in moments(scene, patience=1e-9) if one.step >= min(wanted, one.steps // 2))
    hurt = _steps(state)
    field = chance.choice(("position", "log_gap") if model == "soft" else ("position", "velocity"))
    # Who is put far away without any speed is turned back by the guard, or counts as lost: `mass` tells.
    value = chance.choice((np.nan, np.inf, -np.inf) if field == "position" else (np.nan, np.inf, 1e300))
    flat = getattr(state, field).reshape(-1)
    flat[chance.randrange(int(state.contacts[0]) if field == "log_gap" else len(flat))] = value
    try:
        for one in moments(scene, state=state, patience=1e-9):
            if one.step > hurt + LATEST:
                return None
    except Diverged as error:
        return _steps(state) - hurt if _named(str(error)) else None
    return None


def _named(output: str) -> bool:
    """Whether a message says who, of what, at which time and step."""
    parts = (
        r"t = [0-9.e+-]+ s \(step [0-9]+\)",
        r"(floats?|particle|spheres?) [0-9]",
        r"finite [a-z]+ |goes|overlap|gap",
    )
    return all(re.search(part, output) for part in parts)


def overlapping(model: str) -> Callable[[float, Path], Outcome]:
    """One is put into its neighbor: both are named, soon, or the next step parts them as they were.

    The model of soft spheres may do the latter: films remember their gaps, and centers follow from the forces.
    """

    def trial(scale: float, folder: Path) -> Outcome:
        warmed(model)
        chance, tried = random.Random(model), times(scale, 20)
        found = [_overlap_found_after(model, chance) for _ in range(tried)]
        soon = [late for late in found if late is not None and late <= LATEST]
        return Outcome(tried, len(soon), f"named, or parted, after {max(soon, default=0)} steps at most")

    return trial


def _overlap_found_after(model: str, chance: random.Random) -> int | None:
    """After how many steps both are named or parted; None where neither is so."""
    scene, wanted = scene_of(model, SHORT[model]), chance.randrange(3, 60)
    state = next(copied(one.state) for one in moments(scene, patience=1e-9) if one.step >= min(wanted, one.steps // 2))
    hurt, one = _steps(state), chance.randrange(len(state.position))
    away = np.linalg.norm(state.position - state.position[one], axis=1)
    away[one] = np.inf
    other, apart = int(np.argmin(away)), float(away.min())
    state.position[one] += 0.95 * (state.position[other] - state.position[one])
    try:
        for now in moments(scene, state=state, patience=1e-9):
            distance = float(np.linalg.norm(now.state.position[other] - now.state.position[one]))
            if model == "soft" and now.step > hurt and abs(distance - apart) < PARTED * apart:
                return now.step - hurt
            if now.step > hurt + LATEST:
                return None
    except Diverged as error:
        both = all(re.search(rf"\b{number}\b", str(error)) for number in (one, other))
        return _steps(state) - hurt if both and "overlap" in str(error) and _named(str(error)) else None
    return None


def _steps(state: Any) -> int:
    return int(state.step[0])


SOAKED = 1_000_000
GROWTH = 0.01


def soaked(scale: float, folder: Path) -> Outcome:
    """A million steps: memory and open files stay what they were."""
    scene = dataclasses.replace(scene_of("floating"), duration=3600.0)
    process, steps, before = psutil.Process(), times(scale, SOAKED), (0, 0)
    for one in moments(scene):
        if one.step < steps // 10:
            before = (process.memory_info().rss, process.num_fds())
        if one.step >= steps:
            break
    memory, files = process.memory_info().rss / before[0] - 1.0, process.num_fds() - before[1]
    return Outcome(one.step, one.step if memory < GROWTH and files <= 0 else 0, f"{100 * memory:.2f} % more memory")


TRIALS = (
    *(Trial(f"R3 restarts, {model}", "same continuation from each state", continued(model)) for model in WAYS),
    Trial("R4 threads", "1, 2 and 4, the same bits", threads),
    *(Trial(f"R12 poisoned, {model}", "NaN, infinity, 1e300 in the state", poisoned(model)) for model in WAYS),
    *(Trial(f"R12 overlaps, {model}", "one put into another", overlapping(model)) for model in ("floating", "soft")),
    Trial("R21 soak", "a million steps", soaked),
)
