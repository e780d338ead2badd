"""Mean forces of an incompressible liquid on walls and solids over a step, at the positions and pressures of its
substeps, so that momentum is conserved.

The pressures of a step act before the particles move. With an evaluation after the motion, as in a compressible liquid,
6 to 16 % of the momentum of a splash was missing in the forces on walls. A dummy w has the pressure of the particle i
in front of it, mirrored: the force on it is -V_i V_w [2 p_i + rho (G - u).x_iw] F x_iw, see `projection`.
"""

from __future__ import annotations

import numpy as np

from ecume.engine.neighbor_rows import pairs_in
from ecume.engine.shapes import Flags
from ecume.models.sph.boundaries.forces_on_solids import chains_of, forces_on_dummies, loads_of, roots_of
from ecume.models.sph.boundaries.touching_solids import exchanged_loads
from ecume.models.sph.boundaries.walls import all_repelled, repulsion_load
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.projection import System, gravity_at
from ecume.models.sph.rates.right_hand_side import fill
from ecume.models.sph.state import State, Workspace
from ecume.units import Array


def add_loads(now: Parameters, state: State, workspace: Workspace, solved: tuple[System, Array]) -> None:
    """Add the forces and torques of a substep to the means over the step; `solved` is the result of `project`."""
    fill(now, state, workspace)
    fields = workspace.fields
    kept = fields.force_term.copy()
    fields.force_term[...] = 0.0
    rubbed, place = forces_on_dummies(now, workspace, 0)
    fields.force_term[...] = kept
    pressed = pressure_on_dummies(now, state, workspace, solved)
    more = [*exchanged_loads(now, state, workspace, on_dummies=(pressed, place)).items()]
    more += [(each.owner, repulsion_load(now, state, each)) for each in all_repelled(now, state)]
    more += list(loads_of(now, workspace, (rubbed + pressed, place)))
    share = solved[0].time / now.time_step
    for number, (force, torque) in more:
        state.struck[number] += share * np.concatenate([force, torque])


def pressure_on_dummies(now: Parameters, state: State, workspace: Workspace, solved: tuple[System, Array]) -> Array:
    """The pressure force on each dummy (3, n) in N, including the components of the forces on its images along their
    mirrors.
    """
    (system, flight), d = solved, now.dimension
    count, real = state.position.shape[1], len(workspace.lists.counts)
    found = np.zeros((3, real - count))
    if real == count:
        return found
    i, place = pairs_in(workspace.lists, count)
    dummy = workspace.fields.liquid[workspace.lists.neighbor[place]] == 0.0
    i, place = i[dummy], place[dummy]
    j = workspace.lists.neighbor[place].astype(np.int64)
    gradient, slope = system.gradient[:d, place], system.gradient[d, place]
    away = gradient / np.where(slope == 0.0, 1.0, slope)
    gravity = gravity_at(now, workspace.fields.position[:d, j].astype(np.float64) + now.origin[:, None]) - flight[:, i]
    push = 2.0 * state.pressure[i] + system.density * (gravity * away).sum(axis=0)
    force = -system.volume[i] * workspace.fields.volume[j] * push * gradient
    root = np.concatenate([np.arange(real), roots_of(workspace.images, real)])
    for axis in range(d):
        here = np.where(crossed(now, workspace, axis)[j], 0.0, force[axis])
        found[axis] = np.bincount(root[j] - count, here, real - count)
    return found


def crossed(now: Parameters, workspace: Workspace, axis: int) -> Flags:
    """Whether each column is an image in a mirror across an axis; the mirror bears the force along this axis."""
    sides, chains = now.boundary.sides, chains_of(workspace.images, len(workspace.lists.counts))
    found = np.zeros(workspace.fields.shape[1], np.bool_)
    for side in np.flatnonzero(sides.mirrors):
        if sides.normal[side, axis] != 0.0:
            found[len(workspace.lists.counts) :] |= (chains >> int(side) & 1).astype(np.bool_)
    return found
