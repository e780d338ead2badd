"""The scenery of a picture: the tank, its solids, and what moves beside the particles."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon

from ecume.show.picture import Species
from ecume.show.style import RIM
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
    """The scenery around the particles."""

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
    """the color of what the tank holds"""
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
    """of all particles (m), where frames say none"""
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
    """Whether there are species that keep their own colors."""
    return setting.apart is not None and setting.apart < len(setting.kinds)


def colored(setting: Setting, frame: Frame) -> Frame:
    """The frame without particles that keep their own colors."""
    if not stand_apart(setting):
        return frame
    chosen = frame.arrays["species"] < setting.apart
    return frame.with_arrays({name: array[chosen] for name, array in frame.arrays.items()})


def extent(shape: Shape) -> tuple[Array, Array]:
    """The lowest and the highest corner of what is around a shape."""
    if isinstance(shape, Round):
        middle = np.array([shape.x, shape.y])
        return middle - shape.radius, middle + shape.radius
    return shape.min(axis=0), shape.max(axis=0)


def draw_setting(axes: Axes, setting: Setting) -> None:
    """The tank with its liquid, the bodies in it, and the openings as gaps in the walls."""
    if setting.outline is not None:
        axes.add_patch(_patch(setting.outline, facecolor=setting.inside, edgecolor="none", zorder=0))
        if setting.walls is None:
            axes.add_patch(_patch(setting.outline, facecolor="none", edgecolor=RIM, linewidth=2.0, zorder=2))
    for ends in setting.behind:
        axes.add_line(Line2D(*ends.T, color=RIM, linewidth=0.9, zorder=2))
    for ends in setting.gaps:
        axes.add_line(Line2D(*ends.T, color="white", linewidth=3.0, solid_capstyle="butt", zorder=2.5))


def draw_bodies(axes: Axes, setting: Setting) -> list[Circle | Polygon]:
    """Solids that do not move."""
    colors = zip(setting.bodies, each_color(setting.body_colors, BODY), strict=False)
    patches = [_patch(body, facecolor=color, edgecolor=RIM, linewidth=1.5, zorder=2) for body, color in colors]
    for patch in patches:
        axes.add_patch(patch)
    return patches


def draw_movers(axes: Axes, setting: Setting, frame: Frame) -> list[Polygon]:
    """Filled in 2D, wire frames in 3D."""
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
    """Walls, sides that come back at the other side, and edges, all before the particles."""
    lines = [Line2D(*ends.T, color=RIM, linewidth=2.0, solid_capstyle="projecting") for ends in setting.walls or ()]
    lines += [Line2D(*ends.T, color=RIM, linewidth=1.2, linestyle=":") for ends in setting.dotted]
    edges = zip(setting.wires, each_color(setting.wire_colors, RIM), strict=False)
    lines += [Line2D(*points.T, color=color, linewidth=0.9) for points, color in edges]
    for line in lines:
        line.set_zorder(4)
        axes.add_line(line)
    return lines


def each_color(colors: Sequence[str], usual: str) -> Iterable[str]:
    """These colors, or without end the default one."""
    return colors or itertools.repeat(usual)


def _patch(shape: Shape, **look: Any) -> Circle | Polygon:
    if isinstance(shape, Round):
        return Circle((shape.x, shape.y), shape.radius, **look)
    return Polygon(shape, closed=True, **look)
