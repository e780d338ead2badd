"""One floating sphere, and two."""

import math
import sys

import numpy as np
import pytest

from ecume.errors import BadInput, FloaterSinks
from ecume.laws import capillarity, flotation

WATER = flotation.Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
L = WATER.capillary_length
HEAVY = flotation.Sphere(radius=1e-3, density=1500.0, contact_angle=math.pi / 2)
LIGHT = flotation.Sphere(radius=1e-3, density=300.0, contact_angle=1.0)


def sphere_of(bond, ratio, angle):
    return flotation.Sphere(radius=math.sqrt(bond) * L, density=1000.0 * ratio, contact_angle=angle)


@pytest.mark.parametrize(
    ("bond", "ratio", "degrees"), [(0.3, 1.2, 75.0), (1.0, 0.2, 60.0), (2.0, 1.3, 150.0), (1e-6, 3.0, 20.0)]
)
def test_the_weight_is_what_surface_tension_and_buoyancy_carry(bond, ratio, degrees):
    sphere = sphere_of(bond, ratio, math.radians(degrees))
    found = flotation.equilibrium(sphere, WATER)
    R, phi, psi, z = sphere.radius, found.filling_angle, found.slope_angle, found.contact_height
    tension = 2 * math.pi * WATER.surface_tension * R * math.sin(phi) * math.sin(psi)
    cap = math.pi * R**3 * (2 / 3 - math.cos(phi) + math.cos(phi) ** 3 / 3)
    buoyancy = 1000.0 * 9.81 * (cap - z * math.pi * (R * math.sin(phi)) ** 2)
    weight = 4 / 3 * math.pi * R**3 * sphere.density * 9.81
    assert weight == pytest.approx(tension + buoyancy, rel=1e-11)
    assert phi == pytest.approx(math.pi - sphere.contact_angle + psi)


@pytest.mark.parametrize("psi", [0.02, 0.8, 1.4])
def test_the_surface_around_a_sphere_carries_its_own_weight_of_displaced_liquid(psi):
    """Young–Laplace integrated over the surface: r_c sin(psi) = -int z r dr."""
    radii, amplitudes = flotation.young_laplace.refined(flotation.young_laplace.outer_meniscus(0.7, psi))
    from scipy.integrate import simpson
    from scipy.interpolate import CubicSpline
    from scipy.special import k0, k1

    logarithm = np.log(radii)
    fine = np.linspace(logarithm[0], logarithm[-1], 4001)
    r = np.exp(fine)
    z = -CubicSpline(logarithm, amplitudes)(fine) * k0(r)
    tail = amplitudes[-1] * r[-1] * k1(r[-1])
    assert -simpson(z * r * r, x=fine) + tail == pytest.approx(0.7 * math.sin(psi), rel=1e-7)


def test_twice_the_nodes_move_no_digit_that_counts(monkeypatch):
    steep = flotation.balance.load(0.5, 2.0, 1.4)
    monkeypatch.setattr(flotation.young_laplace, "NODES", 80)
    fine = flotation.balance.load(0.5, 2.0, 1.4)
    assert steep.carried == pytest.approx(fine.carried, rel=1e-9)
    assert steep.meniscus.amplitude == pytest.approx(fine.meniscus.amplitude, rel=1e-9)
    assert steep.change == pytest.approx(fine.change, rel=1e-6)


def test_the_load_changes_with_the_slope_as_its_derivative_says():
    step = 1e-4
    ahead, behind = (flotation.balance.load(0.5, 2.0, 0.9 + sign * step).carried for sign in (1, -1))
    assert flotation.balance.load(0.5, 2.0, 0.9).change == pytest.approx((ahead - behind) / (2 * step), rel=1e-6)


