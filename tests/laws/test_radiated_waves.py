"""Waves of a point that oscillates, against quadrature, the dispersion relation and real special functions."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import j0, struve, yv

from ecume.errors import BadInput
from ecume.laws.radiated_waves import (
    mean_force,
    ripples,
    slope_of_struve_minus_bessel,
    slope_per_force,
    steepness,
    struve_minus_bessel,
    surface_per_force,
)
from ecume.laws.water_waves import wave_frequency

BATH = {"density": 1149.5, "tension": 0.067, "viscosity": 0.01, "gravity": 9.81}
"""A mixture of water and glycerol."""


@pytest.mark.parametrize("frequency", [40.0, 100.0, 300.0])
def test_the_wavelength_is_that_of_the_dispersion_relation(frequency):
    waves = ripples(frequency, 1000.0, 0.07, 1e-9, 9.81)
    wavenumber = 2.0 * math.pi / waves.wavelength
    omega = wave_frequency(wavenumber, 1.0, 9.81, 0.07 / 1000.0)
    assert omega / (2.0 * math.pi) == pytest.approx(frequency, rel=1e-6)


def test_ring_waves_have_that_wavelength_and_viscous_decay_far_away():
    waves = ripples(90.0, **BATH)
    far = 12.0 * waves.wavelength + np.linspace(0.0, waves.wavelength, 200)
    phase = np.unwrap(np.angle(surface_per_force(far, waves)))
    assert -(phase[-1] - phase[0]) == pytest.approx(2.0 * math.pi, rel=1e-3)
    one, other = np.abs(surface_per_force(far[[0, -1]], waves)) * np.sqrt(far[[0, -1]])
    assert math.log(one / other) == pytest.approx(waves.wavelength / waves.decay_length, rel=0.01)
    # Weak damping: 2 nu k^2 over the group velocity.
    k = 2.0 * math.pi / waves.wavelength
    specific = BATH["tension"] / BATH["density"]
    group = (9.81 + 3.0 * specific * k**2) / (2.0 * 2.0 * math.pi * 90.0)
    rate = 2.0 * BATH["viscosity"] / BATH["density"] * k**2
    assert waves.decay_length == pytest.approx(group / rate, rel=0.02)


@pytest.mark.parametrize("x", [0.4, 2.0, 7.0])
def test_the_closed_form_is_the_hankel_transform_of_a_strongly_damped_wave(x):
    waves = ripples(100.0, 1000.0, 0.07, 0.02, 9.81)

    def integrand(k):
        polynomial = waves.damping**2 * k**4 + k**3 + 2j * waves.damping * k**2 + waves.gravity * k - 1.0
        return k * k / polynomial * j0(k * x)

    end = 400.0
    real = quad(lambda k: integrand(k).real, 0.0, end, limit=4000)[0]
    imaginary = quad(lambda k: integrand(k).imag, 0.0, end, limit=4000)[0]
    expected = -complex(real, imaginary) / (2.0 * math.pi * waves.tension)
    found = complex(surface_per_force(np.array([x / waves.wavenumber]), waves)[0])
    assert abs(found - expected) < 2e-3 * abs(expected)


def test_the_slope_is_the_derivative_of_the_surface():
    waves, distance = ripples(90.0, **BATH), np.array([2e-4, 1e-3, 5e-3, 2e-2])
    step = 2e-4 * distance
    by_differences = (surface_per_force(distance + step, waves) - surface_per_force(distance - step, waves)) / (
        2 * step
    )
    assert slope_per_force(distance, waves) == pytest.approx(by_differences, rel=1e-4)


def test_a_static_force_leaves_the_logarithm_of_tension_nearby():
    """At distances far below the wavelength tension alone carries the force: the slope is F/(2 pi sigma r)."""
    waves = ripples(90.0, 1000.0, 0.07, 1e-6, 9.81)
    distance = np.array([1e-3 * waves.wavelength])
    assert slope_per_force(distance, waves)[0].real == pytest.approx(
        1.0 / (2.0 * math.pi * 0.07 * distance[0]), rel=0.01
    )


def test_functions_of_real_arguments_are_those_of_scipy():
    x = np.array([1e-3, 0.1, 1.0, 5.0, 30.0])
    assert struve_minus_bessel(x) == pytest.approx(struve(0, x) - yv(0, x), rel=1e-9)
    assert slope_of_struve_minus_bessel(x) == pytest.approx(2.0 / math.pi - struve(1, x) + yv(1, x), rel=1e-8)


def test_one_is_the_derivative_of_the_other_in_all_quadrants():
    for z in (0.5 + 2.0j, -3.0 + 0.1j, -3.0 - 0.1j, -0.2 - 4.0j, -0.3 + 2.0j, 20.0 - 9.0j):
        step = 1e-4
        slope = (struve_minus_bessel(z + step) - struve_minus_bessel(z - step)) / (2.0 * step)
        assert complex(slope) == pytest.approx(complex(slope_of_struve_minus_bessel(z)), rel=1e-6)


def test_functions_are_continuous_across_the_imaginary_axis():
    for y in (3.0, -0.5):
        left, right = struve_minus_bessel(complex(-1e-12, y)), struve_minus_bessel(complex(1e-12, y))
        assert complex(left) == pytest.approx(complex(right), rel=1e-9)


def test_forces_in_phase_are_equal_and_others_are_not():
    slope = complex(slope_per_force(np.array([5e-3]), ripples(90.0, **BATH))[0])
    assert mean_force(slope, 1e-4, 2e-4 + 0j) == mean_force(slope, 2e-4, 1e-4 + 0j)
    one, other = mean_force(slope, 1e-4, 1e-4j), mean_force(slope, 1e-4j, 1e-4 + 0j)
    assert one == pytest.approx(-other)
    assert abs(one) > 1e-9


def test_what_the_theory_does_not_cover_is_refused():
    with pytest.raises(BadInput, match="damping"):
        ripples(100.0, 1000.0, 0.07, 1.0, 9.81)
    for frequency in (0.05, 1e-10, 1e-300):
        with pytest.raises(BadInput, match="a higher frequency"):
            ripples(frequency, 1000.0, 0.07, 1e-3, 9.81)
    assert steepness(2e-4, ripples(90.0, **BATH)) == pytest.approx(2.0 * steepness(1e-4, ripples(90.0, **BATH)))
