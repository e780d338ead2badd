"""The report of `ecume check` on a scene is correct for all its floats."""

import math
import warnings
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws import flotation, pair_laws
from ecume.laws.pair_laws import PairLaw
from ecume.models.floating.check_report import (
    FEWER_AT_CONTACT,
    _summary_of_collisions,
    _summary_of_raft_speeds,
    meeting_speed,
    seconds_per_step,
    summary,
)
from ecume.models.floating.forces.pair_forces import CutoffWarning
from ecume.models.floating.setup.hydrodynamic_interaction import GasWarning
from ecume.models.floating.setup.kinds import floats_of
from ecume.models.floating.setup.scene_parameters import checked_parameters
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume.units import Unit

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
    tilt, remark = together["float-1: tilt"]
    assert 50.0 < float(tilt.removesuffix(" % too large")) < 100.0
    assert "disc.tension_moment" in remark
    righted = disc | {"disc": disc["disc"] | {"tension_moment": True}}
    assert "float-1: tilt" not in report({"particles": [righted], "interaction": {"method": "multipole"}})


def test_a_step_is_too_long_where_floats_that_attract_pass_through_one_another():
    pair, passing = [row(0.0, 1e-3, 1300.0), row(0.01, 1e-3, 1300.0)], {"contacts": {"law": "none"}}
    assert report({"rows": pair})["time step"][1].startswith("good")
    assert report({"rows": pair} | passing)["time step"][1].startswith("too long where floats overlap")
    for harmless in ({"rows": pair[:1]}, {"rows": pair, "interaction": {"law": "none"}}):
        assert report(harmless | passing)["time step"][1].startswith("good")


def test_shapes_say_where_their_contact_line_is():
    needle = {"kind": "needle", "width": 0.6e-3, "angle": 0.0}
    rows = report(
        {"particles": [{"radius": 3e-3, "density": 7800.0, **STUFF, "shape": needle, "positions": [[0.0, 0.0]]}]}
    )
    assert 90.0 < float(rows["float-1: filling angle"][0].removesuffix(" deg")) < 180.0
    assert float(rows["float-1: height of the contact line"][0].removesuffix(" µm")) < 0.0


def test_a_species_of_different_bodies_is_described_body_by_body():
    sphere = {"x": 0.0, "y": 0.0, "radius": 1e-3, "density": 600.0, **STUFF}
    disc = {"x": 0.02, "y": 0.0, "radius": 2e-3, "density": 300.0, "disc": {"thickness": 1e-3}}
    rows = report({"rows": [sphere, disc]})
    assert "float-1: Bond number" in rows
    assert "float-1: load" in rows


def drift_of_rafts(count, **hydrodynamics):
    bead = {"name": "bead", "radius": 1e-3, "density": 500.0, "count": count, **STUFF}
    slow = {"integration": {"integrator": "overdamped"}} if "interaction" in hydrodynamics else {}
    scene = from_plain({**SCENE, "particles": [bead], "hydrodynamics": hydrodynamics, **slow})
    return [value for _, value, _ in _summary_of_raft_speeds(checked_parameters(scene), scene)]


@pytest.mark.parametrize(("count", "factor"), [(7, "3.4"), (19, "6.1"), (1200, "27")])
def test_the_missing_hydrodynamic_interaction_is_announced_with_its_size(count, factor):
    assert drift_of_rafts(count) == [f"up to {factor} times too slow"]


@pytest.mark.filterwarnings("ignore::ecume.models.floating.setup.hydrodynamic_interaction.ReynoldsWarning")
def test_rafts_with_hydrodynamic_interaction_are_announced_with_their_speed():
    assert drift_of_rafts(19, interaction="rotne-prager") == ["up to 6.1 times a single float"]


def test_gaps_of_many_brownian_floats_that_share_flow_are_announced_with_their_error():
    bead = {"name": "bead", "radius": 1e-6, "density": 1050.0, "count": 9, **STUFF}
    water = {"brownian": True, "interaction": "rotne-prager"}
    slow = {"integration": {"integrator": "overdamped"}}
    few = checked_parameters(from_plain({**SCENE, "particles": [bead], "hydrodynamics": water, **slow}))
    many = few._replace(floats=few.floats._replace(radius=np.full(1001, 1e-6)))
    assert _summary_of_collisions(few) == []
    ((_, reach, remark),) = _summary_of_collisions(many)
    assert reach == "within 20 R"
    assert FEWER_AT_CONTACT in remark
    assert _summary_of_collisions(many._replace(drift=many.drift._replace(thermal=0.0))) == []


