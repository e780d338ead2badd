"""Periodic boxes, and particles sorted into square (cubic) cells.

The periods of a box are an array (2, d): the lengths of its sides, and their inverses; both are zero along an axis
without a period. Positions need not lie inside the box.

Particles are sorted by counting: linear in their number, and stable, so that the order is always the same. Along a
periodic axis a whole number of cells fills the period.

Behind planes particles have images: mirrored ones at walls, which supply missing neighbors, and shifted ones behind the
sides of a periodic box.

The sides are processed one after the other, and later sides also mirror the images of earlier ones, so that corners are
complete.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume._portable import dot, product
from ecume.units import Array


def no_periods(dimension: int) -> Array:
    """The periods of a system without periodic axes."""
    return np.zeros((2, dimension))


def periods_of(sides: Sequence[float]) -> Array:
    """The periods of a box with these sides.

    >>> periods_of([4.0, 0.0]).tolist()
    [[4.0, 0.0], [0.25, 0.0]]
    """
    return np.array([[*sides], [1.0 / side if side > 0.0 else 0.0 for side in sides]])


@compiled_inside
def nearest(apart: float, period: float, inverse: float) -> float:
    """The component `apart` of the vector to the nearest image; unchanged if the period is zero.

    >>> float(nearest(3.5, 4.0, 0.25)), float(nearest(3.5, 0.0, 0.0))
    (-0.5, 3.5)
    """
    image: float = apart - period * np.floor(apart * inverse + 0.5)
    return image


def into_box(position: Array, periods: Array) -> Array:
    """The images of these positions that are inside the box, which begins at the origin."""
    home = position - periods[0] * np.floor(position * periods[1])
    # A coordinate just below zero is rounded up to the full period.
    return np.where((periods[0] > 0.0) & (home >= periods[0]), 0.0, home)


def images_in(position: Array, periods: Array) -> Integers:
    """The image numbers (N, d) of these positions: the number of periods between each and its image
    inside the box.

    >>> images_in(np.array([[-0.5, 9.0]]), periods_of([4.0, 0.0])).tolist()
    [[-1, 0]]
    """
    away: Integers = np.rint((position - into_box(position, periods)) * periods[1]).astype(np.int64)
    return away


Integers = np.ndarray[tuple[int, ...], np.dtype[np.int64]]


class Cells(NamedTuple):
    """The cell of each particle, and the particles sorted by cell."""

    low: Array
    """(d,) the lowest coordinate of all particles; zero along periodic axes"""
    size: Array
    """(1,) edge of a cell, at least the requested reach; along a periodic axis cells are somewhat wider"""
    shape: Integers
    """(d,) cells along each axis"""
    cell: Integers
    """(N,) the cell of a particle"""
    start: Integers
    """(cells + 1,) index in `order` of the first particle of each cell"""
    order: Integers
    """(N,) particles cell by cell, ascending inside a cell"""
    periods: Array
    """(2, d): see `ecume.engine.cells`"""


def make_cells(count: int, dimension: int, periods: Array | None = None) -> Cells:
    """Arrays for `count` particles. Cells are larger in sparse systems, so that their number does not much exceed that
    of particles.
    """
    return Cells(
        low=np.zeros(dimension),
        size=np.ones(1),
        shape=np.ones(dimension, np.int64),
        cell=np.zeros(count, np.int64),
        start=np.zeros(_most_cells(count) + 1, np.int64),
        order=np.zeros(count, np.int64),
        periods=no_periods(dimension) if periods is None else periods,
    )


def _most_cells(count: int) -> int:
    return 4 * count + 64


@compiled
def _lay_out(cells: Cells, position: Array, reach: float) -> int:
    """Choose origin, edge and shape of the cells. Returns the number of cells."""
    count, dimension = position.shape
    most = len(cells.start) - 1
    size = reach
    while True:
        total = 1.0
        for axis in range(dimension):
            low, high = position[0, axis], position[0, axis]
            for i in range(count):
                low, high = min(low, position[i, axis]), max(high, position[i, axis])
            cells.low[axis] = low
            along = np.floor((high - low) / size) + 1.0
            if cells.periods[0, axis] > 0.0:
                cells.low[axis] = 0.0
                along = max(np.floor(cells.periods[0, axis] / size), 1.0)
            total *= along
            cells.shape[axis] = np.int64(min(along, float(most)))
        if total <= most:
            break
        size *= 1.25
    cells.size[0] = size
    return int(total)


@compiled
def sort_into_cells(cells: Cells, position: Array, reach: float) -> None:
    """Sort particles into cells: two particles closer than `reach` are in the same cell or in adjacent ones."""
    count, dimension = position.shape
    total = _lay_out(cells, position, reach)
    for cell in range(total + 1):
        cells.start[cell] = 0
    for i in range(count):
        cell = 0
        for axis in range(dimension):
            if cells.periods[0, axis] > 0.0:
                part = position[i, axis] * cells.periods[1, axis]
                along = np.int64((part - np.floor(part)) * cells.shape[axis])
            else:
                along = np.int64((position[i, axis] - cells.low[axis]) / cells.size[0])
            cell = cell * cells.shape[axis] + min(along, cells.shape[axis] - 1)
        cells.cell[i] = cell
        cells.start[cell + 1] += 1
    for cell in range(total):
        cells.start[cell + 1] += cells.start[cell]
    for i in range(count - 1, -1, -1):
        cell = cells.cell[i]
        cells.start[cell + 1] -= 1
        cells.order[cells.start[cell + 1]] = i
    # The loop moved each start to the end of its cell: shift the starts by one cell.
    for cell in range(total):
        cells.start[cell] = cells.start[cell + 1]
    cells.start[total] = count


class Sides(NamedTuple):
    """Planes with images behind them. A periodic pair is two sides with opposite shifts."""

    point: Array
    """(sides, d) a point of each"""
    normal: Array
    """(sides, d) unit, into the liquid"""
    shift: Array
    """(sides, d) the displacement between a particle and its image at a periodic side; zero for a mirror"""
    mirrors: Integers
    """(sides,) 1 for a mirror, 0 for a periodic side"""


class Images(NamedTuple):
    """The source of each image (it may be an earlier image), and the first image of each side."""

    source: Integers
    """(images,) the particle or earlier image that each image copies"""
    start: Integers
    """(sides + 1,)"""


def images_of(position: Array, sides: Sides, reach: float) -> Images:
    """The images closer than `reach` to each side, of particles at `position`, (d, N).

    Images that are already behind a side have no image there, since those of a periodic side would coincide with their
    sources.
    """
    found, start = [np.empty(0, np.int64)], [0]
    here = position
    for side in range(len(sides.normal)):
        distance = distance_before(here, sides, side)
        near = np.flatnonzero((distance >= 0.0) & (distance < reach))
        found.append(near)
        start.append(start[-1] + len(near))
        here = np.concatenate([here, behind(here[:, near], sides, side)], axis=1)
    return Images(np.concatenate(found), np.array(start, np.int64))


def positions_of_images(position: Array, images: Images, sides: Sides) -> Array:
    """The positions of images, (d, images), of particles at `position`."""
    here = position
    for side in range(len(sides.normal)):
        sources = images.source[images.start[side] : images.start[side + 1]]
        here = np.concatenate([here, behind(here[:, sources], sides, side)], axis=1)
    return here[:, position.shape[1] :]


def distance_before(position: Array, sides: Sides, side: int) -> Array:
    """The distance of each particle from a side, positive inside."""
    distance: Array = product(sides.normal[side], position) - dot(sides.normal[side], sides.point[side])
    return distance


def behind(position: Array, sides: Sides, side: int) -> Array:
    """The positions of the images of particles at `position`."""
    if not sides.mirrors[side]:
        shifted: Array = position + sides.shift[side][:, None]
        return shifted
    mirrored: Array = position - 2.0 * sides.normal[side][:, None] * distance_before(position, sides, side)
    return mirrored
