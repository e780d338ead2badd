"""The parts that pictures of every model share: size, view, scale bar, legend, fast drawing.

What never changes is drawn once; a movie then draws only the rest of each frame.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection
from matplotlib.colors import to_rgba_array
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation
from numpy.typing import NDArray

from ecume.scenes.common import colors_of
from ecume.show.splat import MANY, Splat, splat_in
from ecume.show.style import INK, MUTED, plain, scale_for
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene

DPI = 100
LONGEST_TITLE = 50
"""In characters."""
LETTER, CLOCK = 9.0, 90.0
"""The width of a letter of the title and of the time beside it, in pixels of a picture of the usual size."""

Pixels = NDArray[np.uint8]


class Picture:
    """An open picture of a model's frames: what a row of `FILMS` makes of (scene, sample, size).

    `sample` are frames of the run: from them a picture takes its extent, and the range of its colors.
    """

    figure: Figure
    view: View
    bars: list[Artist]
    layers: Layers

    def show(self, frame: Frame) -> None:
        """Put a frame into the picture."""
        raise NotImplementedError

    def pixels(self, frame: Frame) -> Pixels:
        """The present picture, shape (height, width, 4); valid until the next call."""
        self.show(frame)
        return self.layers.pixels()

    def place(self, frame: Frame, one: int) -> Array:
        """The position at which a particle is seen (m)."""
        return frame.arrays["position"][one, :2]


class Size(NamedTuple):
    """The size of a picture in pixels."""

    width: int
    height: int
    trim: bool = False
    """whether it may be made smaller along one direction, so that what is shown fills it"""


USUAL = Size(960, 720, trim=True)


class View(NamedTuple):
    """The part of the world that is shown (m): left, right, bottom, top."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def width(self) -> float:
        """The distance from left to right (m)."""
        return self.right - self.left

    @property
    def height(self) -> float:
        """The distance from bottom to top (m)."""
        return self.top - self.bottom


def view_around(x: float, y: float, width: float, height: float) -> View:
    """The view around a point."""
    return View(x - width / 2, x + width / 2, y - height / 2, y + height / 2)


class Species(NamedTuple):
    """The name and the color of a species."""

    name: str
    color: str


def species(scene: Scene) -> list[Species]:
    """The species of a scene, in the order of their numbers; those without a color take the palette's next."""
    return [Species(kind.name, color) for kind, color in zip(scene.kinds, colors_of(scene.kinds), strict=True)]


class Layers:
    """A figure of which most never changes: that is drawn once, and then only what moves, from the lowest up."""

    def __init__(self, figure: Figure, moving: Sequence[Artist]) -> None:
        self._figure, self._moving = figure, moving
        self._canvas: Any = FigureCanvasAgg(figure)  # Matplotlib leaves its canvases without types
        self._still: Any = None

    def forget(self) -> None:
        """Draw the unchanging layer again, as when the view has changed."""
        self._still = None

    def pixels(self) -> Pixels:
        """The present picture, shape (height, width, 4); valid until the next call."""
        if self._still is None:
            self._still = self._unmoving()
        self._canvas.restore_region(self._still)
        for artist in self._moving:
            self._figure.draw_artist(artist)
        return np.asarray(self._canvas.buffer_rgba())

    def _unmoving(self) -> Any:
        for artist in self._moving:
            artist.set_animated(True)
        self._canvas.draw()
        return self._canvas.copy_from_bbox(self._figure.bbox)


HEADER, SIDE, BORDER = 46.0, 150.0, 22.0
"""Room above what is shown, right of it and around all, in pixels of a picture of the usual size."""
NARROWEST, LOWEST = 380.0, 250.0
"""The least width and height of a picture of the usual size that is trimmed, in pixels."""


def blank(size: Size, view: View, side: float = SIDE) -> Figure:
    """An empty figure of that size. All grows with it, so that a large movie is a small one with more pixels."""
    part = min(size.width / USUAL.width, size.height / USUAL.height)
    width, height = size.width / part, size.height / part
    if size.trim:
        per_meter = _per_meter(width, height, view, side)
        width = min(width, max(view.width * per_meter + side + 2 * BORDER, NARROWEST))
        height = min(height, max(view.height * per_meter + HEADER + 2 * BORDER, LOWEST))
    # Video formats need even numbers of pixels.
    pixels = [2 * math.ceil(0.5 * part * length - 1e-9) for length in (width, height)] if size.trim else size[:2]
    dpi = DPI * part
    return Figure(figsize=(pixels[0] / dpi, pixels[1] / dpi), dpi=dpi, facecolor="white")


