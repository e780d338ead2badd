"""The figure of floats that release surfactant; `docs/figures.py` draws it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from ecume._quick import sized
from ecume.laws import camphor
from ecume.models import MODELS
from ecume.models.floating.forces.surfactant import Surfactant, centers_of, tension_forces
from ecume.models.floating.parameters import part_of
from ecume.scenes.load import load_scene
from ecume.scenes.templates import folder
from ecume.show.style import INK, MUTED, PALETTE, figure, style
from ecume.simulation import moments

DISC = """model = "floating"
duration = 10.0
frame_every = 0.05
[liquid]
name = "water"
[cell]
size = [0.06, 0.03]
[surfactant]
diffusivity = 1e-4
tension_slope = 10.0
loss_rate = 20.0
spacing = 3.75e-4
[[surfactant.sources]]
release = 4e-7
[[particles]]
radius = 1.5e-3
density = 980.0
contact_angle = "90 deg"
positions = [[0.03, 0.015]]
[interaction]
law = "none"
[hydrodynamics]
drag = "stokes"
[integration]
time_step = 2.5e-4
"""
SPEEDS = np.array(sized((0.05, 0.1, 0.2, 0.3, 0.4, 0.5), (0.2,)))
SETTLED = 0.2
"""s: until the force on a disc in uniform motion is steady."""


def surfactant() -> Figure:
    """Propulsion and drag against speed, and the surface around camphor boats."""
    with style():
        drawn = figure(9.6, 4.0)
        left, right = drawn.subplots(1, 2)
        _propulsion(left)
        _boats(drawn, right)
    return drawn


def _propulsion(axes: Axes) -> None:
    scene = load_scene(DISC)
    floats = MODELS["floating"].parameters(scene).floats
    friction, speed = float(floats.mass[0] / floats.relaxation_time[0]), np.linspace(1e-3, 0.6, 120)
    law = [camphor.propulsion(v, 1.5e-3, 4e-6, 1e-4, 20.0) for v in speed.tolist()]
    axes.plot(100.0 * speed, 1e6 * np.array(law), color=PALETTE[0], label="propulsion, closed form")
    axes.plot(100.0 * speed, 1e6 * friction * speed, color=PALETTE[1], label="drag")
    found = [_force_at(scene, v) for v in SPEEDS.tolist()]
    axes.plot(100.0 * SPEEDS, 1e6 * np.array(found), "o", color=INK, markersize=4, label="propulsion on the grid")
    axes.set(xlabel="speed (cm/s)", ylabel="force (µN)", xlim=(0, 60), ylim=(0, None))
    axes.legend(fontsize=8)


def _force_at(scene: Any, speed: float) -> float:
    """The force of the surfactant on a disc that is held at a speed along x (N)."""
    model = MODELS["floating"]
    parameters = model.parameters(scene)
    state = model.start(scene, parameters)
    workspace = model.workspace(parameters, state, 1.0)
    for step in range(round(SETTLED / parameters.time_step)):
        state.position[0] = 0.03 + speed * step * parameters.time_step, 0.015
        state.velocity[0] = speed, 0.0
        model.advance(parameters, state, workspace, 1)
    state.position[0, 0] = 0.03 + speed * (step + 1) * parameters.time_step
    part = part_of(parameters, Surfactant)
    return float(tension_forces(part, state.concentration, state.position, parameters.floats.radius)[0, 0])


def _boats(drawn: Figure, axes: Axes) -> None:
    scene = load_scene(str(folder() / "camphor-boats.toml"))
    parameters = MODELS["floating"].parameters(scene)
    after = sized(3.0, 0.1)
    state = next(moment.state for moment in moments(scene, patience=0.0)
                 if int(moment.state.step[0]) * parameters.time_step >= after)  # fmt: skip
    part = part_of(parameters, Surfactant)
    fall = np.where(part.wet, 1e3 * part.slope * state.concentration, np.nan)
    x, y = centers_of(part)
    picture = axes.pcolormesh(1e3 * x, 1e3 * y, fall.T, cmap="Blues", rasterized=True)
    drawn.colorbar(picture, ax=axes, label="fall of the surface tension (mN/m)")
    for (px, py), radius, release in zip(state.position, parameters.floats.radius, part.release, strict=True):
        color = "white" if release > 0.0 else "tan"
        axes.add_patch(Circle((1e3 * px, 1e3 * py), 1e3 * radius, facecolor=color, edgecolor=INK, linewidth=0.6))
    axes.add_patch(Circle((0.0, 0.0), 40.0, fill=False, edgecolor=MUTED))
    axes.set(xlim=(-41, 41), ylim=(-41, 41), aspect="equal", xlabel="mm", ylabel="mm")


FIGURES: dict[str, Callable[[], Figure]] = {"surfactant": surfactant}
