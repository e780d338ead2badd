"""Tanks seen from the side: walls, obstacles, moving parts, and particles to scale, colored by a quantity.

The pictures are suitable for any model with a tank. In 3D they show the first and the last axis, or the view of the
camera of the setting.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize, to_rgba_array
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, PathPatch, Polygon
from matplotlib.path import Path

from ecume.show.picture import (
    DPI,
    MANY,
    SIDE,
    USUAL,
    Layers,
    Picture,
    Size,
    Species,
    Splat,
    View,
    axes_for,
    axis_arrows,
    blank,
    clock,
    labels,
    scale_bar,
    species,
    splat_in,
)
from ecume.show.style import INK, MUTED, PALETTE, RIM, scale_for, style
from ecume.trajectories.frame import Frame
from ecume.units import Array

LIQUID, BODY = "#eef5fa", "#d8d3c8"


class Round(NamedTuple):
    """A circle (m)."""

    x: float
    y: float
    radius: float


Shape = Array | Round
"""A polygon's corners (K, 2), or a circle, in meters."""


class Setting(NamedTuple):
    """The surroundings of the particles in a picture."""

    title: str
    outline: Shape | None
    """the tank"""
    bodies: Sequence[Shape] = ()
    """obstacles, rigid bodies"""
    gaps: Sequence[Array] = ()
    """openings: (2, 2), both ends of each"""
    kinds: Sequence[Species] = ()
    """for particles colored by species"""
    inside: str = LIQUID
    """the color of the tank's interior"""
    walls: Sequence[Array] | None = None
    """(2, 2), both ends of each, before the particles; by default all of the outline is a wall, behind them"""
    dotted: Sequence[Array] = ()
    """sides through which one side is left and the other entered: (2, 2), both ends of each"""
    wires: Sequence[Array] = ()
    """edges of a tank and of solids in 3D as projected, in front of all particles: (n, 2) points of each"""
    behind: Sequence[Array] = ()
    """those behind all particles"""
    camera: Array | None = None
    """(3, 3) its right, up, and towards it; by default it looks along the second axis"""
    radius: float | None = None
    """of all particles (m), if frames do not contain radii"""
    room: tuple[Array, Array] | None = None
    """corners beyond which no particle is drawn (m): those of walls, infinite elsewhere"""
    apart: int | None = None
    """the species from which on particles keep their own colors when others are colored by a quantity"""
    movers: Callable[[Frame], list[Array]] | None = None
    """outlines of moving solids, (n, 2) each, as many in every frame; in 3D their edges"""
    body_colors: Sequence[str] = ()
    wire_colors: Sequence[str] = ()
    mover_colors: Sequence[str] = ()
    """of each body, edge, mover; by default one for all"""
    before: bool = False
    """whether bodies are drawn before the contents, and not behind them"""


def stand_apart(setting: Setting) -> bool:
    """Whether some species have separate colors."""
    return setting.apart is not None and setting.apart < len(setting.kinds)


def colored(setting: Setting, frame: Frame) -> Frame:
    """The frame without particles that have separate colors."""
    if not stand_apart(setting):
        return frame
    chosen = frame.arrays["species"] < setting.apart
    return frame.with_arrays({name: array[chosen] for name, array in frame.arrays.items()})


def extent(shape: Shape) -> tuple[Array, Array]:
    """The lower and the upper corner of the box around a shape."""
    if isinstance(shape, Round):
        middle = np.array([shape.x, shape.y])
        return middle - shape.radius, middle + shape.radius
    return shape.min(axis=0), shape.max(axis=0)


def draw_setting(axes: Axes, setting: Setting) -> None:
    """Draw the tank with its liquid, the bodies in it, and the openings as gaps in the walls."""
    if setting.outline is not None:
        axes.add_patch(_patch(setting.outline, facecolor=setting.inside, edgecolor="none", zorder=0))
        if setting.walls is None:
            axes.add_patch(_patch(setting.outline, facecolor="none", edgecolor=RIM, linewidth=2.0, zorder=2))
    for ends in setting.behind:
        axes.add_line(Line2D(*ends.T, color=RIM, linewidth=0.9, zorder=2))
    for ends in setting.gaps:
        axes.add_line(Line2D(*ends.T, color="white", linewidth=3.0, solid_capstyle="butt", zorder=2.5))


