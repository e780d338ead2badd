"""Monte Carlo of hard discs samples every allowed configuration equally, and the rows of the case see what is wrong."""

import math

import numpy as np
import pytest

from ecume_validation import hard_discs
from ecume_validation.hard_discs import AT_WALL, COUNT, EDGES, Found, Room, compared, expected, pressure, weight_of


@pytest.fixture(autouse=True)
def _fewer_moves(monkeypatch):
    monkeypatch.setattr(hard_discs, "SWEEPS", 400)
    monkeypatch.setattr(hard_discs, "BETWEEN", 2)
    monkeypatch.setattr(hard_discs, "MOVE", 1.5)


def test_two_discs_in_a_periodic_square_are_found_where_there_is_room():
    side = 6.0
    found = expected(np.array([[0.0, 0.0], [3.0, 0.0]]), Room(side, math.inf)).value
    exact = math.pi * np.diff((2.0 + EDGES) ** 2) / (side**2 - 4.0 * math.pi)
    assert found.sum() == pytest.approx(exact.sum(), rel=0.05)
    assert found == pytest.approx(exact, rel=0.25)


def test_two_discs_in_a_dish_are_found_near_one_another_and_at_the_wall_as_often_as_there_is_room():
    dish = 4.0
    found = expected(np.array([[-1.5, 0.0], [1.5, 0.0]]), Room(0.0, dish))
    apart = np.linspace(2.0, 2.0 * dish - 2.0, 4001)[:-1]
    weight = np.array([weight_of(0.0, 1.0, dish)(each) for each in apart])
    near = weight[apart < 2.0 + EDGES[-1]].sum() / weight.sum()
    pairs, walls = found.value[: len(EDGES) - 1].sum(), found.value[len(EDGES) - 1 :].sum()
    assert pairs == pytest.approx(near, rel=0.05)
    # More than without the other disc, which is rather at the opposite wall.
    assert walls > 1.05 * 2.0 * (1.0 - (1.0 - AT_WALL[-1] / (dish - 1.0)) ** 2)


def test_the_pressure_of_independent_discs_is_that_of_their_contacts():
    side = 20.0
    counts = COUNT * (COUNT - 1) / 2.0 * math.pi * np.diff((2.0 + EDGES) ** 2) / side**2
    share = COUNT * math.pi / side**2
    assert pressure(counts, side) == pytest.approx(1.0 + 2.0 * share * (COUNT - 1) / COUNT)


def test_a_share_that_is_four_percent_off_is_seen():
    one = np.array([1.0, 2.0])
    rows = list(compared("a", Found(1.04 * one, 1e-3 * one), Found(one, 0.0 * one), ["b", "c"]))
    assert [row.met for row in rows] == [False, False, True]
