import math

import numpy as np
import pytest

from ecume.laws import pair_laws


def test_the_force_is_minus_the_slope_of_the_energy():
    for distance in (0.3, 1.0, 4.0):
        step = 1e-5 * distance
        rise = pair_laws.dipole_energy(distance + step, 0.7) - pair_laws.dipole_energy(distance - step, 0.7)
        assert pair_laws.dipole_force(distance, 0.7) == pytest.approx(-rise / (2 * step), rel=1e-8)


def test_two_ampere_square_meters_a_meter_apart_push_each_other_with_three_ten_millionths_of_a_newton():
    """mu_0/(4 pi) is 1e-7 to nine digits."""
    strength = pair_laws.dipole_strength(1.0, 1.0)
    assert pair_laws.dipole_force(1.0, strength) == pytest.approx(3e-7, rel=1e-9)
    assert pair_laws.dipole_force(1.0, pair_laws.dipole_strength(1.0, -1.0)) == pytest.approx(-3e-7, rel=1e-9)


def test_two_upright_dipoles_are_four_poles_from_afar():
    """Each moment is a pole above and its opposite below; poles push by Coulomb's law."""
    half, distance = 1e-3, 1.0
    pole = 1.0 / (2 * half)
    across, along = 1.0 / distance**2, distance / math.hypot(distance, 2 * half) ** 3
    wanted = 2.0 * pair_laws.PERMEABILITY / (4 * math.pi) * pole**2 * (across - along)
    assert pair_laws.dipole_force(distance, pair_laws.dipole_strength(1.0, 1.0)) == pytest.approx(wanted, rel=1e-4)


def test_what_is_left_out_is_the_force_of_a_half_plane_beyond_the_cutoff():
    r = np.linspace(1.0, 400.0, 400_001)
    force = np.sum(r**-3) - 0.5
    far = np.sum(r[r >= 5.0] ** -3) - 0.5 * 5.0**-3
    assert pair_laws.neglected_dipoles(5.0) == pytest.approx(far / force, rel=1e-3)
