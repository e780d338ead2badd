"""Figures that any model can have: its numbers over time, clusters of what touches, paths. And what figures share."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ecume.analysis.clusters import touching_clusters
from ecume.analysis.fields import ENERGIES
from ecume.analysis.series import number, series, times
from ecume.errors import BadInput
from ecume.models.invariants import INJECTED
from ecume.scenes.faults import suggestion
from ecume.show.style import INK, PALETTE, Scale, figure, legend_outside, plain, scale_for, style
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene

MOST_INSTANTS = 400
"""A curve or a path of more frames than this looks no different, and takes longer to read and to draw."""
LEAST = 1e-15
"""The part of its largest value below which the kinetic energy is not drawn."""

Frames = Sequence[Frame]


def energies(frames: Frames, scene: Scene) -> Figure:
    """Kinetic and potential energies, their sum, the injected work, and the dissipated energy."""
    shown = evolution(frames)
    names = [name for name, unit in shown[0].units.items() if unit in ENERGIES and name != "total_energy"]
    *parts, total = series(shown, *map(number, [*names, "total_energy"]))
    labels = [name.removesuffix("_energy").replace(INJECTED, "injected") for name in names]
    work = dict(zip(names, parts, strict=True)).get(INJECTED, np.zeros(len(total)))
    lost = total[0] - total + work - work[0]
    curves = [*zip(labels, parts, strict=True), ("total", total), ("dissipated", lost)]
    scale = scale_for(max(float(np.abs(values).max()) for _, values in curves), energy_unit(shown[0]))
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Energies")
        for (label, values), color in zip(curves, itertools.cycle(PALETTE), strict=False):
            dashes = "--" if label == "dissipated" else "-"
            axes.plot(
                times(shown), scale.factor * values, dashes, color=INK if label == "total" else color, label=label
            )
        axes.set_ylabel(f"energy ({scale.unit})")
        legend_outside(axes)
    return drawn


def energy_unit(frame: Frame) -> str:
    """J; of a 2D tank J/m."""
    return frame.units.get("total_energy", "J")


def kinetic_energy(frames: Frames, scene: Scene) -> Figure:
    """The kinetic energy; on a logarithmic scale where it changes by more than a decade."""
    shown = evolution(frames)
    (kinetic,) = series(shown, number("kinetic_energy"))
    scale = scale_for(float(kinetic.max()), energy_unit(shown[0]))
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Kinetic energy")
        # A bowl at rest loses invisible decades for ever.
        seen = np.where(kinetic > LEAST * kinetic.max(), kinetic, np.nan)
        axes.plot(times(shown), scale.factor * seen, color=PALETTE[1])
        axes.set_xlim(span(times(shown)))
        axes.set_yscale(scaling(seen))
        axes.set_ylabel(f"kinetic energy ({scale.unit})")
    return drawn


def number_over_time(frames: Frames, scene: Scene, name: str) -> Figure:
    """A number of the frames over time. Raises BadInput if they have none of this name."""
    shown = evolution(frames)
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
    """Counts over time, from zero, on whole numbers."""
    axes.plot(instants, counts, color=color, label=label, drawstyle="steps-post")
    axes.set_ylim(bottom=0)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=6))


def thinned(frames: Frames) -> list[Frame]:
    """Frames from the first to the last, evenly, not too many."""
    chosen = np.linspace(0, len(frames) - 1, min(len(frames), MOST_INSTANTS)).round()
    return [frames[int(index)] for index in chosen]


def evolution(frames: Frames) -> list[Frame]:
    """The same of a run with at least two frames. Raises BadInput for one with a single frame."""
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
    """The interval from the first value to the last, if there are two."""
    return (float(instants[0]), float(instants[-1])) if instants[-1] > instants[0] else None


def titled(what: str, scene: Scene) -> str:
    """The title of a figure: what it shows, and of which scene."""
    return f"{what}: {plain(scene.title).strip()}" if scene.title else what


def over_time(drawn: Figure, scene: Scene, what: str) -> Axes:
    """Axes over time, with a title."""
    axes = drawn.add_subplot(xlabel="time (s)", title=titled(what, scene))
    axes.margins(x=0)
    return axes
