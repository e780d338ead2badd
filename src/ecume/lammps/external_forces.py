"""Our forces on the particles of one rank of LAMMPS: its own, and ghosts of those of other ranks and of the box.

Ghosts are particles with known positions, so that sums over pairs need no periodic images. Their own forces are
incomplete, and are not used.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.record import workspace
from ecume.models.floating.setup.initial_state import with_parts
from ecume.models.floating.state import Workspace, make_state
from ecume.models.floating.time_integration.integration import forces_at
from ecume.units import Array


class Kept(NamedTuple):
    """Neighbor lists, and what they are valid for."""

    which: Integers
    position: Array
    parameters: Parameters
    workspace: Workspace


class ExternalForces:
    """The forces of a scene on some of its floats, with their drag."""

    def __init__(self, parameters: Parameters) -> None:
        """`parameters` are those of all floats."""
        self._parameters = parameters
        self._kept: Kept | None = None

    def __call__(self, which: Integers, position: Array, velocity: Array) -> Array:
        """The forces (N) on the first floats, as many as there are velocities; `which` are the numbers of all."""
        own = len(velocity)
        kept = self._kept
        if kept is None or not _holds(kept, which, position):
            kept = self._kept = _listed(part_of(self._parameters, which), which, position)
        floats = kept.parameters.floats
        friction = (floats.mass / floats.relaxation_time)[:own, None]
        found: Array = forces_at(kept.parameters, position, kept.workspace)[:own] - friction * velocity
        return found


def part_of(parameters: Parameters, which: Integers) -> Parameters:
    """The parameters of these floats, some of which may be there twice; without a periodic cell."""
    count, kick = len(parameters.floats.radius), parameters.kick
    rows = np.concatenate([which, np.arange(count, len(kick.mobility))])
    return parameters._replace(
        floats=parameters.floats._replace(**{name: row[which] for name, row in parameters.floats._asdict().items()}),
        kick=kick._replace(decay=kick.decay[which], gain=kick.gain[which], mobility=kick.mobility[rows]),
        wall_strength=np.ascontiguousarray(parameters.wall_strength[:, which]),
        periods=np.zeros_like(parameters.periods),
    )


def _holds(kept: Kept, which: Integers, position: Array) -> bool:
    """Whether neighbor lists are valid: for the same floats, none of which moved by more than half of the skin."""
    if not np.array_equal(kept.which, which):
        return False
    return bool(np.linalg.norm(position - kept.position, axis=1).max() <= 0.5 * kept.parameters.skin)


def _listed(parameters: Parameters, which: Integers, position: Array) -> Kept:
    """New neighbor lists at these positions."""
    state = with_parts(make_state(position.copy(), np.zeros_like(position)), parameters)
    return Kept(which.copy(), position.copy(), parameters, workspace(parameters, state, 1.0))
