"""Contacts with friction: beside the impulse p along the normal, a tangential one inside Coulomb's cone, |q| <= mu p.

Signorini's and Coulomb's conditions for all contacts at once, as in Moreau's time stepping [moreau1988]: surfaces in
contact stick where an impulse inside the cone can make them, and slide against an impulse on its edge elsewhere. Solved
by the same sweeps and the same conjugate directions as frictionless contacts (`projected_gauss_seidel`), a normal and
a tangential row for each contact in turn.

The tangent is the normal turned counterclockwise, (-n_y, n_x). Both impulses act at the middle of the gap, so that a
pair keeps its angular momentum, spins included, to rounding.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.contact.contacts import Contacts, keyed
from ecume.engine.contact.projected_gauss_seidel import MOST_SWEEPS, PATIENCE, Goal
from ecume.engine.contact.warm_start import Memory, recall_each, remember_each
from ecume.units import Array

CALMER, CALMEST, STALLS = 0.7, 0.1, 8
"""Friction follows from no potential: in braced rafts with mu near 1 sweeps may go in circles. After every so many
looks that find no progress they stop sliding surfaces by less at a time, down to this part, and then wholly again:
slow impulses that creep towards a far solution want haste, circles want calm, and the two look alike.
"""


class Rubbing(NamedTuple):
    """What each contact has along its tangent."""

    friction: Array
    """mu, the coefficient of friction"""
    arm: Array
    """(capacity, 2) m, from the centers of i and of j to where the impulse acts; zero for a wall"""
    weight: Array
    """impulse per sliding speed"""
    impulse: Array
    """q, on j along the tangent"""
    change: Array
    direction: Array
    scratch: Array


class Motion(NamedTuple):
    """What impulses change, and how easily: floats, then walls."""

    velocity: Array
    """(N + walls, 2)"""
    spin: Array
    """(N + walls,) rad/s"""
    mobility: Array
    """(N + walls,) velocity per impulse"""
    ease: Array
    """(N + walls,) spin per angular impulse"""


def make_rubbing(capacity: int) -> Rubbing:
    """Room for `capacity` contacts."""
    return Rubbing(np.zeros(capacity), np.zeros((capacity, 2)), *[np.zeros(capacity) for _ in range(5)])


@compiled
def prepare(
    contacts: Contacts, rubbing: Rubbing, radius: Array, frictions: tuple[float, float], motion: Motion
) -> None:
    """Arms and weights of the contacts that stand there; `frictions` are those between two floats and at walls."""
    count, among, at_walls = len(radius), frictions[0], frictions[1]
    for row in range(contacts.total[0]):
        i, j, gap = contacts.first[row], contacts.second[row], contacts.gap[row]
        among_floats = j < count
        rubbing.friction[row] = among if among_floats else at_walls
        rubbing.arm[row, 0] = radius[i] + (0.5 * gap if among_floats else gap)
        rubbing.arm[row, 1] = radius[j] + 0.5 * gap if among_floats else 0.0
        give = motion.mobility[i] + motion.mobility[j]
        give += rubbing.arm[row, 0] ** 2 * motion.ease[i] + rubbing.arm[row, 1] ** 2 * motion.ease[j]
        rubbing.weight[row] = 1.0 / give if give > 0.0 else 0.0


@compiled
def slidings(contacts: Contacts, rubbing: Rubbing, motion: Motion, speed: Array) -> None:
    """t.(w_j - w_i) of the surfaces of every contact, spins included."""
    first, second, normal, arm = contacts.first, contacts.second, contacts.normal, rubbing.arm
    velocity, spin = motion.velocity, motion.spin
    for row in range(contacts.total[0]):
        i, j = np.uint64(first[row]), np.uint64(second[row])
        along = normal[row, 0] * (velocity[j, 1] - velocity[i, 1])
        along -= normal[row, 1] * (velocity[j, 0] - velocity[i, 0])
        speed[row] = along - arm[row, 0] * spin[i] - arm[row, 1] * spin[j]


@compiled
def push_all(contacts: Contacts, rubbing: Rubbing, impulses: tuple[Array, Array], motion: Motion) -> None:
    """Give each contact these impulses, normal and tangential: equal and opposite ones, and their torques."""
    first, second, normal, arm = contacts.first, contacts.second, contacts.normal, rubbing.arm
    velocity, spin, mobility, ease = motion.velocity, motion.spin, motion.mobility, motion.ease
    along, across = impulses
    for row in range(contacts.total[0]):
        i, j = np.uint64(first[row]), np.uint64(second[row])
        p, q, x, y = along[row], across[row], normal[row, 0], normal[row, 1]
        push_x, push_y = p * x - q * y, p * y + q * x
        velocity[i, 0] -= mobility[i] * push_x
        velocity[i, 1] -= mobility[i] * push_y
        velocity[j, 0] += mobility[j] * push_x
        velocity[j, 1] += mobility[j] * push_y
        spin[i] -= ease[i] * arm[row, 0] * q
        spin[j] -= ease[j] * arm[row, 1] * q


@compiled
def _sweep(contacts: Contacts, rubbing: Rubbing, motion: Motion, eagerness: float) -> float:
    """One Gauss-Seidel sweep over all contacts; the largest change in it, as a relative velocity.

    `eagerness`: the part of what would stop a sliding surface that is done at once.
    """
    first, second, normal, arm = contacts.first, contacts.second, contacts.normal, rubbing.arm
    impulse, bound, weight, change = contacts.impulse, contacts.bound, contacts.weight, contacts.change
    rub, grip, friction, rub_change = rubbing.impulse, rubbing.weight, rubbing.friction, rubbing.change
    velocity, spin, mobility, ease = motion.velocity, motion.spin, motion.mobility, motion.ease
    largest = 0.0
    for row in range(contacts.total[0]):
        i, j = np.uint64(first[row]), np.uint64(second[row])
        x, y, arm_i, arm_j = normal[row, 0], normal[row, 1], arm[row, 0], arm[row, 1]
        apart_x, apart_y = velocity[j, 0] - velocity[i, 0], velocity[j, 1] - velocity[i, 1]
        speed, sliding = x * apart_x + y * apart_y, x * apart_y - y * apart_x - arm_i * spin[i] - arm_j * spin[j]
        new = max(impulse[row] + weight[row] * (bound[row] - speed), 0.0)
        edge = friction[row] * new
        rubbed = min(max(rub[row] - eagerness * grip[row] * sliding, -edge), edge)
        p, q = new - impulse[row], rubbed - rub[row]
        impulse[row], change[row] = new, p
        rub[row], rub_change[row] = rubbed, q
        push_x, push_y = p * x - q * y, p * y + q * x
        velocity[i, 0] -= mobility[i] * push_x
        velocity[i, 1] -= mobility[i] * push_y
        velocity[j, 0] += mobility[j] * push_x
        velocity[j, 1] += mobility[j] * push_y
        spin[i] -= ease[i] * arm_i * q
        spin[j] -= ease[j] * arm_j * q
        turned = ease[i] * arm_i * arm_i + ease[j] * arm_j * arm_j
        largest = max(largest, (mobility[i] + mobility[j]) * abs(p), (mobility[i] + mobility[j] + turned) * abs(q))
    return largest


@compiled
def residual(contacts: Contacts, rubbing: Rubbing, motion: Motion) -> float:
    """By how much the worst contact breaks the conditions (m/s): what one more look at it alone would change."""
    from_normal, sliding = contacts.scratch, rubbing.scratch
    slidings(contacts, rubbing, motion, sliding)
    first, second, normal, velocity = contacts.first, contacts.second, contacts.normal, motion.velocity
    for row in range(contacts.total[0]):
        i, j = np.uint64(first[row]), np.uint64(second[row])
        along = normal[row, 0] * (velocity[j, 0] - velocity[i, 0])
        from_normal[row] = along + normal[row, 1] * (velocity[j, 1] - velocity[i, 1])
    worst = 0.0
    for row in range(contacts.total[0]):
        p, q = contacts.impulse[row], rubbing.impulse[row]
        if contacts.weight[row] > 0.0:
            excess = from_normal[row] - contacts.bound[row]
            worst = max(worst, -excess, min(excess, p / contacts.weight[row]))
        if rubbing.weight[row] > 0.0:
            edge = rubbing.friction[row] * p
            better = min(max(q - rubbing.weight[row] * sliding[row], -edge), edge)
            worst = max(worst, abs(better - q) / rubbing.weight[row])
    return worst


@compiled
def _accelerate(contacts: Contacts, rubbing: Rubbing, motion: Motion, ratio: float) -> None:
    """Go on along the conjugate direction, as frictionless contacts do; p stays positive and q inside its cone."""
    step, rub_step = contacts.scratch, rubbing.scratch
    for row in range(contacts.total[0]):
        along, across = ratio * contacts.direction[row], ratio * rubbing.direction[row]
        old, rubbed = contacts.impulse[row], rubbing.impulse[row]
        contacts.impulse[row] = max(old + along, 0.0)
        edge = rubbing.friction[row] * contacts.impulse[row]
        rubbing.impulse[row] = min(max(rubbed + across, -edge), edge)
        step[row], rub_step[row] = contacts.impulse[row] - old, rubbing.impulse[row] - rubbed
        contacts.direction[row] = along + contacts.change[row]
        rubbing.direction[row] = across + rubbing.change[row]
    if ratio > 0.0:
        push_all(contacts, rubbing, (step, rub_step), motion)


@compiled
def solve(contacts: Contacts, rubbing: Rubbing, motion: Motion, goal: Goal) -> int:
    """Change velocities and spins by the contacts' impulses until the residual is as wanted.

    The impulses that stand in the contacts are the start. Returns the number of sweeps, MOST_SWEEPS + 1 if they were
    not enough.
    """
    push_all(contacts, rubbing, (contacts.impulse, rubbing.impulse), motion)
    for row in range(contacts.total[0]):
        contacts.direction[row], rubbing.direction[row] = 0.0, 0.0
    square_before, residual_before, eagerness, stalls = 0.0, np.inf, 1.0, 0
    for sweep in range(1, MOST_SWEEPS + 1):
        largest = _sweep(contacts, rubbing, motion, eagerness)
        if largest <= goal.wanted and residual(contacts, rubbing, motion) <= goal.wanted:
            return sweep
        if sweep % PATIENCE == 0:
            left = residual(contacts, rubbing, motion)
            if left > 0.5 * residual_before:
                if left <= goal.tolerable:
                    return sweep
                stalls += 1
                if stalls % STALLS == 0:
                    eagerness = CALMER * eagerness if eagerness > CALMEST else 1.0
            residual_before = left
        square = 0.0
        for row in range(contacts.total[0]):
            square += contacts.change[row] ** 2 + rubbing.change[row] ** 2
        ratio = square / square_before if eagerness == 1.0 and 0.0 < square <= square_before else 0.0
        _accelerate(contacts, rubbing, motion, ratio)
        square_before = square
    return MOST_SWEEPS + 1


@compiled
def remember(contacts: Contacts, rubbing: Rubbing, memory: Memory, rubbed: Array) -> None:
    """Keep the tangential impulses of the contacts that `contacts.remember` keeps."""
    remember_each(keyed(contacts), rubbing.impulse, memory, rubbed)


@compiled
def recall(contacts: Contacts, rubbing: Rubbing, memory: Memory, rubbed: Array) -> None:
    """Start from the tangential impulses of the step before."""
    recall_each(keyed(contacts), rubbing.impulse, memory, rubbed)
