"""Rotation of spheres: the rotation of contacts with spins, the balance of torques, and its derivatives.

The rotation of a sphere since the start of the step is stored as the displacement of its equator, sigma = R theta (m),
and a torque as a force at the equator, T/R: all unknowns are lengths, and all residuals forces. The contact divides
X_ij into the arms R_i/(R_i + R_j) X_ij and R_j/(R_i + R_j) X_ij. The pair and its gap vector rotate by (sigma_i +
sigma_j)/(R_i + R_j). The torque on both spheres at their equators is e x F with e = X_ij/(R_i + R_j): total force and
total torque are zero.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume.engine.linear_solvers.block_matrix import Matrix
from ecume.models.soft.contacts.contact import Vector
from ecume.models.soft.contacts.films import ContactResponses, Pairs, center_distance, turned
from ecume.units import Array

SPIN_STIFFNESS = 1e-9
"""The relative stiffness added against spins. In 3D nothing resists the spin of a sphere about the line to its only
neighbor; the added stiffness makes Newton's matrix regular, and does not change the equations.
"""


class Spins(NamedTuple):
    """The rotation of all spheres in a step; its arrays have no columns, (N, 0), where spheres do not spin."""

    radius: Array
    """(N,) m"""
    turn: Array
    """(N, s) m: the rotation since the start of the step, at the current stage; s is 1 in 2D and 3 in 3D"""
    start: Array
    """(N, s) m: its value at the start of the stage; used with drag only"""
    slope: Array
    """(S, N, s) m/s: its rate at each stage, with drag only"""
    drag: Array
    """(N,) N s/m at the equator"""
    held: Array
    """(N,) N/m: the resistance to a rotation since the start of the step, of spheres glued to a wall"""
    torque: Array
    """(N, s) N: external torques as forces at the equator, at load 1"""
    pair_blocks: Array
    """(C, 4, d + s, d + s) N/m: the blocks of each pair in the matrix"""


@compiled_inside
def cross(a: Vector, b: Vector) -> Vector:
    """The vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled_inside
def axial(rows: Array, i: int) -> Vector:
    """The rotation of a sphere as a 3D vector; in 2D along z."""
    if rows.shape[1] == 1:
        return 0.0, 0.0, rows[i, 0]
    return rows[i, 0], rows[i, 1], rows[i, 2]


@compiled
def turn_pairs(pairs: Pairs, turn: Array) -> None:
    """Compute the rotation of each pair from the rotations of its spheres."""
    to = pairs.turn
    for c in range(len(to)):
        a, b = axial(turn, pairs.first[c]), axial(turn, pairs.second[c])
        for k in range(3):
            to[c, k] = (a[k] + b[k]) / pairs.radius_sum[c]


@compiled_inside
def rolled(x: Vector, size: float, ends: tuple[int, int], change: Array, d: int) -> Vector:
    """The change of the center distance x of a pair by changes of positions and spins, (N, d + s), in the frame that
    rotates with the pair; `size` is the sum of its radii.
    """
    i, j = ends
    u = (change[j, 0] - change[i, 0], change[j, 1] - change[i, 1], 0.0 if d == 2 else change[j, 2] - change[i, 2])
    if change.shape[1] == d:
        return u
    s = (0.0, 0.0, change[i, d] + change[j, d])
    if d == 3:
        s = (change[i, 3] + change[j, 3], change[i, 4] + change[j, 4], change[i, 5] + change[j, 5])
    v = cross(s, (x[0] / size, x[1] / size, x[2] / size))
    return u[0] - v[0], u[1] - v[1], u[2] - v[2]


