"""Contacts of bodies that rotate: Jacobian rows for velocities and spins, and the passes of the solver over them.

The conditions are those of `contacts`, for generalized velocities w = (v_x, v_y, spin): each contact is a Jacobian row
J of six numbers, three for each body, with J w >= bound, and the response M^-1 J^T of both bodies to a unit impulse.
The solver is `impulse_solvers`. In a viscous liquid a body has different mobilities along its axis and across it.
Impulses act along the line through both nearest points, so that momentum and angular momentum are conserved to
rounding.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.engine.contact.active_set import numbered
from ecume.engine.contact.contacts import Candidates, ContactKeys, busy_contacts
from ecume.engine.contact.islands import Islands, islands_among
from ecume.engine.outlines import NEARNESS, Outlines, Stance, between, bodies_near, turn_corners, wall_near
from ecume.engine.walls import Walls, wall_count
from ecume.units import Array

FEATURES = 4096
"""An upper bound of the number of features (corner and edge) at which two bodies can be near."""


class TorqueContacts(NamedTuple):
    """Contacts of one time step, ordered by i, then j, then feature. Wall number k is partner N + k."""

    total: Integers
    """(1,)"""
    first: Integers
    """(capacity,) i"""
    second: Integers
    """(capacity,) j, or N + wall"""
    place: Integers
    """(capacity,) the partner and the feature (corner and edge) as one number: j FEATURES + feature"""
    gap: Array
    jacobian: Array
    """(capacity, 6) J: the rate of the gap per velocity and spin of i and j"""
    response: Array
    """(capacity, 6) M^-1 J^T: the change of these by a unit impulse"""
    root: Array
    """(capacity, 6) M^(-1/2) J^T, whose square is J M^-1 J^T: in the axes of each body"""
    bound: Array
    """lower bound of J w"""
    weight: Array
    """effective mass 1/(J M^-1 J^T): impulse per relative velocity"""
    impulse: Array
    change: Array
    direction: Array
    scratch: Array
    near: Array
    """(places, NEARNESS) scratch for one pair"""


class OutlinedBodies(NamedTuple):
    """Bodies that may touch: outlines, walls, and mobilities."""

    outlines: Outlines
    radius: Array
    """(N,) of the bounding circle"""
    walls: Walls
    mobility: Array
    """(N, 3) velocity per impulse along the body, across it, and spin per angular impulse"""
    passing: bool = False
    """whether bodies pass through one another; walls stop them all the same"""


def make_torque_contacts(capacity: int, places: int) -> TorqueContacts:
    """Empty arrays for `capacity` contacts, and for `places` features of one pair."""
    of_row = "gap", "bound", "weight", "impulse", "change", "direction", "scratch"
    return TorqueContacts(
        total=np.zeros(1, np.int64),
        first=np.zeros(capacity, np.int64),
        second=np.zeros(capacity, np.int64),
        place=np.zeros(capacity, np.int64),
        jacobian=np.zeros((capacity, 6)),
        response=np.zeros((capacity, 6)),
        root=np.zeros((capacity, 6)),
        near=np.zeros((places, NEARNESS)),
        **{name: np.zeros(capacity) for name in of_row},
    )


@compiled
def impulse_response(mobility: Array, angle: float, jacobian: Array, response: Array, root: Array) -> float:
    """Write the response M^-1 J^T of one body to a unit impulse, and its root; return its part of J M^-1 J^T."""
    c, s = math.cos(angle), math.sin(angle)
    along, across = c * jacobian[0] + s * jacobian[1], c * jacobian[1] - s * jacobian[0]
    fast, slow = mobility[0] * along, mobility[1] * across
    response[0], response[1], response[2] = c * fast - s * slow, s * fast + c * slow, mobility[2] * jacobian[2]
    root[0], root[1] = math.sqrt(mobility[0]) * along, math.sqrt(mobility[1]) * across
    root[2] = math.sqrt(mobility[2]) * jacobian[2]
    return float(fast * along + slow * across + mobility[2] * jacobian[2] * jacobian[2])


@compiled
def write_row(
    contacts: TorqueContacts, row: int, pair: tuple[int, int], near: Array, stance: Stance, mobility: Array
) -> None:
    """Store one near feature of two bodies as a contact: gap, Jacobian row, response and effective mass."""
    i, j = pair
    contacts.first[row], contacts.second[row], contacts.place[row] = i, j, j * FEATURES + int(near[7])
    contacts.gap[row] = near[0]
    jacobian, response, root = contacts.jacobian[row], contacts.response[row], contacts.root[row]
    to_x, to_y = near[1], near[2]
    jacobian[0], jacobian[1], jacobian[2] = -to_x, -to_y, near[4] * to_x - near[3] * to_y
    way = impulse_response(mobility[i], stance.angle[i], jacobian[:3], response[:3], root[:3])
    response[3:] = 0.0
    root[3:] = 0.0
    # Walls move, but do not turn.
    jacobian[3], jacobian[4], jacobian[5] = to_x, to_y, 0.0
    if j < len(stance.angle):
        jacobian[5] = near[5] * to_y - near[6] * to_x
        way += impulse_response(mobility[j], stance.angle[j], jacobian[3:], response[3:], root[3:])
    contacts.weight[row] = 1.0 / way if way > 0.0 else 0.0


@compiled
def gather(
    contacts: TorqueContacts, candidates: Candidates, stance: Stance, bodies: OutlinedBodies, reach: float
) -> bool:
    """Find all features with a gap below `reach`. False if the capacity is too small."""
    position, near, found, room = stance.position, contacts.near, 0, len(contacts.first)
    count, walls = len(position), wall_count(bodies.walls)
    turn_corners(bodies.outlines, stance)
    for i in range(count):
        pairs = 0 if bodies.passing else candidates.first[i + 1] - candidates.first[i]
        for place in range(pairs + walls):
            if place < pairs:
                j = candidates.partner[candidates.first[i] + place]
                x, y = between(stance, i, j)
                within = bodies.radius[i] + bodies.radius[j] + reach
                here = 0 if x * x + y * y > within * within else bodies_near(
                    bodies.outlines, stance, i, j, reach, near
                )  # fmt: skip
            else:
                j = count + place - pairs
                here = wall_near(bodies.outlines, stance, bodies.walls, (i, place - pairs), reach, near)
            if found + here > room:
                contacts.total[0] = found
                return False
            for k in range(here):
                write_row(contacts, found, (i, j), near[k], stance, bodies.mobility)
                found += 1
    contacts.total[0] = found
    return True


@compiled
def contact_keys(contacts: TorqueContacts) -> ContactKeys:
    """The bodies and the feature of each contact, as keys of the warm start."""
    return ContactKeys(contacts.total, contacts.first, contacts.place, contacts.impulse)


@compiled
def normal_velocities(contacts: TorqueContacts, velocity: Array, speed: Array) -> None:
    """Relative normal velocity J w of each contact; negative for approach."""
    first, second, jac = contacts.first, contacts.second, contacts.jacobian
    for row in range(contacts.total[0]):
        i, j = first[row], second[row]
        closing = jac[row, 0] * velocity[i, 0] + jac[row, 1] * velocity[i, 1] + jac[row, 2] * velocity[i, 2]
        closing += jac[row, 3] * velocity[j, 0] + jac[row, 4] * velocity[j, 1] + jac[row, 5] * velocity[j, 2]
        speed[row] = closing


@compiled
def apply_impulses(contacts: TorqueContacts, some: Integers, impulse: Array, velocity: Array) -> None:
    """Apply the impulses of some contacts to both bodies."""
    first, second, response = contacts.first, contacts.second, contacts.response
    for row in some:
        i, j, push = first[row], second[row], impulse[row]
        for axis in range(3):
            velocity[i, axis] += response[row, axis] * push
            velocity[j, axis] += response[row, 3 + axis] * push


@compiled
def start(contacts: TorqueContacts, velocity: Array) -> int:
    """Change the velocities by the initial impulses; return the number of contacts."""
    total = int(contacts.total[0])
    apply_impulses(contacts, np.arange(total), contacts.impulse, velocity)
    return total


@compiled
def sweep(contacts: TorqueContacts, velocity: Array, some: Integers, relaxation: float) -> float:
    """Perform one projected Gauss-Seidel sweep over some contacts. Returns the largest change, as a
    relative velocity.
    """
    first, second, jac, response = contacts.first, contacts.second, contacts.jacobian, contacts.response
    impulse, bound, weight, change = contacts.impulse, contacts.bound, contacts.weight, contacts.change
    largest = 0.0
    for row in some:
        i, j = first[row], second[row]
        speed = jac[row, 0] * velocity[i, 0] + jac[row, 1] * velocity[i, 1] + jac[row, 2] * velocity[i, 2]
        speed += jac[row, 3] * velocity[j, 0] + jac[row, 4] * velocity[j, 1] + jac[row, 5] * velocity[j, 2]
        new = max(impulse[row] + weight[row] * (bound[row] - speed), 0.0)
        step = new - impulse[row]
        impulse[row], change[row] = new, step
        for axis in range(3):
            velocity[i, axis] += response[row, axis] * step
            velocity[j, axis] += response[row, 3 + axis] * step
        if weight[row] > 0.0:
            largest = max(largest, abs(step) / weight[row])
    return largest


@compiled
def residual(contacts: TorqueContacts, velocity: Array, some: Integers) -> float:
    """The largest violation of the complementarity conditions (m/s): penetration, or impulse on separating bodies."""
    first, second, jac, worst = contacts.first, contacts.second, contacts.jacobian, 0.0
    for row in some:
        i, j = first[row], second[row]
        speed = jac[row, 0] * velocity[i, 0] + jac[row, 1] * velocity[i, 1] + jac[row, 2] * velocity[i, 2]
        speed += jac[row, 3] * velocity[j, 0] + jac[row, 4] * velocity[j, 1] + jac[row, 5] * velocity[j, 2]
        if contacts.weight[row] > 0.0:
            excess = speed - contacts.bound[row]
            worst = max(worst, -excess, min(excess, contacts.impulse[row] / contacts.weight[row]))
    return worst


@compiled
def accelerate(contacts: TorqueContacts, velocity: Array, some: Integers, ratio: float) -> None:
    """Step along the conjugate direction: see `impulse_solvers`."""
    impulse, change, direction, step = contacts.impulse, contacts.change, contacts.direction, contacts.scratch
    for row in some:
        along, old = ratio * direction[row], impulse[row]
        impulse[row] = max(old + along, 0.0)
        step[row] = impulse[row] - old
        direction[row] = along + change[row]
    if ratio > 0.0:
        apply_impulses(contacts, some, step, velocity)


@compiled
def islands(contacts: TorqueContacts, velocity: Array) -> Islands:
    """The islands with an impulse or a change."""
    moves = np.zeros(len(velocity))
    for row in range(contacts.total[0]):
        for axis in range(3):
            moves[contacts.first[row]] += abs(contacts.response[row, axis])
            moves[contacts.second[row]] += abs(contacts.response[row, 3 + axis])
    return islands_among(contacts.first, contacts.second, busy_contacts(contacts), moves)


@compiled
def normal_velocity(contacts: TorqueContacts, velocity: Array, row: int) -> float:
    """Relative normal velocity J w of a contact."""
    i, j, speed = contacts.first[row], contacts.second[row], 0.0
    for axis in range(3):
        speed += contacts.jacobian[row, axis] * velocity[i, axis] + contacts.jacobian[row, 3 + axis] * velocity[j, axis]
    return speed


@compiled
def add_impulse(contacts: TorqueContacts, velocity: Array, row: int, impulse: float) -> None:
    """Change the velocities and spins by an impulse of one contact."""
    i, j = contacts.first[row], contacts.second[row]
    for axis in range(3):
        velocity[i, axis] += contacts.response[row, axis] * impulse
        velocity[j, axis] += contacts.response[row, 3 + axis] * impulse


@compiled
def columns(contacts: TorqueContacts, velocity: Array, rows: Integers) -> Array:
    """The responses to unit impulses in the norm of kinetic energy: see `contacts.columns`."""
    first, second, root = contacts.first, contacts.second, contacts.root
    place, bodies = numbered(np.append(first[rows], second[rows]), len(velocity))
    matrix = np.zeros((3 * bodies + 1, len(rows)))
    for k in range(len(rows)):
        for axis in range(3):
            matrix[3 * place[first[rows[k]]] + axis, k] = root[rows[k], axis]
            matrix[3 * place[second[rows[k]]] + axis, k] += root[rows[k], 3 + axis]
    return matrix
