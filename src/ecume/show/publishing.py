"""Figures for papers: with a given width, without a title, with several runs and an experiment in one figure, and their
data as a table.

The functions use the curves of any finished Matplotlib figure, so that figures need no support for it.
"""

from __future__ import annotations

import csv
import io
import itertools
import math
import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple, cast

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.ticker import FuncFormatter, MaxNLocator

from ecume.errors import BadInput
from ecume.scenes.faults import echo
from ecume.scenes.tables import text_of
from ecume.show.style import INK, PALETTE, legend_outside, plain, style
from ecume.trajectories.records import storing, write_whole
from ecume.trajectories.tables import write_rows
from ecume.units import Array, factor

INCH = 0.0254
DASHES = ("-", "--", ":", "-.")
MARKS = ("o", "s", "^", "D", "v")
LABEL = re.compile(r"\s*(.*?)\s*(?:[(\[]\s*([^()\[\]]+?)\s*[)\]])?\s*")
"""The pattern of the label of an axis or the heading of a column: a name, and its unit in brackets."""
MOST_BYTES = 64 * 2**20


class Finish(NamedTuple):
    """The size of a figure, and its elements in addition to the curves."""

    width: float | None = None
    """m; by default that of the figure"""
    title: bool = True


LEAST = 0.03
"""The least width (m) that leaves room for panels beside their labels."""


def finished(drawn: Figure, finish: Finish) -> Figure:
    """The figure with this width, the same ratio of sides, and times in a suitable unit. Raises BadInput if panels
    have no room.
    """
    for axes in drawn.axes:
        _show_times(axes)
    if finish.width is not None:
        if finish.width < LEAST:
            raise BadInput(
                f"a figure {1e3 * finish.width:.3g} mm wide has no room for its panels; expected at least 30 mm"
            )
        width, height = drawn.get_size_inches()
        drawn.set_size_inches(finish.width / INCH, height * finish.width / INCH / width)
        if finish.width < NARROW:
            with style():
                _narrowed(drawn)
    if not finish.title:
        for axes in drawn.axes:
            for place in ("left", "center", "right"):
                axes.set_title("", loc=place)
        drawn.suptitle("")
    return drawn


class TimeUnit(NamedTuple):
    """A unit of an axis over time."""

    least: float
    """The least time (s) at the end of an axis for which it is used."""
    name: str
    seconds: float
    steps: tuple[float, ...] = (1, 2, 2.5, 5, 10)
    """between ticks, over a power of 10"""


SIXTIETHS = (1, 1.5, 2, 3, 6, 10)
TIME_UNITS = (
    TimeUnit(172800.0, "d", 86400.0),
    TimeUnit(10800.0, "h", 3600.0, SIXTIETHS),
    TimeUnit(600.0, "min", 60.0, SIXTIETHS),
    TimeUnit(0.1, "s", 1.0),
    TimeUnit(1e-4, "ms", 1e-3),
    TimeUnit(1e-7, "µs", 1e-6),
    TimeUnit(0.0, "ns", 1e-9),
)


def time_unit(longest: float) -> TimeUnit:
    """The unit in which an axis that ends at this time (s) is read.

    >>> [time_unit(each).name for each in (3e-6, 0.03, 5.0, 1800.0, 86400.0, 1e6)]
    ['µs', 'ms', 's', 'min', 'h', 'd']
    """
    return next(unit for unit in TIME_UNITS if longest >= unit.least)


class _TimeLocator(MaxNLocator):
    """Ticks at round numbers of a unit, on an axis in seconds."""

    def __init__(self, unit: TimeUnit) -> None:
        super().__init__(nbins="auto", steps=list(unit.steps))
        self._unit = unit

    def tick_values(self, vmin: float, vmax: float) -> Any:
        """The ticks (s) between two times."""
        seconds = self._unit.seconds
        return np.asarray(super().tick_values(vmin / seconds, vmax / seconds)) * seconds


def _show_times(axes: Axes) -> None:
    """Label a linear axis over seconds in a suitable unit; the data stay in seconds."""
    label, (low, high) = axes.get_xlabel(), axes.get_xlim()
    # Where an axis shows a short part of a long time, a unit for the whole would have ticks of many digits.
    unit = time_unit(min(max(abs(low), abs(high)), 100.0 * abs(high - low)))
    if not label.endswith(" (s)") or axes.get_xscale() != "linear" or unit.name == "s":
        return
    axes.set_xlabel(f"{label.removesuffix('(s)')}({unit.name})")
    axes.xaxis.set_major_locator(_TimeLocator(unit))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda tick, _: f"{tick / unit.seconds:.9g}"))


