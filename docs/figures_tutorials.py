"""The figures of the start page and the tutorials, from the scenes that these pages print."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ecume.analysis.free_surface import front_position
from ecume.laws.drag import stokes_friction
from ecume.scenes.load import load_scene
from ecume.show.floating.bowl import Bowl
from ecume.show.picture import Picture, Pixels, Size
from ecume.show.soft.figures import SOFT_FIGURES
from ecume.show.soft.packing import Packing
from ecume.show.sph.picture import liquid_picture
from ecume.show.style import INK, MUTED, PALETTE, figure
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame

PAGES = Path(__file__).parent
DPI = 120


@cache
def run_of(page: str, name: str) -> tuple[Any, list[Frame]]:
    """The scene that a page prints under a name, and its frames."""
    blocks = re.findall(r"^```toml\n(.*?)^```", (PAGES / page).read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    (text,) = (one for one in blocks if re.search(rf"# {re.escape(name)}$", one, re.MULTILINE))
    scene = load_scene(text)
    return scene, list(simulate(scene))


def beside(picture: Picture, frames: Sequence[Frame]) -> Figure:
    """The same picture at several instants; only the last has the legend on its right."""
    shown = [picture.pixels(frame).copy() for frame in frames]
    edge = math.ceil((picture.figure.axes[0].get_position().x1 + 0.015) * shown[0].shape[1])
    return pasted(np.hstack([*(one[:, :edge] for one in shown[:-1]), shown[-1]]))


def below(picture: Picture, frames: Sequence[Frame]) -> Figure:
    """The same picture at several instants, one below the other."""
    return pasted(np.vstack([picture.pixels(frame).copy() for frame in frames]))


def pasted(pixels: Pixels) -> Figure:
    """A figure of these pixels."""
    drawn = Figure(figsize=(pixels.shape[1] / DPI, pixels.shape[0] / DPI), dpi=DPI)
    drawn.figimage(pixels)
    return drawn


def at(frames: Sequence[Frame], time: float) -> Frame:
    """The frame nearest to a time."""
    return min(frames, key=lambda frame: abs(frame.time - time))


def my_bowl() -> Figure:
    """The bowl of the start page at the beginning and after ten seconds."""
    scene, frames = run_of("start.md", "mine.toml")
    return beside(Bowl(scene, frames[::20], Size(560, 440)), [frames[0], frames[-1]])


def two_beads() -> Figure:
    """Two beads before and after they meet, and their gap over time."""
    scene, frames = run_of("tutorials/floating.md", "two-beads.toml")
    gap = [1e3 * (float(np.linalg.norm(np.subtract(*frame.arrays["position"]))) - 2e-3) for frame in frames]
    drawn = figure(6.4, 3.2)
    axes = drawn.add_subplot(xlabel="time (s)", ylabel="gap (mm)", ylim=(-0.1, 4.2), xlim=(0, scene.duration))
    axes.plot([frame.time for frame in frames], gap, color=PALETTE[1])
    met = next((frame.time for frame, apart in zip(frames, gap, strict=True) if apart < 1e-3), scene.duration)
    axes.axvline(met, color=MUTED, linestyle=":")
    axes.text(met + 0.03, 3.6, f"contact at {met:.2f} s", color=INK)
    return drawn


def raft() -> Figure:
    """Twelve beads at the start, on their way and at the end."""
    scene, frames = run_of("tutorials/floating.md", "raft.toml")
    return beside(Bowl(scene, frames[::5], Size(500, 410)), [frames[0], at(frames, 0.4), frames[-1]])


def rest() -> Figure:
    """The tank at rest, and the pressure of its particles beside the hydrostatic one."""
    _, frames = run_of("tutorials/sph.md", "rest.toml")
    last = frames[-1].arrays
    drawn = figure(6.4, 3.2)
    axes = drawn.add_subplot(xlabel="pressure (kPa)", ylabel="height (cm)", ylim=(0, 31), xlim=(0, 3.2))
    axes.plot(1e-3 * last["pressure"], 100.0 * last["position"][:, 1], ".", color=PALETTE[1], label="particles")
    axes.plot([9.81 * 0.3, 0.0], [0.0, 30.0], color=INK, linewidth=0.9, label="ρ g (H − y)")
    axes.legend()
    return drawn


def dam() -> Figure:
    """The small dam break at three instants."""
    scene, frames = run_of("tutorials/sph.md", "dam.toml")
    return below(liquid_picture(scene, frames, Size(760, 420, trim=True)), [frames[0], at(frames, 0.15), frames[-1]])


def dam_front() -> Figure:
    """The front of the small dam break over time."""
    scene, frames = run_of("tutorials/sph.md", "dam.toml")
    time = np.array([frame.time for frame in frames])
    drawn = figure(6.4, 3.0)
    axes = drawn.add_subplot(xlabel="time (s)", ylabel="front (cm)", xlim=(0, scene.duration))
    front = [100.0 * front_position(frame, scene.spacing) for frame in frames]
    axes.plot(time, front, "o-", markersize=3, color=PALETTE[1], label="ecume")
    shallow = 2.0 * math.sqrt(9.81 * 0.2)
    axes.plot(time, 20.0 + 100.0 * shallow * time, "--", color=MUTED, label="shallow water, no friction")
    axes.legend()
    return drawn


def film() -> Figure:
    """The gap of the film between two spheres that are pulled apart."""
    scene, frames = run_of("tutorials/soft.md", "two.toml")
    drawn = figure(6.4, 3.0)
    axes = drawn.add_subplot(xlabel="time (s)", ylabel="gap (µm)", yscale="log", xlim=(0, scene.duration))
    axes.plot(
        [frame.time for frame in frames], [1e6 * frame.numbers["smallest_gap"] for frame in frames], color=PALETTE[1]
    )
    return drawn


def shear() -> Figure:
    """The small packing before the shear and at a strain of 0.1."""
    scene, frames = run_of("tutorials/soft.md", "shear.toml")
    return beside(Packing(scene, frames, Size(620, 500)), [frames[1], frames[-1]])


def flow_curve() -> Figure:
    """The flow curve of the small packing: six rates in one run."""
    scene, frames = run_of("tutorials/soft.md", "flow.toml")
    return SOFT_FIGURES["flow-curve"](frames, scene)


def grain() -> Figure:
    """The height of the settling grain, beside Stokes's law."""
    _, frames = run_of("tutorials/tracers.md", "grain.toml")
    time = np.array([frame.time for frame in frames])
    height = [1e3 * float(frame.arrays["position"][0, 1]) for frame in frames]
    weight = 4.0 / 3.0 * math.pi * 20e-6**3 * (2650.0 - 998.2) * 9.81
    stokes = 1e3 * weight / stokes_friction(20e-6, 1.0016e-3, 1.0)
    drawn = figure(6.4, 3.0)
    axes = drawn.add_subplot(xlabel="time (s)", ylabel="height (mm)", xlim=(0, time[-1]))
    axes.plot(time, height, "o", markersize=4, color=PALETTE[1], label="ecume")
    axes.plot(time, height[0] - stokes * time, "--", color=INK, linewidth=1.0, label="Stokes")
    axes.legend()
    return drawn


