"""Diffusion and settling where the diffusivity depends on position: drag near walls, and turbulent mixing over height.

Along each axis between two walls a step is Metropolis-adjusted, in a transformed coordinate with uniform noise
[bourabee2014]. A suspension in equilibrium (well mixed, or with the profile of settling) remains in equilibrium for any
time step, since a move is accepted with the ratio of the equilibrium densities. The drift by the gradient of the
diffusivity is included. Walls reflect: the coordinate continues beyond them, and is folded back.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, compiled, compiled_inside
from ecume.engine.cells import Integers
from ecume.engine.philox import counter_of, normals, uniforms
from ecume.laws import brownian_motion, wall_drag
from ecume.units import Array

admit(brownian_motion, wall_drag)

Point = tuple[float, float, float]
IRREVERSIBLE = 0.01
"""The largest difference of the reversed move from the start, over the move. Moves across jumps of the diffusivity
exceed it; they are rejected, since they would accumulate particles on the side with the lower diffusivity.
"""


class Surroundings(NamedTuple):
    """The walls and the mixing on which the diffusivity depends, in a box."""

    low: Point
    high: Point
    walled: tuple[int, int, int]
    """1 where there are walls across an axis"""
    near_walls: int
    """1 with drag near walls"""
    table: Array
    """of `wall_drag.wall_mobilities`"""
    heights: Array
    """m, of the profile of turbulent diffusivities; empty without one"""
    mixing: Array
    """m^2/s, at these heights"""
    horizontal: float
    """m^2/s, along the other axes"""
    purpose: int
    """of the random numbers that accept moves: see `counter_of`"""


@compiled
def mobility(place: Point, radius: float, axis: int, around: Surroundings, d: int) -> float:
    """The mobility along an axis, relative to that far from walls; the additional frictions of the walls are added
    up.
    """
    if around.near_walls == 0:
        return 1.0
    friction = 1.0
    for side in range(d):
        if around.walled[side] == 1:
            for k in range(2):
                gap = (place[side] - around.low[side] if k == 0 else around.high[side] - place[side]) - radius
                along, toward = wall_drag.wall_mobilities(gap, radius, around.table)
                friction += 1.0 / (toward if side == axis else along) - 1.0
    return 1.0 / friction


@compiled
def turbulence(height: float, around: Surroundings) -> float:
    """The vertical turbulent diffusivity at a height (m^2/s), by linear interpolation."""
    last = len(around.heights) - 1
    if last < 0:
        return 0.0
    if height <= around.heights[0]:
        return float(around.mixing[0])
    for k in range(last):
        if height < around.heights[k + 1]:
            share = (height - around.heights[k]) / (around.heights[k + 1] - around.heights[k])
            return float(around.mixing[k] + share * (around.mixing[k + 1] - around.mixing[k]))
    return float(around.mixing[last])


@compiled_inside
def moved(place: Point, axis: int, value: float) -> Point:
    """The place with one coordinate replaced."""
    return (value if axis == 0 else place[0], value if axis == 1 else place[1], value if axis == 2 else place[2])


@compiled_inside
def diffusivity_at(
    place: Point, axis: int, own: tuple[float, float, float], around: Surroundings, d: int
) -> tuple[float, float]:
    """The diffusivity along an axis (m^2/s), and the mobility over that far from walls; own = (radius, diffusivity far
    from walls, settling speed).
    """
    share = mobility(place, own[0], axis, around, d)
    spread = own[1] * share
    spread += turbulence(place[axis], around) if axis == d - 1 else around.horizontal
    return spread, share


@compiled_inside
def folded(u: float, ends: tuple[float, float], angular: bool) -> tuple[float, float]:
    """The position of a coordinate u that continues beyond both walls, and its derivative. u is a position, or with
    `angular` the angle in low + (high - low) sin^2(u/2).
    """
    low, width = ends[0], ends[1] - ends[0]
    if angular:
        share = math.sin(0.5 * u) ** 2
        share = min(max(share, 1e-13), 1.0 - 1e-13)
        return low + width * share, width * math.sqrt(share * (1.0 - share))
    along = abs(u - low) % (2.0 * width)
    return low + (along if along <= width else 2.0 * width - along), 1.0


@compiled
def pace(
    u: float, place: Point, axis: int, own: tuple[float, float, float], ends: tuple[float, float],
    around: Surroundings, d: int,
) -> float:  # fmt: skip
    """The derivative of u by the transformed coordinate with uniform noise."""
    z, scale = folded(u, ends, around.near_walls == 1)
    return math.sqrt(max(diffusivity_at(moved(place, axis, z), axis, own, around, d)[0], 1e-300)) / scale


@compiled_inside
def carried(
    u: float, way: float, place: Point, axis: int, own: tuple[float, float, float], ends: tuple[float, float],
    around: Surroundings, d: int,
) -> float:  # fmt: skip
    """The coordinate u after a displacement of the transformed coordinate, by a step of the fourth-order Runge-Kutta
    method.
    """
    a = pace(u, place, axis, own, ends, around, d)
    b = pace(u + 0.5 * way * a, place, axis, own, ends, around, d)
    c = pace(u + 0.5 * way * b, place, axis, own, ends, around, d)
    e = pace(u + way * c, place, axis, own, ends, around, d)
    return u + way * (a + 2.0 * b + 2.0 * c + e) / 6.0


@compiled
def drift(
    u: float, place: Point, axis: int, own: tuple[float, float, float], ends: tuple[float, float],
    around: Surroundings, d: int, most: float,
) -> float:  # fmt: skip
    """The drift of the transformed coordinate y with uniform noise: half of d ln(density sqrt(D))^2/dy."""
    step = 1e-4 * (1.0 if around.near_walls == 1 else ends[1] - ends[0])
    z, scale = folded(u, ends, around.near_walls == 1)
    spread, share = diffusivity_at(moved(place, axis, z), axis, own, around, d)
    logs = 0.0
    for k in range(2):
        side = folded(u + (step if k == 0 else -step), ends, around.near_walls == 1)[0]
        near = math.log(max(diffusivity_at(moved(place, axis, side), axis, own, around, d)[0], 1e-300))
        logs += 0.5 * (near if k == 0 else -near)
    # In equilibrium, settling gives d ln(density)/dz = -speed/D; `upward` is the sign of dz/du.
    upward = 1.0
    if around.near_walls == 1:
        upward = 1.0 if math.sin(u) >= 0.0 else -1.0
    elif math.floor((u - ends[0]) / (ends[1] - ends[0])) % 2 != 0:
        upward = -1.0
    sinking = own[2] * share / math.sqrt(max(spread, 1e-300)) if axis == d - 1 else 0.0
    speed = math.sqrt(spread) / scale * logs / (2.0 * step) - upward * sinking
    return min(max(speed, -most), most)


@compiled
def log_ratio(
    z: float, other: float, place: Point, axis: int, own: tuple[float, float, float], around: Surroundings, d: int
) -> float:
    """The logarithm of the equilibrium density times the root of the diffusivity at another position, over this product
    at the present one.
    """
    total, slope = 0.0, 0.0
    for k in range(3):
        at = moved(place, axis, z + 0.5 * k * (other - z))
        spread, share = diffusivity_at(at, axis, own, around, d)
        if axis == d - 1:
            slope += (4.0 if k == 1 else 1.0) * own[2] * share / max(spread, 1e-300) / 6.0
        if k != 1:
            total += (0.5 if k == 2 else -0.5) * math.log(max(spread, 1e-300))
    return total - slope * (other - z)


@compiled
def moved_along(
    place: Point, axis: int, own: tuple[float, float, float], around: Surroundings, d: int, h: float,
    draws: tuple[float, float],
) -> float:  # fmt: skip
    """The coordinate of a particle along an axis after a time; draws = (a normal number, a uniform one)."""
    z = place[axis]
    if around.walled[axis] == 0:
        spread, share = diffusivity_at(place, axis, own, around, d)
        fall = own[2] * share if axis == d - 1 else 0.0
        return z - h * fall + math.sqrt(2.0 * spread * h) * draws[0]
    ends = (around.low[axis] + own[0], around.high[axis] - own[0])
    z = min(max(z, ends[0]), ends[1])
    u = z
    if around.near_walls == 1:
        u = 2.0 * math.asin(math.sqrt(min(max((z - ends[0]) / (ends[1] - ends[0]), 0.0), 1.0)))
    most = math.sqrt(2.0 / h)
    first = drift(u, place, axis, own, ends, around, d, most)
    way = h * first + math.sqrt(2.0 * h) * draws[0]
    there = carried(u, way, place, axis, own, ends, around, d)
    again = carried(there, -way, place, axis, own, ends, around, d)
    if abs(again - u) > IRREVERSIBLE * abs(there - u):
        return z
    second = drift(there, place, axis, own, ends, around, d, most)
    other = folded(there, ends, around.near_walls == 1)[0]
    back = -way - h * second
    ratio = log_ratio(z, other, place, axis, own, around, d) + 0.5 * draws[0] ** 2 - back * back / (4.0 * h)
    return other if math.log(draws[1]) < ratio else z


@compiled
def diffuse(
    position: Array, status: Integers, bodies: tuple[Array, Array, Array], around: Surroundings,
    key: tuple[int, int, float], h: float, travel: Array,
) -> None:  # fmt: skip
    """Set the mean velocities of particles without inertia over a time, from their random displacements and settling.

    bodies = (radius, Stokes friction, settling speed); key = (seed, step, kT).
    """
    (radius, friction, settling), (seed, step, thermal), d = bodies, key, position.shape[1]
    for i in range(len(status)):
        if status[i] != 0:
            continue
        start = (position[i, 0], position[i, 1], position[i, 2] if d > 2 else 0.0)
        place = start
        far = brownian_motion.diffusivity(thermal, friction[i]) if thermal > 0.0 else 0.0
        own = (radius[i], far, settling[i])
        for axis in range(d):
            draws = (
                normals(counter_of(i, step, axis), seed)[0],
                uniforms(counter_of(i, step, around.purpose + axis), seed)[0],
            )
            place = moved(place, axis, moved_along(place, axis, own, around, d, h, draws))
        for axis in range(d):
            travel[i, axis] = (place[axis] - start[axis]) / h


@compiled
def sink(
    position: Array, status: Integers, bodies: tuple[Array, Array], around: Surroundings, h: float, travel: Array
) -> None:
    """Set the mean velocities of particles that settle without noise over a time; bodies = (radius, settling speed)."""
    (radius, settling), d = bodies, position.shape[1]
    for i in range(len(status)):
        if status[i] == 0:
            start = (position[i, 0], position[i, 1], position[i, 2] if d > 2 else 0.0)
            middle = start[d - 1] - 0.5 * h * settling[i] * mobility(start, radius[i], d - 1, around, d)
            for axis in range(d):
                travel[i, axis] = 0.0
            travel[i, d - 1] = -settling[i] * mobility(moved(start, d - 1, middle), radius[i], d - 1, around, d)


@compiled
def set_settling(
    position: Array, status: Integers, bodies: tuple[Array, Array], around: Surroundings, drift: Array
) -> None:
    """Set the settling velocities of particles at their present places; bodies = (radius, settling speed)."""
    (radius, settling), d = bodies, position.shape[1]
    for i in range(len(status)):
        if status[i] == 0:
            place = (position[i, 0], position[i, 1], position[i, 2] if d > 2 else 0.0)
            drift[i, d - 1] = -settling[i] * mobility(place, radius[i], d - 1, around, d)


@compiled
def set_hindrances(
    position: Array, velocity: Array, status: Integers, radius: Array, around: Surroundings, h: float, found: Array
) -> None:
    """Set the friction along each axis, over that far from walls, in the middle of the step."""
    d = position.shape[1]
    for i in range(len(status)):
        if status[i] == 0:
            place = (0.0, 0.0, 0.0)
            for axis in range(d):
                low, high = around.low[axis] + radius[i], around.high[axis] - radius[i]
                ahead = position[i, axis] + 0.5 * h * velocity[i, axis]
                if around.walled[axis] == 1:
                    # At most half of the gap: drag near the wall prevents a larger displacement.
                    ahead = max(min(ahead, 0.5 * (position[i, axis] + high)), 0.5 * (position[i, axis] + low))
                place = moved(place, axis, ahead)
            for axis in range(d):
                found[i, axis] = 1.0 / mobility(place, radius[i], axis, around, d)


NOTHING = np.zeros((2, 2))
"""Replaces the table without drag near walls."""
