"""What a part of space can tell, and a solid one besides. Points are (N, d)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ecume.units import Array

Flags = NDArray[np.bool_]


class Part(Protocol):
    """A part of space that liquid fills."""

    def bounds(self) -> tuple[Array, Array]:
        """Its lowest and highest corner, each (d,)."""

    def inside(self, points: Array) -> Flags:
        """(N,) whether each point is inside."""

    def way_out(self, points: Array, direction: Array) -> Array:
        """(N,) how far it is from each point inside to the boundary along a unit vector."""

    def anchor(self) -> Array:
        """A corner of the lattice that fits it best, (d,)."""


class Shape(Part, Protocol):
    """A part of space that may be solid."""

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """(N,) how far outside each point is (negative: inside), and (N, d) the slope of that: the way out."""

    def rim(self, spacing: float) -> Array:
        """(S, d) points of the boundary, its corners among them, no farther apart than the spacing."""

    def middle(self) -> Array:
        """(d,) the center of mass."""

    def volume(self) -> float:
        """The volume; in 2D the area."""

    def surface(self) -> float:
        """The area of its boundary; in 2D the length."""

    def inertia(self) -> Array:
        """(3,) moments of inertia about the axes through the center, for unit mass; in 2D only the last is used."""

    def thickness(self) -> float:
        """Between the two parallel lines or planes that hold it most narrowly."""

    def carried(self, way: Array) -> Shape:
        """The same shape, moved by (d,)."""


def apart(points: Array, shapes: Sequence[Part]) -> Flags:
    """Flags of points outside of all shapes."""
    free = np.ones(len(points), bool)
    for shape in shapes:
        free &= ~shape.inside(points)
    return free
