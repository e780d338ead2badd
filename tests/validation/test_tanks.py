"""What the cases of liquids with a free surface see, without the minutes that their runs take."""

import math

import numpy as np
import pytest

from ecume.trajectories.frame import Frame
from ecume.validation import dam_break as dam
from ecume.validation import standing_wave as wave
from ecume.validation import tank

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


def test_a_wall_that_is_struck_as_in_the_experiment_meets_all_but_the_other_code():
    times = np.arange(0.0, 3.6, dam.INSTANT)
    pressures = np.stack([sensor(k, times) for k in (1, 2, 3)], axis=1)
    rows = dam.impact(dam.Impact(times, pressures), 40)
    assert [row.name for row in rows if not row.met] == [rows[-1].name]
    assert "another code" in rows[-1].name


@pytest.mark.parametrize(
    ("fault", "named"),
    [
        (lambda p, t: np.where(abs(t - 2.46) < 2e-3, 30.0, p), {"highest reading"}),
        (lambda p, t: np.where(abs(t - 2.6) < 2e-3, -3.0, p), {"lowest reading"}),
        (lambda p, t: np.where(abs(t - 2.6) < 0.03, -1.0, p), {"lowest reading", "lowest average"}),
        (lambda p, t: 2.0 * p, {"highest average", "highest reading", "impulse"}),
        (lambda p, t: np.interp(t - 0.25, t, p), {"time at half"}),
    ],
)
def test_each_fault_of_an_impact_is_seen(fault, named):
    times = np.arange(0.0, 3.6, dam.INSTANT)
    pressures = np.stack([fault(sensor(k, times), times) for k in (1, 2, 3)], axis=1)
    rows = dam.impact(dam.Impact(times, pressures), 40)[:-1]
    assert {what for row in rows if not row.met for what in named if what in row.name} == named
    assert all(any(what in row.name for what in named) for row in rows if not row.met)


def sensor(k, times):
    """The published readings of a sensor, with the rise to its peak."""
    parts = [dam.published(f"sensor_{what}S{k}", "peak-event") for what in ("half_rise_", "peak_", "")]
    known = sorted({(float(t), float(p)) for part in parts for t, p in zip(*part, strict=True)})
    when, values = np.array([(known[0][0] - 0.01, 0.0), *known]).T
    return np.interp(times, when, values, left=0.0)
