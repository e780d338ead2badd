"""The contact expected by `ecume check` is that of the run."""

import math

import numpy as np
import pytest

from ecume.models.floating.check_report import summary
from ecume.models.floating.first_contact import first_contact
from ecume.models.floating.record import FLOATING
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

TWO = {
    "model": "floating", "duration": 1.0, "frame_every": 0.005,
    "liquid": {"density": 998.0, "viscosity": 0.01, "surface_tension": 0.0728},
    "particles": [
        {"radius": 1e-3, "density": 1300.0, "contact_angle": math.pi / 2, "positions": [[-2e-3, 0.0], [2e-3, 0.0]]},
    ],
}  # fmt: skip


def foreseen(scene):
    parameters = FLOATING.parameters(scene)
    return first_contact(parameters, FLOATING.start(scene, parameters), 10.0 * scene.duration)


@pytest.mark.parametrize("viscosity", [0.001, 0.01, 0.1])
def test_two_floats_meet_about_when_they_were_expected_to(viscosity):
    scene = from_plain({**TWO, "duration": 3.0, "liquid": {**TWO["liquid"], "viscosity": viscosity}})
    # The last few hundredths of a radius take longer: the film between floats slows them.
    met = next(
        frame.time
        for frame in simulate(scene)
        if np.linalg.norm(np.subtract(*frame.arrays["position"])) < 2e-3 * (1.0 + 3e-2)
    )
    assert foreseen(scene) == pytest.approx(met, rel=0.03, abs=0.005)


def test_floats_that_repel_or_are_alone_never_meet():
    one = TWO["particles"][0]
    apart = [{**one, "positions": [[-2e-3, 0.0]]}, {**one, "density": 500.0, "positions": [[2e-3, 0.0]]}]
    assert foreseen(from_plain({**TWO, "particles": apart})) == math.inf
    assert foreseen(from_plain({**TWO, "particles": apart[:1]})) == math.inf


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"duration": 6.0, "frame_every": 0.1}, "frame_every"),
        ({"duration": 0.1, "frame_every": 0.001}, "after the end of the run"),
        ({"duration": 1.0, "frame_every": 0.001}, "alone"),
    ],
)
def test_check_says_how_to_see_the_contact(change, says):
    rows = {name: (value, remark) for name, value, remark in summary(from_plain({**TWO, **change}))}
    value, remark = rows["first contact"]
    assert value.startswith("after about")
    assert says in remark


def test_check_says_that_floats_beyond_the_cutoff_do_not_attract_each_other():
    far = [{**TWO["particles"][0], "positions": [[-2e-2, 0.0], [2e-2, 0.0]]}]
    rows = {name: (value, remark) for name, value, remark in summary(from_plain({**TWO, "particles": far}))}
    assert rows["first contact"] == (
        "not by attraction", "40 mm between the nearest two centers, beyond the cutoff: no float attracts another"
    )  # fmt: skip


@pytest.mark.parametrize("change", [{"density": 500.0}, {"positions": [[1.2e-2, 0.0]]}])
def test_check_says_that_a_contact_is_not_to_be_seen(change):
    """Floats that repel, and floats 14 mm apart, whose attraction would take longer than ten durations."""
    one = TWO["particles"][0]
    two = [{**one, "positions": [[-2e-3, 0.0]]}, {"positions": [[2e-3, 0.0]], **one, **change}]
    if "density" in change:
        two[1]["positions"] = [[2e-3, 0.0]]
    rows = {name: value for name, value, _ in summary(from_plain({**TWO, "duration": 0.2, "particles": two}))}
    assert rows["first contact"] == "not within 2 s"


@pytest.mark.parametrize(
    "changes",
    [
        ({"magnetic_moment": 1e-6}, {"magnetic_moment": -1e-6}, {}),
        ({"shape": {"kind": "ellipsoid", "width": 1e-3}}, {}, {}),
        ({}, {}, {"flow": {"extension_rate": -5.0}}),
    ],
)
def test_check_does_not_rule_out_contacts_by_other_forces_than_those_of_menisci(changes):
    """Magnets, quadrupoles and flows may bring floats together whose menisci repel each other."""
    one, other, around = changes
    first = TWO["particles"][0]
    two = [
        {**first, **one, "positions": [[-2e-3, 0.0]]},
        {**first, **other, "density": 500.0, "positions": [[2e-3, 0.0]]},
    ]
    scene = from_plain({**TWO, **around, "duration": 0.2, "particles": two})
    assert "first contact" not in {name for name, *_ in summary(scene)}
