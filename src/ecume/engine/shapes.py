"""Parts of space: which points are inside, and how far from a point inside a ray leaves. Points are (N, d)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ecume.units import Array

Flags = NDArray[np.bool_]


class Part(Protocol):
    """What a part of space can tell that is filled with liquid."""

    def bounds(self) -> tuple[Array, Array]:
        """Its lowest and highest corner, each (d,)."""

    def inside(self, points: Array) -> Flags:
        """(N,) whether each point is inside."""

    def way_out(self, points: Array, direction: Array) -> Array:
        """(N,) how far it is from each point inside to the boundary along a unit vector."""

    def anchor(self) -> Array:
        """A corner of the lattice that fits it best, (d,)."""


class Shape(Part, Protocol):
    """What it must tell besides, where it is solid."""

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """(N,) how far outside each point is (negative: inside), and (N, d) the slope of that: the way out."""

    def rim(self, spacing: float) -> Array:
        """(S, d) points of the boundary, its corners among them, no farther apart than the spacing."""

    def middle(self) -> Array:
        """(d,) the center of mass."""

    def volume(self) -> float:
        """An area in the plane."""

    def inertia(self) -> Array:
        """(3,) moments about the axes through the middle, of a unit mass; in the plane the last alone counts."""

    def thickness(self) -> float:
        """Between the two parallel lines or planes that hold it most narrowly."""

    def carried(self, way: Array) -> Shape:
        """The same shape, moved by (d,)."""


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

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """To the faces outside of which it is, or else to the nearest one."""
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

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """Along the radius; at the very center every way leads out, and the first axis is taken."""
        away = points - self.center
        length = np.linalg.norm(away, axis=1)
        first = np.eye(points.shape[1])[0]
        normal = np.where(length[:, None] > 0.0, away / np.where(length > 0.0, length, 1.0)[:, None], first)
        return length - self.radius, normal

    def rim(self, spacing: float) -> Array:
        """Evenly around a circle; a spiral with golden steps around a sphere."""
        if len(self.center) == 2:
            angle = np.linspace(0.0, 2.0 * np.pi, round_up(2.0 * np.pi * self.radius, spacing), endpoint=False)
            unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        else:
            count = 2 * round_up(4.0 * np.pi * self.radius**2, spacing**2)
            height = 1.0 - (2.0 * np.arange(count) + 1.0) / count
            angle = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
            around = np.sqrt(1.0 - height**2)
            unit = np.stack([around * np.cos(angle), around * np.sin(angle), height], axis=1)
        points: Array = self.center + self.radius * unit
        return points

    def middle(self) -> Array:
        """Its center."""
        return self.center

    def volume(self) -> float:
        """That of a disc, or of a sphere."""
        return np.pi * self.radius**2 * (1.0 if len(self.center) == 2 else 4.0 / 3.0 * self.radius)

    def inertia(self) -> Array:
        """r^2 / 2 of a disc, 2/5 r^2 of a sphere."""
        return np.full(3, (0.5 if len(self.center) == 2 else 0.4) * self.radius**2)

    def thickness(self) -> float:
        """The diameter."""
        return 2.0 * self.radius

    def carried(self, way: Array) -> Ball:
        """Its center."""
        return Ball(self.center + way, self.radius)


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

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """To the nearest edge or corner."""
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
        """Of the triangles between the first corner and each edge."""
        origin, (one, other, twice) = self.vertices[0], self._fan()
        center: Array = origin + (twice[:, None] * (one + other)).sum(axis=0) / (3.0 * twice.sum())
        return center

    def volume(self) -> float:
        """By the shoelace formula."""
        return 0.5 * abs(self._turn())

    def inertia(self) -> Array:
        """Of the same triangles, moved to the middle."""
        one, other, twice = self._fan()
        parts = (one**2).sum(axis=1) + (other**2).sum(axis=1) + (one * other).sum(axis=1)
        about_corner = float((twice * parts).sum() / (6.0 * twice.sum()))
        apart = self.middle() - self.vertices[0]
        return np.array([0.0, 0.0, about_corner - float(apart @ apart)])

    def thickness(self) -> float:
        """Of its hull: the narrowest strip has an edge on one of its lines."""
        edge = np.roll(self.vertices, -1, axis=0) - self.vertices
        across = np.stack([-edge[:, 1], edge[:, 0]], axis=1) / np.linalg.norm(edge, axis=1)[:, None]
        return float(np.ptp(self.vertices @ across.T, axis=0).min())

    def convex(self) -> bool:
        """Whether it turns the same way at every corner."""
        edge = np.roll(self.vertices, -1, axis=0) - self.vertices
        ahead = np.roll(edge, -1, axis=0)
        turn = (edge[:, 0] * ahead[:, 1] - edge[:, 1] * ahead[:, 0]) * np.sign(self._turn())
        return bool((turn >= -1e-12 * np.abs(turn).max()).all())

    def inset(self, depth: float) -> Polygon | None:
        """Of a convex one what is deeper than that below every edge; None where nothing is."""
        rest = self.vertices
        for first, last in zip(self.vertices, np.roll(self.vertices, -1, axis=0), strict=True):
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
    """What of a convex polygon is above a line, from each corner's height over it."""
    kept = []
    for k in range(len(vertices)):
        ahead = (k + 1) % len(vertices)
        if above[k] >= 0.0:
            kept.append(vertices[k])
        if (above[k] > 0.0) != (above[ahead] > 0.0) and above[k] != 0.0 != above[ahead]:
            share = above[k] / (above[k] - above[ahead])
            kept.append(vertices[k] + share * (vertices[ahead] - vertices[k]))
    return np.array(kept).reshape(-1, 2)


def round_up(length: float, spacing: float) -> int:
    """Into how many pieces a length is cut; rounding must not make one more."""
    return max(1, int(np.ceil(length / spacing - 1e-6)))


def lattice_in(shape: Part, spacing: float) -> Array:
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


def apart(points: Array, shapes: Sequence[Part]) -> Flags:
    """Which points are inside none of the shapes."""
    free = np.ones(len(points), bool)
    for shape in shapes:
        free &= ~shape.inside(points)
    return free
