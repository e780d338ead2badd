"""What actions may change of tracers: positions and velocities of those inside."""

from __future__ import annotations

import numpy as np

from ecume.engine.walls import clearance, described
from ecume.models.actions import Access
from ecume.models.tracers.parameters import Parameters
from ecume.models.tracers.state import State
from ecume.models.tracers.tank import surfaces_of
from ecume.scenes.tracers import TracersScene

TOUCHING = 1e-6
"""Of a radius: tracers that touch a wall may be this far in it."""


def faults(scene: TracersScene, parameters: Parameters, state: State) -> list[str]:
    """The tracers that are neither inside nor have left."""
    surfaces, radius = surfaces_of(scene), parameters.bodies.radius[: len(state.position)]
    if not len(surfaces.kind):
        return []
    clear, which = clearance(state.position, surfaces)
    beyond = np.flatnonzero((clear < radius * (1.0 - TOUCHING)) & (state.left < 0))
    return [
        f"particle {i} is {radius[i] - clear[i]:.3g} m beyond {described(surfaces, int(which[i]))}; "
        "expected a position inside, its radius included"
        for i in beyond
    ]


TRACERS = Access(
    arrays=lambda state: {"position": state.position, "velocity": state.velocity},
    faults=faults,
    work=lambda state: state.work,
)
