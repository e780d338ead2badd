"""Parts of pictures that all models have in common: camera, size, view, scale bar, legend, fast drawing.

Very many particles are painted as discs into pixels, since collections of Matplotlib patches are too slow. In 3D they
are balls, lit from the side of the viewer; nearer ones hide farther ones.

Static parts are drawn once; a movie then draws only the moving parts of each frame.
"""

from __future__ import annotations

import itertools
import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import EllipseCollection
from matplotlib.colors import to_rgb, to_rgba_array
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import Affine2DBase, ScaledTranslation
from numpy.typing import NDArray

from ecume.errors import BadInput
from ecume.scenes.common import colors_of
from ecume.show.style import INK, MUTED, plain, scale_for
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene


FARTHEST = 0.45
"""The brightness of the farthest ball over that of the nearest."""
MANY = 1500
"""The number of circles above which painting pixels is faster than Matplotlib."""
POINT = 1.0 / 72.0
"""The length of a point in inches."""


class Splat(Artist):
    """Particles in axes, painted in the resolution of the figure. `radius` is (N,) or one for all (m); `rim` is the
    width of the line around each particle (points). `room` contains the corners of the painted region (m), infinite
    where there is no wall.
    """

    def __init__(
        self, radius: Array | float, *, balls: bool = False, rim: float = 0.0, room: tuple[Array, Array] | None = None
    ) -> None:
        super().__init__()
        self.radius, self.balls, self.rim, self.room = radius, balls, rim, room
        self.places, self.shades = np.zeros((0, 2)), np.zeros((0, 3))
        self.order: Any = slice(None)

    def put(self, places: Array, depth: Array | None, colors: Array) -> None:
        """Set the discs: positions (N, 2) in m, their depth toward the viewer, and colors (N, 3 or 4) from 0 to 1."""
        self.places, self.shades, self.order = places, 255.0 * colors[:, :3], slice(None)
        if depth is not None and len(depth):
            self.order = np.argsort(depth, kind="stable")
            near = (depth - depth.min()) / max(float(np.ptp(depth)), 1e-300)
            self.shades = self.shades * (FARTHEST + (1.0 - FARTHEST) * near)[:, None]

    def set_offsets(self, places: Array) -> None:
        """Set the positions."""
        self.places = places

    def resize(self, radius: Array) -> None:
        """Set the radii (m)."""
        self.radius = radius

    def _pixel(self, corner: Array) -> Array:
        """The pixel coordinates of a corner in the figure; infinite if the corner is."""
        axes: Any = self.axes
        shown: Array = axes.transData.transform(np.where(np.isfinite(corner), corner, 0.0))
        return np.where(np.isfinite(corner), shown, corner)

    def draw(self, renderer: Any) -> None:
        """Paint the discs over the existing picture."""
        from ecume.engine.rendering import Dots, Look, splat

        axes: Any = self.axes
        if not self.get_visible() or not len(self.places):
            return
        box, per_meter = axes.bbox, axes.transData.transform
        left, bottom = round(box.x0), round(box.y0)
        pixels = np.zeros((max(1, round(box.y1) - bottom), max(1, round(box.x1) - left), 4), np.uint8)
        across, up = per_meter(self.places).T
        zoom = float(np.ptp(per_meter([(0.0, 0.0), (1.0, 0.0)])[:, 0]))
        radius = np.broadcast_to(zoom * np.asarray(self.radius, dtype=np.float64), len(across))
        columns = (across - left, len(pixels) - (up - bottom), radius)
        dots = Dots(*(np.ascontiguousarray(column[self.order]) for column in (*columns, self.shades)))
        rim = self.rim * POINT * axes.figure.dpi
        splat(pixels, dots, Look(self.balls, rim, 255.0 * np.array(to_rgb(INK))))
        if self.room is not None:
            cut(pixels, [self._pixel(corner) - (left, bottom) for corner in self.room])
        context = renderer.new_gc()
        renderer.draw_image(context, left, bottom, pixels[::-1])
        context.restore()


def cut(pixels: NDArray[np.uint8], corners: Sequence[Array]) -> None:
    """Clear the pixels to the left of or below the first corner, and to the right of or above the second one. Rows of
    `pixels` start at the top; corners are counted in pixels from the lower left.
    """
    rows, columns = pixels.shape[:2]
    (left, bottom), (right, top) = corners
    across, up = np.arange(columns) + 0.5, rows - np.arange(rows) - 0.5
    pixels[:, (across < left) | (across > right)] = 0
    pixels[(up < bottom) | (up > top)] = 0


