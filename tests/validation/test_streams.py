"""What the cases on confined flows and drops measure with: without a run."""

import numpy as np
import pytest

from ecume.trajectories.frame import Frame
from ecume_validation import drops, full_tanks


def frame_of(position, velocity=None, mass=None):
    count = len(position)
    arrays = {
        "position": position,
        "velocity": np.zeros_like(position) if velocity is None else velocity,
        "mass": np.ones(count) if mass is None else mass,
    }
    return Frame(0.0, arrays, {}, {})


def scattered(count=900):
    return np.random.default_rng(4).uniform(0.0, 1.0, (count, 2))


def test_series_and_tables_agree():
    assert all(row.met for row in full_tanks.series())
    assert full_tanks.off_the_table() < 1e-6


def test_a_velocity_that_grows_linearly_is_read_exactly():
    place = scattered()
    velocity = np.stack([2.0 * place[:, 1], 1.0 - place[:, 0]], axis=1)
    inside = np.array([[0.5, 0.4], [0.3, 0.6]])
    found = full_tanks.velocity_at(frame_of(place, velocity), inside, 0.1)
    np.testing.assert_allclose(found, np.stack([2.0 * inside[:, 1], 1.0 - inside[:, 0]], axis=1), atol=1e-12)


def test_walls_hold_what_is_read_beside_them():
    place = scattered()
    velocity = np.stack([place[:, 1], np.zeros(len(place))], axis=1)
    found = full_tanks.velocity_at(frame_of(place, velocity), np.array([[0.5, 0.99], [0.5, 0.01]]), 0.1)
    np.testing.assert_allclose(found[:, 0], [0.99, 0.01], atol=1e-12)


def test_axes_are_those_of_an_ellipse():
    place = np.random.default_rng(5).uniform(-1.0, 1.0, (200_000, 2))
    disc = place[(place**2).sum(axis=1) < 1.0]
    np.testing.assert_allclose(drops.axes(frame_of(disc * [2.0, 0.5])), [2.0, 0.5], rtol=0.01)


def test_strings_are_distinguished_from_a_lattice():
    side = np.arange(-0.3, 0.3, 0.02)
    even = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    strings = np.stack(np.meshgrid(side / 3.0, 3.0 * side), axis=-1).reshape(-1, 2)
    assert full_tanks.nearest(frame_of(even)) == pytest.approx(1.0, abs=0.05)
    assert full_tanks.nearest(frame_of(strings)) < 0.5


def test_a_rigid_turn_has_its_spin():
    place = scattered() - 0.5
    velocity = np.stack([-place[:, 1], place[:, 0]], axis=1)
    assert full_tanks.spin(frame_of(place, velocity)) == pytest.approx((place**2).sum())
