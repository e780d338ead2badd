"""Hydrodynamic interaction: limits, symmetry, positive definiteness, and the speeds of rafts."""

import math

import numpy as np
import pytest

from ecume.laws.pair_mobility import compact_raft, pair_mobility, raft_speed_factor, surface_mobility

ALONE = 6.0 * math.pi


def test_far_spheres_move_one_another_as_points_do():
    far = pair_mobility(1e4, 1.0, 2.0, 1.0)
    assert far.along * 4.0 * math.pi * 1e4 == pytest.approx(1.0, rel=1e-7)
    assert far.across * 8.0 * math.pi * 1e4 == pytest.approx(1.0, rel=1e-7)


@pytest.mark.parametrize(("one", "other"), [(1.0, 1.0), (1.0, 0.3), (0.2, 2.0)])
def test_mobilities_are_continuous_and_smooth_where_the_formula_changes(one, other):
    for edge in (one + other, abs(one - other)):
        if edge > 0.0:
            below, above = (np.array(pair_mobility(edge * (1.0 + step), one, other, 1.0)) for step in (-1e-7, 1e-7))
            assert above == pytest.approx(below, rel=1e-6)


def test_a_sphere_inside_another_moves_with_it():
    assert np.allclose(np.array(pair_mobility(0.4, 1.0, 0.5, 1.0)) * ALONE, 1.0, rtol=1e-15)


def test_all_mobilities_scale_with_viscosity_and_size():
    one, other = np.array(pair_mobility(2.7, 1.0, 0.6, 1.0)), np.array(pair_mobility(2.7e-3, 1e-3, 0.6e-3, 5.0))
    assert other * 5e-3 == pytest.approx(one, rel=1e-13)


def test_a_single_float_has_half_the_drag_of_a_sphere_in_the_bulk():
    assert np.allclose(surface_mobility(np.zeros((1, 2)), np.ones(1), 1.0), 2.0 * np.eye(2) / ALONE, rtol=1e-15)


@pytest.mark.parametrize("seed", range(20))
def test_the_matrix_is_symmetric_and_positive_definite_whatever_the_packing(seed):
    dice = np.random.default_rng(seed)
    count = int(dice.integers(2, 30))
    radius = np.exp(dice.normal(0.0, 1.0, count))
    # From far apart to on top of one another.
    position = dice.normal(0.0, 10.0 ** dice.uniform(-2.0, 2.0), (count, 2))
    mobility = surface_mobility(position, radius, 1.0)
    assert np.array_equal(mobility, mobility.T)
    assert np.linalg.eigvalsh(mobility).min() > 0.0


def test_turning_the_floats_turns_the_velocities():
    dice = np.random.default_rng(3)
    position, radius, force = dice.normal(0.0, 3.0, (6, 2)), dice.uniform(0.2, 1.0, 6), dice.normal(size=(6, 2))
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    here = (surface_mobility(position, radius, 1.0) @ force.ravel()).reshape(-1, 2)
    there = (surface_mobility(position @ turn.T, radius, 1.0) @ (force @ turn.T).ravel()).reshape(-1, 2)
    assert there == pytest.approx(here @ turn.T, rel=1e-12)


@pytest.mark.parametrize(("count", "factor"), [(7, 3.45), (19, 6.08), (37, 8.81), (91, 14.37)])
def test_hexagonal_rafts_have_the_speeds_of_rotne_and_prager(count, factor):
    assert raft_speed_factor(count) == pytest.approx(factor, abs=0.005)


def resolved_speed_factor(count, blobs=42):
    """The factor of fully resolved Stokes flow: each sphere is a rigid shell of small overlapping spheres, whose radius
    is half their distance, and whose shell has the drag of the sphere (a rigid multiblob).
    """
    turns, heights = np.pi * (1.0 + math.sqrt(5.0)) * np.arange(blobs), 1.0 - (2.0 * np.arange(blobs) + 1.0) / blobs
    level = np.sqrt(1.0 - heights**2)
    shell = np.stack([level * np.cos(turns), level * np.sin(turns), heights], axis=1)
    small, radius = 0.5 * math.sqrt(4.0 * math.pi / blobs), 1.0
    for _ in range(4):
        radius /= drag_of_blobs(radius * shell, small)
    centers = np.column_stack([compact_raft(count), np.zeros(count)])
    return count / drag_of_blobs((centers[:, None] + radius * shell).reshape(-1, 3), small)


def drag_of_blobs(place, small):
    """The drag of small spheres that move together along x, over that of a sphere of radius 1."""
    apart = place[:, None] - place
    distance = np.linalg.norm(apart, axis=2) + 4.0 * small * np.eye(len(place))
    near, ratio = distance < 2.0 * small, small / distance
    equal = np.where(near, 1.0 - 9.0 / 32.0 / ratio, 0.75 * ratio + 0.5 * ratio**3)
    along = np.where(near, 3.0 / 32.0 / ratio, 0.75 * ratio - 1.5 * ratio**3)
    np.fill_diagonal(equal, 1.0)
    units = apart / distance[..., None]
    mobility = equal[..., None, None] * np.eye(3) + (along[..., None] * units)[..., None] * units[..., None, :]
    mobility = mobility.swapaxes(1, 2).reshape(3 * len(place), -1) / small
    motion = np.tile([1.0, 0.0, 0.0], len(place))
    return motion @ np.linalg.solve(mobility, motion)


@pytest.mark.parametrize(("count", "factor", "excess"), [(2, 1.420, 0.042), (7, 3.218, 0.071), (19, 5.774, 0.053)])
def test_rafts_are_faster_than_in_resolved_flow_by_what_the_law_says(count, factor, excess):
    found = resolved_speed_factor(count)
    assert found == pytest.approx(factor, rel=2e-3)
    assert raft_speed_factor(count) / found - 1.0 == pytest.approx(excess, abs=3e-3)


def test_a_compact_raft_touches_without_overlap():
    raft = compact_raft(91)
    distances = np.linalg.norm(raft[:, None] - raft[None], axis=2) + 9.0 * np.eye(91)
    assert distances.min() == pytest.approx(2.0, rel=1e-12)
    assert np.count_nonzero(np.isclose(distances, 2.0)) == 2 * 240  # a hexagon of side 6


def test_large_rafts_follow_the_square_root_of_their_number():
    assert raft_speed_factor(1200) == 2.0 * raft_speed_factor(300)
    assert raft_speed_factor(300) / raft_speed_factor(75) == pytest.approx(2.0, rel=0.06)
