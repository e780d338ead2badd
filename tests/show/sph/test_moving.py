"""Bodies and moving sides in pictures of liquids."""

import numpy as np
import pytest

import ecume
from ecume.models.sph.boundaries.rigid_bodies import rotations
from ecume.scenes.schema import from_plain
from ecume.show.sph.picture import liquid_picture
from ecume.show.sph.solids import movers_of, turned

PLAIN = {
    "model": "sph",
    "duration": 0.1,
    "frame_every": 0.1,
    "spacing": 0.1,
    "liquid": {"maximum_speed": 2.0},
}


def in_space():
    return from_plain(
        PLAIN
        | {
            "tank": {
                "low": [0.0, 0.0, 0.0],
                "high": [1.0, 1.0, 0.5],
                "top": {"kind": "open"},
                "left": {"kind": "inflow", "speed": 0.5, "level": 0.3},
                "right": {"kind": "outflow", "level": 0.3},
            },
            "fluid": [{"low": [0.0, 0.0, 0.0], "high": [1.0, 0.3, 0.5], "velocity": [0.5, 0.0, 0.0]}],
            "obstacles": [{"low": [0.6, 0.0, 0.1], "high": [0.9, 0.2, 0.4]}],
            "bodies": [
                {"low": [0.2, 0.6, 0.1], "high": [0.4, 0.8, 0.4], "density": 500.0, "spin": [1.0, 2.0, 3.0]},
                {"center": [0.7, 0.5, 0.25], "radius": 0.15, "density": 2000.0},
            ],
        }
    )


def in_the_plane():
    return from_plain(
        PLAIN
        | {
            "tank": {
                "low": [0.0, 0.0],
                "high": [1.0, 1.0],
                "top": {"kind": "open"},
                "left": {"motion": {"times": [0.0, 0.1], "positions": [0.0, 0.05]}},
            },
            "fluid": [{"low": [0.0, 0.0], "high": [1.0, 0.3]}],
            "bodies": [{"low": [0.3, 0.4], "high": [0.5, 0.5], "density": 500.0, "spin": 5.0}],
        }
    )


@pytest.mark.compiled
def test_an_outline_is_where_its_body_is():
    scene = in_the_plane()
    frames = list(ecume.simulate(scene))
    box, side = movers_of(scene)(frames[-1])
    numbers = frames[-1].numbers
    assert numbers["body0_angle"] == pytest.approx(0.5, abs=0.1)
    np.testing.assert_allclose(box.mean(axis=0), [numbers["body0_x"], numbers["body0_y"]])
    along = box[1] - box[0]
    assert np.arctan2(along[1], along[0]) == pytest.approx(numbers["body0_angle"])
    assert side[:, 0].max() == pytest.approx(0.05)
    assert liquid_picture(scene, frames).pixels(frames[-1]).shape[2] == 4


def test_a_picture_turns_bodies_as_the_model_does():
    turn = np.array([0.5, -0.1, 0.7, 0.5]) / np.linalg.norm([0.5, -0.1, 0.7, 0.5])
    pose = np.array([[0.0, 0.0, 0.0, *turn]]).T
    np.testing.assert_allclose(turned(list(turn)), rotations(pose)[0], atol=1e-15)


@pytest.mark.long
@pytest.mark.compiled
def test_bodies_in_space_turn_and_are_drawn():
    scene = in_space()
    frames = list(ecume.simulate(scene))
    numbers = frames[-1].numbers
    assert numbers["particles_entered"] > 0
    turn = turned([numbers[f"body0_q{part}"] for part in "wxyz"])
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert numbers["body0_qw"] == pytest.approx(np.cos(0.05 * np.sqrt(14.0)), abs=0.01)
    assert numbers["body0_y"] == pytest.approx(0.7 - 0.5 * 9.81 * 0.01, abs=1e-4)
    assert liquid_picture(scene, frames).pixels(frames[-1]).shape[2] == 4
