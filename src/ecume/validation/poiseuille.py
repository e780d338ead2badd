"""Channels that start, with walls of images and of dummies, at two resolutions, beside their series."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ecume.laws.flows import couette_start, poiseuille_start
from ecume.trajectories.frame import Frame
from ecume.validation.rows import Row, above, below
from ecume.validation.runner import frames_of, read_table

ACROSS = (15, 30)
VISCOSITY = 0.1
EARLIEST = 0.225
"""s, tau = 0.0225: before that the layer at the wall is thinner than a smoothing length."""
DRIVEN = {"poiseuille": "gravity=[0.8, 0.0]", "couette": "tank.top={velocity=[1.0, 0.0]}"}
WALLS = ("mirror", "dummy")


def rows() -> list[Row]:
    """The series first."""
    return [*series(), *(row for flow in DRIVEN for walls in WALLS for row in channel(flow, walls))]


def series() -> list[Row]:
    """The largest difference of ecume's series from the table, one row per flow."""
    worst = dict.fromkeys(DRIVEN, 0.0)
    for case in read_table("poiseuille", "independent"):
        found = exact(case["flow"], float(case["height"]), float(case["tau"]) / VISCOSITY)
        worst[case["flow"]] = max(worst[case["flow"]], abs(found - float(case["speed"])))
    return [below(f"{flow}: series off the table by", off, 1e-7) for flow, off in worst.items()]


def channel(flow: str, walls: str) -> list[Row]:
    """One flow, one kind of walls, both resolutions."""
    bound = float(read_table("poiseuille")[0]["largest_error"])
    errors = [largest_error(flow, [DRIVEN[flow], f"tank.walls={walls}", f"spacing={1.0 / n!r}"]) for n in ACROSS]
    name = f"{flow}, {walls}"
    return [
        below(f"{name}: largest error, {ACROSS[0]} across", errors[0], 4.0 * bound),
        below(f"{name}: largest error, {ACROSS[1]} across", errors[1], bound),
        above(f"{name}: order", math.log2(errors[0] / errors[1]), 1.3),
    ]


def largest_error(flow: str, changes: Sequence[str]) -> float:
    """The largest error of all particles over all frames."""
    frames = [frame for frame in frames_of("poiseuille", changes) if frame.time >= EARLIEST - 1e-9]
    return max(error(flow, frame) for frame in frames)


def error(flow: str, frame: Frame) -> float:
    """The largest in a frame."""
    speed, height = frame.arrays["velocity"][:, 0], np.clip(frame.arrays["position"][:, 1], 0.0, 1.0)
    return float(np.abs(speed - [exact(flow, y, frame.time) for y in height]).max())


def exact(flow: str, height: float, time: float) -> float:
    """The exact speed, with a largest speed of one in the end."""
    if flow == "couette":
        return couette_start(height, time, 1.0, VISCOSITY, 1.0)
    return poiseuille_start(height, time, 1.0, VISCOSITY, 8.0 * VISCOSITY)
