"""The force between two floats of a scene over their distance: by superposition, by corrected pairs, by multipoles."""

from __future__ import annotations

import itertools
import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from ecume.errors import BadInput
from ecume.laws import capillarity
from ecume.laws.multipole.solving import forces
from ecume.laws.pair_laws import PAIR_LAWS
from ecume.models.floating.forces import multipoles
from ecume.models.floating.forces.multipoles import bodies_and_charges
from ecume.models.floating.setup.kinds import FloatKind, distinct_kinds
from ecume.models.liquids import liquid_of
from ecume.scenes.load import load_scene
from ecume.show.curves import titled
from ecume.show.style import INK, PALETTE, figure, plain, save, scale_for, style
from ecume.units import Array

FURTHEST = 4.0
"""How far forces are drawn, in capillary lengths beyond touching."""
PLACES = 40
ORDER = 16
MOST_PAIRS = 6
LINES = {"superposition": ":", "pair-corrected": "-", "multipole": "o"}


class Forces(NamedTuple):
    """Of one pair of kinds, positive where they repel (N)."""

    label: str
    distance: Array
    """m, of the centers"""
    by_method: dict[str, Array]


def force_law(path: str | os.PathLike[str], out: str | os.PathLike[str]) -> Path:
    """Draw the forces between all kinds of floats of a scene's file into `out`, by each method."""
    scene: Any = load_scene(Path(path))
    if scene.model != "floating" or not PAIR_LAWS[str(scene.interaction.law)].menisci:
        named = [repr(name) for name, row in PAIR_LAWS.items() if row.menisci]
        raise BadInput(f"{os.fspath(path)}: expected a scene of floats with interaction.law = {' or '.join(named)}")
    return save(drawn_forces(scene), Path(out))


def drawn_forces(scene: Any) -> Figure:
    """The forces between all kinds of floats of a scene, by each method."""
    found = pair_forces(scene)
    length = liquid_of(scene).capillary_length
    scale = scale_for(max(float(np.abs(force).max()) for pair in found for force in pair.by_method.values()), "N")
    with style():
        drawn = figure(6.4, 4.6)
        axes = drawn.add_subplot(xlabel="gap, in capillary lengths", title=titled("Force between two floats", scene))
        for pair, color in zip(found, itertools.cycle(PALETTE[1:]), strict=False):
            gap = (pair.distance - pair.distance[0]) / length
            for method, force in pair.by_method.items():
                attracts = force[0] < 0.0
                label = f"{plain(pair.label)}: {'attract' if attracts else 'repel'}"
                size = np.abs(scale.factor * force)
                look = LINES[method]
                axes.plot(
                    gap, size, look, color=color, markersize=3, label=label if method == "pair-corrected" else None
                )
        for method, look in LINES.items():
            axes.plot([], [], look, color=INK, markersize=3, label=method)
        axes.set(yscale="log", ylabel=f"size of the force ({scale.unit})")
        axes.legend(fontsize=8)
    return drawn


def pair_forces(scene: Any) -> list[Forces]:
    """The forces of each pair of kinds of floats, as a run takes them. Raises BadInput where menisci are flat."""
    kinds, number = distinct_kinds(scene)
    names = _names(scene, number, len(kinds))
    pairs = list(itertools.combinations_with_replacement(range(len(kinds)), 2))[:MOST_PAIRS]
    charged = [pair for pair in pairs if kinds[pair[0]].charge * kinds[pair[1]].charge != 0.0]
    if not charged:
        raise BadInput("these floats do not deform the surface; no force to draw")
    return [_forces_of(scene, (kinds[i], kinds[j]), f"{names[i]} – {names[j]}") for i, j in charged]


def _names(scene: Any, number: Any, count: int) -> list[str]:
    """What each kind is called: its species; rows of one species may be of several kinds."""
    species = [name for given in scene.particles for name in [given.name] * given.count]
    species += [row.species_name for row in scene.rows]
    return [species[int(np.flatnonzero(number == kind)[0])] for kind in range(count)]


def _forces_of(scene: Any, pair: tuple[FloatKind, FloatKind], label: str) -> Forces:
    liquid = liquid_of(scene)
    length, touching = liquid.capillary_length, pair[0].radius + pair[1].radius
    distance = touching + FURTHEST * length * np.linspace(0.0, 1.0, PLACES) ** 2
    strength = capillarity.pair_strength(liquid.surface_tension, pair[0].charge, pair[1].charge)
    summed = np.array([capillarity.pair_force(float(each), strength, length) for each in distance])
    reach = float(distance[-1]) + touching
    bodies, numbers = bodies_and_charges(pair), np.array([0, 1])
    tables = multipoles.make_pair_tables(bodies, numbers, liquid, reach)
    beyond = np.array([multipoles.correction(tables, 0, 1, float(each))[1] for each in distance])
    solved = _by_multipoles(multipoles.make_multipoles(bodies, liquid, ORDER, reach), distance)
    by_method = {"superposition": summed, "pair-corrected": summed + beyond, "multipole": solved}
    return Forces(label, distance, by_method)


def _by_multipoles(both: multipoles.Multipoles, distance: Array) -> Array:
    """The force on the second of two, away from the first (N)."""
    orders, force, found = both.rims.response.shape[1], np.zeros((2, 2)), np.zeros_like(distance)
    crowd = multipoles.multipole_scratch(np.zeros((2, 2 * orders)), np.zeros((2, 0)))
    for k in range(len(distance)):
        multipoles.resolve(both, np.array([[0.0, 0.0], [distance[k], 0.0]]), crowd)
        forces(both.rims, crowd.amplitudes, crowd.waves, force)
        found[k] = both.tension * both.length * force[1, 0]
    return found
