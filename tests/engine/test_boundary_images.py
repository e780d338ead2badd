"""Images of particles at walls and periodic sides."""

import numpy as np

from ecume.engine.cells import Sides, images_of, positions_of_images

REACH = 0.3


def periodic_box():
    point = np.array([[0.0, 0.0], [1.0, 1.0], [0.0, 0.0], [1.0, 1.0]])
    normal = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    return Sides(point, normal, normal.copy(), np.zeros(4, np.int64))


def everyone(position, sides):
    images = images_of(position, sides, REACH)
    return np.concatenate([position, positions_of_images(position, images, sides)], axis=1)


def test_a_periodic_box_repeats_each_particle_once_in_each_place():
    position = np.random.default_rng(1).uniform(0.0, 1.0, (2, 200))
    lattice = np.array([[i, j] for i in (-1, 0, 1) for j in (-1, 0, 1)], float)
    wanted = (position.T[:, None, :] + lattice).reshape(-1, 2)
    wanted = wanted[((wanted > -REACH) & (wanted < 1.0 + REACH)).all(axis=1)]
    found = everyone(position, periodic_box()).T
    assert len(found) == len(wanted)
    np.testing.assert_allclose(sorted(found.tolist()), sorted(wanted.tolist()), atol=1e-12)


def test_no_image_stands_on_its_source():
    position = np.random.default_rng(2).uniform(0.0, 1.0, (2, 50))
    found = everyone(position, periodic_box()).T
    apart = np.linalg.norm(found[:, None] - found[None], axis=2) + 2.0 * np.eye(len(found))
    assert apart.min() > 1e-6


def test_a_corner_between_mirrors_is_filled_once():
    sides = Sides(np.zeros((2, 2)), np.eye(2), np.zeros((2, 2)), np.ones(2, np.int64))
    found = everyone(np.array([[0.1], [0.2]]), sides)
    assert sorted(found.T.tolist()) == [[-0.1, -0.2], [-0.1, 0.2], [0.1, -0.2], [0.1, 0.2]]
