"""Contacts of bodies with a mobility that couples all of them: a full matrix, or only its products
with vectors.

If the mobility is a full matrix, each impulse changes the velocities of all bodies. The conditions are those of
`impulse_solvers`, with friction as in `friction`, for velocities w and W = J M J^T with a dense mobility M. Each row of
the Jacobian J has at most six numbers. A change of an impulse adds its column of M J^T to all velocities; columns are
computed when an impulse first becomes positive. The solver is `impulse_solvers`. Each body moves all others, so that
all contacts form one island.

If only products with the mobility are known, the method is that of projected gradients. The conditions are those of
`impulse_solvers`. Gauss-Seidel sweeps require the response to each single impulse; for the flow around ten thousand
floats only the response to all impulses at once can be computed in a reasonable time. The impulses minimize a quadratic
function under p >= 0, by steps along the projected gradient with the lengths of Barzilai & Borwein, as for suspensions
in [yan2019]. Each step is one product.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume._portable import dot
from ecume.engine.cells import Integers
from ecume.engine.contact import friction
from ecume.engine.contact.active_set import numbered
from ecume.engine.contact.contacts import Contacts, normal_velocities
from ecume.engine.contact.islands import Islands
from ecume.units import Array

ENTRIES = 6
"""Entries of a row: two velocities and a spin of each body."""


class DenseRows(NamedTuple):
    """Jacobian rows: all normal ones, followed by as many tangential ones with friction."""

    place: Integers
    """(rows, ENTRIES) indices of velocities and spins; zero where `value` is zero"""
    value: Array
    """(rows, ENTRIES)"""
    response: Array
    """(rows, M) M J^T, of the rows in `filled`"""
    filled: Integers
    """(rows,)"""
    weight: Array
    """effective mass 1/(J M J^T)"""
    bound: Array
    """(contacts,) lower bound of the normal velocity"""
    friction: Array
    """(contacts,)"""
    impulse: Array
    change: Array
    direction: Array


class CoupledContacts(NamedTuple):
    """Rows of contacts, and the mobility of all bodies."""

    rows: DenseRows
    mobility: Array
    """(M, M)"""


@compiled
def make_dense_rows(rows: int, contacts: int, size: int) -> DenseRows:
    """Empty arrays for this number of rows, and for velocities of this total size."""
    return DenseRows(
        np.zeros((rows, ENTRIES), np.int64), np.zeros((rows, ENTRIES)), np.empty((rows, size)),
        np.zeros(rows, np.int64), np.zeros(rows), np.zeros(contacts), np.zeros(contacts), np.zeros(rows),
        np.zeros(rows), np.zeros(rows),
    )  # fmt: skip


@compiled
def set_weights(rows: DenseRows, mobility: Array) -> None:
    """Compute the effective masses."""
    place, value = rows.place, rows.value
    for row in range(len(rows.weight)):
        inverse = 0.0
        for one in range(ENTRIES):
            for other in range(ENTRIES):
                if value[row, one] != 0.0 and value[row, other] != 0.0:
                    inverse += value[row, one] * value[row, other] * mobility[place[row, one], place[row, other]]
        rows.weight[row] = 1.0 / inverse if inverse > 0.0 else 0.0


@compiled_inside
def row_speed(place: Integers, value: Array, row: int, motion: Array) -> float:
    """The rate J w of one row."""
    total = 0.0
    for entry in range(ENTRIES):
        total += value[row, entry] * motion[place[row, entry]]
    return total


@compiled
def add_impulse(rows: DenseRows, row: int, impulse: float, mobility: Array, motion: Array) -> None:
    """Change the motion by an impulse of one row."""
    response = rows.response
    if rows.filled[row] == 0:
        response[row] = 0.0
        for entry in range(ENTRIES):
            share = rows.value[row, entry]
            if share != 0.0:
                source = rows.place[row, entry]
                for k in range(len(motion)):
                    response[row, k] += share * mobility[source, k]
        rows.filled[row] = 1
    for k in range(len(motion)):
        motion[k] += impulse * response[row, k]


@compiled
def start(system: CoupledContacts, motion: Array) -> int:
    """Compute the effective masses, and change the motion by the initial impulses; return the number of contacts."""
    rows, mobility = system
    set_weights(rows, mobility)
    for row in range(len(rows.impulse)):
        if rows.impulse[row] != 0.0:
            add_impulse(rows, row, rows.impulse[row], mobility, motion)
    return len(rows.bound)


@compiled
def sweep(system: CoupledContacts, motion: Array, some: Integers, relaxation: float) -> float:
    """Perform one projected Gauss-Seidel sweep. Returns the largest change, as a velocity."""
    rows, mobility = system
    place, value, impulse, change, weight = rows.place, rows.value, rows.impulse, rows.change, rows.weight
    contacts, largest = len(rows.bound), 0.0
    for row in some:
        speed = row_speed(place, value, row, motion)
        new = max(impulse[row] + weight[row] * (rows.bound[row] - speed), 0.0)
        change[row], impulse[row] = new - impulse[row], new
        if change[row] != 0.0:
            add_impulse(rows, row, change[row], mobility, motion)
            largest = max(largest, abs(change[row]) / weight[row])
        across = contacts + row
        if across < len(impulse):
            edge, sliding = rows.friction[row] * new, row_speed(place, value, across, motion)
            tangential_impulse = min(max(impulse[across] - relaxation * weight[across] * sliding, -edge), edge)
            change[across], impulse[across] = tangential_impulse - impulse[across], tangential_impulse
            if change[across] != 0.0:
                add_impulse(rows, across, change[across], mobility, motion)
                largest = max(largest, abs(change[across]) / weight[across])
    return largest


@compiled
def residual(system: CoupledContacts, motion: Array, some: Integers) -> float:
    """The largest violation of the conditions (m/s): see `friction.residual`."""
    rows = system.rows
    place, value, impulse, weight = rows.place, rows.value, rows.impulse, rows.weight
    contacts, worst = len(rows.bound), 0.0
    for row in some:
        if weight[row] > 0.0:
            excess = row_speed(place, value, row, motion) - rows.bound[row]
            worst = max(worst, -excess, min(excess, impulse[row] / weight[row]))
        across = contacts + row
        if across < len(impulse) and weight[across] > 0.0:
            edge = rows.friction[row] * impulse[row]
            sliding = row_speed(place, value, across, motion)
            better = min(max(impulse[across] - weight[across] * sliding, -edge), edge)
            worst = max(worst, abs(better - impulse[across]) / weight[across])
    return worst


@compiled
def accelerate(system: CoupledContacts, motion: Array, some: Integers, ratio: float) -> None:
    """Step along the conjugate direction: see `impulse_solvers`."""
    rows, mobility = system
    impulse, direction, contacts = rows.impulse, rows.direction, len(rows.bound)
    for row in range(len(impulse)):
        along, old = ratio * direction[row], impulse[row]
        impulse[row] = old + along
        if row < contacts:
            impulse[row] = max(impulse[row], 0.0)
        else:
            edge = rows.friction[row - contacts] * impulse[row - contacts]
            impulse[row] = min(max(impulse[row], -edge), edge)
        direction[row] = along + rows.change[row]
        if impulse[row] != old:
            add_impulse(rows, row, impulse[row] - old, mobility, motion)


@compiled
def restart(system: CoupledContacts, some: Integers) -> None:
    """Set the conjugate direction to zero."""
    for row in range(len(system.rows.direction)):
        system.rows.direction[row] = 0.0


@compiled
def square(system: CoupledContacts, some: Integers) -> float:
    """The square of the last changes of all impulses."""
    total = 0.0
    for row in range(len(system.rows.change)):
        total += system.rows.change[row] ** 2
    return total


@compiled
def islands(system: CoupledContacts, motion: Array) -> Islands:
    """The islands of contacts: all of them form one."""
    total = len(system.rows.bound)
    return Islands(np.arange(total), np.array([0, total]))


@compiled
def relaxed(system: CoupledContacts, relaxation: float) -> float:
    """The next relaxation factor of the tangential rows; without friction it is unchanged."""
    rubs = len(system.rows.impulse) > len(system.rows.bound)
    return float(friction.relaxed(system, relaxation)) if rubs else relaxation


@compiled
def unknowns(system: CoupledContacts) -> tuple[Array, Array, Array]:
    """The impulses, the bounds of the relative velocities, and the effective masses."""
    return system.rows.impulse, system.rows.bound, system.rows.weight


@compiled
def normal_velocity(system: CoupledContacts, motion: Array, row: int) -> float:
    """Relative normal velocity of a contact."""
    return float(row_speed(system.rows.place, system.rows.value, row, motion))


@compiled
def add_impulse_of(system: CoupledContacts, motion: Array, row: int, impulse: float) -> None:
    """Change the motion by an impulse of one contact."""
    add_impulse(system.rows, row, impulse, system.mobility, motion)


@compiled
def columns(system: CoupledContacts, motion: Array, rows: Integers) -> Array:
    """The responses to unit impulses in the norm of dissipated energy, L^T J^T with the mobility L L^T of the bodies
    that touch; the last row is empty. The result has no columns if there is friction, whose velocities are not a
    projection.
    """
    place, value, mobility = system.rows.place, system.rows.value, system.mobility
    if len(system.rows.impulse) > len(system.rows.bound):
        return np.zeros((1, len(rows)))
    index, size = numbered(place[rows].flatten(), len(mobility))
    there = np.empty(size, np.int64)
    for row in rows:
        for entry in range(ENTRIES):
            there[index[place[row, entry]]] = place[row, entry]
    root = cholesky(mobility, there)
    matrix = np.zeros((size + 1, len(rows)))
    for k in range(len(rows)):
        for entry in range(ENTRIES):
            at = index[place[rows[k], entry]]
            for column in range(at + 1):
                matrix[column, k] += root[at, column] * value[rows[k], entry]
    return matrix


@compiled
def cholesky(matrix: Array, there: Integers) -> Array:
    """The lower triangle L of some rows and columns of a positive definite matrix, L L^T."""
    root = np.zeros((len(there), len(there)))
    for i in range(len(there)):
        for j in range(i + 1):
            rest = matrix[there[i], there[j]]
            for k in range(j):
                rest -= root[i, k] * root[j, k]
            root[i, j] = np.sqrt(rest) if i == j else rest / root[j, j]
    return root


MOST_PRODUCTS = 400


@compiled
def spread_forces(contacts: Contacts, push: Array, force: Array) -> None:
    """Compute the forces of contacts on bodies (N + walls, 2), equal and opposite along the normals."""
    force[:] = 0.0
    first, second, normal = contacts.first, contacts.second, contacts.normal
    for row in range(contacts.total[0]):
        i, j = first[row], second[row]
        for axis in range(2):
            force[i, axis] -= push[row] * normal[row, axis]
            force[j, axis] += push[row] * normal[row, axis]


def residual_by_products(excess: Array, push: Array, weight: Array) -> float:
    """The largest violation of the conditions (m/s): approach, or force on separating bodies."""
    return float(np.max(np.maximum(-excess, np.minimum(excess, push / weight)), initial=0.0))


def solve_by_products(
    contacts: Contacts, velocity: Array, respond: Callable[[Array], Array], target: float, acceptable: float
) -> int:
    """Solve for the forces in `contacts.impulse`, which are also the initial guess, and change velocities (N + walls,
    2) by them, until the residual (m/s) is below the target. `respond(forces)` returns the velocities of all bodies
    caused by forces. Returns the number of products, MOST_PRODUCTS + 1 if the residual is not even `acceptable`.
    """
    total = int(contacts.total[0])
    scale, bound = np.sqrt(contacts.weight[:total]), contacts.bound[:total]
    given, force, excess = velocity.copy(), np.zeros_like(velocity), np.zeros(total)

    def gradient(share: Array) -> Array:
        spread_forces(contacts, scale * share, force)
        velocity[:] = given + respond(force)
        normal_velocities(contacts, velocity, excess)
        return np.asarray(scale * (excess - bound))

    share = contacts.impulse[:total] / scale
    slope, products, length = gradient(share), 1, 1.0
    best, least = share, residual_by_products(slope / scale, scale * share, contacts.weight[:total])
    while least > target and products < MOST_PRODUCTS:
        other = np.maximum(share - length * slope, 0.0)
        steeper = gradient(other)
        products += 1
        step, change = other - share, steeper - slope
        share, slope = other, steeper
        left = residual_by_products(slope / scale, scale * share, contacts.weight[:total])
        if left < least:
            best, least = share, left
        curvature = dot(step, change)
        if not curvature > 0.0:
            break
        # The two Barzilai-Borwein lengths alternate; the first is the longer one.
        length = dot(step, step) / curvature if products % 2 else curvature / dot(change, change)
    if best is not share:
        gradient(best)
    contacts.impulse[:total] = scale * best
    return products if least <= max(target, acceptable) else MOST_PRODUCTS + 1
