"""What never changes about shapes while they move, and the scratch of their march."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.engine.contact.torque_contacts import OutlinedBodies, TorqueContacts, make_torque_contacts
from ecume.engine.outlines import Outlines
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.state import State, Workspace
from ecume.units import Array


class Shaped(NamedTuple):
    """Outlines, charges, inertia and friction of all floats."""

    outlines: Outlines
    place: Array
    """(P, 2) of the charges, in each body's own frame (m)"""
    charge: Array
    """(P,) m"""
    first: Integers
    """(N + 1,) the charges of body i are first[i] to first[i + 1]"""
    wall_strength: Array
    """(walls, P) J"""
    inertia: Array
    """(N,) kg m^2"""
    friction: Array
    """(N, 3) along and across each body (N s/m), against turning (N m s)"""
    places: int
    """at how many places two may be near"""


class RigidKicks(NamedTuple):
    """The integrator of bodies with three velocities: along themselves, across, and their spin."""

    inertia: Array
    """(N,) kg m^2"""
    friction: Array
    """(N, 3) see `Shaped`"""


class Outlined(NamedTuple):
    """Contacts of bodies that touch as what they are, with levers."""

    outlines: Outlines
    places: int
    """at how many places two may be near"""
    solved: bool
    """whether contacts do anything"""


class Crew(NamedTuple):
    """Scratch of all parts of floats with a shape."""

    torque: Array
    """(N,) N m"""
    turning: Array
    """(N, 2) that of the state"""
    at: Array
    """(P, 2) the charges, as seen from the center of each one's body"""
    angle: Array
    """(N,)"""
    corner: Array
    """(V, 2)"""
    mobility: Array
    """(N, 3)"""
    passage: Array
    """(N + walls, 3) velocity and spin with which everyone goes through this step"""
    before: Array
    """(N + walls, 3)"""
    levers: TorqueContacts


def make_crew(many: Shaped, parameters: Parameters, state: State, workspace: Workspace) -> Crew:
    """Scratch with room for as many contacts as the workspace has."""
    room = 2 * len(workspace.contacts.first)
    count, rows = len(state.position), len(parameters.kick.mobility)
    return Crew(
        torque=np.zeros(count),
        turning=state.turning,
        at=np.zeros_like(many.place),
        angle=np.zeros(count),
        corner=np.zeros_like(many.outlines.corner),
        mobility=np.zeros((count, 3)),
        passage=np.zeros((rows, 3)),
        before=np.zeros((rows, 3)),
        levers=make_torque_contacts(room, many.places),
    )


@compiled
def party_of(part: Outlined, parameters: Parameters, crew: Crew) -> OutlinedBodies:
    """What the contact solver must know of shapes and walls."""
    return OutlinedBodies(part.outlines, parameters.floats.radius, parameters.walls, crew.mobility)


@compiled
def store_angles(crew: Crew, state: State) -> None:
    """The angles become those of the state."""
    for i in range(len(state.turning)):
        state.turning[i, 0] = crew.angle[i]
