"""Discs, cylinders, ellipsoids and bubbles in the surface."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from ecume.errors import BadInput, FloaterSinks
from ecume.laws import flotation
from ecume.laws.flotation import balance, nonspherical

WATER = flotation.Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3, gas_density=1.2)
L = WATER.capillary_length
EXCESS = WATER.density_difference * WATER.gravity  # N/m^3
THEORIES = tuple(flotation.BALANCES)
SPHERE = flotation.Sphere(0.8e-3, 1400.0, 1.2)
BODIES = (
    flotation.Disc(1.3e-3, 2e-5),
    flotation.Bubble(0.7e-3),
    flotation.VerticalCylinder(1e-3, 2e-3, 900.0, 1.9),
    flotation.HorizontalCylinder(0.5e-3, 1300.0, 1.4),
    flotation.Ellipsoid((2e-3, 1e-3, 0.7e-3), 1300.0, 1.4),
)
each_body = pytest.mark.parametrize("body", BODIES, ids=lambda body: type(body).__name__)


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("density", [300.0, 1400.0])
def test_an_ellipsoid_of_equal_axes_is_a_sphere(theory, density):
    sphere = flotation.equilibrium(flotation.Sphere(1e-3, density, 1.2), WATER, theory)
    ball = flotation.equilibrium(flotation.Ellipsoid((1e-3, 1e-3, 1e-3), density, 1.2), WATER, theory)
    assert ball.charge == pytest.approx(sphere.charge, rel=1e-10)
    # The sphere's closed form asks its angles of sin(phi) sin(psi), not of the slope.
    within = 0.05 if theory == "closed-form" else 1e-9
    for name in ("slope_angle", "filling_angle", "center_height"):
        assert getattr(ball, name) == pytest.approx(getattr(sphere, name), rel=within)


@pytest.mark.parametrize(
    ("upright", "density", "angle"), [(0.5e-3, 1800.0, 1.2), (3e-3, 1010.0, 2.0), (2e-3, 300.0, 0.6)]
)
def test_an_ellipsoid_is_carried_by_tension_and_by_what_it_and_its_dip_displace(upright, density, angle):
    a = 1.5e-3
    found = flotation.equilibrium(flotation.Ellipsoid((a, a, upright), density, angle), WATER)
    line, center, r = found.contact_height, found.center_height, found.contact_radius
    assert ((line - center) / upright) ** 2 + (r / a) ** 2 == pytest.approx(1.0)
    below, _ = quad(lambda z: math.pi * a**2 * (1 - ((z - center) / upright) ** 2), center - upright, line)
    tension = 2 * math.pi * WATER.surface_tension * r * math.sin(found.slope_angle)
    weight = 4 / 3 * math.pi * a**2 * upright * (density - WATER.gas_density) * WATER.gravity
    assert tension + EXCESS * (below - math.pi * r**2 * line) == pytest.approx(weight, rel=1e-10)
    # Young: the body's own slope there, less the surface's, is the contact angle.
    steepness = math.atan2(upright**2 * r, a**2 * (center - line))
    assert steepness - found.slope_angle == pytest.approx(math.pi - angle, rel=1e-9)


def test_the_mean_contact_line_of_an_ellipsoid_does_not_ask_which_way_it_points():
    along, across = (flotation.Ellipsoid(axes, 1300.0, 1.4) for axes in ((2e-3, 1e-3, 1e-3), (1e-3, 2e-3, 1e-3)))
    assert flotation.equilibrium(along, WATER) == flotation.equilibrium(across, WATER)


@pytest.mark.parametrize("load", [-4e-4, 1e-6, 2e-4, 9e-4])
def test_a_disc_is_carried_by_its_rim_and_its_dip(load):
    found = flotation.equilibrium(flotation.Disc(2e-3, load), WATER)
    tension = 2 * math.pi * WATER.surface_tension * 2e-3 * math.sin(found.slope_angle)
    assert tension - EXCESS * math.pi * 4e-6 * found.contact_height == pytest.approx(load, rel=1e-10)
    other = flotation.equilibrium(flotation.Disc(2e-3, -load), WATER)
    assert other.charge == pytest.approx(-found.charge, rel=1e-10)
    assert other.contact_height == pytest.approx(-found.contact_height, rel=1e-10)


def test_a_disc_without_a_load_leaves_the_surface_flat():
    for theory in THEORIES:
        found = flotation.equilibrium(flotation.Disc(1e-3, 0.0), WATER, theory)
        assert found.slope_angle == found.charge == found.contact_height == 0.0


def test_the_linear_charge_of_a_disc_is_not_its_weight_over_two_pi():
    """Its heave carries a share: (a^2 K0 + 2 a K1)/2 is 0.81 at a = L."""
    found = flotation.equilibrium(flotation.Disc(L, 1e-6), WATER, "linear")
    weight_over = 1e-6 / (2 * math.pi * WATER.surface_tension)
    assert weight_over / found.charge == pytest.approx(0.8124, abs=1e-4)


@pytest.mark.parametrize("angle", [0.3, 1.4, 2.5])
def test_a_standing_cylinder_is_carried_wherever_its_line_runs(angle):
    radius, height = 1e-3, 2e-2
    seen = set()
    for density in (20.0, 300.0, 700.0, 1050.0, 1150.0):
        found = flotation.equilibrium(flotation.VerticalCylinder(radius, height, density, angle), WATER)
        top, bottom = found.center_height + 0.5 * height, found.center_height - 0.5 * height
        tension = 2 * math.pi * WATER.surface_tension * radius * math.sin(found.slope_angle)
        weight = math.pi * radius**2 * height * (density - WATER.gas_density) * WATER.gravity
        assert tension - EXCESS * math.pi * radius**2 * bottom == pytest.approx(weight, rel=1e-9)
        assert bottom - 1e-15 <= found.contact_height <= top + 1e-15
        if found.contact_height == pytest.approx(top, abs=1e-12):
            seen.add("top")
            assert angle - math.pi / 2 <= found.slope_angle <= angle
        elif found.contact_height == pytest.approx(bottom, abs=1e-12):
            seen.add("bottom")
            assert angle - math.pi <= found.slope_angle <= angle - math.pi / 2
        else:
            seen.add("side")
            assert found.slope_angle == pytest.approx(angle - math.pi / 2)
    assert "side" in seen
    assert "top" in seen or "bottom" in seen


def test_a_cylinder_pinned_at_its_upper_rim_is_the_disc_that_hangs_there():
    coin = flotation.VerticalCylinder(2e-3, 0.5e-3, 2700.0, 1.5)
    disc = flotation.disc_of_cylinder(coin, WATER)
    assert flotation.equilibrium(coin, WATER).charge == pytest.approx(flotation.equilibrium(disc, WATER).charge)
    light = flotation.VerticalCylinder(2e-3, 0.5e-3, 100.0, 2.8)
    raised = flotation.disc_of_cylinder(light, WATER, "bottom")
    assert flotation.equilibrium(light, WATER).charge == pytest.approx(flotation.equilibrium(raised, WATER).charge)
    assert disc.stability < 0 < raised.stability
    with pytest.raises(BadInput, match="top or bottom"):
        flotation.disc_of_cylinder(coin, WATER, "side")


def test_a_thin_standing_cylinder_draws_a_meniscus_of_the_slope_it_is_given():
    found = flotation.equilibrium(flotation.VerticalCylinder(0.05 * L, 9 * L, 500.0, 1.5), WATER)
    linear = flotation.equilibrium(flotation.VerticalCylinder(0.05 * L, 9 * L, 500.0, 1.5), WATER, "linear")
    from scipy.special import k1

    assert linear.charge == pytest.approx(L * (1.5 - math.pi / 2) / k1(0.05))
    assert found.charge == pytest.approx(linear.charge, rel=2e-3)
    assert found.charge < 0 < found.contact_height  # wetted: the liquid climbs


def test_a_lying_cylinder_is_carried_by_two_lines_and_what_it_displaces():
    R, density, angle = 1.1e-3, 1500.0, 1.9
    found = flotation.equilibrium(flotation.HorizontalCylinder(R, density, angle), WATER)
    phi, z = found.filling_angle, found.contact_height
    assert phi == pytest.approx(math.pi - angle + found.slope_angle)
    assert z == pytest.approx(-2 * L * math.sin(found.slope_angle / 2))
    area, _ = quad(lambda t: 2 * (R * math.sin(t)) ** 2, 0.0, phi)
    lift = 2 * WATER.surface_tension * math.sin(found.slope_angle) + EXCESS * (area - 2 * R * math.sin(phi) * z)
    assert lift == pytest.approx(math.pi * R**2 * (density - WATER.gas_density) * WATER.gravity, rel=1e-10)


@pytest.mark.parametrize("psi", [-0.4, 0.9, 2.2])
def test_the_far_surface_of_a_straight_line_is_its_exponential(psi):
    """Integrated along the arc from the contact line, also beyond vertical slopes."""
    z = flotation.young_laplace.sloping_height(psi)

    def growth(_, at):
        return math.cos(at[2]), math.sin(at[2]), at[1]

    arc = solve_ivp(growth, (0.0, 9.0), (0.0, z, psi), "DOP853", rtol=1e-13, atol=1e-15)
    x, height, slope = arc.y[:, -1]
    grown = 0.5 * (height - math.tan(slope)) * math.exp(x)  # what decays, without the error's part that grows
    assert grown == pytest.approx(flotation.young_laplace.sloping_amplitude(psi), rel=1e-5)


def test_a_thin_lying_cylinder_has_the_slope_of_its_weight():
    B = 1e-8
    found = flotation.equilibrium(flotation.HorizontalCylinder(math.sqrt(B) * L, 1501.2, math.pi / 2), WATER)
    ratio = 1500.0 / WATER.density_difference
    assert math.sin(found.slope_angle) == pytest.approx(0.5 * math.pi * B * (ratio - 0.5), rel=2e-4)
    assert found.charge == pytest.approx(found.slope_angle * L, rel=2e-4)


@each_body
def test_the_theories_of_a_body_agree_where_it_is_small_and_gentle(body):
    small = shrunk(body, 0.02)
    full, closed, linear = (flotation.equilibrium(small, WATER, theory) for theory in THEORIES)
    for other, within in ((closed, 1e-3), (linear, 1e-2)):
        assert other.charge == pytest.approx(full.charge, rel=within)
        assert other.slope_angle == pytest.approx(full.slope_angle, rel=2 * within)


def shrunk(body, share):
    """The body with its lengths times a factor, and its load as a volume."""
    from dataclasses import replace

    if isinstance(body, flotation.Disc):
        return replace(body, radius=share * body.radius, load=share**3 * body.load)
    if isinstance(body, flotation.VerticalCylinder):
        return replace(body, radius=share * body.radius, height=share * body.height, contact_angle=math.pi / 2 + 0.01)
    if isinstance(body, flotation.Ellipsoid):
        return replace(body, semi_axes=tuple(share * axis for axis in body.semi_axes))
    return replace(body, radius=share * body.radius)


@pytest.mark.parametrize(
    ("floats", "sinks"),
    [
        (lambda most: flotation.Disc(2e-3, most), lambda: nonspherical.greatest_rim_load(2e-3, WATER)),
        (lambda most: flotation.Disc(2e-2, most), lambda: nonspherical.greatest_rim_load(2e-2, WATER)),
    ],
)
def test_a_disc_sinks_above_its_greatest_load(floats, sinks):
    most = sinks()
    assert flotation.equilibrium(floats(most * (1 - 1e-6)), WATER).floats
    with pytest.raises(FloaterSinks, match="a lighter or a wider one"):
        flotation.equilibrium(floats(most * (1 + 1e-6)), WATER)


@pytest.mark.parametrize("radius", [0.3e-3, 2e-3])
def test_a_lying_cylinder_sinks_above_the_greatest_load_of_all_slopes(radius):
    angle = 1.3
    slopes = np.linspace(1e-3, angle, 20001)
    loads = [flotation.nonspherical.lying_load(radius / L, angle, float(psi)).carried for psi in slopes]
    most = max(loads) * WATER.density_difference + WATER.gas_density
    assert flotation.equilibrium(flotation.HorizontalCylinder(radius, most * (1 - 1e-6), angle), WATER).floats
    with pytest.raises(FloaterSinks, match="D_max"):
        flotation.equilibrium(flotation.HorizontalCylinder(radius, most * (1 + 1e-6), angle), WATER)


def test_a_standing_cylinder_sinks_when_its_upper_rim_gives_way():
    angle, radius, height = 1.1, 1e-3, 1e-3
    most = (
        nonspherical.greatest_rim_load(radius, WATER, angle) / (math.pi * radius**2 * height * WATER.gravity)
        + WATER.density
    )
    assert flotation.equilibrium(flotation.VerticalCylinder(radius, height, most * (1 - 1e-6), angle), WATER).floats
    with pytest.raises(FloaterSinks, match="upper rim carries"):
        flotation.equilibrium(flotation.VerticalCylinder(radius, height, most * (1 + 1e-6), angle), WATER)


@pytest.mark.parametrize(
    ("theory", "body", "why"),
    [
        ("linear", flotation.Sphere(3e-3, 8000.0, 1.0), "top of this Sphere: it sinks"),
        ("linear", flotation.HorizontalCylinder(3e-3, 8000.0, 1.2), "top of this HorizontalCylinder"),
        ("closed-form", flotation.HorizontalCylinder(3e-3, 8000.0, 1.2), "top of this HorizontalCylinder"),
        ("closed-form", flotation.Ellipsoid((3e-3, 2e-3, 3e-3), 8000.0, 1.2), "top of this Ellipsoid"),
    ],
)
def test_no_theory_puts_a_contact_line_where_there_is_no_body(theory, body, why):
    with pytest.raises(FloaterSinks, match=why):
        flotation.equilibrium(body, WATER, theory)
    below_oil = flotation.Liquid(1000.0, 0.03, 1e-3, gas_density=800.0)
    with pytest.raises(FloaterSinks, match="bottom of this Sphere: it leaves the liquid"):
        flotation.equilibrium(flotation.Sphere(6e-3, 100.0, 2.9), below_oil, "linear")


def test_an_ellipsoid_sinks_where_a_sphere_of_its_axes_does():
    most = flotation.sinking_density_ratio((1e-3 / L) ** 2, 1.3) * WATER.density_difference + WATER.gas_density
    assert flotation.equilibrium(flotation.Ellipsoid((1e-3,) * 3, most * (1 - 1e-6), 1.3), WATER).floats
    with pytest.raises(FloaterSinks, match="D_max"):
        flotation.equilibrium(flotation.Ellipsoid((1e-3,) * 3, most * (1 + 1e-6), 1.3), WATER)


@pytest.mark.parametrize("radius", [0.02, 0.4, 1.5])
def test_a_bubble_is_lifted_by_what_it_displaces_and_held_by_the_rim_of_its_film(radius):
    shape = nonspherical._shape(*nonspherical._found(radius))
    assert shape.volume == pytest.approx(4 / 3 * math.pi * radius**3, rel=1e-8)
    lift = shape.lifted - shape.rim_height * math.pi * shape.rim_radius**2
    assert lift == pytest.approx(2 * math.pi * shape.rim_radius * math.sin(shape.rim_angle), rel=1e-6)


def test_a_small_bubble_has_the_charge_of_its_lift_and_its_film_grows_as_its_radius_squared():
    for radius in (1e-3 * L, 0.03 * L):
        found = flotation.equilibrium(flotation.Bubble(radius), WATER)
        assert found.charge == pytest.approx(-2 / 3 * radius**3 / L**2, rel=1e-5)
        assert found.contact_radius == pytest.approx(2 / math.sqrt(3) * radius**2 / L, rel=1e-2)
        assert found.slope_angle < 0 < found.contact_height
        assert -radius < found.center_height < 0


def test_a_bubble_is_the_limit_of_a_wetted_sphere_without_weight():
    """To leading order only: a sphere keeps its shape."""
    bubble = flotation.equilibrium(flotation.Bubble(0.02 * L), WATER)
    sphere = flotation.nonlinear_charge(4e-4, 0.0, 0.0) * 0.02 * L
    assert bubble.charge == pytest.approx(sphere, rel=1e-3)


def test_a_bubble_that_is_a_dome_is_refused():
    with pytest.raises(BadInput, match="2 at most"):
        flotation.equilibrium(flotation.Bubble(2.1 * L), WATER)


@each_body
@pytest.mark.parametrize("theory", THEORIES)
def test_heavy_bodies_press_the_surface_down_and_light_ones_lift_it(body, theory):
    found = flotation.equilibrium(body, WATER, theory)
    heavy = not isinstance(body, flotation.Bubble)
    assert (found.charge > 0) is heavy
    assert (found.slope_angle > 0) is heavy
    assert (found.contact_height < 0) is heavy
    assert found.floats


def test_unlike_bodies_repel_and_newtons_third_law_holds():
    bubble, disc = flotation.Bubble(0.7e-3), flotation.Disc(1.3e-3, 2e-5)
    force = flotation.pair_force(bubble, disc, 4e-3, WATER, "nonlinear")
    assert force == flotation.pair_force(disc, bubble, 4e-3, WATER, "nonlinear") > 0
    assert flotation.pair_force(disc, SPHERE, 4e-3, WATER) < 0


def test_the_greatest_load_is_found_where_it_lies_at_the_first_slope_tried():
    def load(psi):
        return balance.Load(psi, psi - 100.0 * psi**2, 1.0 - 200.0 * psi, None)

    assert balance.greatest_load(load, 1.0).slope_angle == pytest.approx(0.005, abs=1e-6)
    assert balance.greatest_load(load, 0.001).slope_angle == pytest.approx(0.001)


@pytest.mark.parametrize(
    ("make", "what"),
    [
        (lambda: flotation.Disc(0.0, 1e-5), "radius"),
        (lambda: flotation.Disc(1e-3, math.nan), "load"),
        (lambda: flotation.Disc(1e-3, 1e-5, stability=math.inf), "stability"),
        (lambda: flotation.Bubble(-1.0), "radius"),
        (lambda: flotation.VerticalCylinder(1e-3, 0.0, 1.0, 1.0), "height"),
        (lambda: flotation.VerticalCylinder(1e-3, 1.0, 1.0, 70.0), "did you mean 70 degrees"),
        (lambda: flotation.HorizontalCylinder(1e-3, 0.0, 1.0), "density"),
        (lambda: flotation.Ellipsoid((1e-3, 1e-3), 1.0, 1.0), "expected three"),
        (lambda: flotation.Ellipsoid((1e-3, 1e-3, -1.0), 1.0, 1.0), "semi-axis"),
        (lambda: flotation.equilibrium("cork", WATER), "expected a floating body"),
        (lambda: flotation.equilibrium(SPHERE, WATER, "magic"), "nonlinear, closed-form, linear"),
        (lambda: flotation.equilibrium(flotation.Ellipsoid((1e-3,) * 3, 900.0, 0.0), WATER, "linear"), "nonlinear"),
    ],
)
def test_an_impossible_body_is_refused_by_name(make, what):
    with pytest.raises(BadInput, match=what):
        make()


@pytest.mark.parametrize(
    "body",
    [
        flotation.Disc(1e-3, -1.0),
        flotation.VerticalCylinder(1e-3, 3e-3, 1.0, 3.0),
        flotation.HorizontalCylinder(1e-2, 1.0, 0.1),
        flotation.Ellipsoid((1e-2, 1e-2, 1e-2), 1.0, 0.1),
    ],
)
def test_what_is_too_light_is_reported(body):
    """Under oil: a body lighter than the upper liquid has no equilibrium at the interface."""
    water_under_oil = flotation.Liquid(density=1000.0, surface_tension=0.03, viscosity=1e-3, gas_density=900.0)
    with pytest.raises(FloaterSinks, match=r"leaves the liquid|lets go"):
        flotation.equilibrium(body, water_under_oil)


def test_two_lying_cylinders_pull_as_the_surface_midway_says():
    """Two equal ones far apart: the pressure on the level surface between them, rho g h^2/2, is their force."""
    charge = flotation.equilibrium(flotation.HorizontalCylinder(0.3e-3, 1500.0, 1.5), WATER).charge
    apart = 6 * L
    midway = -2 * charge * math.exp(-0.5 * apart / L)
    assert flotation.lying_pair_force(apart, charge, charge, WATER) == pytest.approx(-0.5 * EXCESS * midway**2)
    step = 1e-6
    ahead, behind = (flotation.lying_pair_energy(apart + d, charge, charge, WATER) for d in (step, -step))
    found = flotation.lying_pair_force(np.array([apart]), charge, charge, WATER)
    assert found[0] == pytest.approx(-(ahead - behind) / (2 * step), rel=1e-6)


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("radius", [650.0 * L, 300.0])
def test_a_rim_too_wide_for_its_meniscus_is_refused(radius, theory):
    with pytest.raises(BadInput, match="capillary lengths; expected at most 600"):
        flotation.equilibrium(flotation.Disc(radius, 2e-5), WATER, theory)
