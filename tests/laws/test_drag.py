"""Drag on floating spheres."""

import math

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.laws import drag, immersion


def test_half_a_sphere_in_the_liquid_feels_half_the_drag():
    assert immersion.immersion_factor(math.pi / 2) == 0.5


def test_drag_falls_as_the_sphere_rises_out_of_the_liquid():
    factors = immersion.immersion_factor(np.linspace(0.0, math.pi, 500))
    assert bool(np.all(np.diff(factors) < 0))
    assert factors[0] == pytest.approx(0.7245)
    assert factors[-1] == pytest.approx(0.0, abs=1e-15)


def test_a_thin_cap_drags_as_half_a_disc_edgewise():
    angle = math.pi - 1e-3
    half_a_disc = 16 / 3 * math.sin(angle)  # over eta R U
    assert 6 * math.pi * immersion.immersion_factor(angle) == pytest.approx(half_a_disc, rel=1e-2)


@pytest.mark.parametrize("degrees", [80.0, 85.0, 95.0, 100.0])
def test_near_ninety_degrees_the_published_series_agrees(degrees):
    cosine = math.cos(math.radians(degrees))
    series = 0.5 * (1 + 9 / 16 * cosine - 0.139 * cosine**2)
    assert immersion.immersion_factor(math.radians(degrees)) == pytest.approx(series, abs=3e-4)


@pytest.mark.parametrize(("degrees", "measured"), [(48.7, 0.68), (82.0, 0.54)])
def test_the_published_measurements_agree_to_three_percent(degrees, measured):
    assert immersion.immersion_factor(math.radians(degrees)) == pytest.approx(measured, rel=0.03)


def test_a_heavy_sphere_sits_deeper_and_drags_more():
    flat, pressed = immersion.factor_at_filling(np.array([math.pi / 2, math.pi / 2 + 0.3]))
    assert flat == 0.5
    assert pressed > flat


def test_terminal_speed_is_force_over_friction():
    friction = drag.stokes_friction(1e-3, 2e-3, 1.0)
    assert friction == pytest.approx(6 * math.pi * 2e-6)
    assert drag.relaxation_time(friction * 3.0, friction) == pytest.approx(3.0)


@pytest.mark.parametrize("angle", [-0.1, 4.0, math.nan])
def test_an_impossible_angle_is_refused(angle):
    with pytest.raises(BadInput, match="contact_angle"):
        immersion.immersion_factor(angle)


def test_the_spline_of_the_table_is_scipys_clamped_one():
    from scipy.interpolate import CubicSpline

    ends = ((1, 0.0), (1, immersion.DRAG.slope))
    wanted = CubicSpline(np.linspace(0.0, math.pi, len(immersion.DRAG.rows[0])), immersion.DRAG.rows[0], bc_type=ends)
    angles = np.linspace(0.0, math.pi, 1001)
    assert immersion.immersion_factor(angles) == pytest.approx(np.maximum(wanted(angles), 0.0), abs=1e-15)


def test_two_spheres_drag_as_one_far_apart_and_as_their_film_in_contact():
    far = drag.pair_factor(np.array([50.0, 100.0])) - 1.0
    assert far == pytest.approx([1.5 / 50, 1.5 / 100], rel=0.04)  # Stokeslets
    for gap in (1e-4, 2e-7, 0.9e-7):
        assert drag.pair_factor(2.0 + gap) == pytest.approx(0.5 / gap, rel=2e-3)
    factors = drag.pair_factor(2.0 + np.geomspace(1e-8, 100.0, 200))
    assert bool(np.all(np.diff(factors) < 0))


def test_a_rough_pair_meets_at_a_finite_drag():
    assert drag.pair_factor(2.0, roughness=0.01) == drag.pair_factor(2.01)
    assert drag.pair_factor(1.9, roughness=0.01) == drag.pair_factor(2.005, roughness=0.01) < 60.0
    assert drag.pair_factor(3.0, roughness=0.01) == drag.pair_factor(3.0)


@pytest.mark.parametrize(("separation", "roughness"), [(2.0, 0.0), (1.0, 0.0), (math.nan, 0.1), (3.0, -0.1)])
def test_smooth_spheres_in_contact_are_refused(separation, roughness):
    with pytest.raises(BadInput, match="roughness"):
        drag.pair_factor(separation, roughness)


def test_a_half_immersed_sphere_carries_a_quarter_of_its_own_volume_of_liquid():
    assert drag.added_mass(1e-3, math.pi / 2, 1000.0) == pytest.approx(0.25 * 4 / 3 * math.pi * 1e-6)
    assert drag.submerged_volume(1e-3, math.pi) == pytest.approx(4 / 3 * math.pi * 1e-9)
    assert drag.submerged_volume(1e-3, 0.0) == pytest.approx(0.0, abs=1e-24)


def test_fast_floaters_drag_more_by_schillers_and_naumanns_factor():
    assert drag.inertial_friction(2e-5, 100.0) == pytest.approx(2e-5 * (1 + 0.15 * 100**0.687))
