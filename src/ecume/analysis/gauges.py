"""Gauges: what a probe at a place, a sensor on a wall or a gauge of the water level would read in a frame of particles.

A value at a point is the mean of the particles near it, weighed by kernel and volume. `reach` (m) is how far a particle
may be, the kernel's support: four spacings is usual in a plane, three to four in space.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ecume.errors import BadInput
from ecume.laws.kernels import Kernel, kernel
from ecume.trajectories.frame import Frame
from ecume.units import Array, Length

KERNEL = "wendland-c2"
THIN = 0.05
"""Where less than this part of a point's surroundings is liquid, there is none."""
FEW = 0.01
"""A slope is trusted where neighbors spread this far in every direction, relative to the reach, squared."""


def points_along(start: Sequence[float], end: Sequence[float], count: int) -> Array:
    """Points from one to the other, evenly: shape (count, d), in m.

    >>> points_along((0.0, 0.0), (1.0, 0.0), 3).tolist()
    [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]]
    """
    return np.linspace(np.asarray(start, dtype=float), np.asarray(end, dtype=float), count)


def filled(frame: Frame, points: Array, reach: Length) -> Array:
    """How much of each point's surroundings is liquid: 1 inside, 1/2 at a surface or a wall, 0 outside."""
    parts: Array = _sums(_pairs(frame, points, reach), np.ones(len(frame.arrays["mass"])))
    return parts


def values_at(frame: Frame, name: str, points: Array, reach: Length) -> Array:
    """An array of the frame at points, shape (points, ...); not a number where there is no liquid.

    Shepard's mean, sum_j V_j f_j W_j / sum_j V_j W_j: between the neighbors' least and largest, and at a surface or a
    wall the value some way into the liquid.
    """
    pairs = _pairs(frame, points, reach)
    there = _sums(pairs, np.ones(len(pairs.volume)))
    total = _sums(pairs, _array_of(frame, name))
    found: Array = total / _shaped(np.where(there > THIN, there, np.nan), total)
    return found


def linear_values_at(frame: Frame, name: str, points: Array, reach: Length) -> Array:
    """The same, from the plane that fits the neighbors best: exact for what grows linearly, up to walls and surfaces.

    Where too few neighbors are there to say which way it grows, the mean of `values_at`.
    """
    pairs, values = _pairs(frame, points, reach), _array_of(frame, name)
    means = values_at(frame, name, points, reach)
    for point in range(len(points)):
        neighbor, weight, away = _neighbors(pairs, point)
        if weight.sum() <= THIN:
            continue
        middle = weight @ away / weight.sum()
        spread = (away - middle).T @ (weight[:, None] * (away - middle)) / weight.sum()
        if np.linalg.eigvalsh(spread)[0] > FEW * reach**2:
            moment = (away - middle).T @ (weight[:, None] * values[neighbor].reshape(len(neighbor), -1)) / weight.sum()
            means[point] += (-middle @ np.linalg.solve(spread, moment)).reshape(means[point].shape)
    return means


def wall_pressure(frame: Frame, sensor: Array, reach: Length) -> float:
    """What a pressure sensor in a wall reads (Pa): the mean over its face, `sensor` being points on it (n, d).

    Zero where the face is dry; a liquid that has not come pushes nothing.
    """
    pressure = linear_values_at(frame, "pressure", np.atleast_2d(sensor), reach)
    return float(np.nan_to_num(pressure).mean())


def water_level(frame: Frame, places: Array, reach: Length) -> Array:
    """Depth of the water above each place of the floor (m): the liquid there is, over the area it stands on.

    Places are (n,) along x in a plane, (n, 2) along x and z in space (y points up). Air bubbles do not count as water.
    Nearer to a wall than `reach`, water is missed that the wall cuts off.
    """
    position = frame.arrays["position"]
    level = np.delete(position, 1, axis=1)
    pairs = _pairs(frame, np.asarray(places, dtype=float).reshape(-1, level.shape[1]), reach, level)
    depths: Array = _sums(pairs, np.ones(len(level)))
    return depths


def wave_amplitude(frame: Frame, wavenumber: float, length: Length) -> float:
    """How high the wave cos(k x) stands in a tank of this length (m), from the liquid's distribution along x.

    (2/L) sum_j V_j cos(k x_j), which is (2/L) times the integral of the level times cos(k x); in a plane.
    """
    volume = frame.arrays["mass"] / frame.arrays["density"]
    return float(2.0 / length * (volume @ np.cos(wavenumber * frame.arrays["position"][:, 0])))


class _Pairs(NamedTuple):
    """Points, and who is near each."""

    points: Array
    position: Array
    volume: Array
    smoothing: float
    kernel: Kernel
    near: Any
    """of each point, a list of particles"""


def _pairs(frame: Frame, points: Array, reach: Length, position: Array | None = None) -> _Pairs:
    if not reach > 0.0:
        raise BadInput(f"reach: came {reach:g} m; wanted the kernel's support, about four spacings")
    position = frame.arrays["position"] if position is None else position
    points = np.asarray(points, dtype=float)
    if points.ndim != 2 or points.shape[1] != position.shape[1]:
        raise BadInput(f"points: came shape {points.shape}; wanted (points, {position.shape[1]})")
    shape = kernel(KERNEL, dim=position.shape[1])
    near = cKDTree(position).query_ball_point(points, reach)
    volume = frame.arrays["mass"] / frame.arrays["density"]
    return _Pairs(points, position, volume, reach / shape.support, shape, near)


def _neighbors(pairs: _Pairs, point: int) -> tuple[Any, Array, Array]:
    """A point's neighbors: who, volume times kernel, and the way there."""
    neighbor = np.asarray(pairs.near[point], dtype=np.int64)
    away = pairs.position[neighbor] - pairs.points[point]
    weight = pairs.volume[neighbor] * pairs.kernel.value(np.sqrt((away**2).sum(axis=1)), pairs.smoothing)
    return neighbor, weight, away


def _sums(pairs: _Pairs, values: Array) -> Array:
    """Sum_j V_j f_j W_j at each point."""
    found = np.zeros((len(pairs.points), *values.shape[1:]))
    for point in range(len(pairs.points)):
        neighbor, weight, _ = _neighbors(pairs, point)
        found[point] = np.tensordot(weight, values[neighbor], axes=1)
    return found


def _array_of(frame: Frame, name: str) -> Array:
    if name not in frame.arrays:
        raise BadInput(f"the frames have no array {name!r}; they have {', '.join(sorted(frame.arrays))}")
    return np.asarray(frame.arrays[name], dtype=float)


def _shaped(numbers: Array, like: Array) -> Array:
    """Numbers with as many axes, so that each divides its row."""
    return numbers.reshape(numbers.shape + (1,) * (like.ndim - 1))
