"""Figures of the spreading, passage, residence and deposition of tracers, with standard errors
(`ecume.analysis.dispersion`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ecume.analysis import dispersion
from ecume.analysis.dispersion import Course
from ecume.analysis.series import inside, times
from ecume.errors import BadInput
from ecume.show.curves import MOST_INSTANTS, Frames, evolution, over_time, titled
from ecume.show.picture import species
from ecume.show.style import MUTED, PALETTE, binned, figure, legend_outside, plain, scale_for, style
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.tracers import TracersScene

BINS = 40
"""Of lengths along an axis, and of times."""
INSTANTS = 5
"""Curves in a figure of profiles."""


def axis_names(frame: Frame) -> str:
    """The names of the axes."""
    return "xyz"[: frame.arrays["position"].shape[1]]


def band(axes: Axes, time: Array, curve: tuple[Array, Array], label: str, color: str) -> None:
    """A curve with its standard error as a band."""
    value, error = curve
    axes.plot(time, value, color=color, label=label)
    axes.fill_between(time, value - error, value + error, color=color, alpha=0.25, linewidth=0.0)


def spreading(frames: Frames, scene: TracersScene) -> Figure:
    """The mean square displacement along each axis, with and without the drift, while all particles are inside."""
    shown, until = before_exits(evenly(frames))
    every, own = dispersion.displacements(shown), dispersion.displacements(shown, without_drift=True)
    scale = scale_for(float(np.sqrt(every.value.max())), "m")
    square = scale.factor**2
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, f"Mean square displacement along each axis{until}")
        for axis, (name, color) in enumerate(zip(axis_names(shown[0]), PALETTE, strict=False)):
            value, error = square * own.value[:, axis], square * own.error[:, axis]
            band(axes, own.time, (value, error), f"{name}, without drift", color)
            axes.plot(every.time, square * every.value[:, axis], "--", color=color, label=name)
        axes.set_ylabel(f"mean square displacement ({scale.unit}²)")
        legend_outside(axes)
    return drawn


def evenly(frames: Frames) -> Frames:
    """Frames at equal intervals, so that displacements since entering have exact times."""
    return evolution(frames[:: max(1, -(-len(frames) // MOST_INSTANTS))])


def before_exits(frames: Frames) -> tuple[Frames, str]:
    """The frames before the first exit, and a remark for the title. Particles that remain afterwards are slow, so that
    their displacements are too small. If fewer than three frames precede the exit, or if particles enter, the result is
    all frames.
    """
    first = len(frames[0].arrays["position"])
    if len(frames[-1].arrays["position"]) > first:
        return frames, ", since entering"
    whole = [bool(inside(frame)[:first].all()) for frame in frames]
    if all(whole):
        return frames, ""
    end = whole.index(False)
    return (frames[:end], ", until the first exit") if end > 2 else (frames, ", of those that stay inside")


def dispersion_over_time(frames: Frames, scene: TracersScene) -> Figure:
    """The dispersion coefficient along each axis, half the rate at which the variance grows, while all particles are
    inside.
    """
    shown, until = before_exits(evenly(frames))
    names = axis_names(shown[0])
    courses = [dispersion.dispersion_coefficient(shown, axis) for axis in range(len(names))]
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, f"Dispersion coefficient{until}")
        for name, course, color in zip(names, courses, PALETTE, strict=False):
            band(axes, course.time, (course.value, course.error), f"along {name}", color)
        axes.axhline(0.0, color=MUTED, linewidth=0.8)
        axes.set_ylabel("dispersion coefficient (m²/s)")
        legend_outside(axes)
    return drawn


def residence(frames: Frames, scene: TracersScene) -> Figure:
    """The distribution of the times from entry until particles left or were deposited."""
    shown = evolution(frames)
    found = dispersion.residence_times(shown)
    if len(found.times) < 2:
        raise BadInput(f"{len(found.times)} particles have left; a distribution needs two or more")
    counts, edges = np.histogram(found.times, whole_bins(found.times, float(np.diff(times(shown)).mean())))
    with style():
        drawn = figure()
        axes = drawn.add_subplot(xlabel="residence time (s)", title=titled("Residence times", scene))
        bars(axes, edges, (counts, np.sqrt(counts)), PALETTE[1])
        note = f"mean {found.mean:.3g} ± {found.error:.1g} s; {found.remaining} still inside"
        axes.axvline(found.mean, color=MUTED, linestyle="--", linewidth=1.0, label=note)
        axes.set_ylabel("particles")
        axes.legend(loc="best", fontsize=8)
    return drawn


def whole_bins(values: Array, interval: float) -> Array:
    """Edges of bins whose width is a multiple of the interval between frames, since the values are multiples of it."""
    low, high = float(values.min()) - 0.25 * interval, float(values.max())
    width = max(1.0, np.ceil((high - low) / BINS / interval)) * interval
    edges: Array = low + width * np.arange(int((high - low) / width) + 2)
    return edges


def bars(axes: Axes, edges: Array, counted: tuple[Array, Array], color: str, label: str | None = None) -> None:
    """A histogram with error bars."""
    value, error = counted
    binned(axes, value, edges, color=color, label=label)
    axes.errorbar(0.5 * (edges[1:] + edges[:-1]), value, error, fmt="none", color=color, alpha=0.6, linewidth=0.8)


def breakthrough(frames: Frames, scene: TracersScene) -> Figure:
    """The fraction of all particles that have left through each opening, over time."""
    shown = evolution(frames)
    openings = sum(name.startswith("left_through_opening_") for name in shown[0].numbers)
    if not openings:
        raise BadInput("the tank has no openings; no breakthrough to draw")
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Breakthrough")
        for opening, color in zip(range(openings), PALETTE * openings, strict=False):
            course = dispersion.breakthrough(shown, opening)
            band(axes, course.time, (course.value, course.error), f"opening {opening}", color)
        axes.set_ylabel("fraction that has left")
        axes.set_ylim(bottom=0.0)
        legend_outside(axes)
    return drawn


def concentration(frames: Frames, scene: TracersScene) -> Figure:
    """The number of particles per length along x at five times."""
    shown = evolution(frames)
    picked = [shown[int(k)] for k in np.unique(np.linspace(0, len(shown) - 1, INSTANTS).round())]
    places = [frame.arrays["position"][inside(frame), 0] for frame in picked]
    edges = edges_of(np.concatenate(places), "all particles have left the tank")
    course = dispersion.concentration(picked, edges, 0)
    scale = scale_for(float(np.abs(edges).max()), "m")
    with style():
        drawn = figure()
        axes = drawn.add_subplot(xlabel=f"x ({scale.unit})", title=titled("Concentration along x", scene))
        for k, color in zip(range(len(picked)), PALETTE, strict=False):
            counted = (course.value[k] / scale.factor, course.error[k] / scale.factor)
            bars(axes, scale.factor * edges, counted, color, time_label(float(course.time[k])))
        axes.set_ylabel(f"particles per {scale.unit}")
        legend_outside(axes)
    return drawn


def time_label(time: float) -> str:
    """A time in a suitable unit, for legends.

    >>> time_label(0.04), time_label(250.0), time_label(22.0 * 86400.0)
    ('0.04 s', '250 s', '22 days')
    """
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if time >= 10.0 * size:
            return f"{time / size:.3g} {unit}"
    return f"{time:.4g} s"


def edges_of(values: Array, without: str) -> Array:
    """The edges of bins that contain all values. Raises BadInput without values."""
    if not len(values):
        raise BadInput(f"{without}; nothing to draw")
    low, high = float(values.min()), float(values.max())
    return np.linspace(low, high if high > low else low + max(abs(low), 1e-9) * 1e-6, BINS + 1)


FLAT = 1e-6
"""The extent of deposited particles along an axis, over the largest, below which they lie in a plane across it."""


def deposition(frames: Frames, scene: TracersScene) -> Figure:
    """The number of deposited particles per length along each axis, at the end; axes normal to a single plane of
    deposits are omitted.
    """
    last = frames[-1]
    held = dispersion.deposited(last)
    names = axis_names(last)
    places = last.arrays["position"][held]
    extents = np.ptp(places, axis=0) if len(places) else np.zeros(len(names))
    wide = extents > FLAT * extents.max()
    scale = scale_for(float(np.abs(places).max(initial=0.0)), "m")
    with style():
        drawn = figure()
        axes = drawn.add_subplot(xlabel=f"place ({scale.unit})", title=titled("Deposition", scene))
        densities = list[Array]()
        for axis, (name, color) in enumerate(zip(names, PALETTE, strict=False)):
            if wide.any() and not wide[axis]:
                continue
            found = dispersion.deposition(last, edges_of(places[:, axis], "no particle is deposited"), axis)
            counted = (found.density / scale.factor, found.error / scale.factor)
            bars(axes, scale.factor * found.edges, counted, color, f"along {name}")
            densities.append(counted[0][counted[0] > 0.0])
        # All deposits on a floor are in one column, far above those on obstacles.
        axes.set_yscale("log")
        axes.set_ylim(bottom=0.5 * float(np.concatenate(densities).min()))
        axes.set_ylabel(f"particles per {scale.unit}")
        legend_outside(axes)
    return drawn


def efficiency(frames: Frames, scene: TracersScene) -> Figure:
    """The deposited fraction of the particles of each species that are deposited or have left, over time."""
    shown = evolution(frames)
    if not any(name.startswith("deposited_on_wall_") for name in shown[0].numbers):
        raise BadInput("no wall and no obstacle holds particles; there is no efficiency to draw")
    kinds = species(scene)
    courses = [efficiency_over_time(shown, index) for index in range(len(kinds))]
    if not any(np.isfinite(course.value).any() for course in courses):
        raise BadInput("no particle is deposited or has left; no efficiency to draw")
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Efficiency of walls and obstacles that hold particles")
        for kind, course in zip(kinds, courses, strict=True):
            band(axes, course.time, (course.value, course.error), plain(kind.name), kind.color)
        axes.set_ylabel("deposited over deposited or gone")
        axes.set_ylim(0.0, 1.05)
        legend_outside(axes)
    return drawn


def efficiency_over_time(frames: Frames, kind: int) -> Course:
    """The efficiency for one species; NaN before its first particle is deposited or has left."""
    found = [dispersion.Efficiency(np.nan, np.nan)] * len(frames)
    for k, frame in enumerate(frames):
        if (~inside(frame) & (frame.arrays["species"] == kind)).any():
            found[k] = dispersion.collector_efficiency(frame, species=kind)
    return Course(times(frames), *np.array(found).T)


MEASURES: dict[str, Any] = {
    "spreading": spreading,
    "dispersion": dispersion_over_time,
    "residence": residence,
    "breakthrough": breakthrough,
    "concentration": concentration,
    "deposition": deposition,
    "efficiency": efficiency,
}
