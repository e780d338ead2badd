"""Periodic boxes that may be sheared: nearest copies of particles, and the copies around a box."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.errors import BadInput
from ecume.trajectories.frame import Frame
from ecume.trajectories.gsd import SIDES
from ecume.units import Array, Length, Number

Integers = NDArray[np.int64]


class Box(NamedTuple):
    """A periodic box with one corner at the origin; copies above and below are displaced along x, after Lees and
    Edwards.
    """

    sides: Array
    """(d,) m; zero along axes that are not periodic, as across walls"""
    strain: Number = 0.0
    """the displacement along x of the copy above, over the height of the box"""

    @property
    def closed(self) -> bool:
        """Flags of the periodic axes."""
        return bool((self.sides > 0.0).all())

    @property
    def volume(self) -> float:
        """The volume (m^d). Raises BadInput if an axis is open."""
        if not self.closed:
            raise BadInput("only a box that is periodic along each axis has a volume")
        return float(np.prod(self.sides))

    @property
    def tilt(self) -> Array:
        """The lattice vectors as columns (d, d), in m."""
        matrix = np.diag(self.sides)
        matrix[0, 1] = self.strain * self.sides[1]
        return matrix


class Copies(NamedTuple):
    """Particles in a box and around it."""

    position: Array
    """(M, d), the particles themselves first"""
    owner: Integers
    """(M,) the particle of which each is a copy"""


def box_of(frame: Frame) -> Box | None:
    """The box of a frame, periodic along the axes with sides in the frame; None without sides."""
    sides = np.array([frame.numbers.get(name, 0.0) for name in SIDES[: frame.arrays["position"].shape[1]]])
    if not sides.any():
        return None
    tilt, strain = frame.numbers.get("box_tilt"), frame.numbers.get("strain", 0.0)
    if not sides[:2].all() and (tilt or strain):
        raise BadInput(f"the frames have a box that is sheared, but no number {SIDES[int(sides[0] > 0.0)]!r}")
    return Box(sides, strain if tilt is None or not sides[1] else tilt / float(sides[1]))


def nearest(between: Array, box: Box | None) -> Array:
    """The shortest vectors (n, d), in m, between particles and all copies of others.

    >>> nearest(np.array([[0.2, 0.9]]), Box(np.ones(2), strain=0.25)).round(12)
    array([[-0.05, -0.1 ]])
    """
    if box is None:
        return between
    boxes = np.round(_in_sides(between[:, 1], box.sides[1]))
    found = between.copy()
    found[:, 0] -= box.strain * box.sides[1] * boxes
    found -= box.sides * np.round(_in_sides(found, box.sides))
    return found


def _in_sides(along: Array, sides: Array) -> Array:
    """The ratio of a length to the side of the box; zero along an axis without a period."""
    return np.asarray(np.divide(along, sides, out=np.zeros_like(along), where=sides > 0.0))


def copies(position: Array, box: Box | None, margin: Length) -> Copies:
    """The particles in their box, and all copies less than a margin outside it."""
    if box is None:
        return Copies(position, np.arange(len(position)))
    home = wrapped(position, box)
    places, owners = [home], [np.arange(len(home))]
    reach = np.where(box.sides > 0.0, np.ceil(_in_sides(np.full(len(box.sides), margin), box.sides)) + 1.0, 0.0)
    for shift in itertools.product(*(range(-n, n + 1) for n in reach.astype(int))):
        move = np.array(shift)
        if move.any():
            moved = home + box.tilt @ _beside(move, box)
            seen = ((box.sides == 0.0) | ((moved > -margin) & (moved < box.sides + margin))).all(axis=1)
            places.append(moved[seen])
            owners.append(np.flatnonzero(seen))
    return Copies(np.concatenate(places), np.concatenate(owners))


def wrapped(position: Array, box: Box) -> Array:
    """The copy of each particle inside the box."""
    rows = np.floor(_in_sides(position[:, 1], box.sides[1]))
    home = position.copy()
    home[:, 0] -= box.strain * box.sides[1] * rows
    home -= box.sides * np.floor(_in_sides(home, box.sides))
    return home


def _beside(move: Integers, box: Box) -> Integers:
    """The same rows of copies with their new numbers: zero is the row that is now next to the box."""
    straight = move.copy()
    if box.strain != 0.0:
        straight[0] -= round(box.strain * box.sides[1] * move[1] / box.sides[0])
    return straight
