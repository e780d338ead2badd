"""Interpolation at points from values at nearby particles: weighted sums over neighbors, means and linear fits.

The caller supplies the weights: this file contains no kernel.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ecume._portable import solve_definite
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.engine.cells import Integers

THIN = 0.05
"""Where less than this part of a point's surroundings is full, nothing is there."""
FEW = 0.01
"""A slope is trusted where neighbors spread this far in every direction, relative to the reach, squared."""


class Near(NamedTuple):
    """Pairs of a point and a particle not farther than the reach, point by point."""

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
    """how many there are"""


def near(points: Array, position: Array, reach: float) -> Near:
    """Pairs of points and particles within reach; both are (n, d)."""
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
    """Shepard's mean, sum_j w_j f_j / sum_j w_j, at each point; not a number where weights sum to less than `THIN`."""
    return _mean_of_pairs(pairs, weight, values[pairs.particle])


def planes(pairs: Near, weight: Array, values: Array) -> Array:
    """At each point the value of the linear fit to its neighbors: exact for linear fields.

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
    """(points,) whether no particle is near a point, so that there is no mean."""
    return ~np.asarray(added(pairs, weight) > THIN)


def _mean_of_pairs(pairs: Near, weight: Array, values: Array) -> Array:
    there = added(pairs, weight)
    total = added(pairs, _shaped(weight, values) * values)
    found: Array = total / _shaped(np.where(there > THIN, there, np.nan), total)
    return found


def _shaped(numbers: Array, like: Array) -> Array:
    """Numbers with as many axes, so that each multiplies its row."""
    return numbers.reshape(numbers.shape + (1,) * (like.ndim - 1))
