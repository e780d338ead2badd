"""Figures of what floats come to: order, pair distribution, shapes of rafts, displacements, approaches."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from ecume.analysis.boxes import box_of
from ecume.analysis.clusters import touching_clusters, touching_pairs
from ecume.analysis.series import times, tracks
from ecume.analysis.structure import (
    Region,
    approach,
    fractal_dimension,
    hexatic_order,
    mean_square_displacement,
    pair_distribution,
    region_in,
    shapes_of,
)
from ecume.engine.walls.enclosures import shrunk
from ecume.errors import BadInput
from ecume.models.floating.walls.shapes import walls_of
from ecume.models.liquids import liquid_of
from ecume.show.curves import Frames, evolution, over_time, scaling, thinned, titled
from ecume.show.style import INK, MUTED, PALETTE, figure, legend_outside, scale_for, style
from ecume.trajectories.frame import Frame

MOST_PAIRS = 12
BINS = 120
MOST_FOR_NO_FIT = 3
"""Sizes of rafts up to which no fractal dimension is fitted."""
SHELLS = 12.0
"""How far the pair distribution is drawn, in mean radii."""


def order(frames: Frames, scene: Any) -> Figure:
    """The hexatic order over time: how good the lattices are, and how far one of them reaches."""
    shown = evolution(frames)
    psi = [hexatic_order(frame) for frame in shown]
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Hexatic order")
        axes.plot(
            times(shown),
            [np.abs(each).mean() for each in psi],
            color=PALETTE[1],
            label="local, $\\langle|\\psi_6|\\rangle$",
        )
        axes.plot(
            times(shown),
            [abs(each.mean()) for each in psi],
            color=PALETTE[0],
            label="global, $|\\langle\\psi_6\\rangle|$",
        )
        axes.set(ylim=(0.0, 1.0), ylabel=r"hexatic order $|\psi_6|$")
        legend_outside(axes)
    return drawn


def distribution(frames: Frames, scene: Any) -> Figure:
    """The pair distribution of the last frame beside that of the first."""
    kept = (frames[0], frames[-1])
    region = region_of(kept[-1], scene)
    radius = float(kept[-1].arrays["radius"].mean())
    # Half a bin off, so that what touches is in the middle of one.
    bins = (np.arange(BINS) + 0.5) * SHELLS / BINS * radius
    edges = np.array([0.0, *bins[bins < region.widest]])
    with style():
        drawn = figure()
        axes = drawn.add_subplot(
            xlabel="distance of the centers, in mean radii", title=titled("Pair distribution", scene)
        )
        for frame, color, label in zip(kept, (MUTED, PALETTE[1]), ("first", "last"), strict=True):
            found = pair_distribution([frame], edges, region)
            axes.stairs(found, edges / radius, color=color, label=f"{label}, {frame.time:.3g} s")
        axes.axhline(1.0, color=INK, linewidth=0.6)
        axes.set(xlim=(0.0, edges[-1] / radius), ylabel="pair distribution g(r)")
        axes.set_ylim(bottom=0.0)
        axes.legend()
    return drawn


def region_of(frame: Frame, scene: Any) -> Region:
    """The dish as far as centers can reach; on an endless surface the rectangle around all floats."""
    radius = float(frame.arrays["radius"].min())
    if scene.cell is not None:
        return Region(size=scene.sides, periodic=True)
    if scene.dish is not None:
        return region_in(shrunk(walls_of(scene.dish), radius))
    across, along = np.ptp(frame.arrays["position"], axis=0) + 2.0 * radius
    return Region(size=(float(across), float(along)))


def displacement(frames: Frames, scene: Any) -> Figure:
    """The mean square displacement over time, beside ballistic and diffusive motion."""
    shown = thinned(frames)
    if len(shown) < 3:
        raise BadInput("displacements need three frames or more")
    every = (shown[-1].time - shown[0].time) / (len(shown) - 1)
    lags = np.unique(np.geomspace(1, len(shown) - 1, 40).round().astype(int))
    found = mean_square_displacement(tracks(shown), [int(lag) for lag in lags])
    if not np.all(found > 0.0):
        raise BadInput("no float moves; no displacement to draw")
    scale = scale_for(float(np.sqrt(found.max())), "m")
    with style():
        drawn = figure()
        axes = drawn.add_subplot(xlabel="lag (s)", title=titled("Mean square displacement", scene))
        time, far = every * lags, scale.factor**2 * found
        axes.plot(time, far, "o-", color=PALETTE[1], markersize=3)
        for power, name in ((1, "~ t: diffusive"), (2, "~ t²: ballistic")):
            axes.plot(time, far[0] * (time / time[0]) ** power, "--", color=MUTED, linewidth=0.9)
            axes.annotate(name, (time[-1], far[0] * (time[-1] / time[0]) ** power), fontsize=8, ha="right", va="bottom")
        axes.set(xscale=scaling(time), yscale=scaling(far))
        axes.set_ylabel(f"mean square displacement ({scale.unit}²)")
    return drawn


def approaches(frames: Frames, scene: Any) -> Figure:
    """The gaps of pairs that touch in the end, over time, down to where they meet."""
    shown = evolution(frames)
    last = shown[-1].arrays
    box = box_of(shown[-1])
    period = None if box is None else box.sides.tolist()
    pairs = touching_pairs(last["position"], last["radius"], period=period)[:MOST_PAIRS]
    if not len(pairs):
        raise BadInput("no floats are in contact in the last frame; no approach to draw")
    length, paths = liquid_of(scene).capillary_length, tracks(shown)
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Gaps of floats that touch in the end")
        gaps = []
        for (i, j), color in zip(pairs, itertools.cycle(PALETTE), strict=False):
            gap = approach(paths, last["radius"], (int(i), int(j)), box) / length
            gaps.append(np.where(gap > 1e-4, gap, np.nan))
            axes.plot(times(shown), gaps[-1], color=color, linewidth=1.0, label=f"floats {i} and {j}")
        axes.set(yscale=scaling(gaps), ylabel="gap, in capillary lengths")
        legend_outside(axes)
    return drawn


def shapes(frames: Frames, scene: Any) -> Figure:
    """The rafts of the last frame: radius of gyration over number, beside that of a round, close-packed raft, and the
    fitted fractal dimension.
    """
    clusters = touching_clusters(frames[-1])
    found = shapes_of(frames[-1], clusters)
    several = clusters.sizes > 1
    if not several.any():
        raise BadInput("no floats are in contact in the last frame; no rafts to draw")
    radius = float(frames[-1].arrays["radius"].mean())
    sizes, gyration = clusters.sizes[several], found.gyration_radius[several] / radius
    # N discs at the density pi/sqrt(12) fill a circle of area 2 sqrt(3) N R^2; its radius of gyration is r/sqrt(2).
    round_ones = np.geomspace(2.0, sizes.max(), 50)
    with style():
        drawn = figure()
        axes = drawn.add_subplot(xlabel="floats in a raft", title=titled("Shapes of rafts", scene))
        long = np.minimum(found.elongation[several], 10.0)
        dots = axes.scatter(sizes, gyration, c=long, s=14, cmap="viridis", vmin=1.0, vmax=10.0)
        packed = np.sqrt(np.sqrt(3.0) / np.pi * round_ones)
        axes.plot(round_ones, packed, color=INK, label="round, close-packed")
        axes.plot(round_ones, np.sqrt((round_ones**2 - 1.0) / 3.0), "--", color=MUTED, label="a straight row")
        axes.set_ylabel("radius of gyration, in mean radii")
        axes.set(xscale=scaling([2.0, *sizes]), yscale=scaling(gyration))
        if len(np.unique(sizes)) > MOST_FOR_NO_FIT:
            fit = fractal_dimension(sizes, gyration)
            middle = np.exp(np.mean(np.log(gyration)) + np.log(round_ones / np.exp(np.mean(np.log(sizes)))) / fit.value)
            axes.plot(
                round_ones, middle, ":", color=PALETTE[0], label=f"fit, dimension {fit.value:.2f} ± {fit.error:.2f}"
            )
        if axes.get_xscale() == "log":
            axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axes.xaxis.set_major_formatter("{x:g}")
            axes.xaxis.set_minor_formatter(NullFormatter())
        else:
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        drawn.colorbar(dots, ax=axes, label="elongation (10 and more)")
        axes.legend()
    return drawn


MEASURES = {
    "order": order,
    "pair-distribution": distribution,
    "displacement": displacement,
    "approach": approaches,
    "shapes": shapes,
}
"""By the names that `ecume plot --what` takes."""
