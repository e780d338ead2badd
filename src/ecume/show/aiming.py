"""Pictures that look closer: at the middle of what they show, or after one particle."""

from __future__ import annotations

from typing import Any, NamedTuple

from ecume.errors import BadInput
from ecume.show.picture import Picture, View, scale_bar, view_around
from ecume.trajectories.frame import Frame


class Aim(NamedTuple):
    """What a picture looks at, and how closely."""

    zoom: float = 1.0
    """How many times larger all is seen."""
    follow: int | None = None
    """The particle that stays in the middle; left out, the middle of the world does."""


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
        """Where a particle is seen (m)."""
        count = len(frame.arrays["position"])
        if not 0 <= one < count:
            raise BadInput(f"there is no particle {one} to follow; at {frame.time:g} s there are 0 to {count - 1}")
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
