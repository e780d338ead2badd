"""Parts of space: which points are inside, and how far from a point inside a ray leaves. Points are (N, d)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ecume.units import Array

Flags = NDArray[np.bool_]


class Shape(Protocol):
    """What a part of space can tell."""

    def bounds(self) -> tuple[Array, Array]:
        """Its lowest and highest corner, each (d,)."""

    def inside(self, points: Array) -> Flags:
        """(N,) whether each point is inside."""

    def way_out(self, points: Array, direction: Array) -> Array:
        """(N,) how far it is from each point inside to the boundary along a unit vector."""

    def anchor(self) -> Array:
        """A corner of the lattice that fits it best, (d,)."""


class Box(NamedTuple):
    """Between two corners."""

    low: Array
    high: Array

    def bounds(self) -> tuple[Array, Array]:
        """Its corners."""
        return self.low, self.high

    def inside(self, points: Array) -> Flags:
        """Between the corners."""
        return np.asarray(((points > self.low) & (points < self.high)).all(axis=1))

    def way_out(self, points: Array, direction: Array) -> Array:
        """To the first face."""
        ahead = np.where(direction > 0.0, self.high - points, points - self.low)
        with np.errstate(divide="ignore"):
            ways = np.where(direction == 0.0, np.inf, ahead / np.abs(direction))
        way: Array = ways.min(axis=1)
        return way

    def anchor(self) -> Array:
        """Its lowest corner."""
        return self.low


class Ball(NamedTuple):
    """A disc or a sphere."""

    center: Array
    radius: float

    def bounds(self) -> tuple[Array, Array]:
        """Of the box around it."""
        return self.center - self.radius, self.center + self.radius

    def inside(self, points: Array) -> Flags:
        """Closer than the radius to the center."""
        square: Array = ((points - self.center) ** 2).sum(axis=1)
        return square < self.radius**2

    def way_out(self, points: Array, direction: Array) -> Array:
        """The rest of the chord."""
        away = points - self.center
        along = away @ direction
        way: Array = -along + np.sqrt(np.maximum(along**2 + self.radius**2 - (away**2).sum(axis=1), 0.0))
        return way

    def anchor(self) -> Array:
        """Its center: the lattice is as symmetric as the ball."""
        return self.center


class Polygon(NamedTuple):
    """Any simple polygon in the plane, vertices (V, 2) in either sense."""

    vertices: Array

    def bounds(self) -> tuple[Array, Array]:
        """Of the box around it."""
        return self.vertices.min(axis=0), self.vertices.max(axis=0)

    def inside(self, points: Array) -> Flags:
        """A ray to the right crosses an odd number of edges."""
        odd: Flags = self._crossings(points, np.array([1.0, 0.0])).sum(axis=1) % 2 == 1
        return odd

    def way_out(self, points: Array, direction: Array) -> Array:
        """To the nearest edge ahead."""
        way: Array = self._distances(points, direction).min(axis=1)
        return way

    def anchor(self) -> Array:
        """The lowest corner of the box around it."""
        return self.bounds()[0]

    def _crossings(self, points: Array, direction: Array) -> Flags:
        return np.isfinite(self._distances(points, direction))

    def _distances(self, points: Array, direction: Array) -> Array:
        """(N, V) from each point along a ray to each edge; infinite where it misses."""
        ahead = np.array([direction[0], direction[1]])
        across = np.array([-direction[1], direction[0]])
        first, last = self.vertices, np.roll(self.vertices, -1, axis=0)
        # Each end is on one side of the ray, an end on it counts as above: a vertex is crossed once.
        below_first = (first @ across)[None, :] < (points @ across)[:, None]
        below_last = (last @ across)[None, :] < (points @ across)[:, None]
        start, end = first @ across, last @ across
        with np.errstate(divide="ignore", invalid="ignore"):
            share = ((points @ across)[:, None] - start) / (end - start)
            place = first @ ahead + share * (last @ ahead - first @ ahead)
            distance = place - (points @ ahead)[:, None]
        crossed = (below_first != below_last) & (distance > 0.0)
        found: Array = np.where(crossed, distance, np.inf)
        return found


def lattice_in(shape: Shape, spacing: float) -> Array:
    """(N, d) the centers of the cells of a square lattice that are inside a shape."""
    low, high = shape.bounds()
    anchor = shape.anchor()
    axes = [_cells(a, b, c, spacing) for a, b, c in zip(low, high, anchor, strict=True)]
    grid = np.meshgrid(*axes, indexing="ij")
    points = np.stack([axis.ravel() for axis in grid], axis=1)
    return points[shape.inside(points)]


def _cells(low: float, high: float, anchor: float, spacing: float) -> Array:
    """Centers between two ends, half a spacing off the anchor. Rounding must not cost a row."""
    first = np.floor((low - anchor) / spacing + 1e-6)
    last = np.ceil((high - anchor) / spacing - 1e-6)
    return np.asarray(anchor + spacing * (np.arange(first, last) + 0.5), dtype=np.float64)


def apart(points: Array, shapes: Sequence[Shape]) -> Flags:
    """Which points are inside none of the shapes."""
    free = np.ones(len(points), bool)
    for shape in shapes:
        free &= ~shape.inside(points)
    return free
