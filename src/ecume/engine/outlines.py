"""Outlines and closed meshes: bodies in 2D with distance, nearest points and normal of two, and parts of space that no
formula describes.

The distance of two ellipses is the width of the widest strip between them; the direction of this strip is found by a
search.

An outline is an ellipse (a disc is a special case), or the area that a disc covers while it moves along edges: a needle
has one edge, a square four, a star as many as it has arms. All contacts but those of two ellipses are therefore
contacts of discs and straight edges, for convex shapes and others. Contacts of two ellipses are those of
`ellipses_near`.

Parts of space without a formula are the inside of a closed surface of triangles, or cubes around given points.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume._portable import length, product
from ecume.engine.cells import Integers, nearest
from ecume.engine.nearest_triangles import nearest_triangles
from ecume.engine.shapes import MOST_CROSSINGS, Cells, Flags, fitted_cells, round_up, scaled_to, whole_within
from ecume.engine.walls import Walls, is_circle, wall_distance
from ecume.errors import BadInput
from ecume.units import Array

DIRECTIONS = 7
"""The number of directions on either side of the line of centers among which the best is chosen for refinement."""
Ellipse = tuple[float, float, float]
"""Semi-axes, and the angle of the first."""
Near = tuple[float, float, float, float, float, float, float]
"""The gap, the normal from one to the other, and the nearest points, relative to the center of each."""


@compiled_inside
def breadth(ellipse: Ellipse, direction: float) -> tuple[float, float, float]:
    """The support function of an ellipse, h = sqrt(a^2 cos^2 + b^2 sin^2), and its first two derivatives."""
    a, b, turn = ellipse
    c, s = math.cos(direction - turn), math.sin(direction - turn)
    h = math.sqrt(a * a * c * c + b * b * s * s)
    slope = (b * b - a * a) * c * s / h
    return h, slope, ((b * b - a * a) * (c * c - s * s) - slope * slope) / h


@compiled_inside
def farthest_point(ellipse: Ellipse, direction: float) -> tuple[float, float]:
    """The point of an ellipse farthest in a direction: h u + h' (u turned by 90 degrees)."""
    h, slope, _ = breadth(ellipse, direction)
    c, s = math.cos(direction), math.sin(direction)
    return h * c - slope * s, h * s + slope * c


@compiled_inside
def strip(x: float, y: float, one: Ellipse, other: Ellipse, direction: float) -> tuple[float, float, float]:
    """The width of the strip between two ellipses across a direction, negative where they overlap, and its first two
    derivatives.
    """
    c, s = math.cos(direction), math.sin(direction)
    h, slope, bend = breadth(one, direction)
    h_other, slope_other, bend_other = breadth(other, direction)
    along = x * c + y * s
    return along - h - h_other, y * c - x * s - slope - slope_other, -along - bend - bend_other


@compiled
def widest_strip(x: float, y: float, one: Ellipse, other: Ellipse, reach: float) -> float:
    """The direction of the widest strip between two ellipses; any direction with a width above
    `reach`.

    For separate ellipses the width has one maximum; for overlapping ones it has several, of which the highest is used.
    It is bracketed around the best of some directions, including those across each ellipse, and found by Newton's
    method.
    """
    ahead = math.atan2(y, x)
    best, direction = strip(x, y, one, other, ahead)[0], ahead
    if best > reach or (one[0] == one[1] and other[0] == other[1]):
        return ahead
    for k in range(2 * DIRECTIONS + 4):
        if k < 4:
            tried = (one[2] if k < 2 else other[2]) + (0.5 if k % 2 == 0 else -0.5) * math.pi
        else:
            side = k - 3 - DIRECTIONS
            tried = ahead + side * 0.5 * math.pi / (DIRECTIONS + 1)
        width = strip(x, y, one, other, tried)[0]
        if width > reach:
            return tried
        if width > best:
            best, direction = width, tried
    return climb(x, y, one, other, direction)


@compiled
def climb(x: float, y: float, one: Ellipse, other: Ellipse, direction: float) -> float:
    """The direction of the local maximum of the width of the strip, found as the zero of its derivative near a
    direction.
    """
    slope = strip(x, y, one, other, direction)[1]
    if slope == 0.0:
        return direction
    step = math.copysign(0.01, slope)
    near, far = direction, direction + step
    for _ in range(12):
        if strip(x, y, one, other, far)[1] * slope <= 0.0:
            break
        step *= 2.0
        near, far = far, far + step
    found = 0.5 * (near + far)
    for _ in range(80):
        _, value, bend = strip(x, y, one, other, found)
        if value * slope > 0.0:
            near = found
        else:
            far = found
        # Newton's step if it stays in the bracket, otherwise bisection.
        going = found - value / bend if bend < 0.0 else far
        if (going - near) * (going - far) >= 0.0:
            going = 0.5 * (near + far)
        if abs(going - found) <= 1e-15 * (1.0 + abs(found)):
            return going
        found = going
    return found


