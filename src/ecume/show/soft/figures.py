"""The figures of the soft model: gaps, forces, stresses and steps over time, and the last instant."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ecume.analysis.series import number, series, times
from ecume.show.curves import Frames, evolution, over_time, scaling, span
from ecume.show.soft.flow_figures import FLOW_FIGURES
from ecume.show.soft.measures import MEASURE_FIGURES, require_box
from ecume.show.soft.packing import Packing
from ecume.show.style import INK, PALETTE, figure, legend_outside, scale_for, style
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.soft import SoftScene

MOST_CURVES = 12
"""Contacts that are drawn one by one; of more, the spread."""
SPREAD = (5, 25, 50, 75, 95)
"""Per cent."""

Key = tuple[int, int]


def gaps(frames: Frames, scene: SoftScene) -> Figure:
    """The gap of every contact over time, or their spread where there are many."""
    return _of_contacts(frames, scene, "gap", "m", "Gaps of contacts")


def forces(frames: Frames, scene: SoftScene) -> Figure:
    """The normal force of every contact over time, or their spread; tension is positive."""
    return _of_contacts(frames, scene, "tension", "N", "Normal forces of contacts")


def _of_contacts(frames: Frames, scene: SoftScene, name: str, unit: str, title: str) -> Figure:
    shown = evolution(frames)
    values = [_contacts(frame, name) for frame in shown]
    keys = sorted({key for instant in values for key in instant})
    largest = max((abs(value) for instant in values for value in instant.values()), default=0.0)
    scale = scale_for(largest, unit)
    with style():
        drawn = figure(6.8, 4.0)
        axes = over_time(drawn, scene, title)
        if len(keys) <= MOST_CURVES:
            for key, color in zip(keys, itertools.cycle(PALETTE), strict=False):
                curve = [scale.factor * instant.get(key, np.nan) for instant in values]
                axes.plot(times(shown), curve, color=color, label=f"spheres {key[0]} and {key[1]}")
            legend_outside(axes)
        else:
            _spread(axes, times(shown), [scale.factor * np.array(list(instant.values())) for instant in values])
        label = "normal force, tension positive" if name == "tension" else name
        axes.set(ylabel=f"{label} ({scale.unit})", xlim=span(times(shown)))
        if name == "gap":
            axes.set_yscale(scaling([value for instant in values for value in instant.values()]))
    return drawn


def _contacts(frame: Frame, name: str) -> dict[Key, float]:
    """Each contact's value, by the numbers of its spheres."""
    first, slot = np.nonzero(frame.arrays["neighbor"] >= 0)
    second = frame.arrays["neighbor"][first, slot]
    return dict(zip(zip(first.tolist(), second.tolist(), strict=True), frame.arrays[name][first, slot], strict=True))


def _spread(axes: Axes, instants: Array, values: list[Array]) -> None:
    """Percentiles as nested bands around the median."""
    low, lower, median, upper, high = np.array([np.percentile(one, SPREAD) for one in values]).T
    axes.fill_between(instants, low, high, color=PALETTE[1], alpha=0.2, linewidth=0, label="5 to 95 %")
    axes.fill_between(instants, lower, upper, color=PALETTE[1], alpha=0.4, linewidth=0, label="25 to 75 %")
    axes.plot(instants, median, color=INK, label="median")
    legend_outside(axes)


def elastic_energy(frames: Frames, scene: SoftScene) -> Figure:
    """The elastic energy of the deflections of all surfaces."""
    shown = evolution(frames)
    (energy,) = series(shown, number("elastic_energy"))
    scale = scale_for(float(energy.max()), "J")
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Elastic energy")
        axes.plot(times(shown), scale.factor * energy, color=PALETTE[1])
        axes.set(ylabel=f"elastic energy ({scale.unit})", xlim=span(times(shown)))
    return drawn


def stress(frames: Frames, scene: SoftScene) -> Figure:
    """Shear stress and normal stress of a periodic box over time."""
    require_box(scene, "stress")
    shown = evolution(frames)
    shear, normal, pressure = series(shown, *map(number, ("shear_stress", "normal_stress", "pressure")))
    scale = scale_for(float(np.abs([shear, normal, pressure]).max()), shown[0].units["shear_stress"])
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Stresses")
        for label, values, color in zip(
            ("shear", "normal", "pressure"), (shear, normal, pressure), PALETTE, strict=False
        ):
            axes.plot(times(shown), scale.factor * values, color=color, label=label)
        axes.set(ylabel=f"stress ({scale.unit})", xlim=span(times(shown)))
        legend_outside(axes)
    return drawn


def picture(frames: Frames, scene: SoftScene) -> Figure:
    """The last frame: spheres, films and forces."""
    shown = Packing(scene, [frames[0], frames[len(frames) // 2], frames[-1]])
    shown.show(frames[-1])
    return shown.figure


SOFT_FIGURES = {
    "gaps": gaps,
    "forces": forces,
    "elastic-energy": elastic_energy,
    "stress": stress,
    **MEASURE_FIGURES,
    **FLOW_FIGURES,
    "packing": picture,
}
