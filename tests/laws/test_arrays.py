"""Laws that a user calls take arrays as well as numbers."""

import math

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.laws import drag, flotation, immersion, meniscus

WATER = flotation.Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
ANGLES = np.array([[0.3, 0.8], [1.5, 2.0]])


@pytest.mark.parametrize(
    ("law", "given"),
    [
        (lambda angle: meniscus.wall_height(angle, WATER), ANGLES),
        (lambda angle: meniscus.wall_amplitude(contact_angle=angle, liquid=WATER), ANGLES),
        (lambda angle: flotation.sinking_density_ratio(bond_number=0.1, contact_angle=angle), ANGLES),
        (lambda bond: flotation.sinking_density_ratio(bond, 1.2), np.array([0.1, 0.3])),
        (lambda bond: flotation.closure_contact_angle(bond_number=bond, density_ratio=0.5), np.array([0.5, 0.6])),
        (lambda r: meniscus.dish_height(r, 0.01, 0.7, WATER), np.array([0.0, 4e-3])),
        (lambda r: meniscus.image_force(1e-4, r, 0.01, WATER, wall="pinned"), np.array([1e-3, 4e-3])),
        (immersion.immersion_factor, ANGLES),
        (drag.pair_factor, np.array([2.1, 3.0])),
    ],
)
def test_an_array_gives_what_its_numbers_give_one_by_one(law, given):
    found = law(given)
    assert found.shape == given.shape
    assert found.ravel() == pytest.approx([law(float(one)) for one in given.ravel()], rel=1e-13)
    assert isinstance(law(float(given.flat[0])), float)


def test_two_arrays_are_broadcast_and_a_bad_number_is_reported():
    bonds, angles = np.array([[0.1], [0.2]]), np.array([0.8, 1.2, 2.0])
    found = flotation.sinking_density_ratio(bonds, angles)
    assert found.shape == (2, 3)
    assert found[1, 2] == flotation.sinking_density_ratio(0.2, 2.0)
    with pytest.raises(BadInput, match="did you mean 90 degrees"):
        meniscus.wall_height(np.array([math.pi / 2, 90.0]), WATER)
