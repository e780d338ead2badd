"""Laws between particles of a liquid: viscosity, diffusion of density, surface tension, and the time steps."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from tests.oracles import liquids

from ecume.laws import density_diffusion, hydrostatics, incompressible, tension, time_step_limits, viscous
from ecume.laws.kernels import kernel


def lattice(dim, spacing, reach):
    """Neighbors of a particle at the origin, on a lattice."""
    line = np.arange(-math.ceil(reach / spacing), math.ceil(reach / spacing) + 1) * spacing
    points = np.stack(np.meshgrid(*[line] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
    return points[np.any(points != 0.0, axis=1)]


def test_artificial_viscosity_repels_what_approaches_and_leaves_what_parts():
    approaching = viscous.approach_speed(-0.3, 0.04, 0.2)
    assert viscous.artificial_viscosity(approaching, 1000.0, 20.0, 0.02) > 0.0
    assert viscous.artificial_viscosity(approaching, 1000.0, 20.0, 0.0, 1.0) > 0.0
    assert viscous.artificial_viscosity(viscous.approach_speed(0.3, 0.04, 0.2), 1000.0, 20.0, 0.02) == 0.0


@pytest.mark.parametrize("name", viscous.LAMINAR)
@pytest.mark.parametrize("dim", [2, 3])
def test_friction_makes_the_laplacian_of_the_velocity(name, dim):
    one, spacing, h, viscosity = kernel("wendland-c4", dim), 0.05, 0.2, 0.7
    x_j = lattice(dim, spacing, 2.0 * h)
    distance = np.linalg.norm(x_j, axis=1)
    slope = np.asarray(one.slope(distance, h)) / distance
    speed_j = 1.5 * x_j[:, 0] + 2.0 * x_j[:, 1] ** 2  # its Laplacian is 4
    friction = viscous.LAMINAR[name](viscosity, viscosity, spacing**dim, spacing**dim)
    force = np.sum(friction * slope * (0.0 - speed_j))
    assert force / spacing**dim == pytest.approx(4.0 * viscosity, rel=0.01)


@pytest.mark.parametrize("dim", [2, 3])
def test_friction_along_the_line_of_two_makes_the_laplacian_of_a_shear(dim):
    one, spacing, h, viscosity = kernel("wendland-c4", dim), 0.05, 0.2, 0.7
    x_j = lattice(dim, spacing, 2.0 * h)
    distance = np.linalg.norm(x_j, axis=1)
    slope = np.asarray(one.slope(distance, h)) / distance
    speed_j = 2.0 * x_j[:, 1] ** 2  # along the first axis; its Laplacian is 4
    friction = viscous.radial_friction(viscosity, viscosity, spacing**dim, spacing**dim, dim)
    force = np.sum(friction * slope * (0.0 - speed_j) * x_j[:, 0] ** 2 / distance**2)
    assert force / spacing**dim == pytest.approx(4.0 * viscosity, rel=0.02)


@pytest.mark.parametrize("dim", [2, 3])
def test_artificial_viscosity_amounts_to_the_viscosity_it_is_said_to(dim):
    one, spacing, h, alpha, c0 = kernel("wendland-c4", dim), 0.05, 0.2, 0.3, 20.0
    x_j = lattice(dim, spacing, 2.0 * h)
    distance = np.linalg.norm(x_j, axis=1)
    speed_j = x_j[:, 1] ** 2  # along the first axis
    # On all pairs: those that part are turned round, for which the law is odd.
    approach = speed_j * x_j[:, 0]
    mu = [
        -math.copysign(viscous.approach_speed(-abs(a), r * r, h), -a) for a, r in zip(approach, distance, strict=True)
    ]
    pi = np.array([viscous.artificial_viscosity(m, 1.0, c0, alpha) for m in mu])
    acceleration = -np.sum(spacing**dim * pi * np.asarray(one.slope(distance, h)) / distance * -x_j[:, 0])
    expected = 2.0 * viscous.viscosity_of_alpha(alpha, h, c0, dim)
    # The softening, 0.01 h^2 beside r^2, takes two percent.
    assert acceleration == pytest.approx(expected, rel=0.03)


def test_between_two_liquids_the_thinner_one_rules_the_friction():
    thin = viscous.adami_friction(1e-3, 1e3, 1.0, 1.0)
    assert thin == pytest.approx(4e-3, rel=1e-5)
    assert viscous.adami_friction(0.0, 0.0, 1.0, 1.0) == viscous.adami_friction(0.0, 1.0, 1.0, 1.0) == 0.0


def test_eddies_grow_with_the_square_of_what_they_span():
    assert viscous.eddy_viscosity(6.0, 0.2) == pytest.approx(4.0 * viscous.eddy_viscosity(6.0, 0.1))
    assert viscous.eddy_viscosity(6.0, 0.1) == pytest.approx((0.12 * 0.1) ** 2 * 6.0)
    assert liquids.inertial_range_coefficient(1.5) == pytest.approx(0.1733, abs=5e-5)


def test_eddies_drain_a_shear_and_press_on_all_sides():
    assert (
        viscous.subparticle_stress(3.0, 0.0, 6.0, 0.1, 0.0) > 0.0 > viscous.subparticle_stress(0.0, 0.0, 6.0, 0.1, 1.0)
    )
    trace = sum(viscous.subparticle_stress(rate, 0.6, 6.0, 0.1, 1.0) for rate in (0.1, 0.2, 0.3))
    assert trace == pytest.approx(-2.0 * viscous.YOSHIZAWA * 0.01 * 36.0)


DEPTHS = np.array([0.2, 0.213, 0.19, 0.25, 0.16])
C0, G, RHO = 10.0, 9.81, 1000.0


@pytest.mark.parametrize("exponent", [1.0, 1.4, 7.0])
def test_in_a_column_at_rest_the_exact_excess_is_nothing(exponent):
    density = [hydrostatics.hydrostatic_density(depth, G, RHO, C0, exponent) for depth in DEPTHS]
    local = liquids.tait_sound_speed(density[0], RHO, C0, exponent)
    for depth, other in zip(DEPTHS, density, strict=True):
        excess = density_diffusion.fourtakas_excess(density[0], other, G * (depth - DEPTHS[0]), local, exponent)
        assert abs(excess) < 1e-8
        assert depth == DEPTHS[0] or abs(density_diffusion.molteni_excess(density[0], other)) > 0.5


def test_the_linear_excess_is_exact_for_a_linear_profile_only():
    step = density_diffusion.fourtakas_linear_excess(1000.0, 1000.0 + 1000.0 * G * 0.05 / C0**2, G * 0.05, RHO, C0)
    assert step == pytest.approx(0.0, abs=1e-9)
    density = [hydrostatics.hydrostatic_density(depth, G, RHO, C0) for depth in (0.9, 0.95)]
    assert density_diffusion.fourtakas_linear_excess(*density, G * 0.05, RHO, C0) < -1.0


def test_antuonos_excess_is_nothing_on_a_linear_density():
    assert density_diffusion.antuono_excess(1000.0, 1000.7, 0.7, 0.7) == pytest.approx(0.0, abs=1e-12)
    assert density_diffusion.antuono_excess(1000.0, 1001.0, 0.7, 0.7) > 0.0


@pytest.mark.parametrize(("head", "tolerance"), [(0.1 / 6, 1e-7), (-0.1 / 6, 1e-7), (0.01 / 6, 3e-14)])
@pytest.mark.parametrize("exponent", [1.0, 3.0, 7.0])
def test_the_series_is_as_exact_as_it_says(head, tolerance, exponent):
    a = exponent - 1.0
    exact = math.expm1(head) if a == 0.0 else math.expm1(math.log1p(a * head) / a)
    assert density_diffusion.hydrostatic_gain(head, exponent) == pytest.approx(exact, rel=tolerance)


def test_density_flows_from_dense_to_thin():
    assert density_diffusion.strength(0.1, 0.1, 10.0) > 0.0
    assert density_diffusion.flow(2.0, -3.0) > 0.0 > density_diffusion.flow(-2.0, -3.0)


def test_cohesion_attracts_far_neighbors_and_keeps_off_near_ones():
    q = np.linspace(1e-3, 1.2, 240)
    found = np.array([tension.cohesion_kernel(r * 0.3, 0.3) for r in q])
    assert np.all(found[q > 1.0] == 0.0)
    assert np.all(found[(q > 0.5) & (q < 1.0)] > 0.0)
    assert found[0] == pytest.approx(-32.0 / (math.pi * 0.3**3) / 64.0, rel=1e-3)
    assert tension.cohesion_kernel(0.52, 1.0) == pytest.approx(32.0 / math.pi * (0.48 * 0.52) ** 3)
    assert tension.cohesion_kernel(0.48, 1.0) == pytest.approx(32.0 / math.pi * (2.0 * (0.48 * 0.52) ** 3 - 1.0 / 64.0))
    middle = [tension.cohesion_kernel(0.15 * factor, 0.3) for factor in (1 - 1e-9, 1 + 1e-9)]
    assert middle[0] == pytest.approx(middle[1], rel=1e-6)


def test_every_contour_of_a_color_counts_and_all_of_them_count_one():
    assert quad(tension.surface_weight, 0.0, 1.0)[0] == pytest.approx(1.0)
    assert tension.surface_weight(-0.1) == tension.surface_weight(1.1) == tension.surface_weight_slope(1.1) == 0.0
    for color in (0.1, 0.35, 0.9):
        assert quad(tension.surface_weight, 0.0, color)[0] == pytest.approx(liquids.surface_share(color))
        slope = (tension.surface_weight(color + 1e-6) - tension.surface_weight(color - 1e-6)) / 2e-6
        assert slope == pytest.approx(tension.surface_weight_slope(color), rel=1e-6)
        assert tension.wetted_share(color) == pytest.approx(liquids.surface_share(color), rel=1e-14)
    for angle in (0.0, 0.3, 0.5 * math.pi, 2.0, math.pi):
        color = tension.solid_color(math.cos(angle))
        assert liquids.surface_share(color) == pytest.approx(0.5 * (1.0 + math.cos(angle)), rel=1e-14, abs=1e-16)


def test_the_layer_of_a_curved_surface_is_pressed_wherever_particles_are():
    # A flat surface's own particles see colors above one half.
    for color in np.linspace(0.55, 1.0, 10):
        assert liquids.surface_share(color) - color * tension.surface_weight(color) > 0.0


def test_steepness_has_no_step_where_directions_become_noise():
    assert tension.steepness(2.0, 0.3) == 2.0
    assert tension.steepness(0.3 - 1e-12, 0.3) == pytest.approx(tension.steepness(0.3 + 1e-12, 0.3))
    for gradient in (0.1, 0.3, 0.7):
        slope = (tension.steepness(gradient + 1e-7, 0.3) - tension.steepness(gradient - 1e-7, 0.3)) / 2e-7
        assert slope == pytest.approx(gradient / max(gradient, 0.3), rel=1e-5)


def test_a_drop_s_pressure_is_laplace_s():
    assert tension.laplace_pressure(0.07, 0.1, 2) == pytest.approx(0.7)
    assert tension.laplace_pressure(0.07, 0.1, 3) == pytest.approx(1.4)


def test_time_steps_shrink_with_what_limits_them():
    assert time_step_limits.acoustic_limit(0.1, 20.0, 5.0) == pytest.approx(0.001)
    assert time_step_limits.viscous_limit(0.1, 2e-3) == pytest.approx(0.625)
    assert time_step_limits.force_limit(0.09, 9.0) == pytest.approx(0.025)
    assert time_step_limits.tension_limit(0.1, 1000.0, 0.05) == pytest.approx(math.sqrt(1.0 / (0.1 * math.pi)))


@pytest.mark.parametrize("dim", [2, 3])
def test_the_excess_of_straight_motion_is_the_change_of_volume_beyond_first_order(dim):
    """Exact in 2D; in 3D the remainder is of third order, the determinant."""
    generator = np.random.default_rng(dim)
    for step in 10.0 ** generator.uniform(-3.0, 0.0, 20):
        gradient = generator.normal(size=(dim, dim))
        divergence, squared = np.trace(gradient), np.trace(gradient @ gradient)
        volume = np.linalg.det(np.eye(dim) + step * gradient)
        third = step**3 * np.linalg.det(gradient) * (dim == 3)
        found = incompressible.straight_motion_excess(divergence, squared, step)
        assert found == pytest.approx(1.0 + step * divergence + third - volume, abs=1e-13)


def test_shifting_grows_with_the_speed_and_close_neighbors_pull_more():
    assert incompressible.shifting_coefficient(0.02, 3.0) == pytest.approx(
        3.0 * incompressible.shifting_coefficient(0.02, 1.0)
    )
    ratios = np.linspace(0.0, 3.0, 7)
    weights = incompressible.tensile_weight(ratios)
    assert np.all(np.diff(weights) > 0.0)
    assert weights[0] == 1.0
