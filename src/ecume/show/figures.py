"""Figures of a run: each a function from frames and their scene to a Matplotlib figure, and the table of them all."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ecume.analysis.clusters import touching_clusters
from ecume.analysis.series import number, series, times, tracks
from ecume.errors import BadInput
from ecume.laws.capillarity import pair_force, pair_strength
from ecume.show.bowl import Bowl, dish_outline, species, species_dots, view_of
from ecume.show.integrators import integrator_comparison
from ecume.show.style import INK, MUTED, PALETTE, figure, legend_outside, plain, save, scale_for, style
from ecume.show.surface import liquid_of
from ecume.trajectories.frame import Frame
from ecume.trajectories.reader import open_trajectory
from ecume.units import Array

__all__ = ["FIGURES", "integrator_comparison", "plot"]

MOST_INSTANTS = 400
"""A curve or a path of more frames than this looks no different, and takes longer to read and to draw."""
LEAST = 1e-15
"""The part of its largest value below which the kinetic energy is not drawn."""
FURTHEST = 6.0
"""How far the force law is drawn, in capillary lengths."""

Frames = Sequence[Frame]


def plot(directory: str | os.PathLike[str], what: str, out: str | os.PathLike[str] | None = None) -> Path:
    """Draw a figure of a run, one of FIGURES, into `out`; left out, into a PNG among the run's results.

    The name says the format: `energies.pdf` and `energies.svg` are vector graphics. Returns the file that was written.
    """
    if what not in FIGURES:
        raise BadInput(f"no such figure as {what!r}; there are {', '.join(FIGURES)}")
    target = Path(directory) / "results" / f"{what}.png" if out is None else Path(out)
    with open_trajectory(directory) as trajectory:
        if not len(trajectory):
            raise BadInput(f"{directory}: the run has no frames yet; there is nothing to draw")
        return save(FIGURES[what](trajectory, trajectory.scene), target)


def energies(frames: Frames, scene: Any) -> Figure:
    """Kinetic and potential energies, their sum, and what the run has lost of it since it began."""
    shown = _thinned(frames)
    names = [name for name, unit in shown[0].units.items() if unit == "J" and name != "total_energy"]
    *parts, total = series(shown, *map(number, [*names, "total_energy"]))
    labels = [name.removesuffix("_energy") for name in names]
    curves = [*zip(labels, parts, strict=True), ("total", total), ("dissipated", total[0] - total)]
    scale = scale_for(max(float(np.abs(values).max()) for _, values in curves), "J")
    with style():
        drawn = figure()
        axes = _over_time(drawn, scene)
        for (label, values), color in zip(curves, itertools.cycle(PALETTE), strict=False):
            dashes = "--" if label == "dissipated" else "-"
            axes.plot(
                times(shown), scale.factor * values, dashes, color=INK if label == "total" else color, label=label
            )
        axes.set_ylabel(f"energy ({scale.unit})")
        legend_outside(axes)
    return drawn


def kinetic_energy(frames: Frames, scene: Any) -> Figure:
    """The kinetic energy on a logarithmic scale: how a bowl comes to rest."""
    shown = _thinned(frames)
    (kinetic,) = series(shown, number("kinetic_energy"))
    scale = scale_for(float(kinetic.max()), "J")
    with style():
        drawn = figure()
        axes = _over_time(drawn, scene)
        # A bowl at rest goes on losing decades that nobody could see.
        seen = np.where(kinetic > LEAST * kinetic.max(), kinetic, np.nan)
        axes.plot(times(shown), scale.factor * seen, color=PALETTE[1])
        axes.set(yscale="log", xlim=_span(times(shown)))
        axes.set_ylabel(f"kinetic energy ({scale.unit})")
    return drawn


def clusters(frames: Frames, scene: Any) -> Figure:
    """How many clusters there are, and how large they are: single floats count as clusters of one."""
    shown = _thinned(frames)
    found = [touching_clusters(frame) for frame in shown]
    with style():
        drawn = figure(6.4, 4.8)
        above, below = drawn.subplots(2, 1, sharex=True)
        _steps(above, times(shown), [len(each.sizes) for each in found], "all", PALETTE[1])
        _steps(below, times(shown), [each.largest for each in found], "largest", PALETTE[0])
        _steps(below, times(shown), [each.mean_size for each in found], "mean", PALETTE[2])
        above.set(ylabel="number of clusters", title=plain(scene.title))
        below.set(ylabel="floats in a cluster", xlabel="time (s)", xlim=_span(times(shown)))
        legend_outside(below)
    return drawn


def _steps(axes: Axes, instants: Array, counts: Sequence[float], label: str, color: str) -> None:
    """Counts over time, from zero, on whole numbers."""
    axes.plot(instants, counts, color=color, label=label, drawstyle="steps-post")
    axes.set_ylim(bottom=0)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=6))


def paths(frames: Frames, scene: Any) -> Figure:
    """The path of every float, from an open circle to where it is last, which is drawn to scale."""
    shown = _thinned(frames)
    view, kinds = view_of(scene, shown), species(scene)
    scale = scale_for(view.width / 2, "m")
    colors = [kinds[kind].color for kind in shown[-1].arrays["species"]]
    where = scale.factor * tracks(shown).swapaxes(0, 1)
    with style():
        drawn = figure(5.4, 5.4 * min(max(view.height / view.width, 0.4), 1.6))
        axes = drawn.add_subplot(aspect="equal")
        axes.set(xlim=np.multiply(view[:2], scale.factor), ylim=np.multiply(view[2:], scale.factor))
        axes.set(xlabel=f"x ({scale.unit})", ylabel=f"y ({scale.unit})", title=plain(scene.title))
        axes.grid(visible=False)
        _discs(axes, where[:, -1], scale.factor * shown[-1].arrays["radius"], colors)
        axes.add_collection(LineCollection(list(where), colors=MUTED, linewidths=0.9, alpha=0.8))
        axes.scatter(where[:, 0, 0], where[:, 0, 1], s=9, facecolors="white", edgecolors=INK, linewidths=0.6, zorder=3)
        if scene.dish is not None:
            axes.add_patch(dish_outline(scene.dish, scale.factor))
        if len(kinds) > 1:
            axes.legend(handles=species_dots(kinds), loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)
    return drawn


class Pair(NamedTuple):
    """Two species that pull at each other."""

    label: str
    touching: float
    strength: float


def force_law(frames: Frames, scene: Any) -> Figure:
    """The force between two floats over their distance, for each pair of species; a dot where they touch."""
    if scene.interaction.law != "capillary":
        raise BadInput(f"the law between these floats is {scene.interaction.law!r}: there is no force to draw")
    length = liquid_of(scene).capillary_length
    pairs = _pairs(frames[0], scene)
    reach = max(FURTHEST * length, 1.5 * max(pair.touching for pair in pairs))
    with style():
        drawn = figure(6.4, 4.2)
        axes = drawn.add_subplot(xlabel="distance of the centers (mm)", title=plain(scene.title))
        largest = max(abs(pair_force(pair.touching, pair.strength, length)) for pair in pairs)
        scale = scale_for(largest, "N")
        for pair, color in zip(pairs, itertools.cycle(PALETTE[1:]), strict=False):
            distance = np.linspace(pair.touching, reach, 300)
            force = np.array([pair_force(float(r), pair.strength, length) for r in distance]) * scale.factor
            attracts = pair.strength > 0
            label = f"{plain(pair.label)}: {'attract' if attracts else 'repel'}"
            axes.plot(1e3 * distance, np.abs(force), "-" if attracts else "--", color=color, label=label)
            axes.plot(1e3 * distance[:1], np.abs(force[:1]), "o", color=color, markersize=5)
        axes.set(yscale="log", xlim=(0, 1e3 * reach), ylabel=f"force ({scale.unit})")
        unit = 1e3 * length
        lengths = (lambda mm: np.asarray(mm, float) / unit, lambda x: np.asarray(x, float) * unit)
        above = axes.secondary_xaxis("top", functions=lengths)
        above.set_xlabel("in capillary lengths")
        axes.legend()
    return drawn


def bowl(frames: Frames, scene: Any) -> Figure:
    """The last frame as seen from above, on the height of the liquid."""
    picture = Bowl(scene, [frames[0], frames[-1]])
    picture.show(frames[-1])
    return picture.figure


FIGURES: dict[str, Callable[[Frames, Any], Figure]] = {
    "energies": energies,
    "kinetic-energy": kinetic_energy,
    "clusters": clusters,
    "paths": paths,
    "force-law": force_law,
    "bowl": bowl,
}


def _thinned(frames: Frames) -> list[Frame]:
    """Frames from the first to the last, evenly, not too many."""
    chosen = np.linspace(0, len(frames) - 1, min(len(frames), MOST_INSTANTS)).round()
    return [frames[int(index)] for index in chosen]


def _span(instants: Array) -> tuple[float, float] | None:
    return (float(instants[0]), float(instants[-1])) if instants[-1] > instants[0] else None


def _over_time(drawn: Figure, scene: Any) -> Axes:
    axes = drawn.add_subplot(xlabel="time (s)", title=plain(scene.title))
    axes.margins(x=0)
    return axes


def _discs(axes: Axes, centers: Array, radius: Array, colors: Sequence[str]) -> None:
    """Circles to scale."""
    look: dict[str, Any] = {"facecolors": colors, "edgecolors": INK, "linewidths": 0.6}
    look |= {"offsets": centers, "offset_transform": axes.transData}
    axes.add_collection(EllipseCollection(2 * radius, 2 * radius, 0 * radius, units="xy", **look))


def _pairs(frame: Frame, scene: Any) -> list[Pair]:
    """Each pair of species, with the radius and charge that its floats have in the run."""
    arrays, tension = frame.arrays, scene.liquid.surface_tension
    kinds = [
        (kind.name, float(np.median(arrays["radius"][chosen])), float(np.median(arrays["charge"][chosen])))
        for index, kind in enumerate(species(scene))
        if (chosen := arrays["species"] == index).any()
    ]
    found = [
        Pair(f"{a} – {b}", radius_a + radius_b, pair_strength(tension, charge_a, charge_b))
        for (a, radius_a, charge_a), (b, radius_b, charge_b) in itertools.combinations_with_replacement(kinds, 2)
    ]
    charged = [pair for pair in found if pair.strength != 0.0]
    if not charged:
        raise BadInput("these floats leave the surface flat: there is no force to draw")
    return charged
