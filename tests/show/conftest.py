"""Frames that no model had to make: floats that drift towards the middle of a dish, two species."""

import numpy as np
import pytest

from ecume.scenes.floating import DishSpec, FloatingScene, FloatSpec, LiquidSpec
from ecume.trajectories.frame import Frame

UNITS = {"kinetic_energy": "J", "pair_energy": "J", "wall_energy": "J", "total_energy": "J", "clusters": "1"}


@pytest.fixture
def scene():
    """Four light floats and two heavy ones in a round dish."""
    return FloatingScene(
        title="Costs $5 and _more_ $$",
        duration=1.0,
        frame_every=0.1,
        liquid=LiquidSpec(density=1000.0, surface_tension=0.07),
        particles=(
            FloatSpec(name="cereal", count=4, radius=2e-3, density=600.0, contact_angle=1.2, color="#ff0000"),
            FloatSpec(name="_bead", count=2, radius=1e-3, density=2000.0, contact_angle=1.5, color="#00ff00"),
        ),
        dish=DishSpec(radius=0.03, contact_angle=0.8),
    )


@pytest.fixture
def frames():
    """Eleven instants: light floats close in on one another until they touch, heavy ones stay."""
    return [_frame(0.1 * n) for n in range(11)]


def _frame(time):
    spread = 0.012 - 0.009 * time
    light = [(spread, 0.0), (0.0, spread), (-spread, 0.0), (0.0, -spread)]
    arrays = {
        "position": np.array([*light, (0.020, 0.008), (0.020, -0.008)]),
        "velocity": np.zeros((6, 2)),
        "radius": np.array([2e-3] * 4 + [1e-3] * 2),
        "charge": np.array([-1e-4] * 4 + [5e-5] * 2),
        "species": np.array([0] * 4 + [1] * 2),
    }
    kinetic, pair, wall = 1e-9 * time * np.exp(-time), -3e-9 * time, 2e-9 - 1e-9 * time
    values = (kinetic, pair, wall, kinetic + pair + wall, 6.0)
    return Frame(time, arrays, dict(zip(UNITS, values, strict=True)), UNITS)


class Run(list):
    """A trajectory in memory."""

    def __init__(self, frames, scene):
        super().__init__(frames)
        self.scene = scene

    def __enter__(self):
        return self

    def __exit__(self, *error):
        return None


@pytest.fixture
def opened(frames, scene):
    """What opening a run with these frames gives."""
    return Run(frames, scene)
