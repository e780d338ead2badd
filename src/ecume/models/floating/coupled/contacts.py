"""Contacts of floats that interact through the liquid: the impulse of each contact moves all floats.

Without inertia nothing rebounds. One plastic solve for the midstep velocities, with the full mobility, keeps floats
from overlapping after the step.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume.engine.contact import contacts as touching
from ecume.engine.contact import impulse_solvers, mobility_contacts
from ecume.engine.contact.contacts import Contacts, Memory
from ecume.engine.contact.impulse_solvers import Goal
from ecume.engine.contact.mobility_contacts import DenseRows, make_dense_rows
from ecume.models.floating.contacts.collisions import (
    clear_impulses,
    contact_bodies,
    goal_of,
    require_gaps,
)
from ecume.models.floating.contacts.friction import Friction, friction_of, memory_of
from ecume.models.floating.coupled.mobility import CoupledScratch
from ecume.models.floating.coupled.motion import store_velocities
from ecume.models.floating.options import Built
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.state import SWEEPS, UNCONVERGED, State, Workspace
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


class CoupledImpulses(NamedTuple):
    """Contacts that are solved with the mobility of all floats, with or without friction."""

    friction: tuple[float, float]
    """coefficients of friction between two floats, and at walls"""
    inertia: Array
    """(N,) kg m^2 of floats that turn; (0,) without friction"""
    overlapping: bool
    """whether floats pass through one another; see also `collisions.Impulses`"""


def rubbing_impulses_of(parameters: Parameters, scene: FloatingScene, interactions: tuple[Any, ...]) -> Built:
    """Return contacts with friction."""
    made: Friction = friction_of(parameters, scene, interactions).part
    return Built(CoupledImpulses(made.friction, made.inertia, False))


def smooth_impulses_of(parameters: Parameters, scene: FloatingScene, interactions: tuple[Any, ...]) -> Built:
    """Return contacts without friction, or none."""
    return Built(CoupledImpulses((0.0, 0.0), np.zeros(0), scene.contacts.law == "none"))


@compiled
def collide_coupled(
    part: CoupledImpulses, own: CoupledScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Solve for the midstep velocities, so that no float overlaps another after the step."""
    if part.overlapping:
        return
    contacts, memory, turning = workspace.contacts, memory_of(state), len(part.inertia) > 0
    goal = gather_contacts(parameters, state, workspace)
    if goal.target > 0.0:
        rows = dense_rows_of(part, contacts, parameters, len(own.motion))
        if turning:
            recall_rubbing(rows, contacts, memory, state.rub, parameters.time_step)
        sweeps = mobility_contacts.solve(rows, own.mobility, own.motion, goal)
        state.tally[SWEEPS] += sweeps
        state.tally[UNCONVERGED] += 1.0 if sweeps > impulse_solvers.MOST_SWEEPS else 0.0
        keep_impulses(rows, contacts, parameters, own)
        touching.remember(touching.contact_keys(contacts), memory)
        if turning:
            rubbing = parameters.time_step * rows.impulse[contacts.total[0] :]
            touching.remember_each(touching.contact_keys(contacts), rubbing, memory, state.rub)
    else:
        clear_impulses(contacts)
        touching.remember(touching.contact_keys(contacts), memory)
    store_velocities(own, state, workspace)
    for i in range(len(state.turning) if turning else 0):
        state.turning[i, 1] = own.motion[2 * len(state.turning) + i]
        state.turning[i, 0] += parameters.time_step * state.turning[i, 1]


@compiled
def gather_contacts(parameters: Parameters, state: State, workspace: Workspace) -> Goal:
    """Find the contacts of this step, with the impulses of the last one; return the tolerance of their solution."""
    contacts = workspace.contacts
    # Twice the travel for a head-on pair, and twice again for floats that others push.
    reach = 4.0 * workspace.travel[0] + parameters.slop
    touching.gather(contacts, workspace.candidates, state.position, contact_bodies(parameters), reach)
    require_gaps(False, parameters, contacts)
    touching.recall(touching.contact_keys(contacts), memory_of(state))
    touching.normal_velocities(contacts, workspace.midstep_velocity, contacts.scratch)
    return goal_of(parameters, contacts)


@compiled
def dense_rows_of(part: CoupledImpulses, contacts: Contacts, parameters: Parameters, size: int) -> DenseRows:
    """Return the rows of all contacts; their unknowns are mean forces, impulses over the time step."""
    total, count, radius = contacts.total[0], len(parameters.floats.radius), parameters.floats.radius
    turning = len(part.inertia) > 0
    rows = make_dense_rows(2 * total if turning else total, total, size)
    for row in range(total):
        i, j, x, y = contacts.first[row], contacts.second[row], contacts.normal[row, 0], contacts.normal[row, 1]
        rows.bound[row] = contacts.bound[row]
        rows.impulse[row] = contacts.impulse[row] / parameters.time_step
        set_direction(rows, row, (i, j), (x, y), count)
        if turning:
            among_floats = j < count
            rows.friction[row] = part.friction[0] if among_floats else part.friction[1]
            set_direction(rows, total + row, (i, j), (-y, x), count)
            rows.place[total + row, 4] = 2 * count + i
            rows.value[total + row, 4] = -(radius[i] + (0.5 if among_floats else 1.0) * contacts.gap[row])
            if among_floats:
                rows.place[total + row, 5] = 2 * count + j
                rows.value[total + row, 5] = -(radius[j] + 0.5 * contacts.gap[row])
    return rows


@compiled_inside
def set_direction(rows: DenseRows, row: int, pair: tuple[int, int], way: tuple[float, float], count: int) -> None:
    """Write the row of the relative velocity of two bodies in one direction; walls are at rest."""
    i, j = pair
    for axis in range(2):
        rows.place[row, axis], rows.value[row, axis] = 2 * i + axis, -way[axis]
        if j < count:
            rows.place[row, 2 + axis], rows.value[row, 2 + axis] = 2 * j + axis, way[axis]


@compiled
def recall_rubbing(rows: DenseRows, contacts: Contacts, memory: Memory, rubbed: Array, time: float) -> None:
    """Start from the tangential impulses of the previous step, as mean forces."""
    total = contacts.total[0]
    touching.recall_each(touching.contact_keys(contacts), rows.impulse[total:], memory, rubbed)
    for row in range(total):
        rows.impulse[total + row] /= time


@compiled
def keep_impulses(rows: DenseRows, contacts: Contacts, parameters: Parameters, own: CoupledScratch) -> None:
    """Store the impulses of the contacts, and add their forces to those on the floats."""
    for row in range(contacts.total[0]):
        contacts.impulse[row] = parameters.time_step * rows.impulse[row]
    for row in range(len(rows.impulse)):
        for entry in range(mobility_contacts.ENTRIES):
            own.load[rows.place[row, entry]] += rows.value[row, entry] * rows.impulse[row]