def test_a_heavy_sphere_presses_the_surface_down_and_a_light_one_lifts_it():
    for theory in flotation.BALANCES:
        heavy, light = (flotation.equilibrium(body, WATER, theory) for body in (HEAVY, LIGHT))
        assert heavy.floats
        assert light.floats
        assert heavy.slope_angle > 0 > heavy.contact_height
        assert light.slope_angle < 0 < light.contact_height
        assert heavy.charge > 0 > light.charge
        assert (
            flotation.surface_height(HEAVY, 3e-3, WATER, theory)
            < 0
            < flotation.surface_height(LIGHT, 3e-3, WATER, theory)
        )


@pytest.mark.parametrize("degrees", [20.0, 90.0, 160.0])
def test_the_theories_agree_for_small_spheres(degrees):
    for ratio in (0.1, 2.0):
        sphere = sphere_of(1e-5, ratio, math.radians(degrees))
        full, closed, linear = (flotation.equilibrium(sphere, WATER, theory) for theory in flotation.BALANCES)
        for other in (closed, linear):
            assert other.slope_angle == pytest.approx(full.slope_angle, rel=2e-3)
            assert other.contact_height == pytest.approx(full.contact_height, rel=2e-3)
            assert other.charge == pytest.approx(full.charge, rel=1e-4)


def test_the_closed_form_is_nearer_to_the_nonlinear_charge_than_the_linear_one():
    for bond, most in ((0.01, 1e-4), (0.1, 1e-3), (0.5, 0.011)):
        full, closed, linear = (
            charge(bond, ratio, math.radians(60.0)) for ratio in (0.2,) for charge in flotation.CHARGES.values()
        )
        assert abs(closed / full - 1) < most
        assert abs(linear / full - 1) > 5 * abs(closed / full - 1)


def test_a_neutral_sphere_leaves_the_surface_flat():
    angle = math.radians(70.0)
    found = flotation.nonlinear_balance(0.2, flotation.neutral_density_ratio(angle), angle)
    assert found.slope_angle == found.contact_height == found.charge == 0.0
    nearly = flotation.nonlinear_balance(0.2, flotation.neutral_density_ratio(angle) + 1e-12, angle)
    assert 0.0 < nearly.charge < 1e-12


@pytest.mark.parametrize("degrees", [0.0, 1e-3, 60.0, 120.0, 180.0])
def test_light_spheres_float_at_every_contact_angle_and_size(degrees):
    for bond in (1e-9, 0.1, 10.0, 1000.0):
        assert flotation.nonlinear_balance(bond, 0.3, math.radians(degrees)).slope_angle != 0.0


def test_a_sphere_just_below_the_sinking_limit_floats_and_one_just_above_sinks():
    for bond, angle in ((0.05, 1.2), (0.8, 2.5), (5.0, math.pi)):
        most = flotation.sinking_density_ratio(bond_number=bond, contact_angle=angle)
        assert flotation.nonlinear_balance(bond, most * (1 - 1e-7), angle).slope_angle > 0
        with pytest.raises(FloaterSinks, match=r"D_max = .* take a smaller or lighter"):
            flotation.nonlinear_balance(bond, most * (1 + 1e-7), angle)


def test_a_small_sphere_sinks_where_surface_tension_alone_gives_way():
    bond, angle = 1e-6, 1.1
    expected = 1.5 / bond * math.sin(angle / 2) ** 2
    assert flotation.sinking_density_ratio(bond, angle) == pytest.approx(expected, rel=1e-4)


def test_a_wetted_sphere_sinks_as_soon_as_it_is_denser_than_the_liquid():
    assert flotation.sinking_density_ratio(0.1, 0.0) == 1.0
    with pytest.raises(FloaterSinks):
        flotation.nonlinear_balance(0.1, 1.0001, 0.0)


def test_a_sphere_far_lighter_than_nothing_leaves_the_liquid():
    with pytest.raises(FloaterSinks, match="leaves the liquid"):
        flotation.nonlinear_balance(0.1, -50.0, 1.0)


