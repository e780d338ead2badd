"""Interpolation at points from values at nearby particles: weighted sums over neighbors, means and linear fits.

The caller supplies the weights: this file contains no kernel.

B-splines assign charges to a square grid, and interpolate fields at the charges, with the same bits for any number of
threads.

A spline of order p distributes a particle over p x p points: weights add up to one, and have p - 2 continuous
derivatives. Each row of the grid is written by one thread, which adds the particles within reach in their order.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume._jit import compiled, prange, threaded
from ecume._portable import solve_definite
from ecume.engine.cells import Integers
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.engine.cells import Integers

THIN = 0.05
"""The sum of weights, relative to full surroundings, below which a point has no value."""
FEW = 0.01
"""The smallest variance of the neighbors' positions along any direction, over the reach squared, that determines a
gradient.
"""


class Near(NamedTuple):
    """The pairs of points and particles within the reach, ordered by points."""

    point: Integers
    """(pairs,) ascending"""
    particle: Integers
    """(pairs,)"""
    away: Array
    """(pairs, d) from the point to the particle"""
    distance: Array
    """(pairs,)"""
    reach: float
    points: int
    """the number of points"""


def near(points: Array, position: Array, reach: float) -> Near:
    """Pairs of points and particles within reach; both are (n, d)."""
    from scipy.spatial import cKDTree

    found = cKDTree(points).sparse_distance_matrix(cKDTree(position), reach, output_type="ndarray")
    order = np.lexsort((found["j"], found["i"]))
    point, particle = found["i"][order].astype(np.int64), found["j"][order].astype(np.int64)
    return Near(point, particle, position[particle] - points[point], found["v"][order], reach, len(points))


def added(pairs: Near, values: Array) -> Array:
    """Sums over the pairs of each point: values (pairs, ...) give (points, ...)."""
    rest = values.shape[1:]
    columns = values.reshape(len(pairs.point), math.prod(rest)).T
    sums = np.empty((math.prod(rest), pairs.points))
    for row, column in enumerate(columns):
        sums[row] = np.bincount(pairs.point, column, pairs.points)
    return sums.T.reshape(pairs.points, *rest)


def means(pairs: Near, weight: Array, values: Array) -> Array:
    """Shepard's mean, sum_j w_j f_j / sum_j w_j, at each point; NaN where the weights sum to less than `THIN`."""
    return _mean_of_pairs(pairs, weight, values[pairs.particle])


def planes(pairs: Near, weight: Array, values: Array) -> Array:
    """The value of the linear fit to the neighbors of each point: exact for linear fields.

    The mean is used if the neighbors do not determine a gradient.
    """
    mean = means(pairs, weight, values)
    middle = _mean_of_pairs(pairs, weight, pairs.away)
    off = pairs.away - middle[pairs.point]
    spread = _mean_of_pairs(pairs, weight, off[:, :, None] * off[:, None, :])
    flat = values[pairs.particle].reshape(len(pairs.particle), math.prod(values.shape[1:]))
    moment = _mean_of_pairs(pairs, weight, off[:, :, None] * flat[:, None, :])
    known = np.asarray(np.isfinite(spread).all(axis=(1, 2)))
    known[known] = np.linalg.eigvalsh(spread[known])[:, 0] > FEW * pairs.reach**2
    slope = solve_definite(spread[known], moment[known])
    mean[known] -= np.einsum("pa,pac->pc", middle[known], slope).reshape(mean[known].shape)
    return mean


def dry(pairs: Near, weight: Array) -> NDArray[np.bool_]:
    """Flags (points,) of the points without particles nearby, where no mean exists."""
    return ~np.asarray(added(pairs, weight) > THIN)


def _mean_of_pairs(pairs: Near, weight: Array, values: Array) -> Array:
    there = added(pairs, weight)
    total = added(pairs, _shaped(weight, values) * values)
    found: Array = total / _shaped(np.where(there > THIN, there, np.nan), total)
    return found


def _shaped(numbers: Array, like: Array) -> Array:
    """The numbers with additional axes, so that each multiplies one row of `like`."""
    return numbers.reshape(numbers.shape + (1,) * (like.ndim - 1))


