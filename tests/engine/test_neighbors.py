import numpy as np
import pytest
from scipy.spatial import cKDTree

from ecume._jit import numba
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
