"""Arrangements and paths with known measures."""

import numpy as np
import pytest
from matplotlib.path import Path

from ecume.analysis.clusters import touching_clusters
from ecume.analysis.series import tracks
from ecume.analysis.structure import (
    Region,
    approach,
    hexatic_order,
    mean_square_displacement,
    neighbor_pairs,
    pair_distribution,
    shapes_of,
)
from ecume.engine.placement import place_on_lattice
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame


def frame_of(position, radius=1.0):
    position = np.asarray(position, dtype=float)
    return Frame(0.0, {"position": position, "radius": np.full(len(position), radius)}, {}, {})


def turned(position, angle):
    return position @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


@pytest.mark.parametrize("angle", [0.0, 0.3])
def test_a_triangular_lattice_has_a_hexatic_order_of_one_however_it_is_turned(angle):
    psi = hexatic_order(frame_of(turned(place_on_lattice(61, 2.1, (3.0, 0.0)), angle)))
    assert psi == pytest.approx(psi[0], abs=1e-12)
    assert np.abs(psi) == pytest.approx(np.ones(61), abs=1e-12)


def test_the_phase_of_the_hexatic_order_turns_six_times_as_far_as_the_lattice():
    lattice = place_on_lattice(37, 2.0, (0.0, 0.0))
    before, after = (hexatic_order(frame_of(turned(lattice, angle)))[0] for angle in (0.0, 0.1))
    assert np.angle(after / before) == pytest.approx(0.6, abs=1e-12)


def test_a_square_lattice_has_no_hexatic_order_inside_and_a_lone_float_none():
    x, y = np.meshgrid(np.arange(9.0), np.arange(9.0))
    square = hexatic_order(frame_of(2.0 * np.stack([x.ravel(), y.ravel()], axis=1), 1.0)).reshape(9, 9)
    assert np.abs(square[1:-1, 1:-1]) == pytest.approx(np.zeros((7, 7)), abs=1e-12)
    assert hexatic_order(frame_of([[0.0, 0.0]])).tolist() == [0.0]


def test_neighbors_are_the_first_shell_only():
    pairs = neighbor_pairs(frame_of(place_on_lattice(7, 2.0, (0.0, 0.0))))
    assert len(pairs) == 12


@pytest.mark.parametrize("region", [Region(radius=2.0), Region(size=(3.0, 4.0))])
def test_random_points_have_a_pair_distribution_of_one_up_to_the_border(region):
    chance, frames = np.random.default_rng(5), []
    for _ in range(40):
        points = chance.uniform(-2.0, 2.0, (2500, 2))
        inside = np.hypot(*points.T) < region.radius if region.radius else np.abs(points[:, 0]) < 1.5
        frames.append(frame_of(points[inside][:600]))
    found = pair_distribution(frames, np.linspace(0.0, 2.5, 11), region)
    assert found == pytest.approx(np.ones(10), abs=0.02)


def test_a_lattice_has_peaks_where_its_shells_are():
    frame = frame_of(place_on_lattice(397, 1.0, (0.0, 0.0)), 0.5)
    edges = np.linspace(0.0, 2.2, 45)
    found = pair_distribution([frame], edges, Region(radius=11.0))
    middle = 0.5 * (edges[1:] + edges[:-1])
    peaks = middle[found > 1.0]
    for shell in (1.0, np.sqrt(3.0), 2.0):
        assert np.min(np.abs(peaks - shell)) < 0.03
    assert np.all(found[middle < 0.95] == 0.0)


def test_edges_beyond_the_region_are_refused():
    with pytest.raises(BadInput, match="width of the region"):
        pair_distribution([frame_of([[0.0, 0.0], [1.0, 0.0]])], np.array([0.0, 5.0]), Region(radius=2.0))
    with pytest.raises(BadInput, match=r"frames: got positions in 3 dimensions; expected 2"):
        pair_distribution([frame_of([[0.0, 0.0, 3.0]])], np.array([0.0, 1.0]), Region(radius=2.0))


def test_a_row_is_long_a_hexagon_is_round_and_both_have_their_radius_of_gyration():
    row = turned(np.stack([2.0 * np.arange(5.0), np.zeros(5)], axis=1), 0.4)
    hexagon = place_on_lattice(7, 2.0, (30.0, 0.0))
    frame = frame_of(np.concatenate([row, hexagon, [[-30.0, 0.0]]]))
    clusters = touching_clusters(frame)
    shapes = shapes_of(frame, clusters)
    first, second, lone = clusters.labels[[0, 5, 12]]
    assert shapes.gyration_radius[first] == pytest.approx(2.0 * np.sqrt(2.0))
    assert shapes.elongation[first] > 1e6
    assert shapes.angle[first] == pytest.approx(0.4)
    assert shapes.gyration_radius[second] == pytest.approx(2.0 * np.sqrt(6.0 / 7.0))
    assert shapes.elongation[second] == pytest.approx(1.0)
    assert shapes.center[second] == pytest.approx([30.0, 0.0])
    assert (shapes.gyration_radius[lone], shapes.elongation[lone]) == (0.0, 1.0)


