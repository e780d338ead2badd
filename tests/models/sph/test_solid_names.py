"""Obstacles and bodies have names: in numbers of frames, figures, pages and messages."""

import dataclasses

import pytest

import ecume
from ecume.errors import SceneError
from ecume.models.sph.record import SPH
from ecume.scenes.schema import from_plain
from ecume.scenes.sph.solids import QUANTITY, TAKEN
from ecume.show.sph import figures
from ecume.show.sph.solids import body_lines
from ecume.show.view.scenery import sph_stage

POST = {"name": "front_post", "low": [0.55, 0.0], "high": [0.65, 0.4]}
RAFT = {"name": "raft", "center": [0.25, 0.3], "radius": 0.05, "density": 500.0}
PLAIN = {
    "model": "sph", "duration": 0.01, "frame_every": 0.01, "spacing": 0.05,
    "tank": {"low": [0.0, 0.0], "high": [1.0, 1.0]}, "liquid": {"maximum_speed": 1.0},
    "fluid": [{"low": [0.0, 0.0], "high": [0.5, 0.3]}], "obstacles": [POST], "bodies": [RAFT],
}  # fmt: skip


def last(**more):
    scene = from_plain({**PLAIN, **more})
    return scene, list(ecume.simulate(scene))


@pytest.mark.long
def test_numbers_figures_and_pages_have_the_names_of_solids():
    scene, frames = last()
    numbers, units = frames[-1].numbers, frames[-1].units
    assert {"front_post_force_x", "front_post_hits", "raft_x", "raft_angle", "raft_velocity_y"} <= numbers.keys()
    assert not [name for name in numbers if name.startswith(("obstacle", "body"))]
    kinds = ("front_post_force_x", "raft_force_y", "raft_x", "raft_velocity_y", "raft_angle", "raft_spin_z")
    assert [units[name] for name in kinds] == ["N/m", "N/m", "m", "m/s", "rad", "1/s"]
    labels = [line.get_label() for axes in figures.forces(frames, scene).axes for line in axes.lines]
    assert labels == ["front_post, x", "front_post, y", "raft, x", "raft, y"]
    (line,) = body_lines(scene.bodies[0], "raft", frames[-1], None)
    assert line.mean(axis=0) == pytest.approx([numbers["raft_x"], numbers["raft_y"]], abs=2e-3)
    sph_stage(scene, frames).movers(frames[-1])
    figures.snapshot(frames, scene)


@pytest.mark.long
def test_the_numbers_of_a_named_solid_are_those_of_one_without_a_name():
    named = last()[1][-1].numbers
    plain = last(**{key: [{k: v for k, v in PLAIN[key][0].items() if k != "name"}] for key in ("obstacles", "bodies")})
    found = {name.replace("front_post", "obstacle0").replace("raft", "body0"): value for name, value in named.items()}
    assert found == plain[1][-1].numbers


@pytest.mark.parametrize(
    ("more", "path"),
    [
        ({"obstacles": [{**POST, "name": "left"}]}, "obstacles[0].name"),
        ({"obstacles": [{**POST, "name": "obstacle3"}]}, "obstacles[0].name"),
        ({"bodies": [{**RAFT, "name": "front_post"}]}, "bodies[0].name"),
        ({"gauges": [{"name": "raft", "position": [0.1, 0.1]}]}, "bodies[0].name"),
        ({"obstacles": [{**POST, "name": "raft_velocity"}]}, "obstacles[0].name"),
        ({"obstacles": [{**POST, "name": "the post"}]}, "obstacles[0].name"),
    ],
)
def test_names_that_numbers_or_others_have_are_refused(more, path):
    with pytest.raises(SceneError, match=path.replace("[", r"\[").replace("]", r"\]")):
        from_plain({**PLAIN, **more})


@pytest.mark.parametrize("name", ["the post", "pfähle", "post.1", "1st", "_post", "post-1"])
def test_a_name_with_other_characters_is_told_what_it_may_have(name):
    with pytest.raises(SceneError, match=r"expected a letter of A to Z or a to z, then such letters, digits and _"):
        from_plain({**PLAIN, "obstacles": [{**POST, "name": name}]})


@pytest.mark.long
def test_a_solid_named_like_any_number_is_refused_or_hides_none():
    """Whatever begins a number of a frame: a solid of this name is refused, or all numbers are still there."""
    _, frames = last()
    begins = {name[:at] for name in frames[-1].numbers for at, letter in enumerate(name) if letter == "_"}
    own = {"front_post", "raft", "front"}
    parameters = SPH.parameters(from_plain(PLAIN))
    assert parameters.boundary.names[-2:] == ("front_post", "raft")
    kinds = [name.removeprefix("raft") for name in frames[-1].numbers if name.startswith("raft_")]
    others = {name for name in frames[-1].numbers if not name.startswith(("front_post", "raft"))}
    for name in sorted(begins - own):
        clash = [name + kind for kind in kinds if name + kind in others]
        assert not clash or TAKEN.fullmatch(name) or QUANTITY.fullmatch(name), clash


def test_messages_call_solids_by_their_names():
    scene = from_plain({**PLAIN, "bodies": [{**RAFT, "center": [0.6, 0.2]}]})
    with pytest.raises(SceneError, match="inside front_post"):
        SPH.parameters(scene)
    assert dataclasses.replace(scene, bodies=()).solid_labels == ("front_post",)
