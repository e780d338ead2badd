"""Gauges: the values of a probe at a point, a sensor on a wall or a gauge of the water level, from a frame of
particles.  A value at a point is the mean of the particles near it, weighted by kernel and volume. `reach` (m) is
the support of the kernel: four spacings is usual in 2D, three to four in 3D.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ecume.engine.interpolation import Near, added, dry, means, near, planes
from ecume.errors import BadInput
from ecume.laws.kernels import kernel
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
    """The filled fraction of the surroundings of each point: 1 inside, 1/2 at a surface or a wall, 0 outside."""
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

    With too few neighbors for a gradient, it is the mean of `values_at`.
    """
    return planes(*_near(frame, points, reach), _array_of(frame, name))


def wall_pressure(frame: Frame, sensor: Array, reach: Length) -> float:
    """The reading of a pressure sensor in a wall (Pa): the mean over its face, `sensor` being points on it (n, d).

    Zero where the face is dry; liquid that has not arrived exerts no pressure. A frame does not contain the walls, so
    that points near few particles count as covered; gauges of a scene include the covered part of each point.
    """
    found = _near(frame, np.atleast_2d(sensor), reach)
    pressure = planes(*found, _array_of(frame, "pressure"))
    return float(np.where(dry(*found), 0.0, pressure).mean())


def water_level(frame: Frame, places: Array, reach: Length) -> Array:
    """The depth of the water above each place of the floor (m): the volume of liquid over the area
    of the floor.

    Places are (n,) along x in 2D, (n, 2) along x and z in 3D (y points up). Air bubbles do not count as water. Closer
    to a wall than `reach`, the depth is too small, since the wall cuts off a part of the kernel.
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
