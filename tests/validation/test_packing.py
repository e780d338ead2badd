"""The rows of sheared packings, for a small one at a small strain."""

import pytest

from ecume.errors import Diverged
from ecume.validation import packing

pytestmark = pytest.mark.compiled


def test_a_small_packing_keeps_its_balance_and_a_symmetric_stress():
    rows = {row.name.split(": ")[1]: row for row in packing.rows_of("sheared-packing", 1.0, 1, strain=0.2, spheres=8)}
    assert len(rows) == 5
    for name in ("strain", "force left on a sphere", "asymmetry of the stress"):
        assert rows[name].met
    assert rows["asymmetry of the stress"].computed > 0.0


def test_a_run_that_ends_too_early_is_not_met(monkeypatch):
    def broken(scene):
        yield next(iter(simulated(scene)))
        raise Diverged("no step is short enough")

    simulated = packing.simulate
    monkeypatch.setattr(packing, "simulate", broken)
    (row,) = packing.rows_of("pressed-packing", 1.0, 1, strain=0.2, spheres=8)
    assert not row.met