@compiled
def ellipses_near(x: float, y: float, one: Ellipse, other: Ellipse, reach: float) -> Near:
    """The nearest points of two ellipses whose centers differ by (x, y); a gap above `reach` is only a lower bound."""
    direction = widest_strip(x, y, one, other, reach)
    gap = strip(x, y, one, other, direction)[0]
    on_one, on_other = farthest_point(one, direction), farthest_point(other, direction)
    return gap, math.cos(direction), math.sin(direction), on_one[0], on_one[1], -on_other[0], -on_other[1]


@compiled
def farthest_from_origin(x: float, y: float, ellipse: Ellipse) -> float:
    """The direction of the point of an ellipse with center (x, y) that is farthest from the origin.

    Fixed-point iteration, in the direction of the farthest point so far, never increases the error; Newton's method
    then completes it.
    """
    direction = math.atan2(y, x)
    for _ in range(4):
        far_x, far_y = farthest_point(ellipse, direction)
        direction = math.atan2(y + far_y, x + far_x)
    for _ in range(20):
        _, slope, bend = breadth(ellipse, direction)
        c, s = math.cos(direction), math.sin(direction)
        value, change = c * y - s * x + slope, bend - c * x - s * y
        if change >= 0.0:
            far_x, far_y = farthest_point(ellipse, direction)
            direction = math.atan2(y + far_y, x + far_x)
        else:
            direction -= value / change
            if abs(value) <= 1e-15 * abs(change):
                break
    return direction


NEARNESS = 8
"""The length of the record of a near feature: gap, normal, both lever arms, and the index of the feature."""


class Outlines(NamedTuple):
    """The outlines of all bodies, each in its own frame with the center at the origin."""

    axes: Array
    """(N, 2) semi-axes of an ellipse, the first along the body's own direction; zero for a body with corners"""
    rounding: Array
    """(N,) radius of the disc that runs along corners and edges"""
    corner: Array
    """(V, 2)"""
    first_corner: Integers
    """(N + 1,)"""
    edge: Integers
    """(E, 2) the corners that it joins"""
    first_edge: Integers
    """(N + 1,)"""


class Stance(NamedTuple):
    """The positions and angles of all bodies."""

    position: Array
    """(N, 2)"""
    angle: Array
    """(N,)"""
    corner: Array
    """(V, 2) relative to the center of the corner's body"""
    periods: Array = np.zeros((2, 2))
    """of the cell: see `cells`; zero without a cell"""


@compiled_inside
def between(stance: Stance, i: int, j: int) -> tuple[float, float]:
    """The vector from the center of body i to that of the nearest image of body j."""
    (position, _, _, periods) = stance
    x = nearest(position[j, 0] - position[i, 0], periods[0, 0], periods[1, 0])
    return x, nearest(position[j, 1] - position[i, 1], periods[0, 1], periods[1, 1])


@compiled
def turn_corners(outlines: Outlines, stance: Stance) -> None:
    """Compute the positions of the corners at the present angles."""
    for i in range(len(stance.angle)):
        c, s = math.cos(stance.angle[i]), math.sin(stance.angle[i])
        for k in range(outlines.first_corner[i], outlines.first_corner[i + 1]):
            x, y = outlines.corner[k, 0], outlines.corner[k, 1]
            stance.corner[k, 0], stance.corner[k, 1] = c * x - s * y, s * x + c * y


@compiled_inside
def discs_near(x: float, y: float, one: float, other: float) -> tuple[float, float, float]:
    """The gap of two discs and the direction from one to the other; the x axis if the centers coincide."""
    distance = math.sqrt(x * x + y * y)
    if distance == 0.0:
        return -one - other, 1.0, 0.0
    return distance - one - other, x / distance, y / distance


@compiled_inside
def beside_edge(point_x: float, point_y: float, ends: tuple[float, float, float, float]) -> tuple[float, float, float]:
    """The projection of a point on an edge (0 to 1 between its ends), and the normal of the edge on the side of the
    point.
    """
    x, y, to_x, to_y = ends
    along_x, along_y = to_x - x, to_y - y
    length = math.sqrt(along_x * along_x + along_y * along_y)
    across = (along_x * (point_y - y) - along_y * (point_x - x)) / length
    place = (along_x * (point_x - x) + along_y * (point_y - y)) / (length * length)
    side = 1.0 if across >= 0.0 else -1.0
    return place, -side * along_y / length, side * along_x / length