def splat_in(axes: Axes, splat: Splat, zorder: float) -> Splat:
    """Add the discs to axes."""
    splat.set_zorder(zorder)
    axes.add_artist(splat)
    return splat


DPI = 100
LONGEST_TITLE = 50
"""The largest number of characters of a title."""
LETTER, CLOCK = 9.0, 90.0
"""The widths in pixels of a letter of the title and of the time, in a picture of the default size."""

Pixels = NDArray[np.uint8]


class Picture:
    """An open picture of a model's frames, made by a row of `FILMS` from (scene, sample, size).

    `sample` are frames of the run, which determine the extent of the picture and the range of its colors.
    """

    figure: Figure
    view: View
    bars: list[Artist]
    layers: Layers
    pace: str = ""
    """text after the time: the speed of a movie over real time"""

    def show(self, frame: Frame) -> None:
        """Draw a frame."""
        raise NotImplementedError

    def pixels(self, frame: Frame) -> Pixels:
        """The present picture, shape (height, width, 4); valid until the next call."""
        self.show(frame)
        return self.layers.pixels()

    def place(self, frame: Frame, one: int) -> Array:
        """The position of a particle in the picture (m)."""
        return frame.arrays["position"][one, :2]


class Size(NamedTuple):
    """The size of a picture in pixels."""

    width: int
    height: int
    trim: bool = False
    """whether it may be made smaller along one direction, so that what is shown fills it"""


USUAL = Size(960, 720, trim=True)


class View(NamedTuple):
    """The shown region (m): left, right, bottom, top."""

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
    """The species of a scene, in the order of their numbers; species without a color have the next one of the
    palette.
    """
    return [Species(kind.name, color) for kind, color in zip(scene.kinds, colors_of(scene.kinds), strict=True)]


class Layers:
    """A figure whose static part is drawn once, and whose moving parts are drawn for each frame, from the lowest up."""

    def __init__(self, figure: Figure, moving: Sequence[Artist]) -> None:
        self._figure, self._moving = figure, moving
        self._canvas: Any = FigureCanvasAgg(figure)  # Matplotlib's canvases have no type annotations
        self._still: Any = None

    def forget(self) -> None:
        """Draw the static part again, as after a change of the view."""
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
"""The space above, right of and around the contents, in pixels of a picture of the default size."""
NARROWEST, LOWEST = 380.0, 250.0
"""The least width and height of a picture of the usual size that is trimmed, in pixels."""


def blank(size: Size, view: View, side: float = SIDE) -> Figure:
    """An empty figure of this size. All elements scale with the size, so that a large movie is a small one with more
    pixels.
    """
    part = min(size.width / USUAL.width, size.height / USUAL.height)
    width, height = size.width / part, size.height / part
    if size.trim:
        per_meter = _per_meter(width, height, view, side)
        width = min(width, max(view.width * per_meter + side + 2 * BORDER, NARROWEST))
        height = min(height, max(view.height * per_meter + HEADER + 2 * BORDER, LOWEST))
    # Video formats require even numbers of pixels.
    pixels = [2 * math.ceil(0.5 * part * length - 1e-9) for length in (width, height)] if size.trim else size[:2]
    dpi = DPI * part
    return Figure(figsize=(pixels[0] / dpi, pixels[1] / dpi), dpi=dpi, facecolor="white")


def _per_meter(width: float, height: float, view: View, side: float) -> float:
    """Pixels per meter with which the view fits into a picture."""
    return min((width - side - 2 * BORDER) / view.width, (height - HEADER - 2 * BORDER) / view.height)


def axes_for(figure: Figure, view: View, side: float = SIDE) -> Axes:
    """Axes for a view, with equal scales and without ticks, since a scale bar shows lengths."""
    width, height = DPI * figure.get_size_inches()
    per_meter = _per_meter(width, height, view, side)
    across, along = view.width * per_meter, view.height * per_meter
    left, bottom = (width - across - side) / 2, (height - HEADER - along) / 2
    axes = figure.add_axes((left / width, bottom / height, across / width, along / height))
    axes.set(xlim=(view.left, view.right), ylim=(view.bottom, view.top))
    axes.set_axis_off()
    return axes


