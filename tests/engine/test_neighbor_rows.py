"""Neighbor lists contain all particles within reach, and no others."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ecume._jit import FEW, use_threads
from ecume.engine.neighbor_rows import STRIDE, empty_lists, grid_around, neighbor_lists, sort_by_cell

NOBODY = (0, 0)


def rows(lists):
    return [set(row[:count].tolist()) for count, row in zip(lists.counts, padded(lists), strict=True)]


def padded(lists):
    return np.split(lists.neighbor[: lists.start[-1]], lists.start[1:-1])


def by_tree(position, centers, reach, passive=NOBODY):
    tree = cKDTree(position.T)
    found = tree.query_ball_point(position.T[:centers], reach)
    walls = range(*passive)
    return [{j for j in row if j != i and not (i in walls and j in walls)} for i, row in enumerate(found)]


MANY = FEW + 100


@pytest.mark.long
@pytest.mark.parametrize(
    ("dimension", "count"),
    [(2, 300), (3, 300), (2, MANY), pytest.param(3, MANY, marks=pytest.mark.compiled)],
)
def test_all_particles_within_reach_are_neighbors_and_no_others(dimension, count):
    position = np.random.default_rng(dimension).uniform(-3.0, 7.0, (dimension, count))
    reach = 10.0 * (12.0 / count) ** (1.0 / dimension)
    lists = neighbor_lists(position, NOBODY, reach, empty_lists(count))
    assert rows(lists) == by_tree(position, count, reach)
    assert 2.0 < lists.counts.mean() < 60.0


def test_walls_do_not_act_on_walls_and_images_have_no_rows():
    position = np.random.default_rng(5).uniform(0.0, 1.0, (3, 500))
    lists = neighbor_lists(position, (200, 350), 0.2, empty_lists(350))
    assert len(lists.counts) == 350
    found = rows(lists)
    assert found == by_tree(position, 350, 0.2, passive=(200, 350))
    assert max(max(row, default=0) for row in found) > 350


def test_rows_end_with_the_particle_itself_up_to_whole_vectors():
    position = np.random.default_rng(6).uniform(0.0, 1.0, (2, 200))
    lists = neighbor_lists(position, NOBODY, 0.1, empty_lists(200))
    for i, (count, row) in enumerate(zip(lists.counts, padded(lists), strict=True)):
        assert len(row) == -(-count // STRIDE) * STRIDE
        assert (row[count:] == i).all()


def test_particles_in_one_place_are_neighbors():
    position = np.full((3, 90), 0.25)
    position[:, 60:] += 10.0
    lists = neighbor_lists(position, NOBODY, 0.1, empty_lists(90))
    assert lists.counts.tolist() == [59] * 60 + [29] * 30


def test_some_far_away_do_not_make_the_cells_of_the_others_large():
    position = np.random.default_rng(7).uniform(0.0, 1.0, (3, 2000))
    position[:, 17], position[:, 18], position[0, 19] = 1e9, 1e9 + 0.05, -1e6
    grid = grid_around(position, 0.1)
    assert grid.edge[0] < 0.15
    assert np.prod(grid.shape) < 20 * 2000
    lists = neighbor_lists(position, NOBODY, 0.1, empty_lists(2000))
    assert rows(lists) == by_tree(position, 2000, 0.1)
    assert 18 in rows(lists)[17]


def test_the_grid_is_the_same_in_any_unit():
    position = np.random.default_rng(7).uniform(0.0, 1.0, (2, 500))
    position[0, 17] = 1e4
    shapes = [grid_around(unit * position, unit * 0.05).shape.tolist() for unit in (1.0, 1e-6, 1e6)]
    assert shapes[0] == shapes[1] == shapes[2]


def test_sparse_particles_have_few_cells():
    position = np.random.default_rng(8).uniform(0.0, 1e4, (3, 100))
    assert np.prod(grid_around(position, 1.0).shape) < 2000
    assert rows(neighbor_lists(position, NOBODY, 2e3, empty_lists(100))) == by_tree(position, 100, 2e3)


@pytest.mark.filterwarnings("ignore:invalid value")  # where loops are plain Python
@pytest.mark.parametrize("broken", [np.nan, np.inf, -np.inf])
def test_what_is_not_a_number_is_no_neighbor(broken):
    position = np.random.default_rng(9).uniform(0.0, 1.0, (2, 100))
    whole = rows(neighbor_lists(position[:, 1:], NOBODY, 0.2, empty_lists(99)))
    position[1, 0] = broken
    found = rows(neighbor_lists(position, NOBODY, 0.2, empty_lists(100)))
    assert found[0] == set()
    assert [{j - 1 for j in row} for row in found[1:]] == whole


def test_no_particles_have_no_neighbors():
    assert len(neighbor_lists(np.ones((2, 0)), NOBODY, 1.0, empty_lists(0)).counts) == 0
    lists = neighbor_lists(np.ones((2, 1)), NOBODY, 1.0, empty_lists(1))
    assert lists.counts.tolist() == [0]


@pytest.mark.long
def test_a_list_is_the_same_for_any_number_of_threads_and_lies_where_the_last_one_lay():
    position = np.random.default_rng(10).uniform(0.0, 1.0, (2, FEW + 500))
    before = use_threads(None)
    try:
        use_threads(1)
        one = neighbor_lists(position, NOBODY, 0.02, empty_lists(FEW + 500))
        kept = one.neighbor[: one.start[-1]].copy()
        use_threads(2)
        two = neighbor_lists(position, NOBODY, 0.02, one)
    finally:
        use_threads(before)
    assert two.neighbor is one.neighbor
    assert np.array_equal(kept, two.neighbor[: two.start[-1]])


def test_sorted_particles_keep_their_order_inside_a_cell():
    position = np.random.default_rng(11).uniform(0.0, 1.0, (2, 1000))
    sorted_particles = sort_by_cell(position, grid_around(position, 0.3))
    assert np.array_equal(sorted_particles.position, position[:, sorted_particles.order])
    for begin, end in zip(sorted_particles.start[:-1], sorted_particles.start[1:], strict=True):
        assert (np.diff(sorted_particles.order[begin:end].astype(int)) > 0).all()
