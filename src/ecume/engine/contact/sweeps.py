"""The solver for contacts of bodies that turn, rub or move one another: accelerated projected Gauss-Seidel sweeps by
islands, for rows of any type.

The conditions, the conjugate directions and the islands are those of `impulse_solvers`, whose loops are written for
discs alone, since most contacts are theirs: each further number in them would slow down every raft. Here the type of
the rows selects the functions of a sweep. Islands on which sweeps do not converge are solved exactly where the
velocities are a projection: with friction they are not. Where all bodies move one another, all contacts are one island.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled, selected
from ecume.engine.cells import Integers
from ecume.engine.contact import friction, mobility_contacts, rolling, torque_contacts
from ecume.engine.contact.friction import FrictionalContacts
from ecume.engine.contact.impulse_solvers import (
    LEAST_FOR_ISLANDS,
    MOST_SWEEPS,
    PATIENCE,
    SWEEPS_BEFORE_ACTIVE_SET,
    Tolerance,
)
from ecume.engine.contact.mobility_contacts import CoupledContacts
from ecume.engine.contact.rolling import RollingContacts
from ecume.engine.contact.torque_contacts import TorqueContacts

RELAXATION, LEAST_RELAXATION, STALLS = 0.7, 0.1, 8
"""Friction has no potential: in overconstrained rafts with mu near 1 the sweeps may cycle. After STALLS checks without
progress the relaxation factor of the tangential rows is multiplied by RELAXATION, down to LEAST_RELAXATION, and then
reset to 1: slow convergence needs a large factor, cycles need a small one, and the residual does not distinguish them.
"""


class RowKind(NamedTuple):
    """The functions of one type of rows. `motion` holds velocities and spins, `some` the numbers of contacts."""

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
    exactly: Callable[..., int] | None = None
    """exactly(rows, motion, some, tolerance): solve by the active-set method; 1 if the result is accepted"""
    prepare: Callable[..., None] | None = None
    """prepare(rows, radius, frictions, motion): set coefficients and effective masses of the rows besides normal ones
    """
    scale: Callable[..., None] | None = None
    """scale(rows, factors): multiply the impulses of these rows"""
    recall: Callable[..., None] | None = None
    """recall(rows, memory, kept): set them to those of the previous step"""
    remember: Callable[..., None] | None = None
    """remember(rows, memory, kept): store them for the next step"""


ROWS: dict[type, RowKind] = {
    FrictionalContacts: RowKind(
        friction.start, friction.sweep, friction.residual, friction.accelerate, friction.restart, friction.square,
        friction.islands, None, friction.prepare, friction.scale, friction.recall, friction.remember,
    ),
    RollingContacts: RowKind(
        rolling.start, rolling.sweep, rolling.residual, rolling.accelerate, rolling.restart, rolling.square,
        rolling.islands, None, rolling.prepare, rolling.scale, rolling.recall, rolling.remember,
    ),
    TorqueContacts: RowKind(
        torque_contacts.start, torque_contacts.sweep, torque_contacts.residual, torque_contacts.accelerate,
        torque_contacts.restart, torque_contacts.square, torque_contacts.islands, torque_contacts.solve_exactly,
    ),
    CoupledContacts: RowKind(
        mobility_contacts.start, mobility_contacts.sweep, mobility_contacts.residual, mobility_contacts.accelerate,
        mobility_contacts.restart, mobility_contacts.square, mobility_contacts.islands,
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
exactly = selected(ROWS, "exactly", -1)
prepare = selected(ROWS, "prepare")
scale = selected(ROWS, "scale")
recall = selected(ROWS, "recall")
remember = selected(ROWS, "remember")


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
        return iterate(rows, motion, every, tolerance)
    found, most = islands(rows, motion), 1
    for island in range(len(found.first) - 1):
        some = found.rows[found.first[island] : found.first[island + 1]]
        if not residual(rows, motion, some) <= tolerance.target:
            most = max(most, iterate(rows, motion, some, tolerance))
    return most


@compiled
def iterate(rows: Any, motion: Any, some: Integers, tolerance: Tolerance) -> int:
    """Do the sweeps of an island after the first; return the number of all, MOST_SWEEPS + 1 without convergence."""
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
            left = residual(rows, motion, some)
            if left > 0.5 * residual_before:
                if left <= tolerance.acceptable:
                    return number
                stalls += 1
                if stalls % STALLS == 0:
                    relaxation = RELAXATION * relaxation if relaxation > LEAST_RELAXATION else 1.0
            residual_before = left
        if number == SWEEPS_BEFORE_ACTIVE_SET and exactly(rows, motion, some, tolerance) == 1:
            return number
    return MOST_SWEEPS + 1
