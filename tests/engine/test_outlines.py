"""Distances of outlines, compared with a search over all their points."""

import math

import numpy as np
import pytest

from ecume.engine.outlines import Outlines, Stance, bodies_near, farthest_from_origin, turn_corners, wall_near
from ecume.engine.walls import box, disc, enclosed_by

SQUARE = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
NEEDLE = np.array([[-2.0, 0.0], [2.0, 0.0]])


def outlines(*bodies):
    """The outlines of ellipses (a, b), and of shapes (corners, edges, rounding)."""
    axes = [body if len(body) == 2 else (0.0, 0.0) for body in bodies]
    cornered = [body if len(body) == 3 else (np.zeros((0, 2)), np.zeros((0, 2), int), 0.0) for body in bodies]
    firsts = np.cumsum([0, *(len(corners) for corners, _, _ in cornered)])
    edges = [np.asarray(edges) + first for (_, edges, _), first in zip(cornered, firsts, strict=False)]
    return Outlines(
        np.array(axes),
        np.array([rounding for _, _, rounding in cornered]),
        np.concatenate([corners for corners, _, _ in cornered]),
        firsts.astype(np.int64),
        np.concatenate(edges).astype(np.int64).reshape(-1, 2),
        np.cumsum([0, *(len(edge) for edge in edges)]).astype(np.int64),
    )


def square(rounding=0.2):
    return SQUARE, [(k, (k + 1) % 4) for k in range(4)], rounding


def needle(rounding=0.3):
    return NEEDLE, [(0, 1)], rounding


def standing(shapes, places, angles):
    stance = Stance(np.array(places, float), np.array(angles, float), np.zeros_like(shapes.corner))
    turn_corners(shapes, stance)
    return stance


def near(shapes, places, angles, reach=10.0):
    found = np.zeros((200, 8))
    total = bodies_near(shapes, standing(shapes, places, angles), 0, 1, reach, found)
    return found[:total]


def points_of(body, count=4000):
    """Closely spaced points of an outline."""
    turn = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    if len(body) == 2:
        return circle * np.array(body)
    corners, edges, rounding = body
    along = np.linspace(0.0, 1.0, 60)[:, None]
    spine = np.concatenate([corners[k] + along * (corners[m] - corners[k]) for k, m in edges])
    return (spine[:, None] + rounding * circle[:: count // 150]).reshape(-1, 2)


def turned(points, angle):
    c, s = math.cos(angle), math.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


def gap_by_search(bodies, places, angles):
    from scipy.spatial import cKDTree

    one, other = (turned(points_of(b), a) + p for b, p, a in zip(bodies, np.array(places), angles, strict=True))
    return float(cKDTree(one).query(other)[0].min())


BODIES = {"ellipse": (2.0, 0.7), "slender": (3.0, 0.2), "disc": (1.1, 1.1), "square": square(), "needle": needle()}


@pytest.mark.long
@pytest.mark.parametrize("one", BODIES)
@pytest.mark.parametrize("other", BODIES)
def test_the_gap_is_the_least_distance_of_any_two_points(one, other):
    chance = np.random.default_rng(3)
    bodies = BODIES[one], BODIES[other]
    shapes = outlines(*bodies)
    for _ in range(6):
        places, angles = [(0.0, 0.0), tuple(chance.uniform(2.6, 4.5, 2))], chance.uniform(0.0, 7.0, 2)
        expected = gap_by_search(bodies, places, angles)
        if expected > 0.05:
            found = near(shapes, places, angles)
            assert found[:, 0].min() == pytest.approx(expected, abs=4e-3)


@pytest.mark.parametrize("one", BODIES)
@pytest.mark.parametrize("other", BODIES)
def test_nearest_points_lie_a_gap_apart_along_the_normal(one, other):
    """Impulses along this line conserve angular momentum."""
    chance = np.random.default_rng(5)
    shapes = outlines(BODIES[one], BODIES[other])
    for _ in range(4):
        places, angles = np.array([(0.0, 0.0), chance.uniform(1.5, 3.5, 2)]), chance.uniform(0.0, 7.0, 2)
        for gap, nx, ny, px, py, qx, qy, _ in near(shapes, places, angles):
            between = places[1] + (qx, qy) - places[0] - (px, py)
            assert math.hypot(nx, ny) == pytest.approx(1.0, abs=1e-12)
            assert between == pytest.approx(np.array([gap * nx, gap * ny]), abs=1e-12)


def test_ellipses_that_overlap_a_little_are_reported():
    shapes = outlines((2.0, 1.0), (2.0, 1.0))
    assert near(shapes, [(0, 0), (3.999, 0)], (0.0, 0.0))[0, 0] == pytest.approx(-1e-3, abs=1e-12)
    assert near(shapes, [(0, 0), (0, 1.999)], (0.0, 0.0))[0, 0] == pytest.approx(-1e-3, abs=1e-12)
    assert near(shapes, [(0, 0), (2.999, 0)], (0.0, 0.5 * math.pi))[0, 0] == pytest.approx(-1e-3, abs=1e-12)


def test_two_squares_side_by_side_touch_at_both_ends_of_the_shared_edge():
    found = near(outlines(square(0.1), square(0.1)), [(0, 0), (2.2, 0.5)], (0.0, 0.0), reach=0.05)
    assert found[:, 0] == pytest.approx(np.zeros(len(found)), abs=1e-12)
    assert sorted(found[:, 4].round(9)) == [-0.5, 1.0]


def test_a_needle_that_crosses_another_is_met_by_its_tip():
    found = near(outlines(needle(0.1), needle(0.1)), [(0, 0), (0.4, 2.3)], (0.0, 0.5 * math.pi), reach=0.2)
    assert len(found) == 1
    assert found[0, :3] == pytest.approx([0.1, 0.0, 1.0], abs=1e-12)
    assert found[0, 3] == pytest.approx(0.4)


@pytest.mark.parametrize("body", BODIES)
def test_the_gap_to_a_round_wall_and_to_a_straight_one(body):
    shapes, chance = outlines(BODIES[body]), np.random.default_rng(9)
    found = np.zeros((20, 8))
    for shape in (disc((0.0, 0.0), 60.0), box((-60.0, -60.0), (60.0, 60.0))):
        walls = enclosed_by(shape)
        for _ in range(4):
            place, angle = chance.uniform(30.0, 38.0, 2), chance.uniform(0.0, 7.0)
            stance, wall = standing(shapes, [place], [angle]), 0 if walls.disc_radius < np.inf else 2
            total = wall_near(shapes, stance, walls, (0, wall), 100.0, found)
            points = turned(points_of(BODIES[body]), angle) + place
            outside = np.hypot(*points.T) if wall == 0 else points[:, 0]
            assert found[:total, 0].min() == pytest.approx(60.0 - outside.max(), abs=3e-3)


def test_a_lone_ellipse_reaches_farthest_along_its_axis():
    assert farthest_from_origin(1.0, 0.0, (2.0, 0.5, 0.0)) == pytest.approx(0.0, abs=1e-12)