@compiled_inside
def edge_ends(outlines: Outlines, stance: Stance, edge: int) -> tuple[float, float, float, float]:
    """The ends of an edge, relative to the center of its body."""
    k, m = outlines.edge[edge, 0], outlines.edge[edge, 1]
    return stance.corner[k, 0], stance.corner[k, 1], stance.corner[m, 0], stance.corner[m, 1]


@compiled_inside
def note(near: Array, found: int, found_near: Near, feature: int) -> int:
    """Record a near feature; return the number of features."""
    if found == len(near):
        return found
    row = near[found]
    row[0], row[1], row[2], row[3], row[4], row[5], row[6] = found_near
    row[7] = feature
    return found + 1


@compiled
def corners_near(outlines: Outlines, stance: Stance, pair: tuple[int, int], reach: float, near: Array) -> int:
    """Record the corners of one body near corners of another."""
    i, j = pair
    x, y = between(stance, i, j)
    one, other, found, feature = outlines.rounding[i], outlines.rounding[j], 0, 0
    for k in range(outlines.first_corner[i], outlines.first_corner[i + 1]):
        for m in range(outlines.first_corner[j], outlines.first_corner[j + 1]):
            own_x, own_y = stance.corner[k, 0], stance.corner[k, 1]
            its_x, its_y = stance.corner[m, 0], stance.corner[m, 1]
            gap, to_x, to_y = discs_near(x + its_x - own_x, y + its_y - own_y, one, other)
            if gap < reach:
                place = (
                    gap, to_x, to_y, own_x + one * to_x, own_y + one * to_y, its_x - other * to_x, its_y - other * to_y
                )  # fmt: skip
                found = note(near, found, place, feature)
            feature += 1
    return found


@compiled
def corners_near_edges(
    outlines: Outlines, stance: Stance, pair: tuple[int, int], reach: float, near: Array, found: int
) -> int:
    """Record the corners of the pair's first body near edges of its second, after the `found`
    features recorded so far.
    """
    i, j = pair
    x, y = between(stance, i, j)
    one, other = outlines.rounding[i], outlines.rounding[j]
    feature = 1000 if i < j else 2000
    for k in range(outlines.first_corner[i], outlines.first_corner[i + 1]):
        own_x, own_y = stance.corner[k, 0], stance.corner[k, 1]
        for edge in range(outlines.first_edge[j], outlines.first_edge[j + 1]):
            ends = edge_ends(outlines, stance, edge)
            place, up_x, up_y = beside_edge(own_x - x, own_y - y, ends)
            gap = (own_x - x - ends[0]) * up_x + (own_y - y - ends[1]) * up_y - one - other
            if 0.0 < place < 1.0 and gap < reach:
                foot_x = ends[0] + place * (ends[2] - ends[0]) + other * up_x
                foot_y = ends[1] + place * (ends[3] - ends[1]) + other * up_y
                at = (gap, -up_x, -up_y, own_x - one * up_x, own_y - one * up_y, foot_x, foot_y)
                found = note(near, found, at if i < j else flipped(at), feature)
            feature += 1
    return found


@compiled_inside
def flipped(near: Near) -> Near:
    """The same record with the two bodies exchanged."""
    return near[0], -near[1], -near[2], near[5], near[6], near[3], near[4]


@compiled_inside
def ellipse_of(outlines: Outlines, stance: Stance, i: int) -> Ellipse:
    """The ellipse of a body at its present angle."""
    return outlines.axes[i, 0], outlines.axes[i, 1], stance.angle[i]


@compiled
def ellipse_near_corners(
    outlines: Outlines, stance: Stance, pair: tuple[int, int], reach: float, near: Array, found: int
) -> int:
    """Record the corners and edges of the pair's second body near its first, an ellipse."""
    i, j = pair
    x, y = between(stance, i, j)
    ellipse, rounding, feature = ellipse_of(outlines, stance, i), outlines.rounding[j], 0
    for m in range(outlines.first_corner[j], outlines.first_corner[j + 1]):
        its_x, its_y = stance.corner[m, 0], stance.corner[m, 1]
        one = ellipses_near(x + its_x, y + its_y, ellipse, (rounding, rounding, 0.0), reach)
        if one[0] < reach:
            at = (one[0], one[1], one[2], one[3], one[4], its_x + one[5], its_y + one[6])
            found = note(near, found, at if i < j else flipped(at), feature)
        feature += 1
    for edge in range(outlines.first_edge[j], outlines.first_edge[j + 1]):
        ends = edge_ends(outlines, stance, edge)
        _, up_x, up_y = beside_edge(-x, -y, ends)
        low_x, low_y = farthest_point(ellipse, math.atan2(-up_y, -up_x))
        place, _, _ = beside_edge(low_x - x, low_y - y, ends)
        gap = (low_x - x - ends[0]) * up_x + (low_y - y - ends[1]) * up_y - rounding
        if 0.0 < place < 1.0 and gap < reach:
            foot_x = ends[0] + place * (ends[2] - ends[0]) + rounding * up_x
            foot_y = ends[1] + place * (ends[3] - ends[1]) + rounding * up_y
            at = (gap, -up_x, -up_y, low_x, low_y, foot_x, foot_y)
            found = note(near, found, at if i < j else flipped(at), feature)
        feature += 1
    return found


