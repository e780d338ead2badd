"""A liquid in 3D rendered as water: its surface along parallel rays, shaded and translucent, with the solids in it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.image import AxesImage
from scipy.ndimage import map_coordinates

from ecume.engine.rendering import MET, Block, Eye, cast
from ecume.engine.shapes import Shape
from ecume.show.picture import View, edges_of
from ecume.show.sph.liquid import SMOOTHING, SUPPORT, Counts, Grid, Region, grid_in, liquid_in, region_of, room_of
from ecume.show.sph.solids import drawn_shape, shape_of, turned
from ecume.show.style import LIQUID_COLORS
from ecume.show.tank import BODY
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.sph import SphScene

FINE, FINER = 2.0, 8.0
"""The number of cells per spacing, and the largest number of a tank with solids, whose edges a coarse grid rounds."""
SHARP_CELLS = 200_000
"""The number of cells up to which they are finer for solids."""
MOST_CELLS = 4_000_000
MOST_RAYS = 160_000
"""The largest number of rays per picture; the pixels between are interpolated."""
SUN = (-0.35, 0.80, 0.49)
"""The direction of the light, as components right, up, and toward the observer."""
SKY = np.array([0.93, 0.97, 1.0])
"""The color that water reflects."""
FRESNEL = 0.02
"""The part of light that water reflects at normal incidence; Schlick's approximation gives it at other angles."""
CLEAR = 0.35
"""The distance in the liquid after which 1/e of the light is left, over the tank's smallest side."""
CLEAREST = 0.85
"""The fraction of light that passes the thinnest liquid, so that the edges of water are visible."""
SHINE = 60.0
"""The exponent of the highlight."""


class Solid(NamedTuple):
    """An obstacle or a body at its present position."""

    shape: Shape
    """about its middle"""
    middle: Array
    turn: Array
    """(3, 3) from its own axes to those of the tank"""
    color: str


def solids_of(scene: SphScene, frame: Frame) -> list[Solid]:
    """Obstacles, and bodies at their positions in the frame."""
    drawn = [(drawn_shape(one), color_of(one)) for one in scene.obstacles if not one.hollow]
    found = [Solid(shape.carried(-shape.middle()), shape.middle(), np.eye(3), color) for shape, color in drawn]
    for name, body in zip(scene.body_names, scene.bodies, strict=True):
        at = {part: frame.numbers[f"{name}_{part}"] for part in ("x", "y", "z", "qw", "qx", "qy", "qz")}
        turn = turned([at[f"q{part}"] for part in "wxyz"])
        found.append(Solid(shape_of(body), np.array([at[axis] for axis in "xyz"]), turn, color_of(body)))
    return found


def color_of(solid: Any) -> str:
    """The color of a solid: the given one, or the default."""
    return str(solid.color or BODY)


def solid_level(solids: list[Solid], grid: Grid) -> tuple[Array, Counts]:
    """The depth inside the nearest solid in every cell (m; negative outside), and the index of this solid."""
    depths = [_depth(one, grid.points(), float(grid.cell.max())) for one in solids]
    if not depths:
        return np.zeros((0, 0, 0)), np.zeros((0, 0, 0), np.int64)
    stacked = np.array(depths)
    return stacked.max(axis=0).reshape(grid.shape), stacked.argmax(axis=0).reshape(grid.shape)


def _depth(solid: Solid, points: Array, margin: float) -> Array:
    """The depth (N,) of points in a solid; for points outside its bounding box, minus their distance from the box."""
    own = (points - solid.middle) @ solid.turn
    low, high = solid.shape.bounds()
    depth: Array = -np.maximum(low - own, own - high).max(axis=1)
    near = depth > -margin
    depth[near] = -solid.shape.nearest(own[near])[0]
    return depth


class Scenery(NamedTuple):
    """The surroundings in a picture of water."""

    region: Region
    grid: Grid
    solid: Array
    which: Counts
    colors: Array
    """(solids, 3)"""


