"""Pictures of soft spheres: a layer with its films and forces, or 3D packings as shaded balls.

Spheres are drawn to scale, films are colored by their gap, and forces by their sign. A periodic box is drawn with its
outline, and surrounded by copies in paler colors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import LogNorm, to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray

from ecume.analysis.boxes import Box, box_of, copies, nearest
from ecume.analysis.close_pairs import films
from ecume.errors import BadInput
from ecume.show.picture import (
    DPI,
    USUAL,
    Eye,
    Layers,
    Picture,
    Size,
    View,
    Wires,
    axes_for,
    blank,
    clock,
    discs,
    edges_of,
    labels,
    scale_bar,
    species,
    view_around,
    wires_of,
)
from ecume.show.style import INK, scale_for, style
from ecume.show.tank import Setting, Tank
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.soft import SoftScene


SIDE = 170.0
"""The margin right of the spheres, in pixels of a picture of the usual size."""
PULL, PUSH = "#b2182b", "#2166ac"
WIDEST = 7.0
"""The width of the line of the largest force, in points."""
FILM, WIDE = 0.28, 0.5
"""Half of the length of a film's line, and the largest drawn gap, in radii of the smaller sphere."""
FARTHEST = 1.5
"""The largest drawn distance of the centers of a contact, over the sum of radii and gap; farther contacts are between
other copies.
"""
WALL_AXES = {"left": "x", "right": "x", "bottom": "y", "top": "y"}
GAP_COLORS = "viridis"
MARK = (0.3, 0.85)
"""The start and the end of the mark that shows a sphere's rotation, in radii."""
BESIDE = 1.6
"""The width of the visible periodic copies around a box, in radii of the largest sphere."""
PALE = 0.4
"""The opacity of copies."""
CIRCLE = np.stack([wave(np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)) for wave in (np.cos, np.sin)], axis=1)
"""A disc as a polygon."""


class Links(NamedTuple):
    """The contacts of a frame, as numbers in the picture's coordinates."""

    first: Array
    """(C, 2) m: the center of one sphere"""
    along: Array
    """(C, 2) m: from there to the other's"""
    radius: Array
    """(C, 2) m: of both"""
    gap: Array
    tension: Array
    pairs: NDArray[np.int64]
    """(C, 2) the numbers of both"""


def links_of(frame: Frame) -> Links:
    """The contacts in a frame; across a periodic border, to the nearest copy."""
    position, radius = frame.arrays["position"], frame.arrays["radius"]
    found = films(frame)
    first, second = found.pairs.T
    along = nearest(position[second] - position[first], box_of(frame))
    slots = np.nonzero(frame.arrays["neighbor"] >= 0)
    here = np.linalg.norm(along, axis=1) < FARTHEST * (radius[found.pairs].sum(axis=1) + found.gap)
    seen = position[first, :2], along[:, :2], radius[found.pairs], found.gap
    columns = (*seen, frame.arrays["tension"][slots], found.pairs)
    return Links(*(column[here] for column in columns))


def links_around(frame: Frame) -> Links:
    """The contacts in a frame, repeated for each shown copy of the box."""
    links, box = links_of(frame), flat_box(frame)
    if box is None:
        return links
    far = _beside(frame) + float(np.linalg.norm(links.along, axis=1).max(initial=0.0))
    around = copies(links.first, box, far)
    # A copy of the first sphere of each contact represents the contact.
    rest: Any = links[1:]
    return Links(around.position, *(column[around.owner] for column in rest))


def flat_box(frame: Frame) -> Box | None:
    """The periodic box, seen along the third axis."""
    box = box_of(frame)
    return None if box is None else box._replace(sides=box.sides[:2])


def _beside(frame: Frame) -> float:
    return BESIDE * float(frame.arrays["radius"].max())


def view_of(frames: Sequence[Frame]) -> View:
    """The shown region: the periodic box and a margin; along other axes, the region that the spheres of these frames
    reach.
    """
    low, high = (end[:2] for end in reached(frames))
    margin = np.full(2, max(float(frame.arrays["radius"].max()) for frame in frames))
    if "bottom_y" in frames[0].numbers:
        margin[1] *= 3.0  # room for the scale under a floor
    sides = np.max([np.zeros(2) if (box := flat_box(frame)) is None else box.sides for frame in frames], axis=0)
    low, high = np.where(sides > 0.0, 0.0, low), np.where(sides > 0.0, sides, high)
    margin[sides > 0.0] = 2.0 * _beside(frames[0])
    (x, y), (width, height) = (low + high) / 2, high - low + margin
    return view_around(float(x), float(y), float(width), float(height))


