"""Obstacles and bodies are drawn in the colors that a scene gives them."""

import numpy as np
import pytest

from ecume.show.sph.picture import liquid_picture
from ecume.show.sph.water import solids_of
from ecume.show.view.page import looks
from ecume.show.view.scenery import sph_stage

from .conftest import frame_of, scene_of

GREEN, PINK = "#00c800", "#ff00c8"
BOX = {"low": [0.2, 0.6], "high": [0.4, 0.8]}
DISC = {"center": [1.0, 0.75], "radius": 0.2}


def lifted(shape):
    """The same in space."""
    return {key: value if key == "radius" else [*value, 0.5 if key != "low" else 0.3] for key, value in shape.items()}


def colored(dimension, obstacle, body):
    """A scene with one of each, and a frame of it."""
    solids = [shape if dimension == 2 else lifted(shape) for shape in (obstacle, body)]
    scene = scene_of(dimension, obstacles=[solids[0] | {"color": GREEN}],
                     bodies=[solids[1] | {"density": 500.0, "color": PINK}])  # fmt: skip
    place = np.zeros(3)
    place[:dimension] = solids[1].get("center") or np.mean([solids[1]["low"], solids[1]["high"]], axis=0)
    pose = {f"body0_{axis}": value for axis, value in zip("xyz", place, strict=True)}
    frame = frame_of(dimension=dimension)
    return scene, frame._replace(numbers=frame.numbers | pose | {"body0_angle": 0.0, "body0_qw": 1.0}
                                 | dict.fromkeys(["body0_qx", "body0_qy", "body0_qz"], 0.0))  # fmt: skip


def seen(pixels, color):
    """How many pixels have it, or nearly."""
    wanted = np.array([int(color[place : place + 2], 16) for place in (1, 3, 5)])
    return int((np.abs(pixels[..., :3].astype(int) - wanted).max(axis=-1) < 60).sum())


@pytest.mark.long
@pytest.mark.parametrize(("dimension", "least"), [(2, 1000), (3, 30)])
@pytest.mark.parametrize("shapes", [(BOX, DISC), (DISC, BOX)], ids=["a ball floats", "a box floats"])
def test_movies_draw_solids_in_their_colors(dimension, least, shapes):
    scene, frame = colored(dimension, *shapes)
    pixels = liquid_picture(scene, [frame]).pixels(frame)
    assert min(seen(pixels, GREEN), seen(pixels, PINK)) > least


@pytest.mark.parametrize("shapes", [(BOX, DISC), (DISC, BOX)], ids=["a ball floats", "a box floats"])
def test_rendered_solids_stand_where_they_are_in_their_colors(shapes):
    scene, frame = colored(3, *shapes)
    turned = {"body0_qw": np.sqrt(0.5), "body0_qz": np.sqrt(0.5)}
    standing, floating = solids_of(scene, frame._replace(numbers=frame.numbers | turned))
    assert (standing.color, floating.color) == (GREEN, PINK)
    middles = {True: [1.0, 0.75, 0.5], False: [0.3, 0.7, 0.4]}
    assert standing.middle == pytest.approx(middles[shapes[0] is DISC])
    assert floating.middle == pytest.approx(middles[shapes[1] is DISC])
    assert floating.turn @ [1.0, 0.0, 0.0] == pytest.approx([0.0, 1.0, 0.0])


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("shapes", [(BOX, DISC), (DISC, BOX)], ids=["a ball floats", "a box floats"])
def test_the_page_receives_the_colors_of_solids(dimension, shapes):
    scene, frame = colored(dimension, *shapes)
    stage = sph_stage(scene, [frame])
    output = looks(frame, frame, stage)
    assert output["painted"] == [PINK] * len(stage.movers(frame))
    assert {line["color"] for line in output["outlines"]} == {None, GREEN}
