"""Shapes of regions and solids, and the dummy particles of solids: those within one support of a surface."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume.engine.outlines import Cloud, Mesh, cylinder_of, hull_of, outward
from ecume.engine.shapes import Ball, Box, Flags, Hollow, Part, Polygon, Shape, apart, round_up
from ecume.scenes.sph import BodySpec, ObstacleSpec, RegionSpec, ShapeSpec, SphScene, TankSpec
from ecume.units import Array

CLEARANCE = 0.25
"""The distance from solids, in spacings, below which no liquid starts."""


def shape_of(spec: ShapeSpec) -> Shape:
    """A shape of the scene as a part of space. Raises BadInput for corners in one plane."""
    if spec.triangles:
        return _mesh(spec.triangles)
    if spec.vertices:
        corners = np.array(spec.vertices)
        return Polygon(corners) if corners.shape[1] == 2 else hull_of(corners)
    if spec.radius is not None and spec.axis is not None:
        return cylinder_of(np.array(spec.center), spec.radius, np.array(spec.axis))
    if spec.radius is not None:
        return Ball(np.array(spec.center), spec.radius)
    return Box(np.array(spec.low), np.array(spec.high))


@functools.lru_cache(maxsize=16)
def _mesh(triangles: tuple[tuple[tuple[float, ...], ...], ...]) -> Mesh:
    return Mesh(outward(np.array(triangles)))


def solid_of(spec: ObstacleSpec | BodySpec, tank: TankSpec) -> Shape:
    """An obstacle or a body as a part of space."""
    shape, hollow = shape_of(spec), isinstance(spec, ObstacleSpec) and spec.hollow
    return Hollow(shape, np.array(tank.low), np.array(tank.high)) if hollow else shape


def obstacles_of(scene: SphScene) -> list[Shape]:
    """All obstacles."""
    return [solid_of(spec, scene.tank) for spec in scene.obstacles]


class OwnAxes(NamedTuple):
    """A body in its principal axes, relative to its center."""

    shape: Shape
    turn: Array
    """(3, 3) from the principal axes to those of the tank"""


def in_own_axes(shape: Shape) -> OwnAxes:
    """A body in its principal axes, for the equations of motion. All shapes but meshes are drawn along these axes."""
    centered = shape.carried(-shape.middle())
    if isinstance(centered, Mesh):
        turn = centered.axes()
        return OwnAxes(centered.turned(turn), turn)
    return OwnAxes(centered, np.eye(3))


def part_of(region: RegionSpec, spacing: float) -> Part:
    """The region of the liquid as a part of space."""
    if region.particles is not None:
        return Cloud(np.array(region.particles.positions), spacing)
    return shape_of(region)


def solids_of(scene: SphScene) -> list[Shape]:
    """Obstacles, then bodies in their initial positions."""
    return [*obstacles_of(scene), *(shape_of(spec) for spec in scene.bodies)]


def gaps_to(solids: Sequence[Shape], points: Array) -> Array:
    """The distance (N,) of each point from the nearest solid, positive outside; infinite without solids."""
    gap = np.full(len(points), np.inf)
    for solid in solids:
        gap = np.minimum(gap, solid.nearest(points)[0])
    return gap


def free_of(points: Array, solids: Sequence[Shape], spacing: float) -> Flags:
    """Flags of the points that are outside of all solids, at a sufficient distance."""
    free: Flags = gaps_to(solids, points) > CLEARANCE * spacing
    return free


def dummies_of(shape: Shape, spacing: float, support: float) -> tuple[Array, Array]:
    """The dummies (n, d) of a solid and their volumes, which fill the shape down to the depth of the support."""
    if isinstance(shape, Ball) and len(shape.center) == 2:
        points, volume = _rings_of(shape, spacing)
    elif isinstance(shape, Polygon) and shape.convex():
        points, volume = _rows_of(shape, spacing, support)
    else:
        points, volume, _ = shape.cells(spacing)
    near = shape.nearest(points)[0] > -support
    return points[near], volume[near]


def obstacle_dummies(scene: SphScene, support: float) -> list[tuple[Array, Array]]:
    """The dummies of each obstacle, without those inside an earlier obstacle or outside the tank."""
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    found, earlier = [], list[Shape]()
    for shape in obstacles_of(scene):
        cut = _cut_rows(shape, (low, high), scene.spacing, support) if len(low) == 2 else None
        points, volume = dummies_of(shape, scene.spacing, support) if cut is None else cut
        stays = apart(points, earlier) & ((points > low) & (points < high)).all(axis=1)
        found.append((points[stays], volume[stays]))
        earlier.append(shape)
    return found


def _rows_of(shape: Polygon, spacing: float, support: float) -> tuple[Array, Array]:
    """Rows of points parallel to the edges, one spacing apart; unlike an oblique lattice they leave no holes."""
    points, volume, outer = [np.zeros((0, 2))], [np.zeros(0)], shape
    for row in range(round_up(support, spacing) + 1):
        inner, middle = shape.inset((row + 1) * spacing), shape.inset((row + 0.5) * spacing)
        share = outer.volume() - (inner.volume() if inner else 0.0)
        place = middle.rim(spacing) if middle else outer.middle()[None]
        points.append(place)
        volume.append(np.full(len(place), share / len(place)))
        if inner is None:
            break
        outer = inner
    return np.concatenate(points), np.concatenate(volume)


def _rings_of(shape: Ball, spacing: float) -> tuple[Array, Array]:
    """Rings of points one spacing apart, for a smooth surface."""
    rings = round_up(shape.radius, spacing)
    width = shape.radius / rings
    points, volume = [], []
    for ring in range(rings):
        radius = (ring + 0.5) * width
        points.append(_ring(shape.center, radius, spacing))
        volume.append(np.full(len(points[-1]), 2.0 * np.pi * radius * width / len(points[-1])))
    return np.concatenate(points), np.concatenate(volume)


ARC = 360
"""The number of corners of a circle that the sides of a tank cut."""
ON_SIDE = 1e-9
"""The distance, over the size of the tank, below which an edge is on a side."""


def _cut_rows(shape: Shape, tank: tuple[Array, Array], spacing: float, support: float) -> tuple[Array, Array] | None:
    """Rows of points along the surface of a disc or convex polygon inside the tank, one spacing apart, each from side
    to side of the tank; None if no side cuts or touches the shape.
    """
    (low, high), (first, last) = tank, shape.bounds()
    if ((first > low) & (last < high)).all() or ((first >= high) | (last <= low)).any():
        return None
    if not isinstance(shape, Ball) and not (isinstance(shape, Polygon) and shape.convex()):
        return None
    points, volume = [np.zeros((0, 2))], [np.zeros(0)]
    for row in range(round_up(support, spacing) + 1):
        outer, middle, inner = (_inset(shape, tank, (row + part) * spacing) for part in (0.0, 0.5, 1.0))
        if middle is None or outer is None:
            break
        place = _row_along(shape, middle, tank, spacing)
        share = outer.volume() - (inner.volume() if inner else 0.0)
        points.append(place)
        volume.append(np.full(len(place), share / max(len(place), 1)))
    return np.concatenate(points), np.concatenate(volume)


def _row_along(shape: Ball | Polygon, middle: Polygon, tank: tuple[Array, Array], spacing: float) -> Array:
    """Points along an inset outline between sides of the tank; if the outline meets no side, along all of it, as
    symmetric as the shape.
    """
    if not _exposed(middle, tank).all():
        return np.concatenate([np.zeros((0, 2)), *(_centers(chain, spacing) for chain in _chains(middle, tank))])
    if isinstance(shape, Ball):
        return _ring(shape.center, float(np.linalg.norm(middle.vertices[0] - shape.center)), spacing)
    return middle.rim(spacing)


def _ring(center: Array, radius: float, spacing: float) -> Array:
    """Points about one spacing apart on a circle: a multiple of four, starting half a step from the axis, so that they
    are symmetric about both axes and both diagonals.
    """
    count = 4 * max(1, round(0.5 * np.pi * radius / spacing))
    angle = 2.0 * np.pi * (np.arange(count) + 0.5) / count
    found: Array = center + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return found


def _inset(shape: Ball | Polygon, tank: tuple[Array, Array], depth: float) -> Polygon | None:
    """The part of a shape in the tank that is deeper than this below its surface in the tank."""
    if isinstance(shape, Ball):
        if depth >= shape.radius:
            return None
        angle = 2.0 * np.pi * np.arange(ARC) / ARC
        circle = shape.center + (shape.radius - depth) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return Polygon(circle).within(*tank)
    inside = shape.within(*tank)
    return None if inside is None else inside.inset(depth, _exposed(inside, tank))


def _exposed(polygon: Polygon, tank: tuple[Array, Array]) -> Flags:
    """Flags (V,) of the edges that do not lie on a side of the tank."""
    one, other = polygon.vertices, np.roll(polygon.vertices, -1, axis=0)
    close, lying = ON_SIDE * float((tank[1] - tank[0]).max()), np.zeros(len(one), bool)
    for corner in tank:
        lying |= ((np.abs(one - corner) < close) & (np.abs(other - corner) < close)).any(axis=1)
    return ~lying


def _chains(polygon: Polygon, tank: tuple[Array, Array]) -> list[Array]:
    """The parts of an outline on a side of the tank, without the edges on sides, as corners (K, 2) each."""
    exposed, corners = _exposed(polygon, tank), polygon.vertices
    count, found, begin, joined = len(corners), list[list[Array]](), int(np.argmin(exposed)), False
    for k in range(begin, begin + count):
        if exposed[k % count]:
            if not joined:
                found.append([corners[k % count]])
            found[-1].append(corners[(k + 1) % count])
        joined = bool(exposed[k % count])
    return [np.array(chain) for chain in found]


def _centers(chain: Array, spacing: float) -> Array:
    """The centers of equal pieces of a line, each about one spacing long."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(chain, axis=0), axis=1))])
    count = max(1, round(float(along[-1]) / spacing))
    place = (np.arange(count) + 0.5) * along[-1] / count
    return np.stack([np.interp(place, along, chain[:, axis]) for axis in range(2)], axis=1)
