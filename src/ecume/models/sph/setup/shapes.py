"""What is solid in the liquid, as dummy particles: those within one support of a surface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ecume.engine.meshes import Cloud, Mesh
from ecume.engine.shapes import Ball, Box, Flags, Part, Polygon, Shape, apart, round_up
from ecume.scenes.sph import RegionSpec, ShapeSpec, SphScene
from ecume.units import Array

CLEARANCE = 0.25
"""Liquid that would start closer to a solid than this many spacings is omitted."""


def shape_of(spec: ShapeSpec) -> Shape:
    """A region of the scene as a part of space."""
    if spec.vertices:
        return Polygon(np.array(spec.vertices))
    if spec.radius is not None:
        return Ball(np.array(spec.center), spec.radius)
    return Box(np.array(spec.low), np.array(spec.high))


def part_of(region: RegionSpec, spacing: float) -> Part:
    """The region of the liquid as a part of space."""
    if region.particles is not None:
        return Cloud(np.array(region.particles.positions), spacing)
    return Mesh(np.array(region.triangles)) if region.triangles else shape_of(region)


def solids_of(scene: SphScene) -> list[Shape]:
    """Obstacles, then bodies as they start."""
    return [shape_of(spec) for spec in (*scene.obstacles, *scene.bodies)]


def free_of(points: Array, solids: Sequence[Shape], spacing: float) -> Flags:
    """Which points are outside of all solids, and not too close to one."""
    free = np.ones(len(points), bool)
    for solid in solids:
        free &= solid.nearest(points)[0] > CLEARANCE * spacing
    return free


def dummies_of(shape: Shape, spacing: float, support: float) -> tuple[Array, Array]:
    """Dummies of a solid, (n, d), and their volumes, which fill the whole shape; the core deeper than the support is
    omitted.
    """
    if isinstance(shape, Ball) and len(shape.center) == 2:
        points, volume = _rings_of(shape, spacing)
    elif isinstance(shape, Polygon) and shape.convex():
        points, volume = _rows_of(shape, spacing, support)
    else:
        points, volume, _ = shape.cells(spacing)
    near = shape.nearest(points)[0] > -support
    return points[near], volume[near]


def obstacle_dummies(scene: SphScene, support: float) -> list[tuple[Array, Array]]:
    """Dummies of each obstacle, without those in an earlier one or outside of the tank."""
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    found, earlier = [], list[Shape]()
    for spec in scene.obstacles:
        shape = shape_of(spec)
        points, volume = dummies_of(shape, scene.spacing, support)
        stays = apart(points, earlier) & ((points > low) & (points < high)).all(axis=1)
        found.append((points[stays], volume[stays]))
        earlier.append(shape)
    return found


def _rows_of(shape: Polygon, spacing: float, support: float) -> tuple[Array, Array]:
    """Rows along the edges, one spacing apart, which have no holes, unlike an oblique lattice."""
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
    """Rings one spacing apart, so that the surface is as smooth as it can be."""
    rings = round_up(shape.radius, spacing)
    width = shape.radius / rings
    points, volume = [], []
    for ring in range(rings):
        radius = (ring + 0.5) * width
        count = max(3, round(2.0 * np.pi * radius / spacing))
        angle = 2.0 * np.pi * np.arange(count) / count
        points.append(shape.center + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))
        volume.append(np.full(count, 2.0 * np.pi * radius * width / count))
    return np.concatenate(points), np.concatenate(volume)
