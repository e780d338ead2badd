"""Projected Gauss-Seidel sweeps: the impulses of all touching pairs at once.

Moreau's and Jean's time stepping: the unknowns are the impulses p >= 0 of a step, the conditions are
n.(w_j - w_i) >= bound where p > 0 only if it is an equality. `w` is the velocity with which particles will go through
the step, so that with bound = -gap/dt nobody ends up inside another: contacts are seen before they happen. Solved by
projected Gauss-Seidel sweeps, sped up by the nonsmooth conjugate gradient of Silcowitz-Hansen, Niebe & Erleben (2010),
until the residual is small enough - however many sweeps that takes: a count of sweeps instead lets large rafts creep
into themselves.

Contacts that hang together, by bodies that can be moved, are an island, and what happens on one is nothing to the
others: each is swept by itself, as often as it takes, and one on which nobody pushes not at all. In a loose crowd,
where most islands are pairs, all else would wait for the largest.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume.engine.cells import Integers
from ecume.engine.contact import active_set
from ecume.engine.contact.contacts import Contacts, push_all
from ecume.units import Array

MOST_SWEEPS = 20_000
PATIENCE = 128
"""Sweeps after which the residual should have halved."""
CONVERGED = 1e-7
"""The residual wanted, as a fraction of the fastest approach that the contacts have to stop."""
ENOUGH = 4_000
"""Sweeps after which a small island is solved by an active-set method instead."""
MANY = 64
"""Fewer contacts are taken for one island."""


Span = tuple[int, int]
"""Contacts from one up to another."""
Who = tuple[Integers, Integers, Array]
"""first, second, normal"""
Push = tuple[Array, Array, Array, Array, Array, Array]
"""impulse, bound, weight, change, direction, scratch"""
Motion = tuple[Array, Array]
"""velocity, mobility"""


@compiled_inside
def who_of(contacts: Contacts) -> Who:
    """Who touches whom, as loops take it."""
    return contacts.first, contacts.second, contacts.normal


@compiled_inside
def push_of(contacts: Contacts) -> Push:
    """How they push."""
    c = contacts
    return c.impulse, c.bound, c.weight, c.change, c.direction, c.scratch


class Islands(NamedTuple):
    """Contacts island by island, ascending on each; those on which somebody pushes, or pushed in the last sweep."""

    rows: Integers
    """(n,)"""
    first: Integers
    """(islands + 1,) where each begins"""


# In the loops below every array gets a name of its own, and none is handed to a function that is not written out in
# place: see `ecume.engine.contact.contacts`.


@compiled
def islands_of(contacts: Contacts, mobility: Array) -> Islands:
    """Who hangs together. Islands stand in the order of their lowest bodies."""
    total, impulse, change = contacts.total[0], contacts.impulse, contacts.change
    island = _named(contacts.first[:total], contacts.second[:total], mobility)
    stirs, ends = np.zeros(len(mobility), np.bool_), np.zeros(len(mobility) + 1, np.int64)
    for row in range(total):
        if impulse[row] != 0.0 or change[row] != 0.0:
            stirs[island[row]] = True
    for row in range(total):
        ends[island[row] + 1] += 1 if stirs[island[row]] else 0
    first, islands = np.zeros(len(mobility) + 1, np.int64), 0
    for name in range(len(mobility)):
        if ends[name + 1] > 0:
            islands += 1
            first[islands] = first[islands - 1] + ends[name + 1]
        ends[name + 1] += ends[name]
    rows = np.empty(first[islands], np.int64)
    for row in range(total):
        name = island[row]
        if stirs[name]:
            rows[ends[name]] = row
            ends[name] += 1
    return Islands(rows, first[: islands + 1])


@compiled
def _named(first: Integers, second: Integers, mobility: Array) -> Integers:
    """The island of each contact, by the lowest body there: ways to it are halved whenever they are gone."""
    parent = np.arange(len(mobility))
    for row in range(len(first)):
        i, j = first[row], second[row]
        if mobility[i] > 0.0 and mobility[j] > 0.0:
            while parent[i] != i:
                parent[i] = parent[parent[i]]
                i = parent[i]
            while parent[j] != j:
                parent[j] = parent[parent[j]]
                j = parent[j]
            parent[max(i, j)] = min(i, j)
    # A parent is never higher than its child.
    for i in range(len(mobility)):
        parent[i] = parent[parent[i]]
    island = np.empty(len(first), np.int64)
    for row in range(len(first)):
        island[row] = parent[first[row]] if mobility[first[row]] > 0.0 else parent[second[row]]
    return island


@compiled
def some_contacts(contacts: Contacts, rows: Integers) -> Contacts:
    """Some contacts by themselves, so that loops find them side by side."""
    total, real = np.full(1, len(rows)), np.zeros((2, len(rows)))
    return Contacts(
        total, contacts.first[rows], contacts.second[rows], contacts.normal[rows], contacts.gap[rows],
        contacts.bound[rows], contacts.weight[rows], contacts.impulse[rows], contacts.change[rows], real[0], real[1],
    )  # fmt: skip


@compiled_inside
def _sweep(span: Span, who: Who, push: Push, motion: Motion) -> float:
    """One Gauss-Seidel sweep over some contacts; the largest change in it, as a relative velocity."""
    first, second, normal = who
    impulse, bound, weight, change, _, _ = push
    velocity, mobility = motion
    largest = 0.0
    for row in range(np.uint64(span[0]), np.uint64(span[1])):
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


@compiled_inside
def _residual(span: Span, who: Who, push: Push, velocity: Array) -> float:
    """By how much the worst of some contacts breaks the conditions (m/s): it lets through, or pushes what leaves."""
    first, second, normal = who
    impulse, bound, weight, _, _, _ = push
    worst = 0.0
    for row in range(np.uint64(span[0]), np.uint64(span[1])):
        i, j = np.uint64(first[row]), np.uint64(second[row])
        along_x = normal[row, 0] * (velocity[j, 0] - velocity[i, 0])
        excess = along_x + normal[row, 1] * (velocity[j, 1] - velocity[i, 1]) - bound[row]
        if weight[row] > 0.0:
            worst = max(worst, -excess, min(excess, impulse[row] / weight[row]))
    return worst


@compiled_inside
def _accelerate(span: Span, who: Who, push: Push, motion: Motion, ratio: float) -> None:
    """Go on along the conjugate direction: p += ratio * d, kept positive; d = ratio * d + the change of the last
    sweep.
    """
    first, second, normal = who
    impulse, _, _, change, direction, step = push
    velocity, mobility = motion
    for row in range(np.uint64(span[0]), np.uint64(span[1])):
        along, old = ratio * direction[row], impulse[row]
        impulse[row] = max(old + along, 0.0)
        step[row] = impulse[row] - old
        direction[row] = along + change[row]
    if ratio > 0.0:
        for row in range(np.uint64(span[0]), np.uint64(span[1])):
            i, j = np.uint64(first[row]), np.uint64(second[row])
            on_i, on_j = mobility[i] * step[row], mobility[j] * step[row]
            velocity[i, 0] -= on_i * normal[row, 0]
            velocity[i, 1] -= on_i * normal[row, 1]
            velocity[j, 0] += on_j * normal[row, 0]
            velocity[j, 1] += on_j * normal[row, 1]


@compiled
def residual(contacts: Contacts, velocity: Array) -> float:
    """By how much the worst contact breaks the conditions (m/s): it lets through, or pushes what leaves."""
    return _residual((0, contacts.total[0]), who_of(contacts), push_of(contacts), velocity)


class Goal(NamedTuple):
    """When impulses are good enough, as residuals (m/s)."""

    wanted: float
    tolerable: float
    """good enough once more sweeps do not help"""


@compiled
def solve(contacts: Contacts, velocity: Array, mobility: Array, goal: Goal) -> int:
    """Change `velocity` by the contacts' impulses until the residual is as wanted.

    The impulses that stand in the contacts are the start. Returns the number of sweeps, MOST_SWEEPS + 1 if they were
    not enough; the most that an island took.
    """
    if begin(contacts, velocity, mobility, goal):
        return 1
    if contacts.total[0] < MANY:
        return solve_islands(contacts, np.array([0, contacts.total[0]]), velocity, mobility, goal)
    islands = islands_of(contacts, mobility)
    some = some_contacts(contacts, islands.rows)
    sweeps = solve_islands(some, islands.first, velocity, mobility, goal)
    take_over(contacts, islands.rows, some)
    return sweeps


@compiled
def begin(contacts: Contacts, velocity: Array, mobility: Array, goal: Goal) -> bool:
    """The first sweep; whether it is enough."""
    span, who, push = (0, contacts.total[0]), who_of(contacts), push_of(contacts)
    push_all(contacts, contacts.impulse, velocity, mobility)
    largest = _sweep(span, who, push, (velocity, mobility))
    return bool(largest <= goal.wanted and _residual(span, who, push, velocity) <= goal.wanted)


@compiled
def solve_islands(contacts: Contacts, first: Integers, velocity: Array, mobility: Array, goal: Goal) -> int:
    """All sweeps but the first, island by island, from `first[0]` up to `first[-1]`; the most that one took."""
    who, push, most = who_of(contacts), push_of(contacts), 1
    for island in range(len(first) - 1):
        span = first[island], first[island + 1]
        if not _residual(span, who, push, velocity) <= goal.wanted:
            small = span[1] - span[0] <= active_set.LARGEST
            sweeps = _go_on(span, who, push, (velocity, mobility), goal, ENOUGH if small else MOST_SWEEPS)
            if small and sweeps > ENOUGH and not solve_exactly(contacts, span, velocity, mobility, goal):
                sweeps = _go_on(span, who, push, (velocity, mobility), goal, MOST_SWEEPS)
            most = max(most, sweeps)
    return most


@compiled
def solve_exactly(contacts: Contacts, span: Span, velocity: Array, mobility: Array, goal: Goal) -> bool:
    """Solve an island by an active-set method; whether that was good enough, and no change where it was not."""
    begin, end = span
    before, slower = contacts.impulse[begin:end].copy(), velocity.copy()
    bound = contacts.bound[begin:end]
    rows = begin + np.flatnonzero((bound > -np.inf) & (contacts.weight[begin:end] > 0.0))
    pair = contacts.first[rows], contacts.second[rows], contacts.normal[rows]
    impulse = contacts.impulse[rows]
    if not active_set.nearest_velocity(pair, contacts.bound[rows], impulse, velocity, mobility):
        return False
    contacts.impulse[rows] = impulse
    left = _residual(span, who_of(contacts), push_of(contacts), velocity)
    if left <= max(goal.wanted, goal.tolerable):
        return True
    contacts.impulse[begin:end], velocity[:] = before, slower
    return False


@compiled_inside
def _go_on(span: Span, who: Who, push: Push, motion: Motion, goal: Goal, most: int) -> int:
    """Sweeps of an island after the first: the number of all, one more than `most` if they were not enough."""
    velocity, change, direction = motion[0], push[3], push[4]
    for row in range(span[0], span[1]):
        direction[row] = 0.0
    square_before, residual_before = 0.0, np.inf
    for sweep in range(2, most + 1):
        square = 0.0
        for row in range(span[0], span[1]):
            square += change[row] ** 2
        # A gradient that grows means that contacts opened or closed: forget the direction.
        ratio = square / square_before if 0.0 < square <= square_before else 0.0
        _accelerate(span, who, push, motion, ratio)
        square_before = square
        largest = _sweep(span, who, push, motion)
        if largest <= goal.wanted and _residual(span, who, push, velocity) <= goal.wanted:
            return sweep
        if sweep % PATIENCE == 0:
            # In a raft braced more than it needs, gaps that disagree in the last digits leave impulses that creep for
            # ever along a direction in which no velocity changes.
            left = _residual(span, who, push, velocity)
            if left <= goal.tolerable and left > 0.5 * residual_before:
                return sweep
            residual_before = left
    return most + 1


@compiled
def take_over(contacts: Contacts, rows: Integers, some: Contacts) -> None:
    """Take over the impulses of some contacts that were solved by themselves."""
    impulse, solved = contacts.impulse, some.impulse
    for place in range(len(rows)):
        impulse[rows[place]] = solved[place]
