"""The numbers of the gallery's scenes, as this version was seen to compute them.

`python -m tests.torture.regression [NAME ...]` records them anew, which a change of the physics has to say. What a
shift of all positions in the thirteenth digit moves too much is not compared on other machines.
"""

from __future__ import annotations

import json
import math
import sys
import time
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ecume.run.manifest import circumstances
from ecume.scenes.load import load_scene
from ecume.simulation import moments
from ecume.trajectories.frame import Frame

from .trials import Outcome, Trial, copied, times

ROOT = Path(__file__).parents[2]
SCENES = {path.stem: path for path in sorted((ROOT / "examples").glob("*.toml"))}
RECORD = Path(__file__).parent / "recorded-examples.json"
HERE, ELSEWHERE = 1e-9, 1e-6
"""Of the largest that a number has been: what may differ on a machine of the same kind, and on others."""
SHIFT, STEADY = 1e-12, 1e-7
WORK = {"contact_sweeps", "substeps", "most_substeps", "rejected_steps", "time_steps"}
"""Counts of computing steps. One more or less is no fault: which step meets a tolerance first is rounding."""
SECONDS = 2.0
"""Of a scene's march up to the frame that is recorded."""


class Recorded(NamedTuple):
    """The numbers of one frame of a scene, and which of them do not hang on rounding."""

    frame: int
    numbers: dict[str, float]
    steady: list[str]


def recorded() -> dict[str, Recorded]:
    """By the scene's name."""
    return {name: Recorded(**one) for name, one in json.loads(RECORD.read_text())["examples"].items()}


def same_machine() -> bool:
    """Whether this is a machine of the record's kind, with the same programs."""
    kept, now = json.loads(RECORD.read_text())["machine"], kind()
    return bool(kept == now)


def kind() -> dict[str, Any]:
    """What can change a bit: versions, the processor, and settings that make libraries compute as on another one."""
    today = circumstances()
    return {name: value for name, value in today.items() if name not in ("ecume", "platform")}


def frames_until(name: str, frame: int, shift: float = 0.0) -> list[Frame]:
    """The frames of a scene up to one of them, with the positions of the start shifted."""
    scene = load_scene(SCENES[name])
    state = None
    if shift:
        state = copied(next(moments(scene)).state)
        position = state.position
        position *= 1.0 + shift * np.random.default_rng(1).uniform(-1.0, 1.0, position.shape)
    found = []
    for one in moments(scene, state=state):
        found += [one.frame] if one.frame is not None else []
        if len(found) > frame:
            break
    return found


def off_by(frames: Sequence[Frame], kept: Recorded) -> dict[str, float]:
    """How far each number is from what was recorded, over the largest that it has been."""
    return {name: _off_by(frames[: kept.frame + 1], name, value) for name, value in kept.numbers.items()}


def _off_by(frames: Sequence[Frame], name: str, value: float) -> float:
    numbers = [frame.numbers.get(name, math.nan) for frame in frames]
    error, largest = abs(numbers[-1] - value), float(np.nanmax(np.abs([value, *numbers])))
    return error / largest if largest > 0.0 else error


def differing(frames: Sequence[Frame], kept: Recorded, *, same: bool) -> dict[str, float]:
    """Numbers that are off by more than they may, and how far."""
    compared = kept.numbers if same else kept.steady
    off = off_by(frames, kept)
    return {name: off[name] for name in compared if not off[name] <= (HERE if same else ELSEWHERE)}


def gallery(scale: float, folder: Path) -> Outcome:
    """Each scene of the gallery, as far as it is recorded."""
    same, known, wrong = same_machine(), recorded(), []
    chosen = list(SCENES)[: times(scale, len(SCENES))]
    for name in chosen:
        off = differing(frames_until(name, known[name].frame), known[name], same=same)
        wrong += [f"{name}: {', '.join(f'{key} {value:.1e}' for key, value in off.items())}"] if off else []
    return Outcome(len(chosen), len(chosen) - len(wrong), "; ".join(wrong) or f"within {HERE if same else ELSEWHERE:g}")


def record(names: Sequence[str]) -> None:
    """Keep the numbers of some scenes, in place of the former."""
    kept = json.loads(RECORD.read_text()) if RECORD.exists() else {"examples": {}}
    if not names or kept.get("machine") == kind():
        kept["machine"] = kind()
    else:
        sys.exit("recorded on another kind of machine: record all, or none")
    for name in names or SCENES:
        kept["examples"][name] = taken(name, kept["examples"].get(name, {"frame": 1})["frame"])._asdict()
        RECORD.write_text(json.dumps(kept, indent=1, sort_keys=True) + "\n", encoding="utf-8")
        print(name, "frame", kept["examples"][name]["frame"], flush=True)


def taken(name: str, least: int) -> Recorded:
    """The numbers of the frame that a scene reaches in time, but not of an earlier one than `least`: a busy machine
    would forget the later ones.
    """
    frames_until(name, 1)  # compiled
    began, last = time.monotonic(), 0
    for one in moments(load_scene(SCENES[name])):
        last += one.frame is not None
        if last > max(least, 1) and time.monotonic() - began > SECONDS:
            break
    frames = frames_until(name, last - 1)
    numbers = {key: float(value) for key, value in frames[-1].numbers.items() if math.isfinite(value)}
    moved = off_by(frames_until(name, last - 1, SHIFT), Recorded(last - 1, numbers, []))
    return Recorded(last - 1, numbers, [key for key in numbers if moved[key] <= STEADY and key not in WORK])


TRIALS = (Trial("R20 gallery", "the numbers of each scene, as recorded", gallery),)

if __name__ == "__main__":
    warnings.simplefilter("ignore")
    record(sys.argv[1:])
