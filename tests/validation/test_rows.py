import json
import math

import numpy as np
import pytest

from ecume_validation.runner import Row, above, as_text, below, within


@pytest.mark.parametrize(
    ("row", "met"),
    [
        (within("a", 1.001, 1.0, 2e-3), True),
        (within("a", 0.997, 1.0, 2e-3), False),
        (within("a", 0.0, 0.0, 0.0), True),
        (within("a", 1.0, 0.0, 0.0), False),
        (within("a", math.inf, 1.0, 1.0), False),
        (below("a", 0.9, 1.0), True),
        (below("a", 1.0, 1.0), False),
        (above("a", 1.1, 1.0), True),
        (above("a", 1.0, 1.0), False),
    ],
)
def test_a_row_is_met_when_its_number_is_as_expected(row, met):
    assert row.met == met


@pytest.mark.parametrize("kind", ["within", "below", "above"])
def test_what_is_met_can_be_written_down(kind):
    row = Row("a", np.float64(1.0), np.float64(1.0), 0.5, kind)
    assert json.dumps({"met": row.met}) in ('{"met": true}', '{"met": false}')


@pytest.mark.parametrize("kind", ["within", "below", "above"])
def test_what_is_no_number_is_never_met(kind):
    assert not Row("a", math.nan, 1.0, 10.0, kind).met


@pytest.mark.parametrize(
    ("row", "text"),
    [
        (within("t", 0.420470321, 0.420470123, 4.2e-4), ("t", "0.42047", "0.42047", "0.00042")),
        (within("h", 0.17431148549532, 0.174311485495, 1e-12), ("h", "0.17431148549532", "0.174311485495", "1e-12")),
        (within("n", 3.0, 0.0, 0.0), ("n", "3", "0", "0")),
        (below("v", 2.5e-7, 1e-6), ("v", "2.5e-07", "< 1e-06", "bound")),
        (above("e", math.inf, 0.5), ("e", "inf", "> 0.5", "bound")),
    ],
)
def test_a_row_shows_as_many_digits_as_its_tolerance_needs(row, text):
    assert as_text(row) == text
