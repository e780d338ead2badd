"""The figure of chains of rough floats; `docs/figures.py` draws it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from ecume._quick import sized
from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.show.style import INK, PALETTE, figure, style
from ecume.simulation import simulate
from ecume_validation.chains import RADIUS, bend_after, holding_coefficient

BENDS = sized((1.2, 1.5, 1.8, 2.1, 2.4, 2.7, 3.0), (2.1,))
FACTORS = (0.7, 0.9, 1.1, 1.3)
"""Coefficients of the simulated chains, over the threshold."""


def rolling_friction() -> Figure:
    """The threshold of chains of three spheres, and a chain of ten with and without rolling friction."""
    with style():
        drawn = figure(9.6, 3.6)
        left, right = drawn.subplots(1, 2)
        _threshold(left)
        _chains(right)
    return drawn


def _threshold(axes: Axes) -> None:
    bends = np.linspace(np.pi / 3.0, np.pi, 200)
    axes.plot(np.degrees(bends), [holding_coefficient(bend) for bend in bends.tolist()], color=PALETTE[0])
    for bend in BENDS:
        for factor in FACTORS:
            coefficient = factor * holding_coefficient(bend)
            holds = abs(bend_after(bend, coefficient) - bend) < 1e-5
            axes.plot(
                np.degrees(bend), coefficient, "o", color=INK, markersize=4.5, fillstyle="full" if holds else "none"
            )
    axes.set(
        xlabel="angle at the sphere in the middle (degrees)", ylabel="coefficient of rolling friction", ylim=(0, None)
    )


def _chains(axes: Axes) -> None:
    base = load_scene(str(folder() / "bent-chain.toml"), [f"duration='{sized(60.0, 0.5)} s'"])
    without = load_scene(
        str(folder() / "bent-chain.toml"), ["contacts.rolling_friction=0.0", f"duration='{sized(60.0, 0.5)} s'"]
    )
    for scene, low, color, label in ((base, 0.0, PALETTE[0], "with"), (without, -7.0, PALETTE[1], "without")):
        *_, last = simulate(scene)
        for x, y in 1e3 * last.arrays["position"]:
            axes.add_patch(Circle((x, y + low), 1e3 * RADIUS, facecolor=color, edgecolor=INK, linewidth=0.6))
        axes.text(-11.5, low + 2.2, f"{label} rolling friction", fontsize=8)
    axes.set(xlim=(-12, 12), ylim=(-10.5, 3.5), aspect="equal", xlabel="mm", ylabel="mm")
    axes.set_yticks([])


FIGURES: dict[str, Callable[[], Figure]] = {"rolling-friction": rolling_friction}