@compiled
def add_torques(pairs: Pairs, responses: ContactResponses, position: Array, right: Array, corrected: bool) -> None:
    """Add the torques of contacts on both spheres to the last columns of `right`."""
    first, second, d = pairs.first, pairs.second, position.shape[1]
    for c in range(len(first)):
        i, j = first[c], second[c]
        f = (responses.force[c, 0], responses.force[c, 1], responses.force[c, 2])
        if corrected:
            g = responses.correction[c]
            f = (f[0] + g[0], f[1] + g[1], f[2] + g[2])
        torque = cross(center_distance(position, pairs.offset, i, j, c), f)
        for k in range(d, right.shape[1]):
            value = torque[2 if d == 2 else k - d] / pairs.radius_sum[c]
            right[i, k] += value
            right[j, k] += value


@compiled
def load_torques(spins: Spins, right: Array, factor: float, during: tuple[float, float]) -> None:
    """Write external torques and the drag on spins into the last columns of `right`. `during` is the time span of the
    stage, and the rotation of the liquid about z during it.
    """
    span, swirl = during
    width = spins.turn.shape[1]
    for i in range(len(spins.drag)):
        for k in range(width):
            value = factor * spins.torque[i, k] - spins.held[i] * spins.turn[i, k]
            if spins.drag[i] > 0.0:
                along = spins.radius[i] * swirl if k == width - 1 else 0.0
                value -= spins.drag[i] * (spins.turn[i, k] - spins.start[i, k] - along) / span
            right[i, right.shape[1] - width + k] = value


@compiled
def fill_pair_blocks(pairs: Pairs, responses: ContactResponses, spins: Spins, position: Array) -> None:
    """Compute the derivatives of forces and torques on both spheres of each pair by their displacements and spins."""
    pair_blocks, d = spins.pair_blocks, position.shape[1]
    by_spin, torque_by = np.zeros((3, 3)), np.zeros((3, 3))
    for c in range(len(pair_blocks)):
        size, k_c = pairs.radius_sum[c], responses.stiffness[c]
        x = center_distance(position, pairs.offset, pairs.first[c], pairs.second[c], c)
        e = (x[0] / size, x[1] / size, x[2] / size)
        f = (responses.force[c, 0] / size, responses.force[c, 1] / size, responses.force[c, 2] / size)
        for axis in range(3):
            one = (1.0 if axis == 0 else 0.0, 1.0 if axis == 1 else 0.0, 1.0 if axis == 2 else 0.0)
            moved, turned_force = cross(e, one), cross(f, one)
            pulled = cross(e, (k_c[0, axis], k_c[1, axis], k_c[2, axis]))
            for k in range(3):
                by_spin[k, axis] = row_times(k_c, k, moved) - turned_force[k]
                torque_by[k, axis] = pulled[k] - turned_force[k]
        store_pair_blocks(pair_blocks[c], k_c, by_spin, torque_by)
        for column in range(pair_blocks.shape[2] - d):
            axis = 2 if d == 2 else column
            rolling = cross(e, (by_spin[0, axis], by_spin[1, axis], by_spin[2, axis]))
            for row in range(pair_blocks.shape[2] - d):
                for block in range(4):
                    pair_blocks[c, block, d + row, d + column] = -rolling[2 if d == 2 else row]


@compiled_inside
def row_times(matrix: Array, row: int, vector: Vector) -> float:
    """The product of a matrix row and a vector."""
    value: float = matrix[row, 0] * vector[0] + matrix[row, 1] * vector[1] + matrix[row, 2] * vector[2]
    return value


@compiled_inside
def store_pair_blocks(pair_blocks: Array, stiffness: Array, by_spin: Array, torque_by: Array) -> None:
    """Store all blocks of a pair except spin by spin. Forces on the two spheres, and the effects of their
    displacements, have opposite signs; torques and spins have equal signs.
    """
    d = 2 if pair_blocks.shape[1] == 3 else 3
    for row in range(d):
        for column in range(d):
            pair_blocks[0, row, column] = pair_blocks[3, row, column] = stiffness[row, column]
            pair_blocks[1, row, column] = pair_blocks[2, row, column] = -stiffness[row, column]
        for k in range(pair_blocks.shape[1] - d):
            axis = 2 if d == 2 else k
            pair_blocks[0, row, d + k] = pair_blocks[1, row, d + k] = -by_spin[row, axis]
            pair_blocks[2, row, d + k] = pair_blocks[3, row, d + k] = by_spin[row, axis]
            pair_blocks[0, d + k, row] = pair_blocks[2, d + k, row] = torque_by[axis, row]
            pair_blocks[1, d + k, row] = pair_blocks[3, d + k, row] = -torque_by[axis, row]