def scenery_of(scene: SphScene, frame: Frame, values: Array) -> Scenery:
    """The fields of a frame; values (N, k) are interpolated."""
    liquid = liquid_in(frame, scene.spacing, values)
    low, high = room_of(scene, frame, liquid.position)
    if len(liquid.position) and not scene.obstacles and not scene.bodies:
        reach = SUPPORT * SMOOTHING * scene.spacing
        low = np.maximum(low, liquid.position.min(axis=0) - reach)
        high = np.minimum(high, liquid.position.max(axis=0) + reach)
    solids = solids_of(scene, frame)
    for solid in solids:  # solids above the liquid are included
        ends = solid.middle + np.concatenate(edges_of(*solid.shape.bounds())) @ solid.turn.T
        low = np.minimum(low, np.maximum(ends.min(axis=0), scene.tank.low))
        high = np.maximum(high, np.minimum(ends.max(axis=0), scene.tank.high))
    size = size_of_cells(scene.spacing, float(np.prod(high - low)), sharp=bool(solids))
    kinds = [getattr(scene.tank, side).kind for side in scene.sides]
    grid = grid_in(low, high, size, [kinds[2 * axis] == "periodic" for axis in range(3)])
    depth, which = solid_level(solids, grid)
    inside = (lambda points: depth.ravel() > 0.0) if solids else None
    colors = np.array([to_rgb(one.color) for one in solids]).reshape(-1, 3)
    return Scenery(region_of(liquid, grid, scene.spacing, inside), grid, depth, which, colors)


def size_of_cells(spacing: float, volume: float, *, sharp: bool) -> float:
    """The size of cells (m) that fill a volume (m^3); they are smaller where solids need sharp edges."""
    usual: float = max(spacing / FINE, (volume / MOST_CELLS) ** (1.0 / 3.0))
    sharper: float = max(spacing / FINER, (volume / SHARP_CELLS) ** (1.0 / 3.0))
    return min(usual, sharper) if sharp else usual


def seen_along(scenery: Scenery, camera: Array, view: View, shape: tuple[int, int]) -> Array:
    """The records of the rays of a picture, (rows, columns, MET)."""
    grid = scenery.grid
    block = Block(
        np.ascontiguousarray(scenery.region.level, np.float32), np.ascontiguousarray(scenery.solid, np.float32),
        grid.low, grid.high, grid.cell,
    )  # fmt: skip
    rows, columns = shape
    across = view.left + view.width * (np.arange(columns) + 0.5) / columns
    up = view.bottom + view.height * (np.arange(rows) + 0.5) / rows
    met = np.zeros((rows, columns, MET))
    cast(block, Eye(across, up, np.ascontiguousarray(camera), nearest_of(grid, camera)), met)
    return met


def nearest_of(grid: Grid, camera: Array) -> float:
    """The coordinate of the nearest point of the block toward the observer (m)."""
    farthest: Array = np.where(camera[2] > 0.0, grid.high, grid.low)
    return float(farthest @ camera[2]) + float(grid.cell.max())


def painted(
    scenery: Scenery, met: Array, camera: Array, view: View, colors: Callable[[Array], Array] | None, water: str
) -> Array:
    """The picture (rows, columns, 4), from 0 to 1: translucent water, or a surface in the colors of a quantity."""
    wet, hard = np.isfinite(met[..., 0]), np.isfinite(met[..., 1])
    pixels = np.zeros((*met.shape[:2], 4))
    behind = np.ones((*met.shape[:2], 3))
    if hard.any():
        places = points_at(scenery, met, camera, view, 1)[hard]
        own = scenery.colors[_nearest(scenery.which, places, scenery.grid)]
        behind[hard] = own * (0.45 + 0.55 * np.clip(met[hard][:, 6:7], 0.0, 1.0))
        pixels[hard] = np.column_stack([behind[hard], np.ones(int(hard.sum()))])
    if wet.any():
        body = np.array(to_rgb(water))
        if colors is not None:
            places = points_at(scenery, met, camera, view, 0)[wet]
            means = [_linear(field, places, scenery.grid) for field in np.moveaxis(scenery.region.values, -1, 0)]
            body = np.asarray(colors(np.stack(means, -1)))[:, :3]
        pixels[wet, :3] = lit(met[wet], camera, behind[wet], body, clear_of(scenery.grid), opaque=colors is not None)
        pixels[wet, 3] = 1.0
    return pixels


def clear_of(grid: Grid) -> float:
    """The distance (m) in the liquid after which 1/e of the light remains."""
    return CLEAR * float((grid.high - grid.low).min())