@compiled
def bodies_near(outlines: Outlines, stance: Stance, i: int, j: int, reach: float, near: Array) -> int:
    """Record all features at which two bodies, i < j, are nearer than `reach`, as far as there is room; return their
    number.
    """
    smooth_i, smooth_j = outlines.axes[i, 0] > 0.0, outlines.axes[j, 0] > 0.0
    if smooth_i and smooth_j:
        x, y = between(stance, i, j)
        one = ellipses_near(x, y, ellipse_of(outlines, stance, i), ellipse_of(outlines, stance, j), reach)
        return note(near, 0, one, 0) if one[0] < reach else 0
    if smooth_i:
        return ellipse_near_corners(outlines, stance, (i, j), reach, near, 0)
    if smooth_j:
        return ellipse_near_corners(outlines, stance, (j, i), reach, near, 0)
    found = corners_near(outlines, stance, (i, j), reach, near)
    found = corners_near_edges(outlines, stance, (i, j), reach, near, found)
    return corners_near_edges(outlines, stance, (j, i), reach, near, found)


@compiled
def wall_near(
    outlines: Outlines, stance: Stance, walls: Walls, pair: tuple[int, int], reach: float, near: Array
) -> int:
    """Record all features at which body i is nearer than `reach` to wall number k, of the pair (i, k); return their
    number.
    """
    i, number = pair
    x, y = stance.position[i, 0], stance.position[i, 1]
    if outlines.axes[i, 0] > 0.0:
        ellipse = ellipse_of(outlines, stance, i)
        if is_circle(walls, number):
            direction = farthest_from_origin(x, y, ellipse)
        else:
            _, in_x, in_y = wall_distance(walls, number, x, y)
            direction = math.atan2(-in_y, -in_x)
        far_x, far_y = farthest_point(ellipse, direction)
        gap, in_x, in_y = wall_distance(walls, number, x + far_x, y + far_y)
        return note(near, 0, (gap, -in_x, -in_y, far_x, far_y, 0.0, 0.0), 0) if gap < reach else 0
    found, rounding = 0, outlines.rounding[i]
    for k in range(outlines.first_corner[i], outlines.first_corner[i + 1]):
        own_x, own_y = stance.corner[k, 0], stance.corner[k, 1]
        distance, in_x, in_y = wall_distance(walls, number, x + own_x, y + own_y)
        if distance - rounding < reach:
            at = (distance - rounding, -in_x, -in_y, own_x - rounding * in_x, own_y - rounding * in_y, 0.0, 0.0)
            found = note(near, found, at, k - outlines.first_corner[i])
    return found


OBLIQUE = np.array([0.53779, 0.61803, 0.57309])
"""A direction along which drawn objects have no edges: a ray through an edge would count two crossings."""
MOST_BUCKETS = 1024
"""The largest number of buckets along each side of the table of triangles."""
COLUMNS = 300
"""The number of rays along each side of the box around overlapping shells, which measure the enclosed volume within
about 1e-4.
"""
ON_SURFACE, ON_AXES = 1e-12, 1e-9
"""Tolerances: the distance of a point on the surface over the size of the mesh, and products of inertia over the
moments.
"""
OVERLAP, SAME = 1e-4, 1e-9
"""The fraction of a volume above which shells count as overlapping, and the distance over the height below which two
crossings count as one.
"""


class Crossings(NamedTuple):
    """The crossings of rays and triangles."""

    ray: Integers
    """the index of the ray's point"""
    distance: Array
    """from the point, positive ahead"""
    way: Integers
    """1 where the ray leaves, -1 where it enters, by the orientation of the triangle"""


class Buckets(NamedTuple):
    """Triangles projected along a direction, and the list of those in each bucket of a table."""

    axes: Array
    """(2, 3) across the direction"""
    low: Array
    """(2,)"""
    size: Array
    """(2,) of a bucket"""
    shape: Integers
    """(2,) buckets along each axis"""
    first: Integers
    """index of the first triangle of each bucket in `triangle`, and the end of the last"""
    triangle: Integers

    def of(self, points: Array) -> tuple[Integers, Flags]:
        """The bucket of each point, and whether it is inside the table."""
        place = np.floor((product(points, self.axes.T) - self.low) / self.size).astype(np.int64)
        within: Flags = np.asarray(((place >= 0) & (place < self.shape)).all(axis=1))
        bucket: Integers = np.where(within, place[:, 0] * self.shape[1] + place[:, 1], 0)
        return bucket, within


