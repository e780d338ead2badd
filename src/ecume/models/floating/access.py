"""What actions may change of floats: positions and velocities."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ecume.models.actions import Access
from ecume.models.floating.contacts.contact_models import contacts_of, gaps_between
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.report.invariants import OVERLAP
from ecume.models.floating.setup.initial_state import position_faults
from ecume.models.floating.state import WORK, State

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


def faults(scene: FloatingScene, parameters: Parameters, state: State) -> list[str]:
    """The floats that overlap by more than contacts tolerate, or are outside the dish."""
    radius = parameters.floats.radius
    names = [f"float {i}" for i in range(len(radius))]
    if contacts_of(parameters).gaps is not None:
        gaps = gaps_between(parameters, state.position, state.turning[:, 0], 0.0)
        walls = "the wall of the dish"
        return [
            f"{names[i]} overlaps {names[j] if j < len(radius) else walls} by {-gap:.3g} m"
            for i, j, gap in gaps
            if -gap > OVERLAP * radius[i]
        ]
    which = np.arange(len(radius))
    return [f"{path} {what}" for path, what, *_ in position_faults(parameters, state.position, which, names, OVERLAP)]


def changed(state: State, moved: bool) -> None:
    """Neighbor lists are made at the reference positions; contacts that were kept are of former positions."""
    if moved:
        state.reference[:] = state.position
        state.touches[0] = 0


FLOATS = Access(
    arrays=lambda state: {"position": state.position, "velocity": state.velocity},
    faults=faults,
    changed=changed,
    work=lambda state: state.tally[WORK : WORK + 1],
)
