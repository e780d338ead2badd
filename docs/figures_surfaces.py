"""The figures of liquids with a free surface: tanks at rest, dam breaks and waves.

They come from the scenes and gauges of `ecume validate`; together they take some minutes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from figures_sph import liquid, scale_to
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ecume.laws.water_waves import viscous_decay
from ecume.show.style import INK, PALETTE, figure
from ecume.simulation import simulate
from ecume_validation import dam_break as dam
from ecume_validation import standing_wave as wave
from ecume_validation.reproduced import draw_front, draw_levels
from ecume_validation.runner import case_scene

WALLS = {
    "mirrors": (),
    "dummies": ("tank.walls=dummy",),
    "no diffusion": ("method.density_diffusion=none",),
    "reflection only": ("tank.walls=reflect", "tank.restitution=1.0"),
}
SHORT = ("spacing=0.05", "duration=35.0", "frame_every=5.0")


def tanks() -> Figure:
    """A tank after ten thousand steps, with walls that hold it and with walls that do not."""
    drawn, scale = figure(10.0, 3.6), scale_to(1.0)
    axes = drawn.subplots(1, 3)
    scenes = {name: case_scene("tank", (*SHORT, *changes)) for name, changes in WALLS.items()}
    lasts = {name: list(simulate(scene))[-1] for name, scene in scenes.items()}
    for axis, name in zip(axes, ("mirrors", "reflection only"), strict=False):
        axis.set(xlim=(0, 1), ylim=(0, 1.1), title=name.capitalize())
        liquid(axis, scenes[name], lasts[name], lasts[name].arrays["pressure"], scale)
    drawn.colorbar(scale, ax=axes[1], label="pressure / ρ g H")
    for (name, last), color in zip(lasts.items(), PALETTE, strict=False):
        axes[2].plot(last.arrays["pressure"], last.arrays["position"][:, 1], ".", color=color, markersize=4, label=name)
    axes[2].plot([1.0, 0.0], [0.0, 1.0], color=INK, linewidth=0.9, label="ρ₀ g (H − y)")
    axes[2].set(xlabel="pressure / ρ g H", ylabel="height / H", xlim=(-0.3, 1.9), ylim=(0, 1.1))
    axes[2].legend()
    return drawn


def dam_break() -> Figure:
    """A dam break: the liquid at four times, its front, levels and wall pressures beside published ones."""
    drawn = figure(10.0, 8.6)
    grid = drawn.add_gridspec(4, 2, height_ratios=[1, 1, 1, 1.8])
    scene = case_scene("dam_break")
    frames = list(simulate(scene))
    for place, time in enumerate((0.5, 1.5, 2.5, 3.0, 4.0, 5.0)):
        axis = drawn.add_subplot(grid[place // 2, place % 2])
        frame = min(frames, key=lambda frame: abs(frame.time - time))
        axis.set(xlim=(0, dam.FAR_WALL), ylim=(0, 1.6), title=f"t √(g/H) = {time:g}")
        liquid(axis, scene, frame, frame.arrays["pressure"], scale_to(1.0))
    run = dam.gauged(frames, dam.FAR_WALL, 0.1)
    draw_front(drawn.add_subplot(grid[3, 0]), run)
    draw_levels(drawn.add_subplot(grid[3, 1]), run)
    return drawn


def standing_wave() -> Figure:
    """Waves at Re = 50 and 500 beside the exact ones: resolutions, forms of the viscosity, completed gradients."""
    drawn = figure(10.0, 3.6)
    left, right = drawn.subplots(1, 2)
    runs: dict[str, tuple[int, tuple[str, ...], Any]] = {
        "16 deep": (16, (), ":"),
        "32 deep": (32, (), "-"),
        "32 deep, morris": (32, ("method.viscosity_model=morris",), "--"),
    }
    _waves(left, 50.0, runs)
    _waves(right, 500.0, {"16 deep": (16, (), ":"), "16 deep, corrected": (16, wave.CORRECTED, "--")})
    return drawn


def _waves(axis: Axes, reynolds: float, runs: dict[str, tuple[int, tuple[str, ...], Any]]) -> None:
    exact, speed = viscous_decay(math.pi, 1.0, 1.0, 1.0 / reynolds), 0.05
    for (name, (deep, changes, dashes)), color in zip(runs.items(), PALETTE, strict=False):
        times, heights = wave.heights(reynolds, deep, changes)
        axis.plot(times, heights, dashes, color=color, label=name)
    times = np.linspace(0.0, 12.0, 400)
    decayed = speed / exact.frequency * np.exp(-exact.rate * times) * np.sin(exact.frequency * times)
    axis.plot(times, decayed, color=INK, linewidth=0.9, label="exact")
    axis.set(xlabel="time √(g/H)", ylabel="wave height / H", title=f"Re = {reynolds:g}")
    axis.set_ylim(top=0.042)
    axis.legend(loc="upper right", ncols=2)


FIGURES: dict[str, Callable[[], Figure]] = {
    "sph-tanks": tanks,
    "sph-dam-break": dam_break,
    "sph-standing-wave": standing_wave,
}
