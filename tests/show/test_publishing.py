"""Figures for a paper: width, title, several runs and an experiment in one, and their numbers."""

import csv

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.show.publishing import Finish, curves_of, finished, read_measured, together, with_measured, written_data
from ecume.show.style import figure

TIME = np.linspace(0.0, 2.0, 5)


def drawn(unit="kPa", scale=1.0, panels=1):
    made = figure(6.4, 4.0)
    for place in range(panels):
        axes = made.add_subplot(panels, 1, place + 1, xlabel="time (s)", ylabel=f"pressure ({unit})", title="Pressure")
        axes.plot(TIME, scale * TIME**2, label="gauge-1")
        axes.axhline(0.0)
    return made


def test_a_figure_gets_the_width_of_a_column_and_loses_its_title():
    made = finished(drawn(), Finish(width=0.086, title=False))
    assert made.get_size_inches() == pytest.approx([86.0 / 25.4, 86.0 / 25.4 * 4.0 / 6.4])
    assert made.axes[0].get_title(loc="left") == made.axes[0].get_title() == ""


@pytest.mark.parametrize("width", [0.001, 0.0299])
def test_a_figure_without_room_for_its_panels_is_refused(width):
    with pytest.raises(BadInput, match=r"mm wide has no room for its panels; expected at least 30 mm"):
        finished(drawn(), Finish(width=width))
    finished(drawn(), Finish(width=0.03))


def test_runs_in_one_figure_have_the_same_unit_and_their_names():
    both = together([("coarse", drawn()), ("fine", drawn(unit="Pa", scale=1000.0))])
    one, other = curves_of(both.axes[0])
    assert one.name == "gauge-1, coarse"
    assert other.name == "gauge-1, fine"
    assert other.line.get_ydata() == pytest.approx(one.line.get_ydata())
    assert one.line.get_linestyle() != other.line.get_linestyle()
    assert both.axes[0].get_ylim()[1] >= 4.0


def test_limits_contain_all_runs():
    both = together([("low", drawn()), ("high", drawn(scale=10.0))])
    assert both.axes[0].get_ylim()[1] >= 40.0


def test_other_panels_and_other_dimensions_are_refused():
    with pytest.raises(BadInput, match="has 2 panels; expected 1"):
        together([("one", drawn()), ("two", drawn(panels=2))])
    with pytest.raises(BadInput, match="two: is in mm; expected kPa"):
        together([("one", drawn()), ("two", drawn(unit="mm"))])


def test_an_experiment_is_drawn_in_the_units_of_the_axes(tmp_path):
    (tmp_path / "lab.csv").write_text("time [ms],pressure [Pa]\n0,0\n1000,1100\n2000,\n")
    made = with_measured(drawn(), read_measured(tmp_path / "lab.csv"))
    points = curves_of(made.axes[0])[-1]
    assert points.name == "pressure, lab"
    assert points.line.get_xdata() == pytest.approx([0.0, 1.0, 2.0])
    assert points.line.get_ydata()[:2] == pytest.approx([0.0, 1.1])
    (tmp_path / "lab.csv").write_text("time [s],height [mm]\n0,0\n")
    with pytest.raises(BadInput, match="fits no axes of the figure"):
        with_measured(drawn(), read_measured(tmp_path / "lab.csv"))


def test_a_column_without_a_unit_is_not_taken_for_that_of_the_figure(tmp_path):
    """The figure chooses kPa, and the numbers are in Pa."""
    (tmp_path / "lab.csv").write_text("time [s],pressure\n0,0\n1,1100\n")
    with pytest.raises(BadInput, match="'pressure' has no unit: write it into the head"):
        with_measured(drawn(), read_measured(tmp_path / "lab.csv"))
    (tmp_path / "lab.csv").write_text("time [s],pressure [kPa]\n0,0\n1,1.1\n")
    counts = figure(6.4, 4.0)
    counts.add_subplot(xlabel="time (s)", ylabel="contacts").plot(TIME, TIME)
    with pytest.raises(BadInput, match="fits no axes of the figure"):
        with_measured(counts, read_measured(tmp_path / "lab.csv"))
    (tmp_path / "lab.csv").write_text("time [ms],contacts\n0,0\n1000,1\n")
    points = curves_of(with_measured(counts, read_measured(tmp_path / "lab.csv")).axes[0])[-1]
    assert points.line.get_xydata().tolist() == [[0.0, 0.0], [1.0, 1.0]]


@pytest.mark.parametrize(
    ("text", "message"), [("", "expected a line of heads"), ("t,p\n1\n", "row 2: got 1 cells"), ("t,p\n1,x\n", "row 2")]
)
def test_a_table_that_is_none_is_refused_with_its_row(tmp_path, text, message):
    (tmp_path / "lab.csv").write_text(text)
    with pytest.raises(BadInput, match=message):
        read_measured(tmp_path / "lab.csv")


