"""The scenery on the page by model: walls, dish, surface, contacts; `STAGES` is the table of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ecume.analysis.boxes import box_of
from ecume.engine.walls import enclosures
from ecume.models.floating.walls.shapes import walls_of
from ecume.scenes.soft.walls import SIDES as WALL_SIDES
from ecume.show.camera import edges_of
from ecume.show.floating.bowl import height_colors, height_ticks, view_of
from ecume.show.floating.shapes import outlines_in
from ecume.show.floating.surface import sheet, surface, typical_meniscus
from ecume.show.picture import species
from ecume.show.soft.packing import WIDE, links_of, reached
from ecume.show.sph.picture import rectangle
from ecume.show.style import liquid_color, scale_for
from ecume.show.view.stage import Line, Stage, Surface
from ecume.show.view.tanks import sph_stage, tracers_stage
from ecume.trajectories.frame import Frame
from ecume.units import Array

CELLS = 110
"""Of the surface's picture along its longer side."""


def floating_stage(scene: Any, sample: Sequence[Frame]) -> Stage:
    """The dish and the liquid's surface in it."""
    view = view_of(scene, sample)
    closest = min(float(frame.arrays["radius"].min()) for frame in sample)
    on = sheet(scene, view, cells=CELLS, closest=closest)
    heights = np.array([surface(frame, on) for frame in sample])
    largest = float(np.abs(heights).max())
    scale = scale_for(largest, "m")
    tint = liquid_color(scene.liquid)
    colors = height_colors(largest * scale.factor, typical_meniscus(sample[0], on) * scale.factor, tint)
    shown, ticks = _marks(colors.norm, scale.factor * float(heights.min()), scale.factor * float(heights.max()))
    shapes, walls = on.shapes, walls_of(scene.dish)
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
        movers=None if shapes is None else lambda frame: [closed(one) for one in outlines_in(frame, shapes)],
        inner=None if shapes is None else np.array([np.hypot(*one.T).min() for one in shapes.outlines]),
    )  # fmt: skip


def _borders(scene: Any) -> list[Line]:
    """The rim of the dish, or the outline of the periodic cell."""
    if scene.dish is not None:
        return [Line(enclosures.outline(walls_of(scene.dish)), closed=True)]
    if scene.cell is None:
        return []
    return [Line(rectangle(np.zeros(2), np.array(scene.sides)), dashed=True)]


def _marks(norm: Any, lowest: float, highest: float) -> tuple[tuple[float, float], list[tuple[float, str]]]:
    """The part of a scale that occurs, the level included, and its ticks: both from 0 to 1."""

    def place(height: float) -> float:
        return float(np.asarray(norm(np.array([height])))[0])

    ticks = [(place(one), f"{one:g}") for one in height_ticks(norm, (lowest, highest))]
    return (place(min(lowest, 0.0)), place(max(highest, 0.0))), ticks


def closed(points: Array) -> Array:
    """A line that ends where it began."""
    return np.concatenate([points, points[:1]])


def soft_stage(scene: Any, sample: Sequence[Frame]) -> Stage:
    """The periodic box, and contact forces."""
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
    """A wall where it is, as long as what is to be seen."""
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
"""By model: what is around the particles of (scene, some frames of the run)."""
