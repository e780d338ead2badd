"""Forces of user laws between the surfaces of two spheres, from tables over ln(gap) made at the start.

The table of a pair of species holds g = h F(h) at evenly spaced ln(h), as cubic Hermite splines. The slope and the
energy are those of the spline, so that the force is exactly minus the gradient of the energy. Smooth laws are
represented to about 1e-9; a jump is smoothed over two intervals, less than a percent of the gap. Beyond its ends a
table continues with a constant force.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside, where_there
from ecume._portable import exp
from ecume.engine.cells import Integers
from ecume.units import Array

INTERVALS = 8192
"""The number of intervals of a table."""


class Tables(NamedTuple):
    """The laws of a scene, a table for each pair of species with a law."""

    row: Integers
    """(S, S) the table of each pair of species, or -1"""
    ends: Array
    """(2,) the first ln(gap) and the spacing"""
    values: Array
    """(K, INTERVALS + 1, 3) g (N m), its slope over ln(gap) times the spacing (N m), and the energy (J)"""


class Across(NamedTuple):
    """The laws of the present contacts."""

    row: Integers
    """(C,) the table of each contact, or -1"""
    ends: Array
    values: Array


def across(tables: Tables | tuple[()], species: Array, pair: Integers) -> Across | tuple[()]:
    """The laws of contacts between these spheres, (C, 2)."""
    if not tables:
        return ()
    kinds = np.asarray(species, np.int64)
    return Across(tables.row[kinds[pair[:, 0]], kinds[pair[:, 1]]], tables.ends, tables.values)


def log_gaps(ends: Array, beyond: int = 0) -> Array:
    """The nodes of tables, with `beyond` more nodes at both ends."""
    return np.asarray(ends[0] + ends[1] * np.arange(-beyond, INTERVALS + 1 + beyond))


def table_of(force: Array, ends: Array) -> Array:
    """A table of `Tables.values` from the force (N) at `log_gaps(ends, 2)`."""
    g = force * exp(log_gaps(ends, 2))
    slope = (g[:-4] - 8.0 * g[1:-3] + 8.0 * g[3:-1] - g[4:]) / 12.0
    value = g[2:-2]
    parts = ends[1] * (0.5 * (value[:-1] + value[1:]) + (slope[:-1] - slope[1:]) / 12.0)
    energy = np.append(np.cumsum(parts[::-1])[::-1], 0.0)
    return np.stack([value, slope, energy], axis=1)


@compiled_inside
def place_in(log_gap: float, ends: Array, intervals: int) -> tuple[int, float]:
    """The interval of a table that contains a gap, and the fraction of the interval below it."""
    u = (log_gap - ends[0]) / ends[1]
    k = min(max(math.floor(u), 0), intervals - 1)
    return k, u - k


@compiled_inside
def user_force(row: int, ends: Array, values: Array, log_gap: float) -> tuple[float, float]:
    """The force of a row's law at a gap (N), positive repels, and its slope over the gap (N/m)."""
    if row < 0:
        return 0.0, 0.0
    intervals = values.shape[1] - 1
    last = ends[0] + ends[1] * intervals
    if not ends[0] <= log_gap <= last:
        end = 0 if log_gap < ends[0] else intervals
        return values[row, end, 0] * math.exp(-(ends[0] if end == 0 else last)), 0.0
    k, t = place_in(log_gap, ends, intervals)
    g0, m0, g1, m1 = values[row, k, 0], values[row, k, 1], values[row, k + 1, 0], values[row, k + 1, 1]
    s = 1.0 - t
    g = g0 * (1.0 + 2.0 * t) * s * s + m0 * t * s * s + g1 * t * t * (3.0 - 2.0 * t) - m1 * t * t * s
    slope = 6.0 * (g1 - g0) * t * s + m0 * s * (1.0 - 3.0 * t) + m1 * t * (3.0 * t - 2.0)
    per_gap = math.exp(-log_gap)
    return g * per_gap, (slope / ends[1] - g) * per_gap * per_gap


@compiled
def user_energies(laws: Across, log_gap: Array) -> Array:
    """The energy of the law of each contact (J), relative to that at the end of its table."""
    ends, values, found = laws.ends, laws.values, np.zeros(len(log_gap))
    intervals = values.shape[1] - 1
    last = ends[0] + ends[1] * intervals
    for c in range(len(log_gap)):
        row = laws.row[c]
        if row < 0:
            continue
        q = min(max(log_gap[c], ends[0]), last)
        k, t = place_in(q, ends, intervals)
        g0, m0, g1, m1 = values[row, k, 0], values[row, k, 1], values[row, k + 1, 0], values[row, k + 1, 1]
        third, fourth = t * t * t, 0.5 * t * t * t * t
        part = g0 * (t - third + fourth) + g1 * (third - fourth) + 0.5 * m0 * t * t
        part += m0 * (0.5 * fourth - 2.0 / 3.0 * third) + m1 * (0.5 * fourth - third / 3.0)
        force = user_force(row, ends, values, q)[0]
        found[c] = values[row, k, 2] - ends[1] * part + force * (math.exp(q) - math.exp(log_gap[c]))
    return found


@where_there()
def set_user_forces(laws: Across, log_gap: Array, found: Array) -> None:
    """Write the force of the law of each contact (N), positive repels, and its slope over the gap (N/m)."""
    row, ends, values = laws.row, laws.ends, laws.values
    for c in range(len(log_gap)):
        found[c, 0], found[c, 1] = user_force(row[c], ends, values, log_gap[c])
