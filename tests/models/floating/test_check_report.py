"""What `ecume check` tells of a scene is true of all its floats."""

import pytest

from ecume.laws import flotation
from ecume.models.floating.check_report import _summary_of_raft_speeds, seconds_per_step, summary
from ecume.scenes.schema import from_plain

SCENE = {"model": "floating", "duration": "1 s", "frame_every": "0.1 s"}
STUFF = {"contact_angle": 1.2}


def report(scene):
    return {name: (value, remark) for name, value, remark in summary(from_plain({**SCENE, **scene}))}


def row(x, radius, density, name="float-1"):
    return {"x": x, "y": 0.0, "radius": radius, "density": density, "species_name": name, **STUFF}


def test_a_table_of_unlike_floats_is_reported_from_the_least_to_the_greatest():
    rows = report({"rows": [row(0.0, 2e-3, 500.0), row(0.01, 1e-3, 500.0), row(0.02, 1e-3, 500.0)]})
    assert rows["float-1: radius"] == ("1 to 2 mm", "3 floats of 2 kinds")
    small, large = (
        report({"rows": [row(0.0, radius, 500.0)]})["float-1: capillary charge"][0].removesuffix(" µm")
        for radius in (1e-3, 2e-3)
    )
    assert rows["float-1: capillary charge"] == (f"{large} to {small} µm", "light: attracts light floats")
    assert rows["float-1: density ratio"] == ("0.5", "")


def test_a_table_of_equal_floats_is_reported_in_one_number_and_knows_when_they_sink():
    rows = report({"rows": [row(0.0, 2e-3, 500.0), row(0.01, 2e-3, 500.0)]})
    assert "float-1: radius" not in rows
    assert rows["float-1: density ratio"][0] == "0.5"
    assert rows["float-1: density ratio"][1].startswith("sinks above 1.")


def test_heavy_and_light_floats_of_one_name_are_both_reported():
    rows = report({"rows": [row(0.0, 1e-3, 200.0), row(0.01, 1e-3, 2000.0)]})
    assert rows["float-1: dimensionless weight"][1] == "some downward: lowers the surface, some upward: raises it"


def test_each_species_is_reported_by_its_own_name():
    rows = report({"rows": [row(0.0, 1e-3, 200.0, "cork"), row(0.01, 1e-3, 2000.0, "bead")]})
    assert (rows["cork: density ratio"][0], rows["bead: density ratio"][0]) == ("0.2", "2")
    assert rows["floats"] == ("2", "2 species")


@pytest.mark.parametrize("count", [1, 60, 300, 10_000])
def test_gathering_costs_more_than_drifting_and_both_grow_with_the_floats(count):
    drifting, gathering = seconds_per_step(count)
    assert drifting < gathering
    assert all(less < more for less, more in zip((drifting, gathering), seconds_per_step(2 * count), strict=True))


def test_equilibrium_and_closeness_are_reported_for_each_species():
    rows = report({"rows": [row(0.0, 1e-3, 1300.0)]})
    assert rows["float-1: filling angle"][0].endswith(" deg")
    assert rows["float-1: height of the contact line"][0].startswith("-60")
    share, _ = rows["float-1: attraction beyond superposition"]
    assert 0.0 < float(share.removesuffix(" %")) < 30.0


def test_what_superposition_omits_is_stated_for_floats_of_any_size():
    """In the limit of small floats it has a closed form; it grows with the radius."""
    found = []
    for radius in (0.03e-3, 0.3e-3, 3e-3, 20e-3):
        share, remark = report({"rows": [row(0.0, radius, 300.0)]})["float-1: attraction beyond superposition"]
        found.append(float(share.removesuffix(" %")))
    small = 100.0 * flotation.superposition_excess(STUFF["contact_angle"], 0.02)
    assert found[0] == pytest.approx(small, rel=0.1)
    assert found == sorted(found)
    assert found[-1] > 25.0
    assert "multipole" in remark
    together = report({"rows": [row(0.0, radius, 300.0)], "interaction": {"method": "multipole"}})
    assert "float-1: attraction beyond superposition" not in together


def test_discs_say_what_they_carry_and_that_superposition_errs():
    disc = {"radius": 1e-3, "density": 300.0, "disc": {"thickness": 1e-3}, "positions": [[0.0, 0.0]]}
    alone = report({"particles": [disc]})
    assert float(alone["float-1: load"][1].removeprefix("sinks above ").removesuffix(" µN")) > 2e6 * 3.14 * 0.072 * 1e-3
    assert float(alone["float-1: height of the contact line"][0].removesuffix(" µm")) < 0.0
    assert "multipole" in alone["float-1: beyond superposition"][1]
    together = report({"particles": [disc], "interaction": {"method": "multipole"}})
    assert "float-1: beyond superposition" not in together


def test_shapes_say_where_their_contact_line_is():
    needle = {"kind": "needle", "width": 0.6e-3, "angle": 0.0}
    rows = report(
        {"particles": [{"radius": 3e-3, "density": 7800.0, **STUFF, "shape": needle, "positions": [[0.0, 0.0]]}]}
    )
    assert 90.0 < float(rows["float-1: filling angle"][0].removesuffix(" deg")) < 180.0
    assert float(rows["float-1: height of the contact line"][0].removesuffix(" µm")) < 0.0


def drift_of_rafts(count, **hydrodynamics):
    bead = {"name": "bead", "radius": 1e-3, "density": 500.0, "count": count, **STUFF}
    scene = from_plain({**SCENE, "particles": [bead], "hydrodynamics": hydrodynamics})
    return [value for _, value, _ in _summary_of_raft_speeds(scene)]


@pytest.mark.parametrize(("count", "factor"), [(7, "3.4"), (19, "6.1"), (1200, "27")])
def test_the_missing_hydrodynamic_interaction_is_announced_with_its_size(count, factor):
    assert drift_of_rafts(count) == [f"up to {factor} times too slow"]


def test_rafts_with_hydrodynamic_interaction_are_announced_with_their_speed():
    assert drift_of_rafts(19, interaction="rotne-prager") == ["up to 6.1 times a single float"]


def test_pairs_and_floats_without_drag_form_no_raft_that_is_too_slow():
    assert drift_of_rafts(2) == drift_of_rafts(19, drag="none") == []
