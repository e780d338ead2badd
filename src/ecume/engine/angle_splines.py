"""Cubic splines of small tables over the angles from 0 to 180 degrees."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from ecume.units import Array


def spline(angles: Array, table: tuple[float, ...], end: float) -> Array:
    """The cubic spline of a table from 0 to 180 degrees, flat at 0 and with the slope `end` at the other end: from its
    values and slopes at the two angles (radians) around.
    """
    step = math.pi / (len(table) - 1)
    place = np.minimum(angles / step, len(table) - 1.0)
    left = np.minimum(place.astype(np.int64), len(table) - 2)
    values, slopes, t = np.array(table), step * _slopes(table, end), place - left
    rise, u = values[left + 1] - values[left], 1.0 - t
    bend = u * (slopes[left] - rise) - t * (slopes[left + 1] - rise)
    factors: Array = u * values[left] + t * values[left + 1] + t * u * bend
    return factors


@cache
def _slopes(table: tuple[float, ...], end: float) -> Array:
    """Those that leave no jump in the second derivative: (m_{k-1} + 4 m_k + m_{k+1}) / 3 = (f_{k+1} - f_{k-1}) / step,
    given at both ends.
    """
    count, values = len(table), np.array(table)
    matrix = 4.0 * np.eye(count) + np.eye(count, k=1) + np.eye(count, k=-1)
    right = np.zeros(count)
    right[1:-1] = 3.0 * (count - 1) / math.pi * (values[2:] - values[:-2])
    matrix[0], matrix[-1] = np.eye(count)[0], np.eye(count)[-1]
    right[0], right[-1] = 0.0, end
    return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
