"""The solver for the impulses of all contacts of a step: accelerated projected Gauss-Seidel sweeps by islands, for rows
of any type, and an exact active-set method.

`solve` is the place to start. In Moreau's and Jean's time stepping the unknowns are the impulses p >= 0 of a step,
complementary to the conditions n.(w_j - w_i) >= bound. `w` is the velocity with which particles move during the step,
so that with bound = -gap/dt no bodies overlap after the step: contacts act before gaps close. The linear
complementarity problem is solved by projected Gauss-Seidel sweeps, accelerated by the nonsmooth conjugate gradients of
Silcowitz-Hansen, Niebe & Erleben (2010), until the residual is below the goal, without a fixed number of sweeps, with
which large rafts would slowly overlap.

Contacts that are connected by movable bodies form an island. Each island is solved separately with as many sweeps as it
needs, and islands without impulses are skipped. Without islands, isolated pairs, the most frequent islands, would be
iterated until the largest island converges.

The type of the rows selects the passes over them. There are rows of discs, of discs with friction (additional
tangential rows) and with rolling resistance (additional torques), of bodies of any shape, and of bodies with
hydrodynamic interaction. Each type has separate loops, because additional numbers in the loops of discs would slow down
every raft. Islands on which sweeps do not converge are solved exactly (`active_set`) if the velocities are a
projection, which they are not with friction.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled, selected
from ecume.engine.cells import Integers
from ecume.engine.contact import contacts, friction, mobility_contacts, rolling, torque_contacts
from ecume.engine.contact.active_set import LARGEST, nearest_impulses
from ecume.engine.contact.contacts import Contacts
from ecume.engine.contact.friction import FrictionalContacts
from ecume.engine.contact.mobility_contacts import CoupledContacts
from ecume.engine.contact.rolling import RollingContacts
from ecume.engine.contact.torque_contacts import TorqueContacts

MOST_SWEEPS = 20_000
PATIENCE, STALLS = 128, 8
"""Sweeps after which the residual should have halved, and the number of times it has not before friction is relaxed."""
CONVERGED = 1e-7
"""The target residual, as a fraction of the largest approach velocity."""
SWEEPS_BEFORE_ACTIVE_SET = 4_000
"""Sweeps after which a small island is solved by the active-set method."""
LEAST_FOR_ISLANDS = 64
"""Fewer contacts are treated as one island."""


class Tolerance(NamedTuple):
    """Convergence criteria, as residuals (m/s)."""

    target: float
    acceptable: float
    """accepted if the residual no longer decreases"""


class RowKind(NamedTuple):
    """The functions of one type of rows. `motion` contains velocities and spins, `some` the indices of contacts."""

    start: Callable[..., int]
    """start(rows, motion): change the motion by the initial impulses; return the number of contacts"""
    sweep: Callable[..., float]
    """sweep(rows, motion, some, relaxation): the largest change, as a velocity"""
    residual: Callable[..., float]
    """residual(rows, motion, some): the largest violation of the conditions (m/s)"""
    accelerate: Callable[..., None]
    """accelerate(rows, motion, some, ratio): a step along the conjugate direction"""
    restart: Callable[..., None]
    """restart(rows, some): forget the conjugate direction"""
    square: Callable[..., float]
    """square(rows, some): of the last changes"""
    islands: Callable[..., Any]
    """islands(rows, motion): those with an impulse or a change"""
    keys: Callable[..., Any] | None = None
    """keys(rows): the keys of the warm start of normal rows"""
    speeds: Callable[..., None] | None = None
    """speeds(rows, velocity, speed): write the relative normal velocities of all contacts"""
    packed: Callable[..., Any] = contacts.unpacked
    """packed(rows, some): rows that may be a copy of some of them, and the numbers of these"""
    unpack: Callable[..., None] | None = None
    """unpack(rows, copy, some): take the impulses from the copy; None without one"""
    relaxed: Callable[..., float] | None = None
    """relaxed(rows, relaxation): the next relaxation factor where sweeps make no progress; None if none is needed"""
    exactly: Callable[..., int] | None = None
    """exactly(rows, motion, some, tolerance): solve by the active-set method; 1 if the result is accepted"""
    unknowns: Callable[..., Any] | None = None
    """unknowns(rows): impulses, bounds and effective masses of the normal rows"""
    speed: Callable[..., float] | None = None
    """speed(rows, motion, row): the relative normal velocity"""
    add: Callable[..., None] | None = None
    """add(rows, motion, row, impulse): change the motion by an impulse along the normal"""
    columns: Callable[..., Any] | None = None
    """columns(rows, motion, some): responses to unit impulses, for `active_set.nearest_impulses`"""
    prepare: Callable[..., None] | None = None
    """prepare(rows, radius, frictions, motion): set coefficients and effective masses of the rows besides normal ones
    """
    scale: Callable[..., None] | None = None
    """scale(rows, factors): multiply the impulses of these rows"""
    recall: Callable[..., None] | None = None
    """recall(rows, memory, kept): set them to those of the previous step"""
    remember: Callable[..., None] | None = None
    """remember(rows, memory, kept): store them for the next step"""


@compiled
def solve(rows: Any, motion: Any, tolerance: Tolerance) -> int:
    """Solve for the impulses and change the motion by them, until the residual is below the goal.

    The initial guess is in the rows. Returns the largest number of sweeps of an island, MOST_SWEEPS + 1 without
    convergence.
    """
    every = np.arange(start(rows, motion))
    if sweep(rows, motion, every, 1.0) <= tolerance.target and residual(rows, motion, every) <= tolerance.target:
        return 1
    if len(every) < LEAST_FOR_ISLANDS:
        return solve_island(rows, motion, every, tolerance)
    found, most = islands(rows, motion), 1
    few, numbers = packed(rows, found.rows)
    for island in range(len(found.first) - 1):
        some = numbers[found.first[island] : found.first[island + 1]]
        most = max(most, solve_island(few, motion, some, tolerance))
    unpack(rows, few, found.rows)
    return most


@compiled
def solve_island(rows: Any, motion: Any, some: Integers, tolerance: Tolerance) -> int:
    """Perform the sweeps of an island after the first; return the number of all sweeps, MOST_SWEEPS + 1 without
    convergence.
    """
    if residual(rows, motion, some) <= tolerance.target:
        return 1
    restart(rows, some)
    square_before, residual_before, relaxation, stalls = 0.0, np.inf, 1.0, 0
    for number in range(2, MOST_SWEEPS + 1):
        gradient = square(rows, some)
        # A growing gradient means that the active set changed: restart the conjugate directions.
        ratio = gradient / square_before if relaxation == 1.0 and 0.0 < gradient <= square_before else 0.0
        accelerate(rows, motion, some, ratio)
        square_before = gradient
        largest = sweep(rows, motion, some, relaxation)
        if largest <= tolerance.target and residual(rows, motion, some) <= tolerance.target:
            return number
        if number % PATIENCE == 0:
            # In an overconstrained raft, rounding of the gaps lets impulses drift without end along self-stresses,
            # which change no velocity.
            left = residual(rows, motion, some)
            if left > 0.5 * residual_before:
                if left <= tolerance.acceptable:
                    return number
                stalls += 1
                if stalls % STALLS == 0:
                    relaxation = relaxed(rows, relaxation)
            residual_before = left
        if number == SWEEPS_BEFORE_ACTIVE_SET and exactly(rows, motion, some, tolerance) == 1:
            return number
    return MOST_SWEEPS + 1


@compiled
def solve_exactly(rows: Any, motion: Any, some: Integers, tolerance: Tolerance) -> int:
    """Solve an island by the active-set method. Returns 1 if the result is accepted; otherwise nothing changes except
    for rounding.
    """
    if len(some) > LARGEST:
        return 0
    (impulse, bound, weight), count = unknowns(rows), 0
    solvable, need, before = np.empty(len(some), np.int64), np.empty(len(some)), np.empty(len(some))
    for row in some:
        if bound[row] > -np.inf and weight[row] > 0.0:
            solvable[count], before[count] = row, impulse[row]
            add(rows, motion, row, -impulse[row])
            count += 1
    for k in range(count):
        need[k] = bound[solvable[k]] - speed(rows, motion, solvable[k])
    found = before[:count].copy()
    solved = nearest_impulses(columns(rows, motion, solvable[:count]), need[:count], found)
    for k in range(count):
        impulse[solvable[k]] = found[k]
        add(rows, motion, solvable[k], found[k])
    if solved and residual(rows, motion, some) <= max(tolerance.target, tolerance.acceptable):
        return 1
    for k in range(count):
        impulse[solvable[k]] = before[k]
        add(rows, motion, solvable[k], before[k] - found[k])
    return 0


ROWS: dict[type, RowKind] = {
    Contacts: RowKind(
        contacts.start, contacts.sweep, contacts.residual, contacts.accelerate, contacts.restart, contacts.square,
        contacts.islands, contacts.contact_keys, contacts.normal_velocities, contacts.packed, contacts.unpack,
        exactly=solve_exactly, unknowns=contacts.unknowns, speed=contacts.normal_velocity, add=contacts.add_impulse,
        columns=contacts.columns,
    ),
    FrictionalContacts: RowKind(
        friction.start, friction.sweep, friction.residual, friction.accelerate, friction.restart, friction.square,
        friction.islands, relaxed=friction.relaxed, prepare=friction.prepare, scale=friction.scale,
        recall=friction.recall, remember=friction.remember,
    ),
    RollingContacts: RowKind(
        rolling.start, rolling.sweep, rolling.residual, rolling.accelerate, rolling.restart, rolling.square,
        rolling.islands, relaxed=friction.relaxed, prepare=rolling.prepare, scale=rolling.scale,
        recall=rolling.recall, remember=rolling.remember,
    ),
    TorqueContacts: RowKind(
        torque_contacts.start, torque_contacts.sweep, torque_contacts.residual, torque_contacts.accelerate,
        contacts.restart, contacts.square, torque_contacts.islands, torque_contacts.contact_keys,
        torque_contacts.normal_velocities, exactly=solve_exactly, unknowns=contacts.unknowns,
        speed=torque_contacts.normal_velocity, add=torque_contacts.add_impulse, columns=torque_contacts.columns,
    ),
    CoupledContacts: RowKind(
        mobility_contacts.start, mobility_contacts.sweep, mobility_contacts.residual, mobility_contacts.accelerate,
        mobility_contacts.restart, mobility_contacts.square, mobility_contacts.islands,
        relaxed=mobility_contacts.relaxed, exactly=solve_exactly, unknowns=mobility_contacts.unknowns,
        speed=mobility_contacts.normal_velocity, add=mobility_contacts.add_impulse_of,
        columns=mobility_contacts.columns,
    ),
}  # fmt: skip
"""The functions of each kind of rows, by type."""

start = selected(ROWS, "start")
sweep = selected(ROWS, "sweep")
residual = selected(ROWS, "residual")
accelerate = selected(ROWS, "accelerate")
restart = selected(ROWS, "restart")
square = selected(ROWS, "square")
islands = selected(ROWS, "islands")
packed = selected(ROWS, "packed")
unpack = selected(ROWS, "unpack")
relaxed = selected(ROWS, "relaxed", 1)
exactly = selected(ROWS, "exactly", -1)
unknowns = selected(ROWS, "unknowns")
speed = selected(ROWS, "speed")
add = selected(ROWS, "add")
columns = selected(ROWS, "columns")
contact_keys = selected(ROWS, "keys")
normal_velocities = selected(ROWS, "speeds")
prepare = selected(ROWS, "prepare")
scale = selected(ROWS, "scale")
recall = selected(ROWS, "recall")
remember = selected(ROWS, "remember")