def sorted_in(triangles: Array, direction: Array) -> Buckets:
    """Buckets of triangles, about as many as triangles."""
    least = np.eye(3)[int(np.argmin(np.abs(direction)))]
    one = np.cross(direction, least)
    axes = np.stack([one / np.linalg.norm(one), np.cross(direction, one) / np.linalg.norm(np.cross(direction, one))])
    flat = product(triangles.reshape(-1, 3), axes.T).reshape(-1, 3, 2)
    low, high = flat.min(axis=(0, 1)), flat.max(axis=(0, 1))
    count = int(np.clip(math.ceil(math.sqrt(len(triangles))), 1, MOST_BUCKETS))
    size, shape = np.maximum((high - low) / count, 1e-300) * (1.0 + 1e-9), np.array([count, count])
    start = np.clip(((flat.min(axis=1) - low) / size).astype(np.int64), 0, count - 1)
    end = np.clip(((flat.max(axis=1) - low) / size).astype(np.int64), 0, count - 1)
    spans = end - start + 1
    each = spans.prod(axis=1)
    triangle = np.repeat(np.arange(len(triangles)), each)
    number = np.arange(len(triangle)) - np.repeat(np.cumsum(each) - each, each)
    bucket = (
        (start[triangle, 0] + number // spans[triangle, 1]) * count + start[triangle, 1] + number % spans[triangle, 1]
    )
    order = np.argsort(bucket, kind="stable")
    first = np.searchsorted(bucket[order], np.arange(count * count + 1))
    return Buckets(axes, low, size, shape, first, triangle[order])


class Mesh(NamedTuple):
    """The space inside a closed surface of triangles (T, 3, 3), in meters; for overlapping shells, inside of any of
    them.
    """

    triangles: Array

    def bounds(self) -> tuple[Array, Array]:
        """The bounding box."""
        return self.triangles.min(axis=(0, 1)), self.triangles.max(axis=(0, 1))

    def extent_along(self, direction: Array) -> float:
        """The largest extent along a direction, at a corner."""
        return float(product(self.triangles.reshape(-1, 3), direction).max())

    def inside(self, points: Array) -> Flags:
        """Whether points are inside: the winding number along a ray is not zero."""
        winding = np.zeros(len(points))
        for found in self._crossings(points, OBLIQUE):
            winding += np.bincount(found.ray, found.way, len(points))
        return np.asarray(winding != 0.0)

    def contains(self, points: Array) -> bool:
        """Whether all points are inside."""
        low, high = self.bounds()
        return bool(((points >= low) & (points <= high)).all()) and bool(self.inside(points).all())

    def way_out(self, points: Array, direction: Array) -> Array:
        """The distance to the nearest triangle ahead; zero if the ray meets no triangle."""
        way = np.full(len(points), np.inf)
        for found in self._crossings(points, direction):
            np.minimum.at(way, found.ray, found.distance)
        return np.where(np.isfinite(way), way, 0.0)

    def cells(self, spacing: float, faces: Array | None = None) -> Cells:
        """The cells inside of a lattice that fits the bounding box."""
        around = fitted_cells(*self.bounds(), spacing)
        return scaled_to(around.those(self.inside(around.centers)), self.volume())

    def faces(self) -> Array:
        """No faces along the axes."""
        return np.zeros((0, 3))

    def volume(self) -> float:
        """The volume of the tetrahedra between the first corner and each triangle (divergence theorem); for overlapping
        shells, from the lengths of many parallel rays.
        """
        return _volume_of(self.triangles.tobytes())[0]

    def overlaps(self) -> bool:
        """Whether some of its shells overlap."""
        return _volume_of(self.triangles.tobytes())[1]

    def lengths(self) -> tuple[float, float, float]:
        """The lengths of parallel rays along z: inside the mesh, and inside more than one shell; and the area per ray.
        A ray through an edge meets both of its triangles, but counts one.
        """
        low, high = self.bounds()
        cell = (high - low)[:2] / COLUMNS
        # Between the nodes of a lattice, since edges of drawn objects are rarely at such positions.
        x, y = (low[axis] + (np.arange(COLUMNS) + 0.4877) * cell[axis] for axis in (0, 1))
        below = np.full(COLUMNS**2, 2.0 * low[2] - high[2])
        starts = np.column_stack([np.repeat(x, COLUMNS), np.tile(y, COLUMNS), below])
        parts = list(self._crossings(starts, np.array([0.0, 0.0, 1.0])))
        ray, distance, way = (np.concatenate(each) for each in zip(*parts, strict=True))
        order = np.lexsort((distance, way, ray))
        ray, distance, way = ray[order], distance[order], way[order]
        again = (np.diff(ray) == 0) & (np.diff(way) == 0) & (np.diff(distance) < SAME * (high[2] - low[2]))
        kept = np.append(np.ones(1, bool), ~again)
        ray, distance, way = ray[kept], distance[kept], way[kept]
        whole = np.bincount(ray, way, len(starts)) == 0.0
        order = np.lexsort((distance, ray))
        order = order[whole[ray[order]]]
        winding = np.cumsum(way[order])[:-1]
        along = np.diff(distance[order])
        share = len(starts) / max(int(whole.sum()), 1)
        lengths = (float(along[np.abs(winding) >= least].sum()) * share for least in (1, 2))
        return (*lengths, float(cell.prod()))  # type: ignore[return-value]  # two lengths

    def volume_within(self, low: Array, high: Array) -> float | None:
        """The whole volume if the box contains the mesh, otherwise None."""
        return whole_within(self, low, high)

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """Distance and normal of the nearest triangle, edge or corner."""
        which, place = nearest_triangles(self.triangles, points)
        away = points - place
        gap = np.sqrt((away**2).sum(axis=1))
        inside = self.inside(points)
        # On the surface the direction is undefined, and the normal of the triangle is used.
        on = gap < ON_SURFACE * float(np.abs(self.triangles).max())
        flat = np.where(on[:, None], self._normals()[which], away / np.where(gap > 0.0, gap, 1.0)[:, None])
        return np.where(inside, -gap, gap), np.where((inside & ~on)[:, None], -flat, flat)

    def rim(self, spacing: float) -> Array:
        """The corners of all triangles, cut into pieces no longer than the spacing."""
        corners = self._pieces(spacing)[0].reshape(-1, 3)
        close = 1e-9 * float(np.ptp(corners, axis=0).max())
        rim: Array = corners[np.unique(np.round(corners / close), axis=0, return_index=True)[1]]
        return rim

    def panels(self, spacing: float) -> tuple[Array, Array, Array]:
        """The pieces of all triangles."""
        pieces, whole = self._pieces(spacing)
        return pieces.mean(axis=1), self._normals()[whole], _areas(pieces)

    def middle(self) -> Array:
        """The centroid, from the tetrahedra between the first corner and each triangle."""
        origin = self.triangles[0, 0]
        corners = self.triangles - origin
        six = _determinants(corners)
        center: Array = origin + (six[:, None] * corners.sum(axis=1)).sum(axis=0) / (4.0 * six.sum())
        return center

    def surface(self) -> float:
        """The total area of the triangles."""
        return float(_areas(self.triangles).sum())

    def inertia(self) -> Array:
        """The principal moments of inertia, in the order of `axes`."""
        return self._principal()[0]

    def axes(self) -> Array:
        """The principal axes of inertia, the columns of a matrix (3, 3); the coordinate axes if all
        axes are principal.
        """
        return self._principal()[1]

    def thickness(self) -> float:
        """The least width of the convex hull across one of its faces."""
        from scipy.spatial import ConvexHull

        normals = np.unique(np.round(ConvexHull(self.triangles.reshape(-1, 3)).equations[:, :3], 6), axis=0)
        return float(np.ptp(product(self.triangles.reshape(-1, 3), normals.T), axis=0).min())

    def carried(self, way: Array) -> Mesh:
        """The mesh moved by a vector."""
        return Mesh(self.triangles + way)

    def turned(self, turn: Array) -> Mesh:
        """The mesh in the axes that are the columns of a matrix (3, 3)."""
        return Mesh(product(self.triangles.reshape(-1, 3), turn).reshape(-1, 3, 3))

    def _sense(self) -> float:
        """1 if the corners turn counterclockwise as seen from outside, else -1."""
        return 1.0 if float(_determinants(self.triangles - self.triangles[0, 0]).sum()) >= 0.0 else -1.0

    def _normals(self) -> Array:
        """(T, 3) unit normals, outward; zero of a triangle without an area."""
        corner = self.triangles[:, 0]
        normal = self._sense() * np.cross(self.triangles[:, 1] - corner, self.triangles[:, 2] - corner)
        size = np.sqrt((normal**2).sum(axis=1))[:, None]
        return np.asarray(normal / np.where(size > 0.0, size, 1.0))

    def _pieces(self, spacing: float) -> tuple[Array, Integers]:
        """Triangles (S, 3, 3) no longer than the spacing into which the triangles are cut, and the index of the
        triangle that each belongs to.
        """
        edges = np.sqrt(((self.triangles - np.roll(self.triangles, 1, axis=1)) ** 2).sum(axis=2)).max(axis=1)
        counts = np.array([round_up(float(edge), spacing) for edge in edges])
        pieces, whole = [], []
        for count in np.unique(counts):
            mine = np.flatnonzero(counts == count)
            shares = _cut_triangle(int(count))
            pieces.append(np.einsum("pcv,tvd->tpcd", shares, self.triangles[mine]).reshape(-1, 3, 3))
            whole.append(np.repeat(mine, len(shares)))
        return np.concatenate(pieces), np.concatenate(whole)

    def _principal(self) -> tuple[Array, Array]:
        """The principal moments about the centroid for unit mass and their axes, from the tetrahedra."""
        corners = self.triangles - self.middle()
        six, total = _determinants(corners), corners.sum(axis=1)
        # The integral of x_a x_b over a tetrahedron with one corner at the origin is 6 V (sum of x x^T of its corners,
        # plus that of their sum) / 120.
        second = np.einsum("t,tva,tvb->ab", six, corners, corners) + np.einsum("t,ta,tb->ab", six, total, total)
        second /= 20.0 * six.sum()
        tensor = np.trace(second) * np.eye(3) - second
        if np.abs(tensor - np.diag(np.diag(tensor))).max() < ON_AXES * np.trace(tensor):
            return np.diag(tensor).copy(), np.eye(3)
        moments, axes = np.linalg.eigh(tensor)
        if float(np.linalg.det(axes)) < 0.0:
            axes[:, 0] *= -1.0
        return moments, axes

    def _crossings(self, points: Array, direction: Array) -> Iterator[Crossings]:
        """Yield the crossings of rays from points with triangles, for some points at a time; a ray is compared with the
        triangles of its bucket.

        The algorithm is that of Moller and Trumbore; a ray parallel to the plane of a triangle misses it.
        """
        corner = self.triangles[:, 0]
        one, other = self.triangles[:, 1] - corner, self.triangles[:, 2] - corner
        across, normal = np.cross(direction, other), np.cross(one, other)
        beside, volume = np.cross(one, direction), (one * np.cross(direction, other)).sum(axis=1)
        volume = np.where(volume == 0.0, np.nan, volume)
        buckets = sorted_in(self.triangles, direction)
        bucket, within = buckets.of(points)
        count = np.where(within, buckets.first[bucket + 1] - buckets.first[bucket], 0)
        ends = np.cumsum(count)
        first = 0
        while first < len(points):
            before = ends[first - 1] if first else 0
            last = max(int(np.searchsorted(ends, before + MOST_CROSSINGS, side="right")), first + 1)
            ray = np.repeat(np.arange(first, last), count[first:last])
            number = np.arange(len(ray)) - (ends - count)[ray] + before
            k = buckets.triangle[buckets.first[bucket[ray]] + number]
            away = points[ray] - corner[k]
            u, v = (away * across[k]).sum(axis=1) / volume[k], (away * beside[k]).sum(axis=1) / volume[k]
            distance = (away * normal[k]).sum(axis=1) / volume[k]
            hit = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (distance > 0.0)
            yield Crossings(ray[hit], distance[hit], np.where(volume[k[hit]] > 0.0, -1, 1))
            first = last


@functools.lru_cache(maxsize=32)
def _volume_of(data: bytes) -> tuple[float, bool]:
    """The volume of a mesh, and whether its shells overlap; cached, since bodies need it at each step."""
    mesh = Mesh(np.frombuffer(data).reshape(-1, 3, 3))
    if _shells(mesh.triangles)[0] > 1:
        length, several, cell = mesh.lengths()
        if several > OVERLAP * length:
            return length * cell, True
    return abs(float(_determinants(mesh.triangles - mesh.triangles[0, 0]).sum())) / 6.0, False


def outward(triangles: Array) -> Array:
    """The triangles (T, 3, 3) of closed shells, reversed where a shell is inside out. A shell of opposite orientation
    inside another shell is a cavity and remains unchanged; the reference orientation is that of the largest shell.
    """
    count, shell = _shells(triangles)
    if count == 1:
        return triangles
    volume = np.bincount(shell, _determinants(triangles - triangles[0, 0]), count)
    sense = np.sign(volume[np.argmax(np.abs(volume))])
    turned = np.zeros(count, bool)
    for other in np.flatnonzero(volume * sense < 0.0):
        corners = triangles[shell == other].reshape(-1, 3)
        around = (Mesh(triangles[shell == each]) for each in np.flatnonzero(volume * sense > 0.0))
        turned[other] = not any(each.contains(corners) for each in around)
    found: Array = np.where(turned[shell][:, None, None], triangles[:, ::-1], triangles)
    return found


def _shells(triangles: Array) -> tuple[int, Integers]:
    """The number of closed surfaces without common edges, and the surface of each triangle (T,)."""
    corners = triangles.reshape(-1, 3)
    close = SAME * float(np.ptp(corners, axis=0).max())
    place = np.unique(np.round(corners / close), axis=0, return_inverse=True)[1].reshape(-1, 3)
    ends = np.sort(np.concatenate([place[:, [0, 1]], place[:, [1, 2]], place[:, [2, 0]]]), axis=1)
    edge = np.unique(ends, axis=0, return_inverse=True)[1].ravel()
    face, count = np.tile(np.arange(len(triangles)), 3), len(triangles) + int(edge.max()) + 1
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    links = coo_array((np.ones(len(face)), (face, len(triangles) + edge)), (count, count))
    number, label = connected_components(links, directed=False)
    return int(number), np.asarray(label[: len(triangles)], np.int64)


def _areas(triangles: Array) -> Array:
    """The areas (T,) of triangles."""
    edge, other = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return 0.5 * np.asarray(np.sqrt((np.cross(edge, other) ** 2).sum(axis=1)))


def _determinants(corners: Array) -> Array:
    """Six times the volumes (T,) of the tetrahedra between the origin and each triangle."""
    return np.asarray((corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum(axis=1))


def _cut_triangle(count: int) -> Array:
    """The barycentric coordinates (count^2, 3, 3) of the corners of equal pieces of a triangle."""
    pieces = []
    for row in range(count):
        for column in range(count - row):
            a, b, c = (row, column), (row + 1, column), (row, column + 1)
            pieces.append((a, b, c))
            if column + row < count - 1:
                pieces.append((b, (row + 1, column + 1), c))
    place = np.array(pieces) / count
    return np.concatenate([1.0 - place.sum(axis=2, keepdims=True), place], axis=2)


def hull_of(points: Array) -> Mesh:
    """The convex hull of points (N, 3). Raises BadInput for points in one plane."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError) as error:
        raise BadInput(f"got {len(points)} points without a volume; expected four or more") from error
    triangles = points[hull.simplices]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    inward = (normal * hull.equations[:, :3]).sum(axis=1) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return Mesh(triangles)


ROUND_SIDES = 64
"""The number of sides of the prism that approximates a cylinder."""


def cylinder_of(center: Array, radius: float, axis: Array) -> Mesh:
    """A cylinder with this center and with an axis from one end to the other, approximated by a prism of the same
    volume.
    """
    along = axis / length(axis)
    one = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    one /= length(one)
    angle = 2.0 * np.pi * np.arange(ROUND_SIDES) / ROUND_SIDES
    wide = radius * math.sqrt(2.0 * np.pi / ROUND_SIDES / math.sin(2.0 * np.pi / ROUND_SIDES))
    circle = wide * (np.cos(angle)[:, None] * one + np.sin(angle)[:, None] * np.cross(along, one))
    return hull_of(center + np.concatenate([circle - 0.5 * axis, circle + 0.5 * axis]))


class Cloud(NamedTuple):
    """The union of cubes around points (N, d), one spacing wide."""

    points: Array
    spacing: float

    def bounds(self) -> tuple[Array, Array]:
        """The bounding box."""
        half = 0.5 * self.spacing
        return self.points.min(axis=0) - half, self.points.max(axis=0) + half

    def extent_along(self, direction: Array) -> float:
        """The largest extent of a point along a direction, plus half a spacing."""
        return float(product(self.points, direction).max()) + 0.5 * self.spacing * length(direction)

    def inside(self, points: Array) -> Flags:
        """Flags of the points that are within half a spacing of one of the cloud's points along each axis."""
        from scipy.spatial import cKDTree

        distance, _ = cKDTree(self.points).query(points, p=np.inf)
        return np.asarray(distance < 0.5 * self.spacing)

    def way_out(self, points: Array, direction: Array) -> Array:
        """The distance along an axis to the last point ahead in a column one spacing wide, plus half a spacing."""
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
        """One cell for each point, for any spacing."""
        widths = np.full(self.points.shape, self.spacing)
        return Cells(self.points, np.prod(widths, axis=1), widths)

    def faces(self) -> Array:
        """No faces along the axes."""
        return np.zeros((0, self.points.shape[1]))

    def volume(self) -> float:
        """The volume of one cell for each point."""
        return float(len(self.points) * self.spacing ** self.points.shape[1])

    def volume_within(self, low: Array, high: Array) -> float | None:
        """The whole volume if the box contains all points, otherwise None."""
        return whole_within(self, low, high)