def reached(frames: Sequence[Frame]) -> tuple[Array, Array]:
    """The lowest and the highest positions, (d,) m, that spheres of these frames reach."""
    edges = [(frame.arrays["position"], frame.arrays["radius"][:, None]) for frame in frames]
    low = np.min([(place - radius).min(axis=0) for place, radius in edges], axis=0)
    return low, np.max([(place + radius).max(axis=0) for place, radius in edges], axis=0)


class Packing(Picture):
    """An open picture: `show` draws a frame, and `pixels` returns the result."""

    def __init__(self, scene: Any, sample: Sequence[Frame], size: Size = USUAL) -> None:
        self.view = view_of(sample)
        self.figure = blank(size, self.view, SIDE)
        links = [links_of(frame) for frame in sample]
        self.largest = max((float(np.abs(one.tension).max(initial=0.0)) for one in links), default=0.0)
        self.norm = _gap_scale(links)
        kinds = species(scene)
        with style():
            axes = axes_for(self.figure, self.view, SIDE)
            self.colors = [to_rgba(kind.color, PALE) for kind in kinds]
            self.beside = PolyCollection([], edgecolors=to_rgba(INK, PALE), linewidths=0.6, zorder=1)
            self.spheres = discs(axes, sample[0], kinds)
            self.outline = Polygon(np.zeros((4, 2)), closed=True, fill=False, edgecolor=INK, linewidth=1.2, zorder=5)
            self.outline.set_linestyle("--")
            axes.add_patch(self.outline)
            self.forces = LineCollection([], capstyle="round", zorder=3)
            self.films = LineCollection([], cmap=GAP_COLORS, norm=self.norm, linewidths=3.0, zorder=4)
            self.marks = LineCollection([], colors=INK, linewidths=1.2, capstyle="round", zorder=2.5)
            for lines in (self.beside, self.marks, self.forces, self.films):
                axes.add_collection(lines, autolim=False)
            self.walls = {wall.side: _wall_line(axes, wall.side) for wall in scene.walls if wall.side in WALL_AXES}
            self.time = clock(axes)
            self.bars = scale_bar(axes, self.view)
            _gap_bar(axes, self.films)
            labels(axes, scene.title, kinds)
            _force_legend(axes, self.largest)
        below: list[Artist] = [self.beside, self.spheres, self.marks]
        moving = [*below, self.forces, self.films, self.outline, *self.walls.values(), *self.bars, self.time]
        self.layers = Layers(self.figure, moving)
        self.show(sample[0])

    def show(self, frame: Frame) -> None:
        """Draw a frame."""
        links = links_around(frame)
        self._show_box(frame)
        self.spheres.set_offsets(frame.arrays["position"][:, :2])
        self.marks.set_segments(list(marks_of(frame)))
        self.forces.set_segments(list(np.stack([links.first, links.first + links.along], axis=1)))
        self.forces.set_linewidth(list(WIDEST * np.abs(links.tension) / max(self.largest, 1e-300)))
        self.forces.set_color([PULL if tension > 0.0 else PUSH for tension in links.tension])
        for side, line in self.walls.items():
            place = [frame.numbers[f"{side}_{WALL_AXES[side]}"]] * 2
            (line.set_xdata if WALL_AXES[side] == "x" else line.set_ydata)(place)
        narrow = links.gap < WIDE * links.radius.min(axis=1)
        self.films.set_segments(list(_film_lines(links)[narrow]))
        self.films.set_array(links.gap[narrow])
        self.time.set_text(f"{frame.time:.4g} s{self.pace}")

    def _show_box(self, frame: Frame) -> None:
        """Draw the outline and the copies of a periodic box."""
        box = flat_box(frame)
        self.outline.set_visible(box is not None and box.closed)
        if box is None:
            return
        place, radius = frame.arrays["position"][:, :2], frame.arrays["radius"]
        around = copies(place, box, _beside(frame) + float(radius.max()))
        here, owner = around.position[len(place) :], around.owner[len(place) :]
        self.beside.set_verts(list(here[:, None] + radius[owner, None, None] * CIRCLE))
        self.beside.set_facecolor([self.colors[kind] for kind in frame.arrays["species"][owner]])
        self.outline.set_xy(box.sides * [(0, 0), (1, 0), (1, 1), (0, 1)])


def marks_of(frame: Frame) -> NDArray[np.float64]:
    """A spoke of each sphere, (N, 2, 2), that rotates with it; in 3D, as seen from above. Empty if spheres do not
    rotate.
    """
    arrays = frame.arrays
    if "angle" in arrays:
        spoke = np.stack([np.cos(arrays["angle"]), np.sin(arrays["angle"])], axis=1)
    elif "orientation" in arrays:
        w, x, y, z = arrays["orientation"].T
        spoke = np.stack([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z)], axis=1)
    else:
        return np.zeros((0, 2, 2))
    spoke = spoke * arrays["radius"][:, None]
    return np.asarray(arrays["position"][:, None, :2] + np.array(MARK)[None, :, None] * spoke[:, None])


