"""Figures of a sweep show the numbers of its table."""

import csv
import re
from typing import ClassVar

import numpy as np
import pytest
from typer.testing import CliRunner

from ecume.analysis.series import Mean
from ecume.cli import app
from ecume.cli.sweeps import _fit_all
from ecume.errors import BadInput
from ecume.show.style import figure
from ecume.sweep import figures
from ecume.sweep.figures import Column, column_of, edges, plot_sweep, scatter, sweep_figure
from ecume.sweep.fits import Points, fit_of, points_of
from ecume.sweep.results import representing
from ecume.sweep.spec import Axis


class Made:
    """A sweep's table, made up."""

    title, directory, drawn = "Costs $5", "nowhere", False
    axes = ("gap", "force", "repeat")
    ways = ("gap", "force")
    written_units: ClassVar[dict[str, str]] = {}

    def units(self, columns):
        return {"gap": "m"}

    def table(self):
        rows = [
            {"gap": gap, "force": force, "repeat": repeat, "state": "done", "word": "t1", "time": gap / force + repeat}
            for gap in (1e-3, 1e-2, 1e-1)
            for force in (1.0, 2.0)
            for repeat in (0, 2)
        ]
        return [*rows, {"gap": 1.0, "force": 1.0, "repeat": 0, "state": "failed", "word": "", "time": np.nan}]


def test_curves_are_means_with_their_errors():
    (axes, *_) = sweep_figure(Made(), "curves").axes
    first = axes.containers[0]
    np.testing.assert_allclose(first.lines[0].get_xydata(), [(1e-3, 1.001), (1e-2, 1.01), (1e-1, 1.1)])
    (bars,) = first.lines[2]
    np.testing.assert_allclose([np.ptp(one[:, 1]) for one in bars.get_segments()], 2.0)
    assert axes.get_xscale() == "log"
    assert axes.get_xlabel() == "gap (m)"
    assert axes.get_ylabel() == "time\nmean of 2 runs"
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["force 1", "force 2"]


def test_an_axis_is_in_the_unit_of_the_file():
    class Written(Made):
        written_units: ClassVar[dict[str, str]] = {"gap": "mm", "force": "mN"}

    (axes, *_) = sweep_figure(Written(), "curves").axes
    assert axes.get_xlabel() == "gap (mm)"
    np.testing.assert_allclose(axes.containers[0].lines[0].get_xdata(), [1.0, 10.0, 100.0])
    assert Column("gap", np.array([2.0]), unit="mm", written=True).at(2.0) == "2 mm"


def test_a_map_has_a_field_for_each_pair():
    (axes, *_) = sweep_figure(Made(), "map").axes
    (mesh,) = axes.collections
    np.testing.assert_allclose(mesh.get_array(), [[1.001, 1.01, 1.1], [1.0005, 1.005, 1.05]])


def test_fields_lie_around_their_values_on_a_logarithmic_axis():
    np.testing.assert_allclose(edges(np.array([1e-3, 1e-2, 1e-1])), 10.0 ** np.array([-3.5, -2.5, -1.5, -0.5]))


def test_a_scatter_has_a_dot_for_each_run():
    (axes, *_) = sweep_figure(Made(), "scatter").axes
    assert len(axes.collections[0].get_offsets()) == 12


def test_a_scatter_of_three_axes_distinguishes_them_by_color_and_marker():
    on = figure().add_subplot()
    columns = [Column(f"floats[0].{name}", np.array(values), unit="m") for name, values in THREE.items()]
    scatter(on, columns, Column("duration", np.arange(4.0), unit="s"))
    assert [text.get_text() for text in on.get_legend().get_texts()] == ["radius 1 mm", "radius 2 mm"]
    assert sum(len(dots.get_offsets()) for dots in on.collections) == 4


THREE = {"gap": [1.0, 2.0, 3.0, 4.0], "reach": [0.1, 0.2, 0.1, 0.2], "radius": [1e-3, 1e-3, 2e-3, 2e-3]}


class Wide(Made):
    """Three axes, one of them of words, and a key that goes along with one."""

    axes = ("gap", "width", "force", "law")
    ways = ("gap", "force", "law")

    def table(self):
        return [
            {"gap": gap, "width": 2 * gap, "force": force, "law": law, "state": "done", "time": gap * force * factor}
            for gap in (1.0, 2.0, 3.0)
            for force in (1.0, 2.0)
            for law, factor in (("stokes", 1.0), ("none", 10.0))
        ]


