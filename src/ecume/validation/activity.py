"""The mean squared displacement of active floats, against closed forms."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ecume.analysis.structure import mean_square_displacement
from ecume.models import MODELS
from ecume.models.floating.setup.kinds import turning_frictions
from ecume.scenes.floating import FloatingScene
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume.validation.rows import Row, within

COUNT, RADIUS, FORCE = 2000, 1e-5, 1e-12
MEMORY, EVERY, FRAMES = 0.5, 0.1, 600
"""The correlation time (s), the time between frames, and their number."""
LAGS = (1, 2, 5, 10)
TORQUE = 6e-17
"""N m: turns the heading by more than a radian in one correlation time."""
TOLERANCE = 0.01
KINDS = {
    "random force": {"force": FORCE, "persistence": MEMORY},
    "propulsion": {"propulsion": FORCE, "rotational_diffusion": 1.0 / MEMORY},
    "propulsion and torque": {"propulsion": FORCE, "rotational_diffusion": 1.0 / MEMORY, "torque": TORQUE},
}


def rows() -> list[Row]:
    """Each kind of activity at several times."""
    return [row for name in KINDS for row in displacements(name)]


def scene_of(name: str) -> FloatingScene:
    """Free floats on a lattice."""
    bead = {
        "radius": RADIUS, "density": 1500.0, "contact_angle": 1.2, "count": COUNT, "placement": "lattice",
        "spacing": 5e-2,
    }  # fmt: skip
    scene = from_plain({
        "model": "floating", "duration": EVERY * FRAMES, "frame_every": EVERY, "seed": 4, "particles": [bead],
        "activity": KINDS[name], "integration": {"integrator": "overdamped"}, "interaction": {"law": "none"},
        "contacts": {"law": "none"},
    })  # fmt: skip
    assert isinstance(scene, FloatingScene)  # noqa: S101  # its model is that
    return scene


def displacements(name: str) -> Iterator[Row]:
    """The mean squared displacement over that in closed form."""
    scene = scene_of(name)
    speed = FORCE * float(MODELS["floating"].parameters(scene).kick.gain[0])
    turning = KINDS[name].get("torque", 0.0) / float(turning_frictions(scene)[0])
    tracks = np.array([frame.arrays["position"] for frame in simulate(scene)])
    found = mean_square_displacement(tracks, LAGS)
    for lag, square in zip(LAGS, found, strict=True):
        ratio = float(square) / persistent_displacement(speed, 1.0 / MEMORY, turning, EVERY * lag)
        yield within(f"{name}: displacement squared after {EVERY * lag:g} s, over theory", ratio, 1.0, TOLERANCE)


def persistent_displacement(speed: float, rate: float, turning: float, time: float) -> float:
    """The mean squared displacement of a velocity with the correlation v^2 e^(-D t) cos(w t): the real part of
    2 v^2 (t/k - (1 - e^(-k t))/k^2) with k = D - i w.
    """
    decay = complex(rate, -turning)
    exponential = np.exp(-decay * time)
    return 2.0 * speed**2 * float(((time / decay) - (1.0 - exponential) / decay**2).real)
