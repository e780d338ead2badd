"""Liquid next to discs, balls and slanted surfaces starts evenly spaced, and stays at rest."""

import math

import numpy as np
import pytest

import ecume
from ecume.models.sph.record import SPH
from ecume.models.sph.setup.initial_particles import cells_of, unaligned_solids
from ecume.models.sph.setup.packing import packed, unevenness
from ecume.models.sph.setup.shapes import gaps_to, solids_of
from ecume.scenes.schema import from_plain, to_plain

DISC = {"center": [0.52, 0.4], "radius": 0.17}
WEDGE = {"vertices": [[0.6, 0.0], [1.0, 0.0], [1.0, 0.45]]}
PIER = {"vertices": [[0.3, 0.0], [0.7, 0.0], [0.6, 0.35], [0.43, 0.35]]}
MOUND = {"center": [0.5, 0.0], "radius": 0.3}
BALL = {"center": [0.5, 0.4, 0.45], "radius": 0.25}
BOX = {"low": [0.25, 0.0], "high": [0.5, 0.375]}


def tank(*obstacles, walls="mirror", layers=10, depth=0.75, **changes):
    """Still water in a tank a meter wide, with an obstacle."""
    dimension = len(obstacles[0]["center"]) if "center" in obstacles[0] else 2
    high = [1.0, depth, 0.9][:dimension]
    plain = {
        "model": "sph", "duration": 1.0, "frame_every": 1.0, "spacing": depth / layers, "obstacles": list(obstacles),
        "tank": {"high": [high[0], 1.0, *high[2:]], "walls": walls},
        "fluid": [{"low": [0.0] * dimension, "high": high}],
    }  # fmt: skip
    return from_plain({**plain, **changes})


def both(scene):
    """The cells of the lattice, and the packed ones."""
    cells = [each for each, _ in cells_of(scene)]
    return cells, packed(scene, cells, unaligned_solids(scene))


SHAPES = {"disc": DISC, "wedge": WEDGE, "pier": PIER, "mound": MOUND}


@pytest.mark.parametrize("walls", ["mirror", "dummy"])
@pytest.mark.parametrize("obstacle", SHAPES.values(), ids=SHAPES)
def test_packed_liquid_has_an_even_density_and_a_gap_to_every_surface(obstacle, walls):
    scene = tank(obstacle, walls=walls)
    solids = unaligned_solids(scene)
    (lattice,), (cells,) = both(scene)
    assert unevenness(scene, [lattice], solids) > 0.03
    assert unevenness(scene, [cells], solids) < 0.015
    gap = gaps_to(solids_of(scene), cells.centers)
    assert gap.min() > 0.25 * scene.spacing
    first_layer = gap[gap < 0.9 * scene.spacing] / scene.spacing
    assert first_layer.mean() == pytest.approx(0.5, abs=0.1)
    assert first_layer.std() < 0.15


def test_packing_in_3d_evens_the_density_out():
    scene = tank(BALL, layers=6)
    solids = unaligned_solids(scene)
    (lattice,), (cells,) = both(scene)
    assert unevenness(scene, [cells], solids) < 0.3 * unevenness(scene, [lattice], solids)


def test_liquid_beside_aligned_boxes_is_not_packed():
    scene = tank(BOX, layers=6)
    assert unaligned_solids(scene) == []
    (lattice,), (cells,) = both(scene)
    assert cells is lattice
    np.testing.assert_array_equal(SPH.start(scene, SPH.parameters(scene)).position.T, lattice.centers)


def test_a_box_too_close_to_a_wall_for_the_lattice_is_packed():
    narrow = {"low": [0.3, 0.0], "high": [0.33, 0.4]}
    assert len(unaligned_solids(tank(narrow))) == 1


def test_packing_has_the_same_bits_each_time_and_moves_no_given_particles():
    scene = tank(DISC)
    np.testing.assert_array_equal(both(scene)[1][0].centers, both(scene)[1][0].centers)
    places = both(scene)[0][0].centers
    given = from_plain({**to_plain(scene), "fluid": [{"particles": {"positions": places.tolist()}}]})
    state = SPH.start(given, SPH.parameters(given))
    np.testing.assert_array_equal(state.position.T, places)


def test_particles_around_obstacles_have_the_mass_of_their_cells():
    """Their number fits the volume that is left, to one particle: of two that are symmetric, both are kept or none."""
    for obstacle in SHAPES.values():
        for layers in (7, 9, 12, 15):
            [(cells, _)] = cells_of(tank(obstacle, layers=layers))
            mass = cells.volumes.sum() / np.prod(cells.widths, axis=1).sum()
            assert mass == pytest.approx(1.0, abs=1.02 / len(cells.volumes))


def test_check_reports_the_summed_density():
    rows = {name: value for name, value, _ in SPH.summary(tank(DISC))}
    assert float(rows["summed density"].split()[1]) < 1.5
    assert "summed density" not in {name for name, *_ in SPH.summary(tank(BOX, layers=6))}


@pytest.mark.sampled(3)
@pytest.mark.compiled  # a thousand steps each
@pytest.mark.parametrize("obstacle", SHAPES.values(), ids=SHAPES)
def test_still_water_stays_still_beside_curved_and_slanted_surfaces(obstacle):
    depth = 0.3
    shrunk = {key: np.multiply(value, 0.4).tolist() for key, value in obstacle.items()}
    scene = tank(shrunk, depth=depth, layers=8)
    frame = list(ecume.simulate(scene))[-1]
    assert frame.numbers["largest_speed"] < 0.02 * math.sqrt(9.81 * depth)
