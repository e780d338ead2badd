"""Closed meshes as solids: distances, normals, moments, pieces of the surface."""

import numpy as np
import pytest
from tests.models.sph.test_sources import ball

from ecume.engine.nearest_triangles import nearest_triangles
from ecume.engine.outlines import Mesh, cylinder_of, hull_of, outward
from ecume.engine.shapes import Ball, Box, Hollow, Polygon
from ecume.errors import BadInput


def box_mesh(size):
    return hull_of(np.array([[x, y, z] for x in (0.0, size[0]) for y in (0.0, size[1]) for z in (0.0, size[2])]))


def corner_mesh():
    """An L-shaped prism: a block of 3 x 3 x 1 without its upper right quarter of 2 x 2, whose shells share no face."""
    outline = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], float)
    flat = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    low, high = (np.column_stack([outline, np.full(6, z)]) for z in (0.0, 1.0))
    faces = [low[list(t)][::-1] for t in flat] + [high[list(t)] for t in flat]
    for k in range(6):
        a, b, c, d = low[k], low[(k + 1) % 6], high[(k + 1) % 6], high[k]
        faces += [np.array([a, b, c]), np.array([a, c, d])]
    return Mesh(np.array(faces))


@pytest.mark.long
def test_the_nearest_of_random_triangles_is_that_of_a_search_through_all():
    dice = np.random.default_rng(3)
    triangles = dice.uniform(-1.0, 1.0, (60, 1, 3)) + 0.3 * dice.normal(size=(60, 3, 3))
    points = dice.uniform(-2.0, 2.0, (80, 3))
    which, place = nearest_triangles(triangles, points)
    shares = dice.dirichlet([1.0, 1.0, 1.0], 4000)
    samples = np.einsum("sc,tcd->tsd", shares, triangles)
    for point, k, spot in zip(points, which, place, strict=True):
        gaps = np.linalg.norm(samples - point, axis=2)
        found = np.linalg.norm(spot - point)
        assert found <= gaps.min() + 1e-12
        assert found == pytest.approx(gaps[k].min(), abs=0.03)


def test_a_box_of_triangles_is_a_box():
    size = np.array([1.0, 2.0, 3.0])
    mesh, box = box_mesh(size), Box(np.zeros(3), size)
    points = np.random.default_rng(1).uniform(-1.0, 4.0, (300, 3))
    for mine, its in zip(mesh.nearest(points), box.nearest(points), strict=True):
        np.testing.assert_allclose(mine, its, atol=1e-12)
    assert mesh.volume() == pytest.approx(6.0)
    assert mesh.surface() == pytest.approx(box.surface())
    assert mesh.thickness() == pytest.approx(1.0)
    np.testing.assert_allclose(mesh.inertia(), box.inertia(), rtol=1e-12)
    np.testing.assert_allclose(mesh.middle(), box.middle(), rtol=1e-12)
    assert (mesh.axes() == np.eye(3)).all()


def test_a_point_on_a_face_has_the_normal_of_the_face():
    gap, normal = box_mesh([1.0, 1.0, 1.0]).nearest(np.array([[1.0, 0.3, 0.4], [0.3, 0.2, 0.0]]))
    np.testing.assert_allclose(gap, 0.0, atol=1e-15)
    np.testing.assert_allclose(normal, [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]], atol=1e-12)


@pytest.mark.parametrize("inside_out", [False, True])
def test_a_corner_is_no_part_of_its_hull(inside_out):
    mesh = corner_mesh()
    mesh = Mesh(mesh.triangles[:, ::-1]) if inside_out else mesh
    points = np.array([[0.5, 0.5, 0.5], [2.0, 2.0, 0.5], [1.2, 2.0, 0.5]])
    gap, normal = mesh.nearest(points)
    np.testing.assert_allclose(gap, [-0.5, 1.0, 0.2], atol=1e-12)
    np.testing.assert_allclose(normal[2], [1.0, 0.0, 0.0], atol=1e-12)
    assert mesh.volume() == pytest.approx(5.0)
    assert not mesh.overlaps()
    polygon = Polygon(np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], float))
    np.testing.assert_allclose(mesh.middle()[:2], polygon.middle(), rtol=1e-12)
    assert mesh.inertia().max() == pytest.approx(polygon.inertia()[2])
    axes = mesh.axes()
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)
    turned = mesh.carried(-mesh.middle()).turned(axes)
    np.testing.assert_allclose(turned.inertia(), mesh.inertia(), rtol=1e-9)
    assert (turned.axes() == np.eye(3)).all()


