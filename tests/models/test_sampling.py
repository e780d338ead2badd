"""Samples between frames in every model: they change no bit of a run, and survive a stop."""

import os

import pytest

from ecume.errors import Stopped
from ecume.models.step_counts import BEFORE
from ecume.run import RunDirectory, RunOptions, resume, run
from ecume.run.lock import ask_to_stop
from ecume.scenes.load import load_scene
from ecume.simulation import moments
from ecume.trajectories.reader import open_trajectory

from .test_last_frame import SCENES

TABLE = """
[output.samples]
every = "7 ms"
block = 4
"""


@pytest.fixture(params=SCENES)
def scene(request):
    """A scene of three frames with about fourteen samples in blocks of four."""
    return load_scene(SCENES[request.param].format(duration="90 ms") + TABLE)


def test_samples_change_no_frame(scene):
    plain = [moment.frame for moment in moments(scene) if moment.frame is not None]
    sampled = list(moments(scene, sampled=BEFORE))
    frames = [moment.frame for moment in sampled if moment.frame is not None]
    assert len([moment for moment in sampled if moment.sample is not None]) >= 3
    for one, other in zip(plain, frames, strict=True):
        assert one.numbers == pytest.approx(other.numbers, rel=0, abs=0, nan_ok=True)
        assert all(array.tobytes() == other.arrays[name].tobytes() for name, array in one.arrays.items())


@pytest.mark.sampled(3)
def test_a_stopped_run_has_the_samples_of_one_that_was_not(scene, tmp_path):
    run(scene, tmp_path / "whole")

    def stop(progress):
        if progress.frames == 2:
            ask_to_stop(os.getpid())

    with pytest.raises(Stopped):
        run(scene, tmp_path / "run", options=RunOptions(progress=stop))
    resume(tmp_path / "run")
    whole, stopped = (RunDirectory(tmp_path / name).samples.read_bytes() for name in ("whole", "run"))
    assert stopped == whole
    with open_trajectory(tmp_path / "run") as trajectory:
        counts = trajectory.samples.counts
        assert (counts[:-1] == 4).all()
        assert counts.sum() == len([moment for moment in moments(scene, sampled=BEFORE) if moment.sample is not None])
        assert set(trajectory.samples.names) == set(trajectory[0].numbers)
