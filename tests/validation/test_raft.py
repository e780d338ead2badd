"""The raft of nineteen, of which the case `raft` demands more."""

import pytest

from ecume.validation.raft import raft


@pytest.mark.compiled
@pytest.mark.parametrize("friction", [0.0, pytest.param(0.3, marks=pytest.mark.long)])
def test_nineteen_attracted_floats_gather_and_nothing_sinks_or_is_made(friction):
    rows = raft(0.04, friction, seeds=range(1, 10))
    assert len(rows) >= 4
    assert [row.name for row in rows if not row.met] == []
