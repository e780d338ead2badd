"""Figures for runs of any model: numbers over time, clusters, paths, and samples between frames.

The last part is the figure of a fit: measured and simulated positions, and the residuals.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ecume.analysis.clusters import touching_clusters
from ecume.analysis.energies import ENERGIES
from ecume.analysis.series import number, series, times, tracks
from ecume.analysis.structure import mean_square_displacement
from ecume.errors import BadInput
from ecume.models import MODELS
from ecume.models.invariants import INJECTED
from ecume.scenes.faults import suggestion
from ecume.show.style import INK, MUTED, PALETTE, Scale, binned, figure, legend_outside, plain, scale_for, style
from ecume.trajectories.frame import Frame
from ecume.trajectories.gsd import present_name
from ecume.trajectories.reader import Trajectory
from ecume.trajectories.samples import Samples
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.fitting import Fit
    from ecume.scenes.schema import Scene

FEWEST = 20
"""The number of values below which none counts as an outlier."""
PART = 0.02
"""The largest fraction of values, and at least two, that may be outliers at either end."""
FENCE = 1.0
"""The distance of an outlier from the range of all other values, over this range."""
ROOM = 0.06
"""The margin beyond the limits, over the range."""


def limits_without_spikes(curves: Array | list[Array]) -> tuple[float, float]:
    """The smallest and the largest value of curves (K, N), without outliers.

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

    Among consecutive outliers only the largest one is marked.
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
    """Draw a triangle at the edge of the axes, with a value next to it."""
    axes.plot(*at, marker="^" if up else "v", color=INK, markersize=5, clip_on=False, zorder=5)
    axes.annotate(text, at, (6, 0), textcoords="offset points", va="center", fontsize=8, color=INK)


MOST_INSTANTS = 400
"""The number of frames in a curve or a path; more look the same, and take longer."""
LEAST = 1e-15
"""The kinetic energy, over its largest value, below which it is not drawn."""

OF_SUMS = {"total": INK, "dissipated": MUTED}
"""Colors of energies that have none of the palette."""

Frames = Sequence[Frame]


def energies(frames: Frames, scene: Scene) -> Figure:
    """Kinetic and potential energies, their sum, the injected work, and the dissipated energy."""
    shown = evolution(frames)
    names = [name for name, unit in shown[0].units.items() if unit in ENERGIES and name != "total_energy"]
    *parts, total = series(shown, *map(number, [*names, "total_energy"]))
    labels = [name.removesuffix("_energy").replace(INJECTED, "injected").replace("_", " ") for name in names]
    work = dict(zip(names, parts, strict=True)).get(INJECTED, np.zeros(len(total)))
    lost = total[0] - total + work - work[0]
    curves = [*zip(labels, parts, strict=True), ("total", total), ("dissipated", lost)]
    scale = scale_for(max(float(np.abs(values).max()) for _, values in curves), energy_unit(shown[0]))
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Energies")
        for (label, values), color in zip(curves, itertools.cycle(PALETTE), strict=False):
            dashes = "--" if label == "dissipated" else "-"
            chosen = OF_SUMS.get(label, color)
            axes.plot(times(shown), scale.factor * values, dashes, color=chosen, label=label)
        axes.set_ylabel(f"energy ({scale.unit})")
        legend_outside(axes)
    return drawn


def energy_unit(frame: Frame) -> str:
    """The unit of energies: J; J/m for a 2D tank."""
    return frame.units.get("total_energy", "J")


def kinetic_energy(frames: Frames, scene: Scene) -> Figure:
    """The kinetic energy; on a logarithmic scale where it changes by more than a decade."""
    shown = evolution(frames)
    (kinetic,) = series(shown, number("kinetic_energy"))
    scale = scale_for(float(kinetic.max()), energy_unit(shown[0]))
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Kinetic energy")
        # The energy of a bowl at rest decays by many further decades, which are not relevant.
        seen = np.where(kinetic > LEAST * kinetic.max(), kinetic, np.nan)
        axes.plot(times(shown), scale.factor * seen, color=PALETTE[1])
        axes.set_xlim(span(times(shown)))
        axes.set_yscale(scaling(seen))
        axes.set_ylabel(f"kinetic energy ({scale.unit})")
    return drawn


def number_over_time(frames: Frames, scene: Scene, name: str) -> Figure:
    """A number of the frames over time. Raises BadInput if the frames have no number with this name."""
    shown, name = evolution(frames), present_name(name)
    if name not in shown[0].numbers:
        raise BadInput(f"the frames have no number {name!r}; {suggestion(name, sorted(shown[0].numbers))}")
    (values,) = series(shown, number(name))
    unit = shown[0].units.get(name, "1")
    words = name.replace("_", " ")
    scale = Scale(1.0, "") if unit == "1" else scale_for(float(np.nanmax(np.abs(values))), unit)
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, words.capitalize())
        axes.plot(times(shown), scale.factor * values, color=PALETTE[1])
        axes.set_xlim(span(times(shown)))
        axes.set_ylabel(f"{words} ({scale.unit})" if scale.unit else words)
    return drawn