def test_pairs_and_floats_without_drag_form_no_raft_that_is_too_slow():
    assert drift_of_rafts(2) == drift_of_rafts(19, drag="none") == []


class Screened(NamedTuple):
    """Constants of a law for these tests."""

    strength: Annotated[float, Unit("J*m")]
    length: Annotated[float, Unit("m")]


def screened(setting, strength: Annotated[float, Unit("J*m")] = 2e-12, length: Annotated[float, Unit("m")] = 1e-3):
    return Screened(strength, length)


def inverse(setting, strength: Annotated[float, Unit("J*m")] = 2e-12, length: Annotated[float, Unit("m")] = 1e-3):
    return Screened(strength / length, length)


def screened_force(distance, own, law):
    return law.strength * math.exp(-distance / law.length) / distance**2


@pytest.fixture
def without_checks(monkeypatch):
    """Replace the built-in one-sided law by laws without checks of their numbers."""

    def put(make):
        law = PairLaw(Screened, make, screened_force, None, papers=())
        monkeypatch.setitem(pair_laws.PAIR_LAWS, "one-sided-legacy", law)
        monkeypatch.setitem(pair_laws._BY_CONSTANTS, Screened, law)

    return put


def with_constants(*numbers):
    interaction = {"law": "one-sided-legacy", "constants": list(numbers)}
    return {"rows": [row(0.0, 1e-3, 1300.0), row(0.01, 1e-3, 1300.0)], "interaction": interaction}


@pytest.mark.parametrize("make", [screened, inverse])
def test_numbers_that_a_law_divides_by_are_faults_of_the_scene(make, without_checks):
    without_checks(make)
    with pytest.raises(SceneError, match=r"interaction.constants: the law 'one-sided-legacy' cannot be evaluated with "
                       r"strength = 1e-10 J\*m, length = 0 m: .*division by zero"):  # fmt: skip
        report(with_constants(1e-10, 0.0))


def test_a_force_that_is_no_number_is_a_fault_of_the_scene(without_checks):
    without_checks(screened)
    with pytest.raises(SceneError, match=r"interaction.constants: .* (the force is inf N|math range error)"):
        report(with_constants(1e300, -1e-5))


def test_a_law_is_named_with_its_numbers_and_those_it_has_by_default(without_checks):
    assert report({"rows": [row(0.0, 1e-3, 1300.0)]})["pair law"] == ("capillary", "superposition of menisci")
    without_checks(screened)
    assert report(with_constants(3e-12))["pair law"][1] == "strength = 3e-12 J*m, length = 0.001 m"


def test_a_law_that_is_cut_off_too_early_is_warned_of(without_checks):
    without_checks(screened)
    with pytest.warns(CutoffWarning, match=r"interaction.accuracy: at the cutoff, .* of that at contact"):
        report(with_constants(3e-12, 0.05))
    dish = {"dish": {"radius": 0.012, "law": "none"}}
    assert report(with_constants(3e-12, 0.05) | dish), "no two floats are farther apart than the cutoff"


def test_a_law_without_menisci_is_not_said_to_attract():
    found = report({"rows": [row(0.0, 1e-3, 200.0)], "interaction": {"law": "none"}})
    assert found["float-1: capillary charge"][1] == "light: raises the surface"


def test_a_law_of_no_strength_does_not_limit_the_time_step(without_checks):
    without_checks(screened)
    found = report(with_constants(0.0))
    assert found["time step"][1] == "good; no force limits it"


def test_a_liquid_in_place_of_the_gas_gets_a_warning():
    for density, warned in ((770.0, True), (1.2, False), (60.0, False)):
        beads = {"radius": 1e-4, "density": 1050.0, "contact_angle": 1.57, "positions": [[0.0, 0.0], [1e-3, 0.0]]}
        scene = from_plain({**SCENE, "liquid": {"density": 998.0, "gas_density": density}, "particles": [beads]})
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            checked_parameters(scene)
        assert [one.category for one in found] == [GasWarning] * warned


CEREAL = {"radius": 1.5e-3, "density": 300.0, "contact_angle": 1.2, "count": 3}


