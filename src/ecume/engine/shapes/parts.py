"""What a part of space can tell, and a solid one besides. Points are (N, d)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ecume.units import Array

Flags = NDArray[np.bool_]


class Cells(NamedTuple):
    """A shape cut into small cells."""

    centers: Array
    """(N, d)"""
    volumes: Array
    """(N,); areas in 2D"""
    widths: Array
    """(N, d) along each axis"""

    def those(self, which: Flags) -> Cells:
        """Some of them."""
        return Cells(self.centers[which], self.volumes[which], self.widths[which])


class Part(Protocol):
    """A part of space that liquid fills."""

    def bounds(self) -> tuple[Array, Array]:
        """Its lowest and highest corner, each (d,)."""

    def inside(self, points: Array) -> Flags:
        """(N,) whether each point is inside."""

    def way_out(self, points: Array, direction: Array) -> Array:
        """(N,) how far it is from each point inside to the boundary along a unit vector."""

    def cells(self, spacing: float, faces: Array | None = None) -> Cells:
        """A lattice that fits into it, with cells about as wide as the spacing; their volumes add up to its own.
        `faces`, (k, d), are coordinates along each axis where cells had best end.
        """

    def faces(self) -> Array:
        """(k, d) coordinates of its faces along each axis, if it is bounded by such faces alone; else none, (0, d)."""

    def volume(self) -> float:
        """Its volume; in 2D its area."""

    def volume_within(self, low: Array, high: Array) -> float | None:
        """The part of its volume that is inside a box; None where no formula gives it."""


class Shape(Part, Protocol):
    """A part of space that may be solid."""

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """(N,) how far outside each point is (negative: inside), and (N, d) the slope of that: the way out."""

    def rim(self, spacing: float) -> Array:
        """(S, d) points of the boundary, its corners among them, no farther apart than the spacing."""

    def middle(self) -> Array:
        """(d,) the center of mass."""

    def surface(self) -> float:
        """The area of its boundary; in 2D the length."""

    def inertia(self) -> Array:
        """(3,) moments of inertia about the axes through the center, for unit mass; in 2D only the last is used."""

    def thickness(self) -> float:
        """Between the two parallel lines or planes that hold it most narrowly."""

    def carried(self, way: Array) -> Shape:
        """The same shape, moved by (d,)."""


def whole_within(part: Part, low: Array, high: Array) -> float | None:
    """Its volume if all of it is inside a box."""
    first, last = part.bounds()
    return part.volume() if (first >= low).all() and (last <= high).all() else None


def apart(points: Array, shapes: Sequence[Part]) -> Flags:
    """Flags of points outside of all shapes."""
    free = np.ones(len(points), bool)
    for shape in shapes:
        free &= ~shape.inside(points)
    return free
