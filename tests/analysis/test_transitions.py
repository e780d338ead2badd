"""Markov chains whose currents and entropy production are known."""

import numpy as np
import pytest

from ecume.analysis.clusters import Clusters, cycles, entropy_production, mean_raft, transitions
from ecume.analysis.structure import fractal_dimension
from ecume.errors import BadInput


def chain(forward, backward, steps, seed=4):
    """States on a ring of three that change in one direction or the other."""
    chance = np.random.default_rng(seed).random(steps)
    moves = np.where(chance < forward, 1, np.where(chance < forward + backward, -1, 0))
    return np.mod(np.cumsum(moves), 3).tolist()


def test_transitions_are_counted_from_row_to_column():
    found = transitions([0, 1, 2, 0, 1, 1, 0])
    order = [found.states.index(name) for name in "012"]
    assert found.counts[np.ix_(order, order)].tolist() == [[0, 2, 0], [1, 1, 1], [1, 0, 0]]
    assert found.probabilities.sum(axis=1) == pytest.approx(np.ones(3))
    assert found.currents[order[0], order[1]] == 1


def test_a_driven_ring_produces_the_entropy_of_its_current_and_affinity():
    forward, backward, every = 0.3, 0.1, 0.5
    found = entropy_production([chain(forward, backward, 40_000)], every)
    expected = (forward - backward) * np.log(forward / backward) / every
    assert found.error < 0.03 * expected
    assert abs(found.value - expected) < 3.0 * found.error + 0.01 * expected
    first = cycles(transitions(chain(forward, backward, 40_000)))[0]
    assert first.states in [("0", "1", "2"), ("1", "2", "0"), ("2", "0", "1")]
    assert first.affinity == pytest.approx(3.0 * np.log(3.0), rel=0.05)


def test_a_ring_in_equilibrium_produces_no_entropy_on_average():
    """Without correction, the sum over the same counts is positive in every sequence."""
    found = [entropy_production([chain(0.2, 0.2, 2000, seed)], 1.0).value for seed in range(60)]
    assert abs(np.mean(found)) < 3.0 * np.std(found) / np.sqrt(len(found))
    assert np.mean(np.array(found) > 0.0) < 0.8


def test_too_short_a_sequence_is_refused():
    with pytest.raises(BadInput, match="the shortest of 20 states, for 8 blocks"):
        entropy_production([["a", "b"] * 10], 1.0)


def test_several_sequences_are_blocks_without_transitions_between_them():
    every = [[0] * 50 + [1] * 50] * 4
    found = entropy_production(every, 1.0, blocks=1)
    assert found.value == pytest.approx(np.log((3 + 0.5) / 0.5) / 99)
    assert found.error == 0.0


def test_the_fractal_dimension_of_rows_is_one_and_of_discs_two():
    sizes = np.array([1, 3, 9, 27, 81])
    rows, discs = np.sqrt((sizes**2 - 1.0) / 3.0), np.sqrt(sizes.astype(float))
    assert fractal_dimension(sizes, rows).value == pytest.approx(1.0, abs=0.02)
    assert fractal_dimension(sizes, discs).value == pytest.approx(2.0)
    with pytest.raises(BadInput, match="three sizes"):
        fractal_dimension(sizes[:3], discs[:3])


def test_the_mean_raft_counts_floats():
    assert mean_raft(Clusters(np.array([0, 0, 0, 1]), np.array([3, 1]))) == pytest.approx(2.5)
