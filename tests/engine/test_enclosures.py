"""The walls of a raft: distances, normals, and the region that they enclose."""

import math

import numpy as np
import pytest

from ecume.engine.walls import box, disc, enclosed_by, no_walls, outside, polygon, surfaces, wall_count, wall_distance
from ecume.errors import BadInput

ANGLES = np.arange(6) * np.pi / 3
HEXAGON = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
SHAPES = {
    "disc": enclosed_by(disc((0.0, 0.0), 2.0)),
    "box": enclosed_by(box((-1.0, -2.0), (3.0, 1.0))),
    "hexagon": enclosed_by(polygon(HEXAGON)),
}


@pytest.mark.parametrize("name", SHAPES)
def test_the_normal_is_the_slope_of_the_distance(name):
    walls, step = SHAPES[name], 1e-6
    for x, y in [(0.5, 0.2), (-0.3, -0.9), (0.9, 0.4)]:
        for number in range(wall_count(walls)):
            _, normal_x, normal_y = wall_distance(walls, number, x, y)
            slope_x = wall_distance(walls, number, x + step, y)[0] - wall_distance(walls, number, x - step, y)[0]
            slope_y = wall_distance(walls, number, x, y + step)[0] - wall_distance(walls, number, x, y - step)[0]
            assert normal_x == pytest.approx(slope_x / (2 * step), abs=1e-8)
            assert normal_y == pytest.approx(slope_y / (2 * step), abs=1e-8)
            assert math.hypot(normal_x, normal_y) == pytest.approx(1.0, abs=1e-14)


def test_distances_of_a_box_are_those_to_its_four_sides():
    assert surfaces.clearances(SHAPES["box"], (0.5, -0.5)) == [1.5, 1.5, 2.5, 1.5]


def test_the_middle_of_a_disc_is_as_far_as_its_radius_and_has_a_direction():
    distance, normal_x, normal_y = wall_distance(SHAPES["disc"], 0, 0.0, 0.0)
    assert distance == 2.0
    assert math.hypot(normal_x, normal_y) == 1.0


def test_an_open_surface_has_no_walls():
    assert wall_count(no_walls()) == 0
    assert np.isinf(no_walls().disc_radius)
    assert np.isinf(surfaces.area(no_walls()))


@pytest.mark.parametrize(
    ("name", "area", "farthest"),
    [("disc", 4 * math.pi, 2.0), ("box", 12.0, math.sqrt(13.0)), ("hexagon", 1.5 * math.sqrt(3.0), 1.0)],
)
def test_the_region_inside_is_as_large_and_as_wide_as_its_shape(name, area, farthest):
    assert surfaces.area(SHAPES[name]) == pytest.approx(area, rel=1e-12)
    assert surfaces.farthest(SHAPES[name]) == pytest.approx(farthest, rel=1e-12)
    outline, (low, high) = surfaces.outline(SHAPES[name]), surfaces.bounds(SHAPES[name])
    assert outline.min(axis=0) == pytest.approx(low, abs=1e-12)
    assert outline.max(axis=0) == pytest.approx(high, abs=1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_each_point_of_the_outline_is_on_a_wall_and_inside_of_the_others(name):
    for point in surfaces.outline(SHAPES[name]):
        assert min(surfaces.clearances(SHAPES[name], point)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_a_shrunk_enclosure_is_where_centers_may_be(name):
    for point in surfaces.outline(surfaces.shrunk(SHAPES[name], 0.1)):
        assert min(surfaces.clearances(SHAPES[name], point)) == pytest.approx(0.1, abs=1e-12)


@pytest.mark.parametrize("shape", [disc((1.0, 0.0), 2.0), box((1.0, 1.0), (2.0, 2.0)), outside(box((-1, -1), (1, 1)))])
def test_what_does_not_enclose_the_origin_is_refused(shape):
    with pytest.raises(BadInput, match="enclosure"):
        enclosed_by(shape)