def test_the_closed_form_says_when_it_does_not_reach_as_far_as_the_truth():
    bond, angle = 1.0, math.pi / 2
    most = flotation.sinking_density_ratio(bond, angle)
    with pytest.raises(FloaterSinks):
        flotation.closed_form_balance(bond, 10 * most, angle)
    with pytest.raises(BadInput, match="nonlinear"):
        flotation.closed_form_balance(3.0, 1.49, math.radians(120.0))


def test_the_sinking_limit_needs_a_size_and_an_angle():
    for bond, angle in ((-1.0, 1.0), (math.nan, 1.0), (0.1, 4.0)):
        with pytest.raises(BadInput):
            flotation.sinking_density_ratio(bond, angle)


def test_a_pair_attracts_alike_and_repels_unlike_whichever_comes_first():
    force = flotation.pair_force(HEAVY, LIGHT, 4e-3, WATER)
    assert force == flotation.pair_force(LIGHT, HEAVY, 4e-3, WATER) > 0
    assert flotation.pair_energy(HEAVY, LIGHT, 4e-3, WATER) == flotation.pair_energy(LIGHT, HEAVY, 4e-3, WATER) > 0
    for body in (HEAVY, LIGHT):
        assert flotation.pair_force(body, body, 4e-3, WATER) < 0
        assert flotation.pair_energy(body, body, 4e-3, WATER) < 0


@pytest.mark.parametrize("theory", flotation.CHARGES)
def test_the_public_pair_law_is_the_one_that_runs_compile(theory):
    charges = [flotation.capillary_charge(body, WATER, theory) for body in (HEAVY, LIGHT)]
    strength = capillarity.pair_strength(WATER.surface_tension, *charges)
    distances = np.linspace(2e-3, 2e-2, 7)
    forces = flotation.pair_force(HEAVY, LIGHT, distances, WATER, theory)
    energies = flotation.pair_energy(HEAVY, LIGHT, distances, WATER, theory)
    for distance, force, energy in zip(distances, forces, energies, strict=True):
        assert force == pytest.approx(capillarity.pair_force(distance, strength, L), rel=1e-13)
        assert energy == pytest.approx(capillarity.pair_energy(distance, strength, L), rel=1e-13)


def test_far_away_the_force_is_a_screened_exponential():
    ratio = flotation.pair_force(HEAVY, HEAVY, 31 * L, WATER) / flotation.pair_force(HEAVY, HEAVY, 30 * L, WATER)
    assert ratio == pytest.approx(math.exp(-1) * math.sqrt(30 / 31), rel=1e-3)


def test_the_surface_meets_the_contact_line_and_its_far_field():
    found = flotation.equilibrium(HEAVY, WATER)
    distances = np.array([0.0, found.contact_radius, 8 * L, 40 * L])
    heights = flotation.surface_height(HEAVY, distances, WATER, "nonlinear")
    assert heights[0] == pytest.approx(found.contact_height, rel=1e-9)
    assert heights[1] == pytest.approx(found.contact_height, rel=1e-9)
    from scipy.special import k0

    assert heights[2] == pytest.approx(-found.charge * k0(8.0), rel=1e-6)
    assert heights[3] == pytest.approx(-found.charge * k0(40.0), rel=1e-6)
    closed = flotation.surface_height(HEAVY, distances, WATER)
    assert closed == pytest.approx(heights, rel=0.03)


def test_the_surface_leaves_a_sphere_with_its_slope():
    sphere = sphere_of(1.0, 2.0, math.radians(120.0))
    found = flotation.equilibrium(sphere, WATER)
    step = 1e-4 * L
    edge = found.contact_radius + np.array([0.0, step, 2 * step])
    h = flotation.surface_height(sphere, edge, WATER, "nonlinear")
    slope = (-3 * h[0] + 4 * h[1] - h[2]) / (2 * step)
    assert slope == pytest.approx(math.tan(found.slope_angle), rel=1e-4)


