"""Parts of space: points inside, distances to the boundary, and the mass properties of solids."""

import numpy as np
import pytest

from ecume.engine import shapes
from ecume.engine.shapes import Ball, Box, Polygon, apart, covered_volume, fitted_cells

BOX = Box(np.array([-1.0, 0.5]), np.array([2.0, 1.5]))
DISC = Ball(np.array([0.3, -0.2]), 1.2)
KITE = Polygon(np.array([[0.0, 0.0], [2.0, 0.4], [2.5, 2.0], [0.2, 1.1]]))
SHAPES = {"box": BOX, "disc": DISC, "kite": KITE}
CUBE = Box(np.zeros(3), np.array([1.0, 2.0, 0.5]))
SPHERE = Ball(np.array([1.0, 2.0, 3.0]), 0.7)


def points_about(shape, count=400):
    low, high = shape.bounds()
    return np.random.default_rng(1).uniform(low - 0.5, high + 0.5, (count, len(low)))


@pytest.mark.parametrize("shape", [BOX, DISC, KITE, CUBE, SPHERE], ids=["box", "disc", "kite", "cuboid", "ball"])
def test_what_is_inside_has_a_negative_gap_and_moves_out_along_the_normal(shape):
    points = points_about(shape)
    gap, normal = shape.nearest(points)
    assert np.array_equal(shape.inside(points), gap < 0.0)
    assert 0.1 < np.mean(gap < 0.0) < 0.9
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0)
    on_surface = points - gap[:, None] * normal
    np.testing.assert_allclose(shape.nearest(on_surface)[0], 0.0, atol=1e-9)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_a_ray_leaves_where_the_way_out_ends(shape):
    points = points_about(shape)
    points = points[shape.inside(points)]
    direction = np.array([0.6, 0.8])
    way = shape.way_out(points, direction)
    assert shape.inside(points + (way - 1e-6)[:, None] * direction).all()
    assert not shape.inside(points + (way + 1e-6)[:, None] * direction).any()


@pytest.mark.parametrize("shape", [BOX, DISC, KITE, CUBE, SPHERE], ids=["box", "disc", "kite", "cuboid", "ball"])
def test_a_fine_lattice_has_the_shapes_volume_and_middle(shape):
    spacing = 0.02 if len(shape.middle()) == 2 else 0.05
    cells = shape.cells(spacing)
    assert shape.inside(cells.centers).all()
    assert cells.volumes.sum() == pytest.approx(shape.volume(), rel=1e-12)
    np.testing.assert_allclose(cells.volumes, spacing ** len(shape.middle()), rtol=0.06)
    np.testing.assert_allclose(cells.centers.mean(axis=0), shape.middle(), atol=0.02)


@pytest.mark.parametrize("shape", [BOX, DISC, KITE, CUBE, SPHERE], ids=["box", "disc", "kite", "cuboid", "ball"])
def test_a_thin_shell_holds_the_surface_times_its_thickness(shape):
    low, high = shape.bounds()
    points = np.random.default_rng(2).uniform(low - 0.1, high + 0.1, (400_000, len(low)))
    shell = np.mean(np.abs(shape.nearest(points)[0]) < 0.02) * np.prod(high - low + 0.2)
    assert shell == pytest.approx(0.04 * shape.surface(), rel=0.03)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_a_fine_lattice_turns_as_heavily_as_the_shape(shape):
    points = shape.cells(0.02).centers - shape.middle()
    assert (points**2).sum(axis=1).mean() == pytest.approx(shape.inertia()[2], rel=0.02)


def test_a_carried_shape_is_the_same_elsewhere():
    way = np.array([3.0, -2.0])
    for shape in SHAPES.values():
        points = points_about(shape)
        assert np.array_equal(shape.inside(points), shape.carried(way).inside(points + way))


def test_a_lattice_starts_half_a_spacing_from_the_corner_and_rounding_costs_no_row():
    cells = Box(np.zeros(2), np.array([0.3, 0.1 * 3])).cells(0.1)
    assert len(cells.centers) == 9
    np.testing.assert_allclose(cells.centers.min(axis=0), 0.05)
    assert set(cells.widths.ravel()) == {0.1}  # rounding in the corners does not change it


