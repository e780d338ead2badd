"""The camera of a picture: zoom, a particle to follow, and the viewpoint in 3D."""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np

from ecume.errors import BadInput
from ecume.show.picture import Picture, View, scale_bar, view_around
from ecume.trajectories.frame import Frame
from ecume.units import Array

UPRIGHT = np.eye(3)
"""The directions right, up and towards the eye of an eye straight before it, where y points up."""
STANDING = np.array([(1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)])
"""The same where z points up."""


class Eye(NamedTuple):
    """The viewpoint of a picture in 3D."""

    azimuth: float = 28.0
    """degrees by which it goes around the vertical, to its right"""
    elevation: float = 20.0
    """degrees by which it looks from above"""

    def camera(self, ahead: Array = UPRIGHT) -> Array:
        """The directions right, up, and towards the eye, (3, 3). `ahead` are the same at azimuth and elevation 0."""
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
    """The edges of a box that are behind its contents, and the others."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    farthest, found = np.where(camera[2] > 0.0, low, high), Wires([], [])
    for edge in edges_of(low, high):
        hidden = (edge == farthest).all(axis=1).any()
        (found.behind if hidden else found.front).append(edge @ camera[:2].T)
    return found


class Aim(NamedTuple):
    """The part of the world that a picture shows."""

    zoom: float = 1.0
    """How many times larger all is seen."""
    follow: int | None = None
    """The particle that stays in the middle; by default the middle of the world does."""


WIDE = Aim()
"""All that there is."""


class Aimed(Picture):
    """An open picture that shows a part of another one's world."""

    def __init__(self, picture: Picture, aim: Aim) -> None:
        self.picture, self.aim = picture, aim
        self.figure, self.layers, self.bars = picture.figure, picture.layers, picture.bars
        whole = picture.view
        self.view = view_around(
            (whole.left + whole.right) / 2.0,
            (whole.bottom + whole.top) / 2.0,
            whole.width / aim.zoom,
            whole.height / aim.zoom,
        )
        _measure(self.bars, scale_bar(picture.figure.axes[0], self.view))
        self._look(self.view)

    def show(self, frame: Frame) -> None:
        """Put a frame into the picture."""
        if self.aim.follow is not None:
            x, y = self.place(frame, self.aim.follow)
            self._look(view_around(float(x), float(y), self.view.width, self.view.height))
        self.picture.show(frame)

    def place(self, frame: Frame, one: int) -> Any:
        """The position at which a particle is seen (m)."""
        count = len(frame.arrays["position"])
        if not 0 <= one < count:
            raise BadInput(f"no particle {one} at {frame.time:g} s; expected 0 to {count - 1}")
        return self.picture.place(frame, one)

    def _look(self, view: View) -> None:
        self.figure.axes[0].set(xlim=(view.left, view.right), ylim=(view.bottom, view.top))
        self.layers.forget()


def aimed(picture: Picture, aim: Aim) -> Picture:
    """The picture itself where there is nothing to aim at."""
    return picture if aim == WIDE else Aimed(picture, aim)


def _measure(bars: list[Any], right: list[Any]) -> None:
    """Let a scale bar say what another one says, which then goes."""
    (bar, text), (new_bar, new_text) = bars, right
    bar.set_xdata(new_bar.get_xdata())
    text.set_text(new_text.get_text())
    text.set_position(new_text.get_position())
    for artist in right:
        artist.remove()
