"""The rows of sheared packings, for a small one at a small strain."""

import math

import pytest

from ecume.analysis.series import Mean
from ecume.errors import Diverged
from ecume_validation import spheres

RUN = spheres.Run("sheared-packing", 1.0, 1)
PIECE = spheres.Piece(10.0, 1.0, 1e-9, 1e-11, Mean(1.0, 0.01), Mean(1.0, 0.01))


@pytest.mark.compiled
def test_a_small_packing_keeps_its_balance_and_a_symmetric_stress():
    frames = spheres._frames(spheres.scene_of(RUN, strain=0.2, spheres=8))
    piece = spheres.piece_of(frames, 0.2)
    rows = {row.name.split(": ")[1]: row for row in spheres.rows_of("small", piece, 0.2)}
    for name in ("strain", "force left on a sphere", "asymmetry of the stress"):
        assert rows[name].met
    assert piece.asymmetry > 0.0
    assert piece.late.value > piece.early.value > 0.0


@pytest.mark.compiled
def test_a_run_that_ends_too_early_is_not_met(monkeypatch):
    def broken(scene):
        yield next(iter(simulated(scene)))
        raise Diverged("no step is short enough")

    simulated = spheres.simulate
    monkeypatch.setattr(spheres, "simulate", broken)
    piece = spheres.piece_of(spheres._frames(spheres.scene_of(RUN, strain=0.2, spheres=8)), 0.2)
    assert not any(row.met for row in spheres.rows_of("broken", piece, 0.2))
    assert not spheres.stationary("sheared-packing", 1.0, [piece, PIECE, PIECE]).met


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("template", spheres.CONTROLS)
def test_the_error_of_the_energy_budget_of_a_packing_falls_with_the_order_of_the_scheme(template):
    assert spheres.budget(template).met


def test_a_stress_that_grows_in_every_run_is_not_stationary():
    row = spheres.stationary("sheared-packing", 1.0, 3 * [PIECE._replace(late=Mean(1.1, 0.01))])
    assert math.isclose(row.computed, 1.1)
    assert not row.met
    assert spheres.stationary("sheared-packing", 1.0, 3 * [PIECE]).met


def test_the_scatter_over_seeds_counts_where_blocks_are_shorter_than_the_memory():
    changes = [PIECE._replace(late=Mean(late, 0.01)) for late in (0.8, 1.0, 1.3)]
    row = spheres.stationary("sheared-packing", 1.0, changes)
    assert row.met
    assert row.tolerance > 0.3


def test_a_finished_run_is_not_computed_again(monkeypatch, tmp_path):
    monkeypatch.setattr(spheres, "_frames", lambda _: [])
    monkeypatch.setattr(spheres, "piece_of", lambda *_: PIECE)
    assert spheres.piece(RUN, tmp_path) == PIECE
    monkeypatch.setattr(spheres, "piece_of", None)
    assert spheres.piece(RUN, tmp_path) == PIECE
