"""Figures of a sweep: a measure over one axis, a curve for each value of a second one, a map of two, or a scatter."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from ecume.errors import BadInput
from ecume.scenes.faults import suggestion
from ecume.show.style import PALETTE, figure, legend_outside, plain, save, style
from ecume.sweep.results import Row, Sweep, open_sweep
from ecume.units import Array

KINDS = ("curves", "map", "scatter")
WIDE = 30.0
"""The ratio of the largest to the least positive value from which on an axis is logarithmic."""
MOST_CURVES = len(PALETTE)


def plot_sweep(directory: Path, kind: str = "curves", measure: str | None = None, out: Path | None = None) -> Path:
    """Draw a figure of a sweep into `out`; left out, into its directory."""
    drawn = sweep_figure(open_sweep(directory), kind, measure)
    return save(drawn, out or directory / f"{kind}.png")


def sweep_figure(sweep: Sweep, kind: str = "curves", measure: str | None = None) -> Figure:
    """The figure of a measure (left out, the first) over what varies."""
    if kind not in KINDS:
        raise BadInput(f"no such figure of a sweep as {kind!r}; {suggestion(kind, KINDS)}")
    rows = [row for row in sweep.table() if row["state"] == "done"]
    if not rows:
        raise BadInput(f"{sweep.directory}: no point is done yet; there is nothing to draw")
    axes = [name for name in sweep.axes if name != "repeat" and varies(rows, name)]
    shown = measured_column(rows, sweep.axes, measure)
    if not axes:
        raise BadInput(f"{sweep.directory}: no axis of the sweep has numbers; there is nothing to draw over")
    with style():
        drawn = figure()
        on = drawn.add_subplot(title=plain(sweep.title))
        DRAWN[kind](on, rows, axes, shown)
    return drawn


def measured_column(rows: Sequence[Row], axes: Sequence[str], asked: str | None) -> str:
    """The column that is drawn."""
    known = [name for name in rows[0] if name not in (*axes, "state") and _numeric(rows, name)]
    if asked is not None and asked not in known:
        raise BadInput(f"the sweep has no measure {asked!r}; {suggestion(asked, known)}")
    if not known:
        raise BadInput("the sweep has no measure that is a number")
    return asked or known[0]


def varies(rows: Sequence[Row], name: str) -> bool:
    """Whether a column has numbers, and not one only."""
    return _numeric(rows, name) and len(np.unique(values_of(rows, name))) > 1


def _numeric(rows: Sequence[Row], name: str) -> bool:
    try:
        return bool(np.isfinite(values_of(rows, name)).any())
    except (TypeError, ValueError):
        return False


def values_of(rows: Sequence[Row], name: str) -> Array:
    """A column as numbers."""
    return np.array([float(row[name]) for row in rows])


def curves(on: Axes, rows: Sequence[Row], axes: Sequence[str], measure: str) -> None:
    """Over the axis with most values, a curve for each value of the next; means and standard errors of what repeats."""
    x_name, *others = sorted(axes, key=lambda name: -len(np.unique(values_of(rows, name))))
    x, y = values_of(rows, x_name), values_of(rows, measure)
    groups = values_of(rows, others[0]) if others else np.zeros(len(rows))
    for place, group in enumerate(np.unique(groups)):
        mine = groups == group
        at = np.unique(x[mine])
        means, errors = zip(*(_mean(y[mine & (x == value)]) for value in at), strict=True)
        label = f"{plain(others[0])} = {group:g}" if others else None
        color = PALETTE[place % MOST_CURVES]
        on.errorbar(at, means, yerr=errors if np.any(errors) else None, fmt="o-", ms=4, color=color, label=label)
    _scaled(on, x, y)
    on.set(xlabel=plain(x_name), ylabel=plain(measure))
    if others:
        legend_outside(on)


def _mean(values: Array) -> tuple[float, float]:
    """And its standard error, which one value alone has not."""
    error = float(np.std(values, ddof=1) / math.sqrt(len(values))) if len(values) > 1 else 0.0
    return float(np.mean(values)), error


def colored_map(on: Axes, rows: Sequence[Row], axes: Sequence[str], measure: str) -> None:
    """The measure over two axes."""
    if len(axes) < 2:
        raise BadInput("a map wants two axes; --what curves draws one")
    x, y, z = (values_of(rows, name) for name in (*axes[:2], measure))
    columns, lines = np.unique(x), np.unique(y)
    table = np.full((len(lines), len(columns)), np.nan)
    for line, column in np.ndindex(table.shape):
        here = z[(y == lines[line]) & (x == columns[column])]
        table[line, column] = here.mean() if len(here) else np.nan
    norm = LogNorm() if wide(z) else None
    image = on.pcolormesh(edges(columns), edges(lines), np.ma.masked_invalid(table), norm=norm)
    _scaled(on, x, y)
    on.set(xlabel=plain(axes[0]), ylabel=plain(axes[1]))
    on.grid(visible=False)
    owner: Any = on.get_figure(root=True)
    owner.colorbar(image, ax=on, label=plain(measure))


def edges(values: Array) -> Array:
    """Between which a map's fields lie: halfway from one value to the next, on the axis as it is drawn.

    >>> edges(np.array([1.0, 2.0, 4.0]))
    array([0.5, 1.5, 3. , 5. ])
    """
    if wide(values):
        return np.asarray(np.exp(edges_between(np.log(values))))
    return edges_between(values)


def edges_between(values: Array) -> Array:
    """Halfway between neighbors, and as far beyond both ends."""
    middle = (values[1:] + values[:-1]) / 2
    return np.concatenate([[1.5 * values[0] - 0.5 * values[1]], middle, [1.5 * values[-1] - 0.5 * values[-2]]])


def scatter(on: Axes, rows: Sequence[Row], axes: Sequence[str], measure: str) -> None:
    """A dot a point; of two axes the second is its color."""
    x, y = values_of(rows, axes[0]), values_of(rows, measure)
    color = values_of(rows, axes[1]) if len(axes) > 1 else None
    dots = on.scatter(x, y, c=color, s=18, norm=LogNorm() if color is not None and wide(color) else None)
    _scaled(on, x, y)
    on.set(xlabel=plain(axes[0]), ylabel=plain(measure))
    if color is not None:
        owner: Any = on.get_figure(root=True)
        owner.colorbar(dots, ax=on, label=plain(axes[1]))


DRAWN = {"curves": curves, "map": colored_map, "scatter": scatter}


def wide(values: Array) -> bool:
    """Whether positive values span more than a linear scale shows."""
    finite = values[np.isfinite(values)]
    return bool(len(finite) and finite.min() > 0.0 and finite.max() > WIDE * finite.min())


def _scaled(on: Axes, x: Array, y: Array) -> None:
    if wide(x):
        on.set_xscale("log")
    if wide(y):
        on.set_yscale("log")