def _wall_line(axes: Axes, side: str) -> Line2D:
    """The line of a wall, seen from its side."""
    draw = axes.axvline if WALL_AXES[side] == "x" else axes.axhline
    return draw(0.0, color=INK, linewidth=3.0, zorder=5)


def _film_lines(links: Links) -> NDArray[np.float64]:
    """The lines normal to each line of centers, between the facing surfaces."""
    length = np.linalg.norm(links.along, axis=1, keepdims=True)
    unit = links.along / np.maximum(length, 1e-300)
    middle = links.first + unit * (links.radius[:, :1] + 0.5 * links.gap[:, None])
    across = FILM * links.radius.min(axis=1, keepdims=True) * np.stack([-unit[:, 1], unit[:, 0]], axis=1)
    return np.stack([middle - across, middle + across], axis=1)


def _gap_scale(links: Sequence[Links]) -> LogNorm:
    """The color scale from half the narrowest gap to twice the widest."""
    gaps = np.concatenate([one.gap[one.gap < WIDE * one.radius.min(axis=1)] for one in links])
    low, high = (float(gaps.min()), float(gaps.max())) if len(gaps) else (1e-6, 1e-3)
    return LogNorm(0.5 * low, 2.0 * high)


def _gap_bar(axes: Axes, films: LineCollection) -> None:
    """Draw the color bar of the gaps."""
    figure: Any = axes.get_figure(root=True)
    box, width = axes.get_position(), DPI * figure.get_size_inches()[0]
    place = figure.add_axes((box.x1 + 40 / width, box.y0 + 0.06 * box.height, 16 / width, 0.42 * box.height))
    bar = figure.colorbar(films, cax=place)
    place.tick_params(labelsize=9)
    place.grid(visible=False)
    scale = scale_for(float(np.max(films.norm.vmax or 1.0)), "m")
    place.yaxis.set_major_formatter(FuncFormatter(lambda gap, _: f"{scale.factor * gap:g}"))
    bar.set_label(f"gap ({scale.unit})", fontsize=10)


def _force_legend(axes: Axes, largest: float) -> None:
    """Draw the legend of forces: the width of the largest, and the colors of tension and compression."""
    scale = scale_for(largest, "N")
    widest = f"{largest * scale.factor:.3g} {scale.unit}"
    handles = [
        Line2D([], [], color=PULL, linewidth=0.6 * WIDEST, label="tension"),
        Line2D([], [], color=PUSH, linewidth=0.6 * WIDEST, label=f"compression\n(widest: {widest})"),
    ]
    kept = axes.get_legend()
    second = axes.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(1.03, 0.74), fontsize=9.5, borderaxespad=0.0
    )
    second.set_clip_on(False)
    for text in second.get_texts():
        text.set_color(INK)
    if kept is not None:
        axes.add_artist(kept)


MANY = 60
"""The number of spheres in 3D above which they are drawn as balls, since they would hide the films."""


def soft_picture(
    scene: SoftScene, sample: Sequence[Frame], size: Size = USUAL, eye: Eye | None = None
) -> Packing | Tank:
    """The picture of a frame: few spheres from above with their forces, many spheres in 3D as balls, or any number in
    perspective.
    """
    count, dimensions = sample[0].arrays["position"].shape
    if dimensions == 2 and eye is not None:
        raise BadInput("got azimuth or elevation for a 2D scene; expected a 3D scene, or neither of them")
    if eye is None and (dimensions == 2 or count < MANY):
        return Packing(scene, sample, size)
    return Tank(setting_in_space(scene, sample, eye or Eye()), sample, size)


def setting_in_space(scene: SoftScene, sample: Sequence[Frame], eye: Eye) -> Setting:
    """The edges of a periodic box, whose size may change, around balls."""
    camera, boxes = eye.camera(), [box for frame in sample if (box := box_of(frame)) is not None and box.closed]
    if not boxes:
        return Setting(scene.title, None, kinds=species(scene), camera=camera)
    sides = np.array([box.sides for box in boxes])
    steady = bool((sides == sides[0]).all())
    around = wires_of(np.zeros(3), sides.max(axis=0), camera) if steady else Wires([], [])
    return Setting(
        scene.title, None, kinds=species(scene), wires=around.front, behind=around.behind, camera=camera,
        movers=None if steady else _edges(camera),
    )  # fmt: skip


def _edges(camera: Array) -> Callable[[Frame], list[Array]]:
    """The edges of the box of each frame."""

    def outlines(frame: Frame) -> list[Array]:
        box = box_of(frame)
        return [] if box is None else [edge @ camera[:2].T for edge in edges_of(np.zeros(3), box.sides)]

    return outlines
