"""Charges that represent a contact line: their field, and their law at large distances."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize, minimize_scalar

from ecume.errors import BadInput
from ecume.laws import contact_lines
from ecume.laws.contact_lines import Line, spread_charges, star_charges
from ecume.laws.drag import disc_friction, disc_turning_friction
from ecume.laws.special import bessel_k0

LINES = [(1.0, 1.0), (1.0, 0.9), (1.0, 0.5), (1.0, 0.25), (1.0, 0.1)]


def height(line, points):
    """The harmonic field of the charges, A ln r each, without a constant."""
    places, charges = spread_charges(line)
    return np.log(np.linalg.norm(points[:, None] - places, axis=2)) @ charges


def around(line, factor=1.0, count=101):
    """Points of the confocal ellipse whose sum of semi-axes is longer, and their v."""
    turn = np.linspace(0.0, 2.0 * math.pi, count)
    focus2, size = line.along**2 - line.across**2, factor * (line.along + line.across)
    along, across = 0.5 * (size + focus2 / size), 0.5 * (size - focus2 / size)
    return np.stack([along * np.cos(turn), across * np.sin(turn)], axis=1), turn


@pytest.mark.parametrize("axes", LINES)
@pytest.mark.parametrize("mode", [2, 3, 5])
def test_a_line_that_rises_and_falls_has_the_field_of_its_own_harmonic(axes, mode):
    """exp(-m (u - u0)) cos(m v), by the sum of the semi-axes, which is c exp(u)."""
    line = Line(*axes, 0.0, mode, 0.01)
    for factor, tolerance in ((1.5, 0.02), (2.0, 3e-3)):
        points, turn = around(line, factor)
        expected = 0.01 * factor**-mode * np.cos(mode * turn)
        slender = 10.0 if axes[1] < 0.2 else 1.0  # whose neighbors on the flank are nearer than this ellipse
        assert height(line, points) == pytest.approx(expected, abs=tolerance * slender * 0.01 * factor**-mode)


@pytest.mark.parametrize("axes", LINES)
def test_a_charged_line_is_level(axes):
    line = Line(*axes, 0.3)
    points, _ = around(line, 1.2)
    found = height(line, points)
    assert np.ptp(found) < 0.02 * 0.3
    assert spread_charges(line)[1].sum() == pytest.approx(0.3)


def test_what_is_round_and_flat_is_one_charge():
    places, charges = spread_charges(Line(1.0, 1.0, 0.2))
    assert places.tolist() == [[0.0, 0.0]]
    assert charges.tolist() == [0.2]


def test_a_line_is_given_by_its_longer_axis_first():
    with pytest.raises(BadInput, match="longer first"):
        spread_charges(Line(1.0, 2.0, 0.1))


@pytest.mark.parametrize("arms", [3, 5])
def test_a_star_rises_once_an_arm(arms):
    line = Line(1.0, 1.0, 0.2, arms, 0.01)
    places, charges = star_charges(line, 0.8)
    turn = np.linspace(0.0, 2.0 * math.pi, 61)
    points = 6.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    height = np.log(np.linalg.norm(points[:, None] - places, axis=2)) @ charges - 0.2 * math.log(6.0)
    weight = np.full(arms, 0.2 / (arms + 1.0))  # which the arms carry as well as the middle
    of_weight = -np.sum(weight) * 0.8**arms / arms * np.cos(arms * turn) / 6.0**arms
    assert height == pytest.approx(0.01 * np.cos(arms * turn) / 6.0**arms + of_weight, abs=0.02 * 0.05 / 6.0**arms)
    assert charges.sum() == pytest.approx(0.2)


def pair_energy(one, other, apart, angles):
    """-2 pi gamma sum A A' K0, gamma and the capillary length one."""
    total = 0.0
    (p, a), (q, b) = spread_charges(one), spread_charges(other)
    p, q = (
        x @ np.array([[math.cos(t), math.sin(t)], [-math.sin(t), math.cos(t)]])
        for x, t in zip((p, q), angles, strict=True)
    )
    for place, charge in zip(p, a, strict=True):
        for there, its in zip(q + np.array([apart, 0.0]), b, strict=True):
            total -= 2.0 * math.pi * charge * its * bessel_k0(float(np.hypot(*(there - place))))
    return total


