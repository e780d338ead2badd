"""Impulses solved for all touching pairs at once.

Moreau's and Jean's time stepping: the unknowns are the impulses p >= 0 of a step, the conditions are
n.(w_j - w_i) >= bound where p > 0 only if it is an equality. `w` is the velocity with which particles will go through
the step, so that with bound = -gap/dt nobody ends up inside another: contacts are seen before they happen. Solved by
projected Gauss-Seidel sweeps, sped up by the nonsmooth conjugate gradient of Silcowitz-Hansen, Niebe & Erleben (2010),
until the residual is small enough - however many sweeps that takes: a count of sweeps instead lets large rafts creep
into themselves.

Sweeps leave out contacts that hang together with none that pushes: nothing moves there, so that no bit depends on it,
and a loose crowd, of which few collide at a time, is solved ten times as fast.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.engine.contacts import Contacts, approaches, push_all
from ecume.units import Array

MOST_SWEEPS = 20_000
PATIENCE = 128
"""Sweeps after which the residual should have halved."""
CONVERGED = 1e-7
"""The residual wanted, as a fraction of the fastest approach that the contacts have to stop."""
MANY = 64
"""Among fewer contacts nobody looks for those that can be left out."""
WAVES = 8
"""How often contacts are gone through to find who hangs together with whom: longer chains are not worth it."""


@compiled
def _stirred(contacts: Contacts, mobility: Array) -> Integers:
    """Rows that hang together, by bodies that can be moved, with one that pushes or pushed in the last sweep; or all.
    In the others nothing would change, however often they are gone through.
    """
    first, second, impulse, change = contacts.first, contacts.second, contacts.impulse, contacts.change
    moved, spreads, found = np.zeros(len(mobility), np.bool_), True, 0
    for row in range(contacts.total[0]):
        if impulse[row] != 0.0 or change[row] != 0.0:
            moved[first[row]], moved[second[row]] = mobility[first[row]] > 0.0, mobility[second[row]] > 0.0
    for _ in range(WAVES):
        spreads = False
        for row in range(contacts.total[0]):
            i, j = first[row], second[row]
            if moved[i] != moved[j] and mobility[i] > 0.0 and mobility[j] > 0.0:
                moved[i], moved[j], spreads = True, True, True
        if not spreads:
            break
    rows = np.empty(contacts.total[0], np.int64)
    for row in range(contacts.total[0]):
        rows[found] = row
        found += 1 if spreads or moved[first[row]] or moved[second[row]] else 0
    return rows[:found]


@compiled
def _some(contacts: Contacts, rows: Integers) -> Contacts:
    """Some contacts by themselves, so that loops find them side by side."""
    real = np.zeros((7, len(rows)))
    gap, bound, weight, impulse, change = real[0], real[1], real[2], real[3], real[4]
    first, second, normal = np.empty(len(rows), np.int64), np.empty(len(rows), np.int64), np.empty((len(rows), 2))
    for place in range(len(rows)):
        row = rows[place]
        first[place], second[place] = contacts.first[row], contacts.second[row]
        normal[place, 0], normal[place, 1] = contacts.normal[row, 0], contacts.normal[row, 1]
        gap[place], bound[place], weight[place] = contacts.gap[row], contacts.bound[row], contacts.weight[row]
        impulse[place], change[place] = contacts.impulse[row], contacts.change[row]
    total = np.full(1, len(rows))
    return Contacts(total, first, second, normal, gap, bound, weight, impulse, change, real[5], real[6])


@compiled
def _sweep(contacts: Contacts, velocity: Array, mobility: Array) -> float:
    """One Gauss-Seidel sweep over all contacts; the largest change in it, as a relative velocity."""
    first, second, normal = contacts.first, contacts.second, contacts.normal
    impulse, bound, weight, change = contacts.impulse, contacts.bound, contacts.weight, contacts.change
    largest = 0.0
    for row in range(contacts.total[0]):
        i, j = np.uint64(first[row]), np.uint64(second[row])
        x, y = normal[row, 0], normal[row, 1]
        speed = x * (velocity[j, 0] - velocity[i, 0]) + y * (velocity[j, 1] - velocity[i, 1])
        new = max(impulse[row] + weight[row] * (bound[row] - speed), 0.0)
        step = new - impulse[row]
        impulse[row], change[row] = new, step
        on_i, on_j = mobility[i] * step, mobility[j] * step
        velocity[i, 0] -= on_i * x
        velocity[i, 1] -= on_i * y
        velocity[j, 0] += on_j * x
        velocity[j, 1] += on_j * y
        largest = max(largest, abs(on_i) + abs(on_j))
    return largest


@compiled
def residual(contacts: Contacts, velocity: Array) -> float:
    """By how much the worst contact breaks the conditions (m/s): it lets through, or pushes what leaves."""
    speed, impulse, bound, weight = contacts.scratch, contacts.impulse, contacts.bound, contacts.weight
    approaches(contacts, velocity, speed)
    worst = 0.0
    for row in range(contacts.total[0]):
        if weight[row] > 0.0:
            excess = speed[row] - bound[row]
            worst = max(worst, -excess, min(excess, impulse[row] / weight[row]))
    return worst


@compiled
def _accelerate(contacts: Contacts, velocity: Array, mobility: Array, ratio: float) -> None:
    """Go on along the conjugate direction: p += ratio * d, kept positive; d = ratio * d + the change of the last
    sweep.
    """
    impulse, change, direction, step = contacts.impulse, contacts.change, contacts.direction, contacts.scratch
    for row in range(contacts.total[0]):
        along, old = ratio * direction[row], impulse[row]
        impulse[row] = max(old + along, 0.0)
        step[row] = impulse[row] - old
        direction[row] = along + change[row]
    if ratio > 0.0:
        push_all(contacts, step, velocity, mobility)


class Goal(NamedTuple):
    """When impulses are good enough, as residuals (m/s)."""

    wanted: float
    tolerable: float
    """good enough once more sweeps do not help"""


@compiled
def solve(contacts: Contacts, velocity: Array, mobility: Array, goal: Goal) -> int:
    """Change `velocity` by the contacts' impulses until the residual is as wanted.

    The impulses that stand in the contacts are the start. Returns the number of sweeps, MOST_SWEEPS + 1 if they were
    not enough.
    """
    push_all(contacts, contacts.impulse, velocity, mobility)
    largest = _sweep(contacts, velocity, mobility)
    if largest <= goal.wanted and residual(contacts, velocity) <= goal.wanted:
        return 1
    if contacts.total[0] >= MANY:
        rows = _stirred(contacts, mobility)
        if 2 * len(rows) < contacts.total[0]:
            few = _some(contacts, rows)
            sweeps = _go_on(few, velocity, mobility, goal)
            for place in range(len(rows)):
                contacts.impulse[rows[place]] = few.impulse[place]
            return sweeps
    return _go_on(contacts, velocity, mobility, goal)


@compiled
def _go_on(contacts: Contacts, velocity: Array, mobility: Array, goal: Goal) -> int:
    """All sweeps but the first."""
    for row in range(contacts.total[0]):
        contacts.direction[row] = 0.0
    square_before, residual_before = 0.0, np.inf
    for sweep in range(1, MOST_SWEEPS):
        square = 0.0
        for row in range(contacts.total[0]):
            square += contacts.change[row] ** 2
        # A gradient that grows means that contacts opened or closed: forget the direction.
        ratio = square / square_before if 0.0 < square <= square_before else 0.0
        _accelerate(contacts, velocity, mobility, ratio)
        square_before = square
        largest = _sweep(contacts, velocity, mobility)
        if largest <= goal.wanted and residual(contacts, velocity) <= goal.wanted:
            return sweep + 1
        if (sweep + 1) % PATIENCE == 0:
            # In a raft braced more than it needs, gaps that disagree in the last digits leave impulses that creep for
            # ever along a direction in which no velocity changes.
            left = residual(contacts, velocity)
            if left <= goal.tolerable and left > 0.5 * residual_before:
                return sweep + 1
            residual_before = left
    return MOST_SWEEPS + 1
