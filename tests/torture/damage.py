"""Files that are damaged, and disks that are full."""

from __future__ import annotations

import random
import resource
import shutil
from pathlib import Path

from ecume.errors import StorageError
from ecume.run import RunDirectory, RunOptions, checkpoints, repair, resume, run
from ecume.run.directory import existing
from ecume.trajectories.reader import open_trajectory

from .trials import ONE_THREAD, Outcome, Trial, ended, forked, go_on, results, scene_of, times, warmed

OFTEN = RunOptions(threads=1, checkpoint_every=0.0)


def full_disk(scale: float, folder: Path) -> Outcome:
    """No file may grow beyond a size: one line, code 4, and after room is made the same end."""
    scene = scene_of("floating", "5 s")
    warmed("floating")
    run(scene, folder / "roomy", options=ONE_THREAD)
    largest = max(path.stat().st_size for path in (folder / "roomy").rglob("*") if path.is_file())
    tried, survived = times(scale, 20), 0
    for number in range(tried):
        home = folder / str(number)
        size = 50 + (largest - 100) * number // tried
        code = ended(forked(lambda home=home, size=size: _bounded(scene, home, size)))
        go_on(scene, home)
        survived += code == 4 and results(home) == results(folder / "roomy")
    return Outcome(tried, survived, "code 4, then the same bytes")


def _bounded(scene: object, home: Path, size: int) -> None:
    import signal

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    run(scene, home, options=OFTEN)


def checkpoints_damaged(scale: float, folder: Path) -> Outcome:
    """The newest checkpoint is cut or has a byte changed: it is set aside, and the run ends as it would have."""
    scene, chance = scene_of("floating", "2 s"), random.Random(6)
    run(scene, folder / "run", options=OFTEN)
    (folder / "run" / "DONE.json").unlink()
    whole = results(folder / "run")
    tried, survived = times(scale, 200), 0
    for number in range(tried):
        home = RunDirectory(folder / f"copy{number}")
        shutil.copytree(folder / "run", home.path)
        newest = checkpoints.newest_first(home)[0]
        newest.write_bytes(damaged(newest.read_bytes(), chance))
        resume(home.path, options=ONE_THREAD)
        survived += results(home.path) == whole
        shutil.rmtree(home.path)
    return Outcome(tried, survived, "the end is the same")


def damaged(content: bytes, chance: random.Random) -> bytes:
    """Cut, or with one bit changed."""
    if chance.random() < 0.4:
        return content[: chance.randrange(len(content))]
    changed = bytearray(content)
    changed[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    return bytes(changed)


def trajectories_damaged(scale: float, folder: Path) -> Outcome:
    """After `repair` whole frames are the former ones, and what is not is named."""
    scene, chance = scene_of("floating", "5 s"), random.Random(7)
    run(scene, folder / "run", options=ONE_THREAD)
    with open_trajectory(folder / "run") as trajectory:
        former = list(trajectory)
    path = existing(folder / "run").trajectory / "0000.gsd"
    content = path.read_bytes()
    tried, survived, kept = times(scale, 500), 0, 0
    for _ in range(tried):
        broken = damaged(content, chance)
        path.write_bytes(broken)
        survived += _mended(folder / "run", former, cut=len(broken) < len(content))
        kept += _frames(folder / "run")
        for aside in path.parent.glob("*.damaged"):
            aside.unlink()
    return Outcome(tried, survived, f"{kept} frames kept")


def _mended(folder: Path, former: list, *, cut: bool) -> bool:
    """Whether a repaired run shows nothing but former frames, and said what it lost."""
    mended = repair(folder)
    found = 0
    with open_trajectory(folder) as trajectory:
        for number in range(len(trajectory)):
            try:
                frame = trajectory[number]
            except StorageError:
                continue
            found += 1
            if any(frame.arrays[name].tobytes() != former[number].arrays[name].tobytes() for name in frame.arrays):
                return False
    # A cut file ends with its last whole frame; a changed bit is named, unless it changes nothing or hides the last.
    return cut or bool(mended.faults) or found >= len(former) - 1


def _frames(folder: Path) -> int:
    with open_trajectory(folder) as trajectory:
        return len(trajectory)


GOLDEN = Path(__file__).parents[1] / "golden"


def left_behind(scale: float, folder: Path) -> Outcome:
    """Runs that versions up to this one left half done: their frames are read, and stay, and the end comes."""
    homes = sorted(path.parent for path in GOLDEN.glob("*/*/manifest.json"))
    survived = 0
    for golden in homes:
        home = folder / golden.parent.name / golden.name
        shutil.copytree(golden, home)
        before = _frames(home)
        done = resume(home, options=ONE_THREAD)
        survived += done.frames > before > 1 and (home / "DONE.json").exists() and _alike(home, golden, before)
    return Outcome(len(homes), survived, ", ".join(sorted({path.parent.name for path in homes})))


def _alike(home: Path, golden: Path, count: int) -> bool:
    """Whether the first frames of two runs have the same bytes."""
    with open_trajectory(home) as now, open_trajectory(golden) as then:
        return all(
            now[number].arrays[name].tobytes() == array.tobytes()
            for number in range(count)
            for name, array in then[number].arrays.items()
        )


TRIALS: tuple[Trial, ...] = (
    Trial("R5 disk full", "no file grows beyond a size", full_disk),
    Trial("R6 checkpoints", "cut, or with a bit changed", checkpoints_damaged),
    Trial("R7 trajectories", "cut, or with a bit changed, then repaired", trajectories_damaged),
    Trial("R17 former versions", "their unfinished runs, resumed", left_behind),
)
