"""The figures of tracers and of walls that reflect; `python docs/figures.py NAME` draws them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from ecume.engine import walls
from ecume.laws import brownian_motion, drag
from ecume.scenes.tracers import ParticleSpec, TankSpec, TracerHydrodynamicsSpec, TracersScene
from ecume.show.style import INK, MUTED, PALETTE, RIM, figure, legend_outside
from ecume.simulation import simulate

LIQUID = "#eef5fa"


def _tank(axes: Axes, corners: list[tuple[float, float]], title: str) -> None:
    axes.add_patch(Polygon(corners, facecolor=LIQUID, edgecolor=RIM, linewidth=1.6))
    axes.set(aspect="equal", title=title)
    axes.set_axis_off()


def corner_path() -> Figure:
    """Four hits in one step, in a rectangle and in a wedge."""
    drawn = figure(6.4, 2.9)
    left, right = drawn.subplots(1, 2)
    _tank(left, [(0, 0), (1, 0), (1, 0.7), (0, 0.7)], "Four collisions in one step")
    _path(left, walls.box((0, 0), (1, 0.7)), (0.55, 0.5), (1.9, 1.15))
    angle = math.radians(40)
    wedge = walls.wedge((0, 0), (math.cos(angle / 2), math.sin(angle / 2)), angle)
    _tank(right, [(0, 0), (1.1, 0), (1.1 * math.cos(angle), 1.1 * math.sin(angle))], "Reflection in a wedge")
    _path(right, wedge, (0.85, 0.3), (-1.75, 0.02))
    return drawn


def _path(axes: Axes, tank: walls.Surfaces, start: tuple[float, float], way: tuple[float, float]) -> None:
    traced = walls.trace([start], [way], 1.0, tank)
    points = np.vstack([start, traced.place, traced.position])
    axes.plot(points[:, 0], points[:, 1], color=PALETTE[1])
    axes.plot(*start, "o", color=INK)
    axes.plot(*traced.position[0], "o", markerfacecolor="white", color=INK)
    axes.plot(traced.place[:, 0], traced.place[:, 1], "s", color=PALETTE[0], markersize=5)
    middle = np.mean(axes.patches[0].get_xy(), axis=0)
    for number, place in enumerate(traced.place, 1):
        out = 11.0 * (place - middle) / math.hypot(*(place - middle))
        axes.annotate(f"{number}", place, out, textcoords="offset points", fontsize=7.5, ha="center", va="center")


def two_at_most() -> Figure:
    """What a step of at most two collisions, as in the original text, does to particles in a box."""
    dice = np.random.default_rng(4)
    start, angle = dice.uniform(0, 1, (3000, 2)), dice.uniform(0, 2 * math.pi, 3000)
    way = dice.uniform(0, 3, 3000)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    box = walls.box((0, 0), (1, 1))
    traced = walls.trace(start, way, 1.0, box)
    ends, first = np.array(traced.position), np.concatenate([[0], np.cumsum(traced.hits)])
    for i in np.flatnonzero(traced.hits > 2):
        # After the second hit the rest of the path is flown straight through whatever comes.
        second, third = first[i] + 1, first[i] + 2
        course = traced.place[third] - traced.place[second]
        took = traced.time[third] - traced.time[second]
        ends[i] = traced.place[second] + course * (1.0 - traced.time[second]) / took
    drawn = figure(6.4, 3.1)
    titles = ("At most two reflections per step", "All reflections")
    for axes, places, title in zip(drawn.subplots(1, 2), (ends, traced.position), titles, strict=True):
        _tank(axes, [(0, 0), (1, 0), (1, 1), (0, 1)], title)
        out = ((places < 0) | (places > 1)).any(axis=1)
        for chosen, color in ((~out, PALETTE[1]), (out, PALETTE[0])):
            axes.plot(places[chosen, 0], places[chosen, 1], ".", color=color, markersize=1.6)
        axes.set(xlim=(-1.6, 2.6), ylim=(-1.6, 2.6))
        told = f"{100 * out.mean():.1f} % outside"
        axes.text(0.5, 0.0, told, ha="center", va="top", color=MUTED, transform=axes.transAxes)
    return drawn


def settling_profile() -> Figure:
    """Grains that sink and diffuse, at three times, beside the equilibrium."""
    radius, thermal = 0.5e-6, brownian_motion.thermal_energy(293.15)
    layer = brownian_motion.sedimentation_length(thermal, 4 / 3 * math.pi * radius**3 * 100.0 * 9.81)
    tall = 4.0 * layer
    spread = brownian_motion.diffusivity(thermal, drag.stokes_friction(radius, 1e-3, 1.0))
    unit = layer * layer / spread
    scene = TracersScene(
        duration=16 * unit,
        frame_every=unit,
        particles=(ParticleSpec(radius=radius, density=1100.0, count=10_000),),
        tank=TankSpec(high=(tall, tall + 2 * radius)),
        hydrodynamics=TracerHydrodynamicsSpec(brownian=True),
    )
    frames = list(simulate(scene))
    drawn = figure(6.0, 3.4)
    axes = drawn.add_subplot(xlabel="concentration / mean", ylabel="height / (kT/W)")
    edges = np.linspace(0.0, 4.0, 25)
    for index, color in zip((0, 1, 3, 16), PALETTE, strict=False):
        height = (frames[index].arrays["position"][:, 1] - radius) / layer
        counts = np.histogram(height, edges)[0] / len(height) * 24
        axes.stairs(
            counts, edges, orientation="horizontal", color=color, label=f"{float(f'{frames[index].time:.2g}'):g} s"
        )
    y = np.linspace(0.0, 4.0, 200)
    axes.plot(4.0 * np.exp(-y) / -math.expm1(-4.0), y, "--", color=INK, linewidth=1.0, label="exp(-y W/kT)")
    legend_outside(axes)
    return drawn


def terminal_speed() -> Figure:
    """Terminal speeds of quartz in water over the size."""
    diameter = np.logspace(-6, -2.5, 120)
    slow = np.array([drag.stokes_settling_speed(d / 2, 1500.0, 1e-3, 9.81) for d in diameter])
    reynolds = np.array([drag.particle_reynolds(v, d / 2, 1000.0, 1e-3) for v, d in zip(slow, diameter, strict=True)])
    real = slow * np.array([drag.settling_reynolds(r) / r for r in reynolds])
    drawn = figure(6.0, 3.2)
    axes = drawn.add_subplot(xlabel="diameter (µm)", ylabel="terminal speed (mm/s)", xscale="log", yscale="log")
    axes.plot(1e6 * diameter, 1e3 * slow, "--", color=MUTED, label="Stokes")
    axes.plot(1e6 * diameter, 1e3 * real, color=PALETTE[1], label="Schiller and Naumann")
    legend_outside(axes)
    return drawn


FIGURES: dict[str, Callable[[], Figure]] = {
    "corner-path": corner_path,
    "two-at-most": two_at_most,
    "settling-profile": settling_profile,
    "terminal-speed": terminal_speed,
}
