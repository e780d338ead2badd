"""Contact lines that move: the references against their own limits, and what the cases see."""

import math

import numpy as np
import pytest

from ecume.trajectories.frame import Frame
from ecume_validation import capillary_rise, sliding_drops
from ecume_validation.contact_lines import line_friction
from ecume_validation.runner import sph_scene

TROUGH = capillary_rise.trough_of(sph_scene("capillary_rise"))
TIMES = np.arange(0.0, 0.061, 2e-3)


def test_a_column_creeps_to_the_height_of_jurin():
    """The difference of levels bears the tension of both plates, less that of the reservoir's."""
    last = capillary_rise.height(TROUGH, np.array([0.0, 5.0]))[-1]
    level = TROUGH.start - (last - TROUGH.start) * TROUGH.gap / TROUGH.reservoir
    assert last - level == pytest.approx(1e-5 / 9.81 * (2.0 / 1e-3 - 1.0 / 3e-3), rel=1e-6)


def test_without_weight_and_reservoir_a_column_fills_a_gap_as_bosanquet_and_washburn_have_it():
    """h^2 = 2 b/a (t - (1 - e^(-a t))/a) with a = 12 nu/d^2; where friction rules, it differs by nothing else."""
    viscous = TROUGH._replace(
        reservoir=1e6, passage=0.0, start=1e-7, gravity=0.0, lines=0.0, viscosity=5e-3, drive=1e-5
    )
    a, times = 12.0 * 5e-3 / 1e-3**2, np.linspace(0.0, 0.05, 6)
    closed = np.sqrt(2.0 * 2e-2 / a * (times - (1.0 - np.exp(-a * times)) / a))
    np.testing.assert_allclose(capillary_rise.height(viscous, times)[1:], closed[1:], rtol=2e-3)


def test_the_case_sees_a_column_that_is_slow_or_low_and_one_without_friction_at_its_lines():
    heights = capillary_rise.height(TROUGH, TIMES)
    assert all(row.met for row in capillary_rise.rows_of("", TROUGH, TIMES, heights))
    bare = capillary_rise.height(TROUGH._replace(lines=0.0), TIMES)
    for broken in (bare, heights[0] + 0.9 * (heights - heights[0]), np.interp(TIMES - 5e-3, TIMES, heights)):
        assert not all(row.met for row in capillary_rise.rows_of("", TROUGH, TIMES, broken))


def test_the_height_of_a_column_is_the_volume_in_the_gap():
    position = np.array([[0.5e-3, 1.5e-3], [0.5e-3, 0.5e-3], [2.0e-3, 1.5e-3]])
    frame = Frame(0.0, {"position": position, "mass": np.full(3, 0.01)}, {}, {})
    assert capillary_rise.column(frame, sph_scene("capillary_rise")) == pytest.approx(0.01)


def test_wedges_drag_as_thin_films_do_where_they_are_flat():
    """The stress 3 eta u/h along the film h = a x gives 3/a for each logarithm."""
    assert line_friction(0.01, math.e, 1.0) == pytest.approx(3.0 / 0.01, rel=1e-4)
    assert line_friction(math.pi, math.e, 1.0) == pytest.approx(0.0, abs=1e-12)  # a drop that only touches


def test_a_drop_at_rest_is_half_a_disc_at_90_degrees():
    found = sliding_drops.wedge_of(math.pi / 2.0, sph_scene("sliding_drops"))
    assert found.center == pytest.approx(4.0 / (3.0 * math.pi) * math.sqrt(4e-6 / math.pi))


@pytest.mark.parametrize("fault", [{"force": 7e-3}, {"center": 2.9e-4}, {"speed": 0.025}])
def test_the_case_sees_drops_that_slide_too_fast_are_flat_or_unbalanced(fault):
    wedge = sliding_drops.wedge_of(math.radians(60.0), sph_scene("sliding_drops"))
    good = sliding_drops.Slide(8e-3 / (0.02 * wedge.drag), 8e-3, 8e-3, wedge.center)
    assert all(row.met for row in sliding_drops.rows_of(60, good, 0.02))
    assert not all(row.met for row in sliding_drops.rows_of(60, good._replace(**fault), 0.02))