def _per_meter(width: float, height: float, view: View, side: float) -> float:
    """Pixels per meter with which the view fits into a picture."""
    return min((width - side - 2 * BORDER) / view.width, (height - HEADER - 2 * BORDER) / view.height)


def axes_for(figure: Figure, view: View, side: float = SIDE) -> Axes:
    """Axes that show the view, both directions to one scale, without ticks: a scale bar says the lengths."""
    width, height = DPI * figure.get_size_inches()
    per_meter = _per_meter(width, height, view, side)
    across, along = view.width * per_meter, view.height * per_meter
    left, bottom = (width - across - side) / 2, (height - HEADER - along) / 2
    axes = figure.add_axes((left / width, bottom / height, across / width, along / height))
    axes.set(xlim=(view.left, view.right), ylim=(view.bottom, view.top))
    axes.set_axis_off()
    return axes


def discs(axes: Axes, frame: Frame, kinds: Sequence[Species]) -> EllipseCollection | Splat:
    """The particles of a frame, to scale whatever the picture's size."""
    diameter, place = 2 * frame.arrays["radius"], frame.arrays["position"][:, :2]
    colors = [kinds[kind].color for kind in frame.arrays["species"]]
    if len(diameter) >= MANY:
        painted = splat_in(axes, Splat(diameter / 2, rim=0.6), 2)
        painted.put(place, None, to_rgba_array(colors))
        return painted
    look: dict[str, Any] = {"facecolors": colors, "edgecolors": INK, "linewidths": 0.6, "zorder": 2}
    circles = EllipseCollection(
        diameter, diameter, np.zeros_like(diameter), units="xy", offsets=place, offset_transform=axes.transData, **look
    )
    axes.add_collection(circles, autolim=False)
    return circles


def clock(axes: Axes) -> Any:
    """The text that shows the time, above the left corner."""
    return axes.text(0.0, 1.015, "", transform=axes.transAxes, fontsize=14, va="bottom", color=INK)


BAR = (6.0, 11.0)
"""How far the scale bar and its text are above the lower end of the axes, in points."""


def scale_bar(axes: Axes, view: View) -> list[Artist]:
    """A bar of a round length in the lower left corner, on a pale ground, for axes that show as much as the view."""
    length = _round_length(view.width / 5)
    part, scale = length / view.width, scale_for(length, "m")
    figure: Any = axes.figure
    above = [axes.transAxes + ScaledTranslation(0.0, points / 72.0, figure.dpi_scale_trans) for points in BAR]
    (bar,) = axes.plot(
        [0.015, 0.015 + part], [0.0] * 2, color=INK, linewidth=2.5, solid_capstyle="butt", transform=above[0]
    )
    text = axes.text(
        0.015 + part / 2, 0.0, f"{length * scale.factor:g} {scale.unit}", ha="center", va="bottom", fontsize=10,
        transform=above[1], bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 1.5},
    )  # fmt: skip
    for artist in (bar, text):
        artist.set_zorder(9)
    return [bar, text]


def _round_length(most: float) -> float:
    """The largest of 1, 2, 5, 10 ... below `most`."""
    power = 10.0 ** np.floor(np.log10(most))
    return float(max(step * power for step in (1, 2, 5) if step * power <= most * (1 + 1e-12)))


def labels(axes: Axes, title: str, kinds: Sequence[Species]) -> None:
    """The title, and the species where there are several."""
    figure: Any = axes.figure
    room = axes.get_position().width * DPI * float(figure.get_size_inches()[0]) - CLOCK
    short = (
        plain(textwrap.shorten(title, min(LONGEST_TITLE, int(room / LETTER)), placeholder=" …"))
        if room > LETTER * 6
        else ""
    )
    axes.text(1.0, 1.015, short, transform=axes.transAxes, ha="right", va="bottom", fontsize=11, color=MUTED)
    if len(kinds) > 1:
        place: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.03, 1.0), "borderaxespad": 0.0}
        axes.legend(handles=species_dots(kinds), fontsize=10.5, **place)


def species_dots(kinds: Sequence[Species]) -> list[Line2D]:
    """The markers of the species in a legend."""
    look: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 8, "markeredgecolor": INK}
    return [Line2D([], [], color=kind.color, label=plain(kind.name), **look) for kind in kinds]
