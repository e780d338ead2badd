"""A picture of one instant as seen from above: floats to scale, the height of the liquid, the dish, time and scale bar.

The parts that never change are drawn once; a movie then draws only the rest of each frame.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any, NamedTuple, cast

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import AsinhNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Rectangle
from numpy.typing import NDArray

from ecume.show.style import HEIGHT_COLORS, INK, MUTED, PALETTE, RIM, Scale, plain, scale_for, style
from ecume.show.surface import Heights, Sheet, View, sheet, surface, unit_meniscus
from ecume.trajectories.frame import Frame

DPI = 100
MARGIN = 1.04
"""The shown part of the surface, in dish diameters."""
HEADER, SIDE, BORDER = 46.0, 150.0, 22.0
"""Room above the surface, right of it and around all, in pixels of a picture of the usual size."""

LONGEST_TITLE = 50
"""In characters; more would run into the time."""

Pixels = NDArray[np.uint8]


class Species(NamedTuple):
    """What a species is called and which color it has."""

    name: str
    color: str


class Size(NamedTuple):
    """Of a picture, in pixels."""

    width: int
    height: int


USUAL = Size(960, 720)


def species(scene: Any) -> list[Species]:
    """The species of a scene, in the order of their numbers; those without a color take the palette's next."""
    from ecume.scenes.floating import species_of

    palette = iter(PALETTE * (1 + len(species_of(scene)) // len(PALETTE)))
    return [Species(name, color or next(palette)) for name, color in species_of(scene)]


def view_of(scene: Any, frames: Sequence[Frame]) -> View:
    """The whole dish, or on an endless surface all that the floats of these frames ever reach."""
    if scene.dish is not None:
        width, height = _extent(scene.dish)
        return _around(0.0, 0.0, MARGIN * width, MARGIN * height)
    low = np.min([(f.arrays["position"] - f.arrays["radius"][:, None]).min(axis=0) for f in frames], axis=0)
    high = np.max([(f.arrays["position"] + f.arrays["radius"][:, None]).max(axis=0) for f in frames], axis=0)
    radius = max(float(f.arrays["radius"].max()) for f in frames)
    side = float((high - low).max()) + 4 * radius
    x, y = (low + high) / 2
    return _around(float(x), float(y), side, side)


def _extent(dish: Any) -> tuple[float, float]:
    if dish.radius is not None:
        return 2 * dish.radius, 2 * dish.radius
    width, height = dish.size
    return width, height


def _around(x: float, y: float, width: float, height: float) -> View:
    return View(x - width / 2, x + width / 2, y - height / 2, y + height / 2)


class Bowl:
    """An open picture: `show` puts a frame into it, `pixels` gives what is then seen.

    `sample` are frames of the run: from them the picture takes its extent, its colors' range and the floats' sizes.
    """

    def __init__(self, scene: Any, sample: Sequence[Frame], size: Size = USUAL, *, cells: int = 200) -> None:
        self.view = view_of(scene, sample)
        # All but the surface grows with the picture, so that a large movie is a small one with more pixels.
        dpi = DPI * min(size.width / USUAL.width, size.height / USUAL.height)
        self.figure = Figure(figsize=(size.width / dpi, size.height / dpi), dpi=dpi, facecolor="white")
        self.canvas: Any = FigureCanvasAgg(self.figure)  # Matplotlib leaves its canvases without types
        closest = min(float(frame.arrays["radius"].min()) for frame in sample)
        self.sheet = sheet(scene, self.view, cells=cells, closest=closest)
        heights = [surface(frame, self.sheet) for frame in sample]
        self.scale = scale_for(float(np.abs(heights).max()), "m")
        kinds = species(scene)
        with style():
            axes = _surface_axes(self.figure, self.view)
            largest, typical = float(np.abs(heights).max()), _typical_meniscus(sample[0], self.sheet)
            self.colors = _height_colors(largest * self.scale.factor, typical * self.scale.factor)
            self.height = _height_image(axes, self.view, self._painted(heights[0]))
            self.floats = _circles(axes, sample[0], kinds)
            self.time = axes.text(0.0, 1.015, "", transform=axes.transAxes, fontsize=14, va="bottom", color=INK)
            # The floats stand above the rim: half of its line would hide where they touch it.
            self._moving: list[Artist] = [self.height, *_dish(axes, scene.dish, self.height), self.floats]
            self._moving += [*_scale_bar(axes, self.view), self.time]
            lowest, highest = float(np.min(heights)), float(np.max(heights))
            shown = min(lowest, 0.0) * self.scale.factor, max(highest, 0.0) * self.scale.factor
            _height_bar(axes, self.colors, shown, self.scale)
            _labels(axes, scene.title, kinds)
        self._still: Any = None
        self.show(sample[0])

    def show(self, frame: Frame) -> None:
        """Put a frame into the picture."""
        self.height.set_data(self._painted(surface(frame, self.sheet)))
        self.floats.set_offsets(frame.arrays["position"])
        self.time.set_text(f"{frame.time:.2f} s")

    def _painted(self, height: Heights) -> Pixels:
        """Heights as colors, before they are spread over the picture's many more pixels."""
        return self.colors.to_rgba(height * np.float32(self.scale.factor), bytes=True)

    def pixels(self, frame: Frame) -> Pixels:
        """The picture of a frame, shape (height, width, 4); good until the next one is asked for."""
        self.show(frame)
        if self._still is None:
            self._still = self._unmoving()
        self.canvas.restore_region(self._still)
        for artist in self._moving:
            self.figure.draw_artist(artist)
        return np.asarray(self.canvas.buffer_rgba())

    def _unmoving(self) -> Any:
        """Draw once what never changes, and keep it."""
        for artist in self._moving:
            artist.set_animated(True)
        self.canvas.draw()
        return self.canvas.copy_from_bbox(self.figure.bbox)


def _surface_axes(figure: Figure, view: View) -> Axes:
    """The axes that show the surface, both directions to one scale, without ticks: a scale bar says the lengths."""
    width, height = DPI * figure.get_size_inches()
    per_meter = min((width - SIDE - 2 * BORDER) / view.width, (height - HEADER - 2 * BORDER) / view.height)
    across, along = view.width * per_meter, view.height * per_meter
    left, bottom = (width - across - SIDE) / 2, (height - HEADER - along) / 2
    axes = figure.add_axes((left / width, bottom / height, across / width, along / height))
    axes.set(xlim=(view.left, view.right), ylim=(view.bottom, view.top))
    axes.set_axis_off()
    return axes


def _height_image(axes: Axes, view: View, painted: Pixels) -> AxesImage:
    return axes.imshow(painted, extent=view, origin="lower", interpolation="bilinear", aspect="auto")


def _height_colors(largest: float, typical: float) -> ScalarMappable:
    """Colors that follow the height for what floats do to the surface, and its logarithm for the steep rim."""
    largest = max(largest, 1e-12)
    linear = min(max(typical, largest / 300), largest)
    return ScalarMappable(AsinhNorm(linear_width=linear, vmin=-largest, vmax=largest), HEIGHT_COLORS)


def _circles(axes: Axes, frame: Frame, kinds: Sequence[Species]) -> EllipseCollection:
    """The floats, to scale whatever the picture's size."""
    diameter = 2 * frame.arrays["radius"]
    circles = EllipseCollection(
        diameter,
        diameter,
        np.zeros_like(diameter),
        units="xy",
        offsets=frame.arrays["position"],
        offset_transform=axes.transData,
        facecolors=[kinds[kind].color for kind in frame.arrays["species"]],
        edgecolors=INK,
        linewidths=0.6,
        zorder=2,
    )
    axes.add_collection(circles, autolim=False)
    return circles


def _dish(axes: Axes, dish: Any, height: AxesImage) -> list[Artist]:
    """The dish's rim; nothing of the liquid is shown outside it."""
    if dish is None:
        return []
    rim = axes.add_patch(dish_outline(dish))
    height.set_clip_path(rim)
    return [rim]


def dish_outline(dish: Any, scale: float = 1.0) -> Patch:
    """A dish's rim, in meters or in `scale` times that."""
    look: dict[str, Any] = {"facecolor": "none", "edgecolor": RIM, "linewidth": 1.8}
    if dish.radius is not None:
        return Circle((0.0, 0.0), scale * dish.radius, **look)
    width, height = (scale * side for side in dish.size)
    return Rectangle((-width / 2, -height / 2), width, height, **look)


def _scale_bar(axes: Axes, view: View) -> list[Artist]:
    """A bar of a round length in the lower left corner."""
    length = _round_length(view.width / 5)
    left, bottom = view.left + 0.01 * view.width, view.bottom + 0.02 * view.height
    (bar,) = axes.plot([left, left + length], [bottom] * 2, color=INK, linewidth=2.5, solid_capstyle="butt")
    scale = scale_for(length, "m")
    label = f"{length * scale.factor:g} {scale.unit}"
    text = axes.text(left + length / 2, bottom + 0.012 * view.height, label, ha="center", va="bottom", fontsize=10)
    return [bar, text]


def _round_length(most: float) -> float:
    """The largest of 1, 2, 5, 10 ... below `most`."""
    power = 10.0 ** np.floor(np.log10(most))
    return float(max(step * power for step in (1, 2, 5) if step * power <= most * (1 + 1e-12)))


def _typical_meniscus(frame: Frame, on: Sheet) -> float:
    """How far a typical float bends the surface at its own edge (m)."""
    return float(np.median(np.abs(frame.arrays["charge"] * unit_meniscus(on, frame.arrays["radius"]))))


def _height_bar(axes: Axes, colors: ScalarMappable, shown: tuple[float, float], scale: Scale) -> None:
    """What the colors mean, as far as they occur."""
    box, figure = axes.get_position(), cast(Figure, axes.get_figure(root=True))
    width = DPI * figure.get_size_inches()[0]
    place = figure.add_axes((box.x1 + 40 / width, box.y0 + 0.04 * box.height, 18 / width, 0.6 * box.height))
    bar = figure.colorbar(colors, cax=place)
    place.set_ylim(*shown)
    bar.set_ticks(_ticks(colors.norm, shown))
    place.yaxis.set_major_formatter("{x:g}")
    place.minorticks_off()
    place.grid(visible=False)
    place.tick_params(labelsize=10)
    bar.set_label(f"height of the liquid ({scale.unit})", fontsize=10.5, labelpad=6)


def _ticks(norm: Any, shown: tuple[float, float], apart: float = 0.08) -> list[float]:
    """Round heights whose places on the color bar are not too close: 0 and powers of ten first, then their halves."""
    low, high = (float(norm(end)) for end in shown)
    chosen: list[float] = []
    for step in (0.0, 1.0, 5.0, 2.0):
        for power in range(3, -5, -1):
            for value in (step * 10.0**power, -step * 10.0**power):
                place = float(norm(value))
                near = any(abs(place - float(norm(other))) < apart * (high - low) for other in chosen)
                if low <= place <= high and shown[0] <= value <= shown[1] and not near:
                    chosen.append(value)
    return sorted(chosen)


def _labels(axes: Axes, title: str, kinds: Sequence[Species]) -> None:
    """The title, and the species where there are several."""
    short = plain(textwrap.shorten(title, LONGEST_TITLE, placeholder=" …"))
    axes.text(1.0, 1.015, short, transform=axes.transAxes, ha="right", va="bottom", fontsize=11, color=MUTED)
    if len(kinds) > 1:
        place: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.03, 1.0), "borderaxespad": 0.0}
        axes.legend(handles=species_dots(kinds), fontsize=10.5, **place)


def species_dots(kinds: Sequence[Species]) -> list[Line2D]:
    """What a legend shows for each species."""
    look: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 8, "markeredgecolor": INK}
    return [Line2D([], [], color=kind.color, label=plain(kind.name), **look) for kind in kinds]
