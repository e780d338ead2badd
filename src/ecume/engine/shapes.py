"""Shapes of regions and solids: the points inside, their distances from the boundary, and for solids nearest points,
panels and inertia.

Points are (N, d). Lattices of equal cells fit into shapes: the volumes of the cells add up to that of the shape.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ecume._portable import cos, dot, length, product, sin
from ecume.units import Array

Flags = NDArray[np.bool_]
Integers = NDArray[np.int64]
MOST_CROSSINGS = 4_000_000
"""The number of pairs of a ray or point with a piece of a boundary that are processed at once."""


class Cells(NamedTuple):
    """A shape divided into small cells."""

    centers: Array
    """(N, d)"""
    volumes: Array
    """(N,); areas in 2D"""
    widths: Array
    """(N, d) along each axis"""

    def those(self, which: Flags) -> Cells:
        """The selected cells."""
        return Cells(self.centers[which], self.volumes[which], self.widths[which])


Panels = tuple[Array, Array, Array]
"""Pieces of a surface: middles (S, d), normals (S, d) outward, and areas (S,)."""


class Part(Protocol):
    """A region that liquid can fill."""

    def bounds(self) -> tuple[Array, Array]:
        """The lowest and the highest corner of the bounding box, each (d,)."""

    def extent_along(self, direction: Array) -> float:
        """The largest coordinate of the points of the region along a unit vector."""

    def inside(self, points: Array) -> Flags:
        """Flags (N,) of the points inside."""

    def way_out(self, points: Array, direction: Array) -> Array:
        """The distance (N,) from each point inside to the boundary along a unit vector."""

    def cells(self, spacing: float, faces: Array | None = None) -> Cells:
        """A lattice of cells that fits into the region, about as wide as the spacing; their volumes add up to its
        volume. `faces`, (k, d), are preferred coordinates of cell boundaries along each axis.
        """

    def faces(self) -> Array:
        """The coordinates (k, d) of its faces along each axis, if all its faces are normal to axes; otherwise none, (0,
        d).
        """

    def volume(self) -> float:
        """The volume; in 2D the area."""

    def volume_within(self, low: Array, high: Array) -> float | None:
        """The volume of the part of the region inside a box; None without a formula."""


class Shape(Part, Protocol):
    """A region that may be solid."""

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """The distance (N,) of each point from the surface, negative inside, and its gradient (N, d)."""

    def rim(self, spacing: float) -> Array:
        """Points (S, d) of the surface, including its corners, no farther apart than the spacing."""

    def panels(self, spacing: float) -> tuple[Array, Array, Array]:
        """Pieces of the surface no wider than the spacing: centers (S, d), outward normals (S, d), and areas (S,)."""

    def middle(self) -> Array:
        """The center of mass (d,)."""

    def surface(self) -> float:
        """The area of the surface; in 2D the length."""

    def inertia(self) -> Array:
        """The moments of inertia (3,) about the axes through the center, for unit mass; in 2D only the last is used."""

    def thickness(self) -> float:
        """The smallest distance of two parallel lines or planes that enclose the shape."""

    def carried(self, way: Array) -> Shape:
        """The same shape, moved by a vector (d,)."""


def whole_within(part: Part, low: Array, high: Array) -> float | None:
    """The volume of a region if a box contains all of it, otherwise None."""
    first, last = part.bounds()
    return part.volume() if (first >= low).all() and (last <= high).all() else None


def apart(points: Array, shapes: Sequence[Part]) -> Flags:
    """Flags of points outside of all shapes."""
    free = np.ones(len(points), bool)
    for shape in shapes:
        free &= ~shape.inside(points)
    return free


class Ball(NamedTuple):
    """A disc or a sphere."""

    center: Array
    radius: float

    def bounds(self) -> tuple[Array, Array]:
        """The bounding box."""
        return self.center - self.radius, self.center + self.radius

    def extent_along(self, direction: Array) -> float:
        """The coordinate of the center plus the radius."""
        return dot(self.center, direction) + self.radius * length(direction)

    def inside(self, points: Array) -> Flags:
        """Whether points are closer than the radius to the center."""
        square: Array = ((points - self.center) ** 2).sum(axis=1)
        return square < self.radius**2

    def way_out(self, points: Array, direction: Array) -> Array:
        """The remaining length of the chord."""
        away = points - self.center
        along = away @ direction
        way: Array = -along + np.sqrt(np.maximum(along**2 + self.radius**2 - (away**2).sum(axis=1), 0.0))
        return way

    def cells(self, spacing: float, faces: Array | None = None) -> Cells:
        """A square lattice with a corner at the center, as symmetric as the ball. It is stretched slightly about the
        center, so that its cells have the volume of the ball.
        """
        half = spacing * round_up(self.radius, spacing) * np.ones(len(self.center))
        away = fitted_cells(-half, half, spacing).centers
        away = away[(away**2).sum(axis=1) < self.radius**2]
        if len(away) == 0:  # smaller than a cell
            away = np.zeros((1, len(self.center)))
        volume = self.volume() / len(away)
        width = volume ** (1.0 / len(self.center))
        widths = np.full(away.shape, width)
        return Cells(self.center + width / spacing * away, np.full(len(away), volume), widths)

    def faces(self) -> Array:
        """No faces along the axes."""
        return np.zeros((0, len(self.center)))

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """The distance along the radius; at the center, where the direction is undefined, the first axis is used."""
        away = points - self.center
        length = np.linalg.norm(away, axis=1)
        first = np.eye(points.shape[1])[0]
        normal = np.where(length[:, None] > 0.0, away / np.where(length > 0.0, length, 1.0)[:, None], first)
        return length - self.radius, normal

    def rim(self, spacing: float) -> Array:
        """Points at equal distances on a circle, mirrored along both axes, or on a golden spiral around a sphere."""
        if len(self.center) == 2:
            count = 4 * round_up(0.5 * np.pi * self.radius, spacing)
            angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
            unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        else:
            count = 2 * round_up(4.0 * np.pi * self.radius**2, spacing**2)
            height = 1.0 - (2.0 * np.arange(count) + 1.0) / count
            angle = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
            around = np.sqrt(1.0 - height**2)
            unit = np.stack([around * np.cos(angle), around * np.sin(angle), height], axis=1)
        points: Array = self.center + self.radius * unit
        return points

    def panels(self, spacing: float) -> tuple[Array, Array, Array]:
        """The tangents of a circle with the same area, or the points of a spiral around a sphere."""
        if len(self.center) == 2:
            count = 4 * round_up(0.5 * np.pi * self.radius, spacing)
            angle = 2.0 * np.pi * (np.arange(count) + 0.5) / count
            normal = np.stack([cos(angle), sin(angle)], axis=1)
        else:
            normal = (self.rim(spacing) - self.center) / self.radius
        area = np.full(len(normal), self.surface() / len(normal))
        return self.center + self.radius * normal, normal, area

    def middle(self) -> Array:
        """The center."""
        return self.center

    def volume(self) -> float:
        """The area of a disc, or the volume of a sphere."""
        return np.pi * self.radius**2 * (1.0 if len(self.center) == 2 else 4.0 / 3.0 * self.radius)

    def volume_within(self, low: Array, high: Array) -> float | None:
        """The whole volume if the box contains the ball, otherwise None."""
        return whole_within(self, low, high)

    def surface(self) -> float:
        """The derivative of the volume with respect to the radius."""
        return len(self.center) * self.volume() / self.radius

    def inertia(self) -> Array:
        """The moments of inertia: r^2 / 2 of a disc, 2/5 r^2 of a sphere."""
        return np.full(3, (0.5 if len(self.center) == 2 else 0.4) * self.radius**2)

    def thickness(self) -> float:
        """The diameter."""
        return 2.0 * self.radius

    def carried(self, way: Array) -> Ball:
        """The ball around the moved center."""
        return Ball(self.center + way, self.radius)


class Box(NamedTuple):
    """A rectangle or a box between two corners."""

    low: Array
    high: Array

    def bounds(self) -> tuple[Array, Array]:
        """The lower and the upper corner."""
        return self.low, self.high

    def extent_along(self, direction: Array) -> float:
        """The largest coordinate of a corner."""
        return float(np.sum(np.maximum(self.low * direction, self.high * direction)))

    def inside(self, points: Array) -> Flags:
        """Whether points are between the corners."""
        return np.asarray(((points > self.low) & (points < self.high)).all(axis=1))

    def way_out(self, points: Array, direction: Array) -> Array:
        """The distance to the first face."""
        ahead = np.where(direction > 0.0, self.high - points, points - self.low)
        with np.errstate(divide="ignore"):
            ways = np.where(direction == 0.0, np.inf, ahead / np.abs(direction))
        way: Array = ways.min(axis=1)
        return way

    def cells(self, spacing: float, faces: Array | None = None) -> Cells:
        """The numbers of cells along each edge whose widths are closest to the spacing."""
        return fitted_cells(self.low, self.high, spacing, faces)

    def faces(self) -> Array:
        """The coordinates of its faces along the axes."""
        return np.array([self.low, self.high])

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """The distance and the normal of the nearest face; for points outside, from all faces that the point is
        beyond.
        """
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

    def panels(self, spacing: float) -> tuple[Array, Array, Array]:
        """Equal pieces of each face."""
        points, normals, areas = [], [], []
        dimension = len(self.low)
        for axis in range(dimension):
            cells = [fitted_axis(a, b, spacing) for a, b in zip(self.low, self.high, strict=True)]
            for side, at in ((-1.0, self.low), (1.0, self.high)):
                places = [at[axis : axis + 1] if k == axis else cells[k][0] for k in range(dimension)]
                face = np.stack([grid.ravel() for grid in np.meshgrid(*places, indexing="ij")], axis=1)
                points.append(face)
                normals.append(np.tile(side * np.eye(dimension)[axis], (len(face), 1)))
                areas.append(np.full(len(face), self.volume() / (self.high - self.low)[axis] / len(face)))
        return np.concatenate(points), np.concatenate(normals), np.concatenate(areas)

    def middle(self) -> Array:
        """The center between the corners."""
        center: Array = 0.5 * (self.low + self.high)
        return center

    def volume(self) -> float:
        """The product of its edges."""
        return float(np.prod(self.high - self.low))

    def volume_within(self, low: Array, high: Array) -> float | None:
        """The product of the overlaps of the edges."""
        edges = np.minimum(self.high, high) - np.maximum(self.low, low)
        return float(np.prod(np.maximum(edges, 0.0)))

    def surface(self) -> float:
        """Twice the sum of the volume over each edge."""
        return float(2.0 * (self.volume() / (self.high - self.low)).sum())

    def inertia(self) -> Array:
        """The moments of inertia, (b^2 + c^2) / 12 about the axis along a."""
        square = np.pad((self.high - self.low) ** 2, (0, 3 - len(self.low)))
        moments: Array = (square.sum() - square) / 12.0
        return moments

    def thickness(self) -> float:
        """The shortest edge."""
        return float((self.high - self.low).min())

    def carried(self, way: Array) -> Box:
        """The box between the moved corners."""
        return Box(self.low + way, self.high + way)


class Polygon(NamedTuple):
    """A simple polygon with vertices (V, 2), clockwise or counterclockwise."""

    vertices: Array

    def bounds(self) -> tuple[Array, Array]:
        """The bounding box."""
        return self.vertices.min(axis=0), self.vertices.max(axis=0)

    def extent_along(self, direction: Array) -> float:
        """The largest coordinate of a corner."""
        return float(product(self.vertices, direction).max())

    def inside(self, points: Array) -> Flags:
        """Whether a ray to the right crosses an odd number of edges."""
        count = np.zeros(len(points), np.int64)
        for point, _ in self._crossings(points, np.array([1.0, 0.0])):
            count += np.bincount(point, minlength=len(points))
        odd: Flags = count % 2 == 1
        return odd

    def way_out(self, points: Array, direction: Array) -> Array:
        """The distance to the nearest edge ahead."""
        way = np.full(len(points), np.inf)
        for point, distance in self._crossings(points, direction):
            np.minimum.at(way, point, distance)
        return way

    def cells(self, spacing: float, faces: Array | None = None) -> Cells:
        """The cells inside of a lattice that fits the bounding box."""
        around = fitted_cells(*self.bounds(), spacing)
        return scaled_to(around.those(self.inside(around.centers)), self.volume())

    def faces(self) -> Array:
        """No faces along the axes."""
        return np.zeros((0, 2))

    def volume_within(self, low: Array, high: Array) -> float | None:
        """The area of the part inside the box."""
        rest = self.within(low, high)
        return 0.0 if rest is None else rest.volume()

    def within(self, low: Array, high: Array) -> Polygon | None:
        """The part of the polygon inside a box, cut at each face; None if empty. Several pieces remain connected by
        lines of zero width.
        """
        rest = self.vertices
        for axis, sign, face in ((0, 1.0, low), (0, -1.0, high), (1, 1.0, low), (1, -1.0, high)):
            rest = _cut(rest, sign * (rest[:, axis] - face[axis]))
            if len(rest) < 3:
                return None
        return Polygon(rest)

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """Distance and normal of the nearest edge or corner."""
        some = max(MOST_CROSSINGS // len(self.vertices), 1)
        if len(points) > some:
            parts = [self.nearest(points[k : k + some]) for k in range(0, len(points), some)]
            gaps, normals = zip(*parts, strict=True)
            return np.concatenate(gaps), np.concatenate(normals)
        first, edge = self.vertices, np.roll(self.vertices, -1, axis=0) - self.vertices
        away = points[:, None, :] - first[None]
        share = np.clip((away * edge).sum(axis=2) / (edge**2).sum(axis=1), 0.0, 1.0)
        away -= share[:, :, None] * edge
        length = np.linalg.norm(away, axis=2)
        best = np.argmin(length, axis=1)
        every = np.arange(len(points))
        gap, way = length[every, best], away[every, best]
        inside = self.inside(points)
        # On an edge the direction is undefined, and the normal of the edge is used.
        outward = np.stack([edge[:, 1], -edge[:, 0]], axis=1)[best] * np.sign(self._turn())
        on = gap < 1e-12 * np.abs(self.vertices).max()
        way = np.where(on[:, None], outward, np.where(inside[:, None], -way, way))
        return np.where(inside, -gap, gap), way / np.linalg.norm(way, axis=1)[:, None]

    def rim(self, spacing: float) -> Array:
        """Points along every edge."""
        pieces = []
        for first, last in zip(self.vertices, np.roll(self.vertices, -1, axis=0), strict=True):
            share = np.linspace(0.0, 1.0, round_up(float(np.linalg.norm(last - first)), spacing), endpoint=False)
            pieces.append(first + share[:, None] * (last - first))
        return np.concatenate(pieces)

    def panels(self, spacing: float) -> tuple[Array, Array, Array]:
        """Equal pieces of each edge."""
        points, normals, areas = [], [], []
        for first, last in zip(self.vertices, np.roll(self.vertices, -1, axis=0), strict=True):
            way = last - first
            count = round_up(length(way), spacing)
            points.append(first + (np.arange(count) + 0.5)[:, None] / count * way)
            normals.append(np.tile(np.sign(self._turn()) * np.array([way[1], -way[0]]) / length(way), (count, 1)))
            areas.append(np.full(count, length(way) / count))
        return np.concatenate(points), np.concatenate(normals), np.concatenate(areas)

    def middle(self) -> Array:
        """The centroid, from the triangles between the first corner and each edge."""
        origin, (one, other, twice) = self.vertices[0], self._fan()
        center: Array = origin + (twice[:, None] * (one + other)).sum(axis=0) / (3.0 * twice.sum())
        return center

    def volume(self) -> float:
        """The area, by the shoelace formula."""
        return 0.5 * abs(self._turn())

    def surface(self) -> float:
        """The total length of the edges."""
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
        """Whether the polygon turns in the same direction at every corner."""
        edge = np.roll(self.vertices, -1, axis=0) - self.vertices
        ahead = np.roll(edge, -1, axis=0)
        turn = (edge[:, 0] * ahead[:, 1] - edge[:, 1] * ahead[:, 0]) * np.sign(self._turn())
        return bool((turn >= -1e-12 * np.abs(turn).max()).all())

    def inset(self, depth: float, edges: Flags | None = None) -> Polygon | None:
        """The part of a convex polygon deeper than a distance below every edge, or below some of
        them; None if empty.
        """
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
        """The polygon with moved corners."""
        return Polygon(self.vertices + way)

    def _fan(self) -> tuple[Array, Array, Array]:
        """Two edges of each triangle from the first corner, and twice its signed area."""
        one = self.vertices - self.vertices[0]
        other = np.roll(one, -1, axis=0)
        return one, other, one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]

    def _turn(self) -> float:
        return float(self._fan()[2].sum())

    def _crossings(self, points: Array, direction: Array) -> Iterator[tuple[Integers, Array]]:
        """Yield points, by index, with the distance along a ray to an edge ahead, for some edges at a time. Points are
        sorted across the rays, so that each edge is compared only with rays that can meet it.
        """
        ahead = np.array([direction[0], direction[1]])
        across = np.array([-direction[1], direction[0]])
        first, last = self.vertices, np.roll(self.vertices, -1, axis=0)
        start, end, beside = first @ across, last @ across, points @ across
        order = np.argsort(beside, kind="stable")
        # An end on the ray counts as above it, so that a vertex is crossed once.
        begin, until = (np.searchsorted(beside[order], f(start, end), side="right") for f in (np.minimum, np.maximum))
        ends, edge = np.cumsum(until - begin), 0
        while edge < len(first):
            before = ends[edge - 1] if edge else 0
            stop = max(int(np.searchsorted(ends, before + MOST_CROSSINGS, side="right")), edge + 1)
            k = np.repeat(np.arange(edge, stop), (until - begin)[edge:stop])
            point = order[np.arange(len(k)) - (ends - until)[k] + before]
            share = (beside[point] - start[k]) / (end - start)[k]
            place = (first @ ahead)[k] + share * (last @ ahead - first @ ahead)[k]
            distance = place - (points @ ahead)[point]
            yield point[distance > 0.0], distance[distance > 0.0]
            edge = stop


class Hollow(NamedTuple):
    """A block with a hole in it."""

    hole: Shape
    low: Array
    high: Array

    def bounds(self) -> tuple[Array, Array]:
        """The corners of the block."""
        return self.low, self.high

    def extent_along(self, direction: Array) -> float:
        """The extent of the block."""
        return Box(self.low, self.high).extent_along(direction)

    def inside(self, points: Array) -> Flags:
        """Whether points are outside of the hole."""
        return ~self.hole.inside(points)

    def way_out(self, points: Array, direction: Array) -> Array:
        """The distance to the end of the block, ignoring the hole."""
        return Box(self.low, self.high).way_out(points, direction)

    def cells(self, spacing: float, faces: Array | None = None) -> Cells:
        """The cells outside of the hole, of a lattice that fits the block."""
        around = fitted_cells(self.low, self.high, spacing)
        return scaled_to(around.those(self.inside(around.centers)), self.volume())

    def faces(self) -> Array:
        """No faces, since those of the block are outside of the liquid."""
        return np.zeros((0, len(self.low)))

    def volume(self) -> float:
        """The volume of the block minus that of the hole inside it."""
        hole = self.hole.volume_within(self.low, self.high)
        box = Box(self.low, self.high)
        return box.volume() - (_sampled_volume(box, self.hole, ()) if hole is None else hole)

    def volume_within(self, low: Array, high: Array) -> float | None:
        """The whole volume if the box contains the block, otherwise None."""
        return whole_within(self, low, high)

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """The distances and normals of the hole, with opposite signs."""
        gap, normal = self.hole.nearest(points)
        return -gap, -normal

    def rim(self, spacing: float) -> Array:
        """The points of the hole."""
        return self.hole.rim(spacing)

    def panels(self, spacing: float) -> tuple[Array, Array, Array]:
        """The panels of the hole that are in the block, with opposite normals."""
        points, normals, areas = self.hole.panels(spacing)
        within = ((points > self.low) & (points < self.high)).all(axis=1)
        return points[within], -normals[within], areas[within]

    def middle(self) -> Array:
        """The center of the block."""
        return Box(self.low, self.high).middle()

    def surface(self) -> float:
        """The surface of the hole."""
        return self.hole.surface()

    def inertia(self) -> Array:
        """NaN, since a hollow never rotates."""
        return np.full(3, np.inf)

    def thickness(self) -> float:
        """The thickness of the block."""
        return Box(self.low, self.high).thickness()

    def carried(self, way: Array) -> Hollow:
        """The block and the hole, moved."""
        return Hollow(self.hole.carried(way), self.low + way, self.high + way)


def _cut(vertices: Array, above: Array) -> Array:
    """The part of a polygon above a line, from the height of each corner over the line."""
    kept = []
    for k in range(len(vertices)):
        ahead = (k + 1) % len(vertices)
        if above[k] >= 0.0:
            kept.append(vertices[k])
        if (above[k] > 0.0) != (above[ahead] > 0.0) and above[k] != 0.0 != above[ahead]:
            share = above[k] / (above[k] - above[ahead])
            kept.append(vertices[k] + share * (vertices[ahead] - vertices[k]))
    return np.array(kept).reshape(-1, 2)


SAMPLES = {2: 500, 3: 64}
"""The number of points along each axis for volumes without a formula; their error is about 1e-4 of
the covered volume.
"""
AT_ONCE = 20_000


def covered_volume(part: Part, others: Sequence[Part]) -> float:
    """The volume of a region that is inside any of the others. It is exact for boxes in a box, and for polygons and
    whole balls and meshes in a box that touch no other shape; otherwise it is computed by sampling.
    """
    in_box = len(part.faces()) > 0
    boxes = [other for other in others if in_box and len(other.faces())]
    total, earlier = _covered_by_boxes(part, boxes) if boxes else 0.0, [*boxes]
    for other in others:
        if any(other is box for box in boxes):
            continue
        among = [each for each in earlier if bounds_meet(each, other)]
        exact = other.volume_within(*part.bounds()) if in_box and not among else None
        total += _sampled_volume(part, other, among) if exact is None else exact
        earlier.append(other)
    return total


def _covered_by_boxes(part: Part, boxes: Sequence[Part]) -> float:
    """The covered volume of a box. The faces of all boxes divide it into cells that are covered either completely or
    not at all.
    """
    low, high = part.bounds()
    faces = np.concatenate([np.clip(box.faces(), low, high) for box in boxes])
    axes = [np.unique([low[axis], *faces[:, axis], high[axis]]) for axis in range(len(low))]
    middles = [0.5 * (x[1:] + x[:-1]) for x in axes]
    centers = np.stack([grid.ravel() for grid in np.meshgrid(*middles, indexing="ij")], axis=1)
    widths = np.stack([grid.ravel() for grid in np.meshgrid(*map(np.diff, axes), indexing="ij")], axis=1)
    return float(np.prod(widths, axis=1)[~apart(centers, boxes)].sum())


def bounds_meet(one: Part, other: Part) -> bool:
    """Whether the bounding boxes of two regions overlap."""
    low, high = _common_bounds(one, other)
    return bool((low < high).all())


def _common_bounds(one: Part, other: Part) -> tuple[Array, Array]:
    (low, high), (lowest, highest) = one.bounds(), other.bounds()
    return np.maximum(low, lowest), np.minimum(high, highest)


def _sampled_volume(part: Part, other: Part, earlier: Sequence[Part]) -> float:
    """The volume of the points that are in both regions but not in earlier ones, by sampling on a lattice."""
    low, high = _common_bounds(part, other)
    if not (low < high).all():
        return 0.0
    axes = [fitted_axis(a, b, (b - a) / SAMPLES[len(low)])[0] for a, b in zip(low, high, strict=True)]
    points = np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1)
    found = 0
    for first in range(0, len(points), AT_ONCE):
        some = points[first : first + AT_ONCE]
        some = some[other.inside(some)]
        some = some[apart(some, earlier)]
        found += int(np.count_nonzero(part.inside(some))) if len(some) else 0
    return float(np.prod(high - low)) * found / len(points)


SAME = 1e-9
"""Relative difference below which a fitted width is set to the spacing, so that rounding in a scene changes no bit."""
ROUNDING = 1e-13
"""The relative rounding error of a sum of volumes."""
NARROWEST = 0.5
"""The smallest width of a cell, in spacings."""


def round_up(length: float, spacing: float) -> int:
    """The number of pieces into which a length is cut, rounded up except for rounding errors."""
    return max(1, int(np.ceil(length / spacing - 1e-6)))


def fitted_axis(low: float, high: float, spacing: float) -> tuple[Array, Array]:
    """Centers and widths of equal cells between two ends; their number is such that the width is nearest to the
    spacing.

    >>> fitted_axis(0.0, 1.0, 0.3)[1].tolist()
    [0.3333333333333333, 0.3333333333333333, 0.3333333333333333]
    """
    count = max(1, round((high - low) / spacing))
    width = (high - low) / count
    if abs(width - spacing) <= SAME * spacing:
        width = spacing
    return low + width * np.arange(0.5, count), np.full(count, width)


def fitted_cells(low: Array, high: Array, spacing: float, faces: Array | None = None) -> Cells:
    """The cells of a box. Along each axis cells end at `faces`, (k, d) coordinates, unless a piece between two faces
    would be narrower than half a spacing.
    """
    axes = []
    for axis, (first, last) in enumerate(zip(low, high, strict=True)):
        ends = [first, *(() if faces is None else _apart(faces[:, axis], first, last, NARROWEST * spacing)), last]
        pieces = [fitted_axis(start, end, spacing) for start, end in itertools.pairwise(map(float, ends))]
        axes.append(tuple(np.concatenate(both) for both in zip(*pieces, strict=True)))
    centers, widths = (
        np.stack([grid.ravel() for grid in np.meshgrid(*each, indexing="ij")], axis=1)
        for each in zip(*axes, strict=True)
    )
    return Cells(centers, np.prod(widths, axis=1), widths)


def _apart(faces: Iterable[float], first: float, last: float, least: float) -> list[float]:
    """The coordinates between two ends, sorted, without those closer to an end or to the previous one than the smallest
    distance.
    """
    found = [first]
    for face in sorted(faces):
        if face - found[-1] >= least and last - face >= least:
            found.append(face)
    return found[1:]


def scaled_to(cells: Cells, volume: float) -> Cells:
    """The same cells with volumes scaled to this sum; unchanged if they already have it."""
    total = float(cells.volumes.sum())
    if total == 0.0 or abs(total - volume) <= ROUNDING * volume:
        return cells
    return cells._replace(volumes=cells.volumes * (volume / total))
