"""Gaps, coordination and volume fractions of packings with known results."""

import math

import numpy as np
import pytest

from ecume.analysis.boxes import Box, box_of
from ecume.analysis.close_pairs import branches, coordination, films, gap_distribution, near_pairs, volume_fraction
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame

ROW = math.sqrt(3.0) / 2.0


@pytest.fixture
def honeycomb():
    """Thirty-six discs at unit spacing in a box sheared by a whole row, which is the same packing."""
    i, j = np.meshgrid(np.arange(6), np.arange(6), indexing="ij")
    place = np.stack([(i + 0.5 * (j % 2)).ravel(), ROW * j.ravel()], axis=1).astype(float)
    numbers = {"box_width": 6.0, "box_height": 6 * ROW, "strain": 1.0 / ROW}
    return Frame(0.0, {"position": place, "radius": np.full(36, 0.45)}, numbers, {})


@pytest.fixture
def soft():
    """Three spheres in a row, with one film in tension and one in compression."""
    arrays = {
        "position": np.array([[0.0, 0.0], [2.1, 0.0], [4.1, 0.0]]),
        "radius": np.ones(3),
        "neighbor": np.array([[1, -1], [2, -1], [-1, -1]]),
        "gap": np.array([[0.2, 0.0], [0.01, 0.0], [0.0, 0.0]]),
        "tension": np.array([[2.0, 0.0], [-3.0, 0.0], [0.0, 0.0]]),
    }
    return Frame(0.0, arrays, {}, {})


def test_a_honeycomb_has_six_neighbors_across_its_sheared_borders_too(honeycomb):
    near = near_pairs(honeycomb, 0.2)
    assert len(near.pairs) == 3 * 36
    assert near.gap == pytest.approx(0.1)
    assert coordination(honeycomb, gap=0.11).tolist() == [6.0] * 36
    assert coordination(honeycomb, gap=0.09).tolist() == [0.0] * 36
    assert np.linalg.norm(branches(honeycomb, near.pairs), axis=1) == pytest.approx(1.0)


def test_a_honeycomb_of_touching_discs_fills_nine_tenths_of_the_plane(honeycomb):
    filled = volume_fraction(honeycomb._replace(arrays=honeycomb.arrays | {"radius": np.full(36, 0.5)}))
    assert filled == pytest.approx(math.pi / (2 * math.sqrt(3)))


def test_between_walls_neighbors_are_found_across_the_borders_that_there_are(honeycomb):
    rows = honeycomb._replace(numbers={"box_width": 6.0})
    assert box_of(rows).sides.tolist() == [6.0, 0.0]
    found = coordination(rows, gap=0.11).reshape(6, 6)
    assert (found[:, 1:5] == 6.0).all()
    assert (found[:, [0, 5]] == 4.0).all()  # nothing lies below the lowest row, nor above the highest
    assert np.linalg.norm(branches(rows, near_pairs(rows, 0.2).pairs), axis=1) == pytest.approx(1.0)
    with pytest.raises(BadInput, match="has a volume"):
        volume_fraction(rows)
    columns = honeycomb._replace(numbers={"box_height": 6 * ROW})
    assert coordination(columns, gap=0.11).reshape(6, 6)[1:5].tolist() == [[6.0] * 6] * 4
    assert coordination(honeycomb._replace(numbers={}), gap=0.11).sum() < coordination(columns, gap=0.11).sum()


def test_films_count_by_their_gap_or_by_how_they_press(soft):
    assert films(soft).pairs.tolist() == [[0, 1], [1, 2]]
    assert coordination(soft, gap=0.1).tolist() == [0.0, 1.0, 1.0]
    assert coordination(soft, gap=0.3).tolist() == [1.0, 2.0, 1.0]
    assert coordination(soft, force=2.9).tolist() == [0.0, 1.0, 1.0]
    assert coordination(soft, force=3.1).tolist() == [0.0, 0.0, 0.0]


def test_a_distribution_of_gaps_integrates_to_one_and_knows_a_log_normal():
    gaps = np.exp(np.random.default_rng(1).normal(math.log(1e-3), 0.5, size=40_000))
    found = gap_distribution(gaps, bins=40)
    assert (found.density * np.diff(np.log(found.edges))).sum() == pytest.approx(1.0)
    wanted = np.exp(-(np.log(found.middles / 1e-3) ** 2) / 0.5) / math.sqrt(2 * math.pi * 0.25)
    known = found.density_error > 0
    assert np.abs((found.density - wanted)[known] / found.density_error[known]).mean() < 1.5


def test_what_has_no_answer_is_refused(honeycomb, soft):
    for given in ({}, {"gap": 1.0, "force": 1.0}):
        with pytest.raises(BadInput, match="give one"):
            coordination(soft, **given)
    with pytest.raises(BadInput, match="no films"):
        coordination(honeycomb, force=1.0)
    with pytest.raises(BadInput, match="no gaps"):
        gap_distribution(np.array([-1.0]))
    with pytest.raises(BadInput, match="needs a box"):
        volume_fraction(soft)
    for left_out in ("box_width", "box_height"):
        with pytest.raises(BadInput, match=f"sheared, but no number '{left_out}'"):
            box_of(honeycomb._replace(numbers={k: v for k, v in honeycomb.numbers.items() if k != left_out}))


def test_the_volume_fraction_of_spheres_in_space():
    frame = Frame(0.0, {"position": np.zeros((8, 3)), "radius": np.full(8, 0.5)}, {}, {})
    assert volume_fraction(frame, Box(np.full(3, 2.0))) == pytest.approx(math.pi / 6)