def draw_bodies(axes: Axes, setting: Setting) -> list[Circle | Polygon | PathPatch]:
    """Draw solids that do not move."""
    colors = zip(setting.bodies, each_color(setting.body_colors, BODY), strict=False)
    patches = [_patch(body, facecolor=color, edgecolor=RIM, linewidth=1.5, zorder=2) for body, color in colors]
    for patch in patches:
        axes.add_patch(patch)
    return patches


def draw_movers(axes: Axes, setting: Setting, frame: Frame) -> list[Polygon]:
    """Draw moving parts, filled in 2D, as wire frames in 3D."""
    flat = setting.camera is None
    outlines = setting.movers(frame) if setting.movers else []
    colors = each_color(setting.mover_colors, BODY if flat else RIM)
    patches = []
    for outline, color in zip(outlines, colors, strict=False):
        look = {"facecolor": color, "edgecolor": RIM} if flat else {"facecolor": "none", "edgecolor": color}
        patches.append(Polygon(outline, closed=True, linewidth=1.2, zorder=3.5, **look))
        axes.add_patch(patches[-1])
    return patches


def draw_wires(axes: Axes, setting: Setting) -> list[Line2D]:
    """Draw walls, periodic sides and edges in front of the particles."""
    lines = [Line2D(*ends.T, color=RIM, linewidth=2.0, solid_capstyle="projecting") for ends in setting.walls or ()]
    lines += [Line2D(*ends.T, color=RIM, linewidth=1.2, linestyle=":") for ends in setting.dotted]
    edges = zip(setting.wires, each_color(setting.wire_colors, RIM), strict=False)
    lines += [Line2D(*points.T, color=color, linewidth=0.9) for points, color in edges]
    for line in lines:
        line.set_zorder(4)
        axes.add_line(line)
    return lines


def each_color(colors: Sequence[str], usual: str) -> Iterable[str]:
    """These colors, or without any an endless sequence of the default color."""
    return colors or itertools.repeat(usual)


def _patch(shape: Shape, **look: Any) -> Circle | Polygon | PathPatch:
    if isinstance(shape, Round):
        return Circle((shape.x, shape.y), shape.radius, **look)
    seam = np.flatnonzero((shape[1:-1] == shape[0]).all(axis=1))
    if len(seam):  # a block with a hole in it
        parts = [Path(part, closed=True) for part in (shape[: seam[0] + 2], shape[seam[0] + 2 : -1])]
        return PathPatch(Path.make_compound_path(*parts), **look)
    return Polygon(shape, closed=True, **look)


MARGIN, BELOW = 0.02, 0.065
"""Room around the tank and below it, in parts of its larger side: the scale bar is below it."""
LEAST_BAR = 150.0
"""The least height of the bar of colors, in pixels of a picture of the usual size."""
LEAST_PIXELS, LEAST_OF_MANY = 4.0, 2.0
"""The smallest drawn size of a particle in pixels, and that of one among MANY."""
RARE = 0.005
"""The part of all values beyond either end of the colors' range: one particle's peak must not pale all others."""


class Coloring(NamedTuple):
    """The colors of a quantity of particles, with a color bar."""

    values: Callable[[Frame], Array]
    label: str
    unit: str
    colors: str = "viridis"


