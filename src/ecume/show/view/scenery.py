"""The scenery on the page by model: walls, dish, surface, contacts, tanks; and its table `STAGES`."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from ecume.analysis.boxes import box_of
from ecume.analysis.pressures import with_pressures
from ecume.engine.walls import rings
from ecume.models.floating.dishes import behind_barrier, walls_of
from ecume.models.sph.setup.choices import free_surface, pressure_of
from ecume.scenes.soft.scene import SIDES as WALL_SIDES
from ecume.show.floating.bowl import height_colors, height_ticks, view_of
from ecume.show.floating.surface import outlines_in, sheet, surface, typical_meniscus
from ecume.show.picture import Species, edges_of, species
from ecume.show.soft.packing import WIDE, links_of, reached
from ecume.show.sph.picture import EDGES, FULL, regions, usual_color
from ecume.show.sph.solids import (
    drawn_shape,
    edges,
    is_ball,
    rectangle,
    rotation,
    shape_of,
    side_line,
    turned,
)
from ecume.show.sph.water import water_color
from ecume.show.style import liquid_color, scale_for
from ecume.show.tank import Round
from ecume.show.tracers import outline_of
from ecume.trajectories.frame import Frame
from ecume.units import Array

ROUND = np.linspace(0.0, 2.0 * np.pi, 65)
"""Angles around a circle."""


class Links(Protocol):
    """Contacts of a frame."""

    @property
    def pairs(self) -> Any:
        """The numbers of both particles of each contact, (C, 2)."""

    @property
    def along(self) -> Array:
        """The vectors from the first particle to the second, or to its nearest copy, (C, d) m."""

    @property
    def gap(self) -> Array:
        """The gap of each contact, (C,) m."""

    @property
    def tension(self) -> Array:
        """The tension of each contact, (C,) N."""


class Line(NamedTuple):
    """A line that never moves."""

    points: Array
    """(n, d) m"""
    closed: bool = False
    dashed: bool = False
    color: str | None = None
    """of a solid with a color"""


class Surface(NamedTuple):
    """The drawing of the heights of the surface."""

    columns: int
    rows: int
    view: tuple[float, float, float, float]
    walls: list[list[float]]
    """the surface is where n.x >= offset (m) for each (n_x, n_y, offset)"""
    round: float
    """and inside this radius (m); 0 for none"""
    map: str
    label: str
    shown: tuple[float, float]
    """the part of the scale that occurs, from 0 to 1"""
    ticks: list[tuple[float, str]]


class Filled(NamedTuple):
    """A tank whose liquid is drawn as a continuous region."""

    spacing: float
    """m"""
    low: list[float]
    """the corners of the tank (m); at open sides, of what is seen"""
    high: list[float]
    periodic: list[bool]


class Stage(NamedTuple):
    """The scenery around the particles of a run."""

    low: Array
    """(d,) m: the lower corner of the initial view"""
    high: Array
    kinds: Sequence[Any]
    """species, with names and colors"""
    usual: str = "species"
    """the initial meaning of colors"""
    radius: float = 0.0
    """of particles if frames do not contain radii (m)"""
    lines: Sequence[Line] = ()
    movers: Callable[[Frame], list[Array]] | None = None
    """outlines of moving solids, with the same number of points in every frame"""
    mover_colors: Sequence[str | None] = ()
    """of each; None or missing, as walls are"""
    inner: Array | None = None
    """(N,) m: radii of the discs inside the outlines of floats with a shape, which are drawn for them"""
    links: Callable[[Frame], Links] | None = None
    widest: float = 0.0
    """the gap up to which films are drawn (m)"""
    heights: Callable[[Frame], Array] | None = None
    """(rows, columns) of the surface, as parts of its scale from 0 to 1"""
    surface: Surface | None = None
    liquid: Filled | None = None
    derived: Callable[[Frame], Frame] | None = None
    """adds the arrays that are shown and not recorded"""
    curves: Sequence[str] = ()
    """numbers whose curves are shown at first"""
    apart: int | None = None
    """the species from which on particles keep their own colors when others are colored by a quantity"""


def circle(middle: Array, radius: float) -> Array:
    """Points on a circle."""
    points: Array = middle + radius * np.column_stack([np.cos(ROUND), np.sin(ROUND)])
    return points


BALL_LINES = 3
"""The number of lines of a ball in 3D."""


def sph_stage(scene: Any, sample: Sequence[Frame]) -> Stage:
    """The scenery of a tank: walls, obstacles, bodies and moving sides."""
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    lines = _tank_lines(scene, low, high) + [_painted(_solid(one), one.color) for one in scene.obstacles]
    driven = [side for side in scene.sides if getattr(scene.tank, side).motion is not None]
    flat = len(low) == 2

    def movers(frame: Frame) -> list[Array]:
        named = zip(scene.body_names, scene.bodies, strict=True)
        bodies = [line for name, body in named for line in _body(body, name, frame)]
        return bodies + [side_line(scene, side, frame) for side in driven if flat]

    margin = 0.03 * float((high - low).max())
    return Stage(
        low - margin, high + margin, _regions(scene), usual_quantity(scene) if flat else "species",
        FULL * scene.spacing, _joined(lines),
        movers if scene.bodies or (driven and flat) else None, _mover_colors(scene, low),
        liquid=_filled(scene, low - margin, high + margin),
        curves=("kinetic_energy", _peak(scene)), apart=len(scene.fluid) if scene.passive_tracers else None,
        derived=_pressures(scene),
    )  # fmt: skip


def usual_quantity(scene: Any) -> str:
    """The array that initially determines the colors of tanks in 2D."""
    return "species" if (name := usual_color(scene)) == "region" else name


def _peak(scene: Any) -> str:
    """The number that is shown with the kinetic energy: the largest pressure, if its single values do not depend on the
    time step.
    """
    splashes = not pressure_of(scene).compressible and free_surface(scene)
    return "largest_speed" if splashes else "largest_pressure"


def _pressures(scene: Any) -> Callable[[Frame], Frame] | None:
    """A function that adds the pressures that differ from the gauge pressure: the dynamic one under gravity, the
    absolute one.
    """
    of_one = any(scene.gravity) and scene.second_liquid is None
    names = ["dynamic_pressure"] * of_one + ["absolute_pressure"] * (scene.liquid.atmospheric_pressure > 0)
    if not names:
        return None
    completed = with_pressures(scene)

    def added(frame: Frame) -> Frame:
        full = completed(frame)
        more = {name: full.arrays[name] for name in names}
        return frame._replace(arrays={**frame.arrays, **more}, units=full.units)

    return added


def _regions(scene: Any) -> list[Species]:
    """The kinds of particles; a single liquid in 3D has the color of its substance, as in movies."""
    kinds = regions(scene)
    if len(scene.tank.low) == 3 and len(scene.fluid) == 1:
        return [kinds[0]._replace(color=water_color(scene)), *kinds[1:]]
    return kinds


def _filled(scene: Any, low: Array, high: Array) -> Filled:
    """The filled tank; beyond open sides the visible region, and the largest extent of moving sides."""
    corners = np.array([scene.tank.low, scene.tank.high], dtype=float)
    for number, side in enumerate(scene.sides):
        axis, end = number // 2, number % 2
        spec = getattr(scene.tank, side)
        if spec.kind == "open" or spec.motion is not None:
            corners[end, axis] = (high if end else low)[axis]
    periodic = [getattr(scene.tank, side).kind == "periodic" for side in scene.sides[::2]]
    return Filled(scene.spacing, corners[0].tolist(), corners[1].tolist(), periodic)


def _mover_colors(scene: Any, low: Array) -> list[str | None]:
    """The colors of bodies in the order of lines; moving sides follow without colors."""
    flat = len(low) == 2
    lines = [1 if flat else BALL_LINES if is_ball(body) else len(edges(shape_of(body))) for body in scene.bodies]
    return [body.color for body, count in zip(scene.bodies, lines, strict=True) for _ in range(count)]


def _painted(lines: list[Line], color: str | None) -> list[Line]:
    return [line._replace(color=color) for line in lines]


def _joined(lines: list[Line | list[Line]]) -> list[Line]:
    return list(itertools.chain.from_iterable(one if isinstance(one, list) else [one] for one in lines))


def _tank_lines(scene: Any, low: Array, high: Array) -> list[Line | list[Line]]:
    """The walls, dashed at periodic sides; empty if all sides are open."""
    kinds = {side: getattr(scene.tank, side).kind for side in scene.sides}
    if len(low) == 3:
        around = any(kind in ("wall", "periodic") for kind in kinds.values())
        return [[Line(edge) for edge in edges_of(low, high)] if around else []]
    corners = rectangle(low, high)
    return [
        Line(corners[[first, last]], dashed=kinds[side] == "periodic")
        for side, first, last in EDGES
        if kinds[side] in ("wall", "periodic")
    ]


def _solid(solid: Any) -> list[Line]:
    """The lines of an obstacle; for a ball in 3D three circles."""
    if is_ball(solid):
        return _ball(np.array(solid.center), solid.radius)
    if solid.vertices and len(solid.vertices[0]) == 2:
        return [Line(np.array(solid.vertices), closed=True)]
    if solid.low is None:
        return [Line(edge) for edge in edges(drawn_shape(solid))]
    low, high = np.array(solid.low), np.array(solid.high)
    return [Line(rectangle(low, high), closed=True)] if len(low) == 2 else [Line(edge) for edge in edges_of(low, high)]


def _ball(middle: Array, radius: float) -> list[Line]:
    if len(middle) == 2:
        return [Line(circle(middle, radius), closed=True)]
    flat = np.column_stack([circle(np.zeros(2), radius), np.zeros(len(ROUND))])
    return [Line(middle + np.roll(flat, turn, axis=1), closed=True) for turn in range(BALL_LINES)]


def _body(body: Any, name: str, frame: Frame) -> list[Array]:
    """The lines of a body at its position; a round one has a spoke, so that its rotation is visible."""
    shape = shape_of(body)
    middle = np.array([frame.numbers[f"{name}_{axis}"] for axis in "xyz"[: len(shape.middle())]])
    if len(middle) == 2:
        turn = rotation(frame.numbers[f"{name}_angle"])
        lines = [np.vstack([circle(np.zeros(2), body.radius), np.zeros(2)])] if body.radius is not None else None
        return [middle + line @ turn.T for line in lines or [one.points for one in _solid_of(shape)]]
    turn = turned([frame.numbers[f"{name}_q{part}"] for part in "wxyz"])
    parts = [one.points for one in _ball(np.zeros(3), body.radius)] if is_ball(body) else edges(shape)
    return [middle + part @ turn.T for part in parts]


def _solid_of(shape: Any) -> list[Line]:
    if hasattr(shape, "vertices"):
        return [Line(shape.vertices, closed=True)]
    low, high = shape.bounds()
    return [Line(rectangle(low, high), closed=True)]


def tracers_stage(scene: Any, sample: Sequence[Frame]) -> Stage:
    """The scenery of tracers: the tank, obstacles and openings."""
    places = np.concatenate([frame.arrays["position"] for frame in sample])
    tank, dimension = scene.tank, places.shape[1]
    lines = [_solid(one) for one in scene.obstacles]
    low, high = places.min(axis=0), places.max(axis=0)
    outline = outline_of(tank) if tank is not None else None
    if outline is not None and dimension == 2:
        points = circle(np.array(outline[:2]), outline.radius) if isinstance(outline, Round) else outline
        lines.append([Line(points, closed=True)])
        low, high = points.min(axis=0), points.max(axis=0)
    elif tank is not None:
        lines.append(_tank_in_space(tank))
        corners = np.concatenate([line.points for line in lines[-1]])
        low, high = corners.min(axis=0), corners.max(axis=0)
    margin = 0.03 * float((high - low).max())
    return Stage(low - margin, high + margin, species(scene), lines=_joined(list(lines)), curves=("kinetic_energy",))


def _tank_in_space(tank: Any) -> list[Line]:
    if getattr(tank, "radius", None) is not None:
        return _ball(np.array(getattr(tank, "center", None) or (0.0, 0.0, 0.0)), tank.radius)
    if getattr(tank, "high", None) is not None:
        return [Line(edge) for edge in edges_of(np.array(tank.low), np.array(tank.high))]
    corners = np.array(tank.vertices)
    return [Line(edge) for edge in edges_of(corners.min(axis=0), corners.max(axis=0))]


CELLS = 110
"""The number of cells of the surface picture along its longer side."""


def floating_stage(scene: Any, sample: Sequence[Frame]) -> Stage:
    """The scenery of floats: the dish, and the surface of the liquid in it."""
    view = view_of(scene, sample)
    closest = min(float(frame.arrays["radius"].min()) for frame in sample)
    on = sheet(scene, view, cells=CELLS, closest=closest)
    heights = np.array([surface(frame, on) for frame in sample])
    largest = float(np.abs(heights).max())
    scale = scale_for(largest, "m")
    tint = liquid_color(scene.liquid)
    colors = height_colors(largest * scale.factor, typical_meniscus(sample[0], on) * scale.factor, tint)
    shown, ticks = _marks(colors.norm, scale.factor * float(heights.min()), scale.factor * float(heights.max()))
    shapes, walls = on.shapes, rings.outer_walls(walls_of(scene.dish))
    drawn = Surface(
        len(on.x), len(on.y), (view.left, view.right, view.bottom, view.top),
        np.column_stack([walls.normal, walls.offset]).tolist(),
        walls.disc_radius if math.isfinite(walls.disc_radius) else 0.0,
        f"height {tint or ''}".strip(), f"height of the liquid ({scale.unit})", shown, ticks,
    )  # fmt: skip
    return Stage(
        np.array([view.left, view.bottom]), np.array([view.right, view.top]), species(scene),
        lines=_borders(scene),
        heights=lambda frame: np.asarray(np.clip(colors.norm(surface(frame, on) * scale.factor), 0.0, 1.0)),
        surface=drawn, curves=("kinetic_energy", "total_energy"),
        movers=_moving_outlines(scene, shapes),
        inner=None if shapes is None else np.array([np.hypot(*one.T).min() for one in shapes.outlines]),
    )  # fmt: skip


def _moving_outlines(scene: Any, shapes: Any) -> Any:
    """A function for the outlines of floats with a shape, and of the region behind a barrier, in a frame; or None."""
    dish = scene.dish
    if shapes is None and (dish is None or dish.barrier is None):
        return None

    def moving(frame: Frame) -> list[Array]:
        bodies = [] if shapes is None else outlines_in(frame, shapes)
        behind = behind_barrier(dish, frame.numbers.get("barrier_position", 0.0))
        return [closed(one) for one in [*bodies, *behind]]

    return moving


def _borders(scene: Any) -> list[Line]:
    """The rim of the dish, or the outline of the periodic cell."""
    if scene.dish is not None:
        walls = walls_of(scene.dish)
        return [
            Line(rings.outline(walls), closed=True),
            *(Line(one, closed=True) for one in rings.inner_outline(walls)),
        ]
    if scene.cell is None:
        return []
    return [Line(rectangle(np.zeros(2), np.array(scene.sides)), dashed=True)]


def _marks(norm: Any, lowest: float, highest: float) -> tuple[tuple[float, float], list[tuple[float, str]]]:
    """The part of a color scale that occurs, including zero, and its ticks; both as positions from 0 to 1."""

    def place(height: float) -> float:
        return float(np.asarray(norm(np.array([height])))[0])

    ticks = [(place(one), f"{one:g}") for one in height_ticks(norm, (lowest, highest))]
    return (place(min(lowest, 0.0)), place(max(highest, 0.0))), ticks


def closed(points: Array) -> Array:
    """A line that ends where it began."""
    return np.concatenate([points, points[:1]])


def soft_stage(scene: Any, sample: Sequence[Frame]) -> Stage:
    """The scenery of soft spheres: the periodic box, and contact forces."""
    low, high = reached(sample)
    box = box_of(sample[0])
    boxed = box is not None and box.closed
    sides = [wall.side for wall in scene.walls]

    def around(frame: Frame) -> list[Array]:
        return [*(_box(frame, len(low)) if boxed else []), *(_wall(frame, side, low, high) for side in sides)]

    return Stage(
        low, high, species(scene), movers=around if boxed or sides else None, links=links_of if len(low) == 2 else None,
        widest=WIDE * float(sample[0].arrays["radius"].min()),
        curves=("shear_stress", "pressure") if boxed else ("smallest_gap", "largest_tension"),
    )  # fmt: skip


def _box(frame: Frame, dimensions: int) -> list[Array]:
    """The periodic box."""
    lengths = np.array([frame.numbers[f"box_{side}"] for side in ("width", "height", "depth")[:dimensions]])
    return [rectangle(np.zeros(2), lengths)] if dimensions == 2 else edges_of(np.zeros(3), lengths)


def _wall(frame: Frame, side: str, low: Array, high: Array) -> Array:
    """The visible part of a wall at its present position."""
    axis = WALL_SIDES[side][0]
    low, high = low.copy(), high.copy()
    low[axis] = high[axis] = frame.numbers[f"{side}_{'xyz'[axis]}"]
    if len(low) == 2:
        return np.array([low, high])
    one, other = (k for k in range(3) if k != axis)
    corners = np.array([low, low, high, high])
    corners[1, one], corners[3, one] = high[one], low[one]
    corners[1, other], corners[3, other] = low[other], high[other]
    return corners


STAGES: dict[str, Callable[[Any, Sequence[Frame]], Stage]] = {
    "floating": floating_stage,
    "soft": soft_stage,
    "sph": sph_stage,
    "tracers": tracers_stage,
}
"""Functions from (scene, some frames of the run) to the surroundings of particles, by model."""
