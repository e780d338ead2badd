"""Exact solutions of contacts: the nearest velocities that satisfy all conditions."""

from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import nnls

from ecume.engine.contact import active_set, impulse_solvers
from ecume.engine.contact.contacts import DiscMotion, apply_impulses, make_contacts
from ecume.engine.contact.impulse_solvers import Tolerance

COMPILED = os.environ.get("NUMBA_DISABLE_JIT") != "1"
EXACT = Tolerance(1e-12, 1e-12)
sizes = st.tuples(st.integers(1, 12), st.integers(1, 12), st.integers(0, 2**32 - 1))


@given(size=sizes)
def test_the_least_squares_are_those_of_scipy(size):
    rows, columns, seed = size
    random = np.random.default_rng(seed)
    matrix, right = random.normal(size=(rows, columns)), random.normal(size=rows)
    solution, found = active_set.nonnegative_least_squares(matrix, right, random.random(columns) < 0.5)
    expected, rest = nnls(matrix, right)
    assert found
    assert solution.min() >= 0.0
    assert np.linalg.norm(matrix @ solution - right) == pytest.approx(rest, abs=1e-10)
    if columns <= rows:
        np.testing.assert_allclose(solution, expected, atol=1e-7)


def raft(rings: int, seed: int, crowding: float = 1e-7):
    """A hexagonal raft with more contacts than degrees of freedom, whose floats are all pushed to its center."""
    random = np.random.default_rng(seed)
    axes = np.array([[1.0, 0.0], [0.5, 0.75**0.5]])
    places = [(a, b) for a in range(-rings, rings + 1) for b in range(-rings, rings + 1) if abs(a + b) <= rings]
    position = np.array(places) @ axes + crowding * random.normal(size=(len(places), 2))
    apart = np.linalg.norm(position[:, None] - position[None], axis=2)
    first, second = (found.astype(np.int64) for found in np.nonzero(np.triu(apart < 1.1, 1)))
    contacts, total = make_contacts(len(first) + 3), len(first)
    contacts.total[0], contacts.first[:total], contacts.second[:total] = total, first, second
    contacts.normal[:total] = (position[second] - position[first]) / apart[first, second][:, None]
    mobility = random.uniform(0.5, 2.0, len(position))
    contacts.bound[:total] = -crowding * random.uniform(0.0, 1.0, total)
    contacts.weight[:total] = 1.0 / (mobility[first] + mobility[second])
    velocity = -position + random.normal(size=position.shape)
    return contacts, velocity, mobility


def optimality(contacts, start, velocity, mobility):
    """The largest violations of optimality: approach, impulse on separating bodies, tension; and the velocities that
    impulses do not explain.
    """
    total = contacts.total[0]
    first, second, normal = contacts.first[:total], contacts.second[:total], contacts.normal[:total]
    impulse = contacts.impulse[:total]
    speed = ((velocity[second] - velocity[first]) * normal).sum(axis=1)
    expected = start.copy()
    np.add.at(expected, first, -(mobility[first] * impulse)[:, None] * normal)
    np.add.at(expected, second, (mobility[second] * impulse)[:, None] * normal)
    excess = speed - contacts.bound[:total]
    return max(-excess.min(), np.minimum(excess, impulse).max(), -impulse.min()), np.abs(expected - velocity).max()


@settings(max_examples=10 if COMPILED else 4)
@given(rings=st.integers(1, 2), seed=st.integers(0, 2**32 - 1), swept=st.integers(0, 3))
def test_the_velocities_of_a_braced_raft_are_the_nearest_ones_allowed(rings, seed, swept):
    contacts, start, mobility = raft(rings, seed)
    total = contacts.total[0]
    velocity = start.copy()
    contacts.impulse[:total] = 0.1 * swept  # from whatever impulses
    apply_impulses(contacts, contacts.impulse, velocity, mobility)
    assert impulse_solvers.solve_exactly(contacts, DiscMotion(velocity, mobility), np.arange(total), EXACT) == 1
    wrong, unexplained = optimality(contacts, start, velocity, mobility)
    assert wrong < 1e-12 * np.abs(start).max()
    assert unexplained < 1e-12 * np.abs(start).max()


