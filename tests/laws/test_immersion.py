"""Drag and torque on spheres between two liquids."""

import math

import numpy as np
import pytest
from tests.oracles.two_liquids import resistance

from ecume.errors import BadInput
from ecume.laws.drag import added_mass, inverse_kinematic_viscosity, schiller_naumann_factor
from ecume.laws.immersion import SHARES, immersion_factor, turning_factor

ANGLES = np.linspace(0.0, math.pi, 91)
FACTORS = pytest.mark.parametrize("factor", [immersion_factor, turning_factor])


@pytest.mark.parametrize(("degrees", "share"), [(35.0, 0.0), (65.0, 0.35), (128.0, 0.13)])
@pytest.mark.parametrize(("factor", "turns"), [(immersion_factor, False), (turning_factor, True)])
def test_the_tables_are_those_of_boundary_elements(factor, turns, degrees, share):
    angle = math.radians(degrees)
    assert factor(angle, share) == pytest.approx(resistance(angle, share, turns), abs=2e-4)


@FACTORS
def test_half_a_sphere_in_each_liquid_feels_half_of_each(factor):
    assert [factor(math.pi / 2, share) for share in np.linspace(0.0, 1.0, 21)] == pytest.approx([0.5] * 21, abs=1e-12)


@FACTORS
@pytest.mark.parametrize("share", [0.0, 0.01, 0.2, 0.37, 0.5])
def test_liquids_exchanged_are_the_angle_seen_from_above(factor, share):
    assert factor(ANGLES, share) == pytest.approx(factor(math.pi - ANGLES, 1.0 - share), abs=1e-12)


def test_who_is_deeper_in_the_more_viscous_liquid_feels_more():
    for share in SHARES[:-1]:
        assert np.all(np.diff(turning_factor(ANGLES, share)) < 1e-12)
        # Between similar liquids a sphere drags more where it only touches the surface: no liquid crosses that.
        assert np.all(np.diff(immersion_factor(ANGLES[: 91 if share < 0.35 else 71], share)) < 0.0)


def test_around_ninety_degrees_the_published_slope_shrinks_with_the_difference_of_the_liquids():
    angle = math.radians(89.0)
    for share in (0.0, 0.1, 0.3, 0.5):
        first = 0.5 * (1.0 + 9.0 / 16.0 * (1.0 - 2.0 * share) * math.cos(angle))
        assert immersion_factor(angle, share) == pytest.approx(first, abs=1e-4)


def test_a_sphere_that_turns_does_not_notice_a_surface_between_equal_liquids():
    assert turning_factor(ANGLES, 0.5) == pytest.approx(np.full(len(ANGLES), 0.5), abs=1e-12)


@FACTORS
@pytest.mark.parametrize("share", [-0.1, 1.1, math.nan])
def test_shares_that_are_none_are_refused(factor, share):
    with pytest.raises(BadInput, match="share_above"):
        factor(1.0, share)


def test_drag_by_the_reynolds_number_is_the_mean_of_both_liquids():
    light, heavy, speed, radius = (800.0, 4e-3), (1000.0, 1e-3), 0.02, 1e-3
    own = [schiller_naumann_factor(2.0 * radius * speed * rho / eta) for rho, eta in (heavy, light)]
    both = inverse_kinematic_viscosity(*heavy, *light)
    assert schiller_naumann_factor(2.0 * radius * speed * both) == pytest.approx(np.average(own, weights=[1e-3, 4e-3]))
    assert inverse_kinematic_viscosity(0.0, 0.0) == math.inf


def test_added_mass_counts_what_is_above():
    assert added_mass(1e-3, 2.0, 900.0, 900.0) == pytest.approx(0.5 * 900.0 * 4.0 / 3.0 * math.pi * 1e-9)
