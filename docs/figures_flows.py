"""The figures of confined flows and drops in liquids made of particles; `docs/figures.py` draws them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ecume.laws.yield_stress import channel_speed
from ecume.scenes.schema import from_plain
from ecume.show.style import INK, MUTED, PALETTE, figure
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume_validation import drops, full_tanks
from ecume_validation.reproduced import draw_midlines
from ecume_validation.runner import case_scene, read_table

TAUS = (0.0225, 0.045, 0.1125, 0.225, 0.5)


def confined() -> Figure:
    """Vortices that fade, beside another package; channels that start; the lines of a square driven by its lid."""
    drawn = figure(11.0, 3.4)
    left, middle, right = drawn.subplots(1, 3)
    _errors(left)
    _profiles(middle)
    draw_midlines(right)
    return drawn


def _errors(axes: Axes) -> None:
    for side, color in zip((25, 50), (PALETTE[1], PALETTE[0]), strict=True):
        found = full_tanks.vortex_course(side)
        axes.plot(found.time[1:], found.error[1:], color=color, label=f"{side} per side")
    cases = read_table("taylor_green")
    for scheme, marker in (("EDAC", "s"), ("TVF", "^")):
        points = np.array([[float(case["time"]), float(case["error"])] for case in cases if case["scheme"] == scheme])
        axes.plot(*points.T, marker, color=MUTED, markersize=5, label=f"PySPH, {scheme}, 50")
    axes.set(xlabel="time U/L", ylabel="mean error of the velocity", xlim=(0, 2.05), ylim=(0, 0.08))
    axes.set_title("Taylor–Green vortices, Re = 100")
    axes.legend()


def _profiles(axes: Axes) -> None:
    scene = case_scene("poiseuille", [full_tanks.DRIVEN["poiseuille"], f"spacing={1.0 / 15!r}"])
    height = np.linspace(0.0, 1.0, 101)
    frames = list(simulate(scene))
    for tau in TAUS:
        frame = min(frames, key=lambda one: abs(one.time * full_tanks.CHANNEL_VISCOSITY - tau))  # called at once
        axes.plot([full_tanks.exact("poiseuille", y, frame.time) for y in height], height, color=INK, linewidth=1.0)
        axes.plot(frame.arrays["velocity"][:, 0], frame.arrays["position"][:, 1], ".", color=PALETTE[0], markersize=4)
    axes.set(xlabel="speed", ylabel="height", xlim=(0, 1.05), ylim=(0, 1))
    axes.set_title("Starting channel flow, 15 across")


def free() -> Figure:
    """A spinning square with and without shifting; a drop that swings."""
    drawn = figure(11.0, 3.4)
    left, middle, right = drawn.subplots(1, 3)
    for axes, shifting in ((left, "none"), (middle, "delta-plus")):
        shown = _square(axes, full_tanks.patch_course(0.025, f"method.shifting={shifting}")[-1])
        axes.set_title(f'shifting = "{shifting}"')
    drawn.colorbar(shown, ax=middle, label="pressure / ρ ω² L²")
    _swing(right)
    return drawn


def _square(axes: Axes, frame: Frame) -> object:
    pressure = frame.arrays["pressure"] / 1000.0
    shown = axes.scatter(*frame.arrays["position"].T, c=pressure, s=2.0, vmin=-0.1, vmax=0.02, cmap="viridis")
    axes.set(aspect="equal", xlim=(-1.0, 1.0), ylim=(-1.0, 1.0), xlabel="x / L", ylabel="y / L")
    return shown


def _swing(axes: Axes) -> None:
    frames = list(simulate(case_scene("drops", [*drops.SWINGING, f"frame_every={drops.PERIOD / 32!r}"])))
    time = np.array([frame.time for frame in frames])
    size = np.array([drops.axes(frame) for frame in frames]) / drops.axes(frames[0])
    for number, name in enumerate(("width", "height")):
        axes.plot(time, size[:, number], ".", color=PALETTE[number], markersize=5, label=name)
    axes.plot(*_ellipse(drops.PERIOD), color=INK, linewidth=1.0)
    axes.set(xlabel="time ω", ylabel="semi-axis / R", xlim=(0, math.ceil(drops.PERIOD)))
    axes.set_title("Oscillating drop, 20 per radius")
    axes.legend()


def _ellipse(duration: float) -> tuple[np.ndarray, np.ndarray]:
    """Times, and both axes there."""
    from scipy.integrate import solve_ivp

    from ecume.laws.drops import drop_strain_change

    def rate(_: float, y: np.ndarray) -> list[float]:
        return [drop_strain_change(y[0], 1.0, y[1], y[2]), y[0] * y[1], -y[0] * y[2]]

    found = solve_ivp(
        rate, (0.0, duration), [0.5, 1.0, 1.0], "DOP853", t_eval=np.linspace(0.0, duration, 200), rtol=1e-9
    )
    return found.t, found.y[1:].T


PULL, HALF = 1000.0, 0.01
LIQUIDS = {
    "Newton": {"consistency": 4.0, "exponent": 1.0, "yield_stress": 0.0},
    "power law, n = 0.5": {"consistency": 4.0, "exponent": 0.5, "yield_stress": 0.0},
    "Bingham": {"consistency": 1.0, "exponent": 1.0, "yield_stress": 4.0},
    "Herschel and Bulkley, n = 0.6": {"consistency": 2.0, "exponent": 0.6, "yield_stress": 3.0},
}


def yielding() -> Figure:
    """Liquids that thin or yield in a channel, beside their exact profiles."""
    drawn = figure(6.0, 3.6)
    axes = drawn.subplots()
    height = np.linspace(-HALF, HALF, 201)
    for (name, liquid), color in zip(LIQUIDS.items(), PALETTE, strict=False):
        *_, last = simulate(from_plain(_channel(liquid)))
        y, speed = last.arrays["position"][:, 1] - HALF, last.arrays["velocity"][:, 0]
        axes.plot([1e3 * channel_speed(each, HALF, PULL, **liquid) for each in height], 1e3 * height, color=color)
        axes.plot(1e3 * speed, 1e3 * y, ".", color=color, markersize=4, label=name)
    axes.set(xlabel="speed (mm/s)", ylabel="height (mm)", ylim=(-1e3 * HALF, 1e3 * HALF))
    axes.set_xlim(0.0)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, markerscale=2.0)
    return drawn


def _channel(liquid: dict[str, float]) -> dict[str, Any]:
    around = {"low": [0.0, 0.0], "high": [1.2 * HALF, 2.0 * HALF]}
    ends = {side: {"kind": "periodic"} for side in ("left", "right")}
    return {
        "model": "sph", "duration": 0.3, "frame_every": 0.3, "spacing": 0.1 * HALF, "gravity": [PULL / 1000.0, 0.0],
        "tank": {**around, **ends}, "fluid": [around],
        "liquid": {"maximum_speed": 0.04, "rheology": {**liquid, "largest_viscosity": 20.0}},
    }  # fmt: skip


FIGURES: dict[str, Callable[[], Figure]] = {
    "sph-confined": confined,
    "sph-free": free,
    "sph-yield-stress": yielding,
}
