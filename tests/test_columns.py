"""Records of neighbors, turned into columns."""

import numpy as np
import pytest

from ecume import _jit
from ecume._columns import RECORD, column, fill_columns, further_column


@_jit.compiled_once
def compiled_columns(columns, records, neighbor, begin, count, first):
    fill_columns(columns, records, neighbor, begin, count, first)


@_jit.compiled_once
def compiled_numbers(columns, k):
    return column(columns, k), further_column(columns, k)


@pytest.mark.compiled
@pytest.mark.parametrize("kind", [np.float64, np.float32])
@pytest.mark.parametrize("count", [0, 8, 16, 72])
@pytest.mark.parametrize(("first", "width"), [(0, RECORD), (0, 2 * RECORD), (RECORD, 2 * RECORD)])
def test_columns_hold_the_records_of_the_neighbors_of_one_particle(kind, count, first, width):
    rng = np.random.default_rng(count)
    records = rng.normal(size=(50, width)).astype(kind)
    neighbor = rng.integers(0, 50, size=400, dtype=np.int32)
    found, expected = (np.full((width, 88), -7.0, kind) for _ in range(2))
    compiled_columns(found, records, neighbor, np.uint64(240), np.uint64(count), np.uint64(first))
    fill_columns(expected, records, neighbor, 240, count, first)
    assert np.array_equal(found, expected)
    filled = slice(first, first + RECORD)
    assert np.array_equal(found[filled, :count], records[neighbor[240 : 240 + count], filled].T)
    expected[filled, :count] = -7.0
    assert np.all(expected == -7.0)


@pytest.mark.compiled
def test_a_column_is_read_in_two_halves():
    columns = np.random.default_rng(0).normal(size=(2 * RECORD, 5))
    halves = compiled_numbers(columns, np.uint64(3))
    assert halves == (column(columns, 3), further_column(columns, 3))
    assert np.array_equal(np.concatenate(halves), columns[:, 3])
