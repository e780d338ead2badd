"""Records of neighbors, turned into columns."""

import numpy as np
import pytest

from ecume import _jit
from ecume._columns import RECORD, fill_columns


@_jit.compiled_once
def compiled_columns(columns, records, neighbor, place, count):
    fill_columns(columns, records, neighbor, place, count)


@pytest.mark.compiled
@pytest.mark.parametrize("kind", [np.float64, np.float32])
@pytest.mark.parametrize("count", [0, 8, 16, 72])
def test_columns_hold_the_records_of_the_neighbors_of_one_particle(kind, count):
    rng = np.random.default_rng(count)
    records = rng.normal(size=(50, RECORD)).astype(kind)
    neighbor = rng.integers(0, 50, size=(5, 80), dtype=np.int32)
    found, expected = (np.full((RECORD, 88), -7.0, kind) for _ in range(2))
    compiled_columns(found, records, neighbor, np.uint64(3), np.uint64(count))
    fill_columns(expected, records, neighbor, 3, count)
    assert np.array_equal(found, expected)
    assert np.array_equal(found[:, :count], records[neighbor[3, :count]].T)
    assert np.all(found[:, count:] == -7.0)
