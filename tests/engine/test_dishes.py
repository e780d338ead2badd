import math

import numpy as np
import pytest

from ecume.engine.walls.dishes import box, disc, no_walls, wall_count, wall_distance

SHAPES = {"disc": disc(2.0), "box": box((-1.0, -2.0), (3.0, 1.0))}


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
    distances = [wall_distance(SHAPES["box"], number, 0.5, -0.5)[0] for number in range(4)]
    assert distances == [1.5, 1.5, 2.5, 1.5]


def test_the_middle_of_a_disc_is_as_far_as_its_radius_and_has_a_direction():
    distance, normal_x, normal_y = wall_distance(disc(2.0), 0, 0.0, 0.0)
    assert distance == 2.0
    assert math.hypot(normal_x, normal_y) == 1.0


def test_an_open_surface_has_no_walls():
    assert wall_count(no_walls()) == 0
    assert np.isinf(no_walls().disc_radius)
