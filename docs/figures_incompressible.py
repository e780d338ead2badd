"""The figures of incompressible tanks, compared with weakly compressible ones."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from figures_sph import liquid, scale_to, scene_of, simulated
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ecume.analysis.series import number, series, times
from ecume.show.style import INK, MUTED, PALETTE, figure

OPEN = {"kind": "open"}
COLUMN = {"low": [0.0, 0.0], "high": [2.0, 1.0]}
SENSOR = {"name": "sensor", "position": [5.366, 0.01], "quantities": ["pressure"]}
COLORS = {"tait": PALETTE[1], "incompressible": PALETTE[0]}
SPLASH = 2.8


def dam(pressure: str) -> dict[str, Any]:
    """A dam break with 20 particles in the height of the column, and a sensor in the far wall."""
    return {
        "duration": 3.6, "frame_every": 0.02, "spacing": 0.05, "gravity": [0.0, -1.0],
        "liquid": {"density": 1.0, "maximum_speed": 2.0}, "gauges": [SENSOR], "fluid": [COLUMN],
        "tank": {"low": [0.0, 0.0], "high": [5.366, 3.0], "top": OPEN}, "method": {"pressure": pressure},
    }  # fmt: skip


def still(pressure: str) -> dict[str, Any]:
    """A disordered tank at rest, 16 particles deep."""
    return {
        "duration": 4.0, "frame_every": 4.0, "spacing": 1.0 / 16.0, "gravity": [0.0, -1.0], "liquid": {"density": 1.0},
        "tank": {"low": [0.0, 0.0], "high": [1.0, 2.0], "top": OPEN},
        "fluid": [{"low": [0.0, 0.0], "high": [1.0, 1.0]}], "method": {"pressure": pressure, "jitter": 0.1},
    }  # fmt: skip


def incompressible() -> Figure:
    """A dam break by both methods: the liquid, the sensor, the number of steps; and the pressure of a tank at rest."""
    drawn = figure(11.0, 5.6)
    grid = drawn.add_gridspec(2, 3)
    runs = {name: simulated(dam(name)) for name in COLORS}
    left = grid[:, 0].subgridspec(2, 1)
    for place, (name, frames) in enumerate(runs.items()):
        axes = drawn.add_subplot(left[place])
        frame = frames[round(SPLASH / 0.02)]
        axes.set(xlim=(-0.05, 5.45), ylim=(-0.05, 2.2))
        liquid(axes, scene_of(dam(name)), frame, frame.arrays["pressure"], scale_to(1.5))
        axes.plot([0, 0, 5.366, 5.366], [2.2, 0, 0, 2.2], color=INK, linewidth=1.0)
        axes.set_title(f'pressure = "{name}", t = {SPLASH:g}')
    sensor, steps, rest = (drawn.add_subplot(place) for place in (grid[0, 1:], grid[1, 1], grid[1, 2]))
    for name, frames in runs.items():
        readings, counts = series(frames, number("sensor_pressure"), number("substeps"))
        sensor.plot(times(frames), readings, color=COLORS[name], label=name, linewidth=1.2)
        steps.plot(times(frames), counts, color=COLORS[name], label=name)
    sensor.set(xlabel="time / √(H/g)", ylabel="sensor / ρ g H", xlim=(2.0, 3.6), ylim=(-4.0, 10.0))
    sensor.legend()
    steps.set(xlabel="time / √(H/g)", ylabel="steps", yscale="log", ylim=(1.0, None))
    _at_rest(rest)
    return drawn


def _at_rest(axes: Axes) -> None:
    """The pressure minus the hydrostatic pressure."""
    for name, color in COLORS.items():
        last = simulated(still(name))[-1]
        height = last.arrays["position"][:, 1]
        axes.plot(last.arrays["pressure"] - (1.0 - height), height, ".", color=color, markersize=3.0)
    axes.axvline(0.0, color=MUTED, linewidth=0.8)
    axes.set(xlabel="(p − hydrostatic) / ρ g H", ylabel="height / H", xlim=(-0.06, 0.06), title="at rest")


FIGURES: dict[str, Callable[[], Figure]] = {"sph-incompressible": incompressible}
