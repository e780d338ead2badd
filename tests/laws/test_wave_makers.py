"""Wave makers: limits of the strokes, the variance of spectra, and steady waves against the equations of motion."""

import math

import pytest
from scipy.integrate import quad

from ecume.errors import BadInput
from ecume.laws.water_waves import wave_frequency
from ecume.laws.wave_makers import flap_ratio, jonswap, piston_ratio, second_order_elevation, wavenumber_at


@pytest.mark.parametrize("deep", [1e-3, 0.1, 1.0, 5.0, 400.0])
def test_the_wavenumber_has_the_frequency_that_was_asked_for(deep):
    wavenumber = wavenumber_at(math.sqrt(9.81 * deep), 0.7, 9.81)
    assert wave_frequency(wavenumber, 0.7, 9.81) == pytest.approx(math.sqrt(9.81 * deep), rel=1e-12)


def test_a_frequency_that_is_not_positive_is_refused():
    with pytest.raises(BadInput, match="angular_frequency"):
        wavenumber_at(-1.0, 1.0, 9.81)


@pytest.mark.parametrize("law", [piston_ratio, flap_ratio, lambda k, depth: second_order_elevation(0.1, k, depth, 0.0)])
def test_water_without_depth_is_refused(law):
    with pytest.raises(BadInput, match="depth"):
        law(1.0, 0.0)
    with pytest.raises(BadInput, match="wavenumber"):
        law(0.0, 1.0)


@pytest.mark.parametrize(("ratio", "speed"), [(piston_ratio, lambda z, h: 1.0), (flap_ratio, lambda z, h: z / h)])
@pytest.mark.parametrize("k", [0.3, 2.0, 8.0])
def test_the_maker_moves_what_the_progressive_wave_takes_from_it(ratio, speed, k):
    """The part of the maker's speed along cosh k z, over that of a wave of unit height and frequency."""
    part = (
        quad(lambda z: speed(z, 1.0) * math.cosh(k * z), 0.0, 1.0)[0]
        / quad(lambda z: math.cosh(k * z) ** 2, 0.0, 1.0)[0]
    )
    assert ratio(k, 1.0) == pytest.approx(part * math.sinh(k), rel=1e-9)


@pytest.mark.parametrize(("ratio", "less"), [(piston_ratio, 0.0), (flap_ratio, 2.0)])
@pytest.mark.parametrize("deep", [40.0, 99.0, 101.0, 2000.0])
def test_makers_in_deep_water_have_their_limits_where_hyperbolic_functions_overflow(ratio, less, deep):
    assert ratio(deep, 1.0) == pytest.approx(2.0 - less / deep, rel=1e-12)


@pytest.mark.parametrize("gamma", [1.0, 3.3, 7.0])
def test_the_significant_height_of_a_spectrum_is_the_one_that_was_asked_for(gamma):
    """Four times the root of the variance, within the fit of its factor."""
    variance = quad(lambda f: jonswap(f, 0.5, 0.1, gamma), 0.01, 20.0, limit=500)[0]
    assert 4.0 * math.sqrt(variance) == pytest.approx(0.1, rel=5e-3)
    assert max((jonswap(f / 200.0, 0.5, 0.1, gamma), f) for f in range(20, 400))[1] == pytest.approx(100, abs=1)


def test_steady_waves_of_second_order_keep_their_mean_and_are_peaked():
    turns = [2.0 * math.pi * n / 64 for n in range(64)]
    heights = [second_order_elevation(0.1, 2.0, 0.8, turn) for turn in turns]
    assert sum(heights) == pytest.approx(0.0, abs=1e-12)
    assert heights[0] > -heights[32]
