"""Clusters in configurations that can be checked by hand."""

import numpy as np
import pytest

from ecume.analysis.clusters import TOLERANCE, touching_clusters, touching_pairs
from ecume.trajectories.frame import Frame


def frame_of(position, radius=1.0):
    position = np.asarray(position, dtype=float).reshape(-1, 2)
    return Frame(0.0, {"position": position, "radius": np.broadcast_to(radius, len(position)).astype(float)}, {}, {})


def chain(count, spacing=2.0):
    return [(spacing * k, 0.5) for k in range(count)]


def test_a_single_float_is_a_cluster_of_one():
    clusters = touching_clusters(frame_of([(3.0, 4.0)]))
    assert clusters.sizes.tolist() == [1]
    assert clusters.mean_size == 1.0


def test_an_empty_surface_has_no_clusters():
    clusters = touching_clusters(frame_of([]))
    assert clusters.sizes.tolist() == []
    assert (clusters.mean_size, clusters.largest) == (0.0, 0)


def test_floats_apart_are_clusters_of_their_own():
    clusters = touching_clusters(frame_of(chain(7, spacing=2.1)))
    assert clusters.sizes.tolist() == [1] * 7


def test_a_chain_that_touches_is_one_cluster():
    clusters = touching_clusters(frame_of(chain(50)))
    assert clusters.sizes.tolist() == [50]
    assert clusters.largest == 50


def test_a_chain_with_a_missing_link_is_two():
    links = chain(10)
    del links[4]
    clusters = touching_clusters(frame_of(links))
    assert sorted(clusters.sizes.tolist()) == [4, 5]
    assert clusters.mean_size == 4.5
    assert clusters.labels.tolist() == [clusters.labels[0]] * 4 + [clusters.labels[-1]] * 5


@pytest.mark.parametrize(("gap", "pairs"), [(0.99 * TOLERANCE, 1), (1.01 * TOLERANCE, 0), (-0.2, 1)])
def test_the_smaller_float_says_which_gap_still_touches(gap, pairs):
    frame = frame_of([(0.0, 0.0), (6.0 + gap, 0.0)], radius=[5.0, 1.0])
    assert len(touching_pairs(frame.arrays["position"], frame.arrays["radius"])) == pairs


def test_a_small_float_between_large_ones_joins_them():
    frame = frame_of([(0.0, 0.0), (5.5, 0.0), (11.0, 0.0)], radius=[5.0, 0.5, 5.0])
    assert touching_clusters(frame).sizes.tolist() == [3]


def test_a_periodic_chain_closes_over_the_edge_and_an_open_one_does_not():
    halves = [(0.5, 5.0), (9.5, 5.0)]
    assert touching_clusters(frame_of(halves, radius=0.5)).sizes.tolist() == [1, 1]
    assert touching_clusters(frame_of(halves, radius=0.5), period=(10.0, 10.0)).sizes.tolist() == [2]


def test_a_box_may_be_periodic_along_one_axis_only():
    across_x, across_y = [(0.5, 5.0), (9.5, 5.0)], [(5.0, -4.5), (5.0, 4.5)]
    assert touching_clusters(frame_of(across_x, radius=0.5), period=(10.0, 0.0)).sizes.tolist() == [2]
    assert touching_clusters(frame_of(across_y, radius=0.5), period=(10.0, 0.0)).sizes.tolist() == [1, 1]


def test_where_a_periodic_box_begins_does_not_matter():
    generator = np.random.default_rng(7)
    position = generator.uniform(0.0, 10.0, (60, 2))
    for shift in (0.0, 3.3, -1e-17, -25.0):
        clusters = touching_clusters(frame_of(position + shift, radius=0.5), period=(10.0, 10.0))
        assert sorted(clusters.sizes) == sorted(touching_clusters(frame_of(position, 0.5), period=(10.0, 10.0)).sizes)


def test_pairs_are_those_that_a_look_at_every_pair_finds():
    generator = np.random.default_rng(3)
    position, radius = generator.uniform(0.0, 20.0, (200, 2)), generator.uniform(0.1, 1.0, 200)
    found = {tuple(pair) for pair in touching_pairs(position, radius, tolerance=0.1)}
    wanted = {
        (i, j)
        for i in range(200)
        for j in range(i + 1, 200)
        if np.linalg.norm(position[i] - position[j]) - radius[i] - radius[j] <= 0.1 * min(radius[i], radius[j])
    }
    assert found == wanted
    assert len(found) > 50
