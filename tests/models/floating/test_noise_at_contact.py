"""Brownian floats at contact: distances as in equilibrium, where each allowed place is equally likely."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

import ecume
from tests.models.floating.brownian_discs import RADIUS, discs_at
from tests.oracles.hard_discs import gap_counts, lattice, monte_carlo

SIDE = 6.0


def test_monte_carlo_finds_two_discs_where_there_is_room():
    edges = np.array([0.0, 0.2, 0.9])
    found = gap_counts(monte_carlo(2, SIDE, 20_000, 1), SIDE, edges)
    assert found == pytest.approx(shares_in_a_cell(edges), rel=0.05)


def shares_in_a_cell(edges):
    """The exact shares of gaps of two discs of radius 1 in a periodic square, up to half its side."""
    return np.pi * np.diff((2.0 + edges) ** 2) / (SIDE**2 - 4.0 * np.pi)


@pytest.mark.long
@pytest.mark.compiled
def test_a_hundred_discs_have_the_pair_distribution_and_the_pressure_of_monte_carlo():
    side, edges = np.sqrt(100 * np.pi / 0.3), np.array([0.0, 0.01, 0.03, 0.05, 0.1, 0.2])
    cell = f"[cell]\nsize = [{side * RADIUS}, {side * RADIUS}]"
    scene = discs_at(lattice(100, side) - side / 2.0, cell, duration=300.0, every=0.1)
    frames = [frame.arrays["position"] / RADIUS for frame in ecume.simulate(scene)]
    found = gap_counts(np.array(frames[20:]), side, edges)
    # Two thousand configurations of Monte Carlo are within 2 %.
    assert found == pytest.approx(gap_counts(monte_carlo(100, side, 12_000, 1), side, edges), rel=0.06)
    place = np.mod(frames[-1], side)
    assert not cKDTree(place, boxsize=side).query_pairs(2.0 - 1e-4)
    # The pressure over that of an ideal gas is 1 + 2 eta g at contact: (1 - 7 eta/16)/(1 - eta)^2 by Henderson.
    contact = (found / ideal_counts(100, side, edges))[:3].mean()
    assert contact == pytest.approx((1.0 - 7.0 * 0.3 / 16.0) / 0.7**2, rel=0.03)


def ideal_counts(count, side, edges):
    """The number of pairs in each bin of gaps if they were placed independently."""
    return count * (count - 1) / 2.0 * np.pi * np.diff((2.0 + edges) ** 2) / side**2
