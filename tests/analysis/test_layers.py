"""Profiles of velocity and volume fraction across a packing."""

import math

import numpy as np
import pytest

from ecume.analysis.layers import ends_of, layers, part_below
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame


def cell(seed=1, dimensions=2, count=30, rate=0.3, profile=None, **walls):
    """Spheres at random in a cell of 4 by 5 (by 3) whose velocity follows from their height."""
    dice, sides = np.random.default_rng(seed), np.array([4.0, 5.0, 3.0])[:dimensions]
    position, radius = dice.uniform(size=(count, dimensions)) * sides, dice.uniform(0.1, 0.3, count)
    velocity = np.zeros_like(position)
    velocity[:, 0] = rate * position[:, 1] if profile is None else profile(position[:, 1])
    numbers = {"box_width": 4.0, "strain_rate": rate, **walls}
    numbers |= {} if walls else {"box_height": 5.0}
    numbers |= {"box_depth": 3.0} if dimensions == 3 else {}
    return Frame(0.0, {"position": position, "radius": radius, "velocity": velocity}, numbers, {})


@pytest.mark.parametrize("dimensions", [2, 3])
def test_the_part_of_a_sphere_below_a_plane_agrees_with_its_integral(dimensions):
    y = np.linspace(-1.0, 1.0, 200001)
    section = 2.0 * np.sqrt(1.0 - y**2) if dimensions == 2 else math.pi * (1.0 - y**2)
    for height in (-1.5, -0.7, 0.0, 0.3, 2.0):
        wanted = np.trapezoid(np.where(y < height, section, 0.0), y)
        found = part_below(np.array(2.0 * height), np.array(2.0), dimensions)
        assert found == pytest.approx(2.0**dimensions * wanted, abs=1e-3)


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("seed", range(5))
def test_the_mean_over_layers_is_the_volume_fraction_also_where_spheres_cross_the_border(dimensions, seed):
    frame = cell(seed, dimensions)
    unit = math.pi if dimensions == 2 else 4.0 / 3.0 * math.pi
    volume = unit * (frame.arrays["radius"] ** dimensions).sum()
    fractions = [one.value for one in layers([frame], 7).fraction]
    assert np.mean(fractions) == pytest.approx(volume / math.prod([4.0, 5.0, 3.0][:dimensions]), rel=1e-12)


def test_a_homogeneous_flow_has_a_straight_profile():
    """A sphere that crosses the top also counts at the bottom, with the speed of the flow there, so that mean profiles
    are straight.
    """
    found = layers([cell(seed, rate=0.3, count=200) for seed in range(30)], 10)
    speeds = np.array([one.value for one in found.velocity])
    assert np.abs(speeds - 0.3 * found.height).max() < 0.02
    assert all(one.error < 0.02 for one in found.velocity)


def test_a_band_between_walls_is_found_where_it_is():
    def banded(y):
        return np.clip(y - 2.0, 0.0, 1.0)

    frames = [cell(seed, count=100, profile=banded, bottom_y=0.0, top_y=5.0) for seed in range(20)]
    assert ends_of(frames[0]) == (0.0, 5.0, False)
    found = layers(frames, 10)
    speeds = [one.value for one in found.velocity]
    assert speeds == pytest.approx(banded(found.height), abs=0.12)


def test_a_cell_between_left_and_right_is_refused():
    frame = cell()
    with pytest.raises(BadInput, match="periodic along x"):
        layers([frame._replace(numbers={"box_height": 5.0})])


def test_a_layer_without_spheres_has_no_velocity_and_no_warning(recwarn):
    frames = [cell(seed, count=3, bottom_y=0.0, top_y=400.0) for seed in range(4)]
    found = layers(frames, 12)
    assert math.isnan(found.velocity[-1].value)
    assert found.fraction[-1].value == 0.0
    assert not recwarn.list