@compiled
def regularize_spins(matrix: Matrix, spins: Spins, free: bool) -> None:
    """Make the matrix of spins regular. If all spheres are `free` to rotate together, a resistance is added to the
    first sphere, for which `remove_free_rotation` compensates.
    """
    own, blocks = matrix.pattern.diagonal, matrix.blocks
    begin = blocks.shape[1] - spins.turn.shape[1]
    for i in range(len(own)):
        trace = 0.0
        for k in range(begin, blocks.shape[1]):
            trace += blocks[own[i], k, k]
        for k in range(begin, blocks.shape[1]):
            blocks[own[i], k, k] += (1.0 if free and i == 0 else SPIN_STIFFNESS) * trace


@compiled
def carry(turn: Array, direction: Array) -> None:
    """Rotate the directions of gap vectors with their pairs, from the frame at the start of the step to that at its
    end.
    """
    for c in range(len(turn)):
        angle = (turn[c, 0], turn[c, 1], turn[c, 2])
        n = turned((direction[c, 0], direction[c, 1], direction[c, 2]), angle)
        length = math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
        for k in range(3):
            direction[c, k] = n[k] / length


def make_spins(radius: Array, resistance: tuple[Array, Array], torque: Array, shape: tuple[int, int, int]) -> Spins:
    """Spins at the start of a step. `resistance` consists of drag and of glue; `shape` contains the numbers of stages,
    of contacts, and of unknowns per sphere.
    """
    stages, contacts, width = shape
    count, spin = torque.shape
    return Spins(
        radius=radius,
        turn=np.zeros((count, spin)),
        start=np.zeros((count, spin)),
        slope=np.zeros((stages, count, spin)),
        drag=resistance[0],
        held=resistance[1],
        torque=torque,
        pair_blocks=np.zeros((contacts if spin else 0, 4, width, width)),
    )


def turned_orientation(orientation: Array, angle: Array) -> Array:
    """Orientations after a rotation by these angles (rad): angles in a layer, quaternions (scalar first) in 3D."""
    if orientation.shape[1] < 4:
        return np.asarray(orientation + angle)
    size = np.linalg.norm(angle, axis=1, keepdims=True)
    w, v = np.cos(size / 2), 0.5 * np.sinc(size / (2 * np.pi)) * angle
    scalar, vector = orientation[:, :1], orientation[:, 1:]
    product = np.concatenate(
        [w * scalar - (v * vector).sum(axis=1, keepdims=True), w * vector + scalar * v + np.cross(v, vector)], axis=1
    )
    return np.asarray(product / np.linalg.norm(product, axis=1, keepdims=True))


# --- Common rotation of freely rotating spheres


SINGULAR = 1e-6
"""Below this fraction of the largest possible resistance of the loads to a rotation, the rotation is undetermined."""


@compiled
def fill_rotation_sides(matrix: Matrix, spins: Spins, right: Array) -> None:
    """Fill the right-hand sides after the first one with torques on the first sphere that rotate all spheres by about
    one radian.
    """
    block, begin = matrix.blocks[matrix.pattern.diagonal[0]], matrix.blocks.shape[1] - spins.turn.shape[1]
    for k in range(spins.turn.shape[1]):
        for i in range(right.shape[1]):
            for m in range(right.shape[2]):
                right[1 + k, i, m] = 0.0
        right[1 + k, 0, begin + k] = block[begin + k, begin + k] * spins.radius[0]


