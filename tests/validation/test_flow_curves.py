"""Flow curves: pieces are kept, the texts beside the tables state what follows from them, and units do not matter."""

import json
import math
import re

import numpy as np
import pytest

from ecume.analysis.series import Mean
from ecume.trajectories.frame import Frame
from ecume_validation import rheology, soft_glasses, suspensions
from ecume_validation.rheology import Piece
from ecume_validation.runner import DATA


def test_the_readme_states_the_fit_of_the_computed_pieces():
    pieces = rheology.computed()
    assert {(one.rate, one.seed) for one in pieces} == {(r, s) for r in rheology.RATES for s in rheology.SEEDS}
    text, fit = (DATA / "rheology" / "README.md").read_text(encoding="utf-8"), rheology.fitted(pieces)
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
        fit = rheology.fitted([one for one in pieces if one.rate <= rheology.RATES[count - 1]])
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
    monkeypatch.setattr(rheology, "simulate", lambda scene: flowing(calls))
    first = rheology.piece(0.25, 1, tmp_path)
    assert rheology.piece(0.25, 1, tmp_path) == first
    assert len(calls) == 1
    rheology.piece(0.25, 2, tmp_path)
    assert len(calls) == 2
    (path, _) = sorted(tmp_path.iterdir())
    assert len(json.loads(path.read_text(encoding="utf-8"))) == len(first)
    assert re.fullmatch(r"[0-9a-f]{16}-[0-9a-f]{16}\.json", path.name)  # of the scene, and of the code
    assert first.shear.value == pytest.approx(2.0, abs=0.03)
    assert first.first_difference.value == pytest.approx(-2.0)
    assert first.settled


def test_a_slow_decay_of_the_stress_is_not_met():
    decaying = [rheology.Instant(step / 50, 5.0 - step / 400, 5.0, 0.0, 0.1, 1e-10) for step in range(600)]
    pieces = [rheology.piece_of(rate, 1, decaying) for rate in (1.0, 2.0, 4.0)]
    assert not any(one.settled for one in pieces)


@pytest.mark.compiled
def test_a_run_in_other_units_has_the_same_stress_over_its_unit():
    row = rheology.units(strain=0.02)
    assert row.met


def readme(name):
    return (DATA / name / "README.md").read_text(encoding="utf-8")


def test_the_readme_of_soft_glasses_states_the_fits():
    pieces, text = soft_glasses.computed(), readme("soft_glasses")
    assert set(pieces) == set(soft_glasses.FLOWS)
    common = soft_glasses.friction_curve(list(pieces.values()))
    assert f"the exponent {common.exponent.value:.2f} ± {common.exponent.error:.2f}" in text
    for fraction in soft_glasses.FITTED:
        fit = soft_glasses.curve(pieces, fraction)
        assert f"m = {fit.exponent.value:.3f} ± {fit.exponent.error:.3f}" in text
        assert f"σ_y = {1e3 * fit.offset.value:.1f} ± {1e3 * fit.offset.error:.1f} mN/m" in text
    assert all(row.name.split(",")[0] in text for row in soft_glasses.rows_of_pieces(pieces) if not row.met)


def test_the_readme_of_soft_glasses_states_the_effect_of_the_size():
    larger = soft_glasses.computed("doubled")
    assert tuple(larger) == soft_glasses.DOUBLED
    for row in soft_glasses.rows_of_sizes(soft_glasses.computed(), larger):
        assert row.met
        assert f"{row.computed:.2f}" in readme("soft_glasses")


def test_the_readme_of_suspensions_states_jamming_and_thickening():
    pieces, text = suspensions.computed(), readme("suspensions")
    assert set(pieces) == set(suspensions.FLOWS)
    for law in suspensions.DIVERGING:
        found = suspensions.jamming(pieces, law)
        assert f"| {found.fraction.value:.3f} ± {found.fraction.error:.3f} |" in text
        assert f"| {found.exponent.value:.2f} ± {found.exponent.error:.2f} |" in text
    rows = list(suspensions.rows_of_pieces(pieces))
    assert f"{rows[-1].computed:.1f}" in text
    assert all(row.name.split(",")[0] in text for row in rows if not row.met)


def test_viscosities_that_do_not_diverge_miss_their_rows():
    """One path of a rearranging flow may be so: the other rows are compared nevertheless."""
    pieces = suspensions.computed()
    lower, densest = suspensions.DIVERGING["frictional"][-2:]
    rows = list(suspensions.rows_of_pieces(pieces | {densest: pieces[lower]}))
    assert len(rows) == len(list(suspensions.rows_of_pieces(pieces)))
    missed = [row.name for row in rows if not row.met]
    assert any("with μ = 1" in name for name in missed)
    assert any("misfit" in name for name in missed)


def flow_of(shear, pressure, difference=0.0):
    means = (Mean(shear, 0.01 * shear), Mean(pressure, 0.01 * pressure), Mean(difference, 0.0))
    return Piece(suspensions.RATE, 1, *means, settled=True, least_pressure=1.0, largest_deflection=0.1,
                 largest_imbalance=0.0)  # fmt: skip


def test_viscosity_and_pressure_give_the_fraction_of_jamming_with_their_own_exponents():
    unit = suspensions.VISCOSITY * suspensions.RATE * suspensions.DIAMETER
    flows = suspensions.DIVERGING["frictionless"]
    distance = {flow: 1.0 - flow.fraction / 0.85 for flow in flows}
    pieces = {flow: flow_of(2.0 * unit * near**-1.5, 0.1 * unit * near**-2.5) for flow, near in distance.items()}
    for diverging, exponent in ((suspensions.viscosity, 1.5), (suspensions.pressure_viscosity, 2.5)):
        found = suspensions.jamming(pieces, "frictionless", diverging)
        assert found.fraction.value == pytest.approx(0.85, rel=1e-6)
        assert found.exponent.value == pytest.approx(exponent, rel=1e-5)
        assert 0.0 < found.fraction.error < 0.01


def test_a_flow_that_is_not_stationary_is_computed_again_to_twice_the_strain(monkeypatch, tmp_path):
    ends = []

    def kept(scene, _, folder):
        assert folder == tmp_path
        ends.append(scene.duration * suspensions.RATE)
        return flow_of(1.0, 1.0)._replace(settled=len(ends) != 2)

    monkeypatch.setattr(suspensions, "kept", kept)
    flow = suspensions.Flow("frictional", 0.68)
    assert suspensions.piece(flow, 1, tmp_path).settled  # at once
    assert suspensions.piece(flow, 1, tmp_path).settled  # the second time
    assert ends == pytest.approx([4.0, 4.0, 7.0])


def test_friction_counts_the_liquid_and_the_compression_across_the_planes_of_shear():
    unit = suspensions.VISCOSITY * suspensions.RATE * suspensions.DIAMETER
    number, friction = suspensions.friction_point(flow_of(3.0 * unit, 9.0 * unit, 2.0 * unit))
    assert number.value == pytest.approx(0.1)
    assert friction.value == pytest.approx(0.4)
    assert friction.error == pytest.approx(0.4 * math.hypot(0.09 / 10.0, 0.03 / 4.0))
    assert np.isclose(suspensions.published_friction(0.6), 0.1 / 0.6 + 0.6 + 1.7)
