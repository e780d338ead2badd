"""Gauges of the scene read what the liquid is there."""

import dataclasses

import numpy as np
import pytest

from ecume.analysis import gauges as readers
from ecume.errors import SceneError
from ecume.models.sph.boundaries.rigid_bodies import with_moved_solids
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
    return readings(with_moved_solids(parameters, state), state, pressure)


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


BLOCK = {"low": [0.5, 0.0], "high": [0.75, 0.5]}
SOLIDS = {
    "none": {},
    "obstacle": {"obstacles": [BLOCK]},
    "disc": {"obstacles": [{"center": [0.5, 0.4], "radius": 0.2}]},
    "body": {"bodies": [{**BLOCK, "density": 2.0}]},
}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("walls", ["mirror", "dummy", "reflect"])
@pytest.mark.parametrize("solids", SOLIDS)
def test_in_the_liquid_up_to_its_surface_a_probe_reads_the_whole_pressure(seed, walls, solids):
    """In corners, at walls and solids and half a spacing below the surface, with particles displaced by chance."""
    dice = np.random.default_rng(seed)
    places = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0 - 0.5 / 16), (0.25, 1.0 - 0.5 / 16), (0.5, 0.6), (0.3, 0.4)]
    places += [(0.0, dice.uniform(0.0, 0.95)), (dice.uniform(0.0, 1.0), 0.95), (dice.uniform(0.8, 1.0), 0.3)]
    places += [(0.5, 0.2)] * (solids in ("obstacle", "body"))
    plain = to_plain(tank(deep=16, jitter=0.2, walls=walls))
    gauges = [{"name": f"p{k}", "position": list(place)} for k, place in enumerate(places)]
    numbers, _ = read(from_plain({**plain, **SOLIDS[solids], "gauges": gauges, "seed": seed}))
    assert list(numbers.values()) == pytest.approx([1.0 - y for _, y in places], abs=1e-9)


@pytest.mark.parametrize("way", [-0.1, 0.1])
def test_a_probe_on_a_wall_that_moves_has_the_room_before_the_wall(way):
    """The liquid has followed the wall; the sensor stays where the wall was."""
    move = {"times": [0.0, 1.0], "positions": [0.0, way]}
    plain = to_plain(tank(deep=16, jitter=0.0))
    plain["tank"] |= {"right": {"motion": move}}
    scene = from_plain({**plain, "gauges": [{**PRESSURE, "position": [1.0, 0.25]}]})
    parameters = SPH.parameters(scene)
    state = start(scene, parameters)
    state.clock[0] = 1.0
    state.position[0] += way * state.position[0]
    state.density[:] /= 1.0 + way
    numbers, _ = readings(with_moved_solids(parameters, state), state, np.ones(state.density.shape))
    assert numbers["P_pressure"] == pytest.approx(1.0)


def read_particles(places, pressure, gauges, **more):
    """What gauges in a tank read of these particles, all with the same pressure."""
    scene = with_gauges(*gauges, fluid=[{"particles": {"positions": places}}], **more)
    parameters = SPH.parameters(scene)
    return readings(parameters, start(scene, parameters), np.full(len(places), pressure))[0]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_reading_is_never_more_than_that_of_the_covered_part(seed, sign):
    """One to five particles near a sensor: a sum of Gaussians, mirrored at the wall, tells what they cover."""
    dice, spacing = np.random.default_rng(seed), 1.0 / 16
    places = [
        (1.0 - spacing * dice.uniform(0.2, 2.5), 0.5 + spacing * dice.uniform(-2.0, 2.0)) for _ in range(1 + seed)
    ]
    found = sign * read_particles(places, sign * 7.0, [{"name": "P", "position": [1.0, 0.5]}])["P_pressure"]
    away = np.sum((np.array(places) - [1.0, 0.5]) ** 2, axis=1) / spacing**2
    covered = min(1.0, 2.0 * 2.0 * float(np.exp(-away).sum()) / np.pi)
    assert 0.0 <= found <= 7.0 * covered * (1.0 + 1e-6)
    assert found == pytest.approx(7.0 * covered, rel=1e-6) or covered < 0.3  # or dry


def test_a_droplet_is_felt_as_it_arrives():
    spacing, gauges = 1.0 / 16, [{"name": "P", "position": [1.0, 0.5], "quantities": ["pressure", "velocity"]}]
    felt = [
        read_particles([(1.0 - away * spacing, 0.5)], 1.0, gauges)["P_pressure"]
        for away in (2.0, 1.5, 1.35, 1.0, 0.5, 0.1)
    ]
    assert felt == sorted(felt)
    assert felt[2] < 0.25
    assert felt[-1] == 1.0


def test_air_has_the_pressure_of_the_atmosphere_and_no_reading_depends_on_where_a_period_begins():
    sides = {"left": {"kind": "periodic"}, "right": {"kind": "periodic"}, "high": [1.0, 2.0]}
    absolute = {"position": [0.0, 0.1], "quantities": ["absolute_pressure"]}
    liquid, spacing = {"density": 1.0, "sound_speed": 10.0, "atmospheric_pressure": 5.0}, 1.0 / 16
    numbers = read_particles(
        [(1.0 - 0.3 * spacing, 0.1)], 2.0,
        [{**absolute, "name": "A"}, {**absolute, "name": "B", "position": [0.5, 1.0]}], tank=sides, liquid=liquid,
    )  # fmt: skip
    assert numbers["B_absolute_pressure"] == 5.0
    shifted = read_particles([(0.5, 0.1)], 2.0, [{**absolute, "name": "A", "position": [0.5 + 0.3 * spacing, 0.1]}],
                             tank=sides, liquid=liquid)  # fmt: skip
    assert numbers["A_absolute_pressure"] == pytest.approx(shifted["A_absolute_pressure"])


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
