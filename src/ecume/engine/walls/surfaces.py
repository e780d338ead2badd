"""Surfaces of walls and obstacles: planes and spheres, each with an inner side, and openings through which particles
enter or leave.

Every shape is a list of surfaces; `together` joins lists. A particle must be on the inner side of all surfaces; for a
convex obstacle it is sufficient to be outside one of its faces.

The second part describes 2D walls for compiled loops, and the region inside. An enclosure of floats is convex and
contains the origin: a circle around it, straight lines, or both. The distance from a wall is positive inside; the
normal points inward and is the gradient of the distance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled_inside
from ecume.engine.cells import Integers
from ecume.errors import BadInput
from ecume.units import Array

PLANE, INSIDE, OUTSIDE = 0, 1, -1
"""Kinds: a plane, a sphere seen from inside, a sphere seen from outside."""


class Surfaces(NamedTuple):
    """Surfaces, K in number, with M openings in them. Rows have three columns; in 2D z is 0."""

    dimension: int
    kind: Integers
    """(K,)"""
    place: Array
    """(K, 3) a plane's unit normal towards the particles; a sphere's center, m"""
    size: Array
    """(K,) m: a plane is n.x = size; a sphere's radius"""
    velocity: Array
    """(K, 3) m/s"""
    face: Integers
    """(K, 2) for the face of an obstacle the range of the obstacle's planes; (0, 0) otherwise"""
    hole: Integers
    """(M,) the surface an opening is in"""
    low: Array
    """(M, 3) m: an opening is the part of its surface inside a box"""
    high: Array
    """(M, 3)"""


def planes(points: Any, normals: Any, velocities: Any = None) -> Surfaces:
    """Planes through points. Normals may have any length, and point to the particles. Moving planes have velocities."""
    through, normal = _rows(points, "points"), _rows(normals, "normals")
    _require_shape(normal, through, "normals", "points")
    lengths = np.linalg.norm(normal, axis=1)
    if not np.all(lengths > 0.0):
        raise BadInput(f"planes: normal {int(np.argmin(lengths))} has no direction; expected one that points inside")
    unit = normal / lengths[:, None]
    velocity = np.zeros_like(unit) if velocities is None else _rows(velocities, "velocities")
    _require_shape(velocity, through, "velocities", "points")
    return _made(through.shape[1], PLANE, unit, np.einsum("kd,kd->k", unit, through), velocity)


def box(low: Sequence[float], high: Sequence[float]) -> Surfaces:
    """The inside of a rectangle, or of a box: lower sides of all axes, then the upper ones."""
    bottom, top = np.asarray(low, np.float64), np.asarray(high, np.float64)
    if bottom.shape != top.shape or bottom.shape not in ((2,), (3,)) or not np.all(bottom < top):
        raise BadInput(f"box: got {low!r} and {high!r}; expected two corners, the lower one first")
    axes = np.eye(len(bottom))
    return planes([bottom] * len(axes) + [top] * len(axes), np.concatenate([axes, -axes]))


def polygon(vertices: Any) -> Surfaces:
    """The inside of a convex polygon with corners in either order: one line for each side."""
    corners = _rows(vertices, "vertices")
    sides = np.roll(corners, -1, axis=0) - corners
    after = np.roll(sides, -1, axis=0)
    if corners.shape[1] != 2 or len(corners) < 3:
        raise BadInput(f"polygon: got {len(corners)} vertices; expected three or more points (x, y)")
    if not sides.any(axis=1).all():
        twice = int(np.argmin(sides.any(axis=1)))
        raise BadInput(f"polygon: vertex {twice} {tuple(corners[twice].tolist())} is also the next; expected it once")
    turns = sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0]
    way = math.copysign(1.0, float(turns.sum()))
    once = abs(abs(float(np.arctan2(turns, (sides * after).sum(axis=1)).sum())) - 2.0 * math.pi) < 1e-6
    if not np.all(way * turns >= 0.0) or not once:
        worst = (int(np.argmin(way * turns)) + 1) % len(corners)
        raise BadInput(
            f"polygon: not convex at vertex {worst} {tuple(corners[worst].tolist())}; "
            "expected corners that all turn the same way"
        )
    return planes(corners, way * np.column_stack([-sides[:, 1], sides[:, 0]]))