def test_cells_end_at_faces_but_are_never_narrower_than_half_a_spacing():
    faces = np.array([[0.37, 0.01], [0.61, 0.52]])
    cells = fitted_cells(np.zeros(2), np.ones(2), 0.1, faces)
    edges = cells.centers + 0.5 * cells.widths
    for axis, ends in ((0, (0.37, 0.61, 1.0)), (1, (0.52, 1.0))):
        assert all(np.isclose(edges[:, axis], end, rtol=0, atol=1e-12).any() for end in ends)
        assert 0.05 <= cells.widths[:, axis].min() <= cells.widths[:, axis].max() <= 0.15
    assert not np.isclose(edges[:, 1], 0.01).any()
    assert cells.volumes.sum() == pytest.approx(1.0, rel=1e-13)


def test_what_others_cover_is_counted_once_and_exactly_for_boxes():
    rng = np.random.default_rng(3)
    unit = Box(np.zeros(2), np.ones(2))
    for _ in range(20):
        lows = rng.uniform(-0.2, 0.8, (3, 2))
        boxes = [Box(low, low + rng.uniform(0.1, 0.6, 2)) for low in lows]
        ends = np.unique(np.clip(np.concatenate([box.faces() for box in boxes] + [unit.faces()]), 0.0, 1.0), axis=None)
        middles = 0.5 * (ends[1:] + ends[:-1])
        points = np.array([(x, y) for x in middles for y in middles])
        areas = np.outer(np.diff(ends), np.diff(ends)).ravel()
        assert covered_volume(unit, boxes) == pytest.approx(areas[~apart(points, boxes)].sum(), rel=1e-12)


def test_what_a_polygon_or_a_disc_covers_follows_from_formulas():
    unit = Box(np.zeros(2), np.ones(2))
    wedge = Polygon(np.array([[0.5, -0.5], [1.5, 0.5], [0.5, 0.5]]))
    assert covered_volume(unit, [wedge]) == pytest.approx(0.5 * 0.5 - 0.0, rel=1e-12)
    assert covered_volume(unit, [Ball(np.array([0.5, 0.5]), 0.3)]) == pytest.approx(np.pi * 0.09, rel=1e-12)
    half = covered_volume(unit, [Ball(np.array([0.5, 0.0]), 0.3)])
    assert half == pytest.approx(0.5 * np.pi * 0.09, rel=1e-3)
    both = covered_volume(unit, [Ball(np.array([0.5, 0.5]), 0.3), Ball(np.array([0.5, 0.5]), 0.2)])
    assert both == pytest.approx(np.pi * 0.09, rel=1e-12)


def test_points_apart_are_in_none_of_the_shapes():
    points = points_about(BOX)
    free = apart(points, [BOX, DISC])
    assert np.array_equal(free, ~BOX.inside(points) & ~DISC.inside(points))


def star(rng, count):
    """A simple polygon of random radii."""
    angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, count))
    return rng.uniform(0.3, 1.0, count)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


@pytest.mark.parametrize("seed", range(5))
def test_points_are_inside_a_polygon_where_the_angles_of_its_corners_add_up_to_a_turn(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    corners, points = star(rng, 40), rng.uniform(-1.0, 1.0, (500, 2))
    away = (corners[None] - points[:, None]) @ np.array([1.0, 1.0j])
    turns = np.angle(np.roll(away, -1, axis=1) / away).sum(axis=1) / (2.0 * np.pi)
    polygon = Polygon(corners)
    expected = polygon.inside(points), *polygon.nearest(points), polygon.way_out(points, np.array([0.6, 0.8]))
    assert expected[0].tolist() == (np.abs(turns) > 0.5).tolist()
    monkeypatch.setattr(shapes, "MOST_CROSSINGS", 100)
    found = polygon.inside(points), *polygon.nearest(points), polygon.way_out(points, np.array([0.6, 0.8]))
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, other)


def test_an_outline_of_many_corners_costs_what_its_rays_meet():
    """20,000 corners and 250,000 points would be 40 GB as a table."""
    angle = np.linspace(0.0, 2.0 * np.pi, 20_000, endpoint=False)
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (250_000, 2))
    inside = Polygon(np.stack([np.cos(angle), np.sin(angle)], axis=1)).inside(points)
    assert (inside == (np.hypot(*points.T) < 1.0)).mean() > 0.99999
