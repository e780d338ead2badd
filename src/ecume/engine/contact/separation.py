"""Position projection of bodies that rotate: displacements and rotations that remove all overlaps."""

from __future__ import annotations

import numpy as np

from ecume._jit import compiled
from ecume.engine.contact import impulse_solvers
from ecume.engine.contact.contacts import Candidates, deepest_overlap
from ecume.engine.contact.impulse_solvers import Tolerance
from ecume.engine.contact.torque_contacts import OutlinedBodies, TorqueContacts, gather
from ecume.engine.outlines import Stance
from ecume.engine.walls import wall_count


@compiled
def separate(
    contacts: TorqueContacts, candidates: Candidates, stance: Stance, bodies: OutlinedBodies, slop: float
) -> int:
    """Move and rotate overlapping bodies until no overlap exceeds `slop`, without changing velocities (position
    projection).

    Each iteration linearizes the gaps and finds the smallest displacements that remove all overlaps, by the impulse
    solver. Returns the number of iterations; `contacts` are those of the final positions.
    """
    position, angle = stance.position, stance.angle
    shift = np.zeros((len(position) + wall_count(bodies.walls), 3))
    for turn in range(50):
        if deepest_overlap(contacts.total, contacts.gap) <= slop:
            return turn
        shift[:] = 0.0
        for row in range(contacts.total[0]):
            contacts.impulse[row] = 0.0
            contacts.bound[row] = -contacts.gap[row] - 0.25 * slop
        impulse_solvers.solve(contacts, shift, Tolerance(1e-3 * slop, 1e-2 * slop))
        for i in range(len(position)):
            position[i, 0] += shift[i, 0]
            position[i, 1] += shift[i, 1]
            angle[i] += shift[i, 2]
        gather(contacts, candidates, stance, bodies, 4.0 * slop)
    return 50