def polyhedron(vertices: Any) -> Surfaces:
    """The inside of the convex hull of 3D points: one plane for each face."""
    from scipy.spatial import ConvexHull, QhullError

    corners = _rows(vertices, "vertices")
    try:
        faces = np.asarray(ConvexHull(corners).equations)
    except (QhullError, ValueError) as error:
        raise BadInput(f"polyhedron: got {len(corners)} points without a volume; expected four or more") from error
    # A face with more than three corners is given as several triangles.
    apart = np.unique(np.round(faces, 9), axis=0, return_index=True)[1]
    normal, offset = -faces[np.sort(apart), :-1], faces[np.sort(apart), -1]
    return planes(offset[:, None] * normal, normal)


def disc(center: Sequence[float], radius: float) -> Surfaces:
    """The inside of a circle, or of a sphere if the center has three coordinates."""
    middle = _rows([center], "center")
    if not radius > 0.0:
        raise BadInput(f"disc: got radius {radius!r}; expected one above 0")
    return _made(middle.shape[1], INSIDE, middle, np.array([float(radius)]), np.zeros_like(middle))


def wedge(apex: Sequence[float], direction: Sequence[float], angle: float) -> Surfaces:
    """The inside of a corner: two lines that meet at the apex with the opening angle (rad) around the direction."""
    if not 0.0 < angle < math.pi:
        raise BadInput(f"wedge: got angle {angle!r}; expected radians between 0 and pi")
    middle = math.atan2(direction[1], direction[0])
    low, high = middle - 0.5 * angle, middle + 0.5 * angle
    return planes([apex, apex], [(-math.sin(low), math.cos(low)), (math.sin(high), -math.cos(high))])


def outside(shape: Surfaces) -> Surfaces:
    """A convex shape as an obstacle: the same surfaces seen from outside."""
    if np.any(shape.face) or len(shape.hole) or (np.any(shape.kind != PLANE) and len(shape.kind) > 1):
        raise BadInput("outside: expected one convex shape without openings: a box, polygon, polyhedron, disc or plane")
    count = len(shape.kind)
    if shape.kind[0] != PLANE:
        return shape._replace(kind=-shape.kind)
    face = np.tile(np.array([0, count], np.int64), (count, 1))
    return shape._replace(place=-shape.place, size=-shape.size, face=face)


def opening(walls: Surfaces, number: int, low: Sequence[float], high: Sequence[float]) -> Surfaces:
    """The same walls with an opening in surface `number`: its part between two corners, through
    which particles leave.
    """
    if not 0 <= number < len(walls.kind):
        raise BadInput(f"opening: got surface {number}; there are {len(walls.kind)}, from 0")
    corners = _rows([low, high], "low, high")
    if corners.shape[1] != walls.dimension or not np.all(corners[0] <= corners[1]):
        raise BadInput(f"opening: got {low!r} and {high!r}; expected two corners, the lower one first")
    wide = _padded(corners)
    if not _meets(walls, number, wide):
        surface = described(walls, number)
        raise BadInput(f"opening: {low!r} to {high!r} has no part in {surface}; expected a part of that surface")
    return walls._replace(
        hole=np.append(walls.hole, np.int64(number)),
        low=np.vstack([walls.low, wide[:1]]),
        high=np.vstack([walls.high, wide[1:]]),
    )


def together(*shapes: Surfaces) -> Surfaces:
    """All surfaces in one list, numbered in order."""
    if len({shape.dimension for shape in shapes}) != 1:
        raise BadInput("together: expected shapes of one dimension")
    starts = np.cumsum([0] + [len(shape.kind) for shape in shapes])
    faces = [shape.face + start * (shape.face[:, 1:] > 0) for shape, start in zip(shapes, starts, strict=False)]
    holes = [shape.hole + start for shape, start in zip(shapes, starts, strict=False)]
    return Surfaces(
        shapes[0].dimension,
        np.concatenate([shape.kind for shape in shapes]),
        np.concatenate([shape.place for shape in shapes]),
        np.concatenate([shape.size for shape in shapes]),
        np.concatenate([shape.velocity for shape in shapes]),
        np.concatenate(faces),
        np.concatenate(holes),
        np.concatenate([shape.low for shape in shapes]),
        np.concatenate([shape.high for shape in shapes]),
    )


