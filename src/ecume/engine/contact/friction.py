"""Contacts with Coulomb friction: a normal impulse p and a tangential one q in the friction cone, |q| <= mu p.

Signorini's and Coulomb's conditions for all contacts at once, as in Moreau's time stepping [moreau1988]: surfaces in
contact stick if an impulse inside the cone can stop them, and otherwise slide against an impulse on its edge. The
solver is `impulse_solvers`; each contact has one normal and one tangential row.

The tangent is the normal rotated counterclockwise, (-n_y, n_x). Both impulses act at the middle of the gap, so that the
angular momentum of a pair, spins included, is conserved to rounding.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.engine.contact import contacts as touching
from ecume.engine.contact.contacts import Contacts, Memory, busy_contacts, contact_keys
from ecume.engine.contact.islands import Islands, islands_among
from ecume.units import Array


class FrictionRows(NamedTuple):
    """The tangential row of each contact."""

    friction: Array
    """mu, the coefficient of friction"""
    arm: Array
    """(capacity, 2) m, lever arms: from the centers of i and j to the point of the impulse; zero for a wall"""
    weight: Array
    """effective mass: impulse per sliding speed"""
    impulse: Array
    """q, on j along the tangent"""
    change: Array
    direction: Array
    scratch: Array


class FrictionalContacts(NamedTuple):
    """The normal and the tangential rows of all contacts."""

    contacts: Contacts
    tangential: FrictionRows


class Motion(NamedTuple):
    """Velocities and mobilities of all bodies: discs, then walls."""

    velocity: Array
    """(N + walls, 2)"""
    spin: Array
    """(N + walls,) rad/s"""
    mobility: Array
    """(N + walls,) velocity per impulse"""
    spin_mobility: Array
    """(N + walls,) spin per angular impulse: the inverse moment of inertia, reduced by drag"""


Frictions = tuple[tuple[float, float], tuple[float, float]]
"""The coefficients of friction between two discs and at walls, and those of rolling friction."""


def make_friction_rows(capacity: int) -> FrictionRows:
    """Empty arrays for `capacity` contacts."""
    return FrictionRows(np.zeros(capacity), np.zeros((capacity, 2)), *[np.zeros(capacity) for _ in range(5)])


@compiled
def prepare(system: FrictionalContacts, radius: Array, frictions: Frictions, motion: Motion) -> None:
    """Set coefficients, lever arms and effective masses."""
    (contacts, rows), count, (among, at_walls) = system, len(radius), frictions[0]
    for row in range(contacts.total[0]):
        i, j, gap = contacts.first[row], contacts.second[row], contacts.gap[row]
        among_floats = j < count
        rows.friction[row] = among if among_floats else at_walls
        rows.arm[row, 0] = radius[i] + (0.5 * gap if among_floats else gap)
        rows.arm[row, 1] = radius[j] + 0.5 * gap if among_floats else 0.0
        inverse = motion.mobility[i] + motion.mobility[j]
        inverse += rows.arm[row, 0] ** 2 * motion.spin_mobility[i] + rows.arm[row, 1] ** 2 * motion.spin_mobility[j]
        rows.weight[row] = 1.0 / inverse if inverse > 0.0 else 0.0


@compiled
def apply_impulses(
    contacts: Contacts, rows: FrictionRows, some: Integers, impulses: tuple[Array, Array], motion: Motion
) -> None:
    """Apply normal and tangential impulses of some contacts to both bodies, equal and opposite, with torques."""
    first, second, normal, arm = contacts.first, contacts.second, contacts.normal, rows.arm
    velocity, spin, mobility, spin_mobility = motion.velocity, motion.spin, motion.mobility, motion.spin_mobility
    along, across = impulses
    for row in some:
        i, j = np.uint64(first[row]), np.uint64(second[row])
        p, q, x, y = along[row], across[row], normal[row, 0], normal[row, 1]
        push_x, push_y = p * x - q * y, p * y + q * x
        velocity[i, 0] -= mobility[i] * push_x
        velocity[i, 1] -= mobility[i] * push_y
        velocity[j, 0] += mobility[j] * push_x
        velocity[j, 1] += mobility[j] * push_y
        spin[i] -= spin_mobility[i] * arm[row, 0] * q
        spin[j] -= spin_mobility[j] * arm[row, 1] * q


@compiled
def start(system: FrictionalContacts, motion: Motion) -> int:
    """Change the motion by the initial impulses; return the number of contacts."""
    contacts, rows = system
    total = int(contacts.total[0])
    apply_impulses(contacts, rows, np.arange(total), (contacts.impulse, rows.impulse), motion)
    return total


@compiled
def sweep(system: FrictionalContacts, motion: Motion, some: Integers, relaxation: float) -> float:
    """Perform one projected Gauss-Seidel sweep over some contacts. Returns the largest change, as a
    relative velocity.

    `relaxation` is the relaxation factor of the tangential rows.
    """
    contacts, rows = system
    first, second, normal, arm = contacts.first, contacts.second, contacts.normal, rows.arm
    impulse, bound, weight, change = contacts.impulse, contacts.bound, contacts.weight, contacts.change
    tangential, tangential_mass, friction, tangential_change = rows.impulse, rows.weight, rows.friction, rows.change
    velocity, spin, mobility, spin_mobility = motion.velocity, motion.spin, motion.mobility, motion.spin_mobility
    largest = 0.0
    for row in some:
        i, j = np.uint64(first[row]), np.uint64(second[row])
        x, y, arm_i, arm_j = normal[row, 0], normal[row, 1], arm[row, 0], arm[row, 1]
        apart_x, apart_y = velocity[j, 0] - velocity[i, 0], velocity[j, 1] - velocity[i, 1]
        speed, sliding = x * apart_x + y * apart_y, x * apart_y - y * apart_x - arm_i * spin[i] - arm_j * spin[j]
        new = max(impulse[row] + weight[row] * (bound[row] - speed), 0.0)
        edge = friction[row] * new
        tangential_impulse = min(max(tangential[row] - relaxation * tangential_mass[row] * sliding, -edge), edge)
        p, q = new - impulse[row], tangential_impulse - tangential[row]
        impulse[row], change[row] = new, p
        tangential[row], tangential_change[row] = tangential_impulse, q
        push_x, push_y = p * x - q * y, p * y + q * x
        velocity[i, 0] -= mobility[i] * push_x
        velocity[i, 1] -= mobility[i] * push_y
        velocity[j, 0] += mobility[j] * push_x
        velocity[j, 1] += mobility[j] * push_y
        spin[i] -= spin_mobility[i] * arm_i * q
        spin[j] -= spin_mobility[j] * arm_j * q
        turned = spin_mobility[i] * arm_i * arm_i + spin_mobility[j] * arm_j * arm_j
        largest = max(largest, (mobility[i] + mobility[j]) * abs(p), (mobility[i] + mobility[j] + turned) * abs(q))
    return largest


@compiled
def residual(system: FrictionalContacts, motion: Motion, some: Integers) -> float:
    """The largest violation of the conditions (m/s): the change by one more local solve of a contact."""
    contacts, rows = system
    first, second, normal, arm = contacts.first, contacts.second, contacts.normal, rows.arm
    impulse, bound, weight = contacts.impulse, contacts.bound, contacts.weight
    tangential, tangential_mass, friction = rows.impulse, rows.weight, rows.friction
    velocity, spin, worst = motion.velocity, motion.spin, 0.0
    for row in some:
        i, j = np.uint64(first[row]), np.uint64(second[row])
        x, y, p, q = normal[row, 0], normal[row, 1], impulse[row], tangential[row]
        apart_x, apart_y = velocity[j, 0] - velocity[i, 0], velocity[j, 1] - velocity[i, 1]
        if weight[row] > 0.0:
            excess = x * apart_x + y * apart_y - bound[row]
            worst = max(worst, -excess, min(excess, p / weight[row]))
        if tangential_mass[row] > 0.0:
            sliding = x * apart_y - y * apart_x - arm[row, 0] * spin[i] - arm[row, 1] * spin[j]
            edge = friction[row] * p
            better = min(max(q - tangential_mass[row] * sliding, -edge), edge)
            worst = max(worst, abs(better - q) / tangential_mass[row])
    return worst


@compiled
def accelerate(system: FrictionalContacts, motion: Motion, some: Integers, ratio: float) -> None:
    """Step along the conjugate direction; p is projected to p >= 0 and q to the friction cone."""
    contacts, rows = system
    step, tangential_step = contacts.scratch, rows.scratch
    for row in some:
        along, across = ratio * contacts.direction[row], ratio * rows.direction[row]
        old, tangential_impulse = contacts.impulse[row], rows.impulse[row]
        contacts.impulse[row] = max(old + along, 0.0)
        edge = rows.friction[row] * contacts.impulse[row]
        rows.impulse[row] = min(max(tangential_impulse + across, -edge), edge)
        step[row], tangential_step[row] = contacts.impulse[row] - old, rows.impulse[row] - tangential_impulse
        contacts.direction[row] = along + contacts.change[row]
        rows.direction[row] = across + rows.change[row]
    if ratio > 0.0:
        apply_impulses(contacts, rows, some, (step, tangential_step), motion)


@compiled
def restart(system: FrictionalContacts, some: Integers) -> None:
    """Set the conjugate direction of some contacts to zero."""
    for row in some:
        system.contacts.direction[row], system.tangential.direction[row] = 0.0, 0.0


@compiled
def square(system: FrictionalContacts, some: Integers) -> float:
    """The square of the last changes of some impulses."""
    total = 0.0
    for row in some:
        total += system.contacts.change[row] ** 2 + system.tangential.change[row] ** 2
    return total


@compiled
def islands(system: FrictionalContacts, motion: Motion) -> Islands:
    """The islands with an impulse or a change. A tangential impulse requires a normal one."""
    contacts = system.contacts
    return islands_among(contacts.first, contacts.second, busy_contacts(contacts), motion.mobility)


RELAXATION, LEAST_RELAXATION = 0.7, 0.1
"""Friction has no potential: in overconstrained rafts with mu near 1 the sweeps may cycle. Where they make no progress,
the relaxation factor of the tangential rows is multiplied by RELAXATION, down to LEAST_RELAXATION, and then reset to 1:
slow convergence needs a large factor, cycles need a small one, and the residual does not distinguish them.
"""


@compiled
def relaxed(system: Any, relaxation: float) -> float:
    """The next relaxation factor of the tangential rows, of any type."""
    return RELAXATION * relaxation if relaxation > LEAST_RELAXATION else 1.0


@compiled
def scale(system: FrictionalContacts, factor: Array) -> None:
    """Multiply the tangential impulses by factors."""
    scale_each(system.tangential.impulse, factor)


@compiled
def scale_each(impulse: Array, factor: Array) -> None:
    """Multiply impulses by factors; a factor of zero gives zero for any impulse."""
    for row in range(len(factor)):
        impulse[row] = factor[row] * impulse[row] if factor[row] != 0.0 else 0.0


@compiled
def remember(system: FrictionalContacts, memory: Memory, kept: Array) -> None:
    """Store the tangential impulses of the contacts whose normal impulses are stored."""
    touching.remember(contact_keys(system.contacts), system.tangential.impulse, memory, kept)


@compiled
def recall(system: FrictionalContacts, memory: Memory, kept: Array) -> None:
    """Set the tangential impulses to those of the previous step."""
    touching.recall(contact_keys(system.contacts), system.tangential.impulse, memory, kept)
