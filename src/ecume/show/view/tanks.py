"""Tanks of liquid and of tracers on the page: walls, obstacles, bodies, sides that move."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ecume.analysis.pressures import with_pressures
from ecume.scenes.sph import SIDES
from ecume.show.camera import edges_of
from ecume.show.picture import Species, species
from ecume.show.scenery import Round
from ecume.show.sph.picture import EDGES, FULL, rectangle, regions, usual_color
from ecume.show.sph.solids import edges, rotation, shape_of, side_line, turned
from ecume.show.sph.water import water_color
from ecume.show.tracers import outline_of
from ecume.show.view.stage import ROUND, Filled, Line, Stage, circle
from ecume.trajectories.frame import Frame
from ecume.units import Array

BALL_LINES, BOX_LINES = 3, 12
"""The number of lines of a solid in 3D."""


def sph_stage(scene: Any, sample: Sequence[Frame]) -> Stage:
    """The tank, obstacles, bodies, moving sides."""
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    lines = _tank_lines(scene, low, high) + [_painted(_solid(one), one.color) for one in scene.obstacles]
    driven = [side for side in SIDES if getattr(scene.tank, side).motion is not None]
    flat = len(low) == 2

    def movers(frame: Frame) -> list[Array]:
        bodies = [line for number, body in enumerate(scene.bodies) for line in _body(body, number, frame)]
        return bodies + [side_line(scene, side, frame) for side in driven if flat]

    margin = 0.03 * float((high - low).max())
    return Stage(
        low - margin, high + margin, _regions(scene), usual_color(scene) if flat else "species",
        FULL * scene.spacing, _joined(lines),
        movers if scene.bodies or (driven and flat) else None, _mover_colors(scene, low),
        liquid=_filled(scene, low - margin, high + margin),
        curves=("kinetic_energy", "largest_pressure"), apart=len(scene.fluid) if scene.passive_tracers else None,
        derived=_pressures(scene),
    )  # fmt: skip


def _pressures(scene: Any) -> Callable[[Frame], Frame] | None:
    """Adds the pressures that differ from the gauge pressure: the dynamic one under gravity, the absolute one."""
    names = ["dynamic_pressure"] * any(scene.gravity) + ["absolute_pressure"] * (scene.liquid.atmospheric_pressure > 0)
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
    """The tank; beyond open sides what is seen, and where sides move the room that they leave at most."""
    corners = np.array([scene.tank.low, scene.tank.high], dtype=float)
    for number, side in enumerate(SIDES[: 2 * len(low)]):
        axis, end = number // 2, number % 2
        spec = getattr(scene.tank, side)
        if spec.kind == "open" or spec.motion is not None:
            corners[end, axis] = (high if end else low)[axis]
    periodic = [getattr(scene.tank, side).kind == "periodic" for side in SIDES[: 2 * len(low) : 2]]
    return Filled(scene.spacing, corners[0].tolist(), corners[1].tolist(), periodic)


def _mover_colors(scene: Any, low: Array) -> list[str | None]:
    """The colors of bodies, line by line; moving sides come after them, and have none."""
    lines = [1 if len(low) == 2 else BALL_LINES if body.radius is not None else BOX_LINES for body in scene.bodies]
    return [body.color for body, count in zip(scene.bodies, lines, strict=True) for _ in range(count)]


def _painted(lines: list[Line], color: str | None) -> list[Line]:
    return [line._replace(color=color) for line in lines]


def _joined(lines: list[Line | list[Line]]) -> list[Line]:
    return list(itertools.chain.from_iterable(one if isinstance(one, list) else [one] for one in lines))


def _tank_lines(scene: Any, low: Array, high: Array) -> list[Line | list[Line]]:
    """Walls; dashed where what leaves comes back at the other side; nothing where all is open."""
    kinds = {side: getattr(scene.tank, side).kind for side in SIDES[: 2 * len(low)]}
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
    """An obstacle; three circles for a ball in 3D."""
    if solid.radius is not None:
        return _ball(np.array(solid.center), solid.radius)
    if solid.vertices:
        return [Line(np.array(solid.vertices), closed=True)]
    low, high = np.array(solid.low), np.array(solid.high)
    return [Line(rectangle(low, high), closed=True)] if len(low) == 2 else [Line(edge) for edge in edges_of(low, high)]


def _ball(middle: Array, radius: float) -> list[Line]:
    if len(middle) == 2:
        return [Line(circle(middle, radius), closed=True)]
    flat = np.column_stack([circle(np.zeros(2), radius), np.zeros(len(ROUND))])
    return [Line(middle + np.roll(flat, turn, axis=1), closed=True) for turn in range(BALL_LINES)]


def _body(body: Any, number: int, frame: Frame) -> list[Array]:
    """A body where it is; a round one with a spoke, so that its turning shows."""
    shape, name = shape_of(body), f"body{number}_"
    middle = np.array([frame.numbers[name + axis] for axis in "xyz"[: len(shape.middle())]])
    if len(middle) == 2:
        turn = rotation(frame.numbers[name + "angle"])
        lines = [np.vstack([circle(np.zeros(2), body.radius), np.zeros(2)])] if body.radius is not None else None
        return [middle + line @ turn.T for line in lines or [one.points for one in _solid_of(shape)]]
    turn = turned([frame.numbers[f"{name}q{part}"] for part in "wxyz"])
    parts = [one.points for one in _ball(np.zeros(3), body.radius)] if body.radius is not None else edges(shape)
    return [middle + part @ turn.T for part in parts]


def _solid_of(shape: Any) -> list[Line]:
    if hasattr(shape, "vertices"):
        return [Line(shape.vertices, closed=True)]
    low, high = shape.bounds()
    return [Line(rectangle(low, high), closed=True)]


def tracers_stage(scene: Any, sample: Sequence[Frame]) -> Stage:
    """The tank, obstacles and openings."""
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
