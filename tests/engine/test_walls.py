"""Walls: particles that fly between them, and the walls of a raft with the region that they enclose."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull, HalfspaceIntersection

from ecume.engine import walls
from ecume.engine.walls import (
    box,
    disc,
    enclosed_by,
    no_walls,
    outside,
    planes,
    polygon,
    surfaces,
    together,
    wall_count,
    wall_distance,
    wedge,
)
from ecume.errors import BadInput

ROOM = walls.box((0.0, 0.0), (1.0, 0.7))
FLOOR = walls.planes([(0.0, 0.0)], [(0.0, 1.0)])
FALL = (0.0, -9.81)


def folded(way, width):
    way = np.mod(way, 2.0 * width)
    return np.where(way > width, 2.0 * width - way, way)


def test_a_billiard_in_a_box_is_the_straight_line_folded_up():
    position, velocity, hits = walls.reflect([(0.3, 0.2)], [(1.234567, 0.87654321)], 1000.0, ROOM)
    assert position[0] == pytest.approx((0.867, 0.34321), abs=1e-9)
    assert hits[0] == 2486
    assert np.abs(velocity[0]) == pytest.approx((1.234567, 0.87654321), rel=1e-14)


def test_in_space_too_and_particles_do_not_disturb_one_another():
    rng = np.random.default_rng(3)
    start, speed = rng.uniform(0.0, (1.0, 0.7, 0.4), (20, 3)), rng.normal(size=(20, 3))
    position, _, _ = walls.reflect(start, speed, 80.0, walls.box((0.0, 0.0, 0.0), (1.0, 0.7, 0.4)))
    assert np.abs(position - folded(start + 80.0 * speed, np.array([1.0, 0.7, 0.4]))).max() < 1e-10


def test_planes_go_through_other_points_with_the_same_normals():
    slanted = walls.planes([(0.0, 0.0), (0.0, 4.0)], [(0.0, 2.0), (1.0, -1.0)])
    assert walls.nearest_points(slanted) == pytest.approx(np.array([[0.0, 0.0, 0.0], [-2.0, 2.0, 0.0]]))
    shifted = walls.through(slanted, np.array([[7.0, 1.0, 0.0], [1.0, 4.0, 0.0]]))
    assert walls.gaps(np.array([[3.0, 2.0]]), shifted) == pytest.approx(np.array([[1.0, 4.0 / math.sqrt(2.0)]]))


@pytest.mark.parametrize("unit", [1e-10, 1.0, 1e9])
def test_an_entrance_ends_at_its_edges_up_to_rounding_in_any_unit(unit):
    slanted = walls.planes([(0.0, 0.0)], [(1.0, -3.0)])
    door = walls.entrance(walls.opening(slanted, 0, (0.3 * unit, 0.1 * unit), (0.9 * unit, 0.3 * unit)), 0)
    ends = door.at(np.array([[0.0], [1.0], [-0.5], [1.5]]))
    assert door.holds(ends).tolist() == [True, True, False, False]


def test_the_second_surface_of_a_corner_is_met_within_the_same_step():
    traced = walls.trace([(0.9, 0.6)], [(1.0, 2.0)], 0.5, walls.box((0.0, 0.0), (1.0, 1.0)))
    assert traced.surface.tolist() == [2, 3]
    assert traced.time == pytest.approx([0.1, 0.2])
    assert traced.place == pytest.approx(np.array([[1.0, 0.8], [0.9, 1.0]]))
    assert traced.position[0] == pytest.approx((0.6, 0.4))


def test_both_surfaces_at_once_turn_a_particle_back_and_neither_turns_it_twice():
    position, velocity, hits = walls.reflect([(0.5, 0.5)], [(1.0, 1.0)], 1.0, walls.box((0.0, 0.0), (1.0, 1.0)))
    assert position[0] == pytest.approx((0.5, 0.5))
    assert velocity[0].tolist() == [-1.0, -1.0]
    assert hits[0] == 2


@pytest.mark.parametrize(("degrees", "most"), [(90, 2), (60, 3), (45, 4), (30, 6), (10, 18), (7, 26)])
def test_a_wedge_turns_a_particle_back_at_most_so_often_as_its_angle_goes_into_two_right_ones(degrees, most):
    rng = np.random.default_rng(degrees)
    angle, way = rng.uniform(-0.5, 0.5, 1000) * math.radians(degrees), rng.uniform(0.0, 2.0 * math.pi, 1000)
    start = np.column_stack([np.cos(angle), np.sin(angle)])
    wedge = walls.wedge((0.0, 0.0), (1.0, 0.0), math.radians(degrees))
    _, _, hits = walls.reflect(start, np.column_stack([np.cos(way), np.sin(way)]), 100.0, wedge)
    assert hits.max() == most == math.ceil(180 / degrees)


@pytest.mark.parametrize(("restitution", "total"), [(0.5, 1.3545709230), (0.8, 4.0637127689), (0.9, 8.5789491787)])
def test_a_bouncing_ball_hits_when_it_should_and_comes_to_rest_in_a_finite_time(restitution, total):
    traced = walls.trace([(0.0, 1.0)], [(0.3, 0.0)], 10.0, FLOOR, restitution, acceleration=FALL)
    first = math.sqrt(2.0 / 9.81)
    bounces = first * (1.0 + 2.0 * np.cumsum(restitution ** np.arange(1, 10)))
    assert traced.time[:10] == pytest.approx([first, *bounces], rel=1e-12)
    assert traced.time[-1] == pytest.approx(total, rel=1e-6)
    assert traced.position[0] == pytest.approx((3.0, 0.0), abs=1e-12)
    assert traced.velocity[0].tolist() == [0.3, 0.0]


def test_each_hit_takes_the_energy_that_the_coefficients_say():
    start, speed = np.array([(0.5, 0.5)]), np.array([(0.3, -2.0)])
    _, velocity, _ = walls.reflect(start, speed, 0.3, FLOOR, 0.6, 0.9)
    assert velocity[0] == pytest.approx((0.27, 1.2))
    _, velocity, hits = walls.reflect([(0.3, 0.2)], [(1.2, 0.9)], 20.0, ROOM, 0.95)
    crossings = walls.trace([(0.3, 0.2)], [(1.2, 0.9)], 20.0, ROOM, 0.95).surface
    sideways, upright = int((crossings % 2 == 0).sum()), int((crossings % 2 == 1).sum())
    assert sideways + upright == hits[0]
    assert np.abs(velocity[0]) == pytest.approx((1.2 * 0.95**sideways, 0.9 * 0.95**upright), rel=1e-12)


def test_flown_backwards_all_return_where_there_is_no_loss():
    rng = np.random.default_rng(5)
    heptagon = walls.polygon([(math.cos(a), math.sin(a)) for a in 2.0 * math.pi * np.arange(7) / 7])
    start, speed = rng.uniform(-0.5, 0.5, (40, 2)), rng.normal(size=(40, 2))
    there, back, _ = walls.reflect(start, speed, 5.0, heptagon, acceleration=(0.0, -1.0))
    again, opposite, _ = walls.reflect(there, -back, 5.0, heptagon, acceleration=(0.0, -1.0))
    assert np.abs(again - start).max() < 1e-8
    assert np.abs(opposite + speed).max() < 1e-8


def test_between_parallel_planes_each_flight_takes_longer_by_the_restitution():
    gap = walls.planes([(0.0, 0.0), (0.0, 1.0)], [(0.0, 1.0), (0.0, -1.0)])
    traced = walls.trace([(0.0, 0.5)], [(0.0, 1.0)], 40.0, gap, 0.8)
    flights = 0.8 ** -np.arange(1.0, len(traced.time))
    assert traced.time == pytest.approx(0.5 + np.concatenate([[0.0], np.cumsum(flights)]), rel=1e-12)


def test_in_a_circle_all_chords_are_alike_and_the_angular_momentum_stays():
    start, speed = np.array([(0.3, 0.1)]), np.array([(0.7, 0.6)])
    traced = walls.trace(start, speed, 3000.0, walls.disc((0.0, 0.0), 1.0))
    spin = start[0, 0] * speed[0, 1] - start[0, 1] * speed[0, 0]
    turn = 2.0 * math.acos(spin / math.hypot(0.7, 0.6))
    angle = np.arctan2(traced.place[:, 1], traced.place[:, 0])
    expected = angle[0] + turn * np.arange(len(angle))
    assert len(angle) > 1000
    assert np.abs(np.mod(angle - expected + math.pi, 2.0 * math.pi) - math.pi).max() < 1e-9
    x, v = traced.position[0], traced.velocity[0]
    assert x[0] * v[1] - x[1] * v[0] == pytest.approx(spin, rel=1e-11)


def test_a_lossless_ball_in_a_box_keeps_its_energy_and_its_parabola():
    start, speed, time = np.array([(0.3, 0.5)]), np.array([(1.1, 0.0)]), 40.0
    position, velocity, _ = walls.reflect(start, speed, time, walls.box((0.0, 0.0), (1.0, 9.0)), acceleration=FALL)
    energy = 0.5 * (velocity**2).sum() + 9.81 * position[0, 1]
    assert energy == pytest.approx(0.5 * 1.21 + 9.81 * 0.5, rel=1e-12)
    period = 2.0 * math.sqrt(1.0 / 9.81)
    since = math.remainder(time, period)
    assert position[0, 1] == pytest.approx(0.5 - 0.5 * 9.81 * since**2, abs=1e-11)


def test_a_moving_wall_gives_twice_its_speed():
    paddle = walls.planes([(0.0, 0.0)], [(1.0, 0.0)], velocities=[(0.5, 0.0)])
    position, velocity, hits = walls.reflect([(1.0, 0.0)], [(-1.0, 0.2)], 1.0, paddle)
    assert velocity[0] == pytest.approx((2.0, 0.2))
    assert position[0] == pytest.approx((1.0 / 3.0 + 2.0 / 3.0, 0.2))
    assert hits[0] == 1
    assert walls.gaps(position, walls.moved(paddle, 1.0))[0, 0] == pytest.approx(0.5)


def test_a_ball_touches_before_its_center_does():
    position, _, _ = walls.reflect([(0.5, 0.5)], [(0.0, -1.0)], 0.5, FLOOR, radius=0.1)
    assert position[0] == pytest.approx((0.5, 0.2))
    position, _, _ = walls.reflect([(0.0, 0.0)], [(1.0, 0.0)], 1.0, walls.disc((0.0, 0.0), 1.0), radius=[0.2])
    assert position[0] == pytest.approx((0.6, 0.0))


def test_no_particle_flies_through_a_thin_obstacle():
    room = walls.together(walls.box((-1.0, -1.0), (1.0, 1.0)), walls.outside(walls.box((-1e-3, -0.5), (1e-3, 0.5))))
    traced = walls.trace([(-0.5, 0.0), (-0.5, 0.7)], [(1.0, 0.0), (1.0, 0.0)], 1.0, room)
    assert traced.position == pytest.approx(np.array([[-0.502, 0.0], [0.5, 0.7]]))
    assert traced.surface.tolist() == [4]


def test_what_slides_over_an_obstacles_edge_falls_off():
    table = walls.together(walls.box((-2.0, -2.0), (2.0, 2.0)), walls.outside(walls.box((-0.5, -0.5), (0.5, 0.5))))
    traced = walls.trace([(-0.4, 1.0)], [(0.2, 0.0)], 7.0, table, 0.0, acceleration=(0.0, -1.0))
    assert traced.surface.tolist() == [7, 1]
    assert traced.time == pytest.approx([1.0, 4.5 + math.sqrt(5.0)])
    assert traced.position[0] == pytest.approx((1.0, -2.0))


def test_a_particle_without_restitution_slides_down_a_round_dish_like_a_pendulum():
    dish, angle = walls.disc((0.0, 0.0), 1.0), 0.1
    start = [(math.sin(angle), -math.cos(angle))]
    position, _, _ = walls.reflect(start, [(0.0, 0.0)], math.pi / math.sqrt(9.81), dish, 0.0, acceleration=FALL)
    assert np.hypot(*position[0]) == pytest.approx(1.0, abs=1e-12)
    # Half a swing later, but for the pendulum's slight delay.
    assert position[0, 0] == pytest.approx(-math.sin(angle), abs=1e-4)


def test_who_meets_an_opening_has_left_and_is_not_turned_back():
    room = walls.opening(ROOM, 1, (0.4, 0.0), (0.6, 0.0))
    traced = walls.trace([(0.5, 0.5), (0.2, 0.5)], [(0.0, -1.0), (0.0, -1.0)], 1.0, room)
    assert traced.left.tolist() == [0, -1]
    assert traced.position == pytest.approx(np.array([[0.5, 0.0], [0.2, 0.5]]))
    assert traced.hits.tolist() == [0, 1]


@pytest.mark.compiled
def test_no_particle_is_ever_outside_however_often_corners_are_met():
    rng = np.random.default_rng(8)
    spheres = walls.outside(walls.disc((-1.0, -1.0), 0.5))
    triangle = walls.outside(walls.polygon([(0.0, 0.0), (1.0, 0.2), (0.3, 0.9)]))
    room = walls.together(walls.polygon([(-2.0, -2.0), (2.0, -1.5), (1.0, 2.0)]), spheres, triangle)
    spread = rng.uniform(-2.0, 2.0, (4000, 2))
    everyone = spread[walls.clearance(spread, room)[0] > 0.02]
    for restitution, fall in ((0.0, (0.0, -3.0)), (0.0, (0.0, 0.0)), (0.7, (0.5, -3.0))):
        position, velocity = everyone, rng.normal(size=everyone.shape)
        for _ in range(5):
            velocity = velocity + rng.normal(size=velocity.shape)
            position, velocity, _ = walls.reflect(position, velocity, 0.5, room, restitution, acceleration=fall)
            assert walls.clearance(position, room)[0].min() > -1e-14


def test_a_particle_that_starts_outside_is_named():
    with pytest.raises(BadInput, match=r"particle 1 at \(0.5, -0.25\) starts outside: 0.25 m beyond plane 1"):
        walls.reflect([(0.5, 0.5), (0.5, -0.25)], np.zeros((2, 2)), 1.0, ROOM)
    with pytest.raises(BadInput, match=r"particle 0 .* beyond circle 0"):
        walls.reflect([(0.0, 0.0)], [(1.0, 0.0)], 1.0, walls.outside(walls.disc((0.1, 0.0), 1.0)))


@pytest.mark.compiled
def test_more_bounces_than_a_step_may_have_are_flagged_not_hidden():
    narrow = walls.box((0.0, 0.0), (1e-6, 1.0))
    with pytest.raises(BadInput, match="particle 0 met walls more than 10000 times"):
        walls.reflect([(5e-7, 0.5)], [(1.0, 0.0)], 1.0, narrow)
    traced = walls.trace([(5e-7, 0.5)], [(1.0, 0.0)], 1.0, narrow)
    assert traced.capped[0]
    assert 0.0 <= traced.position[0, 0] <= 1e-6


@pytest.mark.parametrize(
    ("made", "output"),
    [
        (lambda: walls.polygon([(0, 0), (2, 0), (1, 0.2), (1, 2)]), "not convex at vertex 2"),
        (lambda: walls.polygon([(0, 0), (2, 0), (1, 2), (0, 0)]), r"vertex 3 \(0.0, 0.0\) is also the next"),
        (lambda: walls.box((0, 0), (1, -1)), "the lower one first"),
        (lambda: walls.disc((0, 0), 0.0), "expected one above 0"),
        (lambda: walls.planes([(0, 0)], [(0, 0)]), "has no direction"),
        (lambda: walls.opening(ROOM, 4, (0, 0), (1, 0)), "there are 4"),
        (lambda: walls.opening(ROOM, 1, (1, 0.4), (1, 0.6)), "no part in plane 1"),
        (lambda: walls.opening(walls.disc((0, 0), 1.0), 0, (0, 0), (0.5, 0.5)), "no part in circle 0"),
        (lambda: walls.reflect([(0.5, 0.5)], [(1, 0)], -1.0, ROOM), "expected zero or more seconds"),
        (lambda: walls.trace([(0.5, 0.5)], [(1, 0)], math.inf, ROOM), "expected zero or more seconds"),
        (lambda: walls.reflect([(0.5, 0.5)], [("fast", 0)], 1.0, ROOM), "velocity: .* expected numbers"),
        (lambda: walls.reflect([(0.5, 0.5)], [(1, 0)], 1.0, "box"), "walls: got str"),
        (lambda: walls.reflect([(0.5, 0.5)], [(0, 0)], 1.0, ROOM, restitution=1.5), "from 0 to 1"),
        (lambda: walls.reflect([(0.5, 0.5, 0.5)], [(0, 0, 0)], 1.0, ROOM), "the walls have 2"),
        (lambda: walls.reflect([(0.5, math.nan)], [(0, 0)], 1.0, ROOM), "expected finite numbers"),
    ],
)
def test_what_makes_no_walls_is_refused_with_the_way_out(made, output):
    with pytest.raises(BadInput, match=output):
        made()


def test_a_polyhedron_has_one_plane_a_face():
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 2)]
    assert len(walls.polyhedron(corners).kind) == 6
    position, _, _ = walls.reflect([(0.5, 0.5, 0.5)], [(0.0, 0.0, 3.0)], 1.0, walls.polyhedron(corners))
    assert position[0] == pytest.approx((0.5, 0.5, 0.5))


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


@pytest.mark.parametrize("shape", [wedge((-1.0, 0.0), (1.0, 0.0), 0.5), planes([(0, -1), (0, 1)], [(0, 1), (0, -1)])])
def test_an_open_shape_is_refused(shape):
    with pytest.raises(BadInput, match="enclosure: the shape is open"):
        enclosed_by(shape)


DIAMOND = 3.0 * np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])


@pytest.mark.parametrize(
    ("further", "count"),
    [(polygon(DIAMOND), 4), (box((-2, -2), (2, 2)), 4), (box((-1, -1), (1, 1)), 4), (disc((0, 0), 1.5), 4),
     (box((-1, -1), (0.5, 1)), 4), (disc((0, 0), 1.2), 5)],
)  # fmt: skip
def test_surfaces_that_the_inside_does_not_reach_are_no_walls(further, count):
    found = enclosed_by(together(box((-1, -1), (1, 1)), further))
    assert wall_count(found) == count
    if found.disc_radius == math.inf:
        assert surfaces.area(found) == pytest.approx(3.0 if np.any(found.offset == -0.5) else 4.0, rel=1e-12)


def test_a_shrunk_enclosure_loses_the_sides_that_vanish():
    cut = np.array([(1.0, 0.9), (0.9, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])
    assert wall_count(enclosed_by(polygon(cut))) == 5
    small = surfaces.shrunk(enclosed_by(polygon(cut)), 0.5)
    assert wall_count(small) == 4
    assert surfaces.area(small) == pytest.approx(1.0, rel=1e-12)


lines = st.tuples(st.floats(0.0, 6.28), st.floats(0.1, 3.0))


def half_planes(given):
    """Surfaces around the origin, each by the direction of its normal and its distance."""
    normal = np.array([(math.cos(angle), math.sin(angle)) for angle, _ in given])
    return planes([-away * each for each, (_, away) in zip(normal, given, strict=True)], normal)


@given(st.lists(lines, min_size=3, max_size=9))
@settings(max_examples=60, deadline=None)
def test_an_intersection_of_half_planes_is_open_or_has_its_area(given_lines):
    angles = np.sort([angle for angle, _ in given_lines])
    gap = np.diff(np.append(angles, angles[0] + 2 * math.pi)).max()
    assume(abs(gap - math.pi) > 1e-3)
    shape = half_planes(given_lines)
    if gap > math.pi:
        with pytest.raises(BadInput, match="open"):
            enclosed_by(shape)
        return
    found = enclosed_by(shape)
    inside = HalfspaceIntersection(np.column_stack([-shape.place[:, :2], shape.size]), np.zeros(2))
    hull = ConvexHull(inside.intersections, qhull_options="QJ")
    assert surfaces.area(found) == pytest.approx(hull.volume, rel=1e-6)
    assert surfaces.farthest(found) == pytest.approx(np.hypot(*inside.intersections.T).max(), rel=1e-6)
    assert np.array(surfaces.bounds(found)) == pytest.approx(np.array([hull.min_bound, hull.max_bound]), abs=1e-6)


@pytest.mark.long
@given(st.lists(st.tuples(st.floats(0.0, 6.28), st.floats(0.3, 2.0)), min_size=1, max_size=6), st.floats(0.5, 2.0))
@settings(max_examples=60, deadline=None)
def test_a_circle_cut_by_half_planes_has_its_area(given_lines, radius):
    found = enclosed_by(together(disc((0.0, 0.0), radius), half_planes(given_lines)))
    # Of a region around the origin: the mean square of the distance of its edge, over all directions.
    angle = np.linspace(0.0, 2.0 * math.pi, 100001)[:-1]
    edge = np.full_like(angle, radius)
    for way, away in given_lines:
        outward = -np.cos(angle - way)
        edge = np.minimum(edge, np.where(outward > 1e-9, away / np.maximum(outward, 1e-9), np.inf))
    assert surfaces.area(found) == pytest.approx(math.pi * np.mean(edge**2), rel=1e-4)
    assert surfaces.farthest(found) == pytest.approx(edge.max(), rel=1e-3)
    reach = edge[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    assert np.array(surfaces.bounds(found)) == pytest.approx(np.array([reach.min(0), reach.max(0)]), abs=2e-3 * radius)
    outline = surfaces.outline(found)
    for point in outline:
        assert min(surfaces.clearances(found, point)) == pytest.approx(0.0, abs=1e-9)
