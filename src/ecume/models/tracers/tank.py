"""From a scene's tank to surfaces; compiles nothing new, so that pictures may ask, too."""

from __future__ import annotations

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
            if given is not None:
                shapes.append(inside_of(given) if isinstance(given, TankSpec) else walls.outside(body_of(given)))
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
    return made


class Coefficients(NamedTuple):
    """Restitution and tangential restitution of each surface, (K,)."""

    normal: Array
    tangential: Array


def coefficients_of(scene: TracersScene) -> Coefficients:
    """Those of walls, then of obstacles. Raises SceneError for a wall that the tank does not have."""
    usual = (1.0, 1.0) if scene.tank is None else (scene.tank.restitution, scene.tank.tangential_restitution)
    rows = np.zeros((0, 2))
    if scene.tank is not None:
        rows = np.tile(usual, (len(inside_of(scene.tank).kind), 1))
        for index, wall in enumerate(scene.tank.walls):
            if wall.wall >= len(rows):
                message = f"got {wall.wall}; the tank has {len(rows)} walls, numbered from 0"
                raise SceneError([Fault(f"tank.walls[{index}].wall", message)])
            rows[wall.wall] = own_or(wall, usual)
    parts = [rows, *(np.tile(own_or(body, usual), (len(body_of(body).kind), 1)) for body in scene.obstacles)]
    found = np.concatenate(parts)
    return Coefficients(found[:, 0], found[:, 1])


def own_or(given: WallSpec | ObstacleSpec, usual: tuple[float, float]) -> tuple[float, float]:
    """The coefficients of a wall or an obstacle; by default the usual ones."""
    own = given.restitution, given.tangential_restitution
    normal, tangential = (other if one is None else one for one, other in zip(own, usual, strict=True))
    return normal, tangential


def inside_of(tank: TankSpec) -> Surfaces:
    """The walls of a tank."""
    if tank.high is not None:
        return walls.box(tank.low or (0.0,) * len(tank.high), tank.high)
    if tank.radius is not None:
        return walls.disc([0.0] * tank.dimensions, tank.radius)
    return walls.polygon(tank.vertices) if len(tank.vertices[0]) == 2 else walls.polyhedron(tank.vertices)


def body_of(body: ObstacleSpec) -> Surfaces:
    """An obstacle, seen from inside."""
    if body.low is not None and body.high is not None:
        return walls.box(body.low, body.high)
    if body.center is not None and body.radius is not None:
        return walls.disc(body.center, body.radius)
    return walls.polygon(body.vertices) if len(body.vertices[0]) == 2 else walls.polyhedron(body.vertices)


def nothing(dimensions: int) -> Surfaces:
    """A tank without walls."""
    one = walls.planes([[0.0] * dimensions], [[1.0] + [0.0] * (dimensions - 1)])
    return one._replace(kind=one.kind[:0], place=one.place[:0], size=one.size[:0], velocity=one.velocity[:0],
                        face=one.face[:0])  # fmt: skip