def test_random_steps_add_up_as_squares_and_straight_ways_as_lengths():
    chance = np.random.default_rng(1)
    tracks = np.cumsum(chance.normal(0.0, 0.5, (400, 300, 2)), axis=0)
    lags = [0, 1, 4, 16]
    assert mean_square_displacement(tracks, lags) == pytest.approx(0.5 * np.array(lags), rel=0.02)
    with pytest.raises(BadInput, match=r"tracks: expected positions \(frames, particles, d\): .*tracks\(frames\)"):
        mean_square_displacement([frame_of([[0.0, 0.0]])], lags)
    straight = np.arange(10.0)[:, None, None] * np.array([[[3.0, 4.0]]])
    assert mean_square_displacement(straight, [1, 2]) == pytest.approx([25.0, 100.0])
    with pytest.raises(BadInput, match="from 0 to 9"):
        mean_square_displacement(straight, [10])


def test_an_approach_is_the_gap_of_two():
    tracks = np.array([[[0.0, 0.0], [5.0, 0.0]], [[1.0, 0.0], [4.0, 0.0]]])
    assert approach(tracks, np.array([1.0, 0.5]), (0, 1)) == pytest.approx([3.5, 1.5])


def corners(count, width=1.0):
    angle = 2.0 * np.pi * np.arange(count) / count
    return tuple(map(tuple, np.column_stack([width * np.cos(angle), np.sin(angle)]).tolist()))


@pytest.mark.parametrize("shape", [corners(3), corners(6), corners(5, 1.3)])
def test_a_polygon_shares_with_itself_moved_what_points_strewn_in_it_say(shape):
    region, chance = Region(corners=shape), np.random.default_rng(1)
    path = Path(shape)
    points = chance.uniform(-1.4, 1.4, (200000, 2))
    points = points[path.contains_points(points)]
    assert region.area == pytest.approx(len(points) / 200000 * 2.8**2, rel=0.01)
    angle = chance.uniform(0.0, 2.0 * np.pi, len(points))
    for shift in (0.3 * region.widest, 0.99 * region.widest):
        moved = points + shift * np.column_stack([np.cos(angle), np.sin(angle)])
        share = path.contains_points(moved).mean()
        assert region.overlap(np.array([shift]))[0] == pytest.approx(share * region.area, abs=0.01 * region.area)


CELL = {"box_width": 1.0, "box_height": 0.8}


def in_cell(position, radius=0.05):
    """A frame of a periodic cell."""
    position = np.asarray(position, dtype=float)
    return Frame(0.0, {"position": position, "radius": np.full(len(position), radius)}, CELL, {})


def test_points_strewn_in_a_periodic_cell_have_no_order():
    chance, edges = np.random.default_rng(3), np.linspace(0.0, 0.4, 9)
    frames = [in_cell(chance.random((400, 2)) * [1.0, 0.8]) for _ in range(6)]
    found = pair_distribution(frames, edges, Region(size=(1.0, 0.8), periodic=True))
    assert found == pytest.approx(1.0, abs=0.03)
    with pytest.raises(BadInput, match=r"at most 0\.4 m"):
        pair_distribution(frames, np.array([0.0, 0.5]), Region(size=(1.0, 0.8), periodic=True))


def test_order_and_shapes_do_not_depend_on_where_a_raft_lies_in_a_periodic_cell():
    raft = place_on_lattice(7, 0.1, (0.5, 0.4))
    across = np.mod(raft + np.array([0.5, 0.42]), [1.0, 0.8])
    inside, outside = in_cell(raft), in_cell(across)
    assert np.abs(hexatic_order(outside)) == pytest.approx(np.abs(hexatic_order(inside)))
    assert np.array_equal(neighbor_pairs(outside), neighbor_pairs(inside))
    one, other = (shapes_of(frame, touching_clusters(frame)) for frame in (inside, outside))
    assert touching_clusters(outside).sizes.tolist() == [7]
    assert other.gyration_radius == pytest.approx(one.gyration_radius)


def test_paths_do_not_jump_at_the_borders_of_a_periodic_cell():
    path = np.array([[0.9, 0.1]]) + np.linspace(0.0, 1.7, 12)[:, None] * [1.0, -0.5]
    found = tracks([in_cell(np.mod(place, [1.0, 0.8])[None]) for place in path])
    assert found[:, 0] == pytest.approx(path)
