"""Figures of a sweep: curves of a measure over one key, with one curve for each value of the other keys; fitted power
laws; maps over two keys; scatter plots.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ecume.errors import BadInput
from ecume.scenes.faults import suggestion
from ecume.show.publishing import Finish, finished, written_data
from ecume.show.style import PALETTE, Scale, figure, legend_outside, plain, save, scale_for, style
from ecume.sweep.fits import Points, draw_fits, points_of, write_fits
from ecume.sweep.results import Row, Sweep, open_sweep
from ecume.units import Array, factor

KINDS = ("curves", "map", "scatter", "fit")
WIDE = 30.0
"""An axis is logarithmic from this ratio of the largest to the smallest positive value."""
DASHES = ("-", "--", ":")
PATH = re.compile(r"[A-Za-z_]\w*(?:\[[0-9]+\])?(?:\.[A-Za-z_]\w*(?:\[[0-9]+\])?)+")
"""The path of a key in a scene."""
MOST_CURVES = len(DASHES) * len(PALETTE)


class Column(NamedTuple):
    """A column of the table for a figure; texts are plotted at 0, 1, 2 ..."""

    name: str
    values: Array
    words: tuple[str, ...] = ()
    unit: str = ""
    written: bool = False
    """whether the unit is that of the sweep's file"""

    @property
    def label(self) -> str:
        """The label of an axis, in words.

        >>> Column("particles[0].contact_angle", np.ones(1), unit="°").label
        'contact angle of particles[0] (°)'
        """
        table, _, key = self.name.rpartition(".") if PATH.fullmatch(self.name) else ("", "", self.name)
        words = plain(f"{key} of {table}" if table else key).replace("_", " ").strip()
        return f"{words} ({self.unit})" if self.unit else words

    def at(self, value: float) -> str:
        """A value with its unit, for a legend."""
        if self.words:
            return plain(self.words[int(value)])
        if self.unit == "°":
            return f"{value:.4g}°"
        if self.written:
            return f"{value:.4g} {self.unit}"
        scale = scale_for(value, self.unit) if self.unit else Scale(1.0, "")
        return f"{scale.factor * value:.4g} {scale.unit}".strip()


def plot_sweep(
    directory: Path,
    kind: str,
    measure: str | None = None,
    out: Path | None = None,
    *,
    form: str = "png",
    finish: Finish = Finish(),  # noqa: B008  # it cannot change
    data: Path | None = None,
) -> list[Path]:
    """Draw a figure of a sweep into the file or the folder `out`, by default into its directory. The table of a fit is
    written next to the figure, and the points of all curves into `data`. Returns the paths of the files.
    """
    sweep = open_sweep(directory)
    drawn = sweep_figure(sweep, kind, measure)
    name = f"{kind}-{re.sub(r'[^A-Za-z0-9]+', '-', measure).strip('-')}" if measure else kind
    target = out if out is not None and out.suffix and not out.is_dir() else (out or directory) / f"{name}.{form}"
    if kind == "fit" and data is not None and data.resolve() == target.with_suffix(".csv").resolve():
        raise BadInput(f"--data {data}: the table of the fit has this name; expected another one")
    tables = [] if data is None else [written_data(drawn, data)]
    save(finished(drawn, finish), target)
    if kind == "fit":
        write_fits(target.with_suffix(".csv"), fitted_curves(directory, measure)[1])
    return [*tables, target]


def fitted_curves(directory: Path, measure: str | None = None) -> tuple[str, list[Points]]:
    """The name of a measure (by default the first) and the points of its curves, which a fit draws."""
    axes, shown = _columns(open_sweep(directory), measure)
    return shown.name, fitted_points(axes, shown)


def kinds_of(directory: Path) -> list[str]:
    """The figures for which a sweep has data, except fits, which are drawn only if named."""
    sweep = open_sweep(directory)
    fits = {"curves": not sweep.drawn, "map": len(sweep.ways) > 1, "scatter": True, "fit": False}
    return [kind for kind in KINDS if fits[kind]]


def sweep_figure(sweep: Sweep, kind: str = "curves", measure: str | None = None) -> Figure:
    """The figure of a measure (by default the first) over the varied keys."""
    if kind not in KINDS:
        raise BadInput(f"no such figure of a sweep as {kind!r}; {suggestion(kind, KINDS)}")
    if kind == "curves" and sweep.drawn:
        raise BadInput(f"{sweep.directory}: its points were drawn, and lie on no curves; --what scatter draws them")
    axes, shown = _columns(sweep, measure)
    if kind != "fit":  # the table of a fit is in SI units
        axes = [_as_written(column, sweep.written_units.get(column.name, "")) for column in axes]
    with style():
        drawn = figure()
        on = drawn.add_subplot(title=plain(sweep.title))
        DRAWN[kind](on, axes, shown)
    return drawn


