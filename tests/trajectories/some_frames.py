"""Frames to write, read and compare."""

from __future__ import annotations

from typing import Any

import numpy as np

from ecume.trajectories.frame import Frame

UNITS = {"position": "m", "velocity": "m/s", "radius": "m", "mass": "kg", "species": "1", "kinetic_energy": "J"}


def frame_at(number: int, particles: int = 6, dimensions: int = 2) -> Frame:
    """A frame with random contents."""
    random = np.random.default_rng(number)
    arrays: dict[str, Any] = {
        "position": random.normal(size=(particles, dimensions)),
        "velocity": random.normal(size=(particles, dimensions)),
        "radius": np.linspace(0.001, 0.002, particles),
        "mass": np.full(particles, 0.1),
        "species": np.arange(particles) % 3,
        "neighbors": random.integers(-(2**62), 2**62, particles),
    }
    return Frame(0.1 * number, arrays, {"kinetic_energy": random.normal(), "contacts": 4.0}, UNITS)


def same(one: Frame, other: Frame) -> bool:
    """The same bit for bit, names and units too."""
    alike = one.time == other.time and one.units == other.units and repr(one.numbers) == repr(other.numbers)
    return alike and all(
        array.tobytes() == other.arrays[name].tobytes()
        and (array.dtype, array.shape) == (other.arrays[name].dtype, other.arrays[name].shape)
        for name, array in one.arrays.items()
    )
