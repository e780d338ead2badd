"""Drawing of solids in a tank: obstacles, rigid bodies, and moving sides of the tank."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume.engine import shapes
from ecume.engine.shapes import Ball, Box, Polygon
from ecume.show.tank import Round, Shape, seen
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.sph import SphScene

ROUND = np.linspace(0.0, 2.0 * np.pi, 49)
THICK = 0.4
"""The thickness of a moving side, in spacings."""
FINE = 0.25
"""Width of the cells of solids, in spacings."""


def movers_of(scene: SphScene, camera: Array | None = None) -> Callable[[Frame], list[Array]] | None:
    """A function that returns the outlines of bodies and moving sides in a frame; None if all are at rest."""
    driven = [side for side in scene.sides if getattr(scene.tank, side).motion is not None]
    if not scene.bodies and not driven:
        return None

    def outlines(frame: Frame) -> list[Array]:
        named = zip(scene.body_names, scene.bodies, strict=True)
        found = [line for name, body in named for line in body_lines(body, name, frame, camera)]
        return found + [side_line(scene, side, frame) for side in driven if camera is None]

    return outlines


def mover_colors(scene: SphScene, usual: str, flat: bool) -> list[str]:
    """The colors of these lines in their order; bodies may have separate colors."""
    bodies = [body.color or usual for body in scene.bodies for _ in range(lines_of(body, flat))]
    driven = [side for side in scene.sides if getattr(scene.tank, side).motion is not None]
    return bodies + [usual] * (len(driven) * flat)


def lines_of(body: Any, flat: bool) -> int:
    """The number of lines of a drawn body: a box in 3D has twelve edges."""
    return 1 if flat or is_ball(body) else len(edges(shape_of(body)))


def is_ball(solid: Any) -> bool:
    """Whether a solid is a disc or a sphere."""
    return solid.radius is not None and getattr(solid, "axis", None) is None


def body_lines(body: Any, name: str, frame: Frame, camera: Array | None) -> list[Array]:
    """A body at its position: its outline in 2D; in 3D a circle, or the edges of a box."""
    shape = shape_of(body)
    middle, turn = placed(name, frame, len(shape.middle()))
    if camera is None:
        return [middle + corners(shape) @ turn.T]
    if isinstance(shape, Ball):
        return [ball_outline(middle, shape.radius, camera)]
    return [seen(middle + edge @ turn.T, camera) for edge in edges(shape)]


def solid_cells(scene: SphScene, frame: Frame, tank: tuple[Array, Array]) -> tuple[Array, Array]:
    """Heights and volumes of cells that fill the obstacles and bodies of a frame between the corners of a tank;
    overlaps count once.
    """
    low, high = tank
    heights, volumes, earlier = [np.zeros(0)], [np.zeros(0)], list[shapes.Shape]()
    for number, spec in enumerate((*scene.obstacles, *scene.bodies), -len(scene.obstacles)):
        shape = drawn_shape(spec) if number < 0 else shape_of(spec)
        points, volume, _ = shape.cells(FINE * scene.spacing)
        if number >= 0:
            middle, turn = placed(scene.body_names[number], frame, len(low))
            points = middle + points @ turn.T
        inside = ((points > low) & (points < high)).all(axis=1) & shapes.apart(points, earlier)
        heights.append(points[inside, scene.up_axis])
        volumes.append(volume[inside])
        earlier += [shape] if number < 0 else []
    return np.concatenate(heights), np.concatenate(volumes)


def placed(name: str, frame: Frame, dimension: int) -> tuple[Array, Array]:
    """The center of a body in a frame, and its rotation since the start."""
    read = frame.numbers
    middle = np.array([read[f"{name}_{axis}"] for axis in "xyz"[:dimension]])
    if dimension == 2:
        return middle, rotation(read[f"{name}_angle"])
    return middle, turned([read[f"{name}_q{part}"] for part in "wxyz"])


def ball_outline(middle: Array, radius: float, camera: Array) -> Array:
    """The outline of a ball, a circle from every viewpoint."""
    outline: Array = seen(middle[None], camera) + radius * np.column_stack([np.cos(ROUND), np.sin(ROUND)])
    return outline


def shape_of(body: Any) -> shapes.Shape:
    """The shape of a body relative to its center."""
    shape = drawn_shape(body)
    return shape.carried(-shape.middle())


def drawn_shape(solid: Any) -> shapes.Shape:
    """The shape of a solid at its position in the scene."""
    if is_ball(solid):
        return Ball(np.array(solid.center), solid.radius)
    if solid.vertices and len(solid.vertices[0]) == 2:
        return Polygon(np.array(solid.vertices))
    if solid.low is not None:
        return Box(np.array(solid.low), np.array(solid.high))
    from ecume.engine.outlines import hull_of  # meshes require the compiler, other shapes do not
    from ecume.models.sph.setup.shapes import shape_of as whole

    return whole(solid) if hasattr(solid, "triangles") else hull_of(np.array(solid.vertices))


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
    """The edges of a solid in 3D, (2, 3) each; for a mesh the sharp edges, or all if none is sharp."""
    triangles = getattr(shape, "triangles", None)
    if triangles is not None:
        return _edges_of_mesh(triangles)
    low, high = shape.bounds()
    points = np.array([[(low, high)[bit >> axis & 1][axis] for axis in range(3)] for bit in range(8)])
    return [points[[one, one | 1 << axis]] for axis in range(3) for one in range(8) if not one >> axis & 1]


SHARP = np.cos(np.radians(20.0))
"""The cosine of the angle between two faces above which the edge between them is drawn."""
MOST_EDGES = 400


def _edges_of_mesh(triangles: Array) -> list[Array]:
    size = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())
    corners = np.round(triangles.reshape(-1, 3) / (1e-7 * size))
    places = np.unique(corners, axis=0, return_inverse=True)[1].reshape(-1, 3)
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    ends = np.sort(np.concatenate([places[:, [0, 1]], places[:, [1, 2]], places[:, [2, 0]]]), axis=1)
    lines = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    order = np.lexsort((ends[:, 1], ends[:, 0]))
    pairs = np.flatnonzero((ends[order][1:] == ends[order][:-1]).all(axis=1))
    face = np.tile(np.arange(len(triangles)), 3)[order]
    bend = (normal[face[pairs]] * normal[face[pairs + 1]]).sum(axis=1)
    kept = order[pairs[bend < SHARP]]
    kept = kept if len(kept) else order[pairs]
    return list(lines[kept[:: -(-len(kept) // MOST_EDGES)]])


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
    """A side of the tank at its position, drawn with the thickness of a wall."""
    number = scene.sides.index(side)
    axis, first = number // 2, number % 2 == 0
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    place = float((low if first else high)[axis]) + frame.numbers[f"{side}_position"]
    ends = place, place + (-1.0 if first else 1.0) * THICK * scene.spacing
    low[axis], high[axis] = min(ends), max(ends)
    return np.array([low, (high[0], low[1]), high, (low[0], high[1])])


def rectangle(low: Any, high: Any) -> Array:
    """The corners of a box in 2D, counterclockwise from the lowest."""
    return np.array([(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])])


def outline(solid: Any, tank: Any) -> Shape:
    """The drawn outline of a solid in 2D. A hollow one is the tank, with a seam to the hole and back."""
    if solid.radius is not None:
        whole: Shape = Round(solid.center[0], solid.center[1], solid.radius)
    else:
        whole = np.array(solid.vertices) if solid.vertices else rectangle(solid.low, solid.high)
    if not getattr(solid, "hollow", False):
        return whole
    hole = corners(drawn_shape(solid)) if not isinstance(whole, Round) else _circle(whole)
    block, ring = rectangle(tank.low, tank.high), np.vstack([hole, hole[:1]])
    turn = float(np.sum(hole[:, 0] * np.roll(hole[:, 1], -1) - np.roll(hole[:, 0], -1) * hole[:, 1]))
    return np.vstack([block, block[:1], ring[::-1] if turn > 0.0 else ring, block[:1]])


def _circle(one: Round) -> Array:
    around: Array = np.array([one.x, one.y]) + one.radius * np.column_stack([np.cos(ROUND), np.sin(ROUND)])[:-1]
    return around
