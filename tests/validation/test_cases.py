"""Each case is met, sees what is wrong, and comes with the package."""

import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hatchling.builders.wheel import WheelBuilder

import ecume_validation
from ecume.errors import Diverged
from ecume.laws import drag
from ecume.trajectories.frame import Frame
from ecume_validation import CASES, floats, hydrodynamics, rest
from ecume_validation.floats import raft

HOME = Path(ecume_validation.__file__).parent
DATA = HOME / "data"
ROOT = Path(__file__).parents[2]


def folder(name):
    """Where a case lies."""
    return name.replace("-", "_")


def missed(rows):
    return [row for row in rows if not row.met]


def test_every_folder_is_a_case_and_says_where_its_numbers_are_from():
    folders = {path.name for path in DATA.iterdir()}
    assert folders == {folder(name) for name in CASES}
    for name, case in CASES.items():
        assert case.name == name
        assert (DATA / folder(name) / "README.md").read_text(encoding="utf-8").startswith("# ")


def test_every_paper_that_a_case_cites_is_in_the_bibliography():
    known = set(
        re.findall(r"^@\w+\{(\w+),", (ROOT / "src/ecume/references.bib").read_text(encoding="utf-8"), re.MULTILINE)
    )
    for name in CASES:
        cited = set(
            re.findall(r"\[([a-z]+[0-9]{4})\b", (DATA / folder(name) / "README.md").read_text(encoding="utf-8"))
        )
        assert cited <= known


def test_a_wheel_holds_all_that_the_cases_read(tmp_path):
    (wheel,) = WheelBuilder(str(ROOT / "packaging/validation")).build(directory=str(tmp_path), versions=["standard"])
    packed = set(zipfile.ZipFile(wheel).namelist())
    needed = {path for path in HOME.rglob("*") if path.suffix in {".py", ".md", ".csv", ".toml"}}
    assert len(needed) > 3 * len(CASES)
    assert {f"ecume_validation/{path.relative_to(HOME).as_posix()}" for path in needed} <= packed


@pytest.mark.long
def test_every_published_number_of_floating_spheres_is_met_within_its_digits():
    rows = CASES["floating"].rows()
    assert len(rows) == 302 + 12 + 159 + 3
    assert not missed(rows)


def test_every_kernel_is_one_and_has_the_tabled_values():
    rows = CASES["kernels"].rows()
    assert len(rows) == 3 * 30 + 392 + 20
    assert not missed(rows)


@pytest.mark.long
def test_floats_in_front_of_a_barrier_are_as_in_closed_form():
    rows = CASES["barrier"].rows()
    assert len(rows) == 12 + 6 + 2
    assert not missed(rows)


@pytest.mark.long
@pytest.mark.compiled
def test_two_floats_meet_when_the_equation_of_motion_says_so():
    rows = CASES["meeting"].rows()
    assert len(rows) == 18
    assert not missed(rows)


@pytest.mark.long
@pytest.mark.compiled
def test_rafts_and_floats_with_thermal_noise_move_as_their_mobility_says(monkeypatch):
    monkeypatch.setattr(hydrodynamics, "RAFTS", (7, 19))
    monkeypatch.setattr(hydrodynamics, "FRAMES", 8_000)
    rows = [*hydrodynamics.rafts(), *hydrodynamics.common_motions(), *hydrodynamics.weights()]
    assert len(rows) == 2 + 5 + 2
    assert not missed(rows)


@pytest.mark.compiled
def test_floats_leave_and_climb_walls_as_the_equation_of_motion_says():
    rows = CASES["walls"].rows()
    assert len(rows) == 16
    assert not missed(rows)


@pytest.mark.compiled
def test_a_friction_one_part_in_a_hundred_off_is_seen(monkeypatch):
    right = drag.stokes_friction
    monkeypatch.setattr(drag, "stokes_friction", lambda *given: 1.01 * right(*given))
    assert missed([floats.meeting((0.6, 0.6), 9.0, drag=True)])


@pytest.mark.compiled
def test_a_wall_of_the_wrong_sign_is_seen(monkeypatch):
    right = floats.Bowl
    monkeypatch.setattr(floats, "Bowl", lambda radius, angle, liquid: right(radius, 3.14159 - angle, liquid))
    assert missed([floats.drift("heavy", "wetting", 25.0, False)])


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.filterwarnings("ignore::ecume.models.floating.time_integration.step_size.StepWarning")
def test_the_integrators_have_their_orders_and_keep_or_lose_the_energy():
    assert not missed([*map(floats.order, floats.ORDERS), *floats.energies(50_000)])


@pytest.mark.compiled
@pytest.mark.filterwarnings("ignore::ecume.models.floating.time_integration.step_size.StepWarning")
def test_an_integrator_of_another_order_is_seen(monkeypatch):
    monkeypatch.setitem(floats.ORDERS, "velocity-verlet", 1)
    assert missed([floats.order("velocity-verlet")])


@pytest.mark.filterwarnings("ignore::ecume.models.floating.time_integration.step_size.StepWarning")
def test_a_float_that_verlet_throws_out_is_no_small_change_of_energy(monkeypatch):
    def thrown_out(scene):
        raise Diverged("float 0 left")
        yield

    monkeypatch.setattr(floats, "simulate", thrown_out)
    with pytest.raises(Diverged):
        floats.energies(10_000)


@pytest.mark.compiled
def test_cereals_that_still_drift_are_not_taken_for_a_raft_at_rest():
    rows = rest.bowl("milk", ["duration=3 s"])
    assert [row.name for row in missed(rows)] == ["milk: largest speed in the end (m/s)"]


def bowl_of(monkeypatch, position=0.0, **numbers):
    """The rows that are missed in a bowl of two frames, all well but what is given for the last one."""
    well = {"total_energy": -1e-6, "largest_speed": 0.0, "deepest_overlap": 0.0, "largest_overlap": 0.0}
    well["unconverged_steps"] = 0.0
    frames = [
        Frame(time, {"position": np.array([[place, 0.0]])}, well | output, {})
        for time, place, output in ((0.0, 0.0, {}), (0.1, position, numbers), (0.2, position, numbers))
    ]
    monkeypatch.setattr(rest, "simulate", lambda scene: iter(frames))
    return [row.name for row in missed(rest.bowl("milk", []))]


@pytest.mark.parametrize(
    ("bad", "named"),
    [
        ({"deepest_overlap": 1.6e-6}, "overlap"),
        ({"largest_overlap": 1.6e-6}, "overlap"),
        ({"total_energy": -0.99999e-6}, "energy"),
        ({"largest_speed": 1.1e-6}, "speed"),
        ({"unconverged_steps": 1.0}, "converge"),
        ({"position": np.nan}, "no place"),
    ],
)
def test_each_fault_of_a_bowl_is_seen_in_its_own_row(bad, named, monkeypatch):
    (name,) = bowl_of(monkeypatch, **bad)
    assert named in name


def test_a_bowl_without_faults_is_met(monkeypatch):
    assert bowl_of(monkeypatch) == []


@pytest.mark.compiled
@pytest.mark.parametrize("friction", [0.0, pytest.param(0.3, marks=pytest.mark.long)])
def test_nineteen_attracted_floats_gather_and_nothing_sinks_or_is_made(friction):
    rows = raft(0.04, friction, seeds=range(1, 10))
    assert len(rows) >= 4
    assert [row.name for row in rows if not row.met] == []
