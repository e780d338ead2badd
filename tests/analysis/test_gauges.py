"""Readings of probes, wall sensors and level gauges in a frame of particles."""

import numpy as np
import pytest

from ecume.analysis import gauges
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame

SPACING = 0.05
REACH = 4 * SPACING


def still(dimension=2, jitter=0.0, depth=1.0):
    """A block of still liquid from x = 0 to 2 (and z = 0 to 1); the pressure equals the depth, and the velocity is a
    shear.
    """
    lengths = [2.0, depth, 1.0][:dimension]
    axes = [SPACING * (np.arange(round(length / SPACING)) + 0.5) for length in lengths]
    position = np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1)
    position = position + jitter * SPACING * np.random.default_rng(1).uniform(-1, 1, position.shape)
    count = len(position)
    velocity = np.zeros_like(position)
    velocity[:, 0] = 3.0 * position[:, 1]
    arrays = {
        "position": position,
        "velocity": velocity,
        "pressure": depth - position[:, 1],
        "density": np.full(count, 1000.0),
        "mass": np.full(count, 1000.0 * SPACING**dimension),
    }
    return Frame(0.0, arrays, {}, {})


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_probe_reads_the_pressure_of_its_depth_and_the_velocity_there(dimension):
    frame = still(dimension)
    points = np.array([[1.0, 0.4, 0.5][:dimension], [0.8, 0.55, 0.5][:dimension]])
    assert gauges.values_at(frame, "pressure", points, REACH) == pytest.approx([0.6, 0.45], abs=1e-3)
    velocity = gauges.values_at(frame, "velocity", points, REACH)
    assert velocity.shape == points.shape
    assert velocity[:, 0] == pytest.approx(3.0 * points[:, 1], abs=3e-3)


def test_nothing_is_read_where_there_is_no_liquid():
    frame = still()
    points = np.array([[1.0, 1.5], [1.0, 0.5]])
    assert np.isnan(gauges.values_at(frame, "pressure", points, REACH)).tolist() == [True, False]
    assert np.isnan(gauges.linear_values_at(frame, "pressure", points, REACH)).tolist() == [True, False]


def test_surroundings_are_full_inside_half_full_at_a_wall_and_empty_outside():
    parts = gauges.filled(still(), np.array([[1.0, 0.5], [1.0, 0.0], [1.0, 1.0], [1.0, 1.3]]), REACH)
    assert parts == pytest.approx([1.0, 0.5, 0.5, 0.0], abs=0.01)


def test_a_linear_probe_is_exact_up_to_the_wall_where_the_mean_looks_into_the_liquid():
    frame, floor = still(jitter=0.2), np.array([[1.0, 0.0]])
    assert gauges.linear_values_at(frame, "pressure", floor, REACH) == pytest.approx([1.0], abs=1e-9)
    assert gauges.values_at(frame, "pressure", floor, REACH)[0] < 0.97
    assert gauges.linear_values_at(frame, "velocity", floor, REACH) == pytest.approx(np.zeros((1, 2)), abs=1e-9)


def test_a_sensor_reads_the_mean_over_its_face_and_nothing_while_it_is_dry():
    frame = still(jitter=0.2)
    sensor = gauges.points_along((2.0, 0.2), (2.0, 0.4), 5)
    assert gauges.wall_pressure(frame, sensor, REACH) == pytest.approx(0.7, abs=1e-9)
    assert gauges.wall_pressure(frame, sensor + np.array([0.0, 2.0]), REACH) == 0.0


def test_a_few_stray_particles_are_read_without_a_slope():
    frame = still()
    one = Frame(0.0, {name: array[:1] for name, array in frame.arrays.items()}, {}, {})
    read = gauges.linear_values_at(one, "pressure", one.arrays["position"], REACH)
    assert read == pytest.approx(one.arrays["pressure"])


@pytest.mark.parametrize(("dimension", "places"), [(2, [0.5, 1.1]), (3, [[0.5, 0.5], [1.1, 0.4]])])
def test_the_level_is_the_depth_whatever_the_places(dimension, places):
    assert gauges.water_level(still(dimension), np.array(places), REACH) == pytest.approx([1.0, 1.0], abs=0.01)


def test_a_wave_stands_as_high_as_it_was_made_and_counts_upwards_at_its_crest():
    frame, wavenumber = still(), np.pi / 2.0
    raised = 0.1 * np.cos(wavenumber * frame.arrays["position"][:, 0])
    arrays = {**frame.arrays, "mass": frame.arrays["mass"] * (1.0 + raised)}
    assert gauges.wave_amplitude(Frame(0.0, arrays, {}, {}), wavenumber, 2.0) == pytest.approx(0.1, rel=1e-6)


def test_what_cannot_be_read_is_said():
    frame = still()
    with pytest.raises(BadInput, match=r"no array 'presure'; they have .*pressure"):
        gauges.values_at(frame, "presure", np.zeros((1, 2)), REACH)
    with pytest.raises(BadInput, match=r"expected \(points, 2\)"):
        gauges.filled(frame, np.zeros((1, 3)), REACH)
    with pytest.raises(BadInput, match="four spacings"):
        gauges.filled(frame, np.zeros((1, 2)), 0.0)


def test_a_sensor_does_not_hide_a_pressure_that_is_not_a_number():
    frame = still()
    frame.arrays["pressure"][...] = np.nan
    assert np.isnan(gauges.wall_pressure(frame, np.array([[0.0, 0.5]]), REACH))
    assert gauges.wall_pressure(frame, np.array([[0.0, 3.0]]), REACH) == 0.0
