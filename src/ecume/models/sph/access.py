"""What actions may change of a tank: positions and velocities of the liquid."""

from __future__ import annotations

import numpy as np

from ecume.engine.cells import Integers
from ecume.models.actions import Access
from ecume.models.sph.boundaries.prescribed_motion import instant
from ecume.models.sph.boundaries.walls import flag_outside
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.state import WORK, State
from ecume.scenes.sph import SphScene


def faults(scene: SphScene, parameters: Parameters, state: State) -> list[str]:
    """The particles behind a wall, in a solid, or beyond an open side."""
    guard, outside = instant(parameters, state).boundary.guard, np.zeros(len(state.mass), np.bool_)
    if len(guard.owner):
        flag_outside(state.position, guard.sheet.kind, guard.sheet.number, 0.0, outside)
    low, high = parameters.bounds[:, :, None]
    outside |= ((state.position < low) | (state.position > high)).any(axis=0)
    return [
        f"particle {i} is outside, at {state.position[:, k].tolist()} m; expected a position in the tank"
        for i, k in zip(state.identity[outside], np.flatnonzero(outside), strict=True)
        if state.zone[k] == 0
    ]


def changed(state: State, moved: bool) -> None:
    """Forces depend on positions and velocities."""
    state.ready[0] = 0
    if moved:
        state.reference[...] = state.position
        state.pose_reference[...] = state.pose
        state.clock[1] = state.clock[0]


def ids(state: State) -> Integers:
    """The permanent numbers of particles; buffers behind open sides are not liquid yet."""
    return np.where(state.zone == 0, state.identity, -1)


TANKS = Access(
    arrays=lambda state: {"position": state.position.T, "velocity": state.velocity.T},
    ids=ids,
    faults=faults,
    changed=changed,
    work=lambda state: state.budget[WORK : WORK + 1],
)
