"""Parts of space: inside, the way out, the nearest wall, and what a solid of that shape weighs."""

import numpy as np
import pytest

from ecume.engine.shapes import Ball, Box, Polygon, apart, lattice_in

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
    points = lattice_in(shape, spacing)
    assert len(points) * spacing ** points.shape[1] == pytest.approx(shape.volume(), rel=0.02)
    np.testing.assert_allclose(points.mean(axis=0), shape.middle(), atol=0.02)


@pytest.mark.parametrize("shape", [BOX, DISC, KITE, CUBE, SPHERE], ids=["box", "disc", "kite", "cuboid", "ball"])
def test_a_thin_shell_holds_the_surface_times_its_thickness(shape):
    low, high = shape.bounds()
    points = np.random.default_rng(2).uniform(low - 0.1, high + 0.1, (400_000, len(low)))
    shell = np.mean(np.abs(shape.nearest(points)[0]) < 0.02) * np.prod(high - low + 0.2)
    assert shell == pytest.approx(0.04 * shape.surface(), rel=0.03)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_a_fine_lattice_turns_as_heavily_as_the_shape(shape):
    points = lattice_in(shape, 0.02) - shape.middle()
    assert (points**2).sum(axis=1).mean() == pytest.approx(shape.inertia()[2], rel=0.02)


def test_a_carried_shape_is_the_same_elsewhere():
    way = np.array([3.0, -2.0])
    for shape in SHAPES.values():
        points = points_about(shape)
        assert np.array_equal(shape.inside(points), shape.carried(way).inside(points + way))


def test_a_lattice_starts_half_a_spacing_from_the_corner_and_rounding_costs_no_row():
    points = lattice_in(Box(np.zeros(2), np.array([0.3, 0.1 * 3])), 0.1)
    assert len(points) == 9
    np.testing.assert_allclose(points.min(axis=0), 0.05)


def test_points_apart_are_in_none_of_the_shapes():
    points = points_about(BOX)
    free = apart(points, [BOX, DISC])
    assert np.array_equal(free, ~BOX.inside(points) & ~DISC.inside(points))
