"""The comparison of the integrators shows what their theory says."""

import pytest
from tests.models.floating.test_motion import ORDERS

from ecume.show.floating.law_figures import (
    INTEGRATORS,
    comparison,
    integrator_comparison,
    integrators_beside_one_another,
    orders,
)

pytestmark = pytest.mark.compiled


@pytest.fixture(scope="module")
def found():
    """Every integrator on its way round."""
    return comparison()


@pytest.mark.long
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_errors_fall_with_the_order_of_the_integrator(found, integrator):
    assert orders(found)[integrator] == pytest.approx(ORDERS[integrator], abs=0.1)


@pytest.mark.long
@pytest.mark.parametrize("integrator", ["velocity-verlet", "stormer-verlet", "semi-implicit-euler"])
def test_a_symplectic_scheme_keeps_the_energy_within_bounds(found, integrator):
    drift = found.drifts[integrator]
    assert drift[-20:].max() < 1.2 * drift[:20].max()


@pytest.mark.long
def test_runge_kutta_loses_energy_steadily_and_explicit_euler_all_of_it(found):
    rk4 = found.drifts["rk4"]
    assert rk4[-1] == pytest.approx(2 * rk4[len(rk4) // 2 - 1], rel=0.1)
    assert found.drifts["explicit-euler"][-1] > 0.3


@pytest.mark.long
def test_the_figure_names_every_integrator_with_its_order(found, tmp_path):
    drawn = integrators_beside_one_another(found)
    said = [text.get_text() for text in drawn.legends[0].get_texts()]
    assert "velocity Verlet (order 2.0)" in said
    assert len(said) == len(INTEGRATORS)
    assert [axes.get_xlabel() for axes in drawn.axes] == ["time step (ms)", "time (s)"]


@pytest.mark.long
def test_the_comparison_is_written_where_it_is_wanted(found, tmp_path, monkeypatch):
    monkeypatch.setattr("ecume.show.floating.law_figures.comparison", lambda: found)
    out = integrator_comparison(tmp_path / "deep" / "integrators.pdf")
    assert out == tmp_path / "deep" / "integrators.pdf"
    assert out.read_bytes().startswith(b"%PDF")
