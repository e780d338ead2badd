"""Floats that are not round: their constants and workspace, and the forces and torques on the charges inside their
contact lines.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, compiled
from ecume.engine.cells import Integers
from ecume.engine.contact.torque_contacts import OutlinedBodies, TorqueContacts, make_torque_contacts
from ecume.engine.neighbors import NeighborLists
from ecume.engine.outlines import Outlines
from ecume.engine.walls import wall_count
from ecume.laws import capillarity, special
from ecume.laws.capillarity import pair_energy, pair_force
from ecume.models.floating.dishes import acts, wall_energy, wall_force
from ecume.models.floating.parameters import CAPILLARY_LENGTH, CUTOFF, STRENGTH, Parameters
from ecume.models.floating.state import State, Workspace
from ecume.units import Array

admit(special, capillarity)


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
    """the largest number of contact points of two bodies"""


class RigidKicks(NamedTuple):
    """The integrator of bodies with three velocities: along their axis, across it, and spin."""

    inertia: Array
    """(N,) kg m^2"""
    friction: Array
    """(N, 3) see `Shaped`"""


class Outlined(NamedTuple):
    """Contacts between outlines, with lever arms."""

    outlines: Outlines
    places: int
    """the largest number of contact points of two bodies"""
    solved: bool
    """whether contacts are solved"""


class ShapedScratch(NamedTuple):
    """Workspace of all parts of floats with a shape."""

    torque: Array
    """(N,) N m"""
    turning: Array
    """(N, 2) those of the state"""
    at: Array
    """(P, 2) the charges, relative to the centers of their bodies"""
    angle: Array
    """(N,)"""
    corner: Array
    """(V, 2)"""
    mobility: Array
    """(N, 3)"""
    midstep_velocity: Array
    """(N + walls, 3) midstep velocities and spins"""
    before: Array
    """(N + walls, 3)"""
    levers: TorqueContacts


def make_shaped_scratch(shaped: Shaped, parameters: Parameters, state: State, workspace: Workspace) -> ShapedScratch:
    """Return a workspace for as many contacts as the common workspace holds."""
    room = 2 * len(workspace.contacts.first)
    count, rows = len(state.position), len(parameters.kick.mobility)
    return ShapedScratch(
        torque=np.zeros(count),
        turning=state.turning,
        at=np.zeros_like(shaped.place),
        angle=np.zeros(count),
        corner=np.zeros_like(shaped.outlines.corner),
        mobility=np.zeros((count, 3)),
        midstep_velocity=np.zeros((rows, 3)),
        before=np.zeros((rows, 3)),
        levers=make_torque_contacts(room, shaped.places),
    )


@compiled
def solver_bodies(part: Outlined, parameters: Parameters, own: ShapedScratch) -> OutlinedBodies:
    """Return the data of shapes and walls for the contact solver."""
    return OutlinedBodies(part.outlines, parameters.floats.radius, parameters.walls, own.mobility)


@compiled
def store_angles(own: ShapedScratch, state: State) -> None:
    """Store the angles in the state."""
    for i in range(len(state.turning)):
        state.turning[i, 0] = own.angle[i]


@compiled
def turn_charges(shaped: Shaped, turning: Array, at: Array) -> None:
    """Rotate the charges by the angles of their bodies."""
    for i in range(len(turning)):
        c, s = math.cos(turning[i, 0]), math.sin(turning[i, 0])
        for p in range(shaped.first[i], shaped.first[i + 1]):
            x, y = shaped.place[p, 0], shaped.place[p, 1]
            at[p, 0], at[p, 1] = c * x - s * y, s * x + c * y


@compiled
def body_pair_forces(
    shaped: Shaped, parameters: Parameters, at: Array, pair: tuple[int, int], apart: tuple[float, float]
) -> tuple[float, float, float, float]:
    """The force on the first of two bodies (the second is displaced by `apart`), and the torques on both."""
    (i, j), (x, y) = pair, apart
    unit, length = parameters.pair[STRENGTH], parameters.pair[CAPILLARY_LENGTH]
    force_x, force_y, torque_i, torque_j = 0.0, 0.0, 0.0, 0.0
    for p in range(shaped.first[i], shaped.first[i + 1]):
        on_x, on_y = 0.0, 0.0
        for q in range(shaped.first[j], shaped.first[j + 1]):
            to_x, to_y = x + at[q, 0] - at[p, 0], y + at[q, 1] - at[p, 1]
            distance = math.sqrt(to_x * to_x + to_y * to_y)
            pull = -pair_force(distance, unit * shaped.charge[p] * shaped.charge[q], length) / distance
            on_x += pull * to_x
            on_y += pull * to_y
            torque_j -= pull * (at[q, 0] * to_y - at[q, 1] * to_x)
        torque_i += at[p, 0] * on_y - at[p, 1] * on_x
        force_x += on_x
        force_y += on_y
    return force_x, force_y, torque_i, torque_j


@compiled
def add_wall_forces(shaped: Shaped, parameters: Parameters, position: Array, own: ShapedScratch, force: Array) -> None:
    """Add the forces of the wall menisci on each charge."""
    for i in range(len(position)):
        for p in range(shaped.first[i], shaped.first[i + 1]):
            place = (position[i, 0] + own.at[p, 0], position[i, 1] + own.at[p, 1])
            for number in range(wall_count(parameters.walls)):
                away, in_x, in_y = wall_force(
                    parameters, number, place, shaped.wall_strength[number, p], shaped.charge[p]
                )
                force[i, 0] += away * in_x
                force[i, 1] += away * in_y
                own.torque[i] += away * (own.at[p, 0] * in_y - own.at[p, 1] * in_x)


@compiled
def shaped_forces(
    shaped: Shaped, own: ShapedScratch, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
) -> None:
    """Add the forces on all bodies, and compute the torques; each pair once, so that they cancel to rounding."""
    cutoff = parameters.pair[CUTOFF]
    turn_charges(shaped, own.turning, own.at)
    own.torque[:] = 0.0
    order, first, neighbor = lists.cells.order, lists.rows.first, lists.rows.neighbor
    for slot in range(len(order) if parameters.pair[STRENGTH] != 0.0 else 0):
        i = order[slot]
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
            if i < j and x * x + y * y < cutoff * cutoff:
                force_x, force_y, torque_i, torque_j = body_pair_forces(shaped, parameters, own.at, (i, j), (x, y))
                force[i, 0] += force_x
                force[i, 1] += force_y
                force[j, 0] -= force_x
                force[j, 1] -= force_y
                own.torque[i] += torque_i
                own.torque[j] += torque_j
    if acts(parameters):
        add_wall_forces(shaped, parameters, position, own, force)


@compiled
def energy_of_pair(
    shaped: Shaped, parameters: Parameters, at: Array, pair: tuple[int, int], apart: tuple[float, float]
) -> float:
    """The energy of two bodies (J), minus that of their charges at the cutoff."""
    (i, j), (x, y) = pair, apart
    unit, length, cutoff = parameters.pair[STRENGTH], parameters.pair[CAPILLARY_LENGTH], parameters.pair[CUTOFF]
    total = 0.0
    for p in range(shaped.first[i], shaped.first[i + 1]):
        for q in range(shaped.first[j], shaped.first[j + 1]):
            distance = math.sqrt((x + at[q, 0] - at[p, 0]) ** 2 + (y + at[q, 1] - at[p, 1]) ** 2)
            strength = unit * shaped.charge[p] * shaped.charge[q]
            total += pair_energy(distance, strength, length) - pair_energy(cutoff, strength, length)
    return total


@compiled
def shaped_energies(
    shaped: Shaped, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """Energies of all pairs and of all walls (J)."""
    cutoff = parameters.pair[CUTOFF]
    walls, lists = parameters.walls, workspace.lists
    turn_charges(shaped, state.turning, own.at)
    order, first, neighbor = lists.cells.order, lists.rows.first, lists.rows.neighbor
    pairs, at_walls = 0.0, 0.0
    for slot in range(len(order)):
        i = order[slot]
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            x, y = state.position[j, 0] - state.position[i, 0], state.position[j, 1] - state.position[i, 1]
            if i < j and x * x + y * y < cutoff * cutoff and parameters.pair[STRENGTH] != 0.0:
                pairs += energy_of_pair(shaped, parameters, own.at, (i, j), (x, y))
        for p in range(shaped.first[i], shaped.first[i + 1]):
            at = (state.position[i, 0] + own.at[p, 0], state.position[i, 1] + own.at[p, 1])
            for number in range(wall_count(walls) if acts(parameters) else 0):
                at_walls += wall_energy(parameters, number, at, shaped.wall_strength[number, p], shaped.charge[p])[0]
    return pairs, at_walls
