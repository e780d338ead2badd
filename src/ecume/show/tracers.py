"""Pictures and figures of tracers."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from ecume.analysis.dispersion import present
from ecume.analysis.series import inside, number, series, times
from ecume.engine.walls import Surfaces
from ecume.errors import BadInput
from ecume.models.tracers.tank import body_of, copies_of, inside_of
from ecume.show.curves import Frames, displacement, energies, evolution, over_time, titled
from ecume.show.picture import STANDING, USUAL, Eye, Size, Wires, species, wires_of
from ecume.show.style import PALETTE, binned, figure, legend_outside, plain, scale_for, style
from ecume.show.tank import Round, Setting, Shape, Tank, seen
from ecume.show.tracer_measures import MEASURES, time_label
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.tracers import TankSpec, TracersScene

SLICES = 30
"""The number of slices of a profile."""


def setting_of(scene: TracersScene) -> Setting:
    """The setting of a scene with tank, obstacles and openings; in 3D a side view."""
    bodies = [outline_of(body) for body in scene.obstacles]
    gaps = [seen(np.array([hole.low, hole.high])) for hole in scene.openings]
    outline = outline_of(scene.tank) if scene.tank is not None else None
    return Setting(scene.title, outline, [body for body in bodies if body is not None], gaps, species(scene))


def outline_of(shape: Any) -> Shape | None:
    if (low := getattr(shape, "low", None)) is not None:
        return _rectangle(np.array(low), np.array(shape.high))
    if shape.vertices:
        corners: Array = np.array(shape.vertices)
        return corners if corners.shape[1] == 2 else _rectangle(corners.min(axis=0), corners.max(axis=0))
    center = getattr(shape, "center", None) or (0.0, 0.0)
    return Round(center[0], center[-1], shape.radius)


def _rectangle(low: Array, high: Array) -> Array:
    (left, bottom), (right, top) = seen(low[None])[0], seen(high[None])[0]
    return np.array([(left, bottom), (right, bottom), (right, top), (left, top)])


class TracersTank(Tank):
    """A tank whose particles vanish when they leave through an opening; those that adhere to walls remain."""

    def _fill(self, frame: Frame) -> None:
        there = present(frame)
        super()._fill(frame.with_arrays({name: array[there] for name, array in frame.arrays.items()}))


def tracers_picture(scene: TracersScene, sample: Sequence[Frame], size: Size = USUAL, eye: Eye | None = None) -> Tank:
    """The tank from the side, or in 3D from a camera; each species in its color."""
    kind = TracersTank if scene.openings else Tank
    if eye is None:
        return kind(setting_of(scene), sample, size)
    if sample[0].arrays["position"].shape[1] != 3:
        raise BadInput("got azimuth or elevation for a 2D scene; expected a 3D scene, or neither of them")
    return kind(setting_in_space(scene, eye), sample, size)


def setting_in_space(scene: TracersScene, eye: Eye) -> Setting:
    """The visible edges of tank and obstacles; round ones are shown as their bounding box."""
    camera = eye.camera(STANDING)
    tank = wires_of(*_box_around(scene.tank), camera) if scene.tank is not None else Wires([], [])
    solids = [edge for body in scene.obstacles for part in wires_of(*_box_around(body), camera) for edge in part]
    holes = [hole for opening in scene.openings for hole in wires_of(opening.low, opening.high, camera).front]
    wires = [*tank.front, *solids, *holes]
    return Setting(scene.title, None, kinds=species(scene), wires=wires, behind=tank.behind, camera=camera)


def _box_around(shape: Any) -> tuple[Array, Array]:
    """The lowest and the highest corner of a 3D tank."""
    if (low := getattr(shape, "low", None)) is not None:
        return np.array(low), np.array(shape.high)
    if shape.vertices:
        return np.min(shape.vertices, axis=0), np.max(shape.vertices, axis=0)
    center = np.array(getattr(shape, "center", None) or (0.0, 0.0, 0.0))
    return center - shape.radius, center + shape.radius


def _mean_height(frame: Frame, index: int) -> float:
    heights = frame.arrays["position"][inside(frame) & (frame.arrays["species"] == index), -1]
    return float(heights.mean()) if len(heights) else np.nan


def heights(frames: Frames, scene: TracersScene) -> Figure:
    """The mean height of each species over time."""
    shown = evolution(frames)
    kinds = species(scene)
    curves = [[_mean_height(frame, index) for frame in shown] for index in range(len(kinds))]
    scale = scale_for(float(np.nanmax(np.abs(curves), initial=0.0)), "m")
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Mean height of each species")
        for kind, curve in zip(kinds, curves, strict=True):
            axes.plot(times(shown), scale.factor * np.array(curve), color=kind.color, label=plain(kind.name))
        axes.set_ylabel(f"mean height ({scale.unit})")
        if not np.nanmin(curves, initial=0.0) < 0.0:
            axes.set_ylim(bottom=0.0)
        legend_outside(axes)
    return drawn


def profile(frames: Frames, scene: TracersScene) -> Figure:
    """The distribution of particles over the height at the beginning, in the middle and at the end."""
    instants = [frames[0], frames[len(frames) // 2], frames[-1]]
    places = [frame.arrays["position"][inside(frame), -1] for frame in instants]
    values = np.concatenate(places)
    if not len(values):
        raise BadInput("all particles have left the tank; no profile to draw")
    scale = scale_for(float(np.abs(values).max()), "m")
    edges = np.linspace(values.min(), max(values.max(), values.min() + 1e-12), SLICES + 1)
    with style():
        drawn = figure()
        axes = drawn.add_subplot(xlabel="particles in a slice", title=titled("Number of particles over height", scene))
        for frame, place, color in zip(instants, places, PALETTE, strict=False):
            counts, _ = np.histogram(place, edges)
            binned(axes, counts, scale.factor * edges, upward=True, color=color, label=time_label(frame.time))
        axes.set_ylabel(f"height ({scale.unit})")
        legend_outside(axes)
    return drawn


SIDES = {2: ("left", "floor", "right", "ceiling"), 3: ("left", "front", "floor", "right", "back", "ceiling")}
"""The sides of a box by its dimensions: the lower sides of all axes, then the upper ones."""


def wall_names(scene: TracersScene) -> list[str]:
    """The names of the walls of a tank and of the faces of its obstacles, in the order of their numbers."""
    tank = (
        []
        if scene.tank is None
        else _sides(scene.tank, scene.dimensions)
        if scene.tank.high is not None
        else _faces(inside_of(scene.tank), 0, "wall")
    )
    bodies = [
        _faces(body_of(body), scene.dimensions if body.low is not None else 0, f"obstacle {number}")
        for number, body in enumerate(scene.obstacles, 1)
        for _ in copies_of(scene)
    ]
    return [*tank, *itertools.chain.from_iterable(bodies)]


def _sides(tank: TankSpec, dimensions: int) -> list[str]:
    """The names of the sides of a box that are walls."""
    return [side for k, side in enumerate(SIDES[dimensions]) if "xyz"[k % dimensions] not in tank.periodic]


def _faces(surfaces: Surfaces, dimension: int, name: str) -> list[str]:
    """The names of the faces of a box of this dimension, or with 0 those of another shape."""
    count = len(surfaces.kind)
    if dimension:
        return [f"{name}, {side}" for side in SIDES[dimension]]
    return (
        [name]
        if count == 1
        else [f"{name} {k}" if name == "wall" else f"{name}, face {k}" for k in range(1, count + 1)]
    )


def wall_hits(frames: Frames, scene: TracersScene) -> Figure:
    """The number of hits of each wall until each time."""
    shown = evolution(frames)
    names = [name for name in shown[0].numbers if name.startswith("hits_on_wall_")]
    if not names:
        raise BadInput("the scene has no walls; no collisions to draw")
    if not any(shown[-1].numbers[name] for name in names):
        raise BadInput("no wall turned a particle back; no collisions to draw")
    walls = wall_names(scene)
    with style():
        drawn = figure()
        axes = over_time(drawn, scene, "Collisions with walls")
        curves = zip(walls, series(shown, *map(number, names)), itertools.cycle(PALETTE), strict=False)
        for label, counts, color in curves:
            axes.plot(times(shown), counts, color=color, drawstyle="steps-post", label=label)
        axes.set_ylabel("number of collisions")
        # From a single hit to thousands of small bounces: linear up to ten, then logarithmic.
        axes.set_yscale("symlog", linthresh=10.0)
        axes.set_ylim(bottom=0.0)
        legend_outside(axes)
    return drawn


TRACER_FIGURES: Mapping[str, Any] = {
    "energies": energies,
    "displacement": displacement,
    "heights": heights,
    "profile": profile,
    "hits": wall_hits,
    **MEASURES,
}
