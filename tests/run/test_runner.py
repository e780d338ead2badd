"""Runs that come to their end, and runs that do not."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import toy

from ecume.errors import BadInput, Diverged, RunExists, SceneError, StorageError
from ecume.models import MODELS
from ecume.run import Progress, RunDirectory, RunOptions, checkpoints, info, resume, run
from ecume.simulation import simulate
from ecume.trajectories.reader import open_trajectory

Scenes = Callable[..., toy.ToyScene]


def test_a_run_leaves_every_frame_and_number_of_its_simulation(tmp_path: Path, scene: Scenes) -> None:
    run(scene(), tmp_path / "run")
    frames = list(simulate(scene()))
    lines = [json.loads(line) for line in (tmp_path / "run" / "scalars.jsonl").read_text().splitlines()]
    with open_trajectory(tmp_path / "run") as trajectory:
        assert len(trajectory) == len(frames) == len(lines) == 51
        for here, there, line in zip(trajectory, frames, lines, strict=True):
            assert here.time == there.time == line["time"]
            assert here.numbers == there.numbers
            assert line["kinetic_energy"] == there.numbers["kinetic_energy"]
            for name, array in there.arrays.items():
                np.testing.assert_array_equal(here.arrays[name], array, strict=True)
        assert trajectory.steps.tolist() == [line["step"] for line in lines] == list(range(0, 501, 10))


def test_a_run_keeps_its_scene_as_it_was_written_and_as_it_was_understood(tmp_path: Path, scene: Scenes) -> None:
    source = b"# my bowl\r\nmodel = 'toy'\n"
    run(scene(duration=0.3), tmp_path / "run", options=RunOptions(source=source))
    assert (tmp_path / "run" / "scene.toml").read_bytes() == source
    with open_trajectory(tmp_path / "run") as trajectory:
        assert trajectory.scene == scene(duration=0.3)


def test_a_finished_run_says_so_with_the_digest_of_each_file(tmp_path: Path, scene: Scenes) -> None:
    result = run(scene(), tmp_path / "run")
    done = json.loads((tmp_path / "run" / "DONE.json").read_text())
    assert (done["reason"], done["frames"], result.frames, result.time) == ("done", 51, 51, 0.5)
    assert {"scene.toml", "resolved.json", "scalars.jsonl", "traj/0000.gsd"} <= done["sha256"].keys()
    seen = info(tmp_path / "run")
    assert (seen.state, seen.frames, seen.step, seen.steps, seen.checkpoint) == ("done", 51, 500, 500, 500)
    assert seen.manifest["seed"] == 7
    assert seen.manifest["sessions"][0]["outcome"] == "done"


def test_resuming_a_finished_run_changes_nothing(tmp_path: Path, scene: Scenes, results: Callable[..., Any]) -> None:
    run(scene(), tmp_path / "run")
    before = results(tmp_path / "run")
    result = resume(tmp_path / "run")
    assert (result.frames, result.seconds) == (51, 0.0)
    assert results(tmp_path / "run") == before


def test_a_run_reports_its_progress(tmp_path: Path, scene: Scenes) -> None:
    output: list[Progress] = []
    run(scene(), tmp_path / "run", options=RunOptions(progress=output.append))
    assert output[0].step == 0
    assert output[0].remaining is None
    assert (output[-1].step, output[-1].steps, output[-1].frames, output[-1].remaining) == (500, 500, 51, 0.0)
    assert output[-1].speed > 0
    status = json.loads((tmp_path / "run" / "status.json").read_text())
    assert (status["state"], status["time"], status["last_checkpoint"]) == ("done", 0.5, 500)


def test_a_run_never_overwrites_another_unless_forced(tmp_path: Path, scene: Scenes) -> None:
    run(scene(seed=1), tmp_path / "run")
    with pytest.raises(RunExists, match="--force"):
        run(scene(seed=2), tmp_path / "run")
    (tmp_path / "run" / "notes.txt").write_text("mine")
    run(scene(seed=2), tmp_path / "run", force=True)
    with open_trajectory(tmp_path / "run") as trajectory:
        assert trajectory.scene.seed == 2
    assert (tmp_path / "run" / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize("name", ["scene.toml", "thesis.tex", "lock"])
def test_force_leaves_alone_what_is_no_run_directory(tmp_path: Path, scene: Scenes, name: str) -> None:
    (tmp_path / name).write_text("precious")
    with pytest.raises(RunExists, match="not a run directory"):
        run(scene(), tmp_path, force=True)
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [(name, "precious")]


def test_a_scene_that_cannot_be_run_leaves_no_directory(tmp_path: Path, scene: Scenes, monkeypatch: Any) -> None:
    def refused(*_: Any) -> None:
        raise SceneError([])

    monkeypatch.setattr(toy, "start", refused)
    monkeypatch.setitem(MODELS, "toy", toy.model())
    with pytest.raises(SceneError):
        run(scene(), tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_run_that_diverges_says_when_who_and_what_to_do_and_keeps_its_frames(tmp_path: Path, scene: Scenes) -> None:
    with pytest.raises(Diverged, match=r"bead 1 .* t = 0\.255 s; take a smaller step"):
        run(scene(blow_up_at=255), tmp_path / "run")
    failed = json.loads((tmp_path / "run" / "FAILED.json").read_text())
    assert failed["exit_code"] == 3
    assert "bead 1 is nowhere at t = 0.255 s" in failed["message"]
    with open_trajectory(tmp_path / "run") as trajectory:
        assert len(trajectory) == 26
        assert np.isfinite(trajectory[-1].arrays["position"]).all()
    seen = info(tmp_path / "run")
    assert (seen.state, seen.frames) == ("failed", 26)
    assert "take a smaller step" in seen.why


def test_a_run_that_has_just_begun_is_one_without_frames(tmp_path: Path, scene: Scenes) -> None:
    run(scene(), tmp_path / "run")
    shutil.rmtree(tmp_path / "run" / "traj")
    (tmp_path / "run" / "DONE.json").unlink()
    assert info(tmp_path / "run").frames == 0
    with open_trajectory(tmp_path / "run") as trajectory:
        assert len(trajectory) == 0
        assert trajectory.scene == scene()


@pytest.mark.long
def test_two_checkpoints_are_kept(tmp_path: Path, scene: Scenes) -> None:
    run(scene(), tmp_path / "run", options=RunOptions(checkpoint_every=0.0))
    steps = [int(path.stem) for path in checkpoints.newest_first(RunDirectory(tmp_path / "run"))]
    assert len(steps) == 2
    assert steps[0] == 500


@pytest.mark.parametrize("threads", [None, 1])
def test_frames_and_numbers_hold_nothing_of_the_wall_clock(
    tmp_path: Path, scene: Scenes, results: Callable[..., Any], threads: int | None
) -> None:
    run(scene(duration=0.1), tmp_path / "slow", options=RunOptions(checkpoint_every=0.0, threads=threads))
    run(scene(duration=0.1), tmp_path / "fast")
    assert results(tmp_path / "slow") == results(tmp_path / "fast")


def test_a_changed_program_is_found_out_when_it_computes_a_frame_again(
    tmp_path: Path, scene: Scenes, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(scene(), tmp_path / "run")
    home = RunDirectory(tmp_path / "run")
    home.done.unlink()
    for path in checkpoints.newest_first(home):
        path.unlink()
    monkeypatch.setattr(toy, "ROUNDING", 1e-9)  # stands for a program that computes otherwise
    with pytest.raises(StorageError, match=r"frame 0 .* differs .* in position by .* fault in memory"):
        resume(tmp_path / "run")
    assert len(open_trajectory(tmp_path / "run")) == 51


def test_what_is_not_finite_is_null_in_the_lines_and_exact_in_the_frames(
    tmp_path: Path, scene: Scenes, monkeypatch: Any
) -> None:
    plain = toy.observe
    monkeypatch.setattr(
        toy, "observe", lambda *given: plain(*given)._replace(numbers={"mean_size": float("nan"), "most": float("inf")})
    )
    monkeypatch.setitem(MODELS, "toy", toy.model())
    run(scene(), tmp_path / "run")
    line = json.loads((tmp_path / "run" / "scalars.jsonl").read_text().splitlines()[0])
    assert (line["mean_size"], line["most"]) == (None, None)
    with open_trajectory(tmp_path / "run") as trajectory:
        assert np.isnan(trajectory.numbers("mean_size")).all()
        assert np.isposinf(trajectory.numbers("most")).all()


@pytest.mark.long
def test_a_run_that_would_take_longer_than_allowed_is_refused_by_its_first_steps(tmp_path, scene, monkeypatch):
    monkeypatch.setattr("ecume.run.progress.SETTLED", 0.0)
    with pytest.raises(
        BadInput, match=r"200[01] steps would take about .* days .* more than 1e-07 days; .* --max-days"
    ):
        run(scene(duration=2.0, rest=0.02), tmp_path / "run", options=RunOptions(longest=1e-7 * 86400.0))
    assert info(tmp_path / "run").state == "interrupted"
    resume(tmp_path / "run")
