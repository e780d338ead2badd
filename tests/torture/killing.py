"""Processes that die: at random, inside of writes, by signals, two at once, with readers beside them."""

from __future__ import annotations

import contextlib
import json
import os
import random
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ecume.errors import RunExists
from ecume.run import RunDirectory, RunOptions, checkpoints, info, resume, run
from ecume.run.checkpoints import Checkpoint
from ecume.simulation import moments
from ecume.trajectories.reader import open_trajectory
from ecume.trajectories.segments import Recorder

from .trials import ONE_THREAD, SCENES, Outcome, Trial, ended, forked, go_on, results, scene_of, times, until, warmed


def killed(model: str) -> Callable[[float, Path], Outcome]:
    """Runs of a model that are killed at random moments, and gone on with."""

    def trial(scale: float, folder: Path) -> Outcome:
        kills, scene, chance = times(scale, 50), scene_of(model), random.Random(model)
        warmed(model)
        began = time.monotonic()
        run(scene, folder / "alone", options=ONE_THREAD)
        took, tried = time.monotonic() - began, 0
        for _ in range(kills):
            child = forked(lambda: go_on(scene, folder / "killed"))
            time.sleep(chance.uniform(0.0, 2.0 * took / kills + 0.1))
            os.kill(child, signal.SIGKILL)
            tried += ended(child) == -signal.SIGKILL
        go_on(scene, folder / "killed")
        same = results(folder / "killed") == results(folder / "alone")
        resumed = from_checkpoints(folder / "killed")
        words = f"{'same' if same else 'other'} bytes at the end; {resumed} times from a checkpoint"
        return Outcome(tried, tried if same and (resumed or tried < 5) else 0, words)

    return trial


def from_checkpoints(folder: Path) -> int:
    """How often a run was resumed from a checkpoint, and not from its beginning."""
    sessions = json.loads(RunDirectory(folder).manifest.read_bytes())["sessions"]
    return sum(one["from_step"] > 0 for one in sessions)


def killed_writing(scale: float, folder: Path) -> Outcome:
    """Frames and checkpoints in a tight loop; whatever was said to be written is there, and whole."""
    warmed("floating")
    moment = next(moments(scene_of("floating")))
    chance, tried, survived = random.Random(2), times(scale, 200), 0
    for number in range(tried):
        home = RunDirectory(folder / str(number))
        home.path.mkdir()
        there, output = os.pipe()
        child = forked(lambda home=home, output=output: _write_for_ever(home, moment, output))
        os.close(output)
        time.sleep(chance.uniform(0.0, 0.1))
        os.kill(child, signal.SIGKILL)
        ended(child)
        with os.fdopen(there, "rb") as pipe:
            committed = len(pipe.read())
        survived += _whole(home, committed, type(moment.state))
    return Outcome(tried, survived, "committed frames are complete")


def _write_for_ever(home: RunDirectory, moment: Any, output: int) -> None:
    with Recorder(home.trajectory) as recorder:
        for step in range(10**9):
            recorder.write(moment.frame._replace(time=float(step)), step)
            os.write(output, b"1")
            checkpoints.save(home, Checkpoint(moment.state, step))


def _whole(home: RunDirectory, committed: int, kind: type) -> bool:
    """Whether all frames that were reported are there, and a checkpoint if there was time for one."""
    if not committed:
        return True
    with open_trajectory(home.trajectory) as trajectory:
        frames = len(trajectory)
        whole = [trajectory[number].time for number in range(frames)] == list(map(float, range(frames)))
    found = checkpoints.newest(home, kind, frames, lambda *_: None)
    return whole and frames >= committed and (found is not None or committed < 2)


def asked_to_stop(scale: float, folder: Path) -> Outcome:
    """Signals leave a checkpoint and code 75 within two seconds; the end is the same."""
    scene = scene_of("floating")
    warmed("floating")
    run(scene, folder / "alone", options=ONE_THREAD)
    chance, tried, stopped = random.Random(3), 0, 0
    slow = RunOptions(threads=1, checkpoint_every=1e9)
    for number in range(times(scale, 30)):
        name = ("SIGTERM", "SIGINT", "SIGUSR1")[number % 3]
        before = sessions(folder / "asked")
        child = forked(lambda: go_on(scene, folder / "asked", slow))
        # Who presses Ctrl-C before a run has begun has nothing to lose, and ends it at once.
        until(lambda before=before: sessions(folder / "asked") > before)
        time.sleep(chance.uniform(0.0, 0.2))
        began = time.monotonic()
        os.kill(child, getattr(signal, name))
        code = ended(child)
        if code == 0:
            break
        tried += 1
        stopped += code == 75 and time.monotonic() - began < 2.0
    go_on(scene, folder / "asked")
    same = results(folder / "asked") == results(folder / "alone")
    return Outcome(tried, stopped if same else 0, "code 75 within 2 s")


def sessions(folder: Path) -> int:
    """How often a march has begun in a run's directory."""
    log = RunDirectory(folder).log
    return (
        sum(b'"begun"' in line or b'"resumed"' in line for line in log.read_bytes().splitlines()) if log.exists() else 0
    )


def two_at_once(scale: float, folder: Path) -> Outcome:
    """A second run in the same directory is refused; a lock whose owner was killed is taken over."""
    scene = scene_of("floating")
    warmed("floating")
    child = forked(lambda: run(scene, folder / "run", options=ONE_THREAD))
    until(lambda: info_state(folder / "run") == "running")
    tried, refused = times(scale, 50), 0
    for number in range(tried):
        with contextlib.suppress(RunExists):
            if number % 2:
                resume(folder / "run")
            else:
                run(scene, folder / "run", force=True)
            continue
        refused += 1
    os.kill(child, signal.SIGKILL)
    ended(child)
    resume(folder / "run", options=ONE_THREAD)
    run(scene, folder / "alone", options=ONE_THREAD)
    same = results(folder / "run") == results(folder / "alone")
    return Outcome(tried, refused if same else 0, "then lock of a dead process taken over")


def info_state(folder: Path) -> str:
    """How a run stands; nothing where it has not begun."""
    try:
        return info(folder).state
    except ValueError:
        return ""


def read_while_written(scale: float, folder: Path) -> Outcome:
    """Readers beside a writer see whole frames only."""
    scene = scene_of("floating")
    warmed("floating")
    child = forked(lambda: run(scene, folder / "run", options=ONE_THREAD))
    until(lambda: info_state(folder / "run") == "running")
    tried, good = times(scale, 500), 0
    for _ in range(tried):
        info(folder / "run")
        with open_trajectory(folder / "run") as trajectory:
            count = len(trajectory)
            good += not count or abs(trajectory[count - 1].time - 0.05 * (count - 1)) < 1e-9
    os.kill(child, signal.SIGTERM)
    return Outcome(tried, good if ended(child) in (0, 75) else 0)


TRIALS = (
    *(Trial(f"R1 killed, {model}", "SIGKILL at random moments", killed(model)) for model in SCENES),
    Trial("R2 killed while writing", "SIGKILL during writing of frames and checkpoints", killed_writing),
    Trial("R13 signals", "SIGTERM, SIGINT, SIGUSR1", asked_to_stop),
    Trial("R14 two at once", "a second run in one directory", two_at_once),
    Trial("R16 readers", "reads while a run writes", read_while_written),
)
