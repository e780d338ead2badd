"""Image numbers of particles in periodic boxes: positions and image numbers together are paths without jumps."""

import numpy as np
import pytest

import ecume
from ecume.analysis.series import tracks
from ecume.scenes.load import load_scene
from ecume.simulation import moments

FLOATS = """\
model = "floating"
duration = 0.4
frame_every = 0.1
[cell]
size = [0.01, 0.008]
[[particles]]
radius = 1e-3
density = 1250.0
contact_angle = 1.5707963
positions = [[0.009, 0.004]]
velocities = [[0.07, 0.0]]
[interaction]
law = "none"
[flow]
velocity = [0.07, 0.0]
"""
TANK = """\
model = "sph"
duration = 0.05
frame_every = 0.01
spacing = 0.1
gravity = [0.0, 0.0]
[tank]
high = [1.0, 1.0]
left = { kind = "periodic" }
right = { kind = "periodic" }
bottom = { kind = "periodic" }
top = { kind = "periodic" }
[[fluid]]
low = [0.0, 0.0]
high = [1.0, 1.0]
velocity = [7.0, -3.0]
[liquid]
sound_speed = 100.0
"""


@pytest.mark.compiled
@pytest.mark.parametrize(("text", "velocity"), [(FLOATS, (0.07, 0.0)), (TANK, (7.0, -3.0))])
def test_particles_that_drift_across_borders_go_straight_on(text, velocity):
    frames = list(ecume.simulate(load_scene(text)))
    found, times = tracks(frames), np.array([frame.time for frame in frames])
    assert np.abs(frames[-1].arrays["image"]).max() >= 1
    assert found - found[0] == pytest.approx(
        np.broadcast_to(times[:, None, None] * np.array(velocity), found.shape), rel=1e-6, abs=1e-9
    )


@pytest.mark.compiled
def test_image_numbers_of_a_tank_go_on_after_a_pause_bit_for_bit():
    scene = load_scene(TANK)
    whole, kept = None, None
    for moment in moments(scene):
        whole = moment.state
        if moment.frame is not None and moment.frame.time > 0.015 and kept is None:
            kept = type(whole)(*(array.copy() for array in whole))
    assert kept is not None
    assert np.any(kept.image)
    for moment in moments(scene, state=kept):
        again = moment.state
    assert all(np.array_equal(one, other) for one, other in zip(whole, again, strict=True))
