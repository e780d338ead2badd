"""Floaters that rotate about the vertical."""

import math

import numpy as np
import pytest
from scipy.special import ellipe, ellipk, zeta

from ecume.errors import BadInput
from ecume.laws import drag, immersion


def ring(r, z, a, b):
    """The potential at (r, z) of a ring at (a, b) with the charge cos(phi), over cos(phi)."""
    chi = 1.0 + ((r - a) ** 2 + (z - b) ** 2) / (2.0 * r * a)
    m = 2.0 / (chi + 1.0)
    return 2.0 * (chi * np.sqrt(m) * ellipk(m) - np.sqrt(2.0 * (chi + 1.0)) * ellipe(m)) / np.sqrt(r * a)


def by_single_layer(angle, panels=16):
    """The turning factor by rings on the wet cap and on its mirror image, closer to one another at the rim."""
    end, (at, weights) = math.pi - angle, np.polynomial.legendre.leggauss(6)
    edges = end * (1.0 - np.linspace(1.0, 0.0, panels + 1) ** 3)
    low, high = edges[:-1, None], edges[1:, None]
    t, w = (0.5 * (low + high + (high - low) * at)).ravel(), (0.5 * (high - low) * weights).ravel()
    r, z, off = np.sin(t), -math.cos(angle) - np.cos(t), ~np.eye(len(t), dtype=bool)
    apart = np.abs(t[:, None] - t) + ~off
    own = np.zeros_like(apart)
    own[off] = np.array([ring(r[i], z[i], r[j], z[j]) for i, j in zip(*np.nonzero(off), strict=True)])
    matrix = (own + ring(r[:, None], z[:, None], r, -z)) * w * r
    # The logarithm of the diagonal by its exact integral, less what the other nodes make of it.
    exact = t * np.log(t) + (end - t) * np.log(end - t) - end
    left = exact - (np.log(apart) * w * off).sum(axis=1)
    matrix[~off] += 2.0 * (np.log(8.0 * r) - 2.0) * w - 2.0 * left
    return math.pi * float(np.sum(np.linalg.solve(matrix, r) * r**2 * w))


@pytest.mark.parametrize("degrees", [20, 60, 90, 125, 150])
def test_the_table_is_that_of_a_single_layer_on_the_cap(degrees):
    angle = math.radians(degrees)
    assert immersion.turning_factor(angle) == pytest.approx(by_single_layer(angle), abs=2e-4)


def test_two_touching_spheres_and_thin_caps_turn_as_the_exact_solutions_say():
    assert immersion.turning_factor(0.0) == pytest.approx(0.75 * zeta(3.0), abs=1e-5)
    cap = math.radians(170.0)
    disc = drag.disc_turning_friction(math.sin(cap), 1.0)
    assert drag.sphere_turning_friction(1.0, 1.0, immersion.turning_factor(cap)) == pytest.approx(disc, rel=0.06)


def test_who_is_higher_turns_more_easily():
    factors = immersion.turning_factor(np.linspace(0.0, math.pi, 500))
    assert np.all(np.diff(factors) <= 0.0)
    assert factors[-1] == 0.0


@pytest.mark.parametrize("angle", [-0.1, 3.2, math.nan])
def test_angles_that_are_none_are_refused(angle):
    with pytest.raises(BadInput, match="radians between 0 and pi"):
        immersion.turning_factor(angle)
