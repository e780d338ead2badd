"""The state, which the physics changes, the workspace, and operations on rows of vectors."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine import neighbors
from ecume.engine.cells import Integers
from ecume.engine.contact import contacts
from ecume.models.floating.parameters import Parameters
from ecume.units import Array

COLLISIONS, SWEEPS, UNCONVERGED, DEEPEST, WORK = range(5)
"""Indices of `State.tally`."""


class State(NamedTuple):
    """All data that affect later bits."""

    position: Array
    """(N, 2) m"""
    velocity: Array
    """(N, 2) m/s"""
    step: Integers
    """(1,)"""
    reference: Array
    """(N, 2) the positions at which the neighbor lists were made: they determine the order of sums"""
    touches: Integers
    """(1,) number of stored contacts"""
    touching: Integers
    """(4 N + 16, 2) the stored contacts (i, j); wall number k is N + k"""
    push: Array
    """(4 N + 16,) impulses of these contacts, from which the next solve starts"""
    rub: Array
    """(4 N + 16,) tangential impulses; (0,) without friction"""
    amplitudes: Array
    """(N, 2 (order + 1)) real and imaginary parts of the multipoles, from which the next solution starts; (N, 0)
    without multipoles
    """
    turning: Array
    """(N, 2) angle (rad) and spin (rad/s) of floats that turn; (N, 0) if no float turns"""
    tally: Array
    """collisions, contact sweeps, steps whose contacts did not converge, deepest overlap so far (m), and the work
    done from outside (J)"""
    active: Array = np.zeros((0, 3))
    """(N, 3) the random force on each active float along x and y, over its root mean square, and the heading (rad);
    (0, 3) without activity"""


class Workspace(NamedTuple):
    """Scratch memory; a new one gives the same results."""

    lists: neighbors.NeighborLists
    candidates: contacts.Candidates
    contacts: contacts.Contacts
    force: Array
    """(N, 2) N, at the current positions"""
    midstep_velocity: Array
    """(N + walls, 2) m/s: displacement over time step; zero for walls"""
    before: Array
    """(N + walls, 2) m/s: the midstep velocity before contacts"""
    restitution: Array
    """(N,) the restitution of each float in a collision"""
    stages: Array
    """(5, N, 2) of the Runge-Kutta scheme"""
    travel: Array
    """(1,) m: the longest possible displacement in this step"""
    ready: Integers
    """(1,) whether `force` is valid at the current positions"""
    scratch: Any = ()
    """the `Scratch` of the parts; empty in the workspace that compiled code gets"""


def make_state(position: Array, velocity: Array) -> State:
    """Return a state at time 0; parts may replace the empty arrays."""
    count = len(position)
    return State(
        position=np.array(position, dtype=np.float64),
        velocity=np.array(velocity, dtype=np.float64),
        step=np.zeros(1, np.int64),
        reference=np.array(position, dtype=np.float64),
        touches=np.zeros(1, np.int64),
        touching=np.zeros((4 * count + 16, 2), np.int64),
        push=np.zeros(4 * count + 16),
        rub=np.zeros(0),
        amplitudes=np.zeros((count, 0)),
        turning=np.zeros((count, 0)),
        tally=np.zeros(5),
    )


FIRST_GUESS = 64
"""Number of neighbors per float for which a first workspace has room."""


def make_workspace(parameters: Parameters, state: State, room: float) -> Workspace:
    """Allocate a workspace for about the current density; the run allocates more if this is too little."""
    count = len(state.position)
    walls = len(parameters.kick.mobility) - count
    pairs = int(room * (24 * count + 64))
    return Workspace(
        lists=neighbors.make_lists(count, 2, int(room * count * min(count, FIRST_GUESS)), parameters.periods),
        candidates=contacts.make_candidates(count, pairs),
        contacts=contacts.make_contacts(pairs + count * walls),
        force=np.zeros((count, 2)),
        midstep_velocity=np.zeros((count + walls, 2)),
        before=np.zeros((count + walls, 2)),
        restitution=np.zeros(count),
        stages=np.zeros((5, count, 2)),
        travel=np.zeros(1),
        ready=np.zeros(1, np.int64),
    )


@compiled
def advance_rows(position: Array, velocity: Array, time: float) -> None:
    """Add `time` times the velocities to the positions. Midstep velocities have additional rows for walls."""
    for i in range(min(position.shape[0], velocity.shape[0])):
        position[i, 0] += time * velocity[i, 0]
        position[i, 1] += time * velocity[i, 1]


@compiled
def copy_rows(target: Array, source: Array) -> None:
    """Copy the first rows of `source` to `target`."""
    for i in range(min(target.shape[0], source.shape[0])):
        target[i, 0], target[i, 1] = source[i, 0], source[i, 1]


@compiled
def clear(rows: Array) -> None:
    """Set all rows to zero."""
    for i in range(rows.shape[0]):
        rows[i, 0], rows[i, 1] = 0.0, 0.0


@compiled
def add_rows(to: Array, others: Array) -> None:
    """Add the first rows of `others` to the rows of `to`."""
    for i in range(len(to)):
        to[i, 0] += others[i, 0]
        to[i, 1] += others[i, 1]
