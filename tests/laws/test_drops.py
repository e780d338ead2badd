"""Exact oscillations of drops."""

import math

import numpy as np
import pytest
from scipy.special import iv

from ecume.errors import BadInput
from ecume.laws.drops import drop_decay, drop_period


def test_drops_swing_slower_when_they_are_large():
    assert drop_period(7e-5, 2e-3, 2, 3) > drop_period(7e-5, 1e-3, 2, 3)
    assert drop_period(1.0, 1.0, 2, 2) == pytest.approx(2 * math.pi / math.sqrt(6.0))
    assert drop_period(1.0, 1.0, 3, 3) == pytest.approx(2 * math.pi / math.sqrt(30.0))


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("mode", [2, 3, 4])
def test_thin_liquids_fade_as_lamb_s_globe_does(mode, dim):
    rate = (mode - 1) * (2 * mode + dim - 2)
    errors = [drop_decay(1.0, nu, 1.0, mode, dim).rate / (rate * nu) - 1.0 for nu in (1e-6, 1e-8)]
    # The next term goes with the root of the viscosity.
    assert abs(errors[0]) < 0.01
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.1)
    assert drop_decay(1.0, 0.0, 1.0, mode, dim).rate == 0.0


@pytest.mark.parametrize("dim", [2, 3])
def test_no_stress_is_left_at_the_surface(dim):
    # The flow itself, from the growth rate: potential flow and vorticity, and what the surface feels of them.
    nu, n = 0.05, 2
    found = drop_decay(1.0, nu, 1.0, n, dim)
    s, order = complex(-found.rate, found.frequency), n + 0.5 * (dim - 2)
    k = np.sqrt(s / nu)

    def vorticity(r):
        return iv(order, k * r) / iv(order, k) * r ** (-0.5 * (dim - 2))

    # Radial speed n f/r (in a plane) or n (n+1) f/r (in space), speed along the surface -f' or f' + f/r; R = 1.
    step = 1e-4
    r = 1.0 + step * np.array([-1.0, 0.0, 1.0])
    slopes, bends = [], []
    for f in (r**n + 0j, vorticity(r)):
        slopes.append((f[2] - f[0]) / (2.0 * step))
        bends.append((f[2] - 2.0 * f[1] + f[0]) / step**2)
    shears = [
        bend - slope + n * n if dim == 2 else bend + n * (n + 1) - 2.0
        for slope, bend in zip(slopes, bends, strict=True)
    ]
    part = -shears[0] / shears[1]
    slope, value = slopes[0] + part * slopes[1], 1.0 + part
    stiff = n * (n - 1) * (n + dim - 1)
    normal = s + 2.0 * nu * n * (slope - value) + stiff * value / s
    assert abs(normal) < 1e-4 * abs(s)


def test_a_very_viscous_drop_is_overdamped():
    with pytest.raises(BadInput, match="overdamped"):
        drop_decay(1.0, 5.0, 1.0, 2, 3)


def test_a_larger_drop_is_the_same_drop_with_less_viscosity():
    one, other = drop_decay(1.0, 0.03, 1.0, 2, 3), drop_decay(1.0, 0.06, 4.0, 2, 3)
    assert other.rate == pytest.approx(one.rate / 8.0)
    assert other.frequency == pytest.approx(one.frequency / 8.0)
