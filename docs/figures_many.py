"""The figures of many bodies beyond superposition; `docs/figures.py` draws them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from scipy.special import k0, k1
from studies import rifts as rift_study

from ecume._quick import sized
from ecume.laws import flotation, multipole
from ecume.scenes.load import load_scene
from ecume.show.style import HEIGHT_COLORS, INK, MUTED, PALETTE, figure, style
from ecume.simulation import simulate
from ecume.units import Array

# Capillary length 1 m, surface tension 1 N/m: all comes out in gamma and L.
UNIT = flotation.Liquid(density=1000.0, surface_tension=1.0, viscosity=1e-3, gravity=1e-3)


def beyond_superposition() -> Figure:
    """How far superposition errs for two bodies over their gap, and the surface around seven tilting discs."""
    with style():
        drawn = figure(9.6, 4.0)
        left, right = drawn.subplots(1, 2)
        gaps = np.geomspace(3e-3, 3.0, sized(40, 3))
        cases = (
            ("spheres, θ = 60°, a = 0.3 L", flotation.Sphere(0.3, 1500.0, math.radians(60.0)), PALETTE[1], "-"),
            ("spheres, θ = 90°, a = 0.3 L", flotation.Sphere(0.3, 1500.0, 0.5 * math.pi), PALETTE[2], "-"),
            ("tilting discs, a = 0.1 L", flotation.Disc(0.1, 1e-4), PALETTE[0], "-"),
            ("tilting discs, a = L", flotation.Disc(1.0, 1e-4), PALETTE[4], "-"),
            ("level discs, a = 0.1 L", flotation.Disc(0.1, 1e-4, tilting=False), PALETTE[0], "--"),
        )
        for label, body, color, line in cases:
            left.plot(gaps, [_ratio(body, gap) for gap in gaps], line, color=color, label=label)
        left.axhline(1.0, color=MUTED, linewidth=0.8)
        left.set(xscale="log", xlabel="gap / diameter", ylabel="force / superposition", ylim=(0.6, 1.85))
        left.legend(fontsize=8)
        _raft(right)
    return drawn


def _ratio(body: flotation.Sphere | flotation.Disc, gap: float) -> float:
    apart = 2.0 * body.radius * (1.0 + gap)
    found = multipole.solve([[0.0, 0.0], [apart, 0.0]], [body, body], UNIT, 40)
    return float(found.forces[0, 0] / (2.0 * math.pi * _charge(body) ** 2 * k1(apart)))


def _charge(body: flotation.Sphere | flotation.Disc) -> float:
    if isinstance(body, flotation.Sphere):
        return body.radius * flotation.closed_form_charge(body.radius**2, 1.5, body.contact_angle)
    a = body.radius
    return float(body.load / (math.pi * a * a * k0(a) + 2.0 * math.pi * a * k1(a)))


def hexagon(apart: float) -> Array:
    """Seven places: one in the middle of six."""
    angles = math.pi / 3.0 * np.arange(6)
    return apart * np.concatenate([[[0.0, 0.0]], np.stack([np.cos(angles), np.sin(angles)], axis=1)])


def _raft(axes: object) -> None:
    """Heights over the depth of one disc alone, and the forces."""
    assert isinstance(axes, Axes)  # noqa: S101  # for the type checker
    disc, places = flotation.Disc(0.5, 0.01), hexagon(1.1)
    found = multipole.solve(places, [disc] * 7, UNIT, 20)
    side = np.linspace(-2.6, 2.6, sized(260, 26))
    x, y = np.meshgrid(side, side)
    heights = multipole.height(found, x, y) / (_charge(disc) * k0(0.5))
    largest = float(np.abs(heights).max())
    extent = (-2.6, 2.6, -2.6, 2.6)
    shown = axes.imshow(heights, extent=extent, origin="lower", cmap=HEIGHT_COLORS, vmin=-largest, vmax=largest)
    for place in places:
        axes.add_patch(Circle((place[0], place[1]), 0.5, fill=False, edgecolor=INK, linewidth=0.9))
    pull = found.forces / np.hypot(*found.forces[1])
    axes.quiver(*places[1:].T, *pull[1:].T, color=INK, width=0.007, scale=9.0)
    axes.set(xlabel="x / L", ylabel="y / L")
    axes.grid(visible=False)
    drawn = axes.get_figure(root=True)
    assert drawn is not None  # noqa: S101  # for the type checker
    bar = drawn.colorbar(shown, ax=axes, fraction=0.046)
    bar.set_label("height / depth of a single disc")


def levels() -> Figure:
    """What superposition and corrected pairs make of a raft's corner, and of the way on which three discs meet."""
    with style():
        drawn = figure(9.6, 3.8)
        left, right = drawn.subplots(1, 2)
        gaps = np.geomspace(0.01, 3.0, sized(24, 3))
        for label, body, color in (
            ("discs, a = 0.1 L", flotation.Disc(0.1, 1e-4), PALETTE[0]),
            ("discs, a = L", flotation.Disc(1.0, 1e-4), PALETTE[4]),
            ("spheres of 90°, a = 0.3 L", flotation.Sphere(0.3, 1500.0, 0.5 * math.pi), PALETTE[2]),
        ):
            shares = np.array([_corner(body, gap) for gap in gaps])
            left.plot(gaps, shares[:, 0], "--", color=color)
            left.plot(gaps, shares[:, 1], color=color, label=label)
        left.plot([], [], "--", color=MUTED, label="superposition")
        left.plot([], [], color=MUTED, label="pair-corrected")
        left.axhline(1.0, color=MUTED, linewidth=0.8)
        left.set(xscale="log", xlabel="gap / diameter", ylabel="force on a corner disc / multipoles", ylim=(0.0, 1.3))
        left.legend(fontsize=8, loc="lower right")
        _meeting(right)
    return drawn


