import math
import re

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from ecume.engine.placement import Region, place_at_random, place_on_lattice, place_on_ring
from ecume.engine.walls import disc, enclosed_by, no_walls
from ecume.errors import BadInput

NONE = np.zeros((0, 2)), np.zeros(0)
BOWL = Region((-1.0, -1.0), (1.0, 1.0), enclosed_by(disc((0.0, 0.0), 1.0)))


def least_gap(position, radius):
    touching = np.add.outer(radius, radius)[np.triu_indices(len(radius), 1)]
    return np.min(pdist(position) - touching)


def test_random_discs_touch_neither_each_other_nor_the_wall():
    radius = np.random.default_rng(0).uniform(0.02, 0.08, 60)
    position = place_at_random(radius, BOWL, NONE, seed=1)
    assert least_gap(position, radius) > 0.0
    assert np.all(np.hypot(*position.T) + radius < 1.0)


def test_random_discs_keep_clear_of_those_already_there():
    taken = np.array([[0.0, 0.0]]), np.array([0.6])
    position = place_at_random(np.full(20, 0.05), BOWL, taken, seed=1)
    assert np.all(np.hypot(*position.T) > 0.65)


def test_one_seed_gives_one_placement():
    radius = np.full(30, 0.05)
    assert np.array_equal(place_at_random(radius, BOWL, NONE, 7), place_at_random(radius, BOWL, NONE, 7))
    assert not np.array_equal(place_at_random(radius, BOWL, NONE, 7), place_at_random(radius, BOWL, NONE, 8))


def test_random_places_cover_the_region_evenly():
    region = Region((0.0, 0.0), (2.0, 1.0), no_walls())
    position = place_at_random(np.full(1000, 1e-3), region, NONE, seed=3)
    # The mean of 1,000 even draws is known to 1/sqrt(12 000) of the side: four times that is a 1-in-16,000 event.
    assert np.mean(position, axis=0) == pytest.approx([1.0, 0.5], abs=4 * 2.0 / math.sqrt(12_000))


def advice_on(radius, region=BOWL, taken=NONE):
    with pytest.raises(BadInput) as caught:
        place_at_random(radius, region, taken, seed=1)
    return str(caught.value)


@pytest.mark.compiled
def test_a_placement_that_jams_reports_the_covered_fraction():
    output = advice_on(np.full(70, 0.095))
    assert "floats found a free place at random; together they would cover 63% of the surface" in output


def test_discs_with_a_larger_area_than_the_surface_are_refused_without_a_try():
    output = advice_on(np.full(100_000, 0.095))
    assert output.startswith("together the floats would cover 90250% of the surface; random placement covers about 50%")


@pytest.mark.compiled
@pytest.mark.parametrize("radius", [np.full(70, 0.095), np.linspace(0.04, 0.13, 90), np.full(150, 0.095)])
def test_what_is_said_to_fit_at_random_fits(radius):
    output = advice_on(radius)
    smaller, wider = (
        float(re.search(pattern, output)[1])
        for pattern in (r"radii up to ([\d.]+) times", r"a dish ([\d.]+) times as wide")
    )
    if radius.min() == radius.max():
        count = int(re.search(r"at most (\d+) floats", output)[1])
        assert are_apart(place_at_random(radius[:count], BOWL, NONE, seed=2), radius[:count])
    assert are_apart(place_at_random(smaller * radius, BOWL, NONE, seed=2), smaller * radius)
    dish = Region((-wider, -wider), (wider, wider), enclosed_by(disc((0.0, 0.0), wider)))
    assert are_apart(place_at_random(radius, dish, NONE, seed=2), radius)


def are_apart(position, radius):
    """Whether no two discs overlap."""
    between = np.hypot(*(position[:, None] - position[None]).T)
    np.fill_diagonal(between, np.inf)
    return bool(np.all(between >= radius[:, None] + radius[None]))


def test_a_float_larger_than_the_dish_is_reported_in_the_same_words():
    assert re.search(r"would cover 121% of the surface; .*; a larger dish would do$", advice_on(np.array([1.1])))


@pytest.mark.compiled
def test_a_lattice_is_recommended_only_where_all_fit_on_it():
    output = advice_on(np.full(70, 0.1))
    assert 'placement = "lattice" with spacing = "200.1 mm", on which all of them fit' in output
    lattice = place_on_lattice(70, 0.2001, (0.0, 0.0))
    assert np.hypot(*lattice.T).max() + 0.1 < 1.0
    too_many = advice_on(np.full(85, 0.1))
    fit = int(re.search(r'(\d+) floats with placement = "lattice"', too_many)[1])
    reach = np.hypot(*place_on_lattice(fit + 1, 0.2001, (0.0, 0.0)).T) + 0.1
    assert reach[:fit].max() < 1.0 < reach[fit]
    assert "lattice" not in advice_on(np.linspace(0.04, 0.13, 90))


def test_a_lattice_is_triangular_and_grows_around_its_center():
    seven = place_on_lattice(7, 2.0, (1.0, -1.0))
    assert seven[0].tolist() == [1.0, -1.0]
    assert np.hypot(*(seven[1:] - seven[0]).T) == pytest.approx(np.full(6, 2.0))
    assert np.min(pdist(place_on_lattice(100, 2.0, (0.0, 0.0)))) == pytest.approx(2.0)


def test_a_ring_has_equal_steps():
    ring = place_on_ring(5, 3.0, (1.0, 2.0))
    assert np.hypot(*(ring - [1.0, 2.0]).T) == pytest.approx(np.full(5, 3.0))
    steps = np.hypot(*(ring - np.roll(ring, 1, axis=0)).T)
    assert steps == pytest.approx(np.full(5, 6.0 * math.sin(math.pi / 5)))


def test_discs_in_a_periodic_region_keep_apart_across_its_borders():
    region = Region((0.0, 0.0), (2.0, 1.3), no_walls(), periodic=True)
    radius = np.repeat([0.05, 0.08], [60, 40])
    place = place_at_random(radius, region, NONE, seed=3)
    apart = place[:, None] - place
    apart -= np.array([2.0, 1.3]) * np.round(apart / [2.0, 1.3])
    gap = np.linalg.norm(apart, axis=2) - radius[:, None] - radius
    np.fill_diagonal(gap, 1.0)
    assert gap.min() > 0.0
    # Without the walls of a dish, centers come as near to the borders as elsewhere.
    assert place.min() < 0.05
    with pytest.raises(BadInput, match=r"or a cell [0-9.]+ times as wide"):
        place_at_random(np.full(9, 0.3), region, NONE, seed=3)
