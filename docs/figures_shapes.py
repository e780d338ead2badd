"""The figures of floats with a shape; `docs/figures.py` draws them."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from ecume.engine.outlines import ellipses_near
from ecume.laws import contact_lines
from ecume.laws.contact_lines import Line
from ecume.scenes.load import load_scene
from ecume.show.floating.bowl import Bowl
from ecume.show.picture import Size
from ecume.show.style import MUTED, PALETTE, figure, style
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume_validation.float_forces import energy, placed

TEMPLATES = Path(__file__).parents[1] / "src" / "ecume" / "templates"
SMALL = 1e-3
"""Long semi-axis over the capillary length."""
TIPS, FLANKS = (0.0, 0.0), (0.5 * math.pi, 0.5 * math.pi)


def shapes() -> Figure:
    """Two ellipses over the law of quadrupoles, and the energy of two that touch, mirror images, as they lean."""
    with style():
        drawn = figure(9.6, 3.8)
        left, right = drawn.subplots(1, 2)
        for slender, color in ((0.6, PALETTE[1]), (0.25, PALETTE[0])):
            for angles, name, look in ((TIPS, "tips", "-"), (FLANKS, "flanks", "--")):
                near = touching(slender, angles)
                apart = SMALL * np.geomspace(near * 1.001, 12.0, 60)
                ratios = [_over_law(slender, angles, float(one)) for one in apart]
                left.plot(apart / SMALL, ratios, look, color=color, label=f"b = {slender:g} a, {name}")
            leans = np.linspace(0.0, 0.5 * math.pi, 46)
            energies = np.array([_touching_energy(slender, float(lean)) for lean in leans])
            right.plot(np.degrees(leans), energies / -energies[0], color=color, label=f"b = {slender:g} a")
        left.axhline(1.0, color=MUTED, linewidth=0.8)
        left.set(xscale="log", xlabel="distance of the centers / a", ylabel="energy / quadrupole law", ylim=(0.0, 3.0))
        left.set_xticks([0.5, 1, 2, 4, 8], ["0.5", "1", "2", "4", "8"])
        left.minorticks_off()
        left.legend(fontsize=8)
        right.set(xlabel="tilt of mirror images (degrees)", ylabel="contact energy / that of tips")
        right.set_xticks([0, 30, 60, 90], ["0\ntip to tip", "30", "60", "90\nflank to flank"])
        right.legend(fontsize=8)
    return drawn


def touching(slender: float, angles: tuple[float, float]) -> float:
    """The distance of the centers of two touching ellipses, over a: by halving."""
    near, far = 0.0, 2.2
    for _ in range(40):
        middle = 0.5 * (near + far)
        gap = ellipses_near(middle, 0.0, (1.0, slender, angles[0]), (1.0, slender, angles[1]), 10.0)[0]
        near, far = (near, middle) if gap > 0.0 else (middle, far)
    return far


def _energy(slender: float, angles: tuple[float, float], apart: float) -> float:
    line = Line(SMALL, slender * SMALL, 0.0, 2, 0.01 * SMALL)
    return energy(placed(line, angles[0], 0.0), placed(line, angles[1], apart))


def _over_law(slender: float, angles: tuple[float, float], apart: float) -> float:
    moment = 0.01 * SMALL * (0.5 * SMALL * (1.0 + slender)) ** 2
    strength = contact_lines.quadrupole_strength(1.0, moment, moment)
    return _energy(slender, angles, apart) / contact_lines.quadrupole_energy(apart, sum(angles), strength)


def _touching_energy(slender: float, lean: float) -> float:
    angles = lean, -lean
    return _energy(slender, angles, SMALL * touching(slender, angles))


@cache
def _run(name: str, *changes: str) -> tuple[object, list[Frame]]:
    scene = load_scene(TEMPLATES / f"{name}.toml", list(changes))
    return scene, list(simulate(scene))


def in_motion() -> Figure:
    """Three frames each of parallel ellipsoids, of mirror images, and of needles."""
    rows = (
        (_run("ellipsoids"), (0, 50, 100)),
        (
            _run("ellipsoids", "particles[1].shape.angle='-20 deg'", "duration=1.6", "title='Mirror images roll'"),
            (0, 55, 160),
        ),
        (_run("needle"), (0, 24, 100)),
    )
    size = Size(384, 288)
    pictures = []
    for (scene, frames), shown in rows:
        picture = Bowl(scene, [frames[k] for k in shown], size)
        pictures.append(np.concatenate([picture.pixels(frames[k]).copy() for k in shown], axis=1))
    whole = np.concatenate(pictures, axis=0)
    drawn = Figure(figsize=(whole.shape[1] / 120, whole.shape[0] / 120), layout="none")
    drawn.add_axes((0.0, 0.0, 1.0, 1.0), frameon=False, xticks=[], yticks=[]).imshow(whole)
    return drawn


FIGURES: dict[str, Callable[[], Figure]] = {"shapes": shapes, "shapes-in-motion": in_motion}
