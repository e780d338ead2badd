"""What the physics of tracers moves, the scratch beside it, and what actions may change."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.walls import clearance, described
from ecume.models.actions import Access
from ecume.models.tracers.parameters import Parameters, surfaces_of
from ecume.scenes.tracers import TracersScene
from ecume.units import Array

CAPPED = 0
"""The place in `State.tally` of flights cut short."""


class State(NamedTuple):
    """Everything that can change a later bit: randomness follows from the seed, the particle and the step."""

    position: Array
    """(N, d) m"""
    velocity: Array
    """(N, d) m/s"""
    step: Integers
    """(1,)"""
    left: Integers
    """(N,) the opening through which a particle left, or -1"""
    hits: Integers
    """(K,) how often each wall was hit"""
    tally: Integers
    """(1,) flights with more bounces than a step may have"""
    work: Array = np.zeros(1)
    """(1,) J of work from outside: see `energy_budget`"""


class Workspace(NamedTuple):
    """Scratch of one step."""

    origin: Array
    """(N, d) previous positions"""
    travel: Array
    """(N, d) the velocity with which the step begins"""
    push: Array
    """(N, d) the acceleration of the parabola that ends where the exact motion does"""
    kick: Array
    """(N, d) what the exact velocity has more than the parabola's, as long as no wall is met"""
    noise: Array
    """(N, d) the part of that which is chance, and stays"""
    shift: Array
    """(N, d) the part of the way that is chance"""
    external: Array
    """(N, d) m/s^2: the acceleration by laws of the user"""
    radius: Array
    hits: Integers
    """(N,)"""
    fate: Integers
    """(N,)"""


def make_state(position: Array, velocity: Array, surfaces: int) -> State:
    """The state at time 0."""
    count = len(position)
    return State(
        np.ascontiguousarray(position),
        np.ascontiguousarray(velocity),
        np.zeros(1, np.int64),
        np.full(count, -1, np.int64),
        np.zeros(surfaces, np.int64),
        np.zeros(1, np.int64),
        np.zeros(1),
    )


def came(parameters: Parameters, state: State) -> int:
    """The number of particles that have entered."""
    return len(state.position) - (len(parameters.bodies.radius) - len(parameters.arrivals.step))


def workspace(parameters: Parameters, state: State, room: float) -> Workspace:
    """The workspace, which cannot overflow."""
    count, shape = len(state.position), state.position.shape
    a, b, c, d, e, f, g = (np.zeros(shape) for _ in range(7))
    radius = np.ascontiguousarray(parameters.bodies.radius[:count])
    return Workspace(a, b, c, d, e, f, g, radius, np.zeros(count, np.int64), np.zeros(count, np.int64))


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
