"""The figures of the floating model: what floats do, and by which force."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure

from ecume.analysis.series import tracks
from ecume.errors import BadInput
from ecume.laws.pair_laws import PAIR_LAWS, PairLaw, PairParameters, Setting
from ecume.models.floating.forces.pair_forces import constants_of
from ecume.models.liquids import liquid_of
from ecume.show.curves import Frames, clusters, energies, kinetic_energy, thinned, titled
from ecume.show.floating.bowl import Bowl, dish_outline, view_of
from ecume.show.floating.measures import CLUSTER_FIGURES, MEASURES
from ecume.show.picture import species, species_dots
from ecume.show.style import INK, MUTED, PALETTE, figure, plain, scale_for, style
from ecume.trajectories.frame import Frame
from ecume.units import Array

FURTHEST = 6.0
"""How far the force law is drawn, in capillary lengths."""


def paths(frames: Frames, scene: Any) -> Figure:
    """The path of every float, from an open circle to where it is last, which is drawn to scale."""
    shown = thinned(frames)
    view, kinds = view_of(scene, shown), species(scene)
    scale = scale_for(view.width / 2, "m")
    colors = [kinds[kind].color for kind in shown[-1].arrays["species"]]
    where = scale.factor * tracks(shown).swapaxes(0, 1)
    with style():
        drawn = figure(5.4, 5.4 * min(max(view.height / view.width, 0.4), 1.6))
        axes = drawn.add_subplot(aspect="equal")
        axes.set(xlim=np.multiply(view[:2], scale.factor), ylim=np.multiply(view[2:], scale.factor))
        axes.set(xlabel=f"x ({scale.unit})", ylabel=f"y ({scale.unit})", title=titled("Paths", scene))
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
    """Two species and the force between them."""

    label: str
    touching: float
    force: Callable[[float], float]


def force_law(frames: Frames, scene: Any) -> Figure:
    """The force between two floats over their distance, for each pair of species; a dot where they touch."""
    row = PAIR_LAWS[str(scene.interaction.law)]
    if not (row.has_force and row.reciprocal):
        raise BadInput(f"the law between these floats is {scene.interaction.law!r}; no force to draw")
    length = liquid_of(scene).capillary_length
    pairs = _pairs(frames[0], scene, row)
    reach = max(FURTHEST * length, 1.5 * max(pair.touching for pair in pairs))
    with style():
        drawn = figure(6.4, 4.2)
        axes = drawn.add_subplot(xlabel="distance of the centers (mm)", title=titled("Force between two floats", scene))
        largest = max(abs(pair.force(pair.touching)) for pair in pairs)
        scale = scale_for(largest, "N")
        for pair, color in zip(pairs, itertools.cycle(PALETTE[1:]), strict=False):
            distance = np.linspace(pair.touching, reach, 300)
            force = np.array([pair.force(r) for r in distance.tolist()]) * scale.factor
            attracts = pair.force(pair.touching) < 0.0
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


def _discs(axes: Axes, centers: Array, radius: Array, colors: Sequence[str]) -> None:
    """Circles to scale."""
    look: dict[str, Any] = {"facecolors": colors, "edgecolors": INK, "linewidths": 0.6}
    look |= {"offsets": centers, "offset_transform": axes.transData}
    axes.add_collection(EllipseCollection(2 * radius, 2 * radius, 0 * radius, units="xy", **look))


def _pairs(frame: Frame, scene: Any, row: PairLaw) -> list[Pair]:
    """Each pair of species with a force between them, for the radii and charges that their floats have in the run."""
    arrays, liquid = frame.arrays, liquid_of(scene)
    length, tension = liquid.capillary_length, liquid.surface_tension
    kinds = [
        (kind.name, float(np.median(arrays["radius"][chosen])), float(np.median(arrays["charge"][chosen])))
        for index, kind in enumerate(species(scene))
        if (chosen := arrays["species"] == index).any()
    ]
    radii = [radius for _, radius, _ in kinds]
    law = constants_of(scene, Setting(length, tension, 2.0 * min(radii), FURTHEST * length + 2.0 * max(radii)))

    def force_of(own: PairParameters) -> Callable[[float], float]:
        return lambda distance: row.force(distance, own, law)

    found = [
        Pair(
            f"{a} – {b}",
            radius_a + radius_b,
            force_of(PairParameters(radius_a, radius_b, charge_a, charge_b, length, tension)),
        )
        for (a, radius_a, charge_a), (b, radius_b, charge_b) in itertools.combinations_with_replacement(kinds, 2)
    ]
    charged = [pair for pair in found if pair.force(pair.touching) != 0.0]
    if not charged:
        raise BadInput("these floats do not deform the surface; no force to draw")
    return charged


FLOATING_FIGURES = {
    "energies": energies,
    "kinetic-energy": kinetic_energy,
    "clusters": clusters,
    "paths": paths,
    "force-law": force_law,
    "bowl": bowl,
    **MEASURES,
    **CLUSTER_FIGURES,
}
