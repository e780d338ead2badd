"""Runs that former versions left behind are opened, and gone on with to their end."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import ecume
from ecume.run import info, resume
from ecume.trajectories.reader import open_trajectory

HOME = Path(__file__).parent
RUNS = sorted(path.parent for path in HOME.glob("*/*/manifest.json"))


def test_this_version_has_left_a_run_of_each_model():
    assert {path.name for path in RUNS if path.parent.name == ecume.__version__} == {
        "floating",
        "sph",
        "soft",
        "tracers",
    }


@pytest.mark.compiled
@pytest.mark.parametrize("golden", RUNS, ids=lambda path: path.relative_to(HOME).as_posix())
def test_a_run_of_that_version_is_read_and_gone_on_with(golden, tmp_path):
    home = tmp_path / "run"
    shutil.copytree(golden, home)
    lines = [json.loads(line) for line in (golden / "scalars.jsonl").read_text().splitlines()]
    with open_trajectory(home) as trajectory:
        before = list(trajectory)
        assert [frame.time for frame in before] == [line["time"] for line in lines]
        assert len(before) > 1
        assert trajectory.scene.model == golden.name
    assert info(home).state in ("killed", "stopped")
    done = resume(home)
    assert info(home).state == "done"
    assert done.frames > len(before)
    assert not list((home / "ckpt").glob("*.damaged"))
    with open_trajectory(home) as trajectory:
        for frame, former in zip(trajectory, before, strict=False):
            np.testing.assert_array_equal(frame.arrays["position"], former.arrays["position"])
        assert np.isfinite(trajectory[-1].arrays["position"]).all()
