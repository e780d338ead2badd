"""Where the eye stands before what is in space, and the edges of boxes as it sees them."""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np

from ecume.units import Array

UPRIGHT = np.eye(3)
"""The directions right, up and towards the eye of an eye straight before it, where y points up."""
STANDING = np.array([(1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)])
"""The same where z points up."""


class Eye(NamedTuple):
    """From where what is in space is seen."""

    azimuth: float = 28.0
    """degrees by which it goes around the vertical, to its right"""
    elevation: float = 20.0
    """degrees by which it looks from above"""

    def camera(self, ahead: Array = UPRIGHT) -> Array:
        """Its right, up, and towards it, (3, 3). `ahead` are the same of an eye at azimuth and elevation 0."""
        turn, rise = math.radians(self.azimuth), math.radians(self.elevation)
        right = np.array([math.cos(turn), 0.0, -math.sin(turn)])
        level = np.array([math.sin(turn), 0.0, math.cos(turn)])
        toward = math.cos(rise) * level + math.sin(rise) * np.array([0.0, 1.0, 0.0])
        seen: Array = np.array([right, np.cross(toward, right), toward]) @ ahead
        return seen


class Wires(NamedTuple):
    """Edges of a box, as they are seen: (2, 2) m each."""

    front: list[Array]
    behind: list[Array]


def edges_of(low: Array, high: Array) -> list[Array]:
    """The twelve edges of a box, (2, 3) each."""
    corners = [np.where(choice, high, low) for choice in itertools.product((False, True), repeat=3)]
    pairs = itertools.combinations(corners, 2)
    return [np.array(pair) for pair in pairs if np.count_nonzero(pair[0] != pair[1]) == 1]


def wires_of(low: Any, high: Any, camera: Array) -> Wires:
    """Those of its edges that are behind what it holds, and the others."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    farthest, found = np.where(camera[2] > 0.0, low, high), Wires([], [])
    for edge in edges_of(low, high):
        hidden = (edge == farthest).all(axis=1).any()
        (found.behind if hidden else found.front).append(edge @ camera[:2].T)
    return found
