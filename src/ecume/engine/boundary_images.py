"""Images of particles behind planes: mirrored ones, which keep a kernel's surroundings full at a wall, and shifted ones
behind the sides of a periodic box.

Each side is worked off in turn, and images are mirrored again by the sides that follow: a corner gets its own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecume._portable import dot, product
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.engine.cells import Integers


class Sides(NamedTuple):
    """Planes with images behind them. A periodic pair is two sides with opposite shifts."""

    point: Array
    """(sides, d) somewhere on each"""
    normal: Array
    """(sides, d) unit, into the liquid"""
    shift: Array
    """(sides, d) what a periodic side adds to a position; zero for a mirror"""
    mirrors: Integers
    """(sides,) 1 for a mirror, 0 for a periodic side"""


class Images(NamedTuple):
    """The source of each image (it may be an earlier image), and the first image of each side."""

    source: Integers
    """(images,)"""
    start: Integers
    """(sides + 1,)"""


def images_of(position: Array, sides: Sides, reach: float) -> Images:
    """The images that stand closer than `reach` behind each side, of particles at `position`, (d, N).

    What stands behind a side already has none there: the images of a periodic side would come back onto their sources
    through the opposite one.
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
    """(d, images), of particles at `position`."""
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
