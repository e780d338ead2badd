"""Collisions of two bodies and of a body with a wall."""

import pytest

from ecume.laws import friction


def collided(v_i, v_j, m_i, m_j, restitution):
    J = friction.impulse(v_i - v_j, m_i, m_j, restitution)
    return v_i - J / m_i, v_j + J / m_j


def test_a_collision_keeps_momentum_and_turns_the_approach_by_the_restitution():
    for e in (0.0, 0.3, 1.0):
        w_i, w_j = collided(3.0, -1.0, 0.7, 2.1, e)
        assert 0.7 * w_i + 2.1 * w_j == pytest.approx(0.7 * 3.0 - 2.1, rel=1e-15)
        assert w_j - w_i == pytest.approx(e * 4.0, abs=1e-15)


def test_an_elastic_collision_keeps_energy():
    w_i, w_j = collided(3.0, -1.0, 0.7, 2.1, 1.0)
    assert 0.7 * w_i**2 + 2.1 * w_j**2 == pytest.approx(0.7 * 9 + 2.1, rel=1e-15)


def test_bodies_that_part_are_left_alone():
    assert friction.impulse(-1.0, 1.0, 1.0, 1.0) == 0.0


def test_the_original_coefficient_below_one_half_lets_bodies_sink_into_each_other():
    w_i, w_j = collided(1.0, -1.0, 1.0, 1.0, friction.RESTITUTIONS["legacy_coefficient"](0.3))
    assert w_i > w_j
    w_i, w_j = collided(1.0, -1.0, 1.0, 1.0, friction.RESTITUTIONS["restitution"](0.3))
    assert w_i < w_j


def test_the_coefficient_and_the_restitution_are_inverse():
    assert friction.legacy_coefficient(friction.legacy_restitution(0.35)) == pytest.approx(0.35)