class Tank(Picture):
    """An open picture: `show` draws a frame, and `pixels` returns the result.

    `sample` are frames of the run, which determine the extent of the picture and the range of its colors.
    """

    def __init__(
        self, setting: Setting, sample: Sequence[Frame], size: Size = USUAL, coloring: Coloring | None = None
    ) -> None:
        self.setting, self.coloring, self.least = setting, coloring, 0.0
        self.view = view_of(setting, sample)
        # Space next to the tank is needed only for a color bar or a legend.
        side = SIDE if coloring is not None or len(setting.kinds) > 1 else 0.0
        self.figure = blank(size, self.view, side)
        with style():
            axes = axes_for(self.figure, self.view, side)
            draw_setting(axes, setting)
            bodies = draw_bodies(axes, setting)
            self.mapping = (
                color_bar(axes, coloring, [colored(setting, frame) for frame in sample]) if coloring else None
            )
            contents = self._contents(axes, sample[0])
            self.time = clock(axes)
            labels(axes, setting.title, setting.kinds if coloring is None else ())
            wires = draw_wires(axes, setting)
            self.movers = draw_movers(axes, setting, sample[0])
            self.bars = scale_bar(axes, self.view)
            arrows = [] if setting.camera is None else axis_arrows(axes, setting.camera)
            moving: list[Artist] = [
                *contents,
                *(bodies if setting.before else []),
                *self.movers,
                *wires,
                *self.bars,
                *arrows,
                self.time,
            ]
        self.layers = Layers(self.figure, moving)
        self.show(sample[0])

    def _contents(self, axes: Axes, frame: Frame) -> list[Artist]:
        """The contents of the tank, from the lowest up."""
        self.particles = self._particles(axes, frame)
        return [self.particles]

    def _particles(self, axes: Axes, frame: Frame) -> Circles | Splat:
        if self.setting.radius is None and self.setting.camera is not None:
            return splat_in(axes, Splat(frame.arrays["radius"], balls=True), 3)
        if self.setting.radius is None:
            pixel = _pixel(axes, self.view)
            self.least = 0.5 * pixel * (LEAST_OF_MANY if len(frame.arrays["radius"]) >= MANY else LEAST_PIXELS)
            return circles(axes, drawn_radius(frame, self.least), seen(frame.arrays["position"]), pixel)
        return splat_in(
            axes, Splat(self.setting.radius, balls=self.setting.camera is not None, room=self.setting.room), 3
        )

    def _colors(self, frame: Frame) -> Any:
        own = to_rgba_array([kind.color for kind in self.setting.kinds])
        if self.coloring is None or self.mapping is None:
            return own[frame.arrays["species"]]
        colors = np.array(self.mapping.to_rgba(self.coloring.values(frame)))
        if stand_apart(self.setting):
            apart = frame.arrays["species"] >= self.setting.apart
            colors[apart] = own[frame.arrays["species"][apart]]
        return colors

    def show(self, frame: Frame) -> None:
        """Draw a frame."""
        self._fill(frame)
        for patch, outline in zip(self.movers, self.setting.movers(frame) if self.setting.movers else (), strict=True):
            patch.set_xy(outline)
        self.time.set_text(time_text(frame.time) + self.pace)

    def _fill(self, frame: Frame) -> None:
        """Draw the contents of a frame."""
        position, camera = frame.arrays["position"], self.setting.camera
        depth = None if camera is None else position @ camera[2]
        if self.setting.radius is None:
            self.particles.resize(drawn_radius(frame, self.least))
        self.particles.put(seen(position, camera), depth, self._colors(frame))

    def place(self, frame: Frame, one: int) -> Array:
        """The position of a particle in the picture (m)."""
        there: Array = seen(frame.arrays["position"][one : one + 1], self.setting.camera)[0]
        return there


def _pixel(axes: Axes, view: View) -> float:
    """The size of a pixel (m)."""
    figure: Any = axes.figure
    return float(view.width / (axes.get_position().width * figure.get_size_inches()[0] * figure.dpi))


def drawn_radius(frame: Frame, least: float) -> Array:
    """The radii (m) with which the particles of a frame are drawn, at least the smallest one. Their number may be
    larger than before.
    """
    radius: Array = np.maximum(frame.arrays["radius"], least)
    return radius


def circles(axes: Axes, radius: Array, places: Array, pixel: float) -> Circles | Splat:
    """Particles of various sizes."""
    rim = 0.4 if radius.max(initial=0.0) > 4.0 * pixel else 0.0
    if len(radius) >= MANY:
        return splat_in(axes, Splat(radius, rim=rim), 3)
    drawn = Circles(
        2.0 * radius, 2.0 * radius, np.zeros_like(radius), units="xy", offsets=places,
        offset_transform=axes.transData, edgecolors=INK, linewidths=rim, zorder=3,
    )  # fmt: skip
    axes.add_collection(drawn, autolim=False)
    return drawn