def displacement(frames: Frames, scene: Scene) -> Figure:
    """The mean square displacement over time with ballistic and diffusive slopes; particles are included while they are
    inside.
    """
    # Frames at equal intervals, so that all lags are exact.
    kept = range(0, len(frames), max(1, len(frames) // MOST_INSTANTS))
    if len(kept) < 3:
        raise BadInput("displacements need three frames or more")
    every = (frames[kept[-1]].time - frames[0].time) / (len(kept) - 1)
    lags = np.unique(np.geomspace(1, len(kept) - 1, 40).round().astype(int))
    found = mean_square_displacement(tracks(frames, kept), [int(lag) for lag in lags])
    lags, found = lags[~np.isnan(found)], found[~np.isnan(found)]
    if not np.all(found > 0.0) or not len(found):
        raise BadInput("no particle moves; no displacement to draw")
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


def clusters(frames: Frames, scene: Scene) -> Figure:
    """The number of clusters and their sizes: single floats count as clusters of one."""
    shown = evolution(frames)
    found = [touching_clusters(frame) for frame in shown]
    with style():
        drawn = figure(6.4, 4.8)
        above, below = drawn.subplots(2, 1, sharex=True)
        steps(above, times(shown), [len(each.sizes) for each in found], "all", PALETTE[1])
        steps(below, times(shown), [each.largest for each in found], "largest", PALETTE[0])
        steps(below, times(shown), [each.mean_size for each in found], "mean", PALETTE[2])
        above.set(ylabel="number of clusters", title=titled("Clusters", scene))
        below.set(ylabel="floats in a cluster", xlabel="time (s)", xlim=span(times(shown)))
        legend_outside(below)
    return drawn


def steps(axes: Axes, instants: Array, counts: Sequence[float], label: str, color: str) -> None:
    """Draw counts over time as step lines, from zero, with integer ticks."""
    axes.plot(instants, counts, color=color, label=label, drawstyle="steps-post")
    axes.set_ylim(bottom=0)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=6))


def thinned(frames: Frames) -> list[Frame]:
    """Frames from the first to the last at equal distances, at most `MOST_INSTANTS`."""
    return [frames[index] for index in instants(frames)]


def instants(frames: Frames) -> list[int]:
    """The indices of the frames that `thinned` selects."""
    chosen = np.linspace(0, len(frames) - 1, min(len(frames), MOST_INSTANTS)).round()
    return [int(index) for index in chosen]


def evolution(frames: Frames) -> list[Frame]:
    """Thinned frames of a run. Raises BadInput for a run with a single frame."""
    if len(frames) < 2:
        raise BadInput(f"{ONE_FRAME} at {frames[0].time:g} s; a figure over time needs two frames or more")
    return thinned(frames)


ONE_FRAME = "the run has a single frame,"


def scaling(values: Any) -> str:
    """The scale of an axis: logarithmic if the positive values span a decade or more, otherwise linear.

    >>> scaling([1.3, 2.0]), scaling([1.0, 20.0])
    ('linear', 'log')
    """
    array = np.asarray(values, dtype=float)
    positive = array[np.isfinite(array) & (array > 0.0)]
    return "log" if len(positive) and positive.max() >= 10.0 * positive.min() else "linear"


def span(instants: Array) -> tuple[float, float] | None:
    """The interval from the first to the last value; None for fewer than two."""
    return (float(instants[0]), float(instants[-1])) if instants[-1] > instants[0] else None


def titled(what: str, scene: Scene) -> str:
    """The title of a figure: the quantity and the scene."""
    return f"{what}: {plain(scene.title).strip()}" if scene.title else what


def over_time(drawn: Figure, scene: Scene, what: str) -> Axes:
    """Axes over time, with a title."""
    axes = drawn.add_subplot(xlabel="time (s)", title=titled(what, scene))
    axes.margins(x=0)
    return axes


MOST_PANELS = 8
"""The largest number of panels in a figure; of more numbers, the main ones of the model are drawn."""


def samples_of(frames: Frames) -> Samples | None:
    """The samples of a run, if it has at least two rows of them."""
    if not isinstance(frames, Trajectory):
        return None
    try:
        found = frames.samples
    except BadInput:
        return None
    return found if len(found) > 1 else None


