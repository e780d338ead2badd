"""Gauge, hydrostatic, dynamic and absolute pressure: one definition for gauges, figures, pages and exports."""

import csv

import numpy as np
import pytest

from ecume.analysis.pressures import with_pressures
from ecume.models.sph.record import SPH, start
from ecume.models.sph.report.observation import PRESSURES, readings, reference_of
from ecume.run import run
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume.trajectories.exports import export

ATMOSPHERE = 101325.0


def scene_of(gravity=(0.0, -9.81), **more):
    """Water of 0.5 m in a tank of 1 m, with a gauge 0.3 m below the surface, and one in the air."""
    quantities = ["pressure", "hydrostatic_pressure", "dynamic_pressure", "absolute_pressure"]
    return from_plain(
        {
            "model": "sph", "duration": 0.01, "frame_every": 0.01, "spacing": 0.125, "gravity": list(gravity),
            "liquid": {"density": 800.0, "atmospheric_pressure": ATMOSPHERE, "sound_speed": 30.0},
            "tank": {"high": [1.0, 1.0], "top": {"kind": "open"}},
            "fluid": [{"low": [0.0, 0.0], "high": [1.0, 0.5]}],
            "gauges": [{"name": "wet", "position": [0.5, 0.2], "quantities": quantities},
                       {"name": "dry", "position": [0.5, 0.95], "quantities": quantities}],
            **more,
        }
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(20))
def test_pressures_are_those_of_the_definitions_for_any_gravity(seed):
    """Hydrostatic pressure grows along gravity by rho_0 g per meter, and is zero at the highest liquid."""
    dice = np.random.default_rng(seed)
    gravity = dice.uniform(-10.0, 10.0, 2)
    scene = scene_of(gravity)
    position, gauge = dice.uniform(0.0, 1.0, (30, 2)), dice.uniform(-1e3, 1e4, 30)
    found = {name: kind(reference_of(scene), gauge, position) for name, kind in PRESSURES.items()}
    corners = np.array([[x, y] for x in (0.0, 1.0) for y in (0.0, 0.5)])
    highest = corners[np.argmin(corners @ gravity)]
    np.testing.assert_allclose(found["hydrostatic_pressure"], 800.0 * (position - highest) @ gravity, atol=1e-8)
    np.testing.assert_allclose(found["dynamic_pressure"] + found["hydrostatic_pressure"], gauge, atol=1e-8)
    np.testing.assert_allclose(found["absolute_pressure"] - gauge, ATMOSPHERE, rtol=1e-12)


def test_weightless_liquid_has_no_hydrostatic_pressure():
    scene = scene_of((0.0, 0.0))
    assert not PRESSURES["hydrostatic_pressure"](reference_of(scene), np.ones(3), np.ones((3, 2))).any()


def test_gauges_of_liquid_at_rest_read_the_weight_above_them_and_the_atmosphere():
    scene = scene_of()
    parameters = SPH.parameters(scene)
    state = start(scene, parameters)
    pressure = 800.0 * 9.81 * (0.5 - state.position[1])
    numbers, units = readings(parameters, state, pressure)
    weight = 800.0 * 9.81 * 0.3
    assert numbers["wet_pressure"] == pytest.approx(weight, rel=1e-9)
    assert numbers["wet_hydrostatic_pressure"] == pytest.approx(weight, rel=1e-12)
    assert numbers["wet_dynamic_pressure"] == pytest.approx(0.0, abs=1e-6)
    assert numbers["wet_absolute_pressure"] == pytest.approx(weight + ATMOSPHERE, rel=1e-9)
    assert numbers["dry_pressure"] == 0.0
    assert numbers["dry_absolute_pressure"] == ATMOSPHERE
    assert set(units.values()) == {"Pa"}


def test_exports_have_all_pressures(tmp_path):
    run(scene_of(), tmp_path / "run")
    with export(tmp_path / "run", "csv", tmp_path / "frames.csv").open() as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        gauge = float(row["pressure [Pa]"])
        assert float(row["absolute_pressure [Pa]"]) == pytest.approx(gauge + ATMOSPHERE, rel=1e-12)
        below = float(row["hydrostatic_pressure [Pa]"]) + float(row["dynamic_pressure [Pa]"])
        assert below == pytest.approx(gauge, rel=1e-9, abs=1e-9)
    with np.load(export(tmp_path / "run", "npz", tmp_path / "frames.npz")) as arrays:
        assert {*PRESSURES} <= {*arrays}


def test_frames_hold_the_gauge_pressure_only():
    """The others are derived, and cost no room."""
    scene = scene_of()
    frame = next(iter(simulate(scene)))
    assert {*PRESSURES} & {*frame.arrays} == {"pressure"}
    assert {*PRESSURES} <= {*with_pressures(scene)(frame).arrays}