def discs(axes: Axes, frame: Frame, kinds: Sequence[Species]) -> EllipseCollection | Splat:
    """The particles of a frame, drawn to scale for any size of the picture."""
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
"""The heights of the scale bar and its text above the lower end of the axes, in points."""


def scale_bar(axes: Axes, view: View) -> list[Artist]:
    """A bar of a round length in the lower left corner, on a pale background, for axes that show the whole view."""
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
    """Draw the title, and the legend of species if there are several."""
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


UPRIGHT = np.eye(3)
"""The directions right, up and towards the observer for a horizontal view with y up."""
STANDING = np.array([(1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)])
"""The same directions with z up."""


class Eye(NamedTuple):
    """The viewpoint of a picture in 3D."""

    azimuth: float = 28.0
    """degrees of its rotation about the vertical, to the right"""
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


LEG = 26.0
"""The length of the arrows that show the axes, in points."""


def axis_arrows(axes: Axes, camera: Array) -> list[Artist]:
    """Arrows along x, y and z in the projection of a camera, in the lower right corner."""
    figure: Any = axes.figure
    leg, inches, corner = LEG / 72.0, figure.dpi_scale_trans, cast(Affine2DBase, axes.transAxes)
    place = inches + ScaledTranslation(-1.6 * leg, 0.9 * leg, inches) + ScaledTranslation(1.0, 0.0, corner)
    found: list[Artist] = []
    for name, (across, above) in zip("xyz", (leg * camera[:2]).T, strict=True):
        look: dict[str, Any] = {"arrowstyle": "-|>", "color": INK, "shrinkA": 0.0, "shrinkB": 0.0, "linewidth": 1.2}
        found.append(axes.annotate("", (across, above), (0.0, 0.0), place, place, look, annotation_clip=False))
        far = 1.35 if math.hypot(across, above) > 0.3 * leg else 2.2
        at: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 9, "color": INK, "transform": place}
        found.append(axes.text(far * across, far * above, name, **at))
    for artist in found:
        artist.set_zorder(9)
    return found


class Wires(NamedTuple):
    """The edges of a box in projection: (2, 2) m each."""

    front: list[Array]
    behind: list[Array]


def edges_of(low: Array, high: Array) -> list[Array]:
    """The twelve edges of a box, (2, 3) each."""
    corners = [np.where(choice, high, low) for choice in itertools.product((False, True), repeat=3)]
    pairs = itertools.combinations(corners, 2)
    return [np.array(pair) for pair in pairs if np.count_nonzero(pair[0] != pair[1]) == 1]


def wires_of(low: Any, high: Any, camera: Array) -> Wires:
    """The edges of a box behind its contents, and those in front."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    farthest, found = np.where(camera[2] > 0.0, low, high), Wires([], [])
    for edge in edges_of(low, high):
        hidden = (edge == farthest).all(axis=1).any()
        (found.behind if hidden else found.front).append(edge @ camera[:2].T)
    return found


class Aim(NamedTuple):
    """The shown part of a picture."""

    zoom: float = 1.0
    """The magnification."""
    follow: int | None = None
    """The particle at the center; default: the center of the scene."""


WIDE = Aim()
"""The view of everything."""


class Aimed(Picture):
    """An open picture that shows a part of the region of another one."""

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
        """Draw a frame."""
        if self.aim.follow is not None:
            x, y = self.place(frame, self.aim.follow)
            self._look(view_around(float(x), float(y), self.view.width, self.view.height))
        self.picture.show(frame)

    def place(self, frame: Frame, one: int) -> Any:
        """The position in the picture of a particle (m)."""
        count = len(frame.arrays["position"])
        if not 0 <= one < count:
            raise BadInput(f"no particle {one} at {frame.time:g} s; expected 0 to {count - 1}")
        return self.picture.place(frame, one)

    def _look(self, view: View) -> None:
        self.figure.axes[0].set(xlim=(view.left, view.right), ylim=(view.bottom, view.top))
        self.layers.forget()


def aimed(picture: Picture, aim: Aim) -> Picture:
    """The picture with this aim; the unchanged picture without one."""
    return picture if aim == WIDE else Aimed(picture, aim)


def _measure(bars: list[Any], right: list[Any]) -> None:
    """Replace a scale bar by another one with the right length."""
    (bar, text), (new_bar, new_text) = bars, right
    bar.set_xdata(new_bar.get_xdata())
    text.set_text(new_text.get_text())
    text.set_position(new_text.get_position())
    for artist in right:
        artist.remove()
