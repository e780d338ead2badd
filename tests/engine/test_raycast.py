"""Rays through a ball of liquid: where they enter, the length of their path, and their end at a solid."""

import numpy as np
import pytest

from ecume.engine.rendering import MET, Block, Eye, cast

SIDE = 24
RADIUS = 0.35


def block(solid=None):
    """A ball of liquid in the middle of a cube of side 1, and a solid half-space."""
    axis = (np.arange(SIDE) + 0.5) / SIDE
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    liquid = RADIUS - np.sqrt((x - 0.5) ** 2 + (y - 0.5) ** 2 + (z - 0.5) ** 2)
    hard = np.full(liquid.shape, -1.0) if solid is None else solid - z
    return Block(liquid.astype(np.float32), hard.astype(np.float32), np.zeros(3), np.ones(3), np.full(3, 1.0 / SIDE))


def met_by(found, across, camera=None):
    """Rays at these distances to the right of the middle of the cube, from 1.2 m above the origin."""
    camera = np.eye(3) if camera is None else camera
    middle = camera @ np.full(3, 0.5)
    met = np.zeros((1, len(across), MET))
    cast(found, Eye(middle[0] + np.array(across), middle[1:2].copy(), camera, 1.7), met)
    return met[0], middle


def test_a_ball_is_met_where_it_is_and_is_as_thick_as_its_chord():
    met, middle = met_by(block(), [0.0, 0.2, 0.45])
    heights = np.sqrt(RADIUS**2 - np.array([0.0, 0.2]) ** 2)
    assert 1.7 - met[:2, 0] == pytest.approx(middle[2] + heights, abs=0.004)
    assert met[:2, 2] == pytest.approx(2.0 * heights, abs=1.5 / SIDE)
    assert np.isinf(met[2, 0])
    assert met[2, 2] == 0.0
    assert np.isinf(met[:, 1]).all()


def test_normals_point_out_of_the_liquid():
    met, _ = met_by(block(), [0.0, 0.2])
    assert met[0, 3:6] == pytest.approx([0.0, 0.0, 1.0], abs=0.02)
    assert met[1, 3:6] == pytest.approx([0.2 / RADIUS, 0.0, np.sqrt(1.0 - (0.2 / RADIUS) ** 2)], abs=0.03)


def test_a_ray_ends_at_a_solid():
    met, _ = met_by(block(solid=0.4), [0.0, 0.45])
    assert 1.7 - met[:, 1] == pytest.approx([0.4, 0.4], abs=0.004)
    assert met[0, 2] == pytest.approx(0.5 + RADIUS - 0.4, abs=1.5 / SIDE)
    assert met[:, 6] == pytest.approx([1.0, 1.0], abs=1e-3)


def test_a_block_that_is_full_is_met_at_its_side_with_the_normal_of_that_side():
    full = block()._replace(liquid=np.ones((SIDE, SIDE, SIDE), np.float32))
    met, _ = met_by(full, [0.0])
    assert 1.7 - met[0, 0] == pytest.approx(1.0, abs=1e-9)
    assert met[0, 3:6].tolist() == [0.0, 0.0, 1.0]


def test_from_another_side_the_ball_is_the_same():
    turn = np.array([[0.8, 0.0, -0.6], [-0.36, 0.8, -0.48], [0.48, 0.6, 0.64]])
    met, middle = met_by(block(), [0.0], turn)
    assert 1.7 - met[0, 0] == pytest.approx(middle[2] + RADIUS, abs=0.006)
