"""Polygons."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ecume.engine.shapes.lattices import fitted_cells, round_up, scaled_to
from ecume.engine.shapes.parts import Cells, Flags
from ecume.units import Array


class Polygon(NamedTuple):
    """Any simple polygon, vertices (V, 2) clockwise or counterclockwise."""

    vertices: Array

    def bounds(self) -> tuple[Array, Array]:
        """The bounding box."""
        return self.vertices.min(axis=0), self.vertices.max(axis=0)

    def inside(self, points: Array) -> Flags:
        """A ray to the right crosses an odd number of edges."""
        odd: Flags = self._crossings(points, np.array([1.0, 0.0])).sum(axis=1) % 2 == 1
        return odd

    def way_out(self, points: Array, direction: Array) -> Array:
        """The distance to the nearest edge ahead."""
        way: Array = self._distances(points, direction).min(axis=1)
        return way

    def cells(self, spacing: float, faces: Array | None = None) -> Cells:
        """Those inside of a lattice that fits the box around it."""
        around = fitted_cells(*self.bounds(), spacing)
        return scaled_to(around.those(self.inside(around.centers)), self.volume())

    def faces(self) -> Array:
        """None along the axes."""
        return np.zeros((0, 2))

    def volume_within(self, low: Array, high: Array) -> float | None:
        """That of the part inside."""
        rest = self.within(low, high)
        return 0.0 if rest is None else rest.volume()

    def within(self, low: Array, high: Array) -> Polygon | None:
        """The part inside a box, cut off at each face; None if empty. Lines of no width join several pieces."""
        rest = self.vertices
        for axis, sign, face in ((0, 1.0, low), (0, -1.0, high), (1, 1.0, low), (1, -1.0, high)):
            rest = _cut(rest, sign * (rest[:, axis] - face[axis]))
            if len(rest) < 3:
                return None
        return Polygon(rest)

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """Distance and normal of the nearest edge or corner."""
        first, edge = self.vertices, np.roll(self.vertices, -1, axis=0) - self.vertices
        away = points[:, None, :] - first[None]
        share = np.clip((away * edge).sum(axis=2) / (edge**2).sum(axis=1), 0.0, 1.0)
        away -= share[:, :, None] * edge
        length = np.linalg.norm(away, axis=2)
        best = np.argmin(length, axis=1)
        every = np.arange(len(points))
        gap, way = length[every, best], away[every, best]
        inside = self.inside(points)
        # On the edge itself there is no way: the edge's own normal is it.
        outward = np.stack([edge[:, 1], -edge[:, 0]], axis=1)[best] * np.sign(self._turn())
        on = gap < 1e-12 * np.abs(self.vertices).max()
        way = np.where(on[:, None], outward, np.where(inside[:, None], -way, way))
        return np.where(inside, -gap, gap), way / np.linalg.norm(way, axis=1)[:, None]

    def rim(self, spacing: float) -> Array:
        """Along every edge."""
        pieces = []
        for first, last in zip(self.vertices, np.roll(self.vertices, -1, axis=0), strict=True):
            share = np.linspace(0.0, 1.0, round_up(float(np.linalg.norm(last - first)), spacing), endpoint=False)
            pieces.append(first + share[:, None] * (last - first))
        return np.concatenate(pieces)

    def middle(self) -> Array:
        """The centroid, from the triangles between the first corner and each edge."""
        origin, (one, other, twice) = self.vertices[0], self._fan()
        center: Array = origin + (twice[:, None] * (one + other)).sum(axis=0) / (3.0 * twice.sum())
        return center

    def volume(self) -> float:
        """The area, by the shoelace formula."""
        return 0.5 * abs(self._turn())

    def surface(self) -> float:
        """Its edges, one after the other."""
        return float(np.linalg.norm(np.roll(self.vertices, -1, axis=0) - self.vertices, axis=1).sum())

    def inertia(self) -> Array:
        """The moments of inertia, from the same triangles, about the centroid."""
        one, other, twice = self._fan()
        parts = (one**2).sum(axis=1) + (other**2).sum(axis=1) + (one * other).sum(axis=1)
        about_corner = float((twice * parts).sum() / (6.0 * twice.sum()))
        apart = self.middle() - self.vertices[0]
        return np.array([0.0, 0.0, about_corner - float(apart @ apart)])

    def thickness(self) -> float:
        """The width of the convex hull: the narrowest strip has an edge on one of its lines."""
        edge = np.roll(self.vertices, -1, axis=0) - self.vertices
        across = np.stack([-edge[:, 1], edge[:, 0]], axis=1) / np.linalg.norm(edge, axis=1)[:, None]
        return float(np.ptp(self.vertices @ across.T, axis=0).min())

    def convex(self) -> bool:
        """Whether it turns the same way at every corner."""
        edge = np.roll(self.vertices, -1, axis=0) - self.vertices
        ahead = np.roll(edge, -1, axis=0)
        turn = (edge[:, 0] * ahead[:, 1] - edge[:, 1] * ahead[:, 0]) * np.sign(self._turn())
        return bool((turn >= -1e-12 * np.abs(turn).max()).all())

    def inset(self, depth: float, edges: Flags | None = None) -> Polygon | None:
        """The part of a convex polygon deeper than a distance below every edge, or below some; None if empty."""
        rest = self.vertices
        for k, (first, last) in enumerate(zip(self.vertices, np.roll(self.vertices, -1, axis=0), strict=True)):
            if edges is not None and not edges[k]:
                continue
            edge = (last - first) / np.linalg.norm(last - first)
            inward = np.array([-edge[1], edge[0]]) * np.sign(self._turn())
            rest = _cut(rest, (rest - first) @ inward - depth)
            if len(rest) < 3:
                return None
        return Polygon(rest)

    def carried(self, way: Array) -> Polygon:
        """Every corner."""
        return Polygon(self.vertices + way)

    def _fan(self) -> tuple[Array, Array, Array]:
        """Two edges of each triangle from the first corner, and twice its area with the sign of its sense."""
        one = self.vertices - self.vertices[0]
        other = np.roll(one, -1, axis=0)
        return one, other, one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]

    def _turn(self) -> float:
        return float(self._fan()[2].sum())

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


def _cut(vertices: Array, above: Array) -> Array:
    """What of a polygon is above a line, from each corner's height over it."""
    kept = []
    for k in range(len(vertices)):
        ahead = (k + 1) % len(vertices)
        if above[k] >= 0.0:
            kept.append(vertices[k])
        if (above[k] > 0.0) != (above[ahead] > 0.0) and above[k] != 0.0 != above[ahead]:
            share = above[k] / (above[k] - above[ahead])
            kept.append(vertices[k] + share * (vertices[ahead] - vertices[k]))
    return np.array(kept).reshape(-1, 2)
