"""Run directories from anyone: links, pipes, devices, bombs and wrong digests at every name, met by every verb."""

from __future__ import annotations

import contextlib
import io
import itertools
import os
import random
import resource
import shutil
import signal
import socket
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from typer.testing import CliRunner

from ecume.cli import app
from ecume.errors import StorageError
from ecume.run import RunDirectory, RunOptions, resume, run, verify
from ecume.trajectories.gsd import ENTRY

from .damage import damaged
from .trials import ONE_THREAD, Outcome, Trial, ended, forked, results, scene_of, times, warmed

OFTEN = RunOptions(threads=1, checkpoint_every=0.0)
FILES = (
    *("manifest.json", "resolved.json", "scene.toml", "constants.npz", "lock", "scalars.jsonl", "log.jsonl"),
    *("status.json", "watch.json", "DONE.json", "FAILED.json", "traj/0000.gsd", "traj/0001.gsd", "ckpt/newest"),
    *("status.json.part", "manifest.json.part", "watch.json.part", "DONE.json.part", "results/view.html"),
)
FOLDERS = ("traj", "ckpt", "results")
VERBS = {
    "info": (), "resume": (), "repair": (), "verify": (), "list": (), "plot": ("--list",),
    "view": ("--save", "page.html"), "export": ("--to", "csv", "-o", "out.csv"), "movie": ("-o", "out.gif"),
}  # fmt: skip
CODES = (0, 2, 4)
"""What a verb may end with: a result, or an answer to the user."""
LIMIT, MEMORY = 20, 2 * 2**30
"""Seconds of processor time, and bytes beyond those of the process, that a verb may take."""
COMMAND = "$(touch owned)"


def symbolic(path: Path, outside: Path) -> None:
    path.symlink_to(outside / ("folder" if path.name in FOLDERS else "bashrc"))


def relative(path: Path, outside: Path) -> None:
    path.symlink_to(os.path.relpath(outside / ("folder" if path.name in FOLDERS else "bashrc"), path.parent))


def dangling(path: Path, outside: Path) -> None:
    path.symlink_to(outside / "new")


def hard(path: Path, outside: Path) -> None:
    os.link(outside / "bashrc", path)


def pipe(path: Path, outside: Path) -> None:
    os.mkfifo(path)


def endless(path: Path, outside: Path) -> None:
    path.symlink_to("/dev/zero")


def device(path: Path, outside: Path) -> None:
    try:
        os.mknod(path, 0o20666, os.makedev(1, 5))
    except PermissionError:  # for the administrator alone
        endless(path, outside)


def named_socket(path: Path, outside: Path) -> None:
    with socket.socket(socket.AF_UNIX) as one, contextlib.chdir(path.parent):
        one.bind(path.name)


def sparse(path: Path, outside: Path) -> None:
    with path.open("wb") as file:
        file.truncate(2**40)


def nested(path: Path, outside: Path) -> None:
    path.write_text('{"a": ' * 50_000 + "1" + "}" * 50_000)


def wrong(path: Path, outside: Path) -> None:
    path.write_text('{"pid": -1, "host": 7, "began": 1e999, "sha256": {"../bashrc": 3}, "sessions": 1, "time": []}\n')


LINKS = (symbolic, relative, dangling, hard, pipe, endless, device, named_socket, sparse, nested, wrong)