def test_pieces_of_a_surface_have_its_area_and_integrate_to_nothing():
    mesh = Mesh(ball(0.5, np.array([0.1, 0.2, 0.3]), lines=12))
    points, normals, areas = mesh.panels(0.05)
    assert areas.sum() == pytest.approx(mesh.surface())
    np.testing.assert_allclose((normals * areas[:, None]).sum(axis=0), 0.0, atol=1e-12)
    assert (normals * points * areas[:, None]).sum() / 3.0 == pytest.approx(mesh.volume())
    rim = mesh.rim(0.05)
    assert len(np.unique(rim.round(9), axis=0)) == len(rim)
    assert np.abs(mesh.nearest(rim[::7])[0]).max() < 1e-12


@pytest.mark.long
def test_shells_that_overlap_are_seen():
    both = np.concatenate([ball(0.3, [-0.15, 0.0, 0.0]), ball(0.3, [0.15, 0.0, 0.0])])
    apart = np.concatenate([ball(0.3, [-0.4, 0.0, 0.0]), ball(0.3, [0.4, 0.0, 0.0])])
    assert Mesh(both).overlaps()
    assert not Mesh(apart).overlaps()


def test_a_cylinder_has_its_volume_and_moments():
    axis, radius = np.array([0.3, 0.3, 0.3]), 0.2
    cylinder, height = cylinder_of(np.ones(3), radius, axis), np.sqrt(0.27)
    assert cylinder.volume() == pytest.approx(np.pi * radius**2 * height)
    np.testing.assert_allclose(cylinder.middle(), 1.0)
    across = radius**2 / 4 + height**2 / 12
    np.testing.assert_allclose(sorted(cylinder.inertia()), [radius**2 / 2, across, across], rtol=2e-3)


def test_points_in_a_plane_have_no_hull():
    with pytest.raises(BadInput, match="without a volume"):
        hull_of(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], float))


def test_a_hollow_block_is_solid_where_its_hole_is_not():
    block = Hollow(Ball(np.array([0.5, 0.5]), 0.3), np.zeros(2), np.ones(2))
    points = np.array([[0.5, 0.5], [0.5, 0.7], [0.9, 0.5]])
    assert block.inside(points).tolist() == [False, False, True]
    np.testing.assert_allclose(block.nearest(points)[0], [0.3, 0.1, -0.1])
    assert block.volume() == pytest.approx(1.0 - np.pi * 0.09)
    assert block.cells(0.05).volumes.sum() == pytest.approx(block.volume())
    _, normals, areas = block.panels(0.05)
    np.testing.assert_allclose((normals * areas[:, None]).sum(axis=0), 0.0, atol=1e-12)


def ball_mesh(center, radius):
    return ball(radius, center)


def two_balls(radius, apart):
    """The volume of two equal balls together."""
    lens = np.pi * (4.0 * radius + apart) * (2.0 * radius - apart) ** 2 / 12.0 if apart < 2.0 * radius else 0.0
    return 8.0 / 3.0 * np.pi * radius**3 - lens


@pytest.mark.parametrize("inside_out", [(), (0,), (1,), (0, 1)])
@pytest.mark.parametrize("apart", [0.5, 1.3, 2.5])
def test_shells_of_any_sense_are_united(inside_out, apart):
    """Programs for drawing export some bodies inside out."""
    shells = [ball_mesh([0.0, 0.0, 0.0], 1.0), ball_mesh([apart, 0.1, 0.05], 1.0)]
    turned = [shell[:, ::-1] if k in inside_out else shell for k, shell in enumerate(shells)]
    mesh = Mesh(outward(np.concatenate(turned)))
    assert mesh.volume() == pytest.approx(two_balls(1.0, np.hypot(apart, np.hypot(0.1, 0.05))), rel=0.01)
    assert mesh.volume() == pytest.approx(Mesh(np.concatenate(shells)).volume(), rel=1e-9)
    assert mesh.inside(np.array([[0.5 * apart if apart < 2.0 else 0.0, 0.05, 0.02]])).all()


@pytest.mark.long
def test_a_shell_of_the_other_sense_inside_is_a_cavity():
    outer, inner, core = (ball_mesh([0.1, 0.0, 0.0], radius) for radius in (1.0, 0.6, 0.3))
    for turn in (1, -1):
        mesh = Mesh(outward(np.concatenate([outer, inner[:, ::-1], core])[:, ::turn]))
        volumes = [Mesh(each).volume() for each in (outer, inner, core)]
        assert mesh.volume() == pytest.approx(volumes[0] - volumes[1] + volumes[2])
        assert mesh.inside(np.array([[0.1, 0.0, 0.0], [0.55, 0.0, 0.0], [0.9, 0.0, 0.0]])).tolist() == [
            True,
            False,
            True,
        ]