def _corner(body: flotation.Sphere | flotation.Disc, gap: float) -> tuple[float, float]:
    """The pull on a corner of seven by superposition and by corrected pairs, over that of multipoles."""
    places = hexagon(2.0 * body.radius * (1.0 + gap))
    exact = multipole.solve(places, [body] * 7, UNIT, 20).forces[1, 0]
    summed = corrected = 0.0
    for place in np.delete(places, 1, axis=0):
        away = place - places[1]
        apart = float(np.hypot(*away))
        summed += 2.0 * math.pi * _charge(body) ** 2 * k1(apart) * away[0] / apart
        pair = multipole.solve([[0.0, 0.0], [apart, 0.0]], [body, body], UNIT, 20)
        corrected += float(pair.forces[0, 0]) * away[0] / apart
    return float(summed / exact), float(corrected / exact)


def _meeting(axes: Axes) -> None:
    """The gap of three cereal discs over time by each method."""
    for method, color in (("superposition", PALETTE[0]), ("pair-corrected", PALETTE[2]), ("multipole", PALETTE[1])):
        frames = list(simulate(load_scene(THREE.format(method=method))))
        places = [frame.arrays["position"] for frame in frames]
        gap = [1e3 * (float(np.hypot(*(place[1] - place[0]))) - 2.7e-3) for place in places]
        axes.plot([frame.time for frame in frames], gap, color=color, label=method)
    axes.set(xlabel="time (s)", ylabel="gap of three discs (mm)", ylim=(0.0, None))
    axes.legend(fontsize=8)


THREE = """
model = "floating"
duration = "1.2 s"
frame_every = "0.02 s"
[liquid]
viscosity = "5 mPa*s"
[[particles]]
radius = "1.35 mm"
density = 300.0
disc = {{ thickness = "0.5 mm" }}
placement = "ring"
ring_radius = "3 mm"
count = 3
[interaction]
method = "{method}"
"""


def rifts() -> Figure:
    """The length of clusters in a raft that is pulled, over the pulling rate."""
    found, labels = rift_study.recorded(), {"none": "drag of single beads", "rotne-prager": "hydrodynamic interaction"}
    with style():
        drawn = figure(5.6, 3.9)
        axes = drawn.subplots()
        rates = np.array(rift_study.RATES)
        for (name, label), color, marker in zip(labels.items(), (PALETTE[1], PALETTE[0]), "os", strict=True):
            lengths = np.array([found[name][rate] for rate in rift_study.RATES])
            axes.errorbar(
                rates, lengths.mean(axis=1), lengths.std(axis=1, ddof=1), fmt=marker, markersize=5, capsize=3,
                color=color, label=label,
            )  # fmt: skip
        middle = float(np.mean([found["none"][0.3]]))
        axes.plot(
            rates, np.clip(middle * 0.3 / rates, 1.0, None), color=INK, linewidth=1.0, label="inverse to the rate"
        )
        axes.set(
            xscale="log", yscale="log", xlabel="pulling rate / closing rate of a pair",
            ylabel="cluster length (diameters)",
        )  # fmt: skip
        axes.legend()
    return drawn


FIGURES: dict[str, Callable[[], Figure]] = {
    "beyond-superposition": beyond_superposition,
    "levels": levels,
    "rifts": rifts,
}
