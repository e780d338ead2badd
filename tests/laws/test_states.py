"""Equations of state, the hydrostatic part of a pressure, and a column of liquid at rest."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from tests.oracles import liquids

from ecume.errors import BadInput
from ecume.laws import hydrostatics, states

EXPONENTS = pytest.mark.parametrize("exponent", [1.0, 1.4, 7.0])


@EXPONENTS
def test_tait_pressure_and_density_undo_each_other(exponent):
    density = np.array([960.0, 1000.0, 1040.0])
    pressure = states.tait_pressure(density, 1000.0, 30.0, exponent)
    assert states.tait_density(pressure, 1000.0, 30.0, exponent) == pytest.approx(density, rel=1e-13)
    assert pressure[0] < 0.0 == pressure[1] < pressure[2]


@EXPONENTS
def test_the_sound_speed_is_the_slope_of_the_pressure(exponent):
    step = 1e-2
    low, high = (states.tait_pressure(1030.0 + sign * step, 1000.0, 30.0, exponent) for sign in (-1, 1))
    squared = liquids.tait_sound_speed(1030.0, 1000.0, 30.0, exponent) ** 2
    assert squared == pytest.approx((high - low) / (2 * step), rel=1e-8)


def test_with_the_exponent_one_tait_is_linear():
    assert states.tait_pressure(1010.0, 1000.0, 12.0, 1.0) == pytest.approx(
        liquids.linear_pressure(1010.0, 1000.0, 12.0)
    )
    assert states.tait_density(1440.0, 1000.0, 12.0, 1.0) == pytest.approx(liquids.linear_density(1440.0, 1000.0, 12.0))


def test_stiffness_and_sound_speed_say_the_same():
    stiff = states.stiffness(998.0, 31.0, 7.0)
    assert states.speed_of_stiffness(stiff, 998.0, 7.0) == pytest.approx(31.0)
    given = {"reference_density": 998.0, "gravity": 9.8}
    by_speed = hydrostatics.absolute_pressure(1001.0, 0.3, 1.0, sound_speed=31.0, **given)
    assert hydrostatics.absolute_pressure(1001.0, 0.3, 1.0, stiffness=stiff, **given) == pytest.approx(
        by_speed, rel=1e-14
    )


def test_the_absolute_pressure_is_the_sum_that_the_original_writes():
    found = hydrostatics.absolute_pressure(
        1003.0, 0.2, 0.9, reference_density=1000.0, stiffness=2000.0, gravity=9.8, atmospheric_pressure=1e5
    )
    assert found == pytest.approx(2000.0 * (1.003**7 - 1.0) + 1003.0 * 9.8 * 0.7 + 1e5)


def test_in_a_liquid_that_feels_its_weight_the_sum_counts_the_weight_twice():
    density = hydrostatics.hydrostatic_density(1.0, 9.81, 1000.0, 100.0)
    twice = hydrostatics.absolute_pressure(density, 0.0, 1.0, sound_speed=100.0)
    assert twice == pytest.approx(2 * 1000.0 * 9.81, rel=2e-3)
    right = states.tait_pressure(density, 1000.0, 100.0)
    assert right == pytest.approx(hydrostatics.hydrostatic_pressure(0.0, 1.0, 1000.0, 9.81), rel=2e-3)


def test_the_hydrostatic_part_falls_by_the_weight_and_ends_at_the_surface():
    found = hydrostatics.hydrostatic_pressure(np.array([0.0, 0.4, 1.0, 1.2]), 1.0, 1000.0, 10.0)
    assert found == pytest.approx([10000.0, 6000.0, 0.0, -2000.0])


@pytest.mark.parametrize(
    ("added", "gravity_acts", "in_forces", "free_surface", "reason"),
    [
        (False, True, False, True, ""),
        (True, True, False, False, "twice"),
        (True, True, False, True, "twice"),
        (True, False, False, False, ""),
        (True, False, False, True, "waves would feel no gravity"),
        (True, False, True, False, "push particles up"),
        (True, True, True, False, ""),
        (True, True, True, True, "waves would feel no gravity"),
    ],
)
def test_a_hydrostatic_part_in_the_wrong_place_is_reported_why(added, gravity_acts, in_forces, free_surface, reason):
    found = hydrostatics.hydrostatic_fault(
        added=added, gravity_acts=gravity_acts, in_forces=in_forces, free_surface=free_surface
    )
    assert (reason in found) if reason else found == ""


@pytest.mark.parametrize("given", [{}, {"sound_speed": 10.0, "stiffness": 3.0}])
def test_either_sound_speed_or_stiffness_is_given(given):
    with pytest.raises(BadInput, match="either sound_speed or stiffness"):
        hydrostatics.absolute_pressure(1000.0, 0.0, 1.0, **given)


@pytest.mark.parametrize("given", [{"sound_speed": -1.0}, {"stiffness": 0.0}, {"sound_speed": 1.0, "exponent": 0.0}])
def test_what_makes_no_equation_of_state_is_refused(given):
    with pytest.raises(BadInput, match="expected a positive number"):
        hydrostatics.absolute_pressure(1000.0, 0.0, 1.0, **given)


@EXPONENTS
def test_a_column_carries_its_own_weight(exponent):
    given = (9.81, 1000.0, 25.0, exponent)
    height = hydrostatics.column_height(1000.0, *given)
    mass, _ = quad(lambda depth: hydrostatics.hydrostatic_density(depth, *given), 0.0, height, epsabs=1e-10)
    assert mass == pytest.approx(1000.0, rel=1e-11)
    assert hydrostatics.column_pressure(height, *given) == pytest.approx(9810.0, rel=1e-12)


def test_a_column_solves_the_equation_of_equilibrium():
    def gain(depth, pressure):
        return 9.81 * states.tait_density(pressure, 1000.0, 25.0)

    found = solve_ivp(gain, (0.0, 2.0), [0.0], rtol=1e-11, atol=1e-9).y[0, -1]
    assert hydrostatics.column_pressure(2.0, 9.81, 1000.0, 25.0) == pytest.approx(found, rel=1e-9)


@pytest.mark.parametrize(
    ("mach", "exponent", "shorter", "bottom"),
    [
        (10.0, 7.0, 0.48715, 1.00971238),
        (10.0, 1.0, 0.49669, 1.01),
        (20.0, 7.0, 0.12417, None),
        (20.0, 1.0, 0.12479, None),
    ],
)
def test_a_column_is_shorter_than_its_water_at_rest_density(mach, exponent, shorter, bottom):
    height = hydrostatics.column_height(1.0, 1.0, 1.0, mach, exponent)
    assert 100.0 * (1.0 - height) == pytest.approx(shorter, abs=6e-6)
    if bottom:
        assert hydrostatics.hydrostatic_density(height, 1.0, 1.0, mach, exponent) == pytest.approx(bottom, abs=6e-9)


def test_ten_times_the_fastest_wave_keeps_the_density_within_a_percent():
    speed = states.numerical_sound_speed(2.0, 0.5, 9.81)
    assert hydrostatics.hydrostatic_density(2.0, 9.81, 1000.0, speed) / 1000.0 - 1.0 < 0.01
    assert states.numerical_sound_speed(2.0, 50.0, 9.81) == 500.0
