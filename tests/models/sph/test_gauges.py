"""Gauges of the scene read what the liquid is there."""

import dataclasses

import numpy as np
import pytest

from ecume.analysis import fields as readers
from ecume.errors import SceneError
from ecume.models.sph.record import SPH, start
from ecume.models.sph.report.observation import gauges_of, readings, sensing_area
from ecume.scenes.schema import from_plain, to_plain
from ecume.scenes.sph.tank import TankSpec

from .scenes import tank

PRESSURE = {"name": "P", "position": [1.0, 0.25]}
LEVEL = {"name": "L", "position": [0.0, 0.0], "end": [1.0, 0.0], "count": 3, "quantities": ["level"]}
VELOCITY = {"name": "V", "position": [0.5, 0.5], "quantities": ["velocity", "pressure"]}
DRY = {"name": "dry", "position": [0.5, 1.9], "quantities": ["velocity", "pressure", "level"]}


def with_gauges(*gauges, **more):
    """Liquid from y = 0 to 1 in a tank from 0 to 1, with these gauges in it."""
    plain = to_plain(tank(deep=16, jitter=0.0))
    return from_plain({**plain, **more, "gauges": list(gauges)})


def read(scene):
    """What the gauges say at the start."""
    parameters = SPH.parameters(scene)
    state = start(scene, parameters)
    pressure = 1.0 - state.position[1]
    state.velocity[0] = 3.0 * state.position[1]
    return readings(parameters, state, pressure)


def test_a_probe_at_a_wall_reads_the_pressure_of_its_depth():
    numbers, units = read(with_gauges(PRESSURE))
    assert numbers == {"P_pressure": pytest.approx(0.75, abs=1e-9)}
    assert units == {"P_pressure": "Pa"}


def test_a_sensor_averages_over_its_part_in_the_tank():
    whole, cut = {**PRESSURE, "diameter": 0.2}, {"name": "C", "position": [1.0, 0.05], "diameter": 0.2}
    half_dry = {"name": "D", "position": [1.0, 1.0], "diameter": 0.4}
    numbers, _ = read(with_gauges(whole, cut, half_dry))
    assert numbers["P_pressure"] == pytest.approx(0.75, abs=1e-9)
    assert numbers["C_pressure"] == pytest.approx(0.925, abs=0.01)  # from the floor to 0.15
    assert numbers["D_pressure"] == pytest.approx(0.05, abs=0.03)  # 0.1 where it is wet


@pytest.mark.parametrize(("place", "across"), [((0.0, 0.5, 0.6), 0), ((0.5, 0.5, 2.0), 2), ((0.5, 0.03, 0.6), 1)])
def test_the_area_of_a_sensor_in_3d_is_a_disc_along_the_nearest_side(place, across):
    area = sensing_area(TankSpec(low=(0.0, 0.0, 0.0), high=(1.0, 1.0, 2.0)), np.array(place), 0.2)
    away = np.delete(area - place, across, axis=1)
    assert (area[:, across] == place[across]).all()
    np.testing.assert_allclose(away.mean(axis=0), 0.0, atol=1e-15)
    assert np.linalg.norm(away, axis=1).max() < 0.1
    # The mean square distance of a disc of radius a is a^2/2.
    assert (away**2).sum(axis=1).mean() == pytest.approx(0.005)


def test_a_row_reads_the_level_up_to_the_walls():
    numbers, _ = read(with_gauges(LEVEL))
    assert list(numbers) == ["L_1_level", "L_2_level", "L_3_level"]
    assert list(numbers.values()) == pytest.approx([1.0] * 3, rel=0.02)


def test_a_velocity_is_read_where_it_shears():
    numbers, units = read(with_gauges(VELOCITY))
    assert numbers["V_velocity_x"] == pytest.approx(1.5)
    assert numbers["V_velocity_y"] == pytest.approx(0.0, abs=1e-12)
    assert units["V_velocity_x"] == "m/s"


def test_a_dry_probe_reads_zero_while_the_level_below_it_is_read():
    numbers, _ = read(with_gauges(DRY))
    assert (numbers["dry_pressure"], numbers["dry_velocity_x"]) == (0.0, 0.0)
    assert numbers["dry_level"] == pytest.approx(1.0, rel=0.02)


def test_readings_are_those_of_the_analysis_and_do_not_depend_on_the_order_of_particles():
    scene = with_gauges(VELOCITY)
    parameters = SPH.parameters(scene)
    state = start(scene, parameters)
    state.velocity[:] = np.random.default_rng(1).normal(size=state.velocity.shape)
    order = np.random.default_rng(2).permutation(state.position.shape[1])
    mixed = {
        name: np.take(getattr(state, name), order, axis=-1)
        for name in ("position", "velocity", "density", "mass", "identity")
    }
    pressure = state.density - 1.0
    one = readings(parameters, state, pressure)
    assert one == readings(parameters, state._replace(**mixed), pressure[order])
    frame = SPH.observe(parameters, state, SPH.workspace(parameters, state, 1.0))
    there = readers.linear_values_at(frame, "velocity", np.array([[0.5, 0.5]]), parameters.support)
    assert frame.numbers["V_velocity_x"] == pytest.approx(there[0, 0], rel=1e-12)
    assert frame.units["V_velocity_x"] == "m/s"


@pytest.mark.parametrize(
    ("gauge", "says"),
    [
        ({"name": "P", "position": [0.5, 3.0]}, r"gauges\[0\].position: is outside the tank"),
        ({"name": "P", "position": [0.5, 0.5, 0.5]}, "3 numbers; the tank has 2"),
        ({"name": "largest", "position": [0.5, 0.5]}, "choose another"),
        ({"name": "P", "position": [0.5, 0.5], "end": [0.6, 0.5]}, "both, end and count"),
        ({"name": "P", "position": [0.5, 0.5], "quantities": ["presure"]}, "pressure"),
    ],
)
def test_what_cannot_be_read_is_refused(gauge, says):
    with pytest.raises(SceneError, match=says):
        with_gauges(gauge)
    with pytest.raises(SceneError, match=r"gauges\[1\].name: got 'P', as in gauges\[0\]"):
        with_gauges(PRESSURE, PRESSURE)


def test_a_scene_without_gauges_reads_nothing():
    scene = dataclasses.replace(with_gauges(), gauges=())
    assert gauges_of(scene, 0.1) == ()
