"""`ecume check` foresees events in every model: whether a run shows them."""

import math

import pytest

from ecume.models import MODELS
from ecume.models.expected_events import event_row
from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder

EVENTS = {
    "two-spheres": ("first contact", "after about 1 s"),
    "dam-break": ("first impact", "not before 290 ms"),
    "floating-bodies": ("first impact", "after about 160 ms"),
    "pressed-packing": ("strain of 1", "after about 4 s"),
    "sheared-packing": ("strain of 1", "after about 4 s"),
    "settling": ("20 um: settles", "after about 6.1 s"),
}
"""By hand: fronts of 2 sqrt(g h) over 1.01 m with h = 0.3 m, a disc that falls by 0.125 m, a strain rate of 0.25/s,
and 2 mm at 0.327 mm/s, the speed by Stokes of quartz of 2500 kg/m^3.
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


def test_an_event_that_never_comes_has_no_row():
    assert event_row("first impact", math.inf, (1.0, 0.1), "") == event_row("first impact", 0.0, (1.0, 0.1), "") == []
