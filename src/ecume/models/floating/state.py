"""What the physics moves, and the scratch beside it."""

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
"""Places in `State.tally`."""


class State(NamedTuple):
    """Everything that can change a later bit."""

    position: Array
    """(N, 2) m"""
    velocity: Array
    """(N, 2) m/s"""
    step: Integers
    """(1,)"""
    reference: Array
    """(N, 2) where everyone was when the neighbor lists were made: their order decides the order of sums"""
    touches: Integers
    """(1,) how many contacts are remembered"""
    touching: Integers
    """(4 N + 16, 2) who touches whom; a wall number k stands as N + k"""
    push: Array
    """(4 N + 16,) impulses of these contacts: the next step starts from them"""
    rub: Array
    """(4 N + 16,) those along the surfaces; (0,) where they are smooth"""
    amplitudes: Array
    """(N, 2 (order + 1)) real and imaginary parts of the floats' multipoles: the next solution starts from them; (N, 0)
    where superposition rules
    """
    turning: Array
    """(N, 2) angle (rad) and spin (rad/s) of floats that turn; (N, 0) where none does"""
    tally: Array
    """collisions, contact sweeps, steps whose contacts did not converge, deepest overlap so far (m), and the work
    done from outside (J)"""


class Workspace(NamedTuple):
    """Scratch; a new one gives the same results."""

    lists: neighbors.NeighborLists
    candidates: contacts.Candidates
    contacts: contacts.Contacts
    force: Array
    """(N, 2) N, at the present positions"""
    midstep_velocity: Array
    """(N + walls, 2) m/s: the velocity with which everyone goes through this step; walls stand still"""
    before: Array
    """(N + walls, 2) m/s: what the passage was before contacts"""
    restitution: Array
    """(N,) of each float in a collision"""
    stages: Array
    """(5, N, 2) of the Runge-Kutta scheme"""
    travel: Array
    """(1,) m: how far anyone may go in this step"""
    ready: Integers
    """(1,) whether `force` holds at the present positions"""
    scratch: Any = ()
    """the `Scratch` of the parts; empty in the workspace that compiled code gets"""


def make_state(position: Array, velocity: Array) -> State:
    """At time 0; parts may replace the empty arrays by their own."""
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
"""Neighbors of a float that a first workspace has room for."""


def make_workspace(parameters: Parameters, state: State, room: float) -> Workspace:
    """Room for a crowd about as dense as the present one; the march asks for more when that is too little."""
    count = len(state.position)
    walls = len(parameters.kick.mobility) - count
    pairs = int(room * (24 * count + 64))
    return Workspace(
        lists=neighbors.make_lists(count, 2, int(room * count * min(count, FIRST_GUESS))),
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
    """Straight on. The passage has a row more than there are floats where a dish stands around them: its own."""
    for i in range(min(position.shape[0], velocity.shape[0])):
        position[i, 0] += time * velocity[i, 0]
        position[i, 1] += time * velocity[i, 1]


@compiled
def copy_rows(target: Array, source: Array) -> None:
    """The first rows of one become those of the other."""
    for i in range(min(target.shape[0], source.shape[0])):
        target[i, 0], target[i, 1] = source[i, 0], source[i, 1]


@compiled
def clear(rows: Array) -> None:
    """All zero."""
    for i in range(rows.shape[0]):
        rows[i, 0], rows[i, 1] = 0.0, 0.0


@compiled
def add_rows(to: Array, others: Array) -> None:
    """Add rows to as many others."""
    for i in range(len(to)):
        to[i, 0] += others[i, 0]
        to[i, 1] += others[i, 1]
