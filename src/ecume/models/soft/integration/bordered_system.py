"""The shear and size of a stress-controlled box, and the positions of movable walls, as borders of the linear system of
a stage.

An unknown of the box displaces the spheres by a gradient, K x, in addition to their own displacements. Its row is the
virtual work of the contact forces, the sum of F_ij (K X_ij), which must equal volume times stress; its column is the
change of the forces. Solving the matrix of the spheres for the residual forces and for each column leaves a system of
one or two unknowns.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume._portable import dots, solve
from ecume.models.soft.cell import Cell, StageTarget, flow_gradient, gradient_of, stress_goal, transformed, unknowns
from ecume.models.soft.contacts.contact import ROUNDING, Vector
from ecume.models.soft.contacts.films import ContactResponses, Pairs, center_distance
from ecume.models.soft.contacts.rotation import cross
from ecume.models.soft.contacts.walls import Walls, column_of_wall, corner_of_walls
from ecume.units import Array

MOST = 2
"""The largest number of unknowns of a box."""


class Borders(NamedTuple):
    """Right-hand sides and solutions of the matrix of the spheres: first the residual forces, then the columns of the
    border.
    """

    right: Array
    """(1 + A, N, b)"""
    change: Array
    """(1 + A, N, b)"""
    rows: Array
    """(A, N, b)"""
    left: Array
    """(A,) residual work"""
    corner: Array
    """(A, A)"""


class ContactNetwork(NamedTuple):
    """The contacts between spheres at their positions, and their linear responses."""

    pairs: Pairs
    responses: ContactResponses
    position: Array


class DragTerms(NamedTuple):
    """The spheres on which the liquid drags, while the box carries it along."""

    position: Array
    drag: Array
    """(N,) N s/m"""
    spin_drag: Array
    """(N,) N s/m at the equator"""
    radius: Array


def make_borders(count: int, width: int, most: int) -> Borders:
    """Zero arrays for the borders of up to `most` unknowns."""
    return Borders(
        np.zeros((1 + most, count, width)),
        np.zeros((1 + most, count, width)),
        np.zeros((most, count, width)),
        np.zeros(most),
        np.zeros((most, most)),
    )


@compiled_inside
def work_change(row: Vector, stiffness: Array, c: int, column: Vector) -> float:
    """The virtual work, in one displacement, of the change of a contact force by another displacement."""
    total = 0.0
    for k in range(3):
        for m in range(3):
            total += row[k] * stiffness[c, k, m] * column[m]
    return total


@compiled
def box_stress_residual(cell: Cell, network: ContactNetwork, goal: StageTarget) -> float:
    """The largest residual work, relative to the sum of its absolute terms, minus the rounding error."""
    first, second, offset, position = network.pairs.first, network.pairs.second, network.pairs.offset, network.position
    force, stiffness = network.responses.force, network.responses.stiffness
    worst = 0.0
    for unknown in range(unknowns(cell)):
        row = gradient_of(cell, unknown, goal, True)
        target = stress_goal(cell, unknown, goal.drive, position.shape[1])
        work, whole, rounding = -target, abs(target), 0.0
        for c in range(len(first)):
            i, j = first[c], second[c]
            along = transformed(row, center_distance(position, offset, i, j, c))
            for k in range(position.shape[1]):
                work += force[c, k] * along[k]
                whole += abs(force[c, k] * along[k])
                size = abs(position[j, k]) + abs(position[i, k]) + abs(offset[c, k])
                rounding += ROUNDING * abs(stiffness[c, k, k] * along[k]) * size
        if whole > 0.0:
            worst = max(worst, (abs(work) - rounding) / whole)
    return worst


@compiled
def fill_border(cell: Cell, network: ContactNetwork, goal: StageTarget, borders: Borders, unknown: int) -> None:
    """Fill the border of an unknown: its column of forces, its row, and its residual work."""
    first, second, offset, position = network.pairs.first, network.pairs.second, network.pairs.offset, network.position
    force, correction, stiffness = network.responses.force, network.responses.correction, network.responses.stiffness
    column, rows, left = borders.right[1 + unknown], borders.rows[unknown], borders.left
    by, row = gradient_of(cell, unknown, goal, False), gradient_of(cell, unknown, goal, True)
    column[:] = 0.0
    rows[:] = 0.0
    left[unknown] = -stress_goal(cell, unknown, goal.drive, position.shape[1])
    for c in range(len(first)):
        i, j = first[c], second[c]
        x = center_distance(position, offset, i, j, c)
        across, along = transformed(by, x), transformed(row, x)
        for k in range(position.shape[1]):
            value, work = 0.0, 0.0
            for m in range(3):
                value += stiffness[c, k, m] * across[m]
                work += stiffness[c, m, k] * along[m] + row[m, k] * (force[c, m] + correction[c, m])
            column[i, k] += value
            column[j, k] -= value
            rows[j, k] += work
            rows[i, k] -= work
            left[unknown] += (force[c, k] + correction[c, k]) * along[k]
        if column.shape[1] > position.shape[1]:
            add_spins(network, c, (across, along), (column, rows))


@compiled
def add_drag(cell: Cell, dragged: DragTerms, goal: StageTarget, column: Array, unknown: int) -> None:
    """Add the change of the drag forces to the column of an unknown.

    Spheres move with the gradient K of the unknown, and the flow A of the liquid changes by dA, so that the force on a
    sphere changes by zeta (dA x + A K x - K x)/span. The torque follows from half of the vorticity.
    """
    by, along = gradient_of(cell, unknown, goal, False), flow_gradient(cell)
    change = by.copy()
    change[0, 1] -= along[0, 1] * (by[1, 1] - by[0, 0])
    position, d = dragged.position, dragged.position.shape[1]
    for i in range(len(dragged.drag)):
        if dragged.drag[i] > 0.0:
            x = (position[i, 0], position[i, 1], position[i, 2] if d == 3 else 0.0)
            moves = transformed(by, x)
            carried, further = transformed(change, x), transformed(along, moves)
            for k in range(d):
                column[i, k] += dragged.drag[i] / goal.span * (carried[k] + further[k] - moves[k])
            if column.shape[1] > d:
                swirl = -0.5 * change[0, 1] * dragged.radius[i]
                column[i, column.shape[1] - 1] += dragged.spin_drag[i] / goal.span * swirl


@compiled_inside
def add_spins(network: ContactNetwork, c: int, displaced: tuple[Vector, Vector], to: tuple[Array, Array]) -> None:
    """Add the torques of a contact to the column of an unknown, and the work of the forces by a spin to its row."""
    i, j, size = network.pairs.first[c], network.pairs.second[c], network.pairs.radius_sum[c]
    force, correction, stiffness = network.responses.force, network.responses.correction, network.responses.stiffness
    (across, along), (column, rows) = displaced, to
    x = center_distance(network.position, network.pairs.offset, i, j, c)
    f = (force[c, 0] + correction[c, 0], force[c, 1] + correction[c, 1], force[c, 2] + correction[c, 2])
    more, back = transformed(stiffness[c], across), transformed(stiffness[c].T, along)
    a, b = cross(x, more), cross(across, f)
    e, g = cross(back, x), cross(f, along)
    d, width = network.position.shape[1], column.shape[1]
    for k in range(d, width):
        axis = 2 if d == 2 else k - d
        for body in (i, j):
            column[body, k] += (a[axis] + b[axis]) / size
            rows[body, k] += (e[axis] + g[axis]) / size


@compiled
def fill_corner(cell: Cell, network: ContactNetwork, goal: StageTarget, corner: Array) -> None:
    """Compute the derivatives of residual works by the unknowns of the box, including those of the prescribed works."""
    first, second, offset, position = network.pairs.first, network.pairs.second, network.pairs.offset, network.position
    force, correction, stiffness = network.responses.force, network.responses.correction, network.responses.stiffness
    for one in range(unknowns(cell)):
        row = gradient_of(cell, one, goal, True)
        target = stress_goal(cell, one, goal.drive, position.shape[1])
        for other in range(unknowns(cell)):
            by = gradient_of(cell, other, goal, False)
            total = 0.0
            for k in range(position.shape[1]):
                total -= target * by[k, k]
            for c in range(len(first)):
                x = center_distance(position, offset, first[c], second[c], c)
                across = transformed(by, x)
                twice = transformed(row, across)
                total += work_change(transformed(row, x), stiffness, c, across)
                for k in range(3):
                    total += (force[c, k] + correction[c, k]) * twice[k]
            corner[one, other] = total


@compiled
def fill_all_borders(
    cell: Cell, network: ContactNetwork, dragged: DragTerms, goal: StageTarget, borders: Borders
) -> None:
    """Fill the borders and the corner of a system with a stress-controlled box."""
    for unknown in range(unknowns(cell)):
        fill_border(cell, network, goal, borders, unknown)
        if goal.span > 0.0:
            add_drag(cell, dragged, goal, borders.right[1 + unknown], unknown)
    fill_corner(cell, network, goal, borders.corner)


@compiled
def fill_wall_borders(walls: Walls, load: tuple[float, float], borders: Borders, dimensions: int) -> None:
    """Fill the borders and the corner of a system with movable walls."""
    for unknown in range(len(walls.places.free)):
        column_of_wall(walls, (borders.right[1 + unknown], borders.rows[unknown]), unknown, dimensions)
    corner_of_walls(walls, load, (borders.left, borders.corner))


def border_solution(borders: Borders, count: int) -> Array | None:
    """The changes of the unknowns, after combining the solutions of all right-hand sides; None for a singular
    system.
    """
    by = borders.change.reshape(len(borders.change), -1)
    rows = borders.rows[:count].reshape(count, -1)
    matrix = borders.corner[:count, :count] + dots(rows, by[1 : 1 + count])
    try:
        found = solve(matrix, -borders.left[:count] - dots(rows, by[:1])[:, 0])
    except np.linalg.LinAlgError:
        return None
    for unknown, value in enumerate(found):
        borders.change[0] += value * borders.change[1 + unknown]
    return np.asarray(found) if np.isfinite(found).all() else None


def change_box(cell: Cell, goal: StageTarget, found: Array) -> None:
    """Add the change of the unknowns to the displacement gradient."""
    cell.change[:] = 0.0
    for unknown, value in enumerate(found):
        cell.change[:] += value * gradient_of(cell, unknown, goal, False)


def change_walls(walls: Walls, found: Array) -> None:
    """Add the change of the unknowns to the positions of the walls."""
    walls.places.change[:] = 0.0
    for (wall, axis), value in zip(walls.places.free, found, strict=True):
        walls.places.change[wall, axis] = value
