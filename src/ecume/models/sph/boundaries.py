"""What holds the liquid: planes with images behind them, and layers of dummy particles."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume.engine.images import Sides
from ecume.models.sph.parameters import Boundary, Dummies, Material
from ecume.scenes.sph import SIDES, SphScene
from ecume.units import Array


def boundary_of(scene: SphScene, material: Material, support: float) -> Boundary:
    """The boundary of a scene's tank."""
    sides, table = _imaging_sides(scene, material)
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    for axis in range(len(low)):
        low[axis] = low[axis] if _side(scene, 2 * axis).kind == "wall" else -np.inf
        high[axis] = high[axis] if _side(scene, 2 * axis + 1).kind == "wall" else np.inf
    dummies = _layers(scene, material, support)
    return Boundary(sides, table, dummies, low, high, scene.tank.restitution)


def _side(scene: SphScene, number: int) -> Any:
    return getattr(scene.tank, SIDES[number])


def holds(side: Any, material: Material) -> bool:
    """Whether a wall holds the liquid that touches it."""
    return bool(side.slip == "no-slip" or (side.slip is None and material.viscosity > 0.0))


def _imaging_sides(scene: SphScene, material: Material) -> tuple[Sides, Array]:
    """Mirrors, and periodic sides. Mirrors first: a periodic side then repeats the mirrored ones."""
    dimension = len(scene.tank.low)
    mirrors = scene.tank.walls == "mirror"
    rows = []
    for number in range(2 * dimension):
        side, axis = _side(scene, number), number // 2
        if side.kind == "periodic" or (side.kind == "wall" and mirrors):
            rows.append(_row(scene, number, axis, holds(side, material)))
    rows.sort(key=lambda row: -row[3 * dimension])
    table = np.array(rows).reshape(-1, 3 * dimension + 2)
    d = dimension
    periodic = table[:, 3 * d] == 0.0
    shift = np.where(periodic[:, None], table[:, 2 * d : 3 * d], 0.0)
    return Sides(table[:, :d], table[:, d : 2 * d], shift, (~periodic).astype(np.int64)), table


def _row(scene: SphScene, number: int, axis: int, hold: bool) -> list[float]:
    """Point, normal, shift or velocity, whether it mirrors, whether it holds."""
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    side, first = _side(scene, number), number % 2 == 0
    normal, third = np.zeros(len(low)), np.zeros(len(low))
    normal[axis] = 1.0 if first else -1.0
    if side.kind == "periodic":
        third[axis] = (high - low)[axis] * normal[axis]
    elif side.velocity is not None:
        third[:] = side.velocity
    return [*(low if first else high), *normal, *third, float(side.kind == "wall"), float(hold)]


def _layers(scene: SphScene, material: Material, support: float) -> Dummies:
    """Layers of dummies around the tank, as thick as the support, where its sides are walls."""
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    dimension, spacing = len(low), scene.spacing
    if scene.tank.walls != "dummy":
        return Dummies(np.zeros((dimension, 0)), np.zeros((dimension, 0)), np.zeros(0))
    layers = math.ceil(support / spacing - 1e-9)
    axes = []
    for axis in range(dimension):
        count = round((high - low)[axis] / spacing)
        first = -layers if _side(scene, 2 * axis).kind == "wall" else 0
        last = count + layers if _side(scene, 2 * axis + 1).kind == "wall" else count
        axes.append(low[axis] + spacing * (np.arange(first, last) + 0.5))
    points = np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1)
    outside = ((points < low) | (points > high)).any(axis=1)
    points = points[outside]
    velocity, viscosity = np.zeros_like(points), np.zeros(len(points))
    # A lid moves its own layers, not the corners of the walls beside it: they stand still.
    for number in range(2 * dimension):
        side, axis = _side(scene, number), number // 2
        behind = points[:, axis] < low[axis] if number % 2 == 0 else points[:, axis] > high[axis]
        if side.kind == "wall" and holds(side, material):
            viscosity[behind] = material.viscosity
        if side.velocity is not None:
            velocity[behind] = side.velocity
    return Dummies(np.ascontiguousarray(points.T), np.ascontiguousarray(velocity.T), viscosity)
