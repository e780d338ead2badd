"""The scalar laws between floaters and walls."""

import math

import mpmath
import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.laws import capillarity, flotation, meniscus

WATER = flotation.Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
L = WATER.capillary_length
PLANE = {"plane": (capillarity.plane_wall_energy, capillarity.plane_wall_force)}
PAIR = {"pair": (capillarity.pair_energy, capillarity.pair_force)}


def slope(function, x, step):
    """Sixth-order central difference."""
    weights = ((1, 45.0), (2, -9.0), (3, 1.0))
    return sum(w * (function(x + k * step) - function(x - k * step)) for k, w in weights) / (60.0 * step)


@pytest.mark.parametrize(("energy", "force"), [*PLANE.values(), *PAIR.values()], ids=["plane", "pair"])
def test_a_force_is_minus_the_slope_of_its_energy(energy, force):
    for distance in np.geomspace(0.05 * L, 8 * L, 20):
        waves_needed = force(distance, 2e-9, L)
        assert waves_needed == pytest.approx(-slope(lambda x: energy(x, 2e-9, L), distance, 1e-2 * distance), rel=1e-7)


@pytest.mark.parametrize("name", capillarity.WALLS)
def test_a_round_wall_repels_as_its_energy_grows_outward(name):
    law = capillarity.WALLS[name]
    for r in np.linspace(0.1 * L, 7.5 * L, 20):
        expected = slope(lambda x: law.energy(x, 2e-9, L, 8 * L), r, 2e-3 * L)
        assert law.force(r, 2e-9, L, 8 * L) == pytest.approx(expected, rel=1e-8, abs=1e-20)


def test_the_pair_law_is_exact_to_fourteen_digits():
    with mpmath.workdps(30):
        for ratio in np.geomspace(1e-3, 20.0, 30):
            x = mpmath.mpf(float(ratio))
            assert abs(capillarity.pair_energy(float(ratio), 1.0, 1.0) / -mpmath.besselk(0, x) - 1) < 1e-14
            assert abs(capillarity.pair_force(float(ratio), 1.0, 1.0) / -mpmath.besselk(1, x) - 1) < 1e-14


@pytest.mark.parametrize(
    ("density", "angle_of_glass", "repels"),
    [(1500.0, 45.0, True), (400.0, 45.0, False), (1500.0, 135.0, False), (400.0, 135.0, True)],
    ids=["heavy at wetting", "light at wetting", "heavy at non-wetting", "light at non-wetting"],
)
def test_heavy_floaters_leave_a_wetting_wall_and_light_ones_climb_it(density, angle_of_glass, repels):
    charge = flotation.capillary_charge(flotation.Sphere(1e-3, density, math.pi / 2), WATER)
    amplitude = meniscus.wall_amplitude(math.radians(angle_of_glass), WATER)
    strength = capillarity.wall_strength(WATER.surface_tension, charge, amplitude)
    assert (capillarity.dish_force(0.02, strength, L, 0.03) > 0) is repels
    assert (capillarity.plane_wall_force(0.01, strength, L) > 0) is repels


def test_a_wall_pulls_with_the_slope_of_its_own_surface():
    charge, radius, angle = 2e-5, 6 * L, math.radians(40.0)
    strength = capillarity.wall_strength(WATER.surface_tension, charge, meniscus.wall_amplitude(angle, WATER))
    inclination = slope(lambda r: meniscus.dish_height(r, radius, angle, WATER), 4 * L, 1e-2 * L)
    assert capillarity.dish_force(4 * L, strength, L, radius) == pytest.approx(
        2 * math.pi * WATER.surface_tension * charge * inclination, rel=1e-9
    )
    assert capillarity.dish_energy(4 * L, strength, L, radius) == pytest.approx(
        2 * math.pi * WATER.surface_tension * charge * meniscus.dish_height(4 * L, radius, angle, WATER), rel=1e-12
    )


def test_a_wide_dish_is_a_plane_wall_up_to_its_curvature():
    near_round = capillarity.dish_force(1e4 * L - 3 * L, 1e-9, L, 1e4 * L)
    assert near_round == pytest.approx(capillarity.plane_wall_force(3 * L, 1e-9, L), rel=1e-3)


def test_the_original_wall_pulls_every_floater_whatever_its_sign():
    ratios = {"floater": 1.72, "wall": 2.5}
    bond = (4.5e-3 / L) ** 2
    weight = flotation.weight_number(ratios["wall"], math.radians(45.0))
    strength = capillarity.legacy_wall_strength(WATER.surface_tension, 4.5e-3, bond, weight)
    near, nearer = (capillarity.two_point_legacy_force(0.095 - gap, strength, L, 0.095) for gap in (0.010, 0.005))
    # 2 digits, of the original's set-up with a glass wall
    assert near == pytest.approx(-4.9e-4, rel=0.02)
    assert nearer == pytest.approx(-4.8e-3, rel=0.02)
    assert capillarity.two_point_legacy_force(-0.085, strength, L, 0.095) == -near


@pytest.mark.parametrize(
    ("cutoff", "published"), [(5, 1.4e-2), (6, 5.5e-3), (8, 8.3e-4), (10, 1.2e-4), (12, 1.8e-5), (15, 1e-6), (20, 8e-9)]
)
def test_a_cutoff_neglects_the_published_share(cutoff, published):
    assert capillarity.neglected_fraction(float(cutoff)) == pytest.approx(published, rel=0.05)


def test_the_neglected_share_is_the_integral_of_r_k1():
    from scipy.integrate import quad
    from scipy.special import k1

    integral, _ = quad(lambda r: 2 / math.pi * r * k1(r), 3.0, 60.0, epsabs=0.0, epsrel=1e-13)
    assert capillarity.neglected_fraction(3.0) == pytest.approx(integral, rel=1e-12)


def test_the_truncation_radius_keeps_its_promise():
    for accuracy in (1e-2, 1e-6, 1e-10):
        cutoff = capillarity.truncation_radius(accuracy)
        assert capillarity.neglected_fraction(cutoff) <= accuracy < capillarity.neglected_fraction(cutoff - 1e-6)


@pytest.mark.parametrize("accuracy", [0.0, -1.0, 1.0, math.nan])
def test_an_impossible_accuracy_is_refused(accuracy):
    with pytest.raises(BadInput, match="accuracy"):
        capillarity.truncation_radius(accuracy)
