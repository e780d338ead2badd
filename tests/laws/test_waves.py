"""Waves: dispersion, viscous decay, and dam breaks in shallow water."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import eig
from tests.oracles import dam_breaks

from ecume.errors import BadInput
from ecume.laws import water_waves


@pytest.mark.parametrize(
    ("length", "depth", "mode", "gravity", "expected"),
    [(2.0, 1.0, 1, 9.81, 3.759371), (1.0, 0.5, 1, 9.81, 5.316553), (1.73, 0.6, 1, 9.81, 3.767381),
     (0.9, 0.093, 1, 9.81, 3.277461), (1.0, 1.0, 1, 1.0, 1.769147)],
)  # fmt: skip
def test_standing_waves_have_the_known_frequencies(length, depth, mode, gravity, expected):
    assert water_waves.wave_frequency(mode * math.pi / length, depth, gravity) == pytest.approx(expected, abs=6e-7)


def test_surface_tension_hurries_short_waves():
    short, long = 2 * math.pi / 5e-3, 2 * math.pi / 0.5
    assert water_waves.wave_frequency(short, 1.0, 9.81, 7.2e-5) > 1.5 * water_waves.wave_frequency(short, 1.0, 9.81)
    assert water_waves.wave_frequency(long, 1.0, 9.81, 7.2e-5) == pytest.approx(
        water_waves.wave_frequency(long, 1.0, 9.81), rel=2e-3
    )


ROOTS = [
    # wavelength / depth, Reynolds number, rate, frequency
    (2, 50, 0.2966515, 1.6817676), (2, 100, 0.1636224, 1.7372371), (2, 1000, 0.0186977, 1.7681112),
    (2, 2500, 0.0076326, 1.7688845), (4, 50, 0.0854480, 1.1875663), (4, 1000, 0.0047896, 1.2001298),
    (1, 100, 0.5505495, 2.3044727), (1, 500, 0.1377818, 2.4871161), (1, 2500, 0.0298046, 2.5048526),
]  # fmt: skip


@pytest.mark.parametrize(("ratio", "reynolds", "rate", "frequency"), ROOTS)
def test_viscous_waves_decay_as_the_tabled_roots(ratio, reynolds, rate, frequency):
    found = water_waves.viscous_decay(2 * math.pi / ratio, 1.0, 1.0, 1.0 / reynolds)
    assert found.rate == pytest.approx(rate, abs=6e-8)
    assert found.frequency == pytest.approx(frequency, abs=6e-8)


def test_the_decay_is_an_eigenvalue_of_the_linear_equations():
    """Chebyshev collocation of the vertical velocity and the surface: nothing shared with the closed form."""
    k, nu, g, sigma, n = 2.0, 0.03, 1.3, 0.2, 24
    y = np.cos(math.pi * np.arange(n + 1) / n)
    weights = np.hstack([2.0, np.ones(n - 1), 2.0]) * (-1.0) ** np.arange(n + 1)
    apart = y[:, None] - y[None, :] + np.eye(n + 1)
    d = np.outer(weights, 1.0 / weights) / apart
    d -= np.diag(d.sum(axis=1))
    d *= 2.0  # the depth 1 is half of the nodes' range
    d2 = d @ d
    one = np.eye(n + 1)
    laplace = d2 - k * k * one
    # s laplace w = nu laplace^2 w inside; unknowns w and the surface's height z.
    left = np.zeros((n + 2, n + 2), complex)
    right = np.zeros_like(left)
    left[: n + 1, : n + 1], right[: n + 1, : n + 1] = nu * laplace @ laplace, laplace
    for row, condition in ((0, (d2 + k * k * one)[0]), (n, one[n]), (n - 1, d2[n])):
        left[row, :], right[row, :] = 0.0, 0.0
        left[row, : n + 1] = condition
    # Normal stress, with the pressure from the equation along the surface.
    left[1, :], right[1, :] = 0.0, 0.0
    left[1, : n + 1] = nu * (d @ laplace)[0] - 2.0 * nu * k * k * d[0]
    left[1, n + 1] = -(g + sigma * k * k) * k * k
    right[1, : n + 1] = d[0]
    left[n + 1, 0], right[n + 1, n + 1] = 1.0, 1.0
    values = eig(left, right, right=False)
    swinging = values[np.isfinite(values) & (values.imag > 0.3) & (np.abs(values) < 10.0)]
    found = water_waves.viscous_decay(k, 1.0, g, nu, sigma)
    assert np.min(np.abs(swinging - complex(-found.rate, found.frequency))) < 1e-7


def test_thin_liquids_decay_by_two_nu_k_squared():
    assert water_waves.viscous_decay(3.0, 5.0, 9.81, 1e-9).rate == pytest.approx(2 * 1e-9 * 9.0, rel=1e-3)
    assert water_waves.viscous_decay(3.0, 5.0, 9.81, 0.0) == (0.0, water_waves.wave_frequency(3.0, 5.0, 9.81))


def test_a_wave_in_honey_is_overdamped():
    with pytest.raises(BadInput, match="overdamped"):
        water_waves.viscous_decay(2 * math.pi, 1.0, 1.0, 5.0)


def test_ritters_water_is_neither_made_nor_lost():
    volume, _ = quad(dam_breaks.ritter_depth, -7.0, 7.0, args=(1.0, 1.0, 9.81), points=[-(9.81**0.5), 2 * 9.81**0.5])
    assert volume == pytest.approx(7.0, rel=1e-9)
    assert dam_breaks.ritter_depth(-4.0, 1.0, 1.0, 9.81) == pytest.approx(1.0)
    assert dam_breaks.ritter_depth(6.3, 1.0, 1.0, 9.81) == dam_breaks.ritter_speed(6.3, 1.0, 1.0, 9.81) == 0.0
    assert dam_breaks.ritter_speed(-4.0, 1.0, 1.0, 9.81) == 0.0


def test_ritters_water_flows_as_its_characteristics_say():
    for x in (-5.0, -1.0, 0.0, 3.0, 9.0):
        depth, speed = dam_breaks.ritter_depth(x, 2.0, 1.3, 9.81), dam_breaks.ritter_speed(x, 2.0, 1.3, 9.81)
        assert speed + 2.0 * math.sqrt(9.81 * depth) == pytest.approx(2.0 * math.sqrt(9.81 * 1.3))
        assert speed - math.sqrt(9.81 * depth) == pytest.approx(x / 2.0)


@pytest.mark.parametrize(
    ("wet", "depth", "speed", "bore"),
    [(0.01, 0.1711789, 1.1725245, 1.2452713), (0.1, 0.3961748, 0.7411516, 0.9913929),
     (0.3, 0.5914327, 0.4619067, 0.9373922), (0.5, 0.7269204, 0.2948074, 0.9443906)],
)  # fmt: skip
def test_stokers_bore_is_that_of_the_table(wet, depth, speed, bore):
    assert tuple(dam_breaks.stoker_bore(1.0, wet, 1.0)) == pytest.approx((depth, speed, bore), abs=6e-8)


def test_stokers_water_is_neither_made_nor_lost():
    shelf = 2 * 9.81**0.5 - 3 * (9.81 * dam_breaks.stoker_bore(1.0, 0.3, 9.81).middle_depth) ** 0.5
    edges = [-(9.81**0.5), shelf, dam_breaks.stoker_bore(1.0, 0.3, 9.81).bore_speed]
    volume, _ = quad(dam_breaks.stoker_depth, -5.0, 5.0, args=(1.0, 1.0, 0.3, 9.81), points=edges)
    assert volume == pytest.approx(5.0 + 5.0 * 0.3, rel=1e-9)


@pytest.mark.parametrize("wet", [0.0, -0.1, 1.0, 2.0, math.nan])
def test_a_bore_needs_water_below_the_dams(wet):
    with pytest.raises(BadInput, match="downstream"):
        dam_breaks.stoker_bore(1.0, wet, 9.81)


def test_waves_between_two_liquids_have_the_limits_of_one():
    lower = water_waves.Layer(1000.0, 0.3)
    light = water_waves.interface_frequency_squared(7.0, lower, water_waves.Layer(1e-9, 0.2), 9.81, 0.07)
    assert math.sqrt(light) == pytest.approx(water_waves.wave_frequency(7.0, 0.3, 9.81, 0.07 / 1000.0), rel=1e-9)
    upper = water_waves.Layer(800.0, 0.2)
    assert water_waves.interface_frequency_squared(7.0, lower, water_waves.Layer(1000.0, 0.2), 9.81) == 0.0
    stable = water_waves.interface_frequency_squared(7.0, lower, upper, 9.81)
    assert stable == pytest.approx(-water_waves.interface_frequency_squared(7.0, lower, upper, -9.81))
    shallow = water_waves.interface_frequency_squared(1e-4, lower, upper, 9.81)
    assert shallow == pytest.approx(1e-8 * 9.81 * 200.0 / (1000.0 / 0.3 + 800.0 / 0.2), rel=1e-6)