@compiled
def remove_free_rotation(position: Array, spins: Spins, changes: Array, pull: tuple[Array, Array, float]) -> None:
    """Add a rotation of all spheres to Newton's step so that the total moment of external forces is zero. Where these
    forces do not resist a rotation, the mean spin becomes zero instead.

    The rotations are the solutions for the right-hand sides of `fill_rotation_sides`. `pull` contains the forces
    proportional to the load, the constant forces, and the load. The matrix has a resistance at the first sphere: the
    remaining moment acts there, since contacts have no total moment.
    """
    whole, columns, to_mean, to_moment = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(3), np.zeros(3)
    moment, size = moment_of(position, spins, changes[0], pull)
    mean, own, nowhere = mean_spin(spins, changes[0]), total_torque(spins, pull[2]), np.zeros(position.shape)
    for k in range(spins.turn.shape[1]):
        by_turn, (by_pull, _) = mean_spin(spins, changes[1 + k]), moment_of(nowhere, spins, changes[1 + k], pull)
        for m in range(3):
            whole[m, k] = by_turn[m]
            columns[m, k] = by_pull[m] / size if size > 0.0 else 0.0
    for m in range(3):
        to_mean[m] = -mean[m]
        to_moment[m] = -(moment[m] + own[m]) / size if size > 0.0 else 0.0
    coefficients = least_squares(whole, to_mean, np.zeros(3))
    if size > 0.0:
        coefficients = least_squares(columns, to_moment, coefficients)
    for k in range(spins.turn.shape[1]):
        for i in range(len(position)):
            for m in range(changes.shape[2]):
                changes[0, i, m] += coefficients[k] * changes[1 + k, i, m]


@compiled
def mean_spin(spins: Spins, change: Array) -> Array:
    """The mean spin of all spheres, as an axial vector (rad)."""
    mean, width = np.zeros(3), spins.turn.shape[1]
    for i in range(len(change)):
        for k in range(width):
            mean[2 if width == 1 else k] += change[i, change.shape[1] - width + k] / (spins.radius[i] * len(change))
    return mean


@compiled
def moment_of(position: Array, spins: Spins, change: Array, pull: tuple[Array, Array, float]) -> tuple[Array, float]:
    """The total moment of external forces at the changed positions (N m), and the sum of magnitudes of its terms."""
    (by_load, always, load), (count, d) = pull, position.shape
    moment, size, middle = np.zeros(3), 0.0, np.zeros(3)
    for i in range(count):
        for k in range(d):
            middle[k] += (position[i, k] + change[i, k]) / count
    p, f = np.zeros(3), np.zeros(3)
    for i in range(count):
        for k in range(d):
            p[k] = position[i, k] + change[i, k] - middle[k]
            f[k] = load * by_load[i, k] + always[i, k]
        for k in range(3):
            moment[k] += p[(k + 1) % 3] * f[(k + 2) % 3] - p[(k + 2) % 3] * f[(k + 1) % 3]
            size += abs(p[k] * f[k])
    return moment, size


@compiled
def total_torque(spins: Spins, load: float) -> Array:
    """The sum of external torques on the spheres (N m)."""
    total, width = np.zeros(3), spins.turn.shape[1]
    for i in range(len(spins.torque)):
        for k in range(width):
            total[2 if width == 1 else k] += load * spins.torque[i, k] * spins.radius[i]
    return total


@compiled
def least_squares(matrix: Array, right: Array, otherwise: Array) -> Array:
    """The least-squares solution of three equations by normal equations; undetermined components have the values in
    `otherwise`.
    """
    rows, solution = np.zeros((3, 4)), np.zeros(3)
    for k in range(3):
        rows[k, k] = SINGULAR**2
        rows[k, 3] = SINGULAR**2 * otherwise[k]
        for m in range(3):
            for n in range(3):
                rows[k, n] += matrix[m, k] * matrix[m, n]
            rows[k, 3] += matrix[m, k] * right[m]
    for k in range(3):
        for m in range(3):
            if m != k:
                part = rows[m, k] / rows[k, k]
                for n in range(k, 4):
                    rows[m, n] -= part * rows[k, n]
    for k in range(3):
        solution[k] = rows[k, 3] / rows[k, k]
    return solution
