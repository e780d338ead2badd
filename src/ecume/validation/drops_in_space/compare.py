"""Balls of liquid that swing and fade, beside the exact roots for a drop without air, and the pressure inside."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ecume.laws.drops import drop_decay
from ecume.laws.tension import laplace_pressure
from ecume.scenes.load import load_scene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.validation.rows import Row, above, below, within
from ecume.validation.swings import longest_rise, swing_of

SCENE = Path(__file__).with_name("scene.toml")
VISCOSITY = 0.03
COUNTS = (4, 6)
"""Spacings in a radius."""


def rows() -> list[Row]:
    """At two resolutions, and how much better the finer one is."""
    exact = drop_decay(1.0, VISCOSITY, 1.0, 2, 3)
    runs = {count: list(simulate(load_scene(SCENE, [f"spacing={1.0 / count}"]))) for count in COUNTS}
    found, errors = [], []
    for count, frames in runs.items():
        swing, name = swing_of(frames), f"ball of {count} spacings"
        errors.append(abs(swing.frequency / exact.frequency - 1.0))
        found += [
            within(f"{name}: frequency", swing.frequency, exact.frequency, 2.5 / count**2 * exact.frequency),
            within(f"{name}: decay", swing.rate, exact.rate, 0.4 * exact.rate),
            within(f"{name}: pressure over 2 sigma/R, mean over time", pressure_inside(frames), 1.0, 0.2),
            below(f"{name}: rise of the total energy", longest_rise(frames), 1e-6),
        ]
    order = float(np.log(errors[0] / errors[1]) / np.log(COUNTS[1] / COUNTS[0]))
    return [*found, above("balls: order of the frequency", order, 1.0)]


def pressure_inside(frames: list[Frame]) -> float:
    """The mean of the inner half, once the start's breathing is over."""
    found = []
    for frame in frames[len(frames) // 2 :]:
        inner = np.linalg.norm(frame.arrays["position"], axis=1) < 0.5
        found.append(frame.arrays["pressure"][inner].mean())
    return float(np.mean(found)) / laplace_pressure(1.0, 1.0, 3)
