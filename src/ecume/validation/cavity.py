"""A square driven by its lid, at two resolutions, against corrected tables and another package."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume.laws.kernels import kernel
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume.validation.rows import Row, above, below, within
from ecume.validation.runner import frames_of, read_table

SIDES = (25, 50)
STEADY = 12.0
LINES = {"u": 0, "v": 1}
WALLS = ((0, 0.0, (0.0, 0.0)), (0, 1.0, (0.0, 0.0)), (1, 0.0, (0.0, 0.0)), (1, 1.0, (2.0, 0.0)))
"""Axis and place of each wall, and twice its velocity."""


class Found(NamedTuple):
    """The errors and the volume of a run."""

    errors: dict[str, float]
    """the largest on each line"""
    volume: float


def rows() -> list[Row]:
    """Compare runs of both resolutions."""
    coarse, fine = (found(side) for side in SIDES)
    largest = [max(one.errors.values()) for one in (coarse, fine)]
    published = read_table("cavity")
    peers = {case["line"]: float(case["value"]) for case in published if case["quantity"] == "largest error"}
    return [
        below(f"{SIDES[0]} a side: largest error", largest[0], 0.03),
        *(below(f"{SIDES[1]} a side: largest error of {line}", fine.errors[line], 0.015) for line in LINES),
        *(below(f"{SIDES[1]} a side: error of {line} below PySPH's", fine.errors[line], peers[line]) for line in LINES),
        above("order of the largest error", math.log2(largest[0] / largest[1]), 1.0),
        within("volume at the end", fine.volume, 1.0, 0.005),
    ]


def found(side: int) -> Found:
    """One run: velocities on the lines, in the mean of the last frames."""
    frames = [frame for frame in frames_of("cavity", [f"spacing={1.0 / side!r}"]) if frame.time >= STEADY]
    errors = {}
    for line, component in LINES.items():
        places, expected = table(line)
        found = np.mean([velocity_at(frame, places, 2.0 / side)[:, component] for frame in frames], axis=0)
        errors[line] = float(np.abs(found - expected).max())
    return Found(errors, frames[-1].numbers["volume"])


def table(line: str) -> tuple[Array, Array]:
    """(n, 2) places, and what the velocity there is."""
    cases = [case for case in read_table("cavity", "independent") if case["line"] == line]
    along = np.array([float(case["place"]) for case in cases])
    middle = np.full(len(along), 0.5)
    places = np.stack([middle, along] if line == "u" else [along, middle], axis=1)
    return places, np.array([float(case["velocity"]) for case in cases])


def velocity_at(frame: Frame, places: Array, smoothing: float) -> Array:
    """(n, 2) of a line fitted to the particles around each place, each weighed by the kernel."""
    position, velocity = completed(frame, 2.0 * smoothing)
    shape, fitted = kernel("wendland-c2", dim=2), []
    for place in places:
        away = position - place
        weight = np.asarray(shape.value(np.hypot(*away.T), smoothing))
        near = weight > 0.0
        basis = np.column_stack([np.ones(int(near.sum())), away[near]])
        weighed = basis.T * weight[near]
        fitted.append(np.linalg.solve(weighed @ basis, weighed @ velocity[near])[0])
    return np.array(fitted)


def completed(frame: Frame, reach: float) -> tuple[Array, Array]:
    """Positions and velocities of the particles, and of their images in walls that hold the liquid."""
    position, velocity = frame.arrays["position"], frame.arrays["velocity"]
    for axis, wall, twice in WALLS:
        near = np.abs(position[:, axis] - wall) < reach
        image = position[near].copy()
        image[:, axis] = 2.0 * wall - image[:, axis]
        position = np.concatenate([position, image])
        velocity = np.concatenate([velocity, np.array(twice) - velocity[near]])
    return position, velocity
