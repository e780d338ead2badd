"""Runs of former versions can be opened, and resumed to their end, on any processor."""

import json
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest

import ecume
from ecume.models import MODELS
from ecume.run import RunDirectory, checkpoints, info, resume
from ecume.trajectories.reader import open_trajectory

HOME = Path(__file__).parent
RUNS = sorted(path.parent for path in HOME.glob("*/*/manifest.json"))


def newest_checkpoint(home):
    """The checkpoint from which a run is resumed."""
    model = json.loads((home / "manifest.json").read_text())["model"]
    found = checkpoints.newest(RunDirectory(home), MODELS[model].state, 10**9, lambda path, fault: pytest.fail(fault))
    assert found is not None
    return found


def test_this_version_has_left_a_run_of_each_model():
    assert {path.name for path in RUNS if path.parent.name == ecume.__version__} == {
        "floating",
        "sph",
        "soft",
        "tracers",
    }


@pytest.mark.compiled
@pytest.mark.parametrize("golden", RUNS, ids=lambda path: path.relative_to(HOME).as_posix())
def test_a_run_of_that_version_is_read_and_resumed(golden, tmp_path):
    home = tmp_path / "run"
    shutil.copytree(golden, home)
    lines = [json.loads(line) for line in (golden / "scalars.jsonl").read_text().splitlines()]
    with open_trajectory(home) as trajectory:
        before = list(trajectory)
        assert [frame.time for frame in before] == [line["time"] for line in lines]
        assert len(before) > 1
        assert trajectory.scene.model == golden.name
    assert info(home).state in ("killed", "stopped")
    checkpoint = newest_checkpoint(home).frames
    with (
        warnings.catch_warnings()
    ):  # of other last digits, if this is another processor than the one they were begun on
        warnings.filterwarnings("ignore", message=".*differs from the one on disk|.*constants are derived again")
        done = resume(home)
    assert info(home).state == "done"
    assert done.frames > len(before)
    assert not list((home / "ckpt").glob("*.damaged"))
    with open_trajectory(home) as trajectory:
        replaced = json.loads((home / "manifest.json").read_text())["sessions"][-1].get("replaced")
        first = replaced["frame"] if replaced else len(before)
        assert first >= checkpoint
        for number, (frame, former) in enumerate(zip(trajectory, before, strict=False)):
            here, there = frame.arrays["position"], former.arrays["position"]
            np.testing.assert_allclose(
                here, there, rtol=0.0, atol=0.0 if number < first else 1e-9 * np.abs(there).max()
            )
        assert np.isfinite(trajectory[-1].arrays["position"]).all()
