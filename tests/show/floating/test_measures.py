"""Figures of what floats come to."""

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.scenes.load import load_scene
from ecume.show.floating.figures import MEASURES, region_of
from ecume.trajectories.frame import Frame

SCENE = """
model = "floating"
duration = 1.0
frame_every = 0.1
[[particles]]
count = 7
radius = 1e-3
density = 1300
contact_angle = "90 deg"
[dish]
radius = 0.02
"""


def frames_of(apart, steps=5):
    """Seven floats around one, nearer from frame to frame; in the end they touch."""
    angles = np.arange(6) * np.pi / 3.0
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    found = []
    for step in range(steps):
        spacing = 2e-3 + apart * (1.0 - step / (steps - 1.0))
        position = np.concatenate([[[0.0, 0.0]], spacing * ring])
        found.append(Frame(0.1 * step, {"position": position, "radius": np.full(7, 1e-3)}, {}, {}))
    return found


@pytest.mark.parametrize("name", MEASURES)
def test_each_measure_is_drawn(name):
    drawn = MEASURES[name](frames_of(3e-3), load_scene(SCENE))
    assert drawn.axes[0].get_xlabel()
    assert drawn.axes[0].get_ylabel()


@pytest.mark.parametrize("name", ["approach", "shapes", "displacement"])
def test_what_there_is_nothing_of_is_said(name):
    still = frames_of(3e-3)[:1] * 3
    with pytest.raises(BadInput, match=r"no (approach|rafts|displacement) to draw"):
        MEASURES[name](still, load_scene(SCENE))


def test_centers_reach_a_radius_less_far_than_the_dish():
    scene = load_scene(SCENE)
    assert region_of(frames_of(0.0)[0], scene).radius == pytest.approx(0.019)