class Circles(EllipseCollection):
    """Few particles, drawn as curves."""

    def put(self, places: Array, depth: Array | None, colors: Array) -> None:
        """Set positions and colors; circles ignore the depth."""
        self.set_offsets(places)
        shown: Any = colors
        self.set_facecolor(shown)

    def resize(self, radius: Array) -> None:
        """Set the radii (m)."""
        self.set_widths(2.0 * radius)
        self.set_heights(2.0 * radius)
        self.set_angles(np.zeros_like(radius))


def seen(position: Array, camera: Array | None = None) -> Array:
    """The horizontal and the vertical coordinate of positions in the picture: the first and the last axis, or those of
    a camera.
    """
    if camera is not None:
        shown: Array = position @ camera[:2].T
        return shown
    return np.column_stack([position[:, 0], position[:, -1]])


def time_text(time: float) -> str:
    """The time in a suitable unit.

    >>> time_text(3.14159), time_text(3600.0), time_text(5.0 * 86400.0)
    ('3.14 s', '60.0 min', '5.0 days')
    """
    if time < 600.0:
        return f"{time:.2f} s"
    for size, unit, most in ((60.0, "min", 600.0), (3600.0, "h", 72.0)):
        if time < most * size:
            return f"{time / size:.1f} {unit}"
    return f"{time / 86400.0:.1f} days"


def view_of(setting: Setting, frames: Sequence[Frame]) -> View:
    """The view of the whole tank, or without a tank of the region that the particles of these frames reach."""
    if setting.outline is not None:
        low, high = extent(setting.outline)
    elif setting.wires:
        low, high = extent(np.concatenate([*setting.wires, *setting.behind]))
    else:
        places = [seen(frame.arrays["position"], setting.camera) for frame in frames]
        reach = setting.radius or max(float(frame.arrays["radius"].max()) for frame in frames)
        low = np.min([place.min(axis=0) for place in places], axis=0) - 2.0 * reach
        high = np.max([place.max(axis=0) for place in places], axis=0) + 2.0 * reach
    room = MARGIN * float((high - low).max())
    below = BELOW * float((high - low).max())
    return View(float(low[0]) - room, float(high[0]) + room, float(low[1]) - below, float(high[1]) + room)


def color_bar(axes: Axes, coloring: Coloring, sample: Sequence[Frame]) -> ScalarMappable:
    """The color bar to the right of the tank; its range is that of the sampled frames without rare values, and begins
    at 0 where all particles have left.
    """
    values = np.concatenate([coloring.values(frame) for frame in sample])
    values = values if len(values) else np.zeros(1)
    low = float(np.quantile(values, RARE, method="lower"))
    high = float(np.quantile(values, 1.0 - RARE, method="higher"))
    mapping = ScalarMappable(Normalize(low, high if high > low else low + 1.0), coloring.colors)
    scale = scale_for(max(abs(low), abs(high)), coloring.unit)
    room = axes.get_position()
    figure: Any = axes.figure
    width = DPI * float(figure.get_size_inches()[0])
    tall = max(0.8 * room.height, LEAST_BAR / (DPI * float(figure.get_size_inches()[1])))
    pane = figure.add_axes((room.x1 + 30.0 / width, room.y0 + 0.5 * (room.height - tall), 17.0 / width, tall))
    least, most = mapping.get_clim()
    shown = ScalarMappable(Normalize(scale.factor * least, scale.factor * most), coloring.colors)
    bar = figure.colorbar(shown, cax=pane)
    bar.set_label(f"{coloring.label} ({scale.unit})", fontsize=10.5)
    bar.outline.set_edgecolor(MUTED)
    pane.grid(visible=False)
    pane.tick_params(labelsize=10)
    return mapping


def particles_picture(scene: Any, sample: Sequence[Frame], size: Size = USUAL) -> Tank:
    """Particles without surroundings: the picture for a model without a specific one."""
    kinds = species(scene) or [Species("", PALETTE[0])]
    return Tank(Setting(scene.title, None, kinds=kinds), sample, size)
