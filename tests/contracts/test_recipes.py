"""CONTRIBUTING's recipes for an integrator, a measured quantity and a figure, followed to the letter in a copy."""

import json
import re

import pytest
from tests.contracts.recipes import Copy, block

EDITS = {
    "integrator": [
        ("models/sph/stepping.py", "before", "INTEGRATORS = {", block("semi-implicit") + "\n\n"),
        ("models/sph/stepping.py", "end", "", block("semi-implicit-row")),
    ],
    "measured quantity": [
        ("models/floating/observing.py", "after", "NUMBER_UNITS = {", block("gyration-unit")),
        ("models/floating/observing.py", "after", '        "momentum_x": ', block("gyration-value")),
    ],
    "figure": [
        ("show/floating/figures.py", "before", "FLOATING_FIGURES = {", block("fastest") + "\n\n"),
        ("show/floating/figures.py", "after", "FLOATING_FIGURES = {", block("fastest-row")),
    ],
}
"""By recipe: the file, where in it, and the code of the page."""

USE = """
import json, sys
import numpy as np
from pathlib import Path
import ecume
from ecume.models.floating import FLOATING
from ecume.models.sph.record import SPH
from ecume.show.figures import figures_of
from ecume.trajectories.frame import Frame

def end_of_blob(integrator, steps):
    scene = ecume.from_plain({
        "model": "sph", "duration": 0.02, "frame_every": 0.02, "spacing": 0.25, "gravity": [0.0, -1.0],
        "liquid": {"density": 1000.0, "sound_speed": 10.0},
        "tank": {"low": [-3.0, -3.0], "high": [3.0, 3.0]},
        "fluid": [{"low": [-0.5, -0.5], "high": [0.5, 0.5], "velocity_gradient": [[0.1, -0.5], [0.6, -0.3]]}],
        "method": {"integrator": integrator, "time_step": 0.02 / steps, "start": "rest"},
    })
    *_, last = ecume.simulate(scene)
    return last.arrays["position"]

exact = end_of_blob("symplectic", 32)
errors = [float(np.abs(end_of_blob("semi-implicit", steps) - exact).max()) for steps in (4, 8)]
scene = ecume.from_plain({
    "model": "floating", "duration": 0.2, "frame_every": 0.1,
    "floats": [{"radius": 1e-3, "density": 1300.0, "contact_angle": 1.5, "positions": [[-3e-3, 0.0], [3e-3, 0.0]]}],
})
frames = list(ecume.simulate(scene))
axes = figures_of(scene)["fastest"](frames, scene).axes[0]
print(json.dumps({
    "errors": errors,
    "gyration": [frame.numbers["radius_of_gyration"] for frame in frames],
    "unit": frames[0].units["radius_of_gyration"],
    "label": axes.get_ylabel(),
    "drawn": axes.lines[0].get_ydata().tolist(),
    "speeds": [frame.numbers["largest_speed"] for frame in frames],
}))
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Which files each recipe changed, and what a process with all of them printed."""
    copy, files = Copy(tmp_path_factory.mktemp("copy")), {}
    for recipe, edits in EDITS.items():
        copy.changed.clear()
        for file, where, anchor, text in edits:
            copy.edit(file, where, anchor, text)
        files[recipe] = {path.name for path in copy.changed}
    (told,) = copy.printed(USE, NUMBA_DISABLE_JIT="1")
    return files, json.loads(told)


@pytest.mark.parametrize("recipe", EDITS)
def test_a_recipe_changes_one_file(made, recipe):
    assert len(made[0][recipe]) == 1


def test_a_new_integrator_moves_a_tank_with_the_order_it_has(made):
    coarse, fine = made[1]["errors"]
    assert fine > 0.0
    assert coarse / fine == pytest.approx(2.0, rel=0.15)


def test_a_new_quantity_is_in_frames_with_its_unit(made):
    first, *_, last = made[1]["gyration"]
    assert first == pytest.approx(3e-3)
    assert last < first
    assert made[1]["unit"] == "m"


def test_a_new_figure_is_drawn_with_its_unit(made):
    assert re.fullmatch(r"largest speed \(.*m/s\)", made[1]["label"])
    assert len(made[1]["drawn"]) == len(made[1]["speeds"])
    assert made[1]["drawn"][-1] / made[1]["drawn"][1] == pytest.approx(made[1]["speeds"][-1] / made[1]["speeds"][1])
