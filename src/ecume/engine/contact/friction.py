"""Contacts with Coulomb friction: a normal impulse p and a tangential one q in the friction cone, |q| <= mu p.

Signorini's and Coulomb's conditions for all contacts at once, as in Moreau's time stepping [moreau1988]: surfaces in
contact stick if an impulse inside the cone can stop them, and otherwise slide against an impulse on its edge. The
solver is that of frictionless contacts (`impulse_solvers`), the same sweeps and conjugate directions, with one
normal and one tangential row for each contact.

The tangent is the normal rotated counterclockwise, (-n_y, n_x). Both impulses act at the middle of the gap, so that the
angular momentum of a pair, spins included, is conserved to rounding.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.contact.contacts import Contacts, Memory, contact_keys, recall_each, remember_each
from ecume.engine.contact.impulse_solvers import MOST_SWEEPS, PATIENCE, Tolerance
from ecume.units import Array

RELAXATION, LEAST_RELAXATION, STALLS = 0.7, 0.1, 8
"""Friction has no potential: in overconstrained rafts with mu near 1 the sweeps may cycle. After STALLS checks without
progress the relaxation factor of the tangential rows is multiplied by RELAXATION, down to LEAST_RELAXATION, and then
reset to 1: slow convergence needs a large factor, cycles need a small one, and the residual does not distinguish them.
"""


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


def make_friction_rows(capacity: int) -> FrictionRows:
    """Empty arrays for `capacity` contacts."""
    return FrictionRows(np.zeros(capacity), np.zeros((capacity, 2)), *[np.zeros(capacity) for _ in range(5)])


@compiled
def prepare(
    contacts: Contacts, rows: FrictionRows, radius: Array, frictions: tuple[float, float], motion: Motion
) -> None:
    """Set lever arms and effective masses; `frictions` are the coefficients between two discs and at walls."""
    count, among, at_walls = len(radius), frictions[0], frictions[1]
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
def tangential_velocities(contacts: Contacts, rows: FrictionRows, motion: Motion, speed: Array) -> None:
    """Relative tangential velocity of the two surfaces of each contact, spins included."""
    first, second, normal, arm = contacts.first, contacts.second, contacts.normal, rows.arm
    velocity, spin = motion.velocity, motion.spin
    for row in range(contacts.total[0]):
        i, j = np.uint64(first[row]), np.uint64(second[row])
        along = normal[row, 0] * (velocity[j, 1] - velocity[i, 1])
        along -= normal[row, 1] * (velocity[j, 0] - velocity[i, 0])
        speed[row] = along - arm[row, 0] * spin[i] - arm[row, 1] * spin[j]


@compiled
def apply_impulses(contacts: Contacts, rows: FrictionRows, impulses: tuple[Array, Array], motion: Motion) -> None:
    """Apply the normal and tangential impulses to both bodies of each contact, equal and opposite, with torques."""
    first, second, normal, arm = contacts.first, contacts.second, contacts.normal, rows.arm
    velocity, spin, mobility, spin_mobility = motion.velocity, motion.spin, motion.mobility, motion.spin_mobility
    along, across = impulses
    for row in range(contacts.total[0]):
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
def _sweep(contacts: Contacts, rows: FrictionRows, motion: Motion, relaxation: float) -> float:
    """One projected Gauss-Seidel sweep over all contacts; returns the largest change, as a relative velocity.

    `relaxation` is the relaxation factor of the tangential rows.
    """
    first, second, normal, arm = contacts.first, contacts.second, contacts.normal, rows.arm
    impulse, bound, weight, change = contacts.impulse, contacts.bound, contacts.weight, contacts.change
    tangential, tangential_mass, friction, tangential_change = rows.impulse, rows.weight, rows.friction, rows.change
    velocity, spin, mobility, spin_mobility = motion.velocity, motion.spin, motion.mobility, motion.spin_mobility
    largest = 0.0
    for row in range(contacts.total[0]):
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
def residual(contacts: Contacts, rows: FrictionRows, motion: Motion) -> float:
    """The largest violation of the conditions (m/s): the change by one more local solve of the contact."""
    from_normal, sliding = contacts.scratch, rows.scratch
    tangential_velocities(contacts, rows, motion, sliding)
    first, second, normal, velocity = contacts.first, contacts.second, contacts.normal, motion.velocity
    for row in range(contacts.total[0]):
        i, j = np.uint64(first[row]), np.uint64(second[row])
        along = normal[row, 0] * (velocity[j, 0] - velocity[i, 0])
        from_normal[row] = along + normal[row, 1] * (velocity[j, 1] - velocity[i, 1])
    worst = 0.0
    for row in range(contacts.total[0]):
        p, q = contacts.impulse[row], rows.impulse[row]
        if contacts.weight[row] > 0.0:
            excess = from_normal[row] - contacts.bound[row]
            worst = max(worst, -excess, min(excess, p / contacts.weight[row]))
        if rows.weight[row] > 0.0:
            edge = rows.friction[row] * p
            better = min(max(q - rows.weight[row] * sliding[row], -edge), edge)
            worst = max(worst, abs(better - q) / rows.weight[row])
    return worst


@compiled
def _accelerate(contacts: Contacts, rows: FrictionRows, motion: Motion, ratio: float) -> None:
    """Step along the conjugate direction; p is projected to p >= 0 and q to the friction cone."""
    step, tangential_step = contacts.scratch, rows.scratch
    for row in range(contacts.total[0]):
        along, across = ratio * contacts.direction[row], ratio * rows.direction[row]
        old, tangential_impulse = contacts.impulse[row], rows.impulse[row]
        contacts.impulse[row] = max(old + along, 0.0)
        edge = rows.friction[row] * contacts.impulse[row]
        rows.impulse[row] = min(max(tangential_impulse + across, -edge), edge)
        step[row], tangential_step[row] = contacts.impulse[row] - old, rows.impulse[row] - tangential_impulse
        contacts.direction[row] = along + contacts.change[row]
        rows.direction[row] = across + rows.change[row]
    if ratio > 0.0:
        apply_impulses(contacts, rows, (step, tangential_step), motion)


@compiled
def solve(contacts: Contacts, rows: FrictionRows, motion: Motion, tolerance: Tolerance) -> int:
    """Solve for the impulses and change velocities and spins by them, until the residual is below the goal.

    The initial guess is in `contacts` and `rows`. Returns the number of sweeps, MOST_SWEEPS + 1 without convergence.
    """
    apply_impulses(contacts, rows, (contacts.impulse, rows.impulse), motion)
    for row in range(contacts.total[0]):
        contacts.direction[row], rows.direction[row] = 0.0, 0.0
    square_before, residual_before, relaxation, stalls = 0.0, np.inf, 1.0, 0
    for sweep in range(1, MOST_SWEEPS + 1):
        largest = _sweep(contacts, rows, motion, relaxation)
        if largest <= tolerance.target and residual(contacts, rows, motion) <= tolerance.target:
            return sweep
        if sweep % PATIENCE == 0:
            left = residual(contacts, rows, motion)
            if left > 0.5 * residual_before:
                if left <= tolerance.acceptable:
                    return sweep
                stalls += 1
                if stalls % STALLS == 0:
                    relaxation = RELAXATION * relaxation if relaxation > LEAST_RELAXATION else 1.0
            residual_before = left
        square = 0.0
        for row in range(contacts.total[0]):
            square += contacts.change[row] ** 2 + rows.change[row] ** 2
        ratio = square / square_before if relaxation == 1.0 and 0.0 < square <= square_before else 0.0
        _accelerate(contacts, rows, motion, ratio)
        square_before = square
    return MOST_SWEEPS + 1


@compiled
def remember(contacts: Contacts, rows: FrictionRows, memory: Memory, tangential_impulse: Array) -> None:
    """Keep the tangential impulses of the contacts that `contacts.remember` keeps."""
    remember_each(contact_keys(contacts), rows.impulse, memory, tangential_impulse)


@compiled
def recall(contacts: Contacts, rows: FrictionRows, memory: Memory, tangential_impulse: Array) -> None:
    """Set the tangential impulses to those of the previous step."""
    recall_each(contact_keys(contacts), rows.impulse, memory, tangential_impulse)
