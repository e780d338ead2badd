"""Arithmetic whose rounding the source says."""

import numpy as np
import pytest

from ecume import _jit
from ecume._fused import LANES, fused, lane_sum


@_jit.compiled_once
def products(a, b, c, found):
    for k in range(len(a)):
        found[k] = fused(a[k], b[k], c[k])


@_jit.compiled_once
def summed(values, count):
    return lane_sum(values, count)


@pytest.mark.compiled
@pytest.mark.parametrize(("kind", "small"), [(np.float64, 2.0**-30), (np.float32, 2.0**-14)])
def test_a_product_and_a_sum_are_rounded_once_in_either_precision(kind, small):
    a, b, c = (np.full(19, value, kind) for value in (1.0 + small, 1.0 - small, -1.0))
    found = np.zeros(19, kind)
    products(a, b, c, found)
    assert np.all(a * b + c == 0.0)
    assert np.all(found == -(kind(small) ** 2))


@pytest.mark.compiled
@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_lanes_add_up_in_the_order_that_the_source_says(kind):
    values = np.random.default_rng(3).normal(size=41 * LANES).astype(kind)
    for count in (0, LANES, 40 * LANES):
        assert summed(values, count) == lane_sum(values, count)
    assert lane_sum(values, 40 * LANES) == pytest.approx(float(np.sum(values[: 40 * LANES], dtype=np.float64)))
