"""Frames of liquid that no model had to make: a still block that fills the left of a tank."""

import numpy as np
import pytest

from ecume.laws.hydrostatics import hydrostatic_density
from ecume.laws.states import tait_pressure
from ecume.scenes.schema import from_plain
from ecume.trajectories.frame import Frame

SPACING = 0.05
UNITS = {
    "kinetic_energy": "J",
    "potential_energy": "J",
    "total_energy": "J",
    "center_x": "m",
    "center_y": "m",
    "center_z": "m",
    "front": "m",
    "top": "m",
}


def scene_of(dimension=2, **more):
    """A tank 2 m long and 1 m high (and deep), filled to a half."""
    low, high = [0.0] * dimension, [2.0, 1.0, 1.0][:dimension]
    return from_plain(
        {
            "model": "sph",
            "title": "Still_water $5",
            "duration": 1.0,
            "frame_every": 0.1,
            "spacing": SPACING,
            "tank": {"low": low, "high": high, "top": {"kind": "open"}},
            "fluid": [{"low": low, "high": [2.0, 0.5, 1.0][:dimension]}],
            "liquid": {"sound_speed": 40.0},
            **more,
        }
    )


def frame_of(time=0.0, dimension=2, length=2.0):
    """The liquid at rest from x = 0 on."""
    axes = [SPACING * (np.arange(round(side / SPACING)) + 0.5) for side in (length, 0.5, 1.0)[:dimension]]
    position = np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1)
    density = np.array([hydrostatic_density(0.5 - y, 9.81, 1000.0, 40.0) for y in position[:, 1]])
    velocity = np.zeros_like(position)
    velocity[:, 0] = 3.0 * position[:, 1]
    arrays = {
        "position": position,
        "velocity": velocity,
        "pressure": tait_pressure(density, 1000.0, 40.0),
        "density": density,
        "mass": density * SPACING**dimension,
        "species": np.zeros(len(position), np.int64),
    }
    center = np.zeros(3)
    center[:dimension] = position.mean(axis=0)
    values = (2.0, 3.0, 5.0, *center, position[:, 0].max(), position[:, 1].max())
    return Frame(time, arrays, dict(zip(UNITS, values, strict=True)), UNITS)


@pytest.fixture
def scene():
    """In the plane."""
    return scene_of()


@pytest.fixture
def frames():
    """Three instants of rest."""
    return [frame_of(0.1 * n) for n in range(3)]


def carrying(frame, count=12):
    """The same with so many carried particles in one place, under a pressure that no liquid has."""
    arrays = {name: np.concatenate([array, array[:count]]) for name, array in frame.arrays.items()}
    arrays["position"][-count:], arrays["pressure"][-count:], arrays["species"][-count:] = (1.0, 0.25), 1e9, 1
    return frame._replace(arrays=arrays)
