"""`ecume check` foresees events in every model: whether a run shows them."""

import math

import pytest

from ecume.models import MODELS
from ecume.models.expected_events import event_row
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain
from ecume.scenes.templates import folder

EVENTS = {
    "two-spheres": ("first contact", "after about 1 s"),
    "dam-break": ("first impact", "not before 290 ms"),
    "floating-bodies": ("first impact", "after about 160 ms"),
    "pressed-packing": ("strain of 1", "after about 4 s"),
    "sheared-packing": ("strain of 1", "after about 4 s"),
    "settling": ("20 um: settles", "after about 6.1 s"),
    "bouncing-particles": ("steel: settles", "after about 290 ms"),
}
"""By hand: fronts of 2 sqrt(g h) over 1.01 m with h = 0.3 m, a disc that falls by 0.125 m, a strain rate of 0.25/s,
2 mm at 0.327 mm/s, the speed by Stokes of quartz of 2500 kg/m^3, and a free fall from 0.4 m in air.
"""


def said(name, *changes):
    scene = load_scene(folder() / f"{name}.toml", changes)
    return {row[0]: row[1:] for row in MODELS[scene.model].summary(scene)}


@pytest.mark.parametrize("name", EVENTS)
def test_the_first_event_is_foreseen(name):
    row, time = EVENTS[name]
    assert said(name)[row][0] == time


@pytest.mark.parametrize(
    ("name", "changes", "remark"),
    [
        ("dam-break", ["duration=0.2 s"], "after the end of the run; duration 350 ms shows it"),
        ("dam-break", ["frame_every=50 ms"], "frame_every 6 ms would show it"),
        ("sheared-packing", ["frame_every=2 s"], "duration 8 s and frame_every 80 ms would show it"),
        ("settling", ["duration=5 s"], "after the end of the run; duration 7.4 s shows it"),
    ],
)
def test_a_run_that_does_not_show_it_is_told_so(name, changes, remark):
    assert said(name, *changes)[EVENTS[name][0]][1] == remark


@pytest.mark.parametrize("name", ["tank-at-rest", "sloshing", "lifting-gate", "taylor-green", "dye-channel", "t1"])
def test_nothing_is_foreseen_where_nothing_falls_settles_or_is_sheared(name):
    assert not {row for row in said(name) if row.startswith(("first", "strain")) or row.endswith(("settles", "rises"))}


TANK = {
    "model": "sph", "duration": 2.0, "frame_every": 0.02, "spacing": 0.05, "liquid": {"maximum_speed": 3.0},
    "tank": {"low": [0.0, 0.0], "high": [1.0, 1.0]},
}  # fmt: skip
ABOVE, AFLOAT, SUNK = ([{"low": [0.4, low], "high": [0.6, low + 0.2], "density": 500.0}] for low in (0.7, 0.4, 0.2))
POOL = [{"low": [0.0, 0.0], "high": [1.0, 0.5]}]
COLUMN = [{"low": [0.0, 0.0], "high": [0.3, 0.5]}]
BLOCK = [{"low": [0.3, 0.5], "high": [0.7, 0.8]}]
PUDDLE = {"surface_tension": 0.0728, "density": 1000.0, "maximum_speed": 0.5}


def events(plain):
    scene = from_plain(plain)
    return [row[1] for row in MODELS[scene.model].summary(scene) if row[0] == "first impact" or "settles" in row[0]]


@pytest.mark.parametrize(
    ("changes", "times"),
    [
        ({"fluid": POOL, "bodies": ABOVE}, ["after about 200 ms"]),
        ({"fluid": POOL, "bodies": AFLOAT}, []),
        ({"fluid": POOL, "bodies": SUNK}, []),
        ({"fluid": BLOCK}, ["after about 320 ms"]),
        ({"fluid": BLOCK, "obstacles": [{"low": [0.3, 0.1], "high": [0.7, 0.3]}]}, ["after about 200 ms"]),
        ({"fluid": BLOCK, "tank": {**TANK["tank"], "bottom": {"kind": "open"}}}, []),
        ({"fluid": COLUMN}, ["not before 160 ms"]),
        ({"fluid": [{**COLUMN[0], "velocity": [5.0, 0.0]}]}, []),
        ({"fluid": COLUMN, "base_excitation": {"amplitude": [5.0, 0.0], "frequency": 1.0}}, []),
        ({"fluid": COLUMN, "tank": {**TANK["tank"], "left": {"motion": {"amplitude": 0.1, "frequency": 1.0}}}}, []),
        ({"fluid": [{"low": [0.0, 0.0], "high": [0.01, 0.005]}], "spacing": 1e-3, "liquid": PUDDLE,
          "tank": {"low": [0.0, 0.0], "high": [0.03, 0.02]}}, []),
    ],
)  # fmt: skip
def test_what_floats_rests_or_is_driven_has_no_first_impact(changes, times):
    """Bodies in a pool fell to its bottom, blocks fell through obstacles, and fronts of liquid with a speed had the
    bound of one at rest.
    """
    assert events(TANK | changes) == times


@pytest.mark.parametrize(
    ("tank", "upward", "times"),
    [({}, 0.0, ["after about 6.1 s"]), ({"periodic": ["x"]}, 0.0, ["after about 6.1 s"]),
     ({"periodic": ["y"]}, 0.0, []), ({}, 1e-3, []), ({}, -1e-3, ["after about 1.5 s"])],
)  # fmt: skip
def test_particles_settle_onto_a_bottom_and_against_the_flow(tank, upward, times):
    plain = {
        "model": "tracers", "duration": 20.0, "frame_every": 0.1, "flow": {"velocity": [0.0, upward]},
        "tank": {"high": [2e-3, 2e-3], **tank},
        "particles": [{"name": "silt", "count": 3, "radius": 1e-5, "density": 2500.0}],
    }  # fmt: skip
    assert events(plain) == times


def test_an_event_that_never_comes_has_no_row():
    assert event_row("first impact", math.inf, (1.0, 0.1), "") == event_row("first impact", 0.0, (1.0, 0.1), "") == []
