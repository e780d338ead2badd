"""Contacts with friction and rolling resistance: `engine.contact.rolling` for floats.

The solves are those of friction in `collisions`, with a couple for each contact. Where no couple is chosen, no code of
this file is compiled.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.contact import contacts as touching
from ecume.engine.contact import friction as coulomb
from ecume.engine.contact import rolling, sweeps
from ecume.engine.contact.contacts import Bodies, Contacts
from ecume.engine.contact.friction import FrictionalContacts, FrictionRows, Motion
from ecume.engine.contact.impulse_solvers import Tolerance
from ecume.engine.contact.rolling import RollingContacts, RollingRows
from ecume.models.floating.parameters import Parameters, State, Workspace, memory_of
from ecume.units import Array


class RollingFriction(NamedTuple):
    """Constants of contacts with friction and rolling resistance: those of `collisions.Friction`, and `rolling`."""

    friction: tuple[float, float]
    """coefficients of friction between two floats, and at walls"""
    inertia: Array
    """(N,) kg m^2"""
    decay: Array
    """(N,) the fraction of a spin that remains after the drag of one kick"""
    spin_mobility: Array
    """(N + walls,) spin per angular impulse during one kick"""
    overlapping: bool
    """see `impulse_solvers.Impulses`"""
    rolling: tuple[float, float]
    """coefficients of rolling friction between two floats, and at walls"""


class BrownianRollingFriction(RollingFriction):
    """The same of Brownian floats."""


class RollingScratch(NamedTuple):
    """Workspace of contacts with rolling resistance."""

    friction_rows: FrictionRows
    rolling_rows: RollingRows
    spin: Array
    """(N + walls,) rad/s, during this step; walls do not turn"""
    before: Array
    """(N + walls,) rad/s, before contacts"""


def make_rolling_scratch(
    part: RollingFriction, parameters: Parameters, state: State, workspace: Workspace
) -> RollingScratch:
    """Return a workspace for as many contacts as the common workspace holds."""
    count, capacity = len(parameters.kick.mobility), len(workspace.contacts.gap)
    rows = coulomb.make_friction_rows(capacity), rolling.make_rolling_rows(capacity)
    return RollingScratch(*rows, np.zeros(count), np.zeros(count))


@compiled
def solve_with_rolling(
    part: RollingFriction, scratch: RollingScratch, bodies: Bodies, contacts: Contacts, motion: Motion, goal: Tolerance
) -> int:
    """Solve contacts with couples for these velocities and spins; return the number of sweeps."""
    touching.set_effective_masses(contacts, bodies.mobility)
    coulomb.prepare(contacts, scratch.friction_rows, bodies.radius, part.friction, motion)
    rolling.prepare(contacts, scratch.rolling_rows, bodies.radius, part.rolling, motion)
    system = RollingContacts(FrictionalContacts(contacts, scratch.friction_rows), scratch.rolling_rows)
    return sweeps.solve(system, motion, goal)


@compiled
def stop_with_rolling(
    part: RollingFriction, scratch: RollingScratch, bodies: Bodies, contacts: Contacts, velocity: Array, goal: Tolerance
) -> int:
    """Stop all relative motion, starting from zero impulses; return the number of sweeps."""
    for row in range(contacts.total[0]):
        scratch.friction_rows.impulse[row] = 0.0
        scratch.rolling_rows.impulse[row] = 0.0
    motion = Motion(velocity, scratch.before, bodies.mobility, part.spin_mobility)
    return solve_with_rolling(part, scratch, bodies, contacts, motion, goal)


@compiled
def push_with_rolling(
    part: RollingFriction, scratch: RollingScratch, bodies: Bodies, contacts: Contacts, midstep_velocity: Array
) -> None:
    """Apply the impulses and couples of collisions to the midstep velocities and the spins."""
    for row in range(contacts.total[0]):
        contacts.impulse[row] *= contacts.scratch[row]
        scratch.friction_rows.impulse[row] *= contacts.scratch[row]
        scratch.rolling_rows.impulse[row] *= contacts.scratch[row]
    motion = Motion(midstep_velocity, scratch.spin, bodies.mobility, part.spin_mobility)
    system = RollingContacts(FrictionalContacts(contacts, scratch.friction_rows), scratch.rolling_rows)
    rolling.start(system, motion)


@compiled
def continue_with_rolling(
    part: RollingFriction, scratch: RollingScratch, bodies: Bodies, contacts: Contacts, velocity: Array, goal: Tolerance
) -> int:
    """Solve for velocities and spins, starting from the stored impulses; return the number of sweeps."""
    motion = Motion(velocity, scratch.spin, bodies.mobility, part.spin_mobility)
    return solve_with_rolling(part, scratch, bodies, contacts, motion, goal)


@compiled
def recall_rolling(part: RollingFriction, scratch: RollingScratch, state: State, workspace: Workspace) -> None:
    """Start from the tangential impulses and couples of the previous step."""
    half = len(state.contact_impulse)
    contacts, memory, kept = workspace.contacts, memory_of(state), state.friction_impulse
    coulomb.recall(contacts, scratch.friction_rows, memory, kept[:half])
    rolling.recall(contacts, scratch.rolling_rows, memory, kept[half:])


@compiled
def remember_rolling(part: RollingFriction, scratch: RollingScratch, state: State, workspace: Workspace) -> None:
    """Store the tangential impulses and couples for the next step."""
    half = len(state.contact_impulse)
    contacts, memory, kept = workspace.contacts, memory_of(state), state.friction_impulse
    coulomb.remember(contacts, scratch.friction_rows, memory, kept[:half])
    rolling.remember(contacts, scratch.rolling_rows, memory, kept[half:])