def moving(walls: Surfaces, velocity: Sequence[float]) -> Surfaces:
    """The same walls, all with one velocity (m/s)."""
    return walls._replace(velocity=np.tile(_padded(_rows([velocity], "velocity")), (len(walls.kind), 1)))


def moved(walls: Surfaces, time: float) -> Surfaces:
    """The walls after a time (s), with their openings moved."""
    way = time * walls.velocity
    flat = walls.kind == PLANE
    carried = way[walls.hole]
    return walls._replace(
        place=np.where(flat[:, None], walls.place, walls.place + way),
        size=walls.size + np.where(flat, np.einsum("kd,kd->k", walls.place, way), 0.0),
        low=walls.low + carried,
        high=walls.high + carried,
    )


def through(walls: Surfaces, points: Array) -> Surfaces:
    """The same planes through other points (K, 3)."""
    return walls._replace(size=np.einsum("kd,kd->k", walls.place, points))


def nearest_points(walls: Surfaces) -> Array:
    """The point of each plane that is nearest to the origin (K, 3)."""
    return np.asarray(walls.size[:, None] * walls.place)


def described(walls: Surfaces, number: int) -> str:
    """A phrase that describes a surface, for messages."""
    if number < 0:
        return "no surface"
    place = ", ".join(f"{value:.6g}" for value in walls.place[number, : walls.dimension])
    if walls.kind[number] == PLANE:
        return f"plane {number} (normal ({place}))"
    return (
        f"{'circle' if walls.dimension == 2 else 'sphere'} {number} (center ({place}), radius {walls.size[number]:.6g})"
    )


def _made(dimension: int, kind: int, place: Array, size: Array, velocity: Array) -> Surfaces:
    count = len(size)
    none = np.zeros((0, 3))
    return Surfaces(
        dimension,
        np.full(count, kind, np.int64),
        _padded(place),
        size,
        _padded(velocity),
        np.zeros((count, 2), np.int64),
        np.zeros(0, np.int64),
        none,
        none.copy(),
    )


def _meets(walls: Surfaces, number: int, corners: Array) -> bool:
    """Whether a surface intersects or touches, up to rounding, the box between two corners (2, 3)."""
    middle, half = corners.mean(axis=0), 0.5 * (corners[1] - corners[0])
    place, size = walls.place[number], float(walls.size[number])
    if walls.kind[number] == PLANE:
        least, most = (float(place @ middle + way * np.abs(place) @ half) for way in (-1.0, 1.0))
    else:
        away = np.abs(middle - place)
        least, most = float(np.linalg.norm(np.maximum(away - half, 0.0))), float(np.linalg.norm(away + half))
    slack = 1e-9 * (abs(size) + float(np.abs(corners).max()))
    return least - slack <= size <= most + slack


def _rows(given: Any, name: str) -> Array:
    array = np.atleast_2d(numbers_of(given, name))
    if array.ndim != 2 or array.shape[1] not in (2, 3) or not np.all(np.isfinite(array)):
        raise BadInput(f"{name}: got an array of shape {array.shape}; expected finite numbers, (K, 2) or (K, 3)")
    return array


