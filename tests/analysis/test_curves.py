"""Curves with errors: the largest difference of two curves, and branches of sweeps up and down."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ecume.analysis.curves import Curve, branches, largest_difference
from ecume.analysis.series import Mean
from ecume.errors import BadInput


def test_two_curves_are_compared_where_they_differ_most():
    rates = np.array([0.1, 1.0, 10.0])
    one = Curve(rates, tuple(Mean(value, 0.1) for value in (1.0, 2.0, 4.0)))
    two = Curve(rates[1:], (Mean(2.2, 0.1), Mean(3.0, 1.0)))
    found = largest_difference(one, two)
    assert (found.at, found.relative, found.errors) == pytest.approx((1.0, 0.1, 2.0**0.5))
    with pytest.raises(BadInput, match="no value of the axis in common"):
        largest_difference(one, two._replace(at=np.array([5.0, 7.0])))


def test_curves_at_zero_are_compared_as_well():
    """Durations, yield stresses and counts can be zero, and single runs have no error."""
    one, two = (Curve(np.array([1.0]), (Mean(value, 0.1),)) for value in (0.0, -0.2))
    assert largest_difference(one, two) == pytest.approx((1.0, -np.inf, 2.0**0.5))
    assert largest_difference(one, one) == (1.0, 0.0, 0.0)


@given(st.lists(st.integers(-3, 3).map(float), max_size=12))
def test_each_branch_is_monotonic_and_turns_where_the_next_begins(values):
    found = branches(values)
    assert [place for one in found for place in one.places[:-1]] == list(range(len(values) - 1))
    for one, other in itertools.pairwise(found):
        assert one.last == other.first
        assert one.rises is not other.rises
    for one in found:
        steps = np.diff([values[place] for place in one.places])
        assert (steps >= 0.0).all() if one.rises else (steps <= 0.0).all()
