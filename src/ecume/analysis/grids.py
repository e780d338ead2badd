"""Fields of a liquid of particles on grids and along lines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume.analysis.gauges import filled, linear_values_at, points_along, values_at
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.units import Array, Length

MOST_POINTS = 10_000_000


class Grid(NamedTuple):
    """The nodes of a regular grid, as one array of coordinates per axis (m)."""

    axes: tuple[Array, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """The number of nodes along each axis."""
        return tuple(len(axis) for axis in self.axes)

    @property
    def points(self) -> Array:
        """The nodes (n, d); the last axis varies fastest."""
        return np.stack([axis.ravel() for axis in np.meshgrid(*self.axes, indexing="ij")], axis=1)


def grid_over(low: Sequence[float], high: Sequence[float], spacing: Length) -> Grid:
    """A grid between two corners, whose nodes are at most a spacing apart.

    >>> grid_over((0.0, 0.0), (1.0, 0.5), 0.25).shape
    (5, 3)
    """
    if not spacing > 0.0 or any(b <= a for a, b in zip(low, high, strict=True)):
        raise BadInput(f"a grid from {tuple(low)} to {tuple(high)} every {spacing:g} m has no nodes")
    counts = [int(np.ceil((b - a) / spacing - 1e-9)) + 1 for a, b in zip(low, high, strict=True)]
    if np.prod(np.array(counts, dtype=float)) > MOST_POINTS:
        raise BadInput(f"a grid of {' x '.join(map(str, counts))} nodes has more than {MOST_POINTS:.0e}")
    return Grid(tuple(np.linspace(a, b, count) for a, b, count in zip(low, high, counts, strict=True)))


def on_grid(frame: Frame, name: str, grid: Grid, reach: Length) -> Array:
    """An array of the frame at the grid's nodes, of shape (*grid.shape, ...): Shepard's mean of the particles within
    `reach`, NaN outside of the liquid.
    """
    values = values_at(frame, name, grid.points, reach)
    return values.reshape(*grid.shape, *values.shape[1:])


def linear_on_grid(frame: Frame, name: str, grid: Grid, reach: Length) -> Array:
    """An array of the frame at the grid's nodes, by linear fits: exact for linear fields, up to walls and surfaces."""
    values = linear_values_at(frame, name, grid.points, reach)
    return values.reshape(*grid.shape, *values.shape[1:])


def filled_on_grid(frame: Frame, grid: Grid, reach: Length) -> Array:
    """The filled fraction of each node's surroundings, shape grid.shape."""
    return filled(frame, grid.points, reach).reshape(grid.shape)


class Profile(NamedTuple):
    """Values along a line."""

    along: Array
    """(n,) the distance from the line's start (m)"""
    points: Array
    """(n, d)"""
    values: Array
    """(n, ...), NaN outside of the liquid"""


def profile_along(
    frame: Frame, name: str, ends: tuple[Sequence[float], Sequence[float]], count: int, reach: Length
) -> Profile:
    """An array of the frame at points from one end of a line to the other, by linear fits."""
    points = points_along(*ends, count)
    return Profile(np.linalg.norm(points - points[0], axis=1), points, linear_values_at(frame, name, points, reach))


def velocity_profile(frame: Frame, ends: tuple[Sequence[float], Sequence[float]], count: int, reach: Length) -> Profile:
    """The velocity along a line, (n, d) in m/s."""
    return profile_along(frame, "velocity", ends, count, reach)
