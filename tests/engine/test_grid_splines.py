import numpy as np
import pytest

from ecume.engine import interpolation

SHAPE = (30, 26)
SPACING = 0.1
LOW = np.array([-0.8, -0.9])


@pytest.fixture
def places():
    return np.random.default_rng(3).uniform(0.0, 1.0, (25, 2))


def points():
    return np.meshgrid(LOW[0] + SPACING * np.arange(SHAPE[0]), LOW[1] + SPACING * np.arange(SHAPE[1]), indexing="ij")


@pytest.mark.parametrize("order", [4, 6, 8])
def test_charges_on_the_grid_keep_their_sum_and_their_middle(places, order):
    charge = np.random.default_rng(4).normal(size=25)
    grid = interpolation.density(interpolation.spread_out(places, LOW, SPACING, SHAPE[0], order), charge, SHAPE)
    assert grid.sum() == pytest.approx(charge.sum(), abs=1e-13)
    for axis, there in enumerate(points()):
        assert (grid * there).sum() == pytest.approx(charge @ places[:, axis], abs=1e-12)


@pytest.mark.parametrize("order", [4, 6, 8])
def test_a_straight_field_is_read_as_it_is(places, order):
    x, y = points()
    spread = interpolation.spread_out(places, LOW, SPACING, SHAPE[0], order)
    found = interpolation.fields(spread, np.stack([2.0 * x - y, np.ones(SHAPE)]))
    assert found[:, 0] == pytest.approx(2.0 * places[:, 0] - places[:, 1], abs=1e-12)
    assert found[:, 1] == pytest.approx(np.ones(25), abs=1e-12)


def test_spreading_and_reading_are_each_others_transpose(places):
    rng = np.random.default_rng(5)
    charge, field = rng.normal(size=25), rng.normal(size=SHAPE)
    spread = interpolation.spread_out(places, LOW, SPACING, SHAPE[0], 6)
    there = (interpolation.density(spread, charge, SHAPE) * field).sum()
    assert there == pytest.approx(charge @ interpolation.fields(spread, field[None])[:, 0], rel=1e-12)


def test_weights_are_those_of_the_cubic_spline():
    spread = interpolation.spread_out(np.array([[0.025, 0.0]]), LOW, SPACING, SHAPE[0], 4)
    t = 0.25
    cubic = [(1 - t) ** 3 / 6, (4 - 6 * t**2 + 3 * t**3) / 6, (1 + 3 * t + 3 * t**2 - 3 * t**3) / 6, t**3 / 6]
    assert spread.weight[0, 0] == pytest.approx(cubic, abs=1e-12)
    assert spread.corner[0, 0] == 7
