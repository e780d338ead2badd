"""Solids in a tank as they are drawn: obstacles, rigid bodies, and moving sides of the tank."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume.engine import shapes
from ecume.engine.shapes import Ball, Box, Polygon
from ecume.scenes.sph import SIDES
from ecume.show.tank import Round, Shape, seen
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.sph import SphScene

ROUND = np.linspace(0.0, 2.0 * np.pi, 49)
THICK = 0.4
"""Of a side that moves, in spacings."""
FINE = 0.25
"""Width of the cells of solids, in spacings."""


def movers_of(scene: SphScene, camera: Array | None = None) -> Callable[[Frame], list[Array]] | None:
    """The outlines of bodies and moving sides in a frame; None where nothing moves."""
    driven = [side for side in SIDES if getattr(scene.tank, side).motion is not None]
    if not scene.bodies and not driven:
        return None

    def outlines(frame: Frame) -> list[Array]:
        found = [line for number, body in enumerate(scene.bodies) for line in body_lines(body, number, frame, camera)]
        return found + [side_line(scene, side, frame) for side in driven if camera is None]

    return outlines


def mover_colors(scene: SphScene, usual: str, flat: bool) -> list[str]:
    """The colors of these lines in their order: each body's own, where it has one."""
    bodies = [body.color or usual for body in scene.bodies for _ in range(lines_of(body, flat))]
    driven = [side for side in SIDES if getattr(scene.tank, side).motion is not None]
    return bodies + [usual] * (len(driven) * flat)


def lines_of(body: Any, flat: bool) -> int:
    """The number of lines that a body is drawn with: a box in 3D has twelve edges."""
    return 1 if flat or body.radius is not None else 12


def body_lines(body: Any, number: int, frame: Frame, camera: Array | None) -> list[Array]:
    """A body at its position: its outline in 2D; in 3D a circle, or the edges of a box."""
    shape = shape_of(body)
    middle, turn = placed(number, frame, len(shape.middle()))
    if camera is None:
        return [middle + corners(shape) @ turn.T]
    if isinstance(shape, Ball):
        return [ball_outline(middle, shape.radius, camera)]
    return [seen(middle + edge @ turn.T, camera) for edge in edges(shape)]


def solid_cells(scene: SphScene, frame: Frame, tank: tuple[Array, Array]) -> tuple[Array, Array]:
    """Heights (m) and volumes of cells that fill the obstacles and bodies of a frame between the corners of a tank,
    each place once.
    """
    low, high = tank
    heights, volumes, earlier = [np.zeros(0)], [np.zeros(0)], list[shapes.Shape]()
    for number, spec in enumerate((*scene.obstacles, *scene.bodies), -len(scene.obstacles)):
        shape = drawn_shape(spec) if number < 0 else shape_of(spec)
        points, volume, _ = shape.cells(FINE * scene.spacing)
        if number >= 0:
            middle, turn = placed(number, frame, len(low))
            points = middle + points @ turn.T
        inside = ((points > low) & (points < high)).all(axis=1) & shapes.apart(points, earlier)
        heights.append(points[inside, 1])
        volumes.append(volume[inside])
        earlier += [shape] if number < 0 else []
    return np.concatenate(heights), np.concatenate(volumes)


def placed(number: int, frame: Frame, dimension: int) -> tuple[Array, Array]:
    """Where the middle of a body is in a frame, and its rotation since the start."""
    name, read = f"body{number}", frame.numbers
    middle = np.array([read[f"{name}_{axis}"] for axis in "xyz"[:dimension]])
    if dimension == 2:
        return middle, rotation(read[f"{name}_angle"])
    return middle, turned([read[f"{name}_q{part}"] for part in "wxyz"])


def ball_outline(middle: Array, radius: float, camera: Array) -> Array:
    """A ball as it is seen: round from everywhere."""
    outline: Array = seen(middle[None], camera) + radius * np.column_stack([np.cos(ROUND), np.sin(ROUND)])
    return outline


def shape_of(body: Any) -> shapes.Shape:
    """About its middle."""
    shape = drawn_shape(body)
    return shape.carried(-shape.middle())


def drawn_shape(spec: Any) -> shapes.Shape:
    """A solid as the scene has it."""
    if spec.vertices:
        return Polygon(np.array(spec.vertices))
    if spec.radius is not None:
        return Ball(np.array(spec.center), spec.radius)
    return Box(np.array(spec.low), np.array(spec.high))


def corners(shape: shapes.Shape) -> Array:
    """The corners of a shape in 2D; a disc is a polygon with a spoke, so that its rotation shows."""
    if isinstance(shape, Polygon):
        return shape.vertices
    if isinstance(shape, Ball):
        circle: Array = shape.radius * np.column_stack([np.cos(ROUND), np.sin(ROUND)])
        return np.concatenate([circle, np.zeros((1, 2))])
    low, high = shape.bounds()
    return np.array([low, (high[0], low[1]), high, (low[0], high[1])])


def edges(shape: shapes.Shape) -> list[Array]:
    """The twelve edges of a box, (2, 3) each."""
    low, high = shape.bounds()
    points = np.array([[(low, high)[bit >> axis & 1][axis] for axis in range(3)] for bit in range(8)])
    return [points[[one, one | 1 << axis]] for axis in range(3) for one in range(8) if not one >> axis & 1]


def rotation(angle: float) -> Array:
    """The rotation matrix in 2D."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def turned(quaternion: list[float]) -> Array:
    """The rotation in 3D, by a unit quaternion (w, x, y, z)."""
    w, axis = quaternion[0], np.array(quaternion[1:])
    cross = np.cross(np.eye(3), axis)
    matrix: Array = np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross
    return matrix


def side_line(scene: SphScene, side: str, frame: Frame) -> Array:
    """A side of the tank where it is, as thick as a wall."""
    number = SIDES.index(side)
    axis, first = number // 2, number % 2 == 0
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    place = float((low if first else high)[axis]) + frame.numbers[f"{side}_position"]
    ends = place, place + (-1.0 if first else 1.0) * THICK * scene.spacing
    low[axis], high[axis] = min(ends), max(ends)
    return np.array([low, (high[0], low[1]), high, (low[0], high[1])])


def rectangle(low: Any, high: Any) -> Array:
    """The corners of a box in 2D, counterclockwise from the lowest."""
    return np.array([(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])])


def outline(shape: Any) -> Shape:
    """A shape of the scene as it is drawn."""
    if shape.vertices:
        return np.array(shape.vertices)
    if shape.radius is not None:
        return Round(shape.center[0], shape.center[1], shape.radius)
    return rectangle(shape.low, shape.high)
