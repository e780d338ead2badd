"""Axes that show what matters: limits without outliers, logarithms only where they help, counts from start to end."""

import matplotlib as mpl
import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.show.curves import cut_spikes, evolution, limits_without_spikes, scaling
from ecume.show.soft.measures import cumulative
from ecume.show.style import DARK_CANVAS, LEAST_CONTRAST, contrast, figure, seen_part
from ecume.trajectories.frame import Frame


def test_a_step_line_of_one_event_runs_from_the_start_to_the_end():
    instants, counts = cumulative(np.array([35.0]), np.array([0.0, 1.0, 60.0]))
    assert instants.tolist() == [0.0, 35.0, 60.0]
    assert counts.tolist() == [0, 1, 1]


def test_without_events_the_step_line_stays_at_zero():
    instants, counts = cumulative(np.zeros(0), np.array([2.0, 60.0]))
    assert instants.tolist() == [2.0, 60.0]
    assert counts.tolist() == [0, 0]


@pytest.mark.parametrize(("values", "kind"), [([1.3, 2.0], "linear"), ([1.0, 10.0], "log"), ([0.0, np.nan], "linear")])
def test_less_than_a_decade_is_drawn_on_a_linear_axis(values, kind):
    assert scaling(values) == kind


def spike():
    """A pressure of a few kPa after an impact of one sample."""
    values = np.where(np.arange(120) < 40, 0.0, 3.0 + np.sin(np.arange(120)))
    values[42], values[43] = 98.8, -31.0
    return values


def test_one_spike_does_not_compress_a_curve_and_its_value_is_annotated():
    axes = figure().add_subplot()
    cut_spikes(axes, np.arange(120.0), np.array([spike()]), "kPa")
    low, high = axes.get_ylim()
    assert (low, high) == (pytest.approx(-0.5, abs=0.1), pytest.approx(4.5, abs=0.1))
    assert [text.get_text() for text in axes.texts] == ["98.8 kPa", "-31 kPa"]
    assert [line.get_ydata()[0] for line in axes.lines] == pytest.approx([4.24, -0.24], abs=0.05)


@pytest.mark.parametrize(
    "values", [np.linspace(0.0, 1.0, 60) ** 3, np.sin(np.arange(60.0)), np.zeros(60), spike()[36:50]]
)
def test_a_curve_without_outliers_keeps_its_range(values):
    assert limits_without_spikes([values]) == (values.min(), values.max())


def test_a_run_of_one_frame_has_no_evolution():
    frame = Frame(0.25, {}, {}, {})
    with pytest.raises(BadInput, match=r"single frame, at 0.25 s"):
        evolution([frame])
    assert evolution([frame, frame]) == [frame, frame]


def test_contrasts_are_those_of_the_standard():
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.01)


@pytest.mark.parametrize("name", ["viridis", "cividis", "RdBu_r"])
def test_no_color_of_a_map_vanishes_on_a_dark_page(name):
    colors = mpl.colormaps[name]
    low, high = seen_part(colors, DARK_CANVAS)
    assert 0.0 < low < 0.35
    assert high > 0.85
    assert min(contrast(colors(part)[:3], DARK_CANVAS) for part in np.linspace(low, high, 64)) >= 0.98 * LEAST_CONTRAST
    assert contrast(colors(0.0)[:3], DARK_CANVAS) < 1.5