def test_an_overhanging_meniscus_is_shown_from_its_neck():
    sphere = sphere_of(0.05, 0.9 * flotation.sinking_density_ratio(0.05, math.pi), math.pi)
    steep = sphere_of(3.0, 0.9999 * flotation.sinking_density_ratio(3.0, math.pi), math.pi)
    for body in (sphere, steep):
        heights = flotation.surface_height(body, np.linspace(0.0, 6 * L, 50), WATER, "nonlinear")
        assert bool(np.all(np.diff(heights) >= 0.0))


def test_a_neutral_sphere_has_a_flat_surface_around_it():
    neutral = flotation.Sphere(1e-3, 500.0, math.pi / 2)
    heights = flotation.surface_height(neutral, np.array([0.0, 2e-3]), WATER, "nonlinear")
    assert bool(np.all(np.abs(heights) < 1e-15))


def test_the_gas_counts_on_both_sides():
    dense_gas = flotation.Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3, gas_density=100.0)
    assert flotation.density_ratio(HEAVY, dense_gas) == pytest.approx(1400.0 / 900.0)
    assert dense_gas.capillary_length == pytest.approx(math.sqrt(0.072 / (900.0 * 9.81)))
    bubble = flotation.Sphere(1e-4, 100.0, 0.0)
    assert flotation.dimensionless_weight(bubble, dense_gas) == pytest.approx(-2 / 3)


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"density": 0.0}, "density"),
        ({"density": math.nan}, "density"),
        ({"surface_tension": -1.0}, "surface_tension"),
        ({"viscosity": -1e-3}, "viscosity"),
        ({"gravity": 0.0}, "gravity"),
        ({"gas_density": 2000.0}, "gas_density"),
        ({"gas_density": math.inf}, "gas_density"),
    ],
)
def test_an_impossible_liquid_is_refused_by_name(change, what):
    with pytest.raises(BadInput, match=what):
        flotation.Liquid(**{"density": 1000.0, "surface_tension": 0.072, "viscosity": 1e-3, **change})


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"radius": 0.0}, "radius"),
        ({"radius": math.inf}, "radius"),
        ({"density": -1.0}, "bubble"),
        ({"contact_angle": -0.1}, "contact_angle"),
        ({"contact_angle": math.nan}, "contact_angle"),
        ({"contact_angle": 70.0}, "did you mean 70 degrees, 1.222 rad"),
    ],
)
def test_an_impossible_sphere_is_refused_by_name(change, what):
    with pytest.raises(BadInput, match=what):
        flotation.Sphere(**{"radius": 1e-3, "density": 1000.0, "contact_angle": 1.0, **change})


def test_a_sphere_of_many_capillary_lengths_is_refused():
    with pytest.raises(BadInput, match="capillary lengths"):
        flotation.equilibrium(flotation.Sphere(0.2, 1000.0, 1.0), WATER)
    with pytest.raises(BadInput, match="density ratio"):
        flotation.nonlinear_balance(0.1, math.nan, 1.0)


@pytest.mark.parametrize("distance", [0.0, -1e-3, math.nan, np.array([1e-3, 0.0])])
def test_two_centers_in_one_place_have_no_force(distance):
    with pytest.raises(BadInput, match="distance"):
        flotation.pair_force(HEAVY, HEAVY, distance, WATER)


def test_an_unknown_theory_is_answered_with_those_there_are():
    with pytest.raises(BadInput, match="nonlinear, closed-form, linear"):
        flotation.equilibrium(HEAVY, WATER, "magic")


def test_the_linear_theory_has_no_slope_at_the_ends():
    with pytest.raises(BadInput, match="nonlinear"):
        flotation.equilibrium(flotation.Sphere(1e-3, 500.0, math.pi), WATER, "linear")


