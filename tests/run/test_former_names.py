"""Files of runs of former versions, whose fields had other names."""

import json
from pathlib import Path

import numpy as np
import pytest

from ecume.models import MODELS
from ecume.run.archives import FORMER_NAMES, with_present_names
from ecume.run.directory import RunDirectory
from ecume.run.scalars import lines_of
from ecume.trajectories.gsd import FORMER_BEGINNINGS, FORMER_NUMBERS, present_name
from ecume.trajectories.reader import open_trajectory
from ecume.trajectories.records import sealed_line

GOLDEN = Path(__file__).parents[1] / "golden" / "0.1.0"


@pytest.mark.parametrize("model", ["floating", "sph", "soft", "tracers"])
def test_a_state_of_a_former_version_has_present_names(model):
    (path, *_) = sorted((GOLDEN / model / "ckpt").glob("*.npz"))
    assert json.loads((GOLDEN / model / "manifest.json").read_text("utf-8"))["model"] == model
    with np.load(path) as file:
        stored = {name.removeprefix("state."): file[name] for name in file.files if name.startswith("state.")}
    fields = MODELS[model].state._fields
    assert set(with_present_names(stored, fields)) <= set(fields)


def test_former_names_are_found_within_paths():
    stored = {"gates.0.speed": np.array(1.0), "kick.decay": np.array(2.0), "gone": np.array(3.0)}
    assert with_present_names(stored, ["open_boundaries.0.speed", "kick.decay", "added"]) == {
        "open_boundaries.0.speed": stored["gates.0.speed"],
        "kick.decay": stored["kick.decay"],
        "gone": stored["gone"],
    }


def test_a_present_name_is_never_taken_for_a_former_one():
    stored = {former: np.array(1.0) for former in FORMER_NAMES.values()}
    assert with_present_names(stored, list(stored)) == stored


def test_numbers_of_a_former_version_have_present_names():
    """Its files say `came`, `left` and `lost`; frames, curves and units have the present names; either is accepted."""
    with open_trajectory(GOLDEN / "sph") as trajectory:
        assert {"came", "left", "lost"} <= set(trajectory._segments[0].header.numbers)
        numbers, units = trajectory[0].numbers, trajectory.units
        assert {"particles_entered", "particles_left", "particles_lost"} <= set(numbers)
        assert not {"came", "left", "lost"} & (set(numbers) | set(units) | set(trajectory[0].units))
        assert trajectory.numbers("particles_lost").tolist() == trajectory.numbers("lost").tolist()
        assert trajectory.numbers("lost")[0] == numbers["particles_lost"]


def test_an_array_keeps_its_name():
    """Tracers have an array `left`, the opening through which a particle left."""
    with open_trajectory(GOLDEN / "tracers") as trajectory:
        assert "left" in trajectory[0].arrays
        assert "left" in trajectory.units


def test_no_present_number_is_taken_for_a_former_one():
    present = [*FORMER_NUMBERS.values(), *(f"{begin}0" for begin in FORMER_BEGINNINGS.values())]
    assert list(map(present_name, present)) == present


def test_lines_of_numbers_with_checksums_have_present_names(tmp_path):
    """Runs with checksums keep their lines of former names when they go on; monitors of invariants read all of them."""
    home = RunDirectory(tmp_path)
    home.manifest.write_text(sealed_line({"format": 1}))
    line = sealed_line({"step": 0, "time": 0.0, "lost": 2.0, "came_through_opening_1": 3.0})
    home.scalars.write_text(line)
    (found,) = lines_of(home)
    assert (found["particles_lost"], found["entered_through_opening_1"]) == (2.0, 3.0)
