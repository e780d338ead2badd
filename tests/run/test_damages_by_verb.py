"""Each file of a run, damaged in each way, before each verb: one line says what is wrong, and nothing is lost."""

from __future__ import annotations

import os
import random
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
import toy
from typer.testing import CliRunner

from ecume.cli import app
from ecume.errors import StorageError
from ecume.run import RunDirectory, RunOptions, resume, run, verify

pytestmark = [
    pytest.mark.skipif(os.name == "nt", reason="Windows makes links for administrators alone"),
    pytest.mark.filterwarnings("ignore"),
]
TRIED = 100
"""By default; `ECUME_DAMAGES=20000` tries all."""
Scenes = Callable[..., toy.ToyScene]


def zeros(path: Path) -> None:
    path.write_bytes(bytes(path.stat().st_size))


def folder(path: Path) -> None:
    path.unlink()
    path.mkdir()
    (path / "mine.txt").write_text("mine")


def changed(change: Callable[[bytes], bytes]) -> Callable[[Path], None]:
    return lambda path: path.write_bytes(change(path.read_bytes())) and None


def flipped(content: bytes) -> bytes:
    place = len(content) // 3
    return content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :]


WAYS: dict[str, Callable[[Path], None]] = {
    "missing": Path.unlink,
    "empty": changed(lambda content: b""),
    "half": changed(lambda content: content[: len(content) // 2]),
    "flipped": changed(flipped),
    "zeros": zeros,
    "folder": folder,
    "twice": changed(lambda content: content * 2),
    "more": changed(lambda content: content + b"more"),
    "lines of Windows": changed(lambda content: content.replace(b"\n", b"\r\n")),
    "UTF-16": changed(lambda content: content.decode("latin-1").encode("utf-16")),
    "mark of UTF-8": changed(lambda content: b"\xef\xbb\xbf" + content),
    "newer": changed(lambda content: content.replace(b'"format": 3', b'"format": 99')),
    "not numbers": changed(lambda content: content.replace(b"0.", b"NaN")),
}
READING = {
    "info": ["info", "run"],
    "verify": ["verify", "run"],
    "list": ["list", "."],
    "compare": ["compare", "run", "good"],
    "csv": ["export", "run", "--to", "csv", "-o", "out/x.csv"],
    "xyz": ["export", "run", "--to", "xyz", "-o", "out/x.xyz"],
    "npz": ["export", "run", "--to", "npz", "-o", "out/x.npz"],
    "vtk": ["export", "run", "--to", "vtk", "-o", "out/x.vtkhdf"],
    "numbers": ["export", "run", "--to", "numbers", "-o", "out/x.csv"],
    "import": ["import", "good/scene.toml", "-o", "run"],
    "run": ["run", "good/scene.toml", "-o", "run"],
    "sweep": ["sweep", "run"],
}
"""Verbs that leave a run as it is."""
WRITING = {"resume": ["resume", "run", "--engine", "local", "-q"], "repair": ["repair", "run"]}
REWRITTEN = ("lock", "log.jsonl", "status.json", "watch.json", "manifest.json", "DONE.json", "ckpt")
"""What a resumed run writes again."""


def contents(path: Path) -> dict[str, bytes]:
    return {str(each.relative_to(path)): each.read_bytes() for each in path.rglob("*") if each.is_file()}


@pytest.mark.long
@pytest.mark.parametrize("state", ["done", "killed"])
def test_each_verb_says_in_a_line_what_is_damaged_and_loses_nothing(
    state: str, tmp_path: Path, scene: Scenes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "")  # a verb sets it: restored with the others at the end
    monkeypatch.delenv("NUMBA_NUM_THREADS")
    good, here = RunDirectory(tmp_path / "good"), tmp_path / "here"
    run(scene(duration=0.05), good.path, options=RunOptions(checkpoint_every=0.0))
    truth = contents(good.path)
    if state == "killed":
        good.done.unlink()
    names = [path.relative_to(good.path) for path in sorted(good.path.rglob("*")) if path.is_file()]
    every = [(name, way, verb) for name in names for way in WAYS for verb in {**READING, **WRITING}]
    tried = min(int(os.environ.get("ECUME_DAMAGES", TRIED)), len(every))
    for name, way, verb in random.Random(state).sample(every, tried):
        shutil.rmtree(here, ignore_errors=True)
        (here / "out").mkdir(parents=True)
        shutil.copytree(good.path, here / "run")
        shutil.copytree(good.path, here / "good")
        WAYS[way](here / "run" / name)
        monkeypatch.chdir(here)
        before = contents(here)
        done = CliRunner().invoke(app, {**READING, **WRITING}[verb])
        after, what = contents(here), (name, way, verb, done.output)
        assert done.exception is None or isinstance(done.exception, SystemExit), what
        assert done.exit_code in (0, 1 if verb == "compare" else 0, 2, 4), what
        lines = [line for line in done.stderr.splitlines() if "warning: " not in line]
        assert len(lines) == (done.exit_code in (2, 4) and not (verb == "verify" and done.stdout)), what
        if verb in READING:
            added = {place for place in after if place not in before}
            assert {place: content for place, content in after.items() if place in before} == before, what
            assert not added or (done.exit_code == 0 and all(place.startswith("out/") for place in added)), what
            continue
        kept = set(after.values())
        lost = {place for place, content in before.items() if content and content not in kept}
        again = {place for place in lost if after.get(place) == truth.get(place.removeprefix("run/"))}
        allowed = {place for place in lost if place.removeprefix("run/").split("/")[0] in REWRITTEN}
        assert not lost - again - allowed, what
        if done.exit_code and state == "done":
            assert (here / "run" / "DONE.json").exists(), what
        if verb == "resume" and done.exit_code == 0:
            numbers = ("run/traj/0000.gsd", "run/scalars.jsonl")
            assert all(after[place] == truth[place.removeprefix("run/")] for place in numbers), what


@pytest.mark.parametrize("name", ["scene.toml", "resolved.json", "constants.npz"])
def test_a_completed_run_that_is_refused_stays_complete(name: str, tmp_path: Path, scene: Scenes) -> None:
    """Once the file is put back the run is as it was: its record has the digests of all its files."""
    home = RunDirectory(tmp_path / "run")
    run(scene(duration=0.05), home.path)
    record, content = home.done.read_bytes(), (home.path / name).read_bytes()
    (home.path / name).write_bytes(content[:-5] + b"wrong")
    with pytest.raises(StorageError, match=name):
        resume(home.path)
    assert home.done.read_bytes() == record
    (home.path / name).write_bytes(content)
    assert resume(home.path).seconds == 0.0
    assert verify(home.path).sound


def test_a_record_of_zeros_is_no_text(tmp_path: Path, scene: Scenes) -> None:
    home = RunDirectory(tmp_path / "run")
    run(scene(duration=0.05), home.path)
    home.watch.write_bytes(bytes(4 * (home.watch.stat().st_size // 4) + 2))
    assert f"{home.watch}: damaged: is not text in UTF-8" in verify(home.path).faults
