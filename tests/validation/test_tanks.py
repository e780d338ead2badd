"""What the cases of liquids with a free surface see, without the minutes that their runs take."""

import math

import numpy as np
import pytest

from ecume.trajectories.frame import Frame
from ecume_validation import dam_break as dam
from ecume_validation import impact, tank
from ecume_validation import standing_wave as wave
from ecume_validation.runner import sph_scene

WELL = tank.Rest(error=0.004, largest=0.01, from_column=0.004, speed=1e-5, center=0.5, hits=0.0, there=256)


@pytest.mark.parametrize(
    ("fault", "named"),
    [
        ({"error": 0.02}, "pressure's error"),
        ({"from_column": 0.02}, "Tait's column"),
        ({"largest": 0.02}, "largest"),
        ({"speed": 1e-3}, "speed"),
        ({"center": 0.49}, "shift"),
        ({"hits": 1.0}, "guard"),
        ({"there": 255}, "lost"),
    ],
)
def test_each_fault_of_a_tank_is_seen_in_its_own_row(fault, named):
    frames = [WELL] * 30 + [WELL._replace(**fault)] * 10
    (missed,) = [row.name for row in tank.rows_of("a tank", frames) if not row.met]
    assert named in missed


def test_a_tank_without_faults_passes_and_one_that_creeps_is_reported():
    assert all(row.met for row in tank.rows_of("a tank", [WELL] * 40))
    assert tank.creep([WELL._replace(center=0.5 + 1e-5 * n) for n in range(40)]) == pytest.approx(9e-5)


def test_a_column_of_liquid_at_rest_has_no_error_against_itself():
    height = np.linspace(0.01, 0.99, 50)
    pressure = tank.column(height, 1.0)
    assert pressure[0] == pytest.approx(1.0 - 0.01 * 1.0097, abs=1e-5)  # the weight above
    arrays = {
        "position": np.stack([np.full(50, 0.5), height], axis=1),
        "velocity": np.tile([3e-3, 4e-3], (50, 1)),
        "pressure": pressure,
        "mass": np.full(50, 0.02),
    }
    read = tank.rest(Frame(0.0, arrays, {"center_y": 0.5, "guard_hits": 0.0}, {}))
    assert read.from_column < 1e-12
    assert 0.001 < read.error < 0.005  # the column is half a percent shorter
    assert read.speed == pytest.approx(5e-3)
    assert read.there == 50


def test_a_wave_is_read_out_of_its_heights():
    times = np.linspace(0.0, 12.0, 241)
    noise = 1e-6 * np.sin(37.0 * times)
    found = wave.fitted(times, 0.02 * np.exp(-0.3 * times) * np.sin(1.7 * times) + noise)
    assert found == pytest.approx((0.3, 1.7), rel=1e-4)


def test_a_front_that_lags_and_a_wall_that_is_pressed_too_little_are_seen():
    times, places = dam.published("front", "wcsph-400")
    during = np.append(times, [3.5, 4.0])
    fronts = np.append(places, [5.3, 5.3])
    means = [float(dam.published(f"mean_pressure_{sensor}", "wcsph-400")[1][0]) for sensor in dam.SENSORS]
    pressures, still = np.tile(means, (len(during), 1)), np.ones(len(during))
    run = dam.Broken(during, fronts, still, pressures, np.zeros((len(during), 4)), still)
    late = run._replace(fronts=fronts - 0.06, pressures=0.9 * pressures, volumes=still + 0.02)
    assert all(row.met for row in (*dam.front(run, 80), *dam.pressure(run, 80), dam.volume(run, 80)))
    assert not any(row.met for row in dam.front(late, 80))
    assert not dam.pressure(late, 80)[0].met
    assert not dam.volume(late, 80).met
    assert dam.order(late, late._replace(fronts=fronts - 0.03)).computed == pytest.approx(1.0)


def test_what_lasts_of_a_creep_is_the_decay_of_a_quarter():
    frames = [WELL._replace(center=0.5 - 1e-3 * math.exp(-k / 50)) for k in range(200)]
    assert tank.lasting(frames) == pytest.approx(math.exp(-1.0))
    assert tank.lasting([WELL._replace(center=0.5 - 1e-6 * k) for k in range(200)]) == pytest.approx(1.0)  # a drift


def struck(peak=3.044, least=0.0, late=0.0):
    """Sensors of an impact as in the experiment: a jump to the peak, and a decay to a plateau."""
    times = np.arange(0.0, impact.LASTING, 1e-3)
    arrivals = [impact.published("arrival", sensor) + late for sensor in impact.SENSORS]
    after = np.maximum(times[:, None] - np.array(arrivals), 0.0)
    pressures = np.where(after > 0.0, 0.7 + (peak - 0.7) * np.minimum(after / 0.013, 1.0) * np.exp(-after / 0.2), 0.0)
    pressures[times > 3.2, 0] += least - 0.7
    return impact.Impact(times, pressures, 1.05 * pressures[:, 0])


def test_an_impact_as_in_the_experiment_is_within_all_limits():
    rows = impact.rows_of("H/40", struck(), 2.8)
    assert all(row.met for row in rows)
    assert rows[0].computed == pytest.approx(3.0, rel=0.1)
    assert "experiment: 3.04, other code: 2.8" in rows[0].name


@pytest.mark.parametrize(
    ("fault", "named"),
    [
        ({"peak": 6.0}, "peak of S1"),
        ({"least": -1.0}, "least pressure"),
        ({"late": 0.3}, "arrival at S4"),
        ({"late": -0.3}, "arrival at S1"),
    ],
)
def test_each_fault_of_an_impact_is_seen(fault, named):
    assert any(named in row.name for row in impact.rows_of("H/40", struck(**fault), 2.8) if not row.met)


def test_impacts_of_known_course_have_their_rise_time_and_impulse():
    times = np.linspace(0.0, 2.0, 2001)
    tent = np.clip(1.0 - np.abs(times - 1.0) / 0.2, 0.0, None)
    assert impact.arrival(times, tent) == pytest.approx(0.82, abs=2e-3)
    assert impact.rise_time(times, tent) == pytest.approx(0.2, abs=3e-3)
    assert impact.impulse(times, tent) == pytest.approx(0.2 - 0.5 * 0.02 * 0.1, abs=1e-3)
    assert impact.averaged(times, tent).max() == pytest.approx(1.0 - 0.25 * impact.WINDOW / 0.2, abs=1e-3)
    assert math.isnan(impact.arrival(times, np.zeros_like(times)))


def test_sensors_of_the_experiment_are_read_over_their_height():
    scene = sph_scene("dam_break", [impact.sensors()])
    first = np.array(scene.gauges[0].position), np.array(scene.gauges[0].end)
    assert [spec.name for spec in scene.gauges] == list(impact.SENSORS)
    assert 0.5 * (first[0] + first[1]) == pytest.approx([5.366, 0.01])
    assert first[1][1] - first[0][1] == pytest.approx(0.8 * impact.DIAMETER)
    frame = Frame(0.5, {}, {f"{name}_{n}_pressure": float(n) for name in impact.SENSORS for n in range(1, 6)}, {})
    read = impact.read([frame, frame])
    assert read.pressures == pytest.approx(np.full((2, 4), 3.0))
    assert read.center == pytest.approx(3.0)
