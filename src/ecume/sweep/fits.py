"""The power law of a measure over an axis of a sweep, such as a flow curve, with 95 % intervals over its repeats."""

from __future__ import annotations

import io
import itertools
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from scipy.stats import t

from ecume.analysis.curves import Curve
from ecume.analysis.rheology import CurveFit, power_fit
from ecume.analysis.series import Mean
from ecume.errors import BadInput
from ecume.show.style import PALETTE
from ecume.trajectories.records import write_whole
from ecume.trajectories.tables import write_rows
from ecume.units import Array

LIKELY = 0.95
"""The confidence level of intervals."""
PARAMETERS = ("offset", "factor", "exponent")
COLUMNS = ("curve", "quantity", "x", "value", "error", "low", "high", "runs")


class Points(NamedTuple):
    """A measure over an axis, in all runs of a curve."""

    label: str
    at: Array
    """(P,) the values of the axis, ascending"""
    means: tuple[Mean, ...]
    """over the repeats, with standard errors; 0 for single runs"""
    runs: tuple[int, ...]
    """the number of runs at each value"""
    omitted: int = 0
    """the runs without a finite value, such as those that did not become stationary"""

    @property
    def curve(self) -> Curve:
        """The means without the single values."""
        return Curve(self.at, self.means)

    @property
    def width(self) -> float:
        """The half width of an interval in standard errors: Student's t with the degrees of freedom of the fit."""
        return float(t.ppf(0.5 + 0.5 * LIKELY, len(self.at) - len(PARAMETERS)))


def points_of(label: str, x: Array, values: Array) -> Points:
    """The means over finite values for each value of the axis."""
    good = np.isfinite(x) & np.isfinite(values)
    at = np.unique(x[good])
    groups = [values[good & (x == one)] for one in at]
    means = tuple(
        Mean(float(one.mean()), float(one.std(ddof=1) / np.sqrt(len(one))) if len(one) > 1 else 0.0) for one in groups
    )
    return Points(label, at, means, tuple(map(len, groups)), int((~good).sum()))


def fit_of(points: Points) -> CurveFit:
    """The fit of offset + factor x^exponent; for flow curves, the law of Herschel and Bulkley. Raises BadInput if the
    points do not determine it.
    """
    try:
        return power_fit(points.at, points.means)
    except BadInput as fault:
        omitted = f"; {points.omitted} runs without a finite value are omitted" if points.omitted else ""
        raise BadInput(f"{points.label or 'the points'}: {fault}{omitted}") from None


def draw_fits(on: Axes, curves: Sequence[Points]) -> None:
    """Draw means with their errors, and the fitted curves with their intervals."""
    for points, color in zip(curves, itertools.cycle(PALETTE)):
        fit, values = fit_of(points), [one.value for one in points.means]
        errors = [one.error for one in points.means]
        on.errorbar(
            points.at, values, yerr=errors if any(errors) else None, fmt="o", markersize=4, capsize=2, color=color,
            label=points.label or None,
        )  # fmt: skip
        x = np.geomspace(points.at[0], points.at[-1], 200)
        away = points.width * fit.error(x)
        offset, power = (f"{one.value:.3g} ± {points.width * one.error:.2g}" for one in (fit.offset, fit.exponent))
        on.plot(x, fit(x), color=color, linewidth=1.0, label=f"{offset} + K x$^n$, n = {power}")
        on.fill_between(x, fit(x) - away, fit(x) + away, color=color, alpha=0.15, linewidth=0.0)
    on.legend()


def rows_of(points: Points) -> Iterator[tuple[object, ...]]:
    """The table of a curve: its points, the fit at these points, and the parameters with intervals of 95 %."""
    fit, width = fit_of(points), points.width
    for x, mean, runs in zip(points.at, points.means, points.runs, strict=True):
        yield points.label, "measured", x, mean.value, mean.error, "", "", runs
    for x, value, error in zip(points.at, fit(points.at), fit.error(points.at), strict=True):
        yield points.label, "fitted", x, value, error, value - width * error, value + width * error, ""
    for name in PARAMETERS:
        value, error = getattr(fit, name)
        yield points.label, name, "", value, error, value - width * error, value + width * error, ""
    yield points.label, "misfit", "", fit.misfit, "", "", "", ""


def write_fits(file: Path, curves: Sequence[Points]) -> None:
    """Write the table of all curves as CSV."""
    text = io.StringIO()
    write_rows(text, [COLUMNS])
    for points in curves:
        write_rows(
            text,
            ([f"{entry:.9g}" if isinstance(entry, float) else entry for entry in row] for row in rows_of(points)),
        )
    write_whole(file, text.getvalue())
