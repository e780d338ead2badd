"""Figures of measured quantities of a sheared packing: gaps, coordination, stress, T1 events, non-affine motion."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure

from ecume.analysis.boxes import copies
from ecume.analysis.close_pairs import films, gap_distribution
from ecume.analysis.layers import ends_of, layers
from ecume.analysis.rearrangements import Swaps, local_deformation, neighbor_swaps, nonaffine_displacement
from ecume.analysis.series import number, series, times
from ecume.errors import BadInput
from ecume.scenes.soft import SoftScene
from ecume.show.curves import Frames, evolution, scaling, span, steps, titled
from ecume.show.soft.packing import flat_box
from ecume.show.style import INK, MUTED, PALETTE, Scale, binned, figure, legend_outside, scale_for, style
from ecume.trajectories.frame import Frame
from ecume.units import Array

INSTANTS = 4
"""The number of times at which the distribution of gaps is drawn."""
NEAR = 3.0
"""The radius of the neighborhoods for local deformations, in radii of the largest sphere."""
APART = 0.02
"""The smallest difference of strain between frames for non-affine motion, if possible."""


def gap_histogram(frames: Frames, scene: SoftScene) -> Figure:
    """The distribution of gaps at some instants: the area below each curve is one."""
    chosen = [frames[round(place)] for place in np.linspace(0, len(frames) - 1, min(INSTANTS, len(frames)))]
    gaps = [films(frame).gap for frame in chosen]
    values = np.concatenate(gaps)
    if not len(values):
        raise BadInput("there are no films whose gaps could be shown")
    ends = float(values.min()), float(values.max())
    with style():
        drawn = figure()
        scale = scale_for(ends[1], "m")
        axes = drawn.add_subplot(ylabel="probability density of ln(gap)", title=titled("Distribution of gaps", scene))
        axes.set_xlabel(f"gap ({scale.unit})")
        for frame, gap, color in zip(chosen, gaps, PALETTE, strict=False):
            if len(gap):
                found = gap_distribution(gap, bins=24, span=ends)
                binned(axes, found.density, scale.factor * found.edges, color=color, label=f"{frame.time:.3g} s")
        axes.set_xscale(scaling(ends))
        legend_outside(axes)
    return drawn


def coordination(frames: Frames, scene: SoftScene) -> Figure:
    """The number of close neighbors of a sphere, their mean gap and the narrowest, over time."""
    shown = evolution(frames)
    neighbors, mean, least = series(shown, *map(number, ("coordination", "mean_gap", "smallest_gap")))
    scale = scale_for(float(np.nanmax(np.append(mean, least))), "m")
    with style():
        drawn = figure(6.4, 4.8)
        above, below = drawn.subplots(2, 1, sharex=True)
        above.plot(times(shown), neighbors, color=PALETTE[1])
        above.set(ylabel="close neighbors", title=titled("Close neighbors and their gaps", scene))
        below.plot(times(shown), scale.factor * mean, color=PALETTE[2], label="mean of close neighbors")
        below.plot(times(shown), scale.factor * least, color=PALETTE[0], label="narrowest")
        below.set(
            yscale=scaling([*mean, *least]), ylabel=f"gap ({scale.unit})", xlabel="time (s)", xlim=span(times(shown))
        )
        legend_outside(below)
    return drawn


PARTS = {"squeeze": "squeezed films", "sliding": "sliding films", "remote": "long-range forces"}
"""The parts of the stress by the names of their numbers."""


def viscosity(frames: Frames, scene: SoftScene) -> Figure:
    """Shear stress in its parts, and viscosity, over time."""
    require_box(scene, "stress")
    shown = evolution(frames)
    parts = [name for name in PARTS if f"stress_{name}_xy" in shown[0].numbers]
    total, *shares, thick = series(
        shown, *map(number, ("shear_stress", *(f"stress_{name}_xy" for name in parts), "viscosity"))
    )
    scale = scale_for(float(np.abs(total).max()), shown[0].units["shear_stress"])
    with style():
        drawn = figure(6.4, 4.8)
        above, below = drawn.subplots(2, 1, sharex=True)
        above.plot(times(shown), scale.factor * total, color=INK, label="total")
        for name, share, color in zip(parts, shares, PALETTE, strict=False):
            above.plot(times(shown), scale.factor * share, color=color, linewidth=1.2, label=PARTS[name])
        above.set(ylabel=f"shear stress ({scale.unit})", title=titled("Shear stress and viscosity", scene))
        legend_outside(above)
        # The rate passes through zero where shear reverses, and the apparent viscosity diverges there.
        finite = np.abs(thick[np.isfinite(thick)])
        thickness = scale_for(float(np.median(finite)) if len(finite) else 0.0, shown[0].units["viscosity"])
        below.plot(times(shown), thickness.factor * thick, color=PALETTE[1])
        below.set(ylabel=f"viscosity ({thickness.unit})", xlabel="time (s)", xlim=span(times(shown)))
        _within_most(below, thickness.factor * thick)
    return drawn


def _within_most(axes: Axes, values: Array) -> None:
    """Set the range from the first to the last percent of the finite values."""
    finite = values[np.isfinite(values)]
    if len(finite):
        low, high = np.percentile(finite, (1, 99))
        margin = 0.08 * (high - low) or 1.0
        axes.set_ylim(low - margin, high + margin)


def swaps(frames: Frames, scene: SoftScene) -> Figure:
    """T1 events: their positions, and their cumulative number over time."""
    now = times(evolution(frames))
    found = neighbor_swaps(frames)
    with style():
        drawn = figure(8.6, 4.2)
        where, when = drawn.subplots(1, 2, width_ratios=(1.0, 1.0))
        marks = _swap_map(where, frames[-1], found)
        where.set_title(titled("Positions of T1 events", scene))
        if marks is not None:
            drawn.colorbar(marks, ax=where, label="time (s)", shrink=0.8)
        instants, count = cumulative(found.times, now)
        steps(when, instants, count.tolist(), "T1 events", PALETTE[1])
        when.set(xlabel="time (s)", ylabel="T1 events", title="Cumulative number of T1 events", xlim=span(now))
        when.set_ylim(0.0, 1.08 * max(count[-1], 1))
        if found.unpaired:
            message = f"other changes of neighbors: {found.unpaired}"
            when.text(0.02, 0.97, message, transform=when.transAxes, va="top", color=MUTED, fontsize=8)
    return drawn


def cumulative(events: Array, instants: Array) -> tuple[Array, Array]:
    """The corners of a step line that counts events from (start, 0) to the end of a run.

    >>> [values.tolist() for values in cumulative(np.array([3.0, 2.0]), np.array([0.0, 5.0]))]
    [[0.0, 2.0, 3.0, 5.0], [0, 1, 2, 2]]
    """
    count = np.arange(len(events) + 1)
    return np.concatenate([instants[:1], np.sort(events), instants[-1:]]), np.append(count, count[-1])


def _swap_map(axes: Axes, frame: Frame, found: Swaps) -> Any:
    """The outlines of the spheres in the last frame, and a dot for each event."""
    factor = _outlines(axes, frame).factor
    if not found.events:
        axes.text(0.5, 0.5, "no T1 event", transform=axes.transAxes, ha="center", color=MUTED)
        return None
    look: dict[str, Any] = {"cmap": "viridis", "s": 26, "zorder": 3, "edgecolors": "white", "linewidths": 0.5}
    return axes.scatter(factor * found.places[:, 0], factor * found.places[:, 1], c=found.times, **look)


def _outlines(axes: Axes, frame: Frame) -> Scale:
    """The unfilled outlines of spheres in 2D, with copies across periodic borders; the scale of both axes."""
    position, radius, box = frame.arrays["position"][:, :2], frame.arrays["radius"], flat_box(frame)
    margin = float(radius.max())
    around = copies(position, box, margin)
    sides = np.zeros(2) if box is None else box.sides
    # Half of the line width of the outermost circles is outside of the spheres.
    room = 1.04 * margin
    low, high = np.where(sides > 0.0, [np.zeros(2), sides], [position.min(axis=0) - room, position.max(axis=0) + room])
    scale = scale_for(float(np.abs([low, high]).max()), "m")
    diameter = scale.factor * 2.0 * radius[around.owner]
    look: dict[str, Any] = {"facecolors": "none", "edgecolors": MUTED, "linewidths": 0.5, "units": "xy"}
    places = scale.factor * around.position
    rings = EllipseCollection(
        diameter, diameter, np.zeros_like(diameter), offsets=places, offset_transform=axes.transData, **look
    )
    axes.add_collection(rings, autolim=False)
    low, high = scale.factor * low, scale.factor * high
    axes.set(
        xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel=f"x ({scale.unit})",
        ylabel=f"y ({scale.unit})",
    )  # fmt: skip
    axes.locator_params(nbins=5)
    axes.grid(visible=False)
    return scale


def nonaffine(frames: Frames, scene: SoftScene) -> Figure:
    """The motion relative to the affine deformation of the box up to the last frame, and the residuals of local
    deformations.
    """
    require_box(scene, "even deformation")
    before, after = _strain_apart(frames)
    moved = nonaffine_displacement(before, after)
    reach = NEAR * float(after.arrays["radius"].max())
    rest = np.sqrt(local_deformation(before, after, reach).rest) / float(after.arrays["radius"].mean())
    place = after.arrays["position"]
    with style():
        drawn = figure(6.2, 4.8)
        axes = drawn.add_subplot()
        x, y = _outlines(axes, after).factor * place[:, :2].T
        dots = axes.scatter(x, y, c=rest, cmap="magma_r", s=30, zorder=2)
        arrows = axes.quiver(x, y, *moved[:, :2].T, color=INK, width=0.004, zorder=3)
        longest = float(np.linalg.norm(moved, axis=1).max())
        scale = scale_for(longest, "m")
        if longest > 0.0:
            message = f"{longest * scale.factor:.3g} {scale.unit}"
            axes.quiverkey(arrows, 0.85, 1.04, longest, message, labelpos="E", fontproperties={"size": 8})
        drawn.colorbar(dots, ax=axes, label="root of D²min (mean radii)", shrink=0.8)
        message = f"from {before.time:.4g} s to {after.time:.4g} s"
        axes.text(0.0, 1.01, message, transform=axes.transAxes, fontsize=8, color=MUTED)
        axes.set_title(titled("Non-affine motion", scene), pad=16)
    return drawn


def _strain_apart(frames: Frames) -> tuple[Frame, Frame]:
    """The last frame, and the latest earlier one whose strain differs sufficiently; without such a frame, the second to
    last one.
    """
    if len(frames) < 2:
        raise BadInput("motion takes two frames or more")
    (strain,) = series(frames, number("strain"))
    far = np.flatnonzero(np.abs(strain[:-1] - strain[-1]) >= APART)
    return frames[int(far[-1]) if len(far) else len(frames) - 2], frames[-1]


def require_box(scene: SoftScene, what: str) -> None:
    """Raise BadInput for a box between walls, whose frames contain neither strain nor stress."""
    if scene.cell is None or scene.walls:
        raise BadInput(f"there is no box{' without walls' if scene.walls else ''} whose {what} could be drawn")


LAYERS = 12
"""Across a cell."""


def across(frames: Frames, scene: SoftScene) -> Figure:
    """Velocity and volume fraction over the height, means over the second half of the frames: shear bands show. Spheres
    that make walls rough are shaded; a straight profile is that of the layers between them.
    """
    late = list(frames)
    late = late[len(late) // 2 :]
    found, (low, high) = layers(late, LAYERS), between_rough_walls(late, scene)
    top = found.height[0] + found.height[-1]
    flowing = (found.height > low) & (found.height < high)
    height = scale_for(float(found.height[-1]), "m")
    speeds = [one.value for one in found.velocity]
    speed = scale_for(max(map(abs, speeds)), "m/s")
    with style():
        drawn = figure(7.0, 3.8)
        panels = drawn.subplots(1, 2, sharey=True)
        for axes, means, factor, label in (
            (panels[0], found.velocity, speed.factor, f"velocity along x ({speed.unit})"),
            (panels[1], found.fraction, 1.0, "volume fraction"),
        ):
            values, errors = ([factor * part for part in parts] for parts in zip(*means, strict=True))
            axes.errorbar(
                values, height.factor * found.height, xerr=errors, fmt="o-", markersize=4, capsize=2, color=PALETTE[1]
            )
            axes.set_xlabel(label)
            axes.set_ylim(0.0, height.factor * top)
            for start, end in ((0.0, low), (high, top)):
                axes.axhspan(height.factor * start, height.factor * end, color=MUTED, alpha=0.2, lw=0.0)
        if flowing.sum() > 1 and np.isfinite(np.array(speeds)[flowing]).all():
            line = np.polyfit(found.height[flowing], np.array(speeds)[flowing], 1)
            panels[0].plot(
                speed.factor * np.polyval(line, found.height[flowing]), height.factor * found.height[flowing],
                color=MUTED, linestyle=":", label="straight",
            )  # fmt: skip
        panels[0].set(ylabel=f"height ({height.unit})", title=titled("Across the cell", scene))
        panels[0].legend()
    return drawn


def between_rough_walls(frames: Frames, scene: SoftScene) -> tuple[float, float]:
    """The heights above the bottom (m) between which no sphere is glued to the bottom or the top, mean over frames;
    the ends of the cell where the wall is smooth.
    """
    ends = []
    for side, inward in (("bottom", 1.0), ("top", -1.0)):
        species = [index for index, one in enumerate(scene.particles) if one.glued == side]
        for frame in frames:
            bottom, top, _ = ends_of(frame)
            wall = bottom if side == "bottom" else top
            glued = np.isin(frame.arrays["species"], species)
            reach = inward * (frame.arrays["position"][glued, 1] - wall) + frame.arrays["radius"][glued]
            ends.append(wall - bottom + inward * float(reach.max(initial=0.0)))
    low, high = np.array(ends).reshape(2, -1).mean(axis=1)
    return float(low), float(high)


MEASURE_FIGURES = {
    "gap-distribution": gap_histogram,
    "coordination": coordination,
    "viscosity": viscosity,
    "swaps": swaps,
    "nonaffine": nonaffine,
    "across": across,
}
