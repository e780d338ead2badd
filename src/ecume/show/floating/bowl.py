"""A frame seen from above: floats to scale, the height of the liquid, the dish, time and scale bar."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import AsinhNorm, to_rgba
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Patch, Polygon

from ecume.analysis.boxes import box_of, copies
from ecume.analysis.series import Flags
from ecume.engine.walls import rings
from ecume.models.floating.dishes import behind_barrier, outline_of, walls_of
from ecume.show.floating.surface import (
    Heights,
    outlines_in,
    polygons,
    shapes_of,
    sheet,
    surface,
    turned,
    typical_meniscus,
)
from ecume.show.picture import (
    DPI,
    USUAL,
    Layers,
    Picture,
    Pixels,
    Size,
    View,
    axes_for,
    blank,
    clock,
    discs,
    labels,
    scale_bar,
    species,
    view_around,
)
from ecume.show.style import INK, RIM, Scale, height_colormap, liquid_color, scale_for, style
from ecume.trajectories.frame import Frame
from ecume.units import Array

LINE = 0.8
"""The length of the line that shows the angle of a float, over its diameter."""
BARB = 0.22
"""The length and half width of an arrowhead, over the length of the arrow."""
MARGIN = 1.04
"""The shown part of the surface, in dish diameters."""
BESIDE = 0.03
"""The width of the shown region around a periodic cell, over its longer side."""
PALE = 0.4
"""The opacity of images."""
CIRCLE = np.stack([wave(np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)) for wave in (np.cos, np.sin)], axis=1)
"""A disc as a polygon."""
BEHIND = "#d9d9d9"
"""The color of the part of a dish behind a barrier."""
BELOW = 0.07
"""Room for the scale bar below a dish that is not round, in parts of its width."""


def view_of(scene: Any, frames: Sequence[Frame]) -> View:
    """The shown region: the whole dish; the cell and some of its images; or without both the region that the floats of
    these frames reach.
    """
    if scene.cell is not None:
        width, height = scene.sides
        margin = 2.0 * BESIDE * max(width, height)
        return view_around(0.5 * width, 0.5 * height, width + margin, height + margin)
    if scene.dish is not None:
        (left, bottom), (right, top) = rings.bounds(walls_of(scene.dish))
        middle = 0.5 * (left + right), 0.5 * (bottom + top)
        whole = view_around(*middle, MARGIN * (right - left), MARGIN * (top - bottom))
        # Below a wall without round corners there is no space for the scale bar.
        return whole if scene.dish.radius is not None else whole._replace(bottom=whole.bottom - BELOW * whole.width)
    low = np.min([(f.arrays["position"] - f.arrays["radius"][:, None]).min(axis=0) for f in frames], axis=0)
    high = np.max([(f.arrays["position"] + f.arrays["radius"][:, None]).max(axis=0) for f in frames], axis=0)
    radius = max(float(f.arrays["radius"].max()) for f in frames)
    side = float((high - low).max()) + 4 * radius
    x, y = (low + high) / 2
    return view_around(float(x), float(y), side, side)


class Bowl(Picture):
    """An open picture: `show` draws a frame, and `pixels` returns the picture.

    `sample` are frames of the run, which determine the extent of the picture, the range of its colors and the sizes of
    floats.
    """

    def __init__(self, scene: Any, sample: Sequence[Frame], size: Size = USUAL, *, cells: int = 200) -> None:
        self.view = view_of(scene, sample)
        self.figure = blank(size, self.view)
        self.shapes, self.dish = shapes_of(scene), scene.dish
        closest = min(float(frame.arrays["radius"].min()) for frame in sample)
        self.sheet = sheet(scene, self.view, cells=cells, closest=closest)
        heights = [surface(frame, self.sheet) for frame in sample]
        self.scale = scale_for(float(np.abs(heights).max()), "m")
        kinds = species(scene)
        with style():
            axes = axes_for(self.figure, self.view)
            largest, typical = float(np.abs(heights).max()), typical_meniscus(sample[0], self.sheet)
            self.colors = height_colors(
                largest * self.scale.factor, typical * self.scale.factor, liquid_color(scene.liquid)
            )
            self.height = _height_image(axes, self.view, self._painted(heights[0]))
            self.floats: Any = (
                discs(axes, sample[0], kinds) if self.shapes is None else polygons(axes, sample[0], self.shapes, kinds)
            )
            self.images = PolyCollection([], edgecolors=to_rgba(INK, PALE), linewidths=0.6, zorder=2)
            self.pale = [to_rgba(kind.color, PALE) for kind in kinds]
            axes.add_collection(self.images, autolim=False)
            self.headed, self.turns = _headed(scene, sample[0]), scene.activity is None
            self.rises = LineCollection([], colors=INK, linewidths=1.2, zorder=3)
            axes.add_collection(self.rises, autolim=False)
            self.time = clock(axes)
            # Floats are drawn above the rim, half of whose line would otherwise hide their contacts with it.
            border = [*_dish(axes, scene.dish, self.height), *_cell(axes, scene)]
            # The liquid behind a barrier; the edge drawn last is the barrier.
            self.behind = PolyCollection([], facecolors=BEHIND, edgecolors=RIM, linewidths=1.2, zorder=1.5)
            axes.add_collection(self.behind, autolim=False)
            moving: list[Artist] = [self.height, *border, self.behind, self.images, self.floats, self.rises]
            self.bars = scale_bar(axes, self.view)
            moving += [*self.bars, self.time]
            lowest, highest = float(np.min(heights)), float(np.max(heights))
            shown = min(lowest, 0.0) * self.scale.factor, max(highest, 0.0) * self.scale.factor
            if shown[0] < shown[1]:  # a surface without menisci has one color
                _height_bar(axes, self.colors, shown, self.scale, tall=0.92 if len(kinds) < 2 else 0.6)
            labels(axes, scene.title, kinds)
        self.layers = Layers(self.figure, moving)
        self.show(sample[0])

    def show(self, frame: Frame) -> None:
        """Draw a frame."""
        self.height.set_data(self._painted(surface(frame, self.sheet)))
        if self.shapes is None:
            self.floats.set_offsets(frame.arrays["position"])
            self.rises.set_segments(self._marks(frame))
        else:
            self.floats.set_verts(outlines_in(frame, self.shapes))
        self._show_images(frame)
        self.behind.set_verts(behind_barrier(self.dish, frame.numbers.get("barrier_position", 0.0)))
        self.time.set_text(f"{frame.time:.2f} s{self.pace}")

    def _marks(self, frame: Frame) -> list[Any]:
        """The arrows of floats with a heading, and the lines of other floats that rotate; empty if no float has an
        angle.
        """
        if "angle" not in frame.arrays:
            return []
        turned = self.turns or "spin" in frame.arrays
        return [*arrows(frame)[self.headed], *(rises(frame)[~self.headed] if turned else ())]

    def _show_images(self, frame: Frame) -> None:
        """Draw the images of floats around a periodic cell in paler colors."""
        arrays, count, shapes = frame.arrays, len(frame.arrays["position"]), self.shapes
        around = copies(arrays["position"], box_of(frame), BESIDE * self.view.width + float(arrays["radius"].max()))
        place, owner = around.position[count:], around.owner[count:]
        if shapes is None:
            found = list(place[:, None] + arrays["radius"][owner, None, None] * CIRCLE)
        else:
            bodies = zip(owner, arrays["angle"][owner], place, strict=True)
            found = [turned(shapes.outlines[i], angle) + at for i, angle, at in bodies]
        self.images.set_verts(found)
        self.images.set_facecolor([self.pale[kind] for kind in arrays["species"][owner]])

    def _painted(self, height: Heights) -> Pixels:
        """The colors of heights, before interpolation to the more numerous pixels of the picture."""
        return self.colors.to_rgba(height * np.float32(self.scale.factor), bytes=True)


def rises(frame: Frame) -> Array:
    """A line across each float that rotates, (N, 2, 2), to the highest point of its rim; empty if no rim is
    undulated.
    """
    arrays = frame.arrays
    if "angle" not in arrays:
        return np.zeros((0, 2, 2))
    along = np.stack([np.cos(arrays["angle"]), np.sin(arrays["angle"])], axis=1) * arrays["radius"][:, None]
    lines: Array = arrays["position"][:, None] + np.array([-LINE, LINE])[None, :, None] * along[:, None]
    return lines


def _headed(scene: Any, frame: Frame) -> Flags:
    """Flags of the floats that have a heading: floats with propulsion, and floats with sources of waves."""
    names = np.array([kind.name for kind in scene.kinds])
    of_kind = np.zeros(len(names), bool)
    if scene.activity is not None and scene.activity.propulsion > 0.0:
        of_kind |= np.isin(names, scene.activity.species or names)
    for source in scene.waves.sources if scene.waves is not None else ():
        of_kind |= np.isin(names, source.species or names)
    return np.asarray(of_kind[frame.arrays["species"]])


def arrows(frame: Frame) -> Array:
    """An arrow on each float along its heading, (N, 5, 2): the shaft, then both barbs; none without headings."""
    tip = rises(frame)
    if not len(tip):
        return np.zeros((0, 5, 2))
    shaft = tip[:, 1] - tip[:, 0]
    across = np.stack([-shaft[:, 1], shaft[:, 0]], axis=1)
    barbs = [tip[:, 1] - BARB * shaft + side * BARB * across for side in (1.0, -1.0)]
    return np.stack([tip[:, 0], tip[:, 1], barbs[0], tip[:, 1], barbs[1]], axis=1)


def _height_image(axes: Axes, view: View, painted: Pixels) -> AxesImage:
    return axes.imshow(painted, extent=view, origin="lower", interpolation="bilinear", aspect="auto")


def height_colors(largest: float, typical: float, liquid: str | None = None) -> ScalarMappable:
    """Colors that are linear in the height of menisci around floats, and logarithmic in that of the steep rim; `liquid`
    is the color of the undisturbed surface.
    """
    largest = max(largest, 1e-12)
    linear = min(max(typical, largest / 300), largest)
    return ScalarMappable(AsinhNorm(linear_width=linear, vmin=-largest, vmax=largest), height_colormap(liquid))


def _dish(axes: Axes, dish: Any, height: AxesImage) -> list[Artist]:
    """Draw the rim of the dish, and hide the liquid outside it."""
    if dish is None:
        return []
    rim = axes.add_patch(dish_outline(dish))
    height.set_clip_path(rim)
    return [rim, *(axes.add_patch(patch) for patch in inner_walls(dish))]


def _cell(axes: Axes, scene: Any) -> list[Artist]:
    """The outline of a periodic cell."""
    if scene.cell is None:
        return []
    corners = np.array(scene.sides) * [(0, 0), (1, 0), (1, 1), (0, 1)]
    look: dict[str, Any] = {"facecolor": "none", "edgecolor": INK, "linewidth": 1.2, "linestyle": "--"}
    return [axes.add_patch(Polygon(corners, closed=True, **look))]


def dish_outline(dish: Any, scale: float = 1.0) -> Patch:
    """The rim of a dish, in meters or in multiples of `scale` meters."""
    look: dict[str, Any] = {"facecolor": "none", "edgecolor": RIM, "linewidth": 1.8}
    return Polygon(scale * outline_of(dish), closed=True, **look)


def inner_walls(dish: Any, scale: float = 1.0) -> list[Patch]:
    """What is inside the inner wall of a ring, in meters or in multiples of `scale` meters; none in other dishes."""
    look: dict[str, Any] = {"facecolor": BEHIND, "edgecolor": RIM, "linewidth": 1.8}
    return [Polygon(scale * points, closed=True, **look) for points in rings.inner_outline(walls_of(dish))]


def _height_bar(axes: Axes, colors: ScalarMappable, shown: tuple[float, float], scale: Scale, tall: float) -> None:
    """Draw the color bar of heights for the range that occurs; `tall` is its height over that of the picture."""
    box, figure = axes.get_position(), cast(Figure, axes.get_figure(root=True))
    width = DPI * figure.get_size_inches()[0]
    place = figure.add_axes((box.x1 + 40 / width, box.y0 + 0.04 * box.height, 18 / width, tall * box.height))
    bar = figure.colorbar(colors, cax=place)
    place.set_ylim(*shown)
    bar.set_ticks(height_ticks(colors.norm, shown))
    place.yaxis.set_major_formatter("{x:g}")
    place.minorticks_off()
    place.grid(visible=False)
    place.tick_params(labelsize=10)
    bar.set_label(f"height of the liquid ({scale.unit})", fontsize=10.5, labelpad=6)


def height_ticks(norm: Any, shown: tuple[float, float], apart: float = 0.08) -> list[float]:
    """Round heights whose positions on the color bar are not too close: first 0 and powers of ten, then halves of
    these.
    """
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