@pytest.mark.parametrize("angles", [(0.0, 0.0), (0.4, 0.9), (1.2, -0.3), (0.0, math.pi / 2)])
def test_two_lines_far_apart_follow_the_law_of_quadrupoles(angles):
    """Of moments H (a + b)^2 / 4: what r^2 h cos 2 phi is far outside an ellipse."""
    one, other = Line(1e-4, 0.4e-4, 0.0, 2, 1e-6), Line(1e-4, 1e-4, 0.0, 2, -2e-6)
    moments = [line.rise * (0.5 * (line.along + line.across)) ** 2 for line in (one, other)]
    strength = contact_lines.quadrupole_strength(1.0, *moments)
    found = pair_energy(one, other, 3e-3, angles)
    expected = contact_lines.quadrupole_energy(3e-3, sum(angles), strength)
    # The next order falls as (a/l)^2; the pull of gravity changes K0 at 1e-3 L by as little.
    assert found == pytest.approx(expected, rel=0.01, abs=0.01 * abs(strength) / 3e-3**4)


def test_tips_meet_tips_from_afar_and_flanks_meet_flanks_where_they_touch():
    """At one distance tips are nearer to each other; but flanks can come closer [lehle2008, botto2012]."""
    line = Line(3e-4, 1e-4, 0.0, 2, -1e-6)
    tips, flanks = (pair_energy(line, line, 7e-4, (t, t)) for t in (0.0, math.pi / 2))
    assert tips < flanks < 0.0
    touching_tips = pair_energy(line, line, 6e-4, (0.0, 0.0))
    touching_flanks = pair_energy(line, line, 2e-4, (math.pi / 2, math.pi / 2))
    assert touching_flanks < touching_tips < 0.0
    assert pair_energy(line, line, 7e-4, (0.0, math.pi / 2)) > 0.0


def touching(axes, other, angles):
    """Distance of the centers of two ellipses that touch: Perram and Wertheim (1985)."""
    turn, direction = angles
    way, (c, s) = np.array([math.cos(direction), math.sin(direction)]), (math.cos(turn), math.sin(turn))
    rotation = np.array([[c, -s], [s, c]])
    first, second = np.diag(np.square(axes)), rotation @ np.diag(np.square(other)) @ rotation.T

    def contact(share):
        return -share * (1.0 - share) * way @ np.linalg.solve((1.0 - share) * first + share * second, way)

    return (-minimize_scalar(contact, bounds=(0.0, 1.0), method="bounded").fun) ** -0.5


def docked(ratio, angles):
    """The energy of two ellipses of aspect ratio 4 in contact, the second smaller by this ratio, at these
    orientations.
    """
    lines = [Line(size, 0.25 * size, 0.0, 2, 0.1 * size) for size in (1.0, 1.0 / ratio)]
    apart = touching((1.0, 0.25), (1.0 / ratio, 0.25 / ratio), angles)
    (here, one), (there, other) = (spread_charges(line) for line in lines)
    c, s = math.cos(angles[0]), math.sin(angles[0])
    there = there @ np.array([[c, s], [-s, c]]) + apart * np.array([math.cos(angles[1]), math.sin(angles[1])])
    return float(one @ np.log(np.linalg.norm(here[:, None] - there[None], axis=2)) @ other)


