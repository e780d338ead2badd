"""Graphs with known symmetries, and clusters with published weights."""

import itertools
import math

import numpy as np
import pytest

from ecume.analysis.clusters import arrangement, frequencies, rigid_weight, topologies, topology_of, touching_pairs
from ecume.engine.placement import place_on_lattice
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame

LATTICE = np.array([[1.0, 0.0], [0.5, math.sqrt(0.75)]])
GROUND_STATES = {
    "triangle": [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (0, 2)],
    "parallelogram": [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)],
    "chevron": [(0, 0), (1, 0), (0, 1), (-1, 1), (-1, 0), (1, -1)],
}
"""The rigid clusters of six spheres with nine contacts, in steps along two directions of the lattice."""


def places(name):
    return np.array(GROUND_STATES[name]) @ LATTICE


def pairs_of(position):
    return touching_pairs(position, np.full(len(position), 0.5))


def frame_of(position, **numbers):
    return Frame(0.0, {"position": np.asarray(position), "radius": np.full(len(position), 0.5)}, numbers, {})


def test_a_label_does_not_depend_on_the_numbers_of_the_floats():
    dice = np.random.default_rng(2)
    for _ in range(20):
        position = place_on_lattice(12, 1.0, (0.0, 0.0))[dice.permutation(12)][:9]
        labels = set()
        for _ in range(4):
            order = dice.permutation(9)
            labels |= {tuple(sorted(topologies(frame_of(position[order])), key=str))}
        assert len(labels) == 1


def test_the_symmetry_number_is_the_number_of_permutations_that_keep_the_contacts():
    dice = np.random.default_rng(3)
    for _ in range(40):
        count = int(dice.integers(3, 7))
        every = list(itertools.combinations(range(count), 2))
        chosen = {pair for pair in every if dice.random() < 0.5}
        kept = sum(
            {tuple(sorted((order[i], order[j]))) for i, j in chosen} == chosen
            for order in itertools.permutations(range(count))
        )
        assert topology_of(sorted(chosen), count).symmetry == kept


def test_all_graphs_of_four_floats_have_labels_of_their_own():
    every = list(itertools.combinations(range(4), 2))
    graphs = [chosen for n in range(7) for chosen in itertools.combinations(every, n)]
    found = {topology_of(list(chosen), 4) for chosen in graphs}
    assert len(found) == 11
    assert sum(math.factorial(4) // each.symmetry for each in found) == len(graphs) == 64


def test_six_spheres_have_three_ground_states_with_published_symmetries_and_weights():
    found = {name: topology_of(pairs_of(places(name)), 6) for name in GROUND_STATES}
    assert {each.contacts for each in found.values()} == {9}
    assert {name: each.symmetry for name, each in found.items()} == {"triangle": 6, "parallelogram": 2, "chevron": 2}
    weights = np.array([rigid_weight(places(name), pairs_of(places(name))) for name in GROUND_STATES])
    # Each is a pair to which spheres are added at two contacts that meet at 60 degrees: only the symmetry differs.
    assert weights / weights[0] == pytest.approx([1.0, 3.0, 3.0])


def test_a_weight_does_not_depend_on_units_and_a_chain_has_none():
    position, pairs = places("chevron"), pairs_of(places("chevron"))
    assert rigid_weight(1e-6 * position, pairs) == pytest.approx(rigid_weight(position, pairs))
    with pytest.raises(BadInput, match="not rigid"):
        rigid_weight(position[:3] * [1.0, 0.0] + [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]], np.array([[0, 1], [1, 2]]))


def test_frames_have_topologies_also_across_the_border_of_a_periodic_cell():
    whole = places("triangle") + np.array([[2.0, 2.0]])
    lone = np.array([[8.0, 8.0]])
    inside = frame_of(np.concatenate([whole, lone]), box_width=10.0, box_height=10.0)
    across = frame_of(np.mod(np.concatenate([whole, lone]) - [2.7, 2.3], 10.0), box_width=10.0, box_height=10.0)
    assert arrangement(inside) == arrangement(across) == f"1-0-0+{topology_of(pairs_of(whole), 6).label}"
    assert frequencies([inside, across], 6) == {topology_of(pairs_of(whole), 6): 2}


def test_a_raft_that_is_too_large_for_a_label_is_refused():
    with pytest.raises(BadInput, match="100 floats; expected at most 64"):
        topologies(frame_of(place_on_lattice(100, 1.0, (0.0, 0.0))))
