"""The figure of two liquids in a tank; `docs/figures.py` draws it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from figures_sph import simulated
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ecume.show.style import INK, PALETTE, figure
from ecume.trajectories.frame import Frame

COLORS = {1: PALETTE[1], 2: PALETTE[2]}
PERIODIC = {"kind": "periodic"}
SPACING = 1.0 / 20.0


def layers(ratio: float, **more: Any) -> dict[str, Any]:
    """A light liquid on a dense one of the depth 1/2 each, in a full tank of the height 1."""
    wide = 6.0 * SPACING
    return {
        "duration": 0.5, "frame_every": 0.5, "spacing": SPACING, "gravity": [0.0, -1.0],
        "liquid": {"density": 1.0}, "second_liquid": {"density": 1.0 / ratio},
        "tank": {"high": [wide, 1.0], "left": PERIODIC, "right": PERIODIC},
        "fluid": [
            {"low": [0.0, 0.0], "high": [wide, 0.5]},
            {"low": [0.0, 0.5], "high": [wide, 1.0], "liquid": "second"},
        ],
        **more,
    }  # fmt: skip


def overturning() -> dict[str, Any]:
    """A liquid above one of a third of its density, with a wave in the interface."""
    x = np.linspace(0.0, 0.5, 41)
    lower = [
        [0.0, 0.0],
        [0.5, 0.0],
        *zip(x[::-1].tolist(), (0.5 + 0.05 * np.cos(4.0 * np.pi * x[::-1])).tolist(), strict=True),
    ]
    return layers(
        3.0, duration=2.4, frame_every=0.8,
        tank={"high": [0.5, 1.0], "left": PERIODIC, "right": PERIODIC},
        fluid=[{"vertices": lower, "liquid": "second"}, {"low": [0.0, 0.0], "high": [0.5, 1.0]}],
    )  # fmt: skip


def two_liquids() -> Figure:
    """The pressure in stacked liquids of two ratios of densities, and a dense liquid that sinks through a light one."""
    drawn = figure(9.0, 3.8)
    left, *others = drawn.subplots(1, 5, width_ratios=[3, 1, 1, 1, 1])
    for ratio, color in ((2.0, PALETTE[1]), (1000.0, PALETTE[2])):
        _pressure(left, simulated(layers(ratio))[-1], ratio, color)
    left.set(xlabel="pressure / ρ₁gH", ylabel="height / H", title="At rest after 0.5 √(H/g)")
    left.legend()
    for axes, frame in zip(others, simulated(overturning()), strict=True):
        for kind, color in COLORS.items():
            mine = frame.arrays["position"][frame.arrays["liquid"] == kind]
            axes.plot(*mine.T, "o", color=color, markersize=2.6, markeredgewidth=0.0)
        axes.set(title=f"{frame.time:.1f} √(H/g)", xlim=(0.0, 0.5), ylim=(0.0, 1.0), aspect="equal")
        axes.set_axis_off()
    return drawn


def _pressure(axes: Axes, frame: Frame, ratio: float, color: str) -> None:
    """The pressure of particles over their height, and the exact one."""
    axes.plot(frame.arrays["pressure"], frame.arrays["position"][:, 1], "o", color=color, label=f"ρ₁/ρ₂ = {ratio:g}")
    height = np.array([0.0, 0.5, 1.0])
    axes.plot([0.5 + 0.5 / ratio, 0.5 / ratio, 0.0], height, color=INK, linewidth=0.8)


FIGURES: dict[str, Callable[[], Figure]] = {"sph-two-liquids": two_liquids}
