"""The tank of tracers: walls, obstacles, openings and periodic sides as surfaces, with their restitution."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from ecume.engine import walls
from ecume.engine.walls import Surfaces
from ecume.errors import BadInput, Fault, SceneError
from ecume.scenes.tracers import ObstacleSpec, TankSpec, TracersScene, WallSpec
from ecume.units import Array


def surfaces_of(scene: TracersScene) -> Surfaces:
    """The walls of the tank, then of the obstacles, with the openings. Raises SceneError for an invalid shape."""
    faults: list[Fault] = []
    shapes: list[Surfaces] = []
    for path, given in (("tank", scene.tank), *((f"obstacles[{k}]", body) for k, body in enumerate(scene.obstacles))):
        try:
            if isinstance(given, TankSpec):
                shapes.append(inside_of(given))
            elif given is not None:
                shapes += [walls.outside(shifted(body_of(given), copy)) for copy in copies_of(scene)]
        except BadInput as error:
            faults.append(Fault(path, str(error)))
    made = walls.together(*shapes) if shapes else nothing(scene.dimensions)
    for k, hole in enumerate(scene.openings):
        try:
            made = walls.opening(made, hole.wall, hole.low, hole.high)
        except BadInput as error:
            faults.append(Fault(f"openings[{k}]", str(error)))
    if faults:
        raise SceneError(faults)
    return with_sticking(made, sticking_of(scene))


def with_sticking(surfaces: Surfaces, sticking: Array) -> Surfaces:
    """The surfaces, with an opening over the whole of each sticking surface appended."""
    held = np.flatnonzero(sticking)
    everywhere = np.full((len(held), surfaces.low.shape[1]), math.inf)
    return surfaces._replace(
        hole=np.append(surfaces.hole, held),
        low=np.vstack([surfaces.low, -everywhere]),
        high=np.vstack([surfaces.high, everywhere]),
    )


def sticking_of(scene: TracersScene) -> Array:
    """Flags (K,) of the sticking surfaces."""
    usual = scene.tank is not None and scene.tank.sticking
    rows = np.zeros(0, bool)
    if scene.tank is not None:
        rows = np.full(len(inside_of(scene.tank).kind), usual)
        for wall in scene.tank.walls:
            if wall.wall < len(rows) and wall.sticking is not None:
                rows[wall.wall] = wall.sticking
    bodies = [
        np.full(len(body_of(body).kind) * len(copies_of(scene)), usual if body.sticking is None else body.sticking)
        for body in scene.obstacles
    ]
    return np.concatenate([rows, *bodies]) if bodies else rows


class Periodic(NamedTuple):
    """The periodic axes of a box."""

    low: tuple[float, float, float]
    sides: tuple[float, float, float]
    """m; 0 along an axis that is not periodic"""

    @property
    def any(self) -> bool:
        """Whether any axis is periodic."""
        return max(self.sides) > 0.0


def periodic_of(scene: TracersScene) -> Periodic:
    """The periodic axes of the tank."""
    tank = scene.tank
    if tank is None or not tank.periodic or tank.high is None:
        return Periodic((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    low = tank.low or (0.0,) * len(tank.high)
    sides = [b - a if "xyz"[k] in tank.periodic else 0.0 for k, (a, b) in enumerate(zip(low, tank.high, strict=True))]
    return Periodic((*low, 0.0)[:3], (*sides, 0.0)[:3])  # type: ignore[arg-type]  # three numbers


def copies_of(scene: TracersScene) -> list[Array]:
    """The displacements (m) of an obstacle and its copies in adjacent periodic boxes; zero comes first."""
    sides = np.array(periodic_of(scene).sides[: scene.dimensions])
    steps = [(0, 1, -1) if side > 0.0 else (0,) for side in sides]
    return [np.array(way) * sides for way in itertools.product(*steps)]


def shifted(surfaces: Surfaces, way: Array) -> Surfaces:
    """The surfaces after a displacement."""
    return walls.moved(walls.moving(surfaces, way.tolist()), 1.0)._replace(velocity=surfaces.velocity)


class Coefficients(NamedTuple):
    """Restitution and tangential restitution of each surface, (K,)."""

    normal: Array
    tangential: Array


def coefficients_of(scene: TracersScene) -> Coefficients:
    """The coefficients of walls, then of obstacles. Raises SceneError for an unknown wall."""
    usual = (1.0, 1.0) if scene.tank is None else (scene.tank.restitution, scene.tank.tangential_restitution)
    rows = np.zeros((0, 2))
    if scene.tank is not None:
        rows = np.tile(usual, (len(inside_of(scene.tank).kind), 1))
        for index, wall in enumerate(scene.tank.walls):
            if wall.wall >= len(rows):
                message = f"got {wall.wall}; the tank has {len(rows)} walls, numbered from 0"
                raise SceneError([Fault(f"tank.walls[{index}].wall", message)])
            rows[wall.wall] = own_or(wall, usual)
    copies = len(copies_of(scene))
    parts = [rows, *(np.tile(own_or(body, usual), (len(body_of(body).kind) * copies, 1)) for body in scene.obstacles)]
    found = np.concatenate(parts)
    return Coefficients(found[:, 0], found[:, 1])


def own_or(given: WallSpec | ObstacleSpec, usual: tuple[float, float]) -> tuple[float, float]:
    """The coefficients of a wall or an obstacle; by default the common ones."""
    own = given.restitution, given.tangential_restitution
    normal, tangential = (other if one is None else one for one, other in zip(own, usual, strict=True))
    return normal, tangential


def inside_of(tank: TankSpec) -> Surfaces:
    """The walls of a tank, seen from inside."""
    if tank.high is not None:
        return across(walls.box(tank.low or (0.0,) * len(tank.high), tank.high), tank)
    if tank.radius is not None:
        return walls.disc([0.0] * tank.dimensions, tank.radius)
    return walls.polygon(tank.vertices) if len(tank.vertices[0]) == 2 else walls.polyhedron(tank.vertices)


def across(sides: Surfaces, tank: TankSpec) -> Surfaces:
    """The sides of a box without those across its periodic axes."""
    d = sides.dimension
    kept = [k for k in range(2 * d) if "xyz"[k % d] not in tank.periodic]
    return sides._replace(kind=sides.kind[kept], place=sides.place[kept], size=sides.size[kept],
                          velocity=sides.velocity[kept], face=sides.face[kept])  # fmt: skip


def body_of(body: ObstacleSpec) -> Surfaces:
    """The surfaces of an obstacle, seen from the liquid."""
    if body.low is not None and body.high is not None:
        return walls.box(body.low, body.high)
    if body.center is not None and body.radius is not None:
        return walls.disc(body.center, body.radius)
    return walls.polygon(body.vertices) if len(body.vertices[0]) == 2 else walls.polyhedron(body.vertices)


def around(body: ObstacleSpec) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The lower and the upper corner of the box around an obstacle."""
    if body.low is not None and body.high is not None:
        return body.low, body.high
    if body.center is not None and body.radius is not None:
        reach = body.radius
        return tuple(each - reach for each in body.center), tuple(each + reach for each in body.center)
    corner = np.array(body.vertices)
    return tuple(corner.min(axis=0).tolist()), tuple(corner.max(axis=0).tolist())


def nothing(dimensions: int) -> Surfaces:
    """A tank without walls."""
    one = walls.planes([[0.0] * dimensions], [[1.0] + [0.0] * (dimensions - 1)])
    return one._replace(kind=one.kind[:0], place=one.place[:0], size=one.size[:0], velocity=one.velocity[:0],
                        face=one.face[:0])  # fmt: skip


def bounds(scene: TracersScene) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The box around the tank; a unit box without one."""
    tank, d = scene.tank, scene.dimensions
    if tank is None:
        return (0.0,) * d, (1.0,) * d
    if tank.high is not None:
        return tank.low or (0.0,) * d, tank.high
    if tank.radius is not None:
        return (-tank.radius,) * d, (tank.radius,) * d
    corner = np.array(tank.vertices)
    return tuple(corner.min(axis=0).tolist()), tuple(corner.max(axis=0).tolist())