def ball() -> Figure:
    """The height of the bouncing ball, and the heights that the restitution gives."""
    _, frames = run_of("tutorials/tracers.md", "ball.toml")
    time = np.array([frame.time for frame in frames])
    height = [100.0 * (float(frame.arrays["position"][0, 1]) - 0.01) for frame in frames]
    drawn = figure(6.4, 3.0)
    axes = drawn.add_subplot(
        xlabel="time (s)", ylabel="height of the lowest point (cm)", xlim=(0, time[-1]), ylim=(0, 33)
    )
    axes.plot(time, height, color=PALETTE[1])
    for bounce in (1, 2):
        top = height[0] * 0.8 ** (2 * bounce)
        axes.axhline(top, color=MUTED, linestyle=":", linewidth=1.0)
        axes.text(time[-1], top + 0.4, f"{height[0]:.0f} cm · 0.8$^{2 * bounce}$", ha="right", color=INK)
    return drawn


FIGURES: dict[str, Callable[[], Figure]] = {
    "tutorial-bowl": my_bowl,
    "tutorial-two-beads": two_beads,
    "tutorial-raft": raft,
    "tutorial-rest": rest,
    "tutorial-dam": dam,
    "tutorial-dam-front": dam_front,
    "tutorial-film": film,
    "tutorial-shear": shear,
    "tutorial-flow-curve": flow_curve,
    "tutorial-grain": grain,
    "tutorial-ball": ball,
}
