"""Reflection at walls as functions of arrays: `reflect`, and `trace`, which returns every hit."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.engine.walls.event_driven import CAPPED, MOST_EVENTS, move_all
from ecume.engine.walls.sheets import RELATIVE_ROUNDING, SCALE, Sheet, sheet
from ecume.engine.walls.surfaces import PLANE, Surfaces, described, numbers_of
from ecume.errors import BadInput
from ecume.units import Array


class Trace(NamedTuple):
    """The hits of all particles in one step, ordered by particle and time."""

    position: Array
    """(N, d) m"""
    velocity: Array
    """(N, d) m/s"""
    hits: Integers
    """(N,)"""
    particle: Integers
    """(M,) the index of the particle of each hit"""
    surface: Integers
    """(M,) the index of the surface"""
    time: Array
    """(M,) s, since the start of the step"""
    place: Array
    """(M, d) m"""
    left: Integers
    """(N,) the opening through which a particle left, or -1; such a particle stays at the point where it left"""
    capped: np.ndarray[Any, np.dtype[np.bool_]]
    """(N,) whether the step had more events than allowed; the rest of the flight is missing"""


def reflect(
    position: Any,
    velocity: Any,
    dt: float,
    walls: Surfaces,
    restitution: Any = 1.0,
    tangential: Any = 1.0,
    acceleration: Any = None,
    radius: Any = 0.0,
) -> tuple[Array, Array, Integers]:
    """Move particles through one step of `dt` seconds; return new positions (N, d), velocities (N, d) and hits (N,).

    At each hit the normal velocity v_n becomes -restitution v_n, and the tangential velocity v_t becomes tangential
    v_t, in the frame of the surface. Between hits the flight is straight, or a parabola under a constant acceleration,
    (d,) or (N, d). A particle with a radius touches a surface before its center does. Coefficients are one number, or
    one for each surface. A particle that is pressed onto a surface and would rebound more slowly than 1e-8 of the
    speeds in the step slides. Positions of moving walls are those at the beginning of the step. Raises BadInput for a
    particle that starts outside, or that would need more than 10,000 events; `trace` flags the latter instead.

    >>> from ecume.engine.walls import box
    >>> position, velocity, hits = reflect([(0.5, 0.9)], [(0.0, 1.0)], 0.5, box((0, 0), (1, 1)))
    >>> print(position.round(12), velocity, hits)
    [[0.5 0.6]] [[ 0. -1.]] [1]
    """
    _require_step(dt, walls)
    new, fast, pushed, width = _prepared(position, velocity, acceleration, radius)
    packed = sheet(walls, restitution, tangential)
    _require_inside(new, width, walls, packed)
    hits = np.zeros(len(new), np.int64)
    status = _flown((new, fast, pushed, width), float(dt), packed, _no_log(new.shape[1]), hits)
    if status.min(initial=0) < 0:
        worst = int(np.argmin(status))
        raise BadInput(
            f"reflect: particle {worst} met walls more than {MOST_EVENTS} times within {dt:g} s; take a shorter step"
        )
    return new, fast, hits


def trace(
    position: Any,
    velocity: Any,
    dt: float,
    walls: Surfaces,
    restitution: Any = 1.0,
    tangential: Any = 1.0,
    acceleration: Any = None,
    radius: Any = 0.0,
) -> Trace:
    """Perform the same step as `reflect`, and return every hit: the surface (the original's plane_col, plane_col2 and
    so on), the time and the position.

    >>> from ecume.engine.walls import box
    >>> trace([(0.9, 0.8)], [(1.0, 1.0)], 0.5, box((0, 0), (1, 1))).surface
    array([2, 3])
    """
    _require_step(dt, walls)
    started = _prepared(position, velocity, acceleration, radius)
    packed = sheet(walls, restitution, tangential)
    _require_inside(started[0], started[3], walls, packed)
    count, dimension = started[0].shape
    hits = np.zeros(count, np.int64)
    _flown(started, float(dt), packed, _no_log(dimension), hits)
    first = np.concatenate([[0], np.cumsum(hits)])
    total = int(first[-1])
    log = (first, np.zeros(total, np.int64), np.zeros(total), np.zeros((total, dimension)))
    again = _prepared(position, velocity, acceleration, radius)
    status = _flown(again, float(dt), packed, log, np.zeros_like(hits))
    who = np.repeat(np.arange(count), hits)
    return Trace(again[0], again[1], hits, who, *log[1:], np.maximum(status, 0) - 1, status == CAPPED)


Prepared = tuple[Array, Array, Array, Array]


def _no_log(dimension: int) -> Any:
    none = np.zeros(0, np.int64)
    return none, none, np.zeros(0), np.zeros((0, dimension))


def _flown(started: Prepared, dt: float, packed: Sheet, log: Any, hits: Integers) -> Integers:
    status = np.zeros(len(hits), np.int64)
    per_surface = np.zeros(len(packed.kind), np.int64)
    counts: Any = (hits, status, per_surface)
    move_all(*started, dt, *packed, *log, *counts)
    return status


def _require_step(dt: float, walls: Surfaces) -> None:
    if not isinstance(walls, Surfaces):
        raise BadInput(f"walls: got {type(walls).__name__}; expected what box, polygon, planes, disc ... of walls make")
    if not 0.0 <= dt < np.inf:
        raise BadInput(f"dt: got {dt!r}; expected zero or more seconds; reverse velocities to go back in time")


def _prepared(position: Any, velocity: Any, acceleration: Any, radius: Any) -> Prepared:
    """Copies in the memory layout that compiled code requires."""
    new, fast = numbers_of(position, "position"), numbers_of(velocity, "velocity")
    if new.ndim != 2 or new.shape[1] not in (2, 3) or fast.shape != new.shape:
        raise BadInput(f"position, velocity: got shapes {new.shape}, {fast.shape}; expected (N, 2) or (N, 3) for both")
    pushed = np.zeros((1, new.shape[1])) if acceleration is None else numbers_of(acceleration, "acceleration")
    pushed = np.atleast_2d(pushed)
    if pushed.shape not in ((1, new.shape[1]), new.shape):
        raise BadInput(f"acceleration: got shape {pushed.shape}; expected ({new.shape[1]},) or {new.shape}")
    width = np.atleast_1d(numbers_of(radius, "radius"))
    if width.shape not in ((1,), (len(new),)) or not np.all(width >= 0.0):
        raise BadInput(f"radius: got {radius!r}; expected a length, or one for each of {len(new)} particles")
    for name, array in (("position", new), ("velocity", fast), ("acceleration", pushed)):
        if not np.all(np.isfinite(array)):
            worst = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
            raise BadInput(f"{name}: row {worst} is {array[worst].tolist()}; expected finite numbers")
    return new, fast, pushed, width


def gaps(position: Array, walls: Surfaces) -> Array:
    """The distance (N, K) of each point from each surface (m), positive inside."""
    wide = np.pad(position, ((0, 0), (0, 3 - position.shape[1])))
    flat = wide @ walls.place.T - walls.size
    away = np.linalg.norm(wide[:, None, :] - walls.place[None], axis=2)
    found: Array = np.where(walls.kind == PLANE, flat, walls.kind * (walls.size - away))
    return found


def clearance(position: Array, walls: Surfaces) -> tuple[Array, Integers]:
    """The distance of each point from the nearest surface (m, negative outside), and the index of that surface.

    The distance from an obstacle is the largest of those from its faces.
    """
    found = gaps(position, walls)
    nearest = np.tile(np.arange(found.shape[1]), (len(found), 1))
    for start, stop in {(int(a), int(b)) for a, b in walls.face if b > 0}:
        best = start + np.argmax(found[:, start:stop], axis=1)
        nearest[:, start:stop] = best[:, None]
        found[:, start:stop] = np.take_along_axis(found, best[:, None], axis=1)
    if not found.shape[1]:
        return np.full(len(position), np.inf), np.full(len(position), -1)
    worst = np.argmin(found, axis=1)[:, None]
    return np.take_along_axis(found, worst, axis=1)[:, 0], np.take_along_axis(nearest, worst, axis=1)[:, 0]


def _require_inside(position: Array, radius: Array, walls: Surfaces, packed: Sheet) -> None:
    if position.shape[1] != walls.dimension:
        raise BadInput(f"position: got {position.shape[1]} coordinates; the walls have {walls.dimension}")
    clear, which = clearance(position, walls)
    scale = float(packed.number[:, SCALE].max(initial=0.0))
    rounding = RELATIVE_ROUNDING * (scale + np.linalg.norm(position, axis=1))
    out = np.flatnonzero(clear - radius < -rounding)
    if len(out):
        i = int(out[0])
        point = ", ".join(f"{value:.9g}" for value in position[i])
        others = f" ({len(out)} of {len(position)} particles do)" if len(out) > 1 else ""
        raise BadInput(
            f"position: particle {i} at ({point}) starts outside: {radius[i % len(radius)] - clear[i]:.3g} m beyond "
            f"{described(walls, int(which[i]))}{others}; expected every particle inside, its radius included"
        )
