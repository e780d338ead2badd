"""Spheres that a single film holds: those that may roll freely are found, others are not."""

import numpy as np
import pytest

from ecume.models.soft import SOFT
from ecume.models.soft.contacts.connected_pieces import dangling_spheres, turning_pieces
from ecume.models.soft.state import FAILED
from ecume.scenes.schema import from_plain
from ecume.simulation import moments
from tests.models.soft.random_scenes import drawn, explicit

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


def turning(pair, image, anchored=(0,), count=4):
    anchor = np.zeros(count)
    anchor[list(anchored)] = 1.0
    return np.flatnonzero(turning_pieces(np.array(pair, np.int64), np.array(image, np.int64), anchor)).tolist()


def test_a_piece_whose_films_wind_around_the_cell_cannot_rotate():
    """With the spin of its first sphere anchored, each iteration left most of the rolling forces where they were."""
    chain, inside = [(0, 1), (1, 2), (0, 2)], [[0, 0]] * 3
    assert turning(chain, inside) == [0]
    assert turning(chain, [[0, 0], [0, 0], [1, 0]]) == []


def test_a_closed_loop_across_a_periodic_side_that_returns_does_not_wind():
    assert turning([(0, 1), (1, 2), (0, 2)], [[1, 0], [0, 1], [1, 1]]) == [0]


def test_each_piece_is_looked_at_apart():
    pair, image = [(0, 1), (0, 1), (2, 3)], [[0, 0], [1, 0], [0, 1]]
    assert turning(pair, image, anchored=(0, 2)) == [2]


def test_newtons_method_converges_in_a_packing_with_a_loose_sphere():
    """Half of the steps were not solved, and none longer than 1e-9 of the run was."""
    plain = explicit(from_plain(drawn(np.random.default_rng(58))))
    rate = plain.pop("preparation")["rate"]
    plain["protocol"] = [{"time": 0.0, "height_rate": -rate}]
    first = next(one.state for one in moments(from_plain(plain)) if one.taken >= 40 or one.state.tally[FAILED] > 4)
    assert first.tally[FAILED] <= 4
