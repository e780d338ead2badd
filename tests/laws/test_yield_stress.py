"""Liquids that thin, thicken or yield, compared with an integration of their definition."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from ecume.laws.yield_stress import apparent_viscosity, channel_speed, creep_rate

LIQUIDS = [(1.0, 1.0, 0.0), (4.0, 0.5, 0.0), (0.2, 1.7, 0.0), (1.0, 1.0, 4.0), (0.5, 0.6, 3.0), (2.0, 1.3, 6.0)]
"""Consistency, exponent, yield stress."""


@pytest.mark.parametrize("liquid", LIQUIDS)
def test_the_stress_is_that_of_herschel_and_bulkley(liquid):
    consistency, exponent, stress = liquid
    for rate in (1e-3, 0.3, 1.0, 40.0):
        shear = rate * apparent_viscosity(rate, *liquid, math.inf)
        assert shear == pytest.approx(stress + consistency * rate**exponent, rel=1e-14)


@pytest.mark.parametrize("liquid", LIQUIDS)
def test_nothing_is_stiffer_than_the_largest_viscosity(liquid):
    for rate in (0.0, 1e-12, 1e-3, 1.0, 1e3):
        assert apparent_viscosity(rate, *liquid, 7.0) <= 7.0
    assert math.isfinite(apparent_viscosity(0.0, *liquid, 7.0))


@pytest.mark.parametrize("liquid", [each for each in LIQUIDS if each[1] < 1.0 or each[2] > 0.0])
def test_below_the_rate_of_creep_the_viscosity_is_the_largest(liquid):
    largest = 50.0
    rate = creep_rate(*liquid, largest)
    assert apparent_viscosity(0.999 * rate, *liquid, largest) == largest
    assert apparent_viscosity(1.001 * rate, *liquid, largest) < largest


def test_a_liquid_that_yields_and_thickens_creeps_below_the_lower_of_two_rates():
    """Its viscosity is the largest beyond a high rate, too: the rate of creep was 1e30."""
    liquid, largest = (1.0, 2.0, 100.0), 50.0
    rate = creep_rate(*liquid, largest)
    assert rate == pytest.approx(25.0 - math.sqrt(525.0), rel=1e-9)
    assert creep_rate(*liquid, 19.0) == pytest.approx(10.0, rel=1e-9)  # everywhere: that of the smallest viscosity


def test_a_newtonian_liquid_never_creeps():
    assert creep_rate(1.0, 1.0, 0.0, 1.0) == 0.0
    assert creep_rate(0.0, 1.0, 3.0, 6.0) == pytest.approx(0.5, rel=1e-12)


@pytest.mark.parametrize("liquid", LIQUIDS)
@pytest.mark.parametrize("place", [0.0, 0.3, 0.7, 0.95, 1.0])
def test_the_profile_of_a_channel_integrates_the_rate_at_the_stress_there(liquid, place):
    """The stress is G y, whatever the liquid: its rate of strain is ((G y - tau_y) / K)^(1/n)."""
    consistency, exponent, stress = liquid
    gradient, half = 10.0, 1.0

    def rate(y):
        return (max(gradient * y - stress, 0.0) / consistency) ** (1.0 / exponent)

    expected, _ = quad(rate, place, half, points=[min(max(stress / gradient, place), half)])
    assert channel_speed(place, half, gradient, *liquid) == pytest.approx(expected, rel=1e-8, abs=1e-12)
    assert channel_speed(-place, half, gradient, *liquid) == channel_speed(place, half, gradient, *liquid)


def test_a_plug_that_fills_the_channel_does_not_move():
    assert channel_speed(0.0, 1.0, 2.0, 1.0, 1.0, 2.5) == 0.0
    plug = np.linspace(0.0, 0.39, 5)
    assert len({channel_speed(y, 1.0, 10.0, 1.0, 1.0, 4.0) for y in plug}) == 1