NARROW = 0.12
"""The width (m) below which a figure is that of a column of text: small letters, legends below the panels."""
SMALLER = 0.8
ROW = 0.17
"""The height (inches) of a row of a legend in a narrow figure."""
SHORT = 16
"""The longest text of legends in two columns."""


def _narrowed(drawn: Figure) -> None:
    """Reduce the font size, and move legends next to panels below them if they leave too little width for the
    curves.
    """
    small = SMALLER * float(cast(float, mpl.rcParams["font.size"]))
    for text in drawn.findobj(Text):
        text.set_fontsize(SMALLER * float(text.get_fontsize()))
    for axes in drawn.axes:
        axes.tick_params(labelsize=small)
    beside = [
        (axes, found) for axes in drawn.axes if (found := axes.get_legend()) is not None and _is_beside(axes, found)
    ]
    for axes, legend in beside:
        handles = [handle for handle in legend.legend_handles if handle is not None]
        names = [text.get_text() for text in legend.get_texts()]
        columns, title = 2 if max(map(len, names)) <= SHORT else 1, legend.get_title().get_text() or None
        legend.remove()
        if len(beside) == 1:
            drawn.legend(handles, names, loc="outside lower left", ncols=columns, fontsize=small, title=title)
        else:
            anchor: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (0.0, BELOW), "borderaxespad": 0.0}
            axes.legend(handles, names, ncols=columns, fontsize=small, title=title, **anchor)
        width, height = drawn.get_size_inches()
        drawn.set_size_inches(width, height + ROW * (-(-len(names) // columns) + (title is not None)))


BELOW = -0.35
"""The place of a legend below a panel and its labels, in heights of the panel."""


def _is_beside(axes: Axes, legend: Legend) -> bool:
    """Whether the legend of a panel is to its right."""
    return bool(legend.get_bbox_to_anchor().transformed(axes.transAxes.inverted()).x0 > 1.0)


class Curve(NamedTuple):
    """A curve of a figure, or a set of points."""

    line: Line2D
    name: str
    """in the legend; empty for one without a name"""
    bars: tuple[Array | None, Array | None] = (None, None)
    """(N, 2) the ends of the error bars along x and y; None for a curve without"""


def points_of(line: Line2D) -> Array:
    """The points (N, 2) of a curve."""
    return np.asarray(line.get_xydata(), dtype=np.float64)


def curves_of(axes: Axes) -> list[Curve]:
    """The curves in the coordinates of the axes, without lines across the whole axes and caps of error bars."""
    with_bars = {each[0]: each for each in axes.containers if isinstance(each, ErrorbarContainer)}
    caps = {cap for each in with_bars.values() for cap in each[1]}
    found = []
    for line in axes.lines:
        if line.get_transform() != axes.transData or not len(points_of(line)) or line in caps:
            continue
        bars = with_bars.get(line)
        name = _in_a_line(str((bars or line).get_label()))
        found.append(Curve(line, "" if name.startswith("_") else name, _ends(bars) if bars else (None, None)))
    return found


def _in_a_line(text: str) -> str:
    return " ".join(text.split())


def _ends(bars: ErrorbarContainer) -> tuple[Array | None, Array | None]:
    """The ends of the bars along x and y, (N, 2) each; NaN where an error is not known."""
    ends = [np.array([path.vertices for path in each.get_paths()], dtype=np.float64) for each in bars[2]]
    across = ends.pop(0)[:, :, 0] if bars.has_xerr else None
    return across, ends.pop(0)[:, :, 1] if bars.has_yerr else None


def _cells_of(curve: Curve, *, barred: bool) -> Iterator[tuple[str, ...]]:
    """The cells of each point: x, y, and the ends of the error bars, which are empty without one."""
    points = points_of(curve.line).tolist()
    columns = [
        ends.tolist() if ends is not None and len(ends) == len(points) else [("", "")] * len(points)
        for ends in curve.bars
    ]
    for point, across, up in zip(points, *columns, strict=True):
        ends = (*across, *up) if barred else ()
        yield tuple(value if isinstance(value, str) else repr(value) for value in (*point, *ends))


def written_data(drawn: Figure, out: Path) -> Path:
    """Write the points of all curves as CSV: panel, series, and both axes; columns of text contain their labels with
    units. A figure with error bars has columns for their ends. Raises BadInput for a figure without curves.
    """
    panels = [(panel, axes, curves_of(axes)) for panel, axes in enumerate(drawn.axes, 1)]
    barred = any(bars is not None for _, _, curves in panels for curve in curves for bars in curve.bars)
    rows = [
        (panel, curve.name or f"curve {number}", *map(_in_a_line, (axes.get_xlabel(), axes.get_ylabel())), *cells)
        for panel, axes, curves in panels
        for number, curve in enumerate(curves, 1)
        for cells in _cells_of(curve, barred=barred)
    ]
    if not rows:
        raise BadInput("--data: this figure is a picture without curves; `ecume export --to csv` writes the frames")
    text = io.StringIO()
    ends = ("x_low", "x_high", "y_low", "y_high") if barred else ()
    write_rows(text, [("panel", "series", "x_axis", "y_axis", "x", "y", *ends), *rows])
    with storing(out):
        out.parent.mkdir(parents=True, exist_ok=True)
        write_whole(out, text.getvalue())
    return out


def together(figures: Sequence[tuple[str, Figure]]) -> Figure:
    """Combine the same figure of several runs: each run has a line style, and its name in the legend. Units of axes may
    differ by a prefix. Raises BadInput for figures without curves, or with different panels.
    """
    (first_name, first), *others = figures
    if not any(curves_of(axes) for axes in first.axes):
        raise BadInput("this figure is a picture; only curves of several runs go into one figure")
    for name, other in others:
        if len(other.axes) != len(first.axes):
            raise BadInput(f"{name}: its figure has {len(other.axes)} panels; expected {len(first.axes)}, as the first")
    with style():
        for place, axes in enumerate(first.axes):
            own = curves_of(axes)
            for number, (name, other) in enumerate(others, 1):
                _add(axes, other.axes[place], name, number, single=len(own) == 1)
            for curve in own:
                _labeled(axes, curve.line).set_label(_named(curve.name, first_name))
            if own:
                _rescaled(axes)
    return first


def _add(axes: Axes, other: Axes, name: str, number: int, *, single: bool) -> None:
    """Add the curves of a panel of another run."""
    scales = [_ratio(getattr(other, get)(), getattr(axes, get)(), name) for get in ("get_xlabel", "get_ylabel")]
    own = {curve.line.get_color() for curve in curves_of(axes)}
    fresh = next((color for color in PALETTE if color not in own), PALETTE[number % len(PALETTE)])
    for curve in curves_of(other):
        points = points_of(curve.line) * scales
        errors = [
            None if ends is None else np.abs(ends * scale - values[:, None]).T
            for ends, scale, values in zip(curve.bars, scales, points.T, strict=True)
        ]
        line = curve.line
        hollow = (line.get_linestyle() == "None" and not single) or str(line.get_markerfacecolor()) == "none"
        looks: dict[str, Any] = {
            "drawstyle": line.get_drawstyle(), "marker": line.get_marker(), "markersize": line.get_markersize(),
            "linewidth": line.get_linewidth(), "color": fresh if single else line.get_color(),
            "linestyle": "none" if line.get_linestyle() == "None" else DASHES[number % len(DASHES)],
            "label": _named(curve.name, name), "markerfacecolor": "none" if hollow else None,
        }  # fmt: skip
        if all(each is None for each in errors):
            axes.plot(points[:, 0], points[:, 1], **looks)
        else:
            axes.errorbar(points[:, 0], points[:, 1], xerr=errors[0], yerr=errors[1], capsize=2, **looks)


def _labeled(axes: Axes, line: Line2D) -> Line2D | ErrorbarContainer:
    """The object with the label of a line in the legend: points with error bars have one of their own."""
    bars = (each for each in axes.containers if isinstance(each, ErrorbarContainer) and each[0] is line)
    return next(bars, line)


def _named(curve: str, run: str) -> str:
    return f"{curve}, {plain(run)}" if curve else plain(run)


def _unit_of(label: str) -> str:
    """The unit in the label of an axis or the heading of a column; empty without one."""
    return (match[2] or "").replace("µ", "u") if (match := LABEL.fullmatch(label)) else ""


def _ratio(label: str, other: str, name: str) -> float:
    """The factor between the units of two axes. Raises BadInput if their labels have no common unit."""
    units = [_unit_of(text) for text in (label, other)]
    if units[0] == units[1] or not all(units):
        return 1.0
    try:
        return factor(*units)
    except ValueError:
        raise BadInput(f"{name}: is in {units[0]}; expected {units[1]} or a multiple, as the figure is") from None


ROOM = 0.04
"""Part of the height of a panel above and below curves that it was not drawn for."""


def _rescaled(axes: Axes) -> None:
    """Set limits around all curves, and draw a legend."""
    points = np.concatenate([points_of(curve.line) for curve in curves_of(axes)])
    for axis, values, get, limits in (
        ("x", points[:, 0], axes.get_xlim, axes.set_xlim),
        ("y", points[:, 1], axes.get_ylim, axes.set_ylim),
    ):
        low, high = get()
        seen = values[np.isfinite(values) & (values > 0.0 if getattr(axes, f"get_{axis}scale")() == "log" else True)]
        if len(seen):
            least, most = float(seen.min()), float(seen.max())
            room = ROOM * (max(high, most) - min(low, least)) if axis == "y" and axes.get_yscale() == "linear" else 0.0
            limits(least - room if least < low else low, most + room if most > high else high)
    if (legend := axes.get_legend()) is not None:
        legend.remove()
    legend_outside(axes)


class Measured(NamedTuple):
    """A table of an experiment: columns as functions of the first one."""

    name: str
    heads: list[str]
    """with units in brackets"""
    columns: list[Array]


def read_measured(path: str | os.PathLike[str]) -> Measured:
    """The table of an experiment: a line of headings such as `time [s], pressure [kPa]`, then
    numbers. Raises BadInput.
    """
    file = Path(path)
    try:
        text = text_of(file, MOST_BYTES)
    except ValueError as fault:
        raise BadInput(f"{file}: {fault}") from None
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    mark = max(",;\t", key=lines[0].count) if lines else ","
    rows = list(csv.reader(lines, delimiter=mark))
    if len(rows) < 2 or len(rows[0]) < 2:
        raise BadInput(f"{file}: expected a line of heads such as `time [s],pressure [kPa]`, and numbers below")
    numbers = [_numbers(file, number, row, len(rows[0])) for number, row in enumerate(rows[1:], 2)]
    return Measured(file.stem, [cell.strip() for cell in rows[0]], list(np.array(numbers).T))


def _numbers(file: Path, line: int, row: Sequence[str], count: int) -> list[float]:
    if len(row) != count:
        raise BadInput(f"{file}: row {line}: got {len(row)} cells; expected {count}")
    try:
        return [float(cell) if cell.strip() else math.nan for cell in row]
    except ValueError:
        raise BadInput(f"{file}: row {line}: got {echo(','.join(row))}; expected numbers") from None


def with_measured(drawn: Figure, measured: Measured) -> Figure:
    """The figure with the points of an experiment, each column in the first panel whose axes have its units. Raises
    BadInput for a column that fits no panel.
    """
    marks = itertools.cycle(MARKS)
    for head, column in zip(measured.heads[1:], measured.columns[1:], strict=True):
        axes, x, y = next(_panels(drawn, measured.heads[0], head), (None, 1.0, 1.0))
        if axes is None:
            labels = "; ".join(f"{each.get_xlabel()}, {each.get_ylabel()}" for each in drawn.axes if each.get_ylabel())
            bare = next((one for one in (measured.heads[0], head) if not _unit_of(one)), "")
            hint = f"; {bare!r} has no unit: write it into the head, as in 'time [s]'" if bare else ""
            raise BadInput(f"{measured.name}: column {head!r} fits no axes of the figure, which are {labels}{hint}")
        label = plain(f"{(match[1] if (match := LABEL.fullmatch(head)) else head)}, {measured.name}")
        with style():
            look = {
                "marker": next(marks),
                "linestyle": "none",
                "color": INK,
                "markersize": 4,
                "markerfacecolor": "none",
                "clip_on": False,
            }
            axes.plot(x * measured.columns[0], y * column, label=label, **look)  # type: ignore[arg-type]  # a look
            _rescaled(axes)
    return drawn


def _panels(drawn: Figure, across: str, up: str) -> Iterator[tuple[Axes, float, float]]:
    """Yield the panels whose axes have these units, with the factors of the columns."""
    for axes in drawn.axes:
        if not curves_of(axes):
            continue
        labels = axes.get_xlabel(), axes.get_ylabel()
        if [bool(_unit_of(head)) for head in (across, up)] != [bool(_unit_of(label)) for label in labels]:
            continue  # only this figure uses the prefixes: a number without a unit may have another one
        try:
            yield axes, _ratio(across, labels[0], ""), _ratio(up, labels[1], "")
        except BadInput:
            continue
