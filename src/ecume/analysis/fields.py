"""Liquids in frames: fields at gauges, on grids and along lines, pressures, the free surface, and where energy goes.

Gauges: what a probe at a place, a sensor on a wall or a gauge of the water level would read in a frame of particles.
A value at a point is the mean of the particles near it, weighed by kernel and volume. `reach` (m) is how far a
particle may be, the kernel's support: four spacings is usual in 2D, three to four in 3D.

The free surface of a liquid: its outline, its front, and how high it stands.

Gauge, hydrostatic, dynamic and absolute pressure of tanks; `ecume.models.sph.report.observation` defines them.

Frames hold the gauge pressure; the others follow from it, the position and the scene.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from contourpy import contour_generator
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ecume.analysis.series import number, series, times
from ecume.engine.cells import Sides, images_of, positions_of_images
from ecume.engine.interpolation import Near, added, dry, means, near, planes
from ecume.engine.shapes import Flags
from ecume.errors import BadInput
from ecume.laws.kernels import kernel
from ecume.models.invariants import INJECTED
from ecume.scenes.quantities import SIDES
from ecume.scenes.sph import TankSpec
from ecume.trajectories.frame import Frame, omitted_from
from ecume.units import Array, Length

KERNEL = "wendland-c2"


def points_along(start: Sequence[float], end: Sequence[float], count: int) -> Array:
    """Points (count, d) at equal distances from one end to the other, in m.

    >>> points_along((0.0, 0.0), (1.0, 0.0), 3).tolist()
    [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]]
    """
    return np.linspace(np.asarray(start, dtype=float), np.asarray(end, dtype=float), count)


def filled(frame: Frame, points: Array, reach: Length) -> Array:
    """The filled fraction of each point's surroundings: 1 inside, 1/2 at a surface or a wall, 0 outside."""
    return added(*_near(frame, points, reach))


def values_at(frame: Frame, name: str, points: Array, reach: Length) -> Array:
    """An array of the frame, interpolated at points, of shape (points, ...); NaN outside of the
    liquid.

    Shepard's mean, sum_j V_j f_j W_j / sum_j V_j W_j. It is between the least and the largest value of the neighbors;
    at a surface or a wall it is the value at some depth in the liquid.
    """
    return means(*_near(frame, points, reach), _array_of(frame, name))


def linear_values_at(frame: Frame, name: str, points: Array, reach: Length) -> Array:
    """An array of the frame at points, by linear fits to the neighbors: exact for linear fields, up to walls and
    surfaces.

    With too few neighbors for a gradient, the mean of `values_at`.
    """
    return planes(*_near(frame, points, reach), _array_of(frame, name))


def wall_pressure(frame: Frame, sensor: Array, reach: Length) -> float:
    """The reading of a pressure sensor in a wall (Pa): the mean over its face, `sensor` being points on it (n, d).

    Zero where the face is dry; a liquid that has not come pushes nothing. A frame does not contain the walls, so that
    points near few particles count as covered; gauges of a scene know which part of a point is covered.
    """
    found = _near(frame, np.atleast_2d(sensor), reach)
    pressure = planes(*found, _array_of(frame, "pressure"))
    return float(np.where(dry(*found), 0.0, pressure).mean())


def water_level(frame: Frame, places: Array, reach: Length) -> Array:
    """The depth of the water above each place of the floor (m): the volume of liquid over the area
    of the floor.

    Places are (n,) along x in 2D, (n, 2) along x and z in 3D (y points up). Air bubbles do not count as water. Nearer
    to a wall than `reach`, water is missed that the wall cuts off.
    """
    position = frame.arrays["position"]
    level = np.delete(position, 1, axis=1)
    return added(*_near(frame, np.asarray(places, dtype=float).reshape(-1, level.shape[1]), reach, level))


def wave_amplitude(frame: Frame, wavenumber: float, length: Length) -> float:
    """The amplitude of the wave cos(k x) in a tank of this length (m), from the liquid's distribution along x.

    (2/L) sum_j V_j cos(k x_j), which is (2/L) times the integral of the level times cos(k x); in 2D.
    """
    volume = frame.arrays["mass"] / frame.arrays["density"]
    return float(2.0 / length * (volume @ np.cos(wavenumber * frame.arrays["position"][:, 0])))


