"""The limits of an axis that a few outliers would otherwise compress, with the outliers marked and annotated."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from ecume.show.style import INK
from ecume.units import Array

FEWEST = 20
"""Instants below which nothing counts as an outlier."""
PART = 0.02
"""The part of all instants, and at least two, that may be outliers at either end."""
FENCE = 1.0
"""How far beyond the range of all other values an outlier is, in parts of that range."""
ROOM = 0.06
"""Beyond the limits, in parts of the range."""


def limits_without_spikes(curves: Array | list[Array]) -> tuple[float, float]:
    """The least and the largest value of curves (K, N), without outliers.

    >>> limits_without_spikes([np.array([0.0, 1.0] * 20 + [99.0])])
    (0.0, 1.0)
    """
    values = np.asarray(curves, dtype=float)
    finite = np.sort(values[np.isfinite(values)])
    if not len(finite):
        return 0.0, 1.0
    if values.shape[-1] < FEWEST:
        return float(finite[0]), float(finite[-1])
    few = max(2, round(PART * len(finite)))
    low, high = finite[few], finite[-1 - few]
    room = FENCE * (high - low)
    kept = finite[(finite >= low - room) & (finite <= high + room)] if room > 0.0 else finite
    return float(kept[0]), float(kept[-1])


def cut_spikes(axes: Axes, instants: Array, curves: Array, unit: str) -> None:
    """Set limits without outliers, and mark each outlier at the edge of the axes with its value.

    Of outliers that follow each other only the largest one is marked.
    """
    low, high = limits_without_spikes(curves)
    room = ROOM * (high - low)
    if not room > 0.0:
        return
    for values in curves:
        for sign, edge in ((1.0, high), (-1.0, low)):
            for peak in _peaks(sign * values, sign * edge):
                _mark(axes, (instants[peak], edge + sign * room), f"{values[peak]:.3g} {unit}", up=sign > 0.0)
    outside = (curves > high).any(), (curves < low).any()
    if any(outside):
        axes.set_ylim(low - (1.0 + outside[1]) * room, high + (1.0 + outside[0]) * room)


def _peaks(values: Array, edge: float) -> list[int]:
    """The indices of the largest value in each interval above the edge."""
    above = np.flatnonzero(values > edge)
    groups = np.split(above, np.flatnonzero(np.diff(above) > 1) + 1) if len(above) else []
    return [int(group[np.argmax(values[group])]) for group in groups]


def _mark(axes: Axes, at: tuple[float, float], text: str, *, up: bool) -> None:
    """A triangle that points out of the axes, and a value beside it."""
    axes.plot(*at, marker="^" if up else "v", color=INK, markersize=5, clip_on=False, zorder=5)
    axes.annotate(text, at, (6, 0), textcoords="offset points", va="center", fontsize=8, color=INK)
