"""Every model ends at a duration that is no multiple of the time between frames, also when it is resumed there."""

import os

import pytest

from ecume.errors import Stopped
from ecume.run import RunOptions, resume, run
from ecume.run.lock import ask_to_stop
from ecume.scenes.load import load_scene
from ecume.simulation import moments, simulate
from ecume.trajectories.reader import open_trajectory

FLOATING = """
model = "floating"
duration = "{duration}"
frame_every = "30 ms"
[dish]
radius = "2 cm"
[[particles]]
radius = "1 mm"
density = 600
contact_angle = "70 deg"
positions = [[0.0, 0.0], [0.004, 0.0]]
"""
SOFT = """
model = "soft"
duration = "{duration}"
frame_every = "30 ms"
[liquid]
viscosity = "1 Pa*s"
[[particles]]
radius = "1 mm"
modulus = "1 kPa"
positions = [[0.0, 0.0], [0.00202, 0.0]]
force = [0.0, 0.0]
"""
SPH = """
model = "sph"
duration = "{duration}"
frame_every = "30 ms"
spacing = "0.5 m"
[liquid]
sound_speed = 50.0
[tank]
low = [0.0, 0.0]
high = [2.0, 2.0]
[[fluid]]
low = [0.0, 0.0]
high = [2.0, 1.0]
"""
TRACERS = """
model = "tracers"
duration = "{duration}"
frame_every = "30 ms"
[liquid]
name = "water"
[[particles]]
radius = "10 um"
density = 2000
positions = [[0.0, 0.0, 0.0]]
"""
SCENES = {"floating": FLOATING, "soft": SOFT, "sph": SPH, "tracers": TRACERS}


@pytest.fixture(params=SCENES)
def scene(request):
    """A scene of three frames, and a third of one."""
    return load_scene(SCENES[request.param].format(duration="100 ms"))


def test_a_last_frame_is_added_at_the_end(scene):
    assert [frame.time for frame in simulate(scene)] == [0.0, 0.03, 0.06, 0.09, 0.1]


def test_a_run_that_is_stopped_before_its_last_frame_has_the_same_frames(scene, tmp_path):
    whole = list(simulate(scene))

    def stop(progress):
        if progress.frames == 4:
            ask_to_stop(os.getpid())

    with pytest.raises(Stopped):
        run(scene, tmp_path / "run", options=RunOptions(progress=stop))
    done = resume(tmp_path / "run")
    assert (done.frames, done.time) == (5, 0.1)
    with open_trajectory(tmp_path / "run") as trajectory:
        assert trajectory.times.tolist() == [0.0, 0.03, 0.06, 0.09, 0.1]
        for frame, expected in zip(trajectory, whole, strict=True):
            assert (frame.arrays["position"] == expected.arrays["position"]).all()


def test_an_end_between_two_steps_is_at_the_nearest_one():
    scene = load_scene(SPH.format(duration="97.1311 ms"))
    *_, last = moments(scene)
    step = last.parameters.time_step
    assert last.frame.time == pytest.approx(0.0971311, abs=0.5 * step)
    assert last.frame.time == pytest.approx(last.step * step, rel=1e-12)


def test_soft_spheres_end_exactly_however_short_the_rest_is():
    scene = load_scene(SOFT.format(duration="60.00001 ms"))
    assert [frame.time for frame in simulate(scene)] == [0.0, 0.03, 0.06, 0.06000001]
