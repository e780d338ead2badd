"""The flow curve: pieces are kept, the README states what follows from them, and units do not matter."""

import json
import re

import numpy as np
import pytest

from ecume.trajectories.frame import Frame
from ecume.validation import flow_pieces, rheology
from ecume.validation.runner import DATA


def test_the_readme_states_the_fit_of_the_computed_pieces():
    pieces = rheology.computed()
    assert {(one.rate, one.seed) for one in pieces} == {(r, s) for r in rheology.RATES for s in rheology.SEEDS}
    text, fit = (DATA / "rheology" / "README.md").read_text(encoding="utf-8"), flow_pieces.fitted(pieces)
    exponent = f"m = {fit.exponent.value:.3f} ± {fit.exponent.error:.3f}"
    stress = f"σ_y = {1e3 * fit.offset.value:.1f} ± {1e3 * fit.offset.error:.1f} mN/m"
    assert exponent in text
    assert stress in text
    rows = {row.name.split(",")[0]: row for row in rheology.rows_of_pieces(pieces)}
    assert rows["largest force left on a sphere"].met
    assert rows["exponent of the default laws"].computed == fit.exponent.value
    missed = [name for name, row in rows.items() if not row.met]
    assert all(name in text for name in missed)


def test_the_readme_states_how_the_exponent_depends_on_the_range_and_on_the_pressure():
    pieces, text = rheology.computed(), (DATA / "rheology" / "README.md").read_text(encoding="utf-8")
    for count in range(4, len(rheology.RATES) + 1):
        fit = flow_pieces.fitted([one for one in pieces if one.rate <= rheology.RATES[count - 1]])
        stress = f"{1e3 * fit.offset.value:.1f} ± {1e3 * fit.offset.error:.1f}"
        exponent = f"{fit.exponent.value:.3f} ± {fit.exponent.error:.3f}"
        assert f"| {stress} | {exponent} | {fit.misfit:.1f} |" in text
    common = rheology.friction_curve(pieces)
    assert f"{common.exponent.value:.2f} ± {common.exponent.error:.2f}" in text
    assert f"{common.offset.value:.2f} ± {common.offset.error:.2f}" in text


def test_the_readme_states_the_effect_of_the_size():
    larger, text = rheology.computed("doubled"), (DATA / "rheology" / "README.md").read_text(encoding="utf-8")
    assert tuple(one.rate for one in larger) == rheology.DOUBLED
    for row in rheology.rows_of_sizes(rheology.computed(), larger):
        assert row.met
        assert f"{row.computed:.2f} ± {float(row.name.split('± ')[1]):.2f}" in text


def flowing(calls, count=600):
    noise = np.random.default_rng(1).normal(size=count)
    for step in range(count):
        numbers = {"strain": step / 50, "shear_stress": 2.0 + 0.1 * noise[step], "pressure": 5.0,
                   "largest_deflection": 0.1, "imbalance": 1e-10}  # fmt: skip
        numbers |= {"stress_squeeze_xx": -6.0, "stress_squeeze_yy": -4.0}
        numbers |= dict.fromkeys(("stress_squeeze_xy", "stress_squeeze_yx"), 2.0)
        yield Frame(0.1 * step, {"position": np.zeros((1, 2))}, numbers, {})
    calls.append(1)


def test_a_finished_piece_is_kept_and_not_computed_again(monkeypatch, tmp_path):
    calls = []
    monkeypatch.setattr(flow_pieces, "simulate", lambda scene: flowing(calls))
    first = rheology.piece(0.25, 1, tmp_path)
    assert rheology.piece(0.25, 1, tmp_path) == first
    assert len(calls) == 1
    rheology.piece(0.25, 2, tmp_path)
    assert len(calls) == 2
    (path, _) = sorted(tmp_path.iterdir())
    assert len(json.loads(path.read_text(encoding="utf-8"))) == len(first)
    assert re.fullmatch(r"[0-9a-f]{16}\.json", path.name)
    assert first.shear.value == pytest.approx(2.0, abs=0.03)
    assert first.first_difference.value == pytest.approx(-2.0)
    assert first.settled


def test_a_slow_decay_of_the_stress_is_not_met():
    decaying = [flow_pieces.Instant(step / 50, 5.0 - step / 400, 5.0, 0.0, 0.1, 1e-10) for step in range(600)]
    pieces = [flow_pieces.piece_of(rate, 1, decaying) for rate in (1.0, 2.0, 4.0)]
    assert not any(one.settled for one in pieces)


@pytest.mark.compiled
def test_a_run_in_other_units_has_the_same_stress_over_its_unit():
    row = rheology.units(strain=0.02)
    assert row.met