def test_no_axis_is_averaged_over_by_curves():
    (axes, *_) = sweep_figure(Wide(), "curves").axes
    output = {text.get_text() for text in axes.get_legend().get_texts()}
    assert output == {f"force {force}, law {law}" for force in (1, 2) for law in ("stokes", "none")}
    assert axes.get_xlabel() == "gap (m)"
    ends = sorted(float(one.lines[0].get_ydata()[-1]) for one in axes.containers)
    assert ends == [3.0, 6.0, 30.0, 60.0]
    assert all(not one.has_yerr for one in axes.containers)


def test_a_map_says_over_what_it_is_averaged_and_words_are_ticks():
    axes, bar = sweep_figure(Wide(), "map").axes
    assert bar.get_ylabel() == "time, mean over law"
    np.testing.assert_allclose(axes.collections[0].get_array(), [[5.5, 11.0, 16.5], [11.0, 22.0, 33.0]])

    class Words(Wide):
        ways = ("gap", "law")

    (axes, *_) = sweep_figure(Words(), "map").axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["stokes", "none"]


def test_what_was_never_reached_has_no_error_bar():
    class Never(Made):
        def table(self):
            return [
                {
                    "gap": gap,
                    "force": 1.0,
                    "repeat": repeat,
                    "state": "done",
                    "time": np.inf if gap > 1 else 1.0 + repeat,
                }
                for gap in (1.0, 2.0)
                for repeat in (0, 2)
            ]

    (axes, *_) = sweep_figure(Never(), "curves").axes
    (bars,) = axes.containers[0].lines[2]
    assert np.ptp(bars.get_segments()[0][:, 1]) == pytest.approx(2.0)


class Drawn(Made):
    """Points that lie on no grid."""

    ways, drawn = ("gap", "force"), True

    def table(self):
        chance = np.random.default_rng(1)
        return [
            {"gap": gap, "force": force, "state": "done", "time": gap * force}
            for gap, force in chance.uniform(1.0, 2.0, (20, 2))
        ]


def test_points_that_were_drawn_are_dots_and_no_curves():
    with pytest.raises(BadInput, match="--what scatter"):
        sweep_figure(Drawn(), "curves")
    axes, bar = sweep_figure(Drawn(), "map").axes
    assert len(axes.collections[0].get_offsets()) == 20
    assert bar.get_ylabel() == "time"


@pytest.mark.long
def test_a_figure_has_the_format_the_width_and_the_table_that_were_asked_for(tmp_path, monkeypatch):
    (tmp_path / "points.json").write_text("[]")
    monkeypatch.setattr(figures, "open_sweep", lambda directory: Made())
    words = ["plot", str(tmp_path), "--what", "curves", "--format", "pdf", "--width", "86 mm", "--no-title"]
    more = ["-o", str(tmp_path / "there"), "--data", str(tmp_path / "curves.csv")]
    done = CliRunner().invoke(app, [*words, *more])
    assert done.output == f"wrote {tmp_path / 'curves.csv'}\nwrote {tmp_path / 'there' / 'curves.pdf'}\n"
    assert (tmp_path / "there" / "curves.pdf").read_bytes().startswith(b"%PDF")
    assert (
        (tmp_path / "curves.csv").read_text().startswith("panel,series,x_axis,y_axis,x,y,x_low,x_high,y_low,y_high\n")
    )
    beside = CliRunner().invoke(app, ["plot", str(tmp_path), "other"])
    assert (beside.exit_code, "is a sweep, whose figures are drawn alone" in beside.stderr) == (2, True)


@pytest.mark.parametrize(
    ("rows", "keys"),
    [
        (((1, 10), (2, 20)), ("a",)),
        (((1, 10), (1, 20)), ("b",)),
        (((1, 10), (1, 20), (2, 10), (2, 20)), ("a", "b")),
        ((("1 mm", [1, 2]), ("1 mm", [2, 1])), ("b",)),
    ],
)
def test_linked_keys_are_represented_by_one_that_tells_rows_apart(rows, keys):
    """Otherwise different points count as repeats of one."""
    assert tuple(representing(Axis(keys=("a", "b"), rows=rows))) == keys


def test_too_many_curves_are_refused():
    class Many(Made):
        def table(self):
            return [
                {"gap": gap, "force": force, "state": "done", "time": gap}
                for gap in np.arange(1.0, 50.0)
                for force in np.arange(1.0, 40.0)
            ]

    with pytest.raises(BadInput, match="39 curves are too many"):
        sweep_figure(Many(), "curves")


@pytest.mark.parametrize(
    ("kind", "measure", "says"), [("pie", None, "no such figure"), ("curves", "word", "no measure")]
)
def test_what_there_is_not_is_refused(kind, measure, says):
    with pytest.raises(BadInput, match=says):
        sweep_figure(Made(), kind, measure)