def lit(met: Array, camera: Array, behind: Array, body: Array, clear: float, *, opaque: bool) -> Array:
    """The colors of a liquid's surface: the background, absorbed along the path, with reflections and a highlight."""
    normal = met[:, 3:6] @ camera.T
    facing = np.clip(normal[:, 2:3], 0.0, 1.0)
    sun = np.array(SUN) / np.linalg.norm(SUN)
    light = np.clip(normal @ sun, 0.0, 1.0)[:, None]
    between = sun + np.array([0.0, 0.0, 1.0])
    half = between / np.linalg.norm(between)
    shine = 0.45 * np.clip(normal @ half, 0.0, 1.0)[:, None] ** SHINE
    if opaque:
        shaded = body * (0.5 + 0.5 * light) + 0.4 * shine
    else:
        # The absorption of each color is proportional to its complement in the color of the liquid.
        passed = CLEAREST * np.exp(-met[:, 2:3] / clear * (1.15 - body))
        through = behind * passed + body * (1.0 - passed.mean(axis=1, keepdims=True)) * 0.55
        shaded = through * (0.72 + 0.28 * light)
        reflected = FRESNEL + (1.0 - FRESNEL) * (1.0 - facing) ** 5
        shaded = shaded * (1.0 - reflected) + SKY * reflected + shine
    return np.asarray(np.clip(shaded, 0.0, 1.0))


def points_at(scenery: Scenery, met: Array, camera: Array, view: View, which: int) -> Array:
    """The points (rows, columns, 3) where rays meet the liquid (0) or a solid (1); far away for rays that miss them."""
    rows, columns = met.shape[:2]
    across = view.left + view.width * (np.arange(columns) + 0.5) / columns
    up = view.bottom + view.height * (np.arange(rows) + 0.5) / rows
    toward = nearest_of(scenery.grid, camera) - np.where(np.isfinite(met[..., which]), met[..., which], 0.0)
    points: Array = across[None, :, None] * camera[0] + up[:, None, None] * camera[1] + toward[..., None] * camera[2]
    return points


def _linear(field: Array, places: Array, grid: Grid) -> Array:
    found: Array = np.zeros(len(places))
    map_coordinates(field, ((places - grid.low) / grid.cell - 0.5).T, output=found, order=1, mode="nearest")
    return found


def _nearest(field: Counts, places: Array, grid: Grid) -> Counts:
    index = np.clip(((places - grid.low) / grid.cell).astype(np.int64), 0, np.array(grid.shape) - 1)
    return np.asarray(field[tuple(index.T)])


class WaterImage:
    """The image of a liquid in 3D in axes; `put` shows a frame."""

    def __init__(self, axes: Axes, scene: SphScene, camera: Array, view: View) -> None:
        self.axes, self.scene, self.camera, self.view = axes, scene, camera, view
        self.color = water_color(scene)
        ends = (axes.get_xlim(), axes.get_ylim())
        self.image: AxesImage = axes.imshow(
            np.zeros((2, 2, 4)),
            origin="lower",
            interpolation="bilinear",
            aspect="auto",
            zorder=3,
            extent=(view.left, view.right, view.bottom, view.top),
        )
        axes.set(xlim=ends[0], ylim=ends[1])

    def put(self, frame: Frame, values: Array, colors: Callable[[Array], Array] | None) -> None:
        """Draw a frame; without colors the liquid is translucent."""
        scenery = scenery_of(self.scene, frame, values)
        met = seen_along(scenery, self.camera, self.view, self._shape())
        self.image.set_data(painted(scenery, met, self.camera, self.view, colors, self.color))

    def _shape(self) -> tuple[int, int]:
        """Rows and columns of rays: one per pixel, or fewer."""
        box = self.axes.bbox
        part = min(1.0, (MOST_RAYS / max(box.width * box.height, 1.0)) ** 0.5)
        return max(2, round(part * box.height)), max(2, round(part * box.width))


def water_color(scene: SphScene) -> str:
    """The color of the first region that has one, or of the substance."""
    named = [part.color for part in scene.fluid if part.color]
    return named[0] if named else LIQUID_COLORS.get(scene.liquid.name or "water", LIQUID_COLORS["water"])
