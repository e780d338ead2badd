"""Spheres that a single film holds: those that may roll freely are found, others are not."""

import numpy as np
import pytest

from ecume.models.soft import SOFT
from ecume.models.soft.contacts.connected_pieces import dangling_spheres
from ecume.scenes.schema import from_plain

RING = [(0, 1), (1, 2), (0, 2)]


def dangling(pair, count=6, wall=(), anchored=(), **more):
    plain = {
        "model": "soft", "duration": 1.0, "frame_every": 1.0, "rotation": True, "liquid": {"viscosity": 1.0},
        "particles": [{"radius": 1.0, "modulus": 1.0, "positions": [[3.0 * k, 1.5] for k in range(count)]}],
        "cell": {"size": [40.0, 40.0]},
    } | more  # fmt: skip
    parameters = SOFT.parameters(from_plain(plain))
    touching = np.zeros((count, len(parameters.walls.modulus)), np.int64)
    touching[list(wall)] = 1
    anchor = np.zeros(count)
    anchor[list(anchored)] = 1.0
    found = dangling_spheres(parameters, np.array(pair, np.int64).reshape(-1, 2), touching, anchor)
    return np.flatnonzero(found).tolist()


def test_a_chain_that_ends_freely_dangles_from_its_end_to_the_network():
    assert dangling([*RING, (2, 3), (3, 4), (4, 5)]) == [3, 4, 5]
    assert dangling([*RING, (2, 3), (3, 4), (4, 5), (0, 5)]) == []


def test_one_sphere_of_a_free_chain_holds_the_others():
    assert dangling([(0, 1), (1, 2)], anchored=[0]) == [1, 2]
    assert len(dangling([(0, 1), (2, 3)])) == 2


def test_a_wall_holds_a_sphere_like_a_neighbor():
    walls = {"walls": [{"side": "bottom"}]}
    assert dangling(RING, wall=[0, 4, 5], **walls) == [4, 5]


@pytest.mark.parametrize("more", [
    {"hydrodynamics": {"drag": "stokes"}},
    {"gravity": 1.0, "liquid": {"viscosity": 1.0, "density": 1.0}},
])  # fmt: skip
def test_spheres_with_drag_or_weight_do_not_dangle(more):
    species = {"radius": 1.0, "modulus": 1e3, "density": 1.1, "positions": [[3.0 * k, 1.5] for k in range(6)]}
    scene = {"particles": [species], "walls": [{"side": "bottom"}]} if "gravity" in more else {}
    assert dangling([*RING, (2, 3)], wall=range(3) if "gravity" in more else (), **scene, **more) == []
