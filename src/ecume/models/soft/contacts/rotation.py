"""Spheres that spin: how contacts turn with them, the balance of torques, and what resists a spin.

A sphere's spin stands as the way its equator goes, sigma = R theta (m), since the step's beginning, and a torque as a
force at the equator, T/R: so all unknowns are lengths and all that is left over are forces. Between two spheres lie
the arms R_i/(R_i + R_j) X_ij and R_j/(R_i + R_j) X_ij. The pair turns by (sigma_i + sigma_j)/(R_i + R_j), the gap
vector with it, and both spheres get the torque e x F at their equators, e = X_ij/(R_i + R_j): forces, and torques with
the forces' moments, sum to zero.
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
"""A sphere with a single neighbor in 3D rotates without resistance about the line to it. This relative stiffness
against spins is added to Newton's matrix, which makes it regular; the equations do not change.
"""


class Spins(NamedTuple):
    """The spheres' spins in a step; with no rows of components, (N, 0), where spheres do not spin."""

    radius: Array
    """(N,) m"""
    turn: Array
    """(N, s) m since the start of the step, of the stage; one component in a layer, three in 3D"""
    start: Array
    """(N, s) m: where the stage starts from; means something with drag only"""
    slope: Array
    """(S, N, s) m/s of the stages, with drag only"""
    drag: Array
    """(N,) N s/m at the equator"""
    torque: Array
    """(N, s) N at the equator: external, at load 1"""
    pair_blocks: Array
    """(C, 4, d + s, d + s) N/m: the blocks of the pairs"""


@compiled_inside
def cross(a: Vector, b: Vector) -> Vector:
    """The vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled_inside
def axial(rows: Array, i: int) -> Vector:
    """A row of spins as a vector: in a layer, out of the plane."""
    if rows.shape[1] == 1:
        return 0.0, 0.0, rows[i, 0]
    return rows[i, 0], rows[i, 1], rows[i, 2]


@compiled
def turn_pairs(pairs: Pairs, spins: Spins) -> None:
    """The rotation of each pair."""
    turn, to = spins.turn, pairs.turn
    for c in range(len(to)):
        a, b = axial(turn, pairs.first[c]), axial(turn, pairs.second[c])
        for k in range(3):
            to[c, k] = (a[k] + b[k]) / pairs.radius_sum[c]


@compiled_inside
def rolled(x: Vector, size: float, ends: tuple[int, int], change: Array, d: int) -> Vector:
    """The change of the distance x of a pair by changes of positions and spins, (N, d + s), in the frame that rotates
    with it; the sum of its radii is its size.
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
    """Add the torques of contacts on the spins of both their spheres, in the last columns of `right`."""
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
    """External torques, and the drag on spins, into the last columns of `right`; `during` is the stage's span, and by
    how much the liquid turns in it, out of the plane of x and y.
    """
    span, swirl = during
    width = spins.turn.shape[1]
    for i in range(len(spins.drag)):
        for k in range(width):
            value = factor * spins.torque[i, k]
            if spins.drag[i] > 0.0:
                along = spins.radius[i] * swirl if k == width - 1 else 0.0
                value -= spins.drag[i] * (spins.turn[i, k] - spins.start[i, k] - along) / span
            right[i, right.shape[1] - width + k] = value


@compiled
def fill_pair_blocks(pairs: Pairs, responses: ContactResponses, spins: Spins, position: Array) -> None:
    """The derivatives of forces and torques on both spheres of each pair by their displacements and spins."""
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
    """A component of a product."""
    value: float = matrix[row, 0] * vector[0] + matrix[row, 1] * vector[1] + matrix[row, 2] * vector[2]
    return value


@compiled_inside
def store_pair_blocks(pair_blocks: Array, stiffness: Array, by_spin: Array, torque_by: Array) -> None:
    """All blocks of a pair but spins against spins: forces on the first are opposite to those on the second, and what
    moves the first is opposite to what moves the second; spins and torques are alike for both.
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
    """Make the matrix of spins regular where spheres are `free` to turn all together: the first one resists, which
    `remove_free_rotation` makes good.
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
def begin_spins(spins: Spins, row: Array, time_step: float) -> None:
    """The spins at the start of a stage, from the slopes of the stages before."""
    start, slope = spins.start, spins.slope
    for i in range(len(spins.drag)):
        for k in range(start.shape[1]):
            start[i, k] = 0.0
            for earlier in range(len(row)):
                start[i, k] += time_step * row[earlier] * slope[earlier, i, k]


@compiled
def end_spins(spins: Spins, stage: int, span: float) -> None:
    """The slopes of a solved stage."""
    for i in range(len(spins.drag)):
        for k in range(spins.turn.shape[1]):
            spins.slope[stage, i, k] = (spins.turn[i, k] - spins.start[i, k]) / span


@compiled
def carry(pairs: Pairs, direction: Array) -> None:
    """Directions of gap vectors turn with their pairs: from the frame of the step's beginning to that of its end."""
    for c in range(len(pairs.turn)):
        angle = (pairs.turn[c, 0], pairs.turn[c, 1], pairs.turn[c, 2])
        n = turned((direction[c, 0], direction[c, 1], direction[c, 2]), angle)
        length = math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
        for k in range(3):
            direction[c, k] = n[k] / length


def make_spins(radius: Array, drag: Array, torque: Array, shape: tuple[int, int, int]) -> Spins:
    """Spins at a step's beginning; the shape says how many stages, contacts, and unknowns a sphere there are."""
    stages, contacts, width = shape
    count, spin = torque.shape
    return Spins(
        radius=radius,
        turn=np.zeros((count, spin)),
        start=np.zeros((count, spin)),
        slope=np.zeros((stages, count, spin)),
        drag=drag,
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


# --- Spheres that spin and that nothing holds: how all of them lie together


SINGULAR = 1e-6
"""Of what loads would resist a turn with, if nothing in it canceled: less than this says nothing of the turn."""


@compiled
def fill_rotation_sides(matrix: Matrix, spins: Spins, right: Array) -> None:
    """Right sides, after the first one: torques on the first sphere that turn all of them by about a radian."""
    block, begin = matrix.blocks[matrix.pattern.diagonal[0]], matrix.blocks.shape[1] - spins.turn.shape[1]
    for k in range(spins.turn.shape[1]):
        for i in range(right.shape[1]):
            for m in range(right.shape[2]):
                right[1 + k, i, m] = 0.0
        right[1 + k, 0, begin + k] = block[begin + k, begin + k] * spins.radius[0]


@compiled
def remove_free_rotation(position: Array, spins: Spins, changes: Array, pull: tuple[Array, Array, float]) -> None:
    """Add to the first change of positions and spins a multiple of the others, the responses to `fill_rotation_sides`,
    so that the total moment of external forces is zero; if these do not resist a rotation, so that the mean spin is
    zero. `pull` is the part proportional to the load, the constant part, and the load.

    The matrix holds the first sphere: the remaining moment acts on it, since contacts have no total moment.
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
    """The moment of what pulls at changed places (N m), and how large it were if nothing in it canceled."""
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
    """The total of the torques on the spheres (N m)."""
    total, width = np.zeros(3), spins.turn.shape[1]
    for i in range(len(spins.torque)):
        for k in range(width):
            total[2 if width == 1 else k] += load * spins.torque[i, k] * spins.radius[i]
    return total


@compiled
def least_squares(matrix: Array, right: Array, otherwise: Array) -> Array:
    """The solution of three equations by normal equations and elimination; undetermined components keep the given
    value.
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