def test_the_numbers_of_a_figure_are_its_curves_to_the_last_digit(tmp_path):
    written_data(drawn(panels=2), tmp_path / "fig.csv")
    rows = list(csv.DictReader((tmp_path / "fig.csv").read_text().splitlines()))
    assert {row["panel"] for row in rows} == {"1", "2"}
    assert rows[0] | {"x": "", "y": ""} == {
        "panel": "1", "series": "gauge-1", "x_axis": "time (s)", "y_axis": "pressure (kPa)", "x": "", "y": "",
    }  # fmt: skip
    assert [float(row["y"]) for row in rows[:5]] == (TIME**2).tolist()
    with pytest.raises(BadInput, match="picture without curves"):
        written_data(figure(), tmp_path / "none.csv")


def test_the_numbers_of_points_with_errors_are_their_values_and_the_ends_of_the_bars(tmp_path):
    """Caps of error bars were written as curves of their own. Means of too few values have no error."""

    def with_bars(shift):
        made = figure()
        axes = made.subplots()
        height, unknown = np.array([3.0, 5.0, 6.0]) + shift, float("nan")
        axes.errorbar([1.0, 2.0, 3.0], height, yerr=[0.5, 0.25, unknown], xerr=0.125, capsize=2, label="mean")
        axes.set(xlabel="rate (1/s)", ylabel="stress (Pa)")
        return made

    written_data(with_bars(0.0), tmp_path / "fig.csv")
    first, second, third = csv.DictReader((tmp_path / "fig.csv").read_text().splitlines())
    assert (first["series"], first["y_low"], first["y_high"]) == ("mean", "2.5", "3.5")
    assert (third["x_low"], third["y"], third["y_low"], third["y_high"]) == ("2.875", "6.0", "nan", "nan")
    assert [float(second[each]) for each in ("x_low", "x", "x_high", "y")] == [1.875, 2.0, 2.125, 5.0]
    both = together([("one", with_bars(0.0)), ("two", with_bars(1.0))])
    written_data(both, tmp_path / "both.csv")
    rows = list(csv.DictReader((tmp_path / "both.csv").read_text().splitlines()))
    assert [(row["series"], row["y_low"]) for row in rows] == [
        ("mean, one", "2.5"), ("mean, one", "4.75"), ("mean, one", "nan"),
        ("mean, two", "3.5"), ("mean, two", "5.75"), ("mean, two", "nan"),
    ]  # fmt: skip


def test_points_of_an_experiment_below_all_curves_are_not_at_the_edge(tmp_path):
    (tmp_path / "lab.csv").write_text("time [s],pressure [kPa]\n0,-2\n1,9\n")
    axes = with_measured(drawn(), read_measured(tmp_path / "lab.csv")).axes[0]
    low, high = axes.get_ylim()
    assert low < -2.2
    assert high > 9.2


@pytest.mark.parametrize(
    ("end", "unit", "seconds"),
    [
        (2e-6, "µs", 1e-6),
        (0.05, "ms", 1e-3),
        (20.0, "s", 1.0),
        (1800.0, "min", 60.0),
        (8e4, "h", 3600.0),
        (1e6, "d", 86400.0),
    ],
)
def test_times_have_a_suitable_unit_and_round_ticks(end, unit, seconds):
    made = figure(6.4, 4.0)
    axes = made.add_subplot(xlabel="time (s)", ylabel="pressure (kPa)")
    axes.plot(end * TIME / TIME[-1], TIME)
    axes.set_xlim(0.0, end)
    finished(made, Finish())
    made.draw_without_rendering()
    assert axes.get_xlabel() == f"time ({unit})"
    assert curves_of(axes)[0].line.get_xdata()[-1] == end
    for text in axes.get_xticklabels():
        assert float(text.get_text()) * seconds == pytest.approx(text.get_position()[0])
        assert len(text.get_text()) <= 4
    assert 3 < len(axes.get_xticklabels()) < 15


@pytest.mark.parametrize(("ends", "unit"), [((1e5, 1e5 + 3.0), "s"), ((1.8e4, 2.16e4), "h"), ((-0.03, 0.0), "ms")])
def test_a_short_part_of_a_long_time_has_the_unit_of_its_length(ends, unit):
    made = figure(6.4, 4.0)
    axes = made.add_subplot(xlabel="time (s)", xlim=ends)
    finished(made, Finish())
    assert axes.get_xlabel() == f"time ({unit})"


def test_lengths_and_logarithms_stay_as_they_are():
    made = figure(6.4, 4.0)
    length, lag = made.subplots(1, 2)
    length.set(xlabel="height (m)", xlim=(0.0, 1e-3))
    lag.set(xlabel="lag (s)", xscale="log", xlim=(1e-3, 1e5))
    finished(made, Finish())
    assert (length.get_xlabel(), lag.get_xlabel()) == ("height (m)", "lag (s)")
