"""What holds the liquid: planes with images behind them, and layers of dummy particles."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ecume.engine.boundary_images import Sides
from ecume.engine.cells import Integers
from ecume.errors import Fault, SceneError
from ecume.models.sph.defaults import color_reach_of
from ecume.models.sph.parameters import Boundary, Dummies, Material
from ecume.models.sph.solids import grains, obstacle_grains, shape_of, solids_of
from ecume.models.sph.wall_reflection import guard_of
from ecume.scenes.sph import SIDES, SphScene
from ecume.units import Array

LAYERED = ("wall", "inflow", "outflow")
LEAST_PERIOD = 1.2
"""Of a periodic tank, in supports: lists look a little further than a support."""


def boundary_of(scene: SphScene, material: Material, support: float) -> Boundary:
    """The tank, what stands in it, and the bodies' particles about their middles."""
    require_long_periods(scene, max(support, color_reach_of(scene)))
    sides, table, image_owner = _imaging_sides(scene)
    solids = solids_of(scene)
    middle = 0.5 * (np.array(scene.tank.low) + np.array(scene.tank.high))
    walls = 2 * len(middle)
    names = SIDES[:walls]
    names += tuple(f"obstacle{index}" for index in range(len(scene.obstacles)))
    names += tuple(f"body{index}" for index in range(len(scene.bodies)))
    centers = np.zeros((len(names), 3))
    centers[:, : len(middle)] = [*[middle] * walls, *[solid.middle() for solid in solids]]
    dummies = joined([_layers(scene, material, support), *_of_solids(scene, material, support)])
    return Boundary(sides, table, image_owner, dummies, guard_of(scene), names, centers)


def require_long_periods(scene: SphScene, support: float) -> None:
    """A periodic tank must be longer than a support, or a particle would miss its neighbors' further images."""
    size = np.array(scene.tank.high) - np.array(scene.tank.low)
    for axis in range(len(size)):
        if _side(scene, 2 * axis).kind == "periodic" and size[axis] < LEAST_PERIOD * support:
            least = LEAST_PERIOD * support
            came = f"{size[axis]:.4g} m along {'xyz'[axis]}, where the tank is periodic"
            raise SceneError([Fault("tank.high", f"came {came}; wanted {least:.4g} m, or a smaller spacing")])


def joined(pieces: list[Dummies]) -> Dummies:
    """One after the other."""
    return Dummies(*(np.ascontiguousarray(np.concatenate(parts, axis=-1)) for parts in zip(*pieces, strict=True)))


def dummies_at(points: Array, volume: Array, viscosity: float, owner: int) -> Dummies:
    """A solid's particles at rest, from points (n, d)."""
    count = len(points)
    number = np.full(count, owner, np.int64)
    return Dummies(points.T.copy(), np.zeros_like(points.T), np.full(count, viscosity), volume, number)


def _of_solids(scene: SphScene, material: Material, support: float) -> list[Dummies]:
    pieces, first = [], 2 * len(scene.tank.low)
    for index, (points, volume) in enumerate(obstacle_grains(scene, support)):
        viscosity = material.viscosity * holds(scene.obstacles[index], scene)
        pieces.append(dummies_at(points, volume, viscosity, first + index))
    for index, spec in enumerate(scene.bodies):
        shape = shape_of(spec)
        points, volume = grains(shape, scene.spacing, support)
        viscosity = material.viscosity * holds(spec, scene)
        owner = first + len(scene.obstacles) + index
        pieces.append(dummies_at(points - shape.middle(), volume, viscosity, owner))
    return pieces


def _side(scene: SphScene, number: int) -> Any:
    return getattr(scene.tank, SIDES[number])


def holds(side: Any, scene: SphScene) -> bool:
    """Whether the no-slip condition holds at a wall: by default where the scene gives a viscosity."""
    return bool(side.slip == "no-slip" or (side.slip is None and scene.liquid.viscosity))


def _imaging_sides(scene: SphScene) -> tuple[Sides, Array, Integers]:
    """Mirrors, and periodic sides, and the number of each mirror's side in the tank (-1: periodic). Mirrors first: a
    periodic side then repeats the mirrored ones.
    """
    dimension = len(scene.tank.low)
    mirrors = scene.tank.walls == "mirror"
    rows, numbers = [], []
    for number in range(2 * dimension):
        side, axis = _side(scene, number), number // 2
        if side.kind == "periodic" or (side.kind == "wall" and mirrors):
            rows.append(_row(scene, number, axis, holds(side, scene)))
            numbers.append(number if side.kind == "wall" else -1)
    order = sorted(range(len(rows)), key=lambda k: -rows[k][3 * dimension])
    table = np.array([rows[k] for k in order]).reshape(-1, 4 * dimension + 2)
    owner, d = np.array([numbers[k] for k in order], np.int64), dimension
    periodic = table[:, 3 * d] == 0.0
    shift = np.where(periodic[:, None], table[:, 2 * d : 3 * d], 0.0)
    return Sides(table[:, :d], table[:, d : 2 * d], shift, (~periodic).astype(np.int64)), table, owner


def _row(scene: SphScene, number: int, axis: int, hold: bool) -> list[float]:
    """Point, normal, shift or velocity, whether it mirrors, whether it holds, acceleration."""
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    side, first = _side(scene, number), number % 2 == 0
    normal, third = np.zeros(len(low)), np.zeros(len(low))
    normal[axis] = 1.0 if first else -1.0
    if side.kind == "periodic":
        third[axis] = (high - low)[axis] * normal[axis]
    elif side.velocity is not None:
        third[:] = side.velocity
    flags = float(side.kind == "wall"), float(hold)
    return [*(low if first else high), *normal, *third, *flags, *np.zeros(len(low))]


def _layers(scene: SphScene, material: Material, support: float) -> Dummies:
    """Layers of dummies around the tank, as thick as the support, where its sides are walls."""
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    dimension, spacing = len(low), scene.spacing
    if scene.tank.walls != "dummy":
        return dummies_at(np.zeros((0, dimension)), np.zeros(0), 0.0, 0)
    layers = math.ceil(support / spacing - 1e-9)
    axes = []
    for axis in range(dimension):
        count = round((high - low)[axis] / spacing)
        # Walls go on beside the buffers of in- and outflows.
        first = -layers if _side(scene, 2 * axis).kind in LAYERED else 0
        last = count + layers if _side(scene, 2 * axis + 1).kind in LAYERED else count
        axes.append(low[axis] + spacing * (np.arange(first, last) + 0.5))
    points = np.stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")], axis=1)
    walled = np.array([_side(scene, number).kind == "wall" for number in range(2 * dimension)])
    outside = (((points < low) & walled[0::2]) | ((points > high) & walled[1::2])).any(axis=1)
    points = points[outside]
    velocity, viscosity, owner = np.zeros_like(points), np.zeros(len(points)), np.zeros(len(points), np.int64)
    # A lid moves its own layers, not the corners of the walls beside it: they stand still.
    for number in range(2 * dimension):
        side, axis = _side(scene, number), number // 2
        behind = points[:, axis] < low[axis] if number % 2 == 0 else points[:, axis] > high[axis]
        if side.kind == "wall":
            owner[behind] = number
        if side.kind == "wall" and holds(side, scene):
            viscosity[behind] = material.viscosity
        if side.velocity is not None:
            velocity[behind] = side.velocity
    volume = np.full(len(points), spacing**dimension)
    return Dummies(np.ascontiguousarray(points.T), np.ascontiguousarray(velocity.T), viscosity, volume, owner)
