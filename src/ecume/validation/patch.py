"""A spinning square of liquid: its negative pressure, its momentum, and whether it tears into strings."""

from __future__ import annotations

import numpy as np

from ecume.laws.flows import patch_pressure
from ecume.trajectories.frame import Frame
from ecume.validation.rows import Row, above, below, within
from ecume.validation.runner import frames_of, read_table

MIDDLE = -147.34
"""Pa, at the start."""


def rows() -> list[Row]:
    """The series, then runs of two resolutions, then without shifting."""
    coarse, fine, bare = course(0.05), course(0.025), course(0.025, "method.shifting=none")
    return [
        below("series off the table by", off_the_table(), 1e-6),
        within("20 a side: pressure in the middle (Pa)", early(coarse), MIDDLE, 7.4),
        within("40 a side: pressure in the middle (Pa)", early(fine), MIDDLE, 7.4),
        within("angular momentum, shifted", spin(fine[-1]) / spin(fine[0]), 1.0, 0.005),
        within("angular momentum, not shifted", spin(bare[-1]) / spin(bare[0]), 1.0, 0.005),
        above("energy of motion left", fine[-1].numbers["kinetic_energy"] / fine[0].numbers["kinetic_energy"], 0.95),
        within("volume", fine[-1].numbers["volume"], 1.0, 0.005),
        above("nearest neighbors, shifted", nearest(fine[-1]), 0.8),
        below("nearest neighbors, not shifted", nearest(bare[-1]), 0.8),
    ]


def course(spacing: float, *changes: str) -> list[Frame]:
    """One run."""
    return list(frames_of("patch", [f"spacing={spacing!r}", *changes]))


def off_the_table() -> float:
    """The largest difference of ecume's series from the table."""
    table = [[float(value) for value in case.values()] for case in read_table("patch", "independent")]
    return max(abs(patch_pressure(x, y, 1.0, -2.0, 1.0) - pressure) for x, y, pressure in table)


def early(frames: list[Frame]) -> float:
    """The mean pressure in the middle (Pa) while sound passes a few times."""
    first = [frame for frame in frames if 0.0 < frame.time < 0.35]
    return float(np.mean([frame.arrays["pressure"][inner(frame, 0.1)].mean() for frame in first]))


def inner(frame: Frame, radius: float) -> np.typing.NDArray[np.bool_]:
    """The particles near the middle."""
    near: np.typing.NDArray[np.bool_] = np.hypot(*frame.arrays["position"].T) < radius
    return near


def spin(frame: Frame) -> float:
    """Angular momentum (kg m^2/s)."""
    x, v = frame.arrays["position"], frame.arrays["velocity"]
    return float(np.sum(frame.arrays["mass"] * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])))


def nearest(frame: Frame) -> float:
    """The mean distance to the nearest neighbor in the middle, over the lattice's at this density of particles."""
    place = frame.arrays["position"][inner(frame, 0.25)]
    apart = np.linalg.norm(place[:, None] - place[None], axis=2) + 10.0 * np.eye(len(place))
    lattice = np.sqrt(np.pi * 0.25**2 / len(place))
    return float(apart.min(axis=1).mean() / lattice)
