"""The figures of sums over many floats; `docs/figures.py` draws them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from scipy.special import k1

from ecume._quick import sized
from ecume.laws import pair_laws
from ecume.models import MODELS
from ecume.models.floating.forces import ewald_grid
from ecume.models.floating.forces.magnets import DipoleMoments
from ecume.models.floating.parameters import part_of
from ecume.models.floating.time_integration.integration import forces_at
from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.show.style import INK, MUTED, PALETTE, figure, style
from ecume.simulation import simulate
from ecume.units import Array

BEADS = '[[particles]]\ncount = {count}\nradius = "20 um"\ndensity = 2000.0\ncontact_angle = "90 deg"\n'
SCENE = (
    'model = "floating"\nduration = 1.0\nframe_every = 1.0\n{beads}[integration]\nintegrator = "overdamped"\n'
    '[interaction]\nsummation = "grid"\naccuracy = {accuracy}\n'
)
ASKED = np.array(sized([1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8], [1e-2, 1e-4]))
COUNT = sized(3000, 300)
PROBED = 100
"""Floats whose forces are compared with a direct sum."""


def measured_errors(accuracy: float) -> tuple[float, float]:
    """R.m.s. errors over r.m.s. forces of beads that cover 15 %: with charges of random sign, and all alike."""
    model = MODELS["floating"]
    scene = load_scene(SCENE.format(beads=BEADS.format(count=COUNT), accuracy=accuracy))
    parameters = model.parameters(scene)
    state = model.start(scene, parameters)
    signs = np.random.default_rng(1).choice([-1.0, 1.0], COUNT)
    found = []
    for sign in (signs, np.ones(COUNT)):
        charge = parameters.floats.charge * sign
        charged = parameters._replace(floats=parameters.floats._replace(charge=charge))
        workspace = model.workspace(charged, state, 1.0)
        forces_at(charged, state.position, workspace)
        wanted = _direct(parameters.pair, state.position, charge)
        found.append(float(np.sqrt(np.sum((workspace.force[:PROBED] - wanted) ** 2) / np.sum(wanted**2))))
    return found[0], found[1]


def _direct(pair: Array, position: Array, charge: Array) -> Array:
    apart = position[None] - position[:PROBED, None]
    distance = np.hypot(apart[..., 0], apart[..., 1]) / pair[1]
    distance[np.arange(PROBED), np.arange(PROBED)] = np.inf
    pull = pair[0] / pair[1] ** 2 * charge[:PROBED, None] * charge * k1(distance) / distance
    return np.asarray(np.einsum("ij,ijk->ik", pull, apart))


def counted_work(count: int, radius: float, coverage: float) -> tuple[float, float]:
    """Work of a float, in pairs, with cells alone and with a grid; the radius is over the capillary length."""
    density = coverage / (np.pi * radius**2)
    between = np.sqrt(density * ewald_grid.PACKED / (np.pi * radius**2))
    statistics = ewald_grid.FloatStatistics(count, between, float(np.sqrt(count / density)), 2.0 * radius, radius, 10.2)
    return statistics.neighbors(statistics.cutoff), ewald_grid.best_split(statistics, 1e-4)[0].work / count


def crowds() -> Figure:
    """What is asked for and what comes out; and what it costs from a thousand to a million."""
    with style():
        drawn = figure(9.6, 4.0)
        left, right = drawn.subplots(1, 2)
        errors = np.array([measured_errors(accuracy) for accuracy in ASKED])
        left.loglog(ASKED, ASKED, color=MUTED, linewidth=0.8)
        left.loglog(ASKED, errors[:, 0], "o", color=PALETTE[0], label="charges of random sign")
        left.loglog(ASKED, errors[:, 1], "s", color=PALETTE[1], label="charges of one sign")
        left.set(xlabel="specified accuracy", ylabel="r.m.s. error / r.m.s. force")
        left.legend(fontsize=8)
        counts = np.geomspace(1e3, 1e6, sized(13, 3))
        for color, radius, coverage in ((PALETTE[0], 0.007, 0.15), (PALETTE[1], 0.007, 0.5), (PALETTE[2], 0.1, 0.5)):
            work = np.array([counted_work(int(count), radius, coverage) for count in counts])
            right.loglog(counts, work[:, 0], "--", color=color)
            right.loglog(counts, work[:, 1], color=color, label=f"R = {radius:g} L, coverage {coverage:.0%}")
        right.plot([], [], "--", color=INK, label="cells only")
        right.set(xlabel="floats", ylabel="pairs per float and step")
        right.legend(fontsize=8)
    return drawn


def magnets() -> Figure:
    """What two magnets do to each other over their distance, and what many come to."""
    scene = load_scene(str(folder() / "mermaid.toml"))
    parameters = MODELS["floating"].parameters(scene)
    length, unit, charge = parameters.pair[1], parameters.pair[0], parameters.floats.charge[0]
    touching, moment = 2.0 * parameters.floats.radius[0], part_of(parameters, DipoleMoments).moment[0]
    with style():
        drawn = figure(9.6, 4.2)
        left, right = drawn.subplots(1, 2)
        distance = np.geomspace(touching, 12.0 * length, 200)
        pull = unit * charge**2 / length * k1(distance / length)
        for color, share in zip(PALETTE, (0.5, 1.0, 2.0, 4.0), strict=False):
            push = pair_laws.dipole_force(distance, pair_laws.dipole_strength(share * moment, share * moment))
            left.plot(
                distance / length, (push - pull) / pull[0], color=color, label=f"m = {share * moment * 1e6:.3g} µA m²"
            )
        left.axhline(0.0, color=MUTED, linewidth=0.8)
        left.set(
            xlabel="distance of the centers / L", ylabel="force / attraction at contact", ylim=(-0.9, 0.6), xscale="log"
        )
        left.legend(fontsize=8)
        *_, frame = simulate(scene)
        for x, y in 1e3 * frame.arrays["position"]:
            right.add_patch(Circle((x, y), 500.0 * touching, facecolor=PALETTE[1], edgecolor=INK, linewidth=0.4))
        right.add_patch(Circle((0.0, 0.0), 1e3 * scene.dish.radius, fill=False, edgecolor=MUTED))
        right.set(xlim=(-41, 41), ylim=(-41, 41), aspect="equal", xlabel="mm", ylabel="mm")
    return drawn


FIGURES: dict[str, Callable[[], Figure]] = {"crowds": crowds, "magnets": magnets}
