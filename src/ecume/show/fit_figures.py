"""The figure of a fit: where objects were and where the simulation has them, and what is left."""

from __future__ import annotations

import itertools

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ecume.fitting import Fit
from ecume.show.style import INK, MUTED, PALETTE, figure, plain, scale_for, style
from ecume.units import Array

MOST_COLORED = 8
"""Objects beyond so many are drawn, and have no line in the legend."""


def fit_figure(found: Fit) -> Figure:
    """Tracks and simulation in 2D; residuals over time, with the 95 percent band of the noise."""
    with style():
        drawn = figure(9.0, 4.2)
        left, right = drawn.subplots(1, 2, width_ratios=[1.0, 1.3])
        _paths(left, found)
        _residuals(right, found)
        title = getattr(found.scene, "title", "")
        left.set_title("Measured and simulated tracks")
        if title:
            drawn.suptitle(plain(title).strip())
    return drawn


def _paths(axes: Axes, found: Fit) -> None:
    measured = found.tracks.position
    scale = scale_for(float(np.nanmax(np.abs(measured))), "m")
    for number, color in zip(range(measured.shape[1]), itertools.cycle(PALETTE), strict=False):
        name = f"object {found.tracks.names[number]}" if number < MOST_COLORED else None
        axes.plot(*(scale.factor * measured[:, number].T), ".", color=color, ms=3, alpha=0.6, label=name)
        axes.plot(*(scale.factor * found.simulated[:, number].T), color=INK, lw=0.9)
    axes.plot([], [], color=INK, lw=0.9, label="simulated")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel=f"x ({scale.unit})", ylabel=f"y ({scale.unit})")
    axes.legend(loc="best")


def _residuals(axes: Axes, found: Fit) -> None:
    left = found.tracks.position - found.simulated
    scale = scale_for(float(np.nanmax(np.abs(left))), "m")
    band = 1.96 * found.noise * scale.factor
    axes.axhspan(-band, band, color=MUTED, alpha=0.15, lw=0, label="1.96 standard deviations")
    axes.axhline(0.0, color=MUTED, lw=0.7)
    for number, color in zip(range(left.shape[1]), itertools.cycle(PALETTE), strict=False):
        for component, mark in ((0, "o"), (1, "x")):
            values: Array = scale.factor * left[:, number, component]
            label = f"{'xy'[component]} of all objects" if number == 0 else None
            axes.plot(found.tracks.times, values, mark, color=color, ms=2.5, mew=0.7, label=label)
    axes.margins(x=0)
    axes.set(xlabel="time (s)", ylabel=f"measured minus simulated ({scale.unit})", title="Residuals")
    axes.legend(loc="upper center", ncols=3, bbox_to_anchor=(0.5, -0.16))