def samples(frames: Frames, scene: Scene) -> Figure:
    """The numbers sampled between frames over time; for blocks the mean, and the range as a band."""
    found = samples_of(frames)
    if found is None:
        raise BadInput("the run has no two rows of samples; write a table [output.samples] with every and block")
    names = shown_numbers(found, MODELS[scene.model].main_numbers)
    with style():
        drawn = figure(6.4, 1.2 + 1.3 * len(names))
        panels = drawn.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
        for axes, name in zip(panels, names, strict=True):
            _curve(axes, found, name)
        panels[0].set_title(titled(_title(found), scene))
        panels[-1].set(xlabel="time (s)", xlim=span(found.times))
    return drawn


CLASSES = 30
"""The largest number of size classes, an odd number."""


def sizes(frames: Frames, scene: Scene) -> Figure:
    """The size distribution of the particles at the end: the fraction of their number and of their volume in each class
    of radii.
    """
    radius = np.asarray(frames[-1].arrays["radius"], float).ravel()
    scale, spread = scale_for(float(radius.max()), "m"), 100.0 * float(radius.std() / radius.mean())
    low, high = float(radius.min()), float(radius.max())
    around = 0.05 * high if high - low < 1e-9 * high else 0.0
    # An odd number, so that equal sizes are in the middle class.
    classes = min(CLASSES, max(5, round(math.sqrt(len(radius))))) // 2 * 2 + 1
    edges = np.linspace(low - around, high + around, 1 + classes)
    rows = [(np.ones(len(radius)), INK, "of the number"), (radius**3, PALETTE[1], "of the volume")]
    with style():
        drawn = figure()
        axes = drawn.add_subplot(xlabel=f"radius ({scale.unit})", title=titled("Sizes", scene))
        for weights, color, label in rows:
            part, _ = np.histogram(radius, edges, weights=weights / weights.sum())
            binned(axes, 100.0 * part, scale.factor * edges, color=color, label=label)
        axes.axvline(
            scale.factor * float(radius.mean()),
            color=MUTED,
            linewidth=0.8,
            label=f"mean, spread {spread:.1f} %",
        )
        axes.set_ylabel("part in each class (%)")
        axes.set_ylim(bottom=0.0)
        axes.legend()
    return drawn


def shown_numbers(found: Samples, main: tuple[str, ...]) -> list[str]:
    """The numbers in the figure: all if there are few, otherwise the main ones."""
    if len(found.names) <= MOST_PANELS:
        return found.names
    return [name for name in found.names if name in main][:MOST_PANELS] or found.names[:MOST_PANELS]


def _title(found: Samples) -> str:
    return f"Averages of {found.counts[0]} samples" if found.blocks else "Samples"


def _curve(axes: Axes, found: Samples, name: str) -> None:
    """Draw one number with its range, in a suitable unit."""
    low, high, mean = found.minimum(name), found.maximum(name), found.mean(name)
    sizes = np.abs(np.concatenate([low, high]))
    unit = found.units[name]
    scale = scale_for(float(sizes[np.isfinite(sizes)].max(initial=0.0)), unit) if unit != "1" else None
    factor = scale.factor if scale else 1.0
    if found.blocks:
        axes.fill_between(found.times, factor * low, factor * high, color=PALETTE[1], alpha=0.25, linewidth=0.0)
    axes.plot(found.times, factor * mean, color=PALETTE[1], linewidth=1.0)
    label = plain(name.replace("_", " "))
    axes.set_ylabel(f"{label}\n({scale.unit})" if scale else label, fontsize="small")


MOST_COLORED = 8
"""The number of objects with an entry in the legend."""


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
    for which, color in zip(range(measured.shape[1]), itertools.cycle(PALETTE), strict=False):
        name = f"object {found.tracks.names[which]}" if which < MOST_COLORED else None
        axes.plot(*(scale.factor * measured[:, which].T), ".", color=color, ms=3, alpha=0.6, label=name)
        axes.plot(*(scale.factor * found.simulated[:, which].T), color=INK, lw=0.9)
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
    for which, color in zip(range(left.shape[1]), itertools.cycle(PALETTE), strict=False):
        for component, mark in ((0, "o"), (1, "x")):
            values: Array = scale.factor * left[:, which, component]
            label = f"{'xy'[component]} of all objects" if which == 0 else None
            axes.plot(found.tracks.times, values, mark, color=color, ms=2.5, mew=0.7, label=label)
    axes.margins(x=0)
    axes.set(xlabel="time (s)", ylabel=f"measured minus simulated ({scale.unit})", title="Residuals")
    axes.legend(loc="upper center", ncols=3, bbox_to_anchor=(0.5, -0.16))
