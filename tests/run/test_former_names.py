"""Files of runs of former versions, whose fields had other names."""

import json
from pathlib import Path

import numpy as np
import pytest

from ecume.models import MODELS
from ecume.run.archives import FORMER_NAMES, with_present_names

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
