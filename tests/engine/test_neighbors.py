import numba
import numpy as np
import pytest
from scipy.spatial import cKDTree

from ecume.engine.cells import periods_of
from ecume.engine.neighbors import THREADS_FROM, build, farthest_move, make_lists


def listed_pairs(lists, count):
    order, first, neighbor = lists.cells.order, lists.rows.first, lists.rows.neighbor
    return {(order[s], order[t]) for s in range(count) for t in neighbor[first[s] : first[s + 1]]}


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("count", [1, 2, 50, 200])
def test_lists_hold_exactly_the_pairs_within_reach_both_ways(dimension, count):
    position = np.random.default_rng(count).random((count, dimension)) * np.array([3.0, 1.0, 2.0])[:dimension]
    lists = make_lists(count, dimension, 100 * count)
    assert build(lists, position, 0.3)
    pairs = cKDTree(position).query_pairs(0.3)
    assert listed_pairs(lists, count) == pairs | {(j, i) for i, j in pairs}


def nearest_distances(position, periods):
    """The distance of each particle to the nearest image of each other, by brute force."""
    apart = position[:, None] - position
    apart -= periods[0] * np.round(apart * periods[1])
    return np.linalg.norm(apart, axis=2)


SIDES = [(3.0, 1.0, 2.0), (0.5, 0.7, 0.4), (0.65, 0.95, 1.3), (1.0, 0.0, 0.5), (0.0, 1.0, 0.0)]


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("sides", SIDES)
def test_lists_in_a_periodic_box_hold_each_pair_of_nearest_images_once(dimension, sides):
    periods = periods_of(sides[:dimension])
    position = 4.0 * np.random.default_rng(7).random((60, dimension)) - 2.0
    lists = make_lists(60, dimension, 6000, periods)
    assert build(lists, position, 0.3)
    near = nearest_distances(position, periods) < 0.3
    np.fill_diagonal(near, False)
    assert listed_pairs(lists, 60) == set(zip(*np.nonzero(near), strict=True))
    first, neighbor = lists.rows.first, lists.rows.neighbor
    assert first[60] == near.sum()
    for slot in range(60):
        row = neighbor[first[slot] : first[slot + 1]].astype(int)
        assert np.all(np.diff(row) > 0)
        assert lists.rows.later[slot] == first[slot] + np.sum(row < slot)


@pytest.mark.compiled
def test_threads_write_the_same_lists_as_one():
    count = THREADS_FROM + 100
    position = np.random.default_rng(3).random((count, 2))
    found = []
    for threads in (1, min(2, numba.config.NUMBA_NUM_THREADS)):
        numba.set_num_threads(threads)
        lists = make_lists(count, 2, 100 * count)
        assert build(lists, position, 0.05)
        found.append((lists.rows.first.copy(), lists.rows.neighbor[: lists.rows.first[-1]].copy()))
    assert np.array_equal(found[0][0], found[1][0])
    assert np.array_equal(found[0][1], found[1][1])
    assert listed_pairs(lists, count) == {
        pair for i, j in cKDTree(position).query_pairs(0.05) for pair in ((i, j), (j, i))
    }


def test_lists_without_room_say_so_and_hold_nothing():
    position = np.zeros((10, 2))
    lists = make_lists(10, 2, 16)
    assert not build(lists, position, 1.0)
    assert not lists.valid[0]
    assert lists.rows.first[-1] == 0


def test_the_farthest_move_is_that_of_the_fastest_and_nan_for_no_position():
    reference = np.zeros((3, 2))
    position = np.array([[0.0, 1.0], [3.0, 4.0], [0.0, 0.0]])
    assert farthest_move(position, reference) == 5.0
    position[1, 0] = np.nan
    assert np.isnan(farthest_move(position, reference))