def test_fast_floats_are_told_what_their_drag_lacks():
    milk = {"density": 1030.0, "viscosity": 2e-3, "surface_tension": 0.045}
    stokes = {"hydrodynamics": {"drag": "stokes"}}
    value, remark = report({"liquid": milk, "particles": [CEREAL], **stokes})["Reynolds number"]
    assert float(value.removeprefix("up to ")) > 20.0
    assert "schiller-naumann" in remark
    for slow in (stokes | {"particles": [CEREAL | {"radius": 5e-5}]}, {}):
        assert "Reynolds number" not in report({"liquid": milk, "particles": [CEREAL], **slow})


def test_a_liquid_without_viscosity_needs_no_word_on_drag():
    """The default drag law was refused in it."""
    rows = report({"liquid": {"viscosity": 0.0}, "particles": [CEREAL]})
    assert "Reynolds number" not in rows
    assert "added mass" in rows


def test_what_lacks_drag_is_told_only_what_can_be_had():
    """`schiller-naumann` is refused for shapes and in moving dishes, where the remedy also named it."""
    milk = {"density": 1030.0, "viscosity": 2e-3, "surface_tension": 0.045}
    needle = CEREAL | {"radius": 5e-3, "shape": {"kind": "needle", "width": 3e-3}}
    changes = {
        "no other drag is known": {"particles": [needle]},
        "moving dish": {"dish": {"radius": 0.05, "contact_angle": 1.0, "motion": {"velocity": [0.01, 0.0]}}},
        "velocity-verlet": {"integration": {"integrator": "overdamped"}},
    }
    for words, change in changes.items():
        remark = report({"liquid": milk, "particles": [CEREAL], **change})["Reynolds number"][1]
        assert words in remark
        assert ("schiller-naumann" in remark) == (words == "velocity-verlet")
    stokes = {"hydrodynamics": {"drag": "stokes"}}
    assert "integrator" not in report({"liquid": milk, "particles": [CEREAL], **stokes})["Reynolds number"][1]


def test_fast_floats_are_told_what_their_inertia_lacks():
    milk = {"density": 1030.0, "viscosity": 2e-3, "surface_tension": 0.045}
    value, remark = report({"liquid": milk, "particles": [CEREAL]})["added mass"]
    light, heavy = (
        floats_of(from_plain({**SCENE, "liquid": milk, "particles": [CEREAL], "hydrodynamics": {"added_mass": added}}))
        for added in (False, True)
    )
    assert value == f"up to {100.0 * (heavy.mass[0] / light.mass[0] - 1.0):.3g} %"
    assert "hydrodynamics.added_mass" in remark
    slow, moving = {"particles": [CEREAL | {"radius": 5e-5}]}, {"hydrodynamics": {"added_mass": True}}
    for change in (slow, moving, {"integration": {"integrator": "overdamped"}}):
        assert "added mass" not in report({"liquid": milk, "particles": [CEREAL], **change})


@pytest.mark.long
def test_two_floats_meet_as_fast_as_energy_and_drag_allow():
    """Runs with and without much drag: the speed at contact is below the bound, and above half of it."""
    for viscosity in (1e-3, 0.1):
        floats = {**CEREAL, "count": 2, "positions": [[-2.2e-3, 0.0], [2.2e-3, 0.0]]}
        plain = {
            **SCENE,
            "liquid": {"viscosity": viscosity},
            "particles": [floats],
            "duration": 3.0,
            "frame_every": 0.01,
        }
        scene = from_plain(plain)
        fastest = max(frame.numbers["largest_speed"] for frame in simulate(scene))
        assert 0.4 < fastest / meeting_speed(checked_parameters(scene)) < 1.05


def test_small_slow_floats_are_told_what_includes_the_drift_of_rafts():
    bead = CEREAL | {"radius": 2e-5, "density": 2000.0}
    assert "rotne-prager" in report({"particles": [bead]})["drift of rafts"][1]
    assert "rotne-prager" not in report({"particles": [CEREAL]})["drift of rafts"][1]


def test_multipoles_are_refused_where_contact_lines_may_overlap_and_name_the_image():
    multipole = {"interaction": {"method": "multipole", "order": 2}, "particles": [CEREAL]}
    with pytest.raises(SceneError, match=r"contacts that keep floats apart: got 'none' \(contacts.law\)"):
        report({**multipole, "contacts": {"law": "none"}})
    with pytest.raises(SceneError, match=r"got 'pinned' \(dish.image\)"):
        report({**multipole, "dish": {"radius": 0.05, "image": "pinned"}})
