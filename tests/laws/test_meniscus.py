"""The liquid's surface at walls."""

import math

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.laws import flotation, meniscus

LIQUID = flotation.Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
L = LIQUID.capillary_length


@pytest.mark.parametrize("degrees", [0.0, 30.0, 89.0, 120.0, 180.0])
def test_hydrostatic_pressure_on_a_wall_balances_surface_tension(degrees):
    """Horizontal balance of the liquid between the wall and far away: gamma (1 - sin theta) = rho g h^2/2."""
    height = meniscus.wall_height(math.radians(degrees), LIQUID)
    pull = LIQUID.surface_tension * (1 - math.sin(math.radians(degrees)))
    assert pull == pytest.approx(0.5 * 1000.0 * 9.81 * height**2, abs=1e-16)
    assert (height > 0) is (degrees < 90.0)


@pytest.mark.parametrize("degrees", [0.0, 30.0, 80.0, 140.0])
def test_the_plane_profile_solves_young_and_laplace(degrees):
    angle = math.radians(degrees)
    x = np.linspace(0.2, 5.0, 25) * L
    step = 2e-3 * L
    below, at, above = (meniscus.plane_height(x + k * step, angle, LIQUID) for k in (-1, 0, 1))
    slope, bend = (above - below) / (2 * step), (above - 2 * at + below) / step**2
    assert bend / (1 + slope**2) ** 1.5 == pytest.approx(at / L**2, rel=1e-4, abs=1e-4 * abs(at[0]) / L**2)
    assert meniscus.plane_height(0.0, angle, LIQUID) == meniscus.wall_height(angle, LIQUID)
    far = meniscus.plane_height(20 * L, angle, LIQUID) * math.exp(20.0)
    assert far == pytest.approx(meniscus.wall_amplitude(angle, LIQUID), rel=1e-12)


def test_a_wall_at_ninety_degrees_leaves_the_surface_flat():
    flat = math.pi / 2
    assert meniscus.wall_amplitude(flat, LIQUID) == meniscus.wall_height(flat, LIQUID) == 0.0
    assert meniscus.plane_height(L, flat, LIQUID) == 0.0
    for theory in meniscus.DISHES:
        assert meniscus.dish_height(L, 5 * L, flat, LIQUID, theory) == pytest.approx(0.0, abs=1e-18)


def test_near_ninety_degrees_the_linear_theory_is_right():
    angle = math.radians(89.9)
    assert meniscus.wall_amplitude(angle, LIQUID) == pytest.approx(L / math.tan(angle), rel=1e-5)
    r = np.linspace(0.0, 3.0, 7) * L
    heights = [meniscus.dish_height(r, 3 * L, angle, LIQUID, theory) for theory in meniscus.DISHES]
    assert heights[0] == pytest.approx(heights[2], rel=1e-5)
    assert heights[1] == pytest.approx(heights[2], rel=1e-5)


def test_a_non_wetting_wall_is_the_mirror_image_of_a_wetting_one():
    r = np.linspace(0.0, 4.0, 5) * L
    for theory in meniscus.DISHES:
        wetting = meniscus.dish_height(r, 4 * L, math.radians(50.0), LIQUID, theory)
        other = meniscus.dish_height(r, 4 * L, math.radians(130.0), LIQUID, theory)
        assert other == pytest.approx(-wetting, rel=1e-9)
        assert bool(np.all(np.diff(wetting) > 0))


def test_the_nonlinear_dish_meets_its_wall_at_the_contact_angle():
    angle, radius = math.radians(35.0), 2 * L
    step = 1e-4 * L
    h = meniscus.dish_height(radius - np.array([0.0, step, 2 * step]), radius, angle, LIQUID, "nonlinear")
    slope = (3 * h[0] - 4 * h[1] + h[2]) / (2 * step)
    assert slope == pytest.approx(1 / math.tan(angle), rel=1e-5)


def test_the_default_dish_is_good_outside_two_capillary_lengths_of_the_wall():
    r = np.linspace(0.0, 6.0, 7) * L
    rough, exact = (meniscus.dish_height(r, 8 * L, math.radians(45.0), LIQUID, t) for t in ("amplitude", "nonlinear"))
    assert rough == pytest.approx(exact, rel=0.01)


def test_very_wide_and_very_narrow_dishes_work():
    wide = meniscus.dish_height(np.array([0.0, 400.0]) * L, 400 * L, 0.8, LIQUID, "nonlinear")
    assert wide[0] == pytest.approx(0.0, abs=1e-30)
    assert wide[1] == pytest.approx(meniscus.wall_height(0.8, LIQUID), rel=2e-3)
    radius = 0.01 * L
    jurin = 2 * L**2 * math.cos(0.8) / radius
    assert meniscus.dish_height(0.0, radius, 0.8, LIQUID, "nonlinear") == pytest.approx(jurin, rel=1e-3)
    tiny = meniscus.dish_height(0.0, 1e-3 * L, 0.8, LIQUID, "nonlinear")
    assert tiny == pytest.approx(10 * jurin, rel=1e-3)


def test_a_rectangle_meets_all_four_walls_with_the_linear_slope():
    angle, size = math.radians(60.0), (5 * L, 8 * L)
    wanted = meniscus.wall_amplitude(angle, LIQUID) / L
    step = 1e-3 * L
    for x, y, across, along in ((2.5, 1.0, 1, 0), (-2.5, 0.3, -1, 0), (0.7, 4.0, 0, 1), (0.0, -4.0, 0, -1)):
        at, before, earlier = (
            meniscus.rectangle_height((x * L - k * across * step, y * L - k * along * step), size, angle, LIQUID)
            for k in range(3)
        )
        assert (3 * at - 4 * before + earlier) / (2 * step) == pytest.approx(wanted, rel=1e-5)


def test_a_rectangle_far_from_three_walls_is_a_plane_wall():
    height = meniscus.rectangle_height((np.array([97.0]) * L, 0.0), (200 * L, 200 * L), 0.5, LIQUID)
    assert height[0] == pytest.approx(meniscus.wall_amplitude(0.5, LIQUID) * math.exp(-3.0), rel=1e-12)


def test_places_outside_a_dish_are_refused():
    with pytest.raises(BadInput, match="outside the dish"):
        meniscus.dish_height(0.02, 0.01, 0.8, LIQUID)
    with pytest.raises(BadInput, match="outside the dish"):
        meniscus.rectangle_height((0.02, 0.0), (0.01, 0.01), 0.8, LIQUID)


@pytest.mark.parametrize(
    ("r", "radius", "angle", "what"),
    [
        (-1e-3, 0.01, 0.8, "r is"),
        (0.0, 0.0, 0.8, "dish_radius"),
        (0.0, 0.01, 45.0, "did you mean 45 degrees"),
        (0.0, math.nan, 0.8, "dish_radius"),
    ],
)
def test_an_impossible_dish_is_refused_by_name(r, radius, angle, what):
    with pytest.raises(BadInput, match=what):
        meniscus.dish_height(r, radius, angle, LIQUID)


def test_the_linear_dish_has_no_height_when_wetted_all_over():
    with pytest.raises(BadInput, match="amplitude"):
        meniscus.dish_height(0.0, 0.01, 0.0, LIQUID, "linear")
    with pytest.raises(BadInput, match="amplitude, nonlinear, linear"):
        meniscus.dish_height(0.0, 0.01, 0.0, LIQUID, "exact")
