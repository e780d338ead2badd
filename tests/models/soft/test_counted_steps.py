"""A run of soft spheres counts its accepted time steps."""

import json

import pytest

from ecume.errors import Stopped
from ecume.models.soft.record import SOFT
from ecume.models.soft.state import ACCEPTED
from ecume.run import RunOptions, info, resume, run
from ecume.run.checkpoints import newest
from ecume.run.directory import RunDirectory
from ecume.run.lock import ask_to_stop
from ecume.scenes.load import load_scene
from ecume.trajectories.reader import open_trajectory

SCENE = """
model = "soft"
duration = "4 s"
frame_every = "0.5 s"
[liquid]
viscosity = "1 Pa*s"
[[particles]]
radius = "1 mm"
modulus = "1 kPa"
positions = [[0.0, 0.0], [0.00201, 0.0]]
force = [0.0, 0.0]
[[particles]]
radius = "1 mm"
modulus = "1 kPa"
positions = [[0.00402, 0.0]]
force = [0.0, 0.0]
"""


def counted(home):
    """The steps in the lines of numbers and in the frames."""
    lines = [json.loads(line)["step"] for line in RunDirectory(home).scalars.read_text().splitlines()]
    with open_trajectory(home) as trajectory:
        assert trajectory.steps.tolist() == lines
    return lines


def accepted(home):
    """The steps in the newest checkpoint."""
    checkpoint = newest(RunDirectory(home), SOFT.state, 10**9, lambda path, fault: pytest.fail(fault))
    assert checkpoint.step == checkpoint.state.tally[ACCEPTED] < checkpoint.state.step[0]
    return checkpoint.step


def test_frames_reports_and_checkpoints_count_the_steps_that_were_taken(tmp_path):
    done = run(load_scene(SCENE), tmp_path / "run")
    steps = counted(tmp_path / "run")
    assert steps == sorted(set(steps))  # at least one step per frame
    assert done.steps == steps[-1] == accepted(tmp_path / "run") < 1024
    seen = info(tmp_path / "run")
    assert (seen.step, seen.steps, seen.checkpoint) == (done.steps, done.steps, done.steps)


@pytest.mark.long
def test_a_run_that_is_stopped_reports_its_steps_and_no_total(tmp_path):
    import os

    def stop(progress):
        assert progress.steps is None or progress.time == progress.duration
        if progress.time >= 2.0:
            ask_to_stop(os.getpid())

    with pytest.raises(Stopped, match=r"at t = 2 s \(step \d+\)"):
        run(load_scene(SCENE), tmp_path / "run", options=RunOptions(progress=stop))
    seen = info(tmp_path / "run")
    assert (seen.state, seen.steps, seen.step) == ("stopped", None, seen.checkpoint)
    assert accepted(tmp_path / "run") == seen.step < 1024
    assert seen.manifest["sessions"][-1]["to_step"] == seen.step
    resume(tmp_path / "run")
    run(load_scene(SCENE), tmp_path / "whole")
    assert counted(tmp_path / "run") == counted(tmp_path / "whole")
