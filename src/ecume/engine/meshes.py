"""Parts of space that no formula describes: inside a closed surface of triangles, or around given points."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ecume._portable import product
from ecume.engine.shapes import Cells, Flags, fitted_cells, scaled_to, whole_within
from ecume.units import Array

OBLIQUE = np.array([0.53779, 0.61803, 0.57309])
"""A direction along which no edge of a drawn thing lies: a ray through an edge would count two crossings."""
MOST_CROSSINGS = 4_000_000
"""Pairs of ray and triangle that are looked at together."""


class Mesh(NamedTuple):
    """Inside a closed surface of triangles, (T, 3, 3): corners in meters."""

    triangles: Array

    def bounds(self) -> tuple[Array, Array]:
        """The bounding box."""
        return self.triangles.min(axis=(0, 1)), self.triangles.max(axis=(0, 1))

    def inside(self, points: Array) -> Flags:
        """A ray crosses an odd number of triangles."""
        found = np.zeros(len(points), bool)
        for part in self._parts(len(points)):
            found[part] = np.isfinite(self._distances(points[part], OBLIQUE)).sum(axis=1) % 2 == 1
        return found

    def way_out(self, points: Array, direction: Array) -> Array:
        """To the nearest triangle ahead; nothing where none is."""
        way = np.zeros(len(points))
        for part in self._parts(len(points)):
            way[part] = self._distances(points[part], direction).min(axis=1)
        return np.where(np.isfinite(way), way, 0.0)

    def cells(self, spacing: float, faces: Array | None = None) -> Cells:
        """Those inside of a lattice that fits the box around it."""
        around = fitted_cells(*self.bounds(), spacing)
        return scaled_to(around.those(self.inside(around.centers)), self.volume())

    def faces(self) -> Array:
        """None along the axes."""
        return np.zeros((0, 3))

    def volume(self) -> float:
        """Of the tetrahedra between the first corner and each triangle (divergence theorem)."""
        corners = self.triangles - self.triangles[0, 0]
        return abs(float((corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum())) / 6.0

    def volume_within(self, low: Array, high: Array) -> float | None:
        """All of it, or no formula."""
        return whole_within(self, low, high)

    def _parts(self, count: int) -> list[slice]:
        """So many points that the table of distances stays small."""
        step = max(1, MOST_CROSSINGS // len(self.triangles))
        return [slice(first, first + step) for first in range(0, count, step)]

    def _distances(self, points: Array, direction: Array) -> Array:
        """(N, T) from each point along a ray to each triangle; infinite where it misses."""
        corner = self.triangles[:, 0]
        one, other = self.triangles[:, 1] - corner, self.triangles[:, 2] - corner
        across = np.cross(direction, other)
        beside, normal = np.cross(one, direction), np.cross(one, other)
        volume = (one * across).sum(axis=1)
        # A ray along a triangle's own plane misses it.
        volume = np.where(volume == 0.0, np.nan, volume)
        u = (product(points, across.T) - (corner * across).sum(axis=1)) / volume
        v = (product(points, beside.T) - (corner * beside).sum(axis=1)) / volume
        way = (product(points, normal.T) - (corner * normal).sum(axis=1)) / volume
        hit = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (way > 0.0)
        found: Array = np.where(hit, way, np.inf)
        return found


class Cloud(NamedTuple):
    """Around points, (N, d), half a spacing far along each axis."""

    points: Array
    spacing: float

    def bounds(self) -> tuple[Array, Array]:
        """The bounding box."""
        half = 0.5 * self.spacing
        return self.points.min(axis=0) - half, self.points.max(axis=0) + half

    def inside(self, points: Array) -> Flags:
        """Closer to one of them than half a spacing, along each axis."""
        distance, _ = cKDTree(self.points).query(points, p=np.inf)
        return np.asarray(distance < 0.5 * self.spacing)

    def way_out(self, points: Array, direction: Array) -> Array:
        """To the last of its points ahead in a column one spacing wide, and half a spacing more; along an axis."""
        axis = int(np.argmax(np.abs(direction)))
        ahead = np.sign(direction[axis])
        columns = np.floor(np.delete(self.points - self.bounds()[0], axis, axis=1) / self.spacing)
        mine = np.floor(np.delete(points - self.bounds()[0], axis, axis=1) / self.spacing)
        _, number = np.unique(np.concatenate([columns, mine]), axis=0, return_inverse=True)
        number = number.ravel()
        last = np.full(number.max() + 1, -np.inf)
        np.maximum.at(last, number[: len(self.points)], ahead * self.points[:, axis])
        way = last[number[len(self.points) :]] - ahead * points[:, axis] + 0.5 * self.spacing
        found: Array = np.maximum(way, 0.0)
        return found

    def cells(self, spacing: float, faces: Array | None = None) -> Cells:
        """One cell for each point, whatever the spacing."""
        widths = np.full(self.points.shape, self.spacing)
        return Cells(self.points, np.prod(widths, axis=1), widths)

    def faces(self) -> Array:
        """None along the axes."""
        return np.zeros((0, self.points.shape[1]))

    def volume(self) -> float:
        """A cell for each point."""
        return float(len(self.points) * self.spacing ** self.points.shape[1])

    def volume_within(self, low: Array, high: Array) -> float | None:
        """All of it, or no formula."""
        return whole_within(self, low, high)
