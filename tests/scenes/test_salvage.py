"""Faults of a whole scene beside syntax errors and misspelt keys."""

from pathlib import Path

import pytest

from ecume.errors import Fault, SceneError
from ecume.scenes.valid_part import QUICK, load_and_examine

GOOD = """model = "floating"
duration = "1 s"
frame_every = "0.1 s"
[dish]
radius = "4 cm"
[[particles]]
radius = "1.5 mm"
density = 300
contact_angle = "70 deg"
count = 2
"""
HUGE = 'radius = "1.5 mm"', "radius = 1"
TYPOS = [
    ('frame_every = "0.1 s"', 'frame_evry = "0.1 s"', "did you mean frame_every"),
    ("count = 2", "cuont = 2", "did you mean count"),
    ("count = 2", 'count = 2\nseveral = "yes"', "no such key"),
    ("count = 2", "count = 2\nvolume = nonsense", "is not TOML"),
    ("[dish]", "[dish]\ndepth ==", "is not TOML"),
    ("count = 2", 'count = 2\ncolor = "nocolor"', "nocolor"),
]
WITHOUT_PHYSICS = [
    ('radius = "1.5 mm"', "radius = 1.5 mm", "is not TOML"),
    ('model = "floating"', "model = floating", "is not TOML"),
    ("[dish]", "[[dish]]", "write [dish] with one pair of brackets"),
    ("[[particles]]", "[particles]", "write [[particles]] with two brackets"),
]
"""Faults that leave no valid part."""


def physics(scene):
    """Refuse floats of a meter, as a model does."""
    faults = [
        Fault(f"particles[{index}].radius", "is it in meters?")
        for index, one in enumerate(scene.particles)
        if one.radius > 0.5
    ]
    if faults:
        raise SceneError(faults)


def faults_of(text, folder: Path):
    """All that is reported of a file with this text."""
    file = folder / "scene.toml"
    file.write_text(text)
    with pytest.raises(SceneError) as error:
        load_and_examine(file, [], physics)
    return error.value.faults


@pytest.mark.parametrize(("old", "new", "says"), TYPOS)
def test_a_fault_of_the_text_does_not_hide_one_of_the_physics(old, new, says, tmp_path):
    faults = faults_of(GOOD.replace(*HUGE).replace(old, new, 1), tmp_path)
    output = [str(fault) for fault in faults]
    assert len(output) == 2
    assert any(says in one for one in output)
    (physical,) = (fault for fault in faults if "in meters" in fault.message)
    assert (physical.path, physical.line) == ("particles[0].radius", 8 if "depth" in new else 7)


def test_several_faults_of_each_kind_are_reported_in_the_order_of_the_file(tmp_path):
    text = (
        GOOD.replace(*HUGE).replace("count = 2", "cuont = 2\nvolume = nonsense").replace("[dish]", "[dish]\ndepth ==")
    )
    faults = faults_of(text, tmp_path)
    assert [fault.line for fault in faults] == [5, 8, 11, 12]


@pytest.mark.parametrize(("old", "new", "says"), TYPOS + WITHOUT_PHYSICS)
def test_what_is_right_but_for_its_text_has_that_fault_only(old, new, says, tmp_path):
    (fault,) = faults_of(GOOD.replace(old, new, 1), tmp_path)
    assert says in str(fault)


def test_a_list_of_species_that_begins_as_a_table_has_one_fault(tmp_path):
    more = "[[particles]]\nradius = 1e-3\ndensity = 300\ncontact_angle = 1\ncount = 1\n"
    (fault,) = faults_of(GOOD.replace("[[particles]]", "[particles]") + more, tmp_path)
    assert "two brackets" in fault.message


def test_a_short_list_that_is_refused_is_printed(tmp_path):
    tank = 'model = "sph"\nduration = 1\nframe_every = 1\nspacing = 0.1\n[tank]\nhigh = ["1 m", "1 m"]\n'
    (fault,) = faults_of(tank + '[[fluid]]\nlow = ["0 m", "O m"]\nhigh = ["1 m", "1 m"]\n', tmp_path)
    assert fault.path == "fluid[0].low"
    assert fault.message.startswith("got ['0 m', 'O m']; ")


def test_a_scene_that_lacks_something_has_no_valid_part(tmp_path):
    faults = faults_of(GOOD.replace("density = 300\n", "").replace(*HUGE), tmp_path)
    assert [fault.path for fault in faults] == ["particles[0].density"]


def test_a_good_scene_is_loaded(tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(GOOD)
    assert load_and_examine(file, [], physics).particles[0].count == 2
    with pytest.raises(SceneError, match="cannot be read"):
        load_and_examine(tmp_path / "nothing.toml", [], physics)


@pytest.mark.parametrize(("count", "found"), [(QUICK, 2), (QUICK + 1, 1)])
def test_nothing_is_placed_for_more_particles_than_is_quick(count, found, tmp_path):
    """A misspelt key is reported for any number; what only the placed particles show, for few."""
    text = GOOD.replace(*HUGE).replace("frame_every", "frame_evry").replace("count = 2", f"count = {count}")
    assert len(faults_of(text, tmp_path)) == found
