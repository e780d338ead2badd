"""The figure of numbers that were sampled between frames."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ecume.errors import BadInput
from ecume.models import MODELS
from ecume.show.curves import Frames, span, titled
from ecume.show.style import PALETTE, figure, plain, scale_for, style
from ecume.trajectories.reader import Trajectory
from ecume.trajectories.samples import Samples

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene

MOST_PANELS = 8
"""Numbers that one figure shows; of more, the main ones of the model."""


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
    """The numbers sampled between frames over time; of blocks the mean, and the range as a band."""
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


def shown_numbers(found: Samples, main: tuple[str, ...]) -> list[str]:
    """The numbers of the figure: all of a few, the main ones of many."""
    if len(found.names) <= MOST_PANELS:
        return found.names
    return [name for name in found.names if name in main][:MOST_PANELS] or found.names[:MOST_PANELS]


def _title(found: Samples) -> str:
    return f"Averages of {found.counts[0]} samples" if found.blocks else "Samples"


def _curve(axes: Axes, found: Samples, name: str) -> None:
    """One number with its range, in the unit that fits it."""
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
