"""Contacts with rolling resistance: a torque between two surfaces in contact, limited by the normal impulse.

In addition to the impulses p and q of `friction`, each contact transmits an angular impulse R* r, a couple that is
equal and opposite on the two bodies, with |r| <= mu_r p and the effective radius R* = R_i R_j/(R_i + R_j); at a wall R*
= R_i. Bodies do not rotate relative to each other if a couple within this limit can prevent it; otherwise the couple
opposes the relative spin with its largest value: the constant directional torque of [ai2011] as a complementarity
condition, like Coulomb's. r has the unit of an impulse, and R* (spin_j - spin_i) that of a velocity, so that all rows
have the same tolerance.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.engine.contact import contacts as touching
from ecume.engine.contact import friction
from ecume.engine.contact.contacts import Contacts, Memory, contact_keys
from ecume.engine.contact.friction import FrictionalContacts, Frictions, Motion
from ecume.engine.contact.islands import Islands
from ecume.units import Array


class RollingRows(NamedTuple):
    """The couple of each contact."""

    friction: Array
    """mu_r, the coefficient of rolling friction"""
    arm: Array
    """R*, the effective radius (m)"""
    weight: Array
    """effective mass: impulse per R* times relative spin"""
    impulse: Array
    """r: the couple R* r acts on j, its opposite on i"""
    change: Array
    direction: Array
    scratch: Array


class RollingContacts(NamedTuple):
    """The normal, the tangential and the rolling rows of all contacts."""

    sliding: FrictionalContacts
    rolling: RollingRows


def make_rolling_rows(capacity: int) -> RollingRows:
    """Empty arrays for `capacity` contacts."""
    return RollingRows(*[np.zeros(capacity) for _ in range(7)])


@compiled
def prepare(system: RollingContacts, radius: Array, frictions: Frictions, motion: Motion) -> None:
    """Set coefficients, lever arms, effective radii and masses."""
    friction.prepare(system.sliding, radius, frictions, motion)
    contacts, rows, count, (among, at_walls) = system.sliding.contacts, system.rolling, len(radius), frictions[1]
    for row in range(contacts.total[0]):
        i, j = contacts.first[row], contacts.second[row]
        if j < count:
            rows.friction[row], rows.arm[row] = among, radius[i] * radius[j] / (radius[i] + radius[j])
        else:
            rows.friction[row], rows.arm[row] = at_walls, radius[i]
        inverse = rows.arm[row] ** 2 * (motion.spin_mobility[i] + motion.spin_mobility[j])
        rows.weight[row] = 1.0 / inverse if inverse > 0.0 else 0.0


@compiled
def apply_couples(contacts: Contacts, rows: RollingRows, some: Integers, impulse: Array, motion: Motion) -> None:
    """Apply the couples of some contacts to both bodies, equal and opposite."""
    for row in some:
        i, j, couple = contacts.first[row], contacts.second[row], rows.arm[row] * impulse[row]
        motion.spin[i] -= motion.spin_mobility[i] * couple
        motion.spin[j] += motion.spin_mobility[j] * couple


@compiled
def start(system: RollingContacts, motion: Motion) -> int:
    """Change the motion by the initial impulses; return the number of contacts."""
    total = friction.start(system.sliding, motion)
    apply_couples(system.sliding.contacts, system.rolling, np.arange(total), system.rolling.impulse, motion)
    return total


@compiled
def sweep(system: RollingContacts, motion: Motion, some: Integers, relaxation: float) -> float:
    """Perform one projected Gauss-Seidel sweep over some contacts: their impulses, then their couples. Returns the
    largest change, as a relative velocity.
    """
    contacts, rows = system.sliding.contacts, system.rolling
    largest = friction.sweep(system.sliding, motion, some, relaxation)
    first, second, normal_impulse = contacts.first, contacts.second, contacts.impulse
    arm, weight, limit, impulse, change = rows.arm, rows.weight, rows.friction, rows.impulse, rows.change
    spin, spin_mobility = motion.spin, motion.spin_mobility
    for row in some:
        i, j = np.uint64(first[row]), np.uint64(second[row])
        turning, edge = arm[row] * (spin[j] - spin[i]), limit[row] * normal_impulse[row]
        new = min(max(impulse[row] - relaxation * weight[row] * turning, -edge), edge)
        r = new - impulse[row]
        impulse[row], change[row] = new, r
        spin[i] -= spin_mobility[i] * arm[row] * r
        spin[j] += spin_mobility[j] * arm[row] * r
        if weight[row] > 0.0:
            largest = max(largest, abs(r) / weight[row])
    return largest


@compiled
def residual(system: RollingContacts, motion: Motion, some: Integers) -> float:
    """The largest violation of the conditions (m/s): the change by one more local solve of a contact."""
    contacts, rows = system.sliding.contacts, system.rolling
    worst = friction.residual(system.sliding, motion, some)
    for row in some:
        if rows.weight[row] > 0.0:
            i, j, r = contacts.first[row], contacts.second[row], rows.impulse[row]
            edge = rows.friction[row] * contacts.impulse[row]
            turning = rows.arm[row] * (motion.spin[j] - motion.spin[i])
            better = min(max(r - rows.weight[row] * turning, -edge), edge)
            worst = max(worst, abs(better - r) / rows.weight[row])
    return worst


@compiled
def accelerate(system: RollingContacts, motion: Motion, some: Integers, ratio: float) -> None:
    """Step along the conjugate direction; r is projected to its limit at the new normal impulse."""
    friction.accelerate(system.sliding, motion, some, ratio)
    contacts, rows = system.sliding.contacts, system.rolling
    for row in some:
        turned, old = ratio * rows.direction[row], rows.impulse[row]
        edge = rows.friction[row] * contacts.impulse[row]
        rows.impulse[row] = min(max(old + turned, -edge), edge)
        rows.scratch[row] = rows.impulse[row] - old
        rows.direction[row] = turned + rows.change[row]
    if ratio > 0.0:
        apply_couples(contacts, rows, some, rows.scratch, motion)


@compiled
def restart(system: RollingContacts, some: Integers) -> None:
    """Set the conjugate direction of some contacts to zero."""
    friction.restart(system.sliding, some)
    for row in some:
        system.rolling.direction[row] = 0.0


@compiled
def square(system: RollingContacts, some: Integers) -> float:
    """The square of the last changes of some impulses."""
    total = friction.square(system.sliding, some)
    for row in some:
        total += system.rolling.change[row] ** 2
    return total


@compiled
def islands(system: RollingContacts, motion: Motion) -> Islands:
    """The islands with an impulse or a change: a couple requires a normal impulse."""
    return friction.islands(system.sliding, motion)


@compiled
def scale(system: RollingContacts, factor: Array) -> None:
    """Multiply the tangential impulses and the couples by factors."""
    friction.scale(system.sliding, factor)
    friction.scale_each(system.rolling.impulse, factor)


@compiled
def remember(system: RollingContacts, memory: Memory, kept: Array) -> None:
    """Keep the tangential impulses, and behind them the couples, of the contacts whose normal impulses are kept."""
    half = len(kept) // 2
    friction.remember(system.sliding, memory, kept[:half])
    touching.remember(contact_keys(system.sliding.contacts), system.rolling.impulse, memory, kept[half:])


@compiled
def recall(system: RollingContacts, memory: Memory, kept: Array) -> None:
    """Set the tangential impulses and the couples to those of the previous step."""
    half = len(kept) // 2
    friction.recall(system.sliding, memory, kept[:half])
    touching.recall(contact_keys(system.sliding.contacts), system.rolling.impulse, memory, kept[half:])