def _near(frame: Frame, points: Array, reach: Length, position: Array | None = None) -> tuple[Near, Array]:
    """The particles near each point, and the weight of each pair: volume times kernel."""
    position = frame.arrays["position"] if position is None else position
    points = np.asarray(points, dtype=float)
    if not reach > 0.0:
        raise BadInput(f"reach: got {reach:g} m; expected the kernel's support, about four spacings")
    if points.ndim != 2 or points.shape[1] != position.shape[1]:
        raise BadInput(f"points: got shape {points.shape}; expected (points, {position.shape[1]})")
    shape = kernel(KERNEL, dim=position.shape[1])
    pairs = near(points, position, reach)
    volume = frame.arrays["mass"] / frame.arrays["density"]
    return pairs, volume[pairs.particle] * shape.value(pairs.distance, reach / shape.support)


def _array_of(frame: Frame, name: str) -> Array:
    if name not in (*frame.arrays, *omitted_from(frame)):
        raise BadInput(f"the frames have no array {name!r}; they have {', '.join(sorted(frame.arrays))}")
    return np.asarray(frame.arrays[name], dtype=float)


MOST_POINTS = 10_000_000


class Grid(NamedTuple):
    """The nodes of a regular grid, as one array of coordinates per axis (m)."""

    axes: tuple[Array, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """The number of nodes along each axis."""
        return tuple(len(axis) for axis in self.axes)

    @property
    def points(self) -> Array:
        """The nodes (n, d); the last axis varies fastest."""
        return np.stack([axis.ravel() for axis in np.meshgrid(*self.axes, indexing="ij")], axis=1)


def grid_over(low: Sequence[float], high: Sequence[float], spacing: Length) -> Grid:
    """A grid between two corners, whose nodes are at most a spacing apart.

    >>> grid_over((0.0, 0.0), (1.0, 0.5), 0.25).shape
    (5, 3)
    """
    if not spacing > 0.0 or any(b <= a for a, b in zip(low, high, strict=True)):
        raise BadInput(f"a grid from {tuple(low)} to {tuple(high)} every {spacing:g} m has no nodes")
    counts = [int(np.ceil((b - a) / spacing - 1e-9)) + 1 for a, b in zip(low, high, strict=True)]
    if np.prod(np.array(counts, dtype=float)) > MOST_POINTS:
        raise BadInput(f"a grid of {' x '.join(map(str, counts))} nodes has more than {MOST_POINTS:.0e}")
    return Grid(tuple(np.linspace(a, b, count) for a, b, count in zip(low, high, counts, strict=True)))


def on_grid(frame: Frame, name: str, grid: Grid, reach: Length) -> Array:
    """An array of the frame at the grid's nodes, of shape (*grid.shape, ...): Shepard's mean of the particles within
    `reach`, NaN outside of the liquid.
    """
    values = values_at(frame, name, grid.points, reach)
    return values.reshape(*grid.shape, *values.shape[1:])


def linear_on_grid(frame: Frame, name: str, grid: Grid, reach: Length) -> Array:
    """An array of the frame at the grid's nodes, by linear fits: exact for linear fields, up to walls and surfaces."""
    values = linear_values_at(frame, name, grid.points, reach)
    return values.reshape(*grid.shape, *values.shape[1:])


def filled_on_grid(frame: Frame, grid: Grid, reach: Length) -> Array:
    """The filled fraction of each node's surroundings, shape grid.shape."""
    return filled(frame, grid.points, reach).reshape(grid.shape)


class Profile(NamedTuple):
    """Values along a line."""

    along: Array
    """(n,) the distance from the line's start (m)"""
    points: Array
    """(n, d)"""
    values: Array
    """(n, ...), NaN outside of the liquid"""


def profile_along(
    frame: Frame, name: str, ends: tuple[Sequence[float], Sequence[float]], count: int, reach: Length
) -> Profile:
    """An array of the frame at points from one end of a line to the other, by linear fits."""
    points = points_along(*ends, count)
    return Profile(np.linalg.norm(points - points[0], axis=1), points, linear_values_at(frame, name, points, reach))


def velocity_profile(frame: Frame, ends: tuple[Sequence[float], Sequence[float]], count: int, reach: Length) -> Profile:
    """The velocity along a line, (n, d) in m/s."""
    return profile_along(frame, "velocity", ends, count, reach)


ENERGIES = ("J", "J/m")
"""Units of energies: of a 2D tank they are per meter of depth."""


def energy_budget(frames: Iterable[Frame]) -> Mapping[str, Array]:
    """Each kind of energy over time (J; J/m in 2D), and the energy lost since the first frame.

    Keys: `time` (s), every energy of the frames, `lost`, and `dissipated`: the lost energy plus the injected work.
    """
    kept = list(frames)
    names = [name for name, unit in kept[0].units.items() if unit in ENERGIES]
    curves = dict(zip(names, series(kept, *map(number, names)), strict=True))
    lost, work = curves["total_energy"][0] - curves["total_energy"], curves.get(INJECTED, np.zeros(len(kept)))
    return {"time": times(kept), **curves, "lost": lost, "dissipated": lost + work - work[0]}


TOGETHER = 1.6
"""The largest distance, in spacings, of connected particles of a liquid."""


def front_position(frame: Frame, spacing: Length, *, below: Length = np.inf) -> float:
    """The largest x of the liquid (m), measured at its edge; separate drops do not count. Only the part below the
    height `below`, along y, is included.
    """
    position = frame.arrays["position"]
    near = largest_piece(position, spacing) & (position[:, 1] < below)
    if not near.any():
        raise BadInput(f"no liquid below {below:g} m")
    return float(position[near, 0].max()) + 0.5 * spacing


def largest_piece(position: Array, spacing: Length) -> Flags:
    """Flags (N,) of the particles of the largest connected piece of liquid."""
    pairs = cKDTree(position).query_pairs(TOGETHER * spacing, output_type="ndarray")
    count = len(position)
    graph = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    _, piece = connected_components(graph, directed=False)
    mine: Flags = piece == np.bincount(piece).argmax()
    return mine


def level_by_column(frame: Frame, edges: Array) -> Array:
    """The depth of the liquid in each column if it were at rest (m): its volume over the area of
    the column.

    `edges` are those of the columns along x, one more than columns, in 2D.
    """
    if np.any(np.diff(edges) <= 0.0):
        raise BadInput("edges of columns must grow from one to the next")
    volume = frame.arrays["mass"] / frame.arrays["density"]
    found, _ = np.histogram(frame.arrays["position"][:, 0], edges, weights=volume)
    depth: Array = found / np.diff(edges)
    return depth


def top_by_column(frame: Frame, edges: Array, spacing: Length) -> Array:
    """The highest point of the liquid along y in each column (m), including spray; NaN in empty columns."""
    position = frame.arrays["position"]
    column = np.digitize(position[:, 0], edges) - 1
    tops = np.full(len(edges) - 1, -np.inf)
    inside = (column >= 0) & (column < len(tops))
    np.maximum.at(tops, column[inside], position[inside, 1] + 0.5 * spacing)
    return np.where(np.isfinite(tops), tops, np.nan)


HALF = 0.5
REACH = 4.0
"""The range of a particle's kernel, in spacings."""
FINE = 0.5
"""The spacing of the grid, in spacings of particles."""


class Walls(NamedTuple):
    """The corners of a tank (m); infinite at open sides. The liquid has no surface at a wall."""

    low: Array
    high: Array


def walls_of(tank: TankSpec) -> Walls:
    """The walls of a scene's tank, in 3D where y points up."""
    low, high = np.array(tank.low, dtype=float), np.array(tank.high, dtype=float)
    for index, side in enumerate(SIDES[: 2 * len(low)]):
        if getattr(tank, side).kind == "open":
            (low if index % 2 == 0 else high)[index // 2] = -np.inf if index % 2 == 0 else np.inf
    return Walls(low, high)


def free_surface(frame: Frame, spacing: Length, walls: Walls | None = None) -> list[Array]:
    """The outline of a liquid in 2D as lines, (K, 2) each, in m; a closed one ends where it begins.

    A contour of the kernel's sum, at one half. The liquid is mirrored at walls, so that no line runs along them.
    """
    position = frame.arrays["position"]
    if position.shape[1] != 2:
        raise BadInput(f"an outline needs frames in 2D; these frames have {position.shape[1]} dimensions")
    if not len(position):
        return []
    reach, room = REACH * spacing, 1.5 * REACH * spacing
    low, high = position.min(axis=0) - room, position.max(axis=0) + room
    if walls is not None:
        low, high = np.maximum(low, walls.low), np.minimum(high, walls.high)
    grid = grid_over(low, high, FINE * spacing)
    field = filled_on_grid(frame if walls is None else mirrored(frame, walls, reach), grid, reach)
    lines = contour_generator(grid.axes[0], grid.axes[1], field.T).lines(HALF)
    return [np.asarray(line, dtype=float) for line in lines]


def mirrored(frame: Frame, walls: Walls, reach: Length) -> Frame:
    """The frame with images of its particles behind walls closer than the reach."""
    sides = _sides(walls)
    position = frame.arrays["position"].T
    images = images_of(position, sides, reach)
    source = images.source.copy()
    # An image may be the image of an image: each is followed back to its particle.
    while (late := source >= position.shape[1]).any():
        source[late] = source[source[late] - position.shape[1]]
    arrays = {name: np.concatenate([array, array[source]]) for name, array in frame.arrays.items()}
    positions = np.concatenate([position, positions_of_images(position, images, sides)], axis=1)
    return frame.with_arrays({**arrays, "position": np.ascontiguousarray(positions.T)})


def _sides(walls: Walls) -> Sides:
    """The walls as mirrors."""
    dimension = len(walls.low)
    rows = [
        (axis, corner, sign) for corner, sign in ((walls.low, 1.0), (walls.high, -1.0)) for axis in range(dimension)
    ]
    kept = [(axis, corner[axis], sign) for axis, corner, sign in rows if np.isfinite(corner[axis])]
    point, normal = np.zeros((len(kept), dimension)), np.zeros((len(kept), dimension))
    for row, (axis, place, sign) in enumerate(kept):
        point[row, axis], normal[row, axis] = place, sign
    return Sides(point, normal, np.zeros_like(point), np.ones(len(kept), np.int64))


def with_pressures(scene: Any) -> Callable[[Frame], Frame]:
    """A function that adds `hydrostatic_pressure`, `dynamic_pressure` and `absolute_pressure` (Pa) to frames of a tank.
    Frames of other models stay as they are.

    >>> import ecume, numpy as np
    >>> scene = ecume.from_plain({"model": "sph", "duration": 0.1, "frame_every": 0.1, "spacing": 0.1,
    ...     "liquid": {"atmospheric_pressure": 101325.0},
    ...     "tank": {"high": [1.0, 1.0]}, "fluid": [{"low": [0.0, 0.0], "high": [1.0, 0.5]}]})
    >>> frame = Frame(0.0, {"position": np.array([[0.5, 0.1]]), "pressure": np.array([4000.0])}, {}, {})
    >>> arrays = with_pressures(scene)(frame).arrays
    >>> {name: round(float(arrays[name][0]), 6) for name in sorted(arrays) if name != "position"}
    {'absolute_pressure': 105325.0, 'dynamic_pressure': 76.0, 'hydrostatic_pressure': 3924.0, 'pressure': 4000.0}
    """
    if scene.model != "sph":
        return lambda frame: frame
    from ecume.models.sph.report.observation import PRESSURES, reference_of

    reference = reference_of(scene)

    def added(frame: Frame) -> Frame:
        gauge, position = frame.arrays["pressure"], frame.arrays["position"]
        found = {name: kind(reference, gauge, position) for name, kind in PRESSURES.items() if name != "pressure"}
        return frame._replace(arrays={**frame.arrays, **found}, units={**frame.units, **dict.fromkeys(found, "Pa")})

    return added
