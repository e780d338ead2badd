"""Sloshing: the series against its own equation, and what the case sees."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ecume.laws.water_waves import BaseExcitation, Tank, sloshing_height, sloshing_mode, wave_frequency
from ecume_validation import sloshing as case
from ecume_validation.runner import case_scene


@pytest.mark.parametrize(("mode", "viscosity"), [(1, 0.0), (3, 0.01), (5, 0.2)])
def test_a_mode_moves_as_its_equation_says_also_where_it_creeps(mode, viscosity):
    tank, excitation = Tank(2.0, 1.0, 1.0, viscosity), BaseExcitation(0.01, 0.9, 0.7)
    k = mode * math.pi / 2.0
    swing, decay, push = wave_frequency(k, 1.0, 1.0), 2.0 * viscosity * k * k, 4.0 * math.tanh(k) / (mode * math.pi)

    def rates(time, b):
        pull = excitation.amplitude * math.sin(excitation.turning * time + excitation.phase)
        return [b[1], -2.0 * decay * b[1] - swing**2 * b[0] - push * pull]

    found = solve_ivp(rates, (0.0, 7.3), [0.0, 0.0], rtol=1e-11, atol=1e-14).y[0, -1]
    assert sloshing_mode(7.3, mode, tank, excitation) == pytest.approx(found, rel=1e-7, abs=1e-12)


def test_a_slow_pull_tilts_the_surface_until_it_is_level_again():
    slow = BaseExcitation(0.02, 1e-7, math.pi / 2.0)
    tank = Tank(2.0, 1.0, 9.81, 1e-2)
    heights = np.array([sloshing_height(x, 1e4, tank, slow) for x in (0.0, 0.5, 1.0, 1.5, 2.0)])
    np.testing.assert_allclose(heights, 0.02 / 9.81 * np.array([-1.0, -0.5, 0.0, 0.5, 1.0]), atol=0.012 * 0.02 / 9.81)


def test_the_case_sees_a_wave_that_is_too_low_too_slow_or_hits_walls():
    scene = case_scene("sloshing")
    times = np.arange(0.0, 15.0, 0.1)
    exact = case.series(times, scene)
    late = np.where(times >= case.SETTLED, 0.0, 0.01)
    good = case.Rise(times, 0.98 * exact + late, exact, 0.0)
    assert all(row.met for row in case.rows_of(good, 32))
    for broken in (
        good._replace(computed=0.9 * exact),
        good._replace(computed=case.series(1.03 * times, scene)),
        good._replace(hits=1.0),
    ):
        assert not all(row.met for row in case.rows_of(broken, 32))
