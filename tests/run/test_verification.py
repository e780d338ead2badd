"""No byte of a run changes without notice: `verify` names the file, and `resume` computes what is damaged again."""

import contextlib
import json
import random
import shutil

import pytest
import toy
from typer.testing import CliRunner

from ecume.cli import app
from ecume.errors import Diverged, RunExists, StorageError
from ecume.run import RunDirectory, RunOptions, lock, resume, run, verify
from ecume.run.directory import manifest_of
from ecume.trajectories.reader import open_trajectory

pytestmark = pytest.mark.sampled(2)

FLIPS = 4
"""Of each file of each run."""
OFTEN = RunOptions(checkpoint_every=0.0)
MADE = {}


@pytest.fixture(params=["done", "killed", "failed"])
def made(request, tmp_path, tmp_path_factory, scene):
    """A run that ended so, with checkpoints."""
    if request.param not in MADE:
        MADE[request.param] = tmp_path_factory.mktemp("made") / "run"
        changes = {"blow_up_at": 35} if request.param == "failed" else {}
        with contextlib.suppress(Diverged):
            run(scene(duration=0.05, **changes), MADE[request.param], options=OFTEN)
        if request.param == "killed":
            (MADE["killed"] / "DONE.json").unlink()
    shutil.copytree(MADE[request.param], tmp_path / "run")
    return RunDirectory(tmp_path / "run")


@pytest.fixture
def killed(tmp_path, scene):
    home = RunDirectory(tmp_path / "run")
    run(scene(duration=0.05), home.path, options=OFTEN)
    home.done.unlink()
    return home


def flip(path, place, bit=0):
    content = bytearray(path.read_bytes())
    content[place] ^= 1 << bit
    path.write_bytes(content)


def test_a_run_that_is_not_damaged_is_sound(made):
    before = {path: path.stat().st_mtime_ns for path in made.path.rglob("*")}
    found = verify(made.path, deep=True)
    assert found.sound, found.faults
    assert found.remarks == ()
    assert found.recomputed == found.frames > 2
    assert {path: path.stat().st_mtime_ns for path in made.path.rglob("*")} == before


@pytest.mark.long
def test_each_changed_byte_is_named(made):
    chance = random.Random(21)
    for path in sorted(path for path in made.path.rglob("*") if path.is_file()):
        content = path.read_bytes()
        for place in {0, len(content) - 1, *(chance.randrange(len(content)) for _ in range(FLIPS))}:
            flip(path, place, chance.randrange(8))
            found = verify(made.path)
            assert any(path.name in each for each in (*found.faults, *found.remarks)), (path.name, place)
            assert not found.sound or path.suffix == ".gsd"
            path.write_bytes(content)


@pytest.mark.parametrize("frame", [0, 3, 5])
def test_a_frame_before_the_last_checkpoint_that_is_damaged_is_computed_again(killed, tmp_path, scene, results, frame):
    run(scene(duration=0.05), tmp_path / "whole", options=OFTEN)
    place = bytes(open_trajectory(killed.path)[frame].arrays["position"].tobytes())
    flip(killed.trajectory / "0000.gsd", (killed.trajectory / "0000.gsd").read_bytes().index(place))
    assert f"frame {frame} is damaged" in verify(killed.path).faults[0]
    resume(killed.path)
    assert results(killed.path) == results(tmp_path / "whole")
    assert verify(killed.path).sound


def test_a_number_that_was_changed_after_the_run_does_not_survive_resume(killed, tmp_path, scene, results):
    run(scene(duration=0.05), tmp_path / "whole", options=OFTEN)
    lines = killed.scalars.read_text().splitlines(keepends=True)
    killed.scalars.write_text(lines[0] + lines[1].replace("0.01", "0.02", 1) + "".join(lines[2:]))
    assert "line 2: its checksum does not fit its data" in verify(killed.path).faults[0]
    resume(killed.path)
    assert results(killed.path) == results(tmp_path / "whole")


@pytest.mark.parametrize("name", ["traj/0000.gsd", "scalars.jsonl", "ckpt/000000000050.npz"])
def test_a_completed_run_that_is_damaged_is_not_said_to_be_complete(tmp_path, scene, results, name):
    home = RunDirectory(tmp_path / "run")
    run(scene(duration=0.05), home.path, options=OFTEN)
    whole = results(home.path)
    flip(home.path / name, (home.path / name).stat().st_size // 2)
    with pytest.warns(UserWarning, match=rf"{name}: damaged after the run was done"):
        resume(home.path)
    assert results(home.path) == whole
    assert verify(home.path).sound


def test_a_scene_file_that_was_changed_is_not_passed_over(killed):
    killed.scene.write_text(killed.scene.read_text().replace("seed = 7", "seed = 8"))
    with pytest.raises(StorageError, match=r"scene\.toml: damaged: it is not what the run began with"):
        resume(killed.path)


def test_lines_of_another_run_are_found_by_their_frames(killed, tmp_path, scene):
    run(scene(duration=0.05, frame_every=0.005), tmp_path / "other", options=OFTEN)
    lines = RunDirectory(tmp_path / "other").scalars.read_text().splitlines(keepends=True)
    killed.scalars.write_text("".join(lines[:6]))
    assert "line 1: its checksum does not fit its data, or it belongs to another run" in verify(killed.path).faults[0]


def test_frames_that_other_bits_would_compute_are_found_by_deep_alone(killed, monkeypatch):
    assert verify(killed.path).sound
    monkeypatch.setattr(toy, "ROUNDING", 1e-9)
    assert "frame 0, computed again, differs in position" in verify(killed.path, deep=True).faults[0]


def test_a_run_that_is_being_written_is_not_verified(killed):
    with lock.held(killed), pytest.raises(RunExists, match="is being written"):
        verify(killed.path)


def test_the_command_ends_with_a_code(killed):
    ended = CliRunner().invoke(app, ["verify", str(killed.path)])
    assert (ended.exit_code, ended.stdout.splitlines()[-1][-5:]) == (0, "sound")
    assert json.loads(CliRunner().invoke(app, ["verify", str(killed.path), "--json"]).stdout)["sound"] is True
    flip(killed.path / "constants.npz", 100)
    ended = CliRunner().invoke(app, ["verify", str(killed.path), "--json"])
    assert ended.exit_code == StorageError.exit_code
    assert "constants.npz" in json.loads(ended.stdout)["faults"][0]
    assert "ecume verify" in CliRunner().invoke(app, ["info", str(killed.path)]).stdout


DAMAGES = {
    "watch.json": '{"until": 1.0, "policy": "warn", "invariants": [{"name": 3}]}',
    "status.json": '{"step": "many"}',
    "lock": '{"pid": -4, "host": "here", "began": 1.0}',
    "manifest.json": '{"ecume": "0.1.0", "sessions": 5}',
    "resolved.json": "[" * 100_000,
    "FAILED.json": "9" * 5000,
}


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", DAMAGES)
@pytest.mark.parametrize("checked", [True, False], ids=["checked", "of an earlier version"])
def test_what_is_read_is_validated_or_an_error(killed, name, checked):
    if not checked:
        plain = {key: value for key, value in manifest_of(killed).items() if key not in ("format", "scene_sha256")}
        killed.manifest.write_text(json.dumps(plain))
    (killed.path / name).write_text(DAMAGES[name])
    killed.status.unlink(missing_ok=name != "status.json") if name == "lock" else None
    for verb in ("info", "verify", "list", "repair", "resume"):
        ended = CliRunner().invoke(app, [verb, str(killed.path)])
        assert isinstance(ended.exception, SystemExit | None), (verb, ended.exception)