class Curve(Made):
    """Stresses 2 + 3 rate^0.5 of three repeats, which scatter symmetrically, in two liquids."""

    axes = ("rate", "liquid", "repeat")
    ways = ("rate", "liquid")

    def table(self):
        return [
            {"rate": rate, "liquid": liquid, "repeat": n, "state": "done", "stress": part * law + 0.01 * (n - 1)}
            for rate, law in ((rate, 2.0 + 3.0 * rate**0.5) for rate in (0.1, 0.4, 1.0, 4.0, 9.0))
            for liquid, part in (("oil", 1.0), ("water", 0.5))
            for n in range(3)
        ]  # fmt: skip


def test_a_fit_finds_the_law_of_each_curve_and_states_its_interval(tmp_path, monkeypatch):
    monkeypatch.setattr(figures, "open_sweep", lambda directory: Curve())
    (picture,) = plot_sweep(tmp_path, "fit", "stress")
    with picture.with_suffix(".csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for curve, factor in (("liquid oil", 1.0), ("liquid water", 0.5)):
        mine = {row["quantity"]: row for row in rows if row["curve"] == curve}
        for name, true in (("offset", 2.0 * factor), ("factor", 3.0 * factor), ("exponent", 0.5)):
            assert float(mine[name]["value"]) == pytest.approx(true, rel=1e-4)
            # Two degrees of freedom: 4.30 standard errors.
            half = 0.5 * (float(mine[name]["high"]) - float(mine[name]["low"]))
            assert half == pytest.approx(4.3027 * float(mine[name]["error"]), rel=1e-3)
        measured = [row for row in rows if row["curve"] == curve and row["quantity"] == "measured"]
        assert [row["runs"] for row in measured] == ["3"] * 5
        assert [float(row["error"]) for row in measured] == pytest.approx([0.01 / 3**0.5] * 5)


def test_the_command_prints_the_fits_with_their_intervals_and_where_two_curves_differ(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(figures, "open_sweep", lambda directory: Curve())
    _fit_all(tmp_path, quiet=False)
    printed = capsys.readouterr().out
    (row,) = [line for line in printed.splitlines() if "liquid water" in line and "exponent" in line]
    value, low, high = (float(word) for word in re.search(r"([0-9.]+) +([0-9.]+) to ([0-9.]+)", row).groups())
    assert value == pytest.approx(0.5, abs=1e-3)
    assert low <= value <= high
    assert "liquid water differs from liquid oil most at 9: by -50 %" in printed
    assert {path.name for path in tmp_path.iterdir()} == {"fit.png", "fit.csv"}


def test_runs_without_a_value_are_counted():
    points = points_of("", np.array([1.0, 1.0, 2.0]), np.array([3.0, np.nan, 5.0]))
    assert (points.omitted, points.runs) == (1, (1, 1))
    with pytest.raises(BadInput, match=r"the points: .* got 2; 1 runs without a finite value are omitted"):
        fit_of(points)


def test_the_command_fits_two_curves_without_a_common_value_of_the_axis(tmp_path, monkeypatch, capsys):
    class Apart(Curve):
        def table(self):
            rows = super().table()
            return [row | {"rate": row["rate"] * (2.0 if row["liquid"] == "water" else 1.0)} for row in rows]

    monkeypatch.setattr(figures, "open_sweep", lambda directory: Apart())
    _fit_all(tmp_path, quiet=False)
    printed = capsys.readouterr().out
    assert "differs" not in printed
    assert "wrote" in printed


def test_the_interval_of_a_fit_contains_the_true_law_as_often_as_it_says():
    """Five points of noise with a known error, 400 times: 95 % of the curve's intervals contain it."""
    dice, rates, inside = np.random.default_rng(3), np.geomspace(0.1, 10.0, 12), []
    true = 1.0 + 2.0 * rates**0.5
    for _ in range(400):
        means = [Mean(value + 0.05 * dice.normal(), 0.05) for value in true]
        points = Points("", rates, tuple(means), (1,) * len(rates))
        fit = fit_of(points)
        inside.append(np.abs(fit(rates) - true) < points.width * fit.error(rates))
    # Errors of the fit grow with a misfit above 1, and do not shrink with one below.
    assert 0.94 < np.mean(inside) < 0.99


def test_a_fit_that_too_few_points_determine_is_refused():
    with pytest.raises(BadInput, match="a fit of three parameters takes 4 points or more; got 3"):
        sweep_figure(Made(), "fit", "time")


def test_angles_are_drawn_in_degrees():
    column = column_of([{"angle": 0.5 * np.pi}, {"angle": np.pi}], "angle", {"angle": "rad"})
    assert column.values.tolist() == [90.0, 180.0]
    assert column.label == "angle (°)"
    assert column.at(90.0) == "90°"