def deflated(home: RunDirectory) -> None:
    """A checkpoint of some kilobytes that unpacks to gigabytes."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (2**29,)})
    path = newest(home)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("state.position.npy", "w") as member:
        member.write(stream.getvalue())
        for _ in range(64):
            member.write(bytes(2**24))


def overlapping(home: RunDirectory) -> None:
    """Chunks of a frame that all refer to the same bytes of a file."""
    path = home.trajectory / "0000.gsd"
    content = bytearray(path.read_bytes()) + bytes(8 * 2**20)
    entries = np.frombuffer(content, ENTRY, 512, 256).copy()
    mine = entries["frame"] == 1
    entries["location"][mine], entries["rows"][mine], entries["columns"][mine] = 20_000, 2**20, 1
    content[256 : 256 + entries.nbytes] = entries.tobytes()
    path.write_bytes(content)


def commanding(home: RunDirectory) -> None:
    """A manifest with a command in it, and a log that is a link."""
    home.manifest.write_text(home.manifest.read_text().replace('"processor": "', f'"processor": "{COMMAND}'))


BOMBS: tuple[Callable[[RunDirectory], None], ...] = (deflated, overlapping, commanding)


def newest(home: RunDirectory) -> Path:
    """The newest checkpoint."""
    return max(home.checkpoints.glob("*.npz"))


def hostile_directories(scale: float, folder: Path) -> Outcome:
    """Each kind of link, pipe, device and bomb at each name, with each verb: nothing outside changes, no verb hangs or
    fills the memory, and each ends with an answer.
    """
    import ecume.show.movies  # noqa: F401  # once, and not in each process

    warmed("floating")
    made = folder / "made"
    run(scene_of("floating", "0.5 s"), made, options=OFTEN)
    (made / "DONE.json").unlink()
    cases = [(kind, name) for kind in LINKS for name in (*FILES, *FOLDERS)] + [(bomb, "") for bomb in BOMBS]
    trials = list(itertools.product(cases, VERBS))
    random.Random(22).shuffle(trials)
    trials = trials[: times(scale, len(trials))]
    failed = []
    for number, ((kind, name), verb) in enumerate(trials):
        place = folder / str(number)
        shutil.copytree(made, place / "run")
        outside = place / "outside"
        (outside / "folder").mkdir(parents=True)
        (outside / "bashrc").write_text("export PATH\n")
        spoil(RunDirectory(place / "run"), kind, name, outside)
        code = ended(forked(lambda verb=verb, place=place: bounded(verb, place)))
        left = sorted(path.name for path in outside.rglob("*"))
        if code or (outside / "bashrc").read_text() != "export PATH\n" or left != ["bashrc", "folder"]:
            failed.append(f"{verb} with {kind.__name__} {name}: {code}")
        shutil.rmtree(place)
    return Outcome(len(trials), len(trials) - len(failed), "; ".join(failed[:3]) or "nothing outside changed")


def spoil(home: RunDirectory, kind: Callable, name: str, outside: Path) -> None:
    """Put something hostile into a run."""
    if not name:
        kind(home)
        return
    path = newest(home) if name == "ckpt/newest" else home.path / name
    path.parent.mkdir(exist_ok=True)
    if path.is_dir():
        shutil.rmtree(path)
    path.unlink(missing_ok=True)
    kind(path, outside)


def bounded(verb: str, place: Path) -> None:
    """A verb in this process, with bounded time and memory; raises where it gave no answer."""
    there = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (there + MEMORY, there + MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT))
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(3 * LIMIT)
    with contextlib.chdir(place):
        done = CliRunner().invoke(app, [verb, "." if verb == "list" else "run", *VERBS[verb]])
    if done.exit_code not in CODES or "Traceback" in done.output:
        raise RuntimeError(done.output)


def bit_rot(scale: float, folder: Path) -> Outcome:
    """One byte anywhere in a completed or killed run: `verify` names its file, and `resume` ends with the former bytes
    or with an error.
    """
    warmed("floating")
    chance, tried, survived, missed = random.Random(23), times(scale, 1000), 0, []
    run(scene_of("floating", "1 s"), folder / "done", options=OFTEN)
    shutil.copytree(folder / "done", folder / "killed")
    (folder / "killed" / "DONE.json").unlink()
    whole = results(folder / "done")
    for number in range(tried):
        home = folder / "copy"
        shutil.copytree(folder / ("done", "killed")[number % 2], home)
        path = chance.choice(sorted(path for path in home.rglob("*") if path.is_file()))
        path.write_bytes(damaged(path.read_bytes(), chance) if number % 5 == 0 else flipped(path.read_bytes(), chance))
        found = verify(home)
        named = any(path.name in each for each in (*found.faults, *found.remarks))
        good = named and resumed(home, whole)
        survived += good
        missed += [] if good else [f"{path.relative_to(home)} ({'named' if named else 'not named'})"]
        shutil.rmtree(home)
    return Outcome(tried, survived, "; ".join(missed[:3]) or "named, and computed again or refused")


def flipped(content: bytes, chance: random.Random) -> bytes:
    """One byte changed."""
    changed = bytearray(content)
    changed[chance.randrange(len(content))] ^= chance.randrange(1, 256)
    return bytes(changed)


def resumed(home: Path, whole: dict[str, bytes]) -> bool:
    """Whether a run that is resumed ends with these bytes, or with an error."""
    try:
        resume(home, options=ONE_THREAD)
    except StorageError:
        return True
    return results(home) == whole


TRIALS = (
    Trial("R22 hostile directories", "links, pipes, devices, bombs in a run, each verb", hostile_directories),
    Trial("R23 bit rot", "a byte changed anywhere in a completed or killed run", bit_rot),
)