def numbers_of(given: Any, name: str) -> Array:
    """A copy as an array of floating-point numbers."""
    try:
        return np.array(given, np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise BadInput(f"{name}: got {str(given)[:60]}; expected numbers") from error


def _require_shape(array: Array, other: Array, name: str, its: str) -> None:
    if array.shape != other.shape:
        raise BadInput(f"{name}: got shape {array.shape}; expected {other.shape}, as the {its} have")


def _padded(array: Array) -> Array:
    return np.ascontiguousarray(np.pad(array, ((0, 0), (0, 3 - array.shape[1]))))


class Entrance(NamedTuple):
    """An opening in a flat wall."""

    normal: Array
    """(d,) unit, to the inside"""
    middle: Array
    """(d,) m, on the wall"""
    along: Array
    """(d - 1, d) unit vectors in the wall"""
    half: Array
    """(d - 1,) m: its largest extent along each"""
    low: Array
    """(d,) m: the corners of the opening's box"""
    high: Array

    def at(self, shares: Array) -> Array:
        """The points (n, d) on the wall at shares (n, d - 1) in (0, 1)."""
        places: Array = self.middle + ((2.0 * shares - 1.0) * self.half) @ self.along
        return places

    def holds(self, places: Array) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Flags (n,) of the points on the wall that are in the opening."""
        slack = 1e-9 * np.linalg.norm(self.high - self.low)
        within = (places >= self.low - slack) & (places <= self.high + slack)
        return np.asarray(within.all(axis=1))

    def area(self) -> float:
        """The area (m^2 in 3D, m in 2D), for a wall normal to an axis, in 2D for any wall."""
        return float(np.prod(2.0 * self.half))


def entrance(walls: Surfaces, hole: int) -> Entrance:
    """The entrance that an opening forms. Raises BadInput for a curved wall, and if the wall does not cross the box of
    the opening.

    >>> from ecume.engine.walls import box, opening
    >>> door = entrance(opening(box((0, 0), (2, 1)), 0, (0.0, 0.2), (0.0, 0.6)), 0)
    >>> door.normal.tolist(), round(door.area(), 12)
    ([1.0, 0.0], 0.4)
    """
    d, wall = walls.dimension, int(walls.hole[hole])
    if walls.kind[wall] != PLANE:
        raise BadInput(f"entrance: got an opening in {described(walls, wall)}; expected one in a flat wall")
    normal, low, high = walls.place[wall, :d], walls.low[hole, :d], walls.high[hole, :d]
    along = np.linalg.svd(normal[None])[2][1:]
    edge = _border(normal, float(walls.size[wall]), low, high)
    if not len(edge):
        raise BadInput(
            f"entrance: {described(walls, wall)} does not go through the box {low.tolist()}, {high.tolist()}"
        )
    reach = edge @ along.T
    first, last = reach.min(axis=0), reach.max(axis=0)
    middle = walls.size[wall] * normal + 0.5 * (first + last) @ along
    return Entrance(normal, middle, along, 0.5 * (last - first), low, high)


def _border(normal: Array, size: float, low: Array, high: Array) -> Array:
    """The intersections of a plane with the edges of a box, (n, d)."""
    d, found = len(normal), []
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(d, -1).T
    slack = 1e-9 * (np.abs(corners).max() + abs(size))
    for axis in range(d):
        for corner in corners[corners[:, axis] == low[axis]]:
            end = np.where(np.arange(d) == axis, high, corner)
            here, there = normal @ corner - size, normal @ end - size
            if abs(here) <= slack:
                found.append(corner)
            if abs(there) <= slack:
                found.append(end)
            if here * there < 0.0:
                found.append(corner + here / (here - there) * (end - corner))
    return np.array(found).reshape(-1, d)


ARCS = 360
"""Points of the outline of a circle."""


class Walls(NamedTuple):
    """The walls of an enclosure. `disc_radius` is infinite without a circle; lines are n.x = offset with n inward."""

    disc_radius: float
    normal: Array
    """(K, 2) inward unit normals of the lines"""
    offset: Array
    """(K,) m"""


def no_walls() -> Walls:
    """The walls of an open surface, which has none."""
    return Walls(math.inf, np.zeros((0, 2)), np.zeros(0))


def enclosed_by(surfaces: Surfaces) -> Walls:
    """The walls of a 2D shape, without surfaces that its inside does not touch. Raises BadInput if the shape is not
    convex, is open, or does not contain the origin.

    >>> from ecume.engine.walls import box
    >>> enclosed_by(box((-2.0, -1.0), (2.0, 1.0))).offset.tolist()
    [-2.0, -1.0, -2.0, -1.0]
    """
    flat, round_ones = surfaces.kind == PLANE, surfaces.kind == INSIDE
    if surfaces.dimension != 2 or np.any(surfaces.face) or not np.all(flat | round_ones):
        raise BadInput("enclosure: expected a convex 2D shape")
    if np.any(surfaces.place[round_ones]) or np.any(surfaces.size[flat] > 0.0):
        raise BadInput("enclosure: expected a shape around the origin")
    radius = float(surfaces.size[round_ones].min(initial=math.inf))
    found = reached(Walls(radius, np.ascontiguousarray(surfaces.place[flat, :2]), surfaces.size[flat].copy()))
    if found.disc_radius == math.inf and (len(found.offset) < 3 or not np.all(np.isfinite(side_ends(found)))):
        raise BadInput("enclosure: the shape is open; expected one that lines or a circle close all around")
    return found


SLIVER = 1e-9
"""The length of a side over the size of the enclosure, below which its line only touches the enclosure."""


def side_ends(walls: Walls) -> Array:
    """The ends (K, 2) of the part of the edge on each line, in m along the line from its point nearest to the origin,
    counterclockwise. The second end is not beyond the first if no part of the line belongs to the edge.
    """
    normal, offset, count = walls.normal, walls.offset, len(walls.offset)
    radius = walls.disc_radius
    turn = normal[:, 0, None] * normal[:, 1] - normal[:, 1, None] * normal[:, 0]  # from line k to line j
    alike, parallel = normal @ normal.T, np.abs(turn) <= SLIVER
    needed = offset[None] - offset[:, None] * np.where(parallel, np.sign(alike), alike)
    meets = needed / np.where(parallel, np.inf, -turn)
    # Points inside line j are at t >= meets if line j turns clockwise, and at t <= meets otherwise.
    first = np.where(turn < -SLIVER, meets, -np.inf).max(axis=1, initial=-np.inf)
    last = np.where(turn > SLIVER, meets, np.inf).min(axis=1, initial=np.inf)
    if radius < math.inf:
        half = np.sqrt(np.maximum(radius**2 - offset**2, 0.0))
        first, last = np.maximum(first, -half), np.minimum(last, half)
    earlier = np.arange(count)[None] < np.arange(count)[:, None]
    behind = parallel & ((needed > 0.0) | ((needed == 0.0) & earlier & (alike > 0.0)))
    return np.where(behind.any(axis=1)[:, None], 0.0, np.stack([first, last], axis=1))


def reached(walls: Walls) -> Walls:
    """The same enclosure without lines, or a circle, that are no part of its edge."""
    if not len(walls.offset):
        return walls
    ends = side_ends(walls)
    size = float(np.abs(walls.offset).max()) if walls.disc_radius == math.inf else walls.disc_radius
    kept = ends[:, 1] - ends[:, 0] > SLIVER * size
    left = Walls(walls.disc_radius, np.ascontiguousarray(walls.normal[kept]), walls.offset[kept])
    lines = left._replace(disc_radius=math.inf)
    around = side_ends(lines)
    if len(around) > 2 and np.all(np.hypot(around, lines.offset[:, None]) <= walls.disc_radius * (1.0 + SLIVER)):
        return lines
    return left


@compiled_inside
def wall_count(walls: Walls) -> int:
    """The number of walls: the circle, if any, is number 0, followed by the lines."""
    return len(walls.offset) + (1 if walls.disc_radius < np.inf else 0)


@compiled_inside
def is_circle(walls: Walls, number: int) -> bool:
    """Whether a wall is the circle."""
    return number == 0 and walls.disc_radius < np.inf


@compiled_inside
def wall_distance(walls: Walls, number: int, x: float, y: float) -> tuple[float, float, float]:
    """The distance of the point (x, y) from wall `number`, positive inside, and the wall's inward normal there.

    At the center of a circle, where the direction is undefined, the first axis is used.
    """
    if walls.disc_radius < np.inf:
        if number == 0:
            radius = math.sqrt(x * x + y * y)
            if radius == 0.0:
                return walls.disc_radius, -1.0, 0.0
            return walls.disc_radius - radius, -x / radius, -y / radius
        number -= 1
    normal_x, normal_y = walls.normal[number, 0], walls.normal[number, 1]
    return normal_x * x + normal_y * y - walls.offset[number], normal_x, normal_y


def clearances(walls: Walls, place: Any) -> list[float]:
    """The distances of a point from all walls (m)."""
    x, y = float(place[0]), float(place[1])
    return [float(wall_distance(walls, number, x, y)[0]) for number in range(wall_count(walls))]


def shrunk(walls: Walls, by: float) -> Walls:
    """The enclosure for the centers of discs of this radius (m)."""
    return reached(Walls(walls.disc_radius - by, walls.normal, walls.offset + by))


def corners(walls: Walls) -> Array:
    """The corners of an enclosure by lines alone, counterclockwise, (K, 2) m. Raises BadInput without corners."""
    if walls.disc_radius < math.inf or len(walls.offset) < 3:
        raise BadInput("corners: expected an enclosure by three or more lines")
    order = np.argsort(np.arctan2(-walls.normal[:, 1], -walls.normal[:, 0]), kind="stable")
    one, after = order, np.roll(order, -1)
    (a, b), (c, d) = walls.normal[one].T, walls.normal[after].T
    first, second, turn = walls.offset[one], walls.offset[after], a * d - b * c
    return np.stack([(first * d - second * b) / turn, (a * second - c * first) / turn], axis=1)


def outline(walls: Walls) -> Array:
    """The edge of the region inside, counterclockwise, as points of a polygon (m). Raises BadInput if it is open."""
    if walls.disc_radius == math.inf:
        return corners(walls)
    angle = np.linspace(0.0, 2.0 * np.pi, ARCS, endpoint=False)
    if len(walls.offset):
        x, y = _line_points(walls).T
        angle = np.sort(np.concatenate([angle, np.arctan2(y, x) % (2.0 * np.pi)]))
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    outward = -unit @ walls.normal.T
    with np.errstate(divide="ignore"):
        lines = np.where(outward > 0.0, -walls.offset / outward, np.inf)
    reach = np.minimum(walls.disc_radius, lines.min(axis=1, initial=np.inf))
    around: Array = reach[:, None] * unit
    return around


def farthest(walls: Walls) -> float:
    """The distance of the farthest point inside from the origin (m)."""
    if walls.disc_radius < math.inf or not len(walls.offset):
        return walls.disc_radius
    return max(math.hypot(*corner) for corner in corners(walls))


def bounds(walls: Walls) -> tuple[tuple[float, float], tuple[float, float]]:
    """The lower and the upper corner of the rectangle around an enclosure (m)."""
    r = walls.disc_radius
    if not len(walls.offset):
        return (-r, -r), (r, r)
    if r == math.inf:
        around = corners(walls)
    else:
        extremes = r * np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])
        inside = np.all(extremes @ walls.normal.T >= walls.offset, axis=1)
        around = np.concatenate([_line_points(walls), extremes[inside]])
    low, high = around.min(axis=0), around.max(axis=0)
    return (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))


def area(walls: Walls) -> float:
    """The area inside (m^2), infinite if it is open."""
    if not len(walls.offset):
        return math.pi * walls.disc_radius**2
    if walls.disc_radius == math.inf:
        x, y = corners(walls).T
        return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    # Triangles from the origin to the lines, and sectors of the circle between them.
    ends, away = side_ends(walls), -walls.offset[:, None]
    triangles, angles = 0.5 * np.diff(ends, axis=1) * away, np.diff(np.arctan2(ends, away), axis=1)
    return float(np.sum(triangles)) + 0.5 * walls.disc_radius**2 * (2.0 * math.pi - float(np.sum(angles)))


def _line_points(walls: Walls) -> Array:
    """Both end points of each line on the boundary, (2 K, 2) m."""
    along = np.stack([walls.normal[:, 1], -walls.normal[:, 0]], axis=1)
    points: Array = (walls.offset[:, None] * walls.normal)[:, None] + side_ends(walls)[:, :, None] * along[:, None]
    return points.reshape(-1, 2)
