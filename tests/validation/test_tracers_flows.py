"""The quick comparisons of tracers in flows, and the exact series of the others."""

import numpy as np
import pytest

from ecume_validation import tracers_flows


def test_saffman_s_lift_is_that_of_an_integrator_of_order_eight():
    assert all(row.met for row in tracers_flows.lift())


@pytest.mark.compiled
@pytest.mark.long
@pytest.mark.parametrize(
    "rows",
    [
        tracers_flows.gyres,
        tracers_flows.cells,
        tracers_flows.expelled,
        tracers_flows.near_a_wall,
        tracers_flows.orbits,
    ],
)
def test_the_rows_of_a_quick_comparison_are_met(rows):
    assert not [row for row in rows() if not row.met]


def test_the_series_of_dispersion_end_at_taylor_and_aris():
    for modes, divisor in ((tracers_flows.slit_modes(), 210.0), (tracers_flows.tube_modes(), 48.0)):
        late = tracers_flows.variance(np.array([1e6]), 100.0, modes)[0]
        assert late == pytest.approx(1.0 + 1e4 / divisor, rel=1e-4)
        early = tracers_flows.variance(np.array([1e-6]), 100.0, modes)[0]
        assert early == pytest.approx(1.0 + 1e4 * modes[0].sum() * 0.5e-6, rel=1e-3)