def _as_written(column: Column, unit: str) -> Column:
    """A column in the unit of the sweep file."""
    if not unit or not column.unit or column.unit == "°":
        return column
    try:
        ratio = factor(unit, column.unit)
    except ValueError:  # degrees Celsius have an offset
        return column
    return column._replace(values=column.values / ratio, unit=unit, written=True)


def _columns(sweep: Sweep, measure: str | None) -> tuple[list[Column], Column]:
    """The varied keys of the completed points, and the measure."""
    rows = [row for row in sweep.table() if row["state"] == "done"]
    if not rows:
        raise BadInput(f"{sweep.directory}: no point is finished; nothing to draw")
    shown = measured_column(rows, sweep.axes, measure)
    units = sweep.units([*sweep.ways, shown])
    axes = [column for name in sweep.ways if len(np.unique((column := column_of(rows, name, units)).values)) > 1]
    if not axes:
        raise BadInput(f"{sweep.directory}: no parameter varies among the finished points; nothing to draw")
    return axes, column_of(rows, shown, units)


def measured_column(rows: Sequence[Row], axes: Sequence[str], asked: str | None) -> str:
    """The column that is drawn."""
    known = [name for name in rows[0] if name not in (*axes, "state") and _numeric(rows, name)]
    if asked is not None and asked not in known:
        raise BadInput(f"the sweep has no measure {asked!r}; {suggestion(asked, known)}")
    if not known:
        raise BadInput("the sweep has no measure that is a number")
    return asked or known[0]


def _numeric(rows: Sequence[Row], name: str) -> bool:
    try:
        return bool(np.isfinite(values_of(rows, name)).any())
    except (TypeError, ValueError):
        return False


def values_of(rows: Sequence[Row], name: str) -> Array:
    """A column as numbers."""
    return np.array([float(row[name]) for row in rows])


def column_of(rows: Sequence[Row], name: str, units: dict[str, str]) -> Column:
    """A column of the table for a figure."""
    if all(isinstance(row[name], (int, float)) and not isinstance(row[name], bool) for row in rows):
        values, unit = values_of(rows, name), units.get(name, "")
        return Column(name, np.degrees(values), unit="°") if unit == "rad" else Column(name, values, unit=unit)
    words = tuple(dict.fromkeys(str(row[name]) for row in rows))
    return Column(name, np.array([float(words.index(str(row[name]))) for row in rows]), words)


def curves(on: Axes, axes: Sequence[Column], measure: Column) -> None:
    """Draw the measure over the numeric key with most values, with one curve for each combination of the others; means
    and standard errors of repeated points.
    """
    x, *others = by_length(axes)
    groups, counts = groups_of(x, others), list[int]()
    for (label, mine), (dash, color) in zip(groups, itertools.product(DASHES, PALETTE), strict=False):
        at = np.unique(x.values[mine])
        means, errors = zip(*(_mean(measure.values[mine & (x.values == value)]) for value in at), strict=True)
        bars = errors if np.any(errors) else None
        on.errorbar(at, means, yerr=bars, fmt="o", ls=dash, ms=4, color=color, label=label or None)
        counts += [int((mine & (x.values == value)).sum()) for value in at]
    _scaled(on, x, measure)
    if max(counts) > 1:
        runs = f"{min(counts)} to {max(counts)}" if min(counts) < max(counts) else str(max(counts))
        on.set_ylabel(f"{measure.label}\nmean of {runs} runs")
    if others:
        legend_outside(on)


def by_length(axes: Sequence[Column]) -> list[Column]:
    """The numeric key with most values, and the others."""
    return sorted(axes, key=lambda column: (bool(column.words), -len(np.unique(column.values))))


def groups_of(x: Column, others: Sequence[Column]) -> list[tuple[str, NDArray[np.bool_]]]:
    """The combinations of the values of all other keys, with the label and the rows of each."""
    names = short_names(others)
    groups = sorted(set(zip(*(column.values for column in others), strict=True))) if others else [()]
    if len(groups) > MOST_CURVES:
        raise BadInput(f"{len(groups)} curves are too many to distinguish; use --what map or --what scatter")
    found = []
    for group in groups:
        pairs = list(zip(others, group, strict=True))
        label = ", ".join(f"{name} {column.at(value)}" for name, (column, value) in zip(names, pairs, strict=True))
        same = [column.values == value for column, value in pairs]
        found.append((label, np.logical_and.reduce([np.isfinite(x.values), *same])))
    return found


def fitted_points(axes: Sequence[Column], measure: Column) -> list[Points]:
    """The points of each curve for the fit of a power law."""
    x, *others = by_length(axes)
    if x.words:
        raise BadInput(f"{x.name} takes words; a power law needs an axis of numbers")
    return [points_of(label, x.values[mine], measure.values[mine]) for label, mine in groups_of(x, others)]


def fits(on: Axes, axes: Sequence[Column], measure: Column) -> None:
    """Draw curves with power laws and their intervals."""
    draw_fits(on, fitted_points(axes, measure))
    _scaled(on, by_length(axes)[0], measure)