@pytest.mark.long
@pytest.mark.compiled
@settings(max_examples=25)
@given(rings=st.integers(1, 3), seed=st.integers(0, 2**32 - 1))
def test_any_braced_raft_converges(rings, seed):
    contacts, start, mobility = raft(rings, seed)
    velocity = start.copy()
    sweeps = impulse_solvers.solve(contacts, DiscMotion(velocity, mobility), Tolerance(1e-9, 1e-7))
    assert sweeps <= impulse_solvers.MOST_SWEEPS
    wrong, unexplained = optimality(contacts, start, velocity, mobility)
    assert wrong <= 1e-7
    assert unexplained < 1e-12


@pytest.mark.compiled
@pytest.mark.parametrize("rings", [5, 6])
def test_a_large_braced_raft_is_solved_exactly(rings):
    """As in a trough whose barrier presses on a raft of 150 floats, where sweeps converged slowly in one of ten
    steps.
    """
    contacts, start, mobility = raft(rings, 7)
    velocity, total = start.copy(), int(contacts.total[0])
    assert total > 2 * len(start)
    exact = Tolerance(1e-12 * np.abs(start).max(), 0.0)
    assert impulse_solvers.solve_exactly(contacts, DiscMotion(velocity, mobility), np.arange(total), exact) == 1
    wrong, unexplained = optimality(contacts, start, velocity, mobility)
    assert wrong <= exact.target
    assert unexplained < 1e-12


def test_a_fixed_body_stays():
    contacts, start, mobility = raft(1, 3)
    total, velocity = contacts.total[0], start.copy()
    mobility[0], velocity[0] = 0.0, 0.0
    assert impulse_solvers.solve_exactly(contacts, DiscMotion(velocity, mobility), np.arange(total), EXACT) == 1
    assert velocity[0].tolist() == [0.0, 0.0]
    start[0] = 0.0
    assert optimality(contacts, start, velocity, mobility)[0] < 1e-12


@pytest.mark.parametrize("seed", range(4))
def test_an_island_is_solved_without_touching_the_others(seed):
    one, start, mobility = raft(1, seed)
    total, count = one.total[0], len(start)
    both = make_contacts(2 * total)
    both.total[0] = 2 * total
    for k in range(2):
        rows = slice(k * total, (k + 1) * total)
        both.first[rows], both.second[rows] = one.first[:total] + k * count, one.second[:total] + k * count
        for name in ("normal", "bound", "weight"):
            getattr(both, name)[rows] = getattr(one, name)[:total]
    starts, mobilities = np.concatenate([start, 2.0 * start]), np.concatenate([mobility, mobility])
    velocity = starts.copy()
    some = np.arange(total, 2 * total)
    assert impulse_solvers.solve_exactly(both, DiscMotion(velocity, mobilities), some, EXACT) == 1
    np.testing.assert_array_equal(velocity[:count], starts[:count])
    assert not both.impulse[:total].any()
    one.impulse[:total] = both.impulse[total : 2 * total]
    wrong, unexplained = optimality(one, starts[count:], velocity[count:], mobility)
    assert wrong < 1e-12
    assert unexplained < 1e-12


def test_what_cannot_be_solved_is_left_as_it_was():
    contacts, start, mobility = raft(1, 5)
    mobility[:] = 0.0  # nothing can move
    contacts.bound[: contacts.total[0]] = 1.0
    velocity = start.copy()
    every = np.arange(contacts.total[0])
    assert impulse_solvers.solve_exactly(contacts, DiscMotion(velocity, mobility), every, EXACT) == 0
    np.testing.assert_array_equal(velocity, start)
    assert not contacts.impulse.any()