class Spread(NamedTuple):
    """Positions of particles on a grid."""

    corner: Integers
    """(N, 2) the lowest grid point of each"""
    weight: Array
    """(2, N, order) along x and along y"""
    start: Integers
    """(rows + 1,) index in `order` of the first particle with its corner in each row"""
    order: Integers
    """(N,) particles row by row"""


def spread_out(position: Array, low: Array, spacing: float, rows: int, order: int) -> Spread:
    """The grid points and weights of particles (N, 2), on a grid with this number of rows whose first point is at
    `low`.
    """
    count = len(position)
    found = Spread(
        corner=np.empty((count, 2), np.int64),
        weight=np.empty((2, count, order)),
        start=np.zeros(rows + 1, np.int64),
        order=np.empty(count, np.int64),
    )
    _weigh(position, low, 1.0 / spacing, found.corner, found.weight)
    _sort_rows(found.corner, found.start, found.order)
    return found


@compiled
def _spline(weights: Array, t: float) -> None:
    """Compute the B-spline weights of the points around a particle at the fraction t of a cell, by recursion over the
    order.
    """
    order = len(weights)
    weights[0], weights[1] = 1.0 - t, t
    for n in range(3, order + 1):
        scale = 1.0 / (n - 1)
        weights[n - 1] = scale * t * weights[n - 2]
        for k in range(n - 2, 0, -1):
            weights[k] = scale * ((t + n - 1 - k) * weights[k - 1] + (k + 1 - t) * weights[k])
        weights[0] *= scale * (1.0 - t)


@threaded
def _weigh(position: Array, low: Array, per_cell: float, corner: Integers, weight: Array) -> None:
    back = weight.shape[2] // 2 - 1
    for row in prange(position.shape[0]):
        i = np.uint64(row)
        for axis in range(2):
            place = (position[i, axis] - low[axis]) * per_cell
            whole = int(place)
            corner[i, axis] = whole - back
            _spline(weight[axis, i], place - whole)


@compiled
def _sort_rows(corner: Integers, start: Integers, order: Integers) -> None:
    """Sort particles by rows, with a stable counting sort."""
    rows = len(start) - 1
    for i in range(len(order)):
        start[corner[i, 0] + 1] += 1
    for row in range(rows):
        start[row + 1] += start[row]
    for i in range(len(order) - 1, -1, -1):
        row = corner[i, 0]
        start[row + 1] -= 1
        order[start[row + 1]] = i
    for row in range(rows):
        start[row] = start[row + 1]
    start[rows] = len(order)


def density(spread: Spread, charge: Array, shape: tuple[int, int]) -> Array:
    """The charges on the grid; their sum is conserved."""
    grid = np.zeros(shape)
    _fill(spread.corner, spread.weight, spread.start, spread.order, charge, grid)
    return grid


@threaded
def _fill(corner: Integers, weight: Array, start: Integers, order: Integers, charge: Array, grid: Array) -> None:
    reach = weight.shape[2]
    for number in prange(len(start) - 1):
        row = int(np.int64(number))
        for place in range(start[max(row - reach + 1, 0)], start[row + 1]):
            i = np.uint64(order[place])
            share = charge[i] * weight[0, i, np.uint64(row - corner[i, 0])]
            column = np.uint64(corner[i, 1])
            for k in range(np.uint64(reach)):
                grid[row, column + k] += share * weight[1, i, k]


def fields(spread: Spread, grids: Array) -> Array:
    """The values of grids, (fields, rows, columns), at the particles: (N, fields)."""
    found = np.empty((len(spread.order), len(grids)))
    _read(spread.corner, spread.weight, spread.order, grids, found)
    return found


@threaded
def _read(corner: Integers, weight: Array, order: Integers, grids: Array, found: Array) -> None:
    reach = np.uint64(weight.shape[2])
    for number in prange(len(order)):
        i = np.uint64(order[np.uint64(number)])
        row, column = np.uint64(corner[i, 0]), np.uint64(corner[i, 1])
        for field in range(np.uint64(grids.shape[0])):
            total = 0.0
            for a in range(reach):
                line = 0.0
                for b in range(reach):
                    line += weight[1, i, b] * grids[field, row + a, column + b]
                total += weight[0, i, a] * line
            found[i, field] = total
