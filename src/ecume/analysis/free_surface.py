"""The free surface of a liquid of particles: its front, its height in columns, and its particles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from contourpy import contour_generator
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ecume.analysis.grids import filled_on_grid, grid_over
from ecume.engine.cells import Sides, images_of, positions_of_images
from ecume.engine.shapes import Flags
from ecume.errors import BadInput
from ecume.scenes.quantities import AXES, Up, sides_along
from ecume.scenes.sph import TankSpec
from ecume.trajectories.frame import Frame
from ecume.units import Array, Length

TOGETHER = 1.6
"""The largest distance, in spacings, of connected particles of a liquid."""


def front_position(frame: Frame, spacing: Length, *, below: Length = np.inf, up: Up = "y") -> float:
    """The largest x of the liquid (m), measured at its edge and without separate drops. Only the part below the height
    `below` is included.
    """
    position = frame.arrays["position"]
    near = largest_piece(position, spacing) & (position[:, AXES.index(up)] < below)
    if not near.any():
        raise BadInput(f"no liquid below {below:g} m")
    return float(position[near, 0].max()) + 0.5 * spacing


def largest_piece(position: Array, spacing: Length) -> Flags:
    """Flags (N,) of the particles of the largest connected piece of liquid."""
    pairs = cKDTree(position).query_pairs(TOGETHER * spacing, output_type="ndarray")
    count = len(position)
    graph = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    _, piece = connected_components(graph, directed=False)
    mine: Flags = piece == np.bincount(piece).argmax()
    return mine


def level_by_column(frame: Frame, edges: Array) -> Array:
    """The depth of the liquid in each column if it were at rest (m): its volume over the area of
    the column.

    `edges` are those of the columns along x, one more than columns, in 2D.
    """
    if np.any(np.diff(edges) <= 0.0):
        raise BadInput("edges of columns must grow from one to the next")
    volume = frame.arrays["mass"] / frame.arrays["density"]
    found, _ = np.histogram(frame.arrays["position"][:, 0], edges, weights=volume)
    depth: Array = found / np.diff(edges)
    return depth


def top_by_column(frame: Frame, edges: Array, spacing: Length, up: Up = "y") -> Array:
    """The highest point of the liquid in each column (m), including spray; NaN in empty columns."""
    position = frame.arrays["position"]
    column = np.digitize(position[:, 0], edges) - 1
    tops = np.full(len(edges) - 1, -np.inf)
    inside = (column >= 0) & (column < len(tops))
    np.maximum.at(tops, column[inside], position[inside, AXES.index(up)] + 0.5 * spacing)
    return np.where(np.isfinite(tops), tops, np.nan)


HALF = 0.5
REACH = 4.0
"""The range of a particle's kernel, in spacings."""
FINE = 0.5
"""The spacing of the grid, in spacings of particles."""


class Walls(NamedTuple):
    """The corners of a tank (m); infinite at open sides. The liquid has no surface at a wall."""

    low: Array
    high: Array


def walls_of(tank: TankSpec, up: Up = "y") -> Walls:
    """The walls of a scene's tank."""
    low, high = np.array(tank.low, dtype=float), np.array(tank.high, dtype=float)
    for index, side in enumerate(sides_along(up, len(low))):
        if getattr(tank, side).kind == "open":
            (low if index % 2 == 0 else high)[index // 2] = -np.inf if index % 2 == 0 else np.inf
    return Walls(low, high)


def free_surface(frame: Frame, spacing: Length, walls: Walls | None = None) -> list[Array]:
    """The outline of a liquid in 2D as lines, (K, 2) each, in m; a closed one ends where it begins.

    The outline is the contour at one half of the sum of the kernel. The liquid is mirrored at walls, so that no outline
    runs along them.
    """
    position = frame.arrays["position"]
    if position.shape[1] != 2:
        raise BadInput(f"an outline needs frames in 2D; these frames have {position.shape[1]} dimensions")
    if not len(position):
        return []
    reach, room = REACH * spacing, 1.5 * REACH * spacing
    low, high = position.min(axis=0) - room, position.max(axis=0) + room
    if walls is not None:
        low, high = np.maximum(low, walls.low), np.minimum(high, walls.high)
    grid = grid_over(low, high, FINE * spacing)
    field = filled_on_grid(frame if walls is None else mirrored(frame, walls, reach), grid, reach)
    lines = contour_generator(grid.axes[0], grid.axes[1], field.T).lines(HALF)
    return [np.asarray(line, dtype=float) for line in lines]


def mirrored(frame: Frame, walls: Walls, reach: Length) -> Frame:
    """The frame with images of its particles behind walls closer than the reach."""
    sides = _sides(walls)
    position = frame.arrays["position"].T
    images = images_of(position, sides, reach)
    source = images.source.copy()
    # An image may be the image of an image; each is traced back to its particle.
    while (late := source >= position.shape[1]).any():
        source[late] = source[source[late] - position.shape[1]]
    arrays = {name: np.concatenate([array, array[source]]) for name, array in frame.arrays.items()}
    positions = np.concatenate([position, positions_of_images(position, images, sides)], axis=1)
    return frame.with_arrays({**arrays, "position": np.ascontiguousarray(positions.T)})


def _sides(walls: Walls) -> Sides:
    """The walls as mirrors."""
    dimension = len(walls.low)
    rows = [
        (axis, corner, sign) for corner, sign in ((walls.low, 1.0), (walls.high, -1.0)) for axis in range(dimension)
    ]
    kept = [(axis, corner[axis], sign) for axis, corner, sign in rows if np.isfinite(corner[axis])]
    point, normal = np.zeros((len(kept), dimension)), np.zeros((len(kept), dimension))
    for row, (axis, place, sign) in enumerate(kept):
        point[row, axis], normal[row, axis] = place, sign
    return Sides(point, normal, np.zeros_like(point), np.ones(len(kept), np.int64))