def test_ellipses_lie_side_by_side_unless_one_is_much_smaller():
    """What the page on floating bodies says of arrows [loudet2009]."""
    side = (0.0, 0.5 * math.pi)
    for ratio, angle in ((1.0, 0.0), (1.2, 0.0), (1.5, 0.0), (2.0, 25.0)):
        starts = [(math.radians(turn), math.radians(way)) for turn in (0, -30, 30) for way in (50, 90, 130)]
        best = min((minimize(lambda at, by=ratio: docked(by, at), start, method="Nelder-Mead") for start in starts),
                   key=lambda found: found.fun)  # fmt: skip
        assert abs(math.degrees(best.x[0])) == pytest.approx(angle, abs=0.5)
        assert (best.fun < 1.001 * docked(ratio, side)) == (angle > 0.0)


def test_a_sphere_shifted_or_stretched_upwards_has_a_level_line():
    assert contact_lines.ellipsoid_undulation(1.0, 1.0, 0.7) == 0.0
    assert contact_lines.ellipsoid_undulation(1.3, 1.0, math.pi / 2) == pytest.approx(0.0, abs=1e-16)
    assert contact_lines.ellipsoid_undulation(1.3, 1.0, 0.7) == -contact_lines.ellipsoid_undulation(1.0, 1.3, 0.7)


@pytest.mark.parametrize("angle", [0.6, 1.2, 2.3])
def test_the_contact_line_of_an_almost_round_ellipsoid_keeps_youngs_angle(angle):
    """The surface z = z0 + H (r_c/r)^2 cos 2 phi meets the ellipsoid everywhere at one angle, to second order."""
    small = 1e-4
    axes = np.array([1.0 + small, 1.0 - small, 1.0])
    rise = contact_lines.ellipsoid_undulation(axes[0], axes[1], angle)
    radius = math.sin(angle)

    def cosine(phi, rise):
        # Where the surface meets the ellipsoid along phi: Newton's method from the sphere's line, outwards.
        r = radius
        for _ in range(30):
            z = math.cos(angle) + rise * (radius / r) ** 2 * math.cos(2 * phi)
            x, y = r * math.cos(phi), r * math.sin(phi)
            value = (x / axes[0]) ** 2 + (y / axes[1]) ** 2 + z**2 - 1.0
            slope = 2 * r + 2 * z * (-2 * rise * radius**2 / r**3 * math.cos(2 * phi))
            r -= value / slope
        normal = np.array([x / axes[0] ** 2, y / axes[1] ** 2, z])
        h_r = -2 * rise * radius**2 / r**3 * math.cos(2 * phi)
        h_t = -2 * rise * radius**2 / r**3 * math.sin(2 * phi)
        up = [-h_r * math.cos(phi) + h_t * math.sin(phi), -h_r * math.sin(phi) - h_t * math.cos(phi), 1.0]
        return float(normal @ up / np.linalg.norm(normal) / np.linalg.norm(up))

    spread = abs(cosine(0.0, rise) - cosine(math.pi / 2, rise))
    flat = abs(cosine(0.0, 0.0) - cosine(math.pi / 2, 0.0))
    assert spread < 3e-3 * flat


def test_thin_ellipsoids_drag_as_discs_and_long_ones_less_along_than_across():
    half = 0.5 * contact_lines.ellipsoid_friction(1.0, 1.0, 1e-6, 2.0)
    assert half == pytest.approx(disc_friction(1.0, 2.0), rel=1e-4)
    turning = 0.5 * contact_lines.ellipsoid_turning_friction(1.0, 1.0, 1e-6, 2.0)
    assert turning == pytest.approx(disc_turning_friction(1.0, 2.0), rel=1e-4)
    along, across = (
        contact_lines.ellipsoid_friction(1.0, 1e-4, 1e-4, 1.0),
        contact_lines.ellipsoid_friction(1e-4, 1.0, 1e-4, 1.0),
    )
    # Slender bodies: 4 pi eta a/(ln(2a/b) - 1/2) along, 8 pi eta a/(ln(2a/b) + 1/2) across.
    log = math.log(2e4)
    assert along == pytest.approx(4.0 * math.pi / (log - 0.5), rel=1e-6)
    assert across == pytest.approx(8.0 * math.pi / (log + 0.5), rel=1e-6)
