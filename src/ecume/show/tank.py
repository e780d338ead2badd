"""Tanks as seen from the side: walls, obstacles, and particles to scale, colored by species or by a quantity.

Any model with a tank can have its pictures here. In 3D they show the first and the last axis, or what a camera
of the setting sees.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize, to_rgba_array

from ecume.show.picture import (
    DPI,
    SIDE,
    USUAL,
    Layers,
    Picture,
    Size,
    Species,
    View,
    axes_for,
    blank,
    clock,
    labels,
    scale_bar,
    species,
)
from ecume.show.scenery import Setting, colored, draw_bodies, draw_movers, draw_setting, draw_wires, extent, stand_apart
from ecume.show.splat import MANY, Splat, splat_in
from ecume.show.style import INK, MUTED, PALETTE, scale_for, style
from ecume.trajectories.frame import Frame
from ecume.units import Array

MARGIN, BELOW = 0.02, 0.065
"""Room around the tank and below it, in parts of its larger side: the scale bar is below it."""
LEAST_BAR = 150.0
"""The least height of the bar of colors, in pixels of a picture of the usual size."""
LEAST_PIXELS = 2.0
"""What would be smaller is drawn so large: it would not be seen."""
RARE = 0.005
"""The part of all values beyond either end of the colors' range: one particle's peak must not pale all others."""


class Coloring(NamedTuple):
    """Values of a frame's particles as colors, with a bar that says what they mean."""

    values: Callable[[Frame], Array]
    label: str
    unit: str
    colors: str = "viridis"


class Tank(Picture):
    """An open picture: `show` puts a frame into it, `pixels` gives what is then seen.

    `sample` are frames of the run: from them the picture takes its extent, and its colors' range.
    """

    def __init__(
        self, setting: Setting, sample: Sequence[Frame], size: Size = USUAL, coloring: Coloring | None = None
    ) -> None:
        self.setting, self.coloring = setting, coloring
        self.view = view_of(setting, sample)
        # Without a bar of colors or a legend there is nothing beside the tank.
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
            moving: list[Artist] = [
                *contents,
                *(bodies if setting.before else []),
                *self.movers,
                *wires,
                *self.bars,
                self.time,
            ]
        self.layers = Layers(self.figure, moving)
        self.show(sample[0])

    def _contents(self, axes: Axes, frame: Frame) -> list[Artist]:
        """What the tank holds, from the lowest up."""
        self.particles = self._particles(axes, frame)
        return [self.particles]

    def _particles(self, axes: Axes, frame: Frame) -> Circles | Splat:
        if self.setting.radius is None and self.setting.camera is not None:
            return splat_in(axes, Splat(frame.arrays["radius"], balls=True), 3)
        if self.setting.radius is None:
            return circles(axes, self.view, frame)
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
        """Put a frame into the picture."""
        self._fill(frame)
        for patch, outline in zip(self.movers, self.setting.movers(frame) if self.setting.movers else (), strict=True):
            patch.set_xy(outline)
        self.time.set_text(time_text(frame.time))

    def _fill(self, frame: Frame) -> None:
        """Put the contents of a frame into the tank."""
        position, camera = frame.arrays["position"], self.setting.camera
        depth = None if camera is None else position @ camera[2]
        self.particles.put(seen(position, camera), depth, self._colors(frame))

    def place(self, frame: Frame, one: int) -> Array:
        """Where a particle is seen (m)."""
        there: Array = seen(frame.arrays["position"][one : one + 1], self.setting.camera)[0]
        return there


def circles(axes: Axes, view: View, frame: Frame) -> Circles | Splat:
    """Particles of many sizes; what would be too small to be seen is drawn larger."""
    figure: Any = axes.figure
    across = axes.get_position().width * float(figure.get_size_inches()[0]) * figure.dpi
    pixel = view.width / across
    diameter = np.maximum(2.0 * frame.arrays["radius"], LEAST_PIXELS * pixel)
    rim = 0.4 if diameter.max() > 8.0 * pixel else 0.0
    if len(diameter) >= MANY:
        return splat_in(axes, Splat(diameter / 2.0, rim=rim), 3)
    drawn = Circles(
        diameter, diameter, np.zeros_like(diameter), units="xy", offsets=seen(frame.arrays["position"]),
        offset_transform=axes.transData, edgecolors=INK, linewidths=rim, zorder=3,
    )  # fmt: skip
    axes.add_collection(drawn, autolim=False)
    return drawn


class Circles(EllipseCollection):
    """Few particles, as curves."""

    def put(self, places: Array, depth: Array | None, colors: Array) -> None:
        """Where they are seen, and their colors; circles have no depth."""
        self.set_offsets(places)
        shown: Any = colors
        self.set_facecolor(shown)


def seen(position: Array, camera: Array | None = None) -> Array:
    """The first axis and the last, which points up; or what a camera has at its right and above."""
    if camera is not None:
        shown: Array = position @ camera[:2].T
        return shown
    return np.column_stack([position[:, 0], position[:, -1]])


def time_text(time: float) -> str:
    """The time with its unit, to two decimals."""
    return f"{time:.2f} s" if time < 600.0 else f"{time / 60.0:.1f} min"


def view_of(setting: Setting, frames: Sequence[Frame]) -> View:
    """The whole tank; without one, all that the particles of these frames ever reach."""
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
    """The colors' range is that of the sampled frames, but for what is rare; the bar stands right of the tank."""
    values = np.concatenate([coloring.values(frame) for frame in sample])
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
    """Particles without surroundings: the picture of a model without a specific one."""
    kinds = species(scene) or [Species("", PALETTE[0])]
    return Tank(Setting(scene.title, None, kinds=kinds), sample, size)