def test_young_gives_the_angle_or_says_that_there_is_none():
    angle = flotation.young_contact_angle(solid_gas=0.02, solid_liquid=0.056, liquid_gas=0.072)
    assert math.degrees(angle) == pytest.approx(120.0)
    with pytest.raises(BadInput, match="spreads"):
        flotation.young_contact_angle(solid_gas=0.2, solid_liquid=0.05, liquid_gas=0.072)
    with pytest.raises(BadInput, match="draws back"):
        flotation.young_contact_angle(solid_gas=0.0, solid_liquid=0.1, liquid_gas=0.072)
    with pytest.raises(BadInput, match="liquid_gas"):
        flotation.young_contact_angle(solid_gas=0.0, solid_liquid=0.1, liquid_gas=0.0)


@pytest.mark.parametrize(
    ("bond", "ratio", "degrees"),
    [
        (0.1, 0.2, 175.8142),
        (0.3, 0.5, 163.8392),
        (0.3, 1.05, 175.9045),
        (0.6, 0.5, 117.2475),
        (0.6, 1.05, 132.0545),
        (0.6, 2.5, 156.1636),
    ],
)
def test_the_original_closure_gives_its_published_angles(bond, ratio, degrees):
    assert math.degrees(flotation.closure_contact_angle(bond, ratio)) == pytest.approx(degrees, abs=1e-4)


@pytest.mark.parametrize(("bond", "ratio"), [(0.1, 1.0), (0.7, 0.5), (0.2, 1.0)])
def test_the_original_closure_has_no_angle_for_most_floaters(bond, ratio):
    with pytest.raises(BadInput, match="closure"):
        flotation.closure_contact_angle(bond, ratio)


def test_a_law_is_imported_without_compiler_or_solver():
    import subprocess

    code = "import sys; from ecume.laws import flotation, meniscus, drag, capillarity, friction; "
    code += "assert not {'numba', 'scipy', 'pint', 'pydantic'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(("bond", "ratio", "angle"), [(1e-20, 1.2, 1.5), (1e-3, 0.5, 1e-13), (1e-3, 0.9, 1e-13)])
def test_extreme_numbers_give_finite_balances(bond, ratio, angle):
    found = flotation.nonlinear_balance(bond, ratio, angle)
    assert all(math.isfinite(number) for number in found)


def test_a_sphere_smaller_than_an_atom_is_refused():
    with pytest.raises(BadInput, match="atom"):
        flotation.nonlinear_balance(1e-30, 1.2, 1.5)


@pytest.mark.parametrize(
    ("degrees", "excesses", "within"),
    [
        (60.0, (0.0382, 0.0360, 0.0228, 0.0123, 0.0055, 0.0016, 0.0003), 4e-4),
        (120.0, (0.0382, 0.0360, 0.0228, 0.0123, 0.0055, 0.0016, 0.0003), 4e-4),
        (30.0, (0.0030, 0.0029, 0.0021, 0.0012, 0.0006, 0.0002, 0.0000), 2e-4),
        (90.0, (0.152, 0.1172, 0.0543, 0.0264, 0.0113, 0.0034, 0.0007), 6e-3),
    ],
)
def test_close_spheres_attract_as_much_harder_as_the_multipoles_of_small_ones_do(degrees, excesses, within):
    """Independent numbers for B = 0.001 (60 and 120 degrees) and 0.01, whose size adds a little."""
    for gap, excess in zip((0.0, 0.01, 0.1, 0.25, 0.5, 1.0, 2.0), excesses, strict=True):
        assert flotation.superposition_excess(math.radians(degrees), gap) == pytest.approx(excess, abs=within)


def test_superposition_is_right_far_away_and_for_dots():
    assert flotation.superposition_excess(math.pi / 2, 30.0) == pytest.approx(0.0, abs=1e-6)
    assert flotation.superposition_excess(0.0, 0.0) == 0.0
    reach = flotation.superposition_reach(math.pi / 2, 0.05)
    assert flotation.superposition_excess(math.pi / 2, reach) == pytest.approx(0.05, rel=1e-6)
    with pytest.raises(BadInput, match="gap"):
        flotation.superposition_excess(1.0, -0.1)
