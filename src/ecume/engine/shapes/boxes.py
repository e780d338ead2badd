"""Boxes along the axes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume.engine.shapes.lattices import fitted_cells, round_up
from ecume.engine.shapes.parts import Cells, Flags
from ecume.units import Array


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
        """The distance to the first face."""
        ahead = np.where(direction > 0.0, self.high - points, points - self.low)
        with np.errstate(divide="ignore"):
            ways = np.where(direction == 0.0, np.inf, ahead / np.abs(direction))
        way: Array = ways.min(axis=1)
        return way

    def cells(self, spacing: float, faces: Array | None = None) -> Cells:
        """As many along each edge as fit best."""
        return fitted_cells(self.low, self.high, spacing, faces)

    def faces(self) -> Array:
        """Its corners."""
        return np.array([self.low, self.high])

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """Distance and normal of the nearest face, from outside of all faces that the point is beyond."""
        from_middle = points - self.middle()
        beyond = np.abs(from_middle) - 0.5 * (self.high - self.low)
        inside = np.eye(points.shape[1])[np.argmax(beyond, axis=1)]
        out = beyond.max(axis=1) > 0.0
        away = np.where(out[:, None], np.maximum(beyond, 0.0), inside)
        length = np.linalg.norm(away, axis=1)
        gap = np.where(out, length, beyond.max(axis=1))
        return gap, np.where(from_middle < 0.0, -away, away) / length[:, None]

    def rim(self, spacing: float) -> Array:
        """The nodes of a lattice over all faces."""
        axes = [np.linspace(a, b, round_up(b - a, spacing) + 1) for a, b in zip(self.low, self.high, strict=True)]
        points = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
        rim: Array = points[((points == self.low) | (points == self.high)).any(axis=1)]
        return rim

    def middle(self) -> Array:
        """Half way between the corners."""
        center: Array = 0.5 * (self.low + self.high)
        return center

    def volume(self) -> float:
        """The product of its edges."""
        return float(np.prod(self.high - self.low))

    def volume_within(self, low: Array, high: Array) -> float | None:
        """Between the higher of the low ends and the lower of the high ends."""
        edges = np.minimum(self.high, high) - np.maximum(self.low, low)
        return float(np.prod(np.maximum(edges, 0.0)))

    def surface(self) -> float:
        """The volume over each edge, twice."""
        return float(2.0 * (self.volume() / (self.high - self.low)).sum())

    def inertia(self) -> Array:
        """(b^2 + c^2) / 12 about the axis along a."""
        square = np.pad((self.high - self.low) ** 2, (0, 3 - len(self.low)))
        moments: Array = (square.sum() - square) / 12.0
        return moments

    def thickness(self) -> float:
        """Its shortest edge."""
        return float((self.high - self.low).min())

    def carried(self, way: Array) -> Box:
        """Both corners."""
        return Box(self.low + way, self.high + way)