def short_names(columns: Sequence[Column]) -> list[str]:
    """The last parts of the keys of columns, or the whole keys if two have the same last part.

    >>> short_names([Column("liquid.viscosity", np.ones(1)), Column("floats[0].radius", np.ones(1))])
    ['viscosity', 'radius']
    """
    last = [column.name.rsplit(".", 1)[-1] for column in columns]
    return [plain(one if last.count(one) == 1 else column.name) for one, column in zip(last, columns, strict=True)]


def _mean(values: Array) -> tuple[float, float]:
    """The mean and its standard error, which is NaN for single or infinite values."""
    sure = len(values) > 1 and np.isfinite(values).all()
    return float(np.mean(values)), float(np.std(values, ddof=1) / math.sqrt(len(values))) if sure else 0.0


def colored_map(on: Axes, axes: Sequence[Column], measure: Column) -> None:
    """Draw the measure over two keys as a map, averaged over the others; sampled points as dots."""
    if len(axes) < 2:
        raise BadInput("a map needs two axes; --what curves draws one")
    x, y, *others = axes
    norm = LogNorm() if wide(measure.values) else None
    columns, lines = np.unique(x.values), np.unique(y.values)
    if len(columns) * len(lines) > MOST_FIELDS * len(measure.values):
        image: Any = on.scatter(x.values, y.values, c=measure.values, s=30, norm=norm)
    else:
        table = _averaged(x, y, measure)
        image = on.pcolormesh(edges(columns), edges(lines), np.ma.masked_invalid(table), norm=norm)
        on.grid(visible=False)
    _scaled(on, x, y)
    over = f", mean over {', '.join(plain(column.name) for column in others)}" if others else ""
    _colorbar(on, image, measure.label + over)


MOST_FIELDS = 4
"""The largest number of grid fields per point; with more, points do not form a grid."""


def _averaged(x: Column, y: Column, z: Column) -> Array:
    """The mean at each pair of values; NaN for pairs without points."""
    columns, lines = np.unique(x.values), np.unique(y.values)
    table = np.full((len(lines), len(columns)), np.nan)
    for line, column in np.ndindex(table.shape):
        here = z.values[(y.values == lines[line]) & (x.values == columns[column])]
        table[line, column] = here.mean() if len(here) else np.nan
    return table


def _colorbar(on: Axes, image: Any, label: str) -> None:
    owner: Any = on.get_figure(root=True)
    owner.colorbar(image, ax=on, label=label)


def edges(values: Array) -> Array:
    """The edges of a map's cells: halfway between neighboring values, on the scale of the axis.

    >>> edges(np.array([1.0, 2.0, 4.0]))
    array([0.5, 1.5, 3. , 5. ])
    """
    if wide(values):
        return np.asarray(np.exp(edges_between(np.log(values))))
    return edges_between(values)


def edges_between(values: Array) -> Array:
    """Midpoints between neighbors, continued by equal distances at both ends."""
    middle = (values[1:] + values[:-1]) / 2
    return np.concatenate([[1.5 * values[0] - 0.5 * values[1]], middle, [1.5 * values[-1] - 0.5 * values[-2]]])


def scatter(on: Axes, axes: Sequence[Column], measure: Column) -> None:
    """Draw a dot per point; the second numeric key is its color, the third its marker."""
    x, *others = axes
    color = next((column for column in others if not column.words), None)
    values = np.zeros(len(x.values)) if color is None else color.values
    look: dict[str, Any] = {"s": 22, "norm": LogNorm() if wide(values) else Normalize(values.min(), values.max())}
    mark = next(
        (column for column in others if column is not color and len(np.unique(column.values)) <= len(MARKERS)), None
    )
    kinds = np.zeros(len(x.values)) if mark is None else mark.values
    for kind, marker in zip(np.unique(kinds), MARKERS, strict=False):
        mine = kinds == kind
        name = None if mark is None else f"{short_names([mark])[0]} {mark.at(float(kind))}"
        dots = on.scatter(x.values[mine], measure.values[mine], c=values[mine], marker=marker, label=name, **look)
    if mark is not None:
        on.legend()
    _scaled(on, x, measure)
    if color is not None:
        _colorbar(on, dots, color.label)


MARKERS = "os^Dv<>*"
DRAWN = {"curves": curves, "map": colored_map, "scatter": scatter, "fit": fits}


def wide(values: Array) -> bool:
    """Whether positive values span more than a linear scale can resolve."""
    finite = values[np.isfinite(values)]
    return bool(len(finite) and finite.min() > 0.0 and finite.max() > WIDE * finite.min())


def _scaled(on: Axes, x: Column, y: Column) -> None:
    """Set the scales and labels of both axes."""
    on.set(xlabel=x.label, ylabel=y.label)
    for column, axis, scale in ((x, on.xaxis, on.set_xscale), (y, on.yaxis, on.set_yscale)):
        if column.words:
            axis.set_ticks(range(len(column.words)), labels=[plain(word) for word in column.words])
        elif wide(column.values):
            scale("log")
