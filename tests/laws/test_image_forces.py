"""The force on a floater by its mirror image at a wall."""

import math

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.laws import flotation, meniscus

LIQUID = flotation.Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
L = LIQUID.capillary_length
A = 2e-5
UNIT = 2 * math.pi * LIQUID.surface_tension * A**2 / L


def field(place, source, radius, sign, orders=60):
    """The height of the mirror image's field at a position in a dish, by its series, for a source of unit charge;
    lengths in L.
    """
    from scipy.special import iv, ivp, kv, kvp

    (x, y), (u, v) = place, source
    r, s, angle = math.hypot(x, y), math.hypot(u, v), math.atan2(y, x) - math.atan2(v, u)
    total = 0.0
    for m in range(orders):
        ratio = kvp(m, radius) / ivp(m, radius) if sign > 0 else kv(m, radius) / iv(m, radius)
        total -= (1 if m == 0 else 2) * ratio * iv(m, r) * iv(m, s) * math.cos(m * angle)
    return total


@pytest.mark.parametrize(("wall", "sign"), [("fixed-angle", 1), ("pinned", -1)])
def test_a_mirrored_meniscus_meets_the_wall_as_the_wall_wants(wall, sign):
    """With its image the field has no slope at a wall of fixed angle, and no height at a pinned one; its slope is the
    force.
    """
    from scipy.special import k0

    radius, source = 3.0, (1.3, 0.4)

    def height(r, angle):
        place = r * math.cos(angle), r * math.sin(angle)
        return k0(math.dist(place, source)) + field(place, source, radius, sign)

    for angle in (0.0, 1.0, 2.8):
        there = height(radius, angle) - height(radius - 1e-5, angle) if sign > 0 else height(radius, angle)
        assert there == pytest.approx(0.0, abs=1e-9)
    step, r = 1e-4, math.hypot(*source)
    ahead, behind = (field(tuple(x * (1 + d / r) for x in source), source, radius, sign) for d in (step, -step))
    found = meniscus.image_force(A, r * L, radius * L, LIQUID, wall)
    assert found == pytest.approx(UNIT * (ahead - behind) / (2 * step), rel=1e-6)


@pytest.mark.parametrize("charge", [A, -A])
def test_a_fixed_angle_attracts_and_a_pinned_line_repels_either_charge(charge):
    r = np.array([0.1, 2.0, 4.5]) * L
    assert bool(np.all(meniscus.image_force(charge, r, 5 * L, LIQUID) > 0))
    assert bool(np.all(meniscus.image_force(charge, r, 5 * L, LIQUID, "pinned") < 0))


@pytest.mark.parametrize("wall", meniscus.WALLS)
def test_a_wide_dish_is_a_plane_wall_and_so_is_a_wide_rectangle(wall):
    plane = meniscus.plane_image_force(A, 0.7 * L, LIQUID, wall)
    wide = [meniscus.image_force(A, (a - 0.7) * L, a * L, LIQUID, wall) / plane - 1 for a in (100.0, 200.0)]
    assert abs(wide[0]) < 0.01
    assert wide[0] / wide[1] == pytest.approx(2.0, rel=0.02)  # what is left is the wall's curvature
    x, y = meniscus.rectangle_image_force(A, (49.3 * L, 3 * L), (100 * L, 100 * L), LIQUID, wall)
    assert x == pytest.approx(plane, rel=1e-12)
    assert y == 0.0


@pytest.mark.parametrize("wall", meniscus.WALLS)
def test_a_corner_pulls_along_its_diagonal_as_three_images_do(wall):
    sign, d = meniscus.WALLS[wall], 0.6
    from scipy.special import k1

    x, y = meniscus.rectangle_image_force(A, (30 * L - d * L, -(30 - d) * L), (60 * L, 60 * L), LIQUID, wall)
    far = 2 * d * math.sqrt(2)
    expected = UNIT * (sign * k1(2 * d) + k1(far) / math.sqrt(2))
    assert x == pytest.approx(expected, rel=1e-10)
    assert y == pytest.approx(-expected, rel=1e-10)


def test_a_narrow_channel_is_the_slope_of_its_own_energy():
    """The lattice of images against the energy of the same images, differentiated."""
    from scipy.special import k0

    width, x, step = 1.7, 0.45, 1e-5

    def energy(place):
        total = 0.0
        for k in range(-20, 21):
            total -= 0.5 * k0(abs(2 * k * width)) if k else 0.0
            total -= 0.5 * k0(abs((2 * k + 1) * width - 2 * place))
        return UNIT * L * total

    slope = -(energy(x + step) - energy(x - step)) / (2 * step * L)
    found, _ = meniscus.rectangle_image_force(A, (x * L, 0.0), (width * L, 200 * L), LIQUID)
    assert found == pytest.approx(slope, rel=1e-8)


def test_the_middle_feels_nothing_and_near_it_the_force_grows_with_distance():
    assert meniscus.image_force(A, 0.0, 2 * L, LIQUID) == 0.0
    near, twice = (meniscus.image_force(A, r * L, 2 * L, LIQUID) for r in (1e-8, 2e-8))
    assert twice == pytest.approx(2 * near)
    assert near / 1e-8 == pytest.approx(meniscus.image_force(A, 1e-4 * L, 2 * L, LIQUID) / 1e-4, rel=1e-6)


def test_a_very_wide_dish_overflows_nowhere():
    found = meniscus.image_force(A, np.array([0.0, 1900.0, 1999.5]) * L, 2000 * L, LIQUID)
    assert 0.0 == found[0] < found[1] < 1e-80
    assert found[2] == pytest.approx(meniscus.plane_image_force(A, 0.5 * L, LIQUID), rel=1e-3)


@pytest.mark.parametrize(
    ("ask", "what"),
    [
        (lambda: meniscus.image_force(A, 0.02, 0.01, LIQUID), "less than the dish's radius"),
        (lambda: meniscus.image_force(A, 0.01 * (1 - 1e-5), 0.01, LIQUID), "plane_image_force"),
        (lambda: meniscus.image_force(A, 0.0, 0.01, LIQUID, "sticky"), "fixed-angle, pinned"),
        (lambda: meniscus.plane_image_force(A, 0.0, LIQUID), "distance"),
        (lambda: meniscus.rectangle_image_force(A, (0.01, 0.0), (0.01, 0.01), LIQUID), "outside the dish"),
        (lambda: meniscus.rectangle_image_force(A, (0.0, 0.0), (-0.01, 0.01), LIQUID), "width"),
    ],
)
def test_what_lies_at_or_beyond_a_wall_is_refused(ask, what):
    with pytest.raises(BadInput, match=what):
        ask()
