"""Thermal noise at walls and obstacles.

At a flat wall, or at walls at right angles, drift and noise are reflected together by Lepingle's scheme, exact for a
constant drift and any time step [lepingle1995]. No such law is known where walls meet at other angles, at curved walls,
and at the edges of obstacles. There a step is a flight with the velocity of drift and noise, which walls reflect
specularly. Flights of constant speed conserve phase-space volume, so that under noise alone a uniform density stays
uniform in any shape; with a drift a step is accepted with a probability (`acceptance`) that keeps the equilibrium.
"""

from __future__ import annotations

import math

from ecume._jit import admit, compiled, compiled_inside
from ecume.engine.cells import Integers
from ecume.engine.philox import counter_of_pair, normals, uniforms
from ecume.engine.walls import Sheet
from ecume.engine.walls.sheets import Vector, axpy, dot, gap_to, hole_at, inward_normal, load, piece_gap, scaled, store
from ecume.engine.walls.surfaces import PLANE
from ecume.laws import brownian_motion
from ecume.models.tracers.parameters import Parameters, State, Workspace
from ecume.units import Length

admit(brownian_motion)

REACH = 5.5
"""Standard deviations of noise within which a step may meet a wall: farther away with a probability of 4e-8."""
RIGHT_ANGLE = 1e-9
"""The cosine of the angle between normals up to which walls are at right angles."""


@compiled
def reflect_noise(parameters: Parameters, state: State, scratch: Workspace) -> None:
    """Add the reflection of the noise at walls and obstacles to the velocities (`brownian_motion.reflected_gain`),
    except for particles whose flight is reflected (`in_corner`); set the displacement by the drift alone.

    The random number of a wall is the component along its normal of two random vectors. Perpendicular walls then have
    independent numbers, which is exact. Nearly parallel walls, such as the facets of a round basin, have nearly equal
    numbers, since the same noise leads to both.
    """
    sheet, h, thermal = parameters.mirroring, parameters.time_step, parameters.fluid.thermal
    kind, number, hole, part = sheet.kind, sheet.number, sheet.hole, sheet.part
    for i in range(len(scratch.status)):
        if scratch.status[i] != 0:
            continue
        for axis in range(scratch.travel.shape[1]):
            scratch.shift[i, axis] = h * (scratch.travel[i, axis] - scratch.noise[i, axis])
        variance = 2.0 * brownian_motion.diffusivity(thermal, parameters.bodies.friction[i]) * h
        radius = scratch.radius[i]
        x, free = load(state.position, i), scaled(h, load(scratch.travel, i))
        if in_corner(sheet, x, load(scratch.shift, i), (radius, math.sqrt(variance))):
            continue
        k, piece, way, pushed, drawn, one, other = 0, 0, free, False, False, x, x
        while k < kind.shape[0]:
            before, nearest, following = piece_gap(kind, number, k, x, 0.0)
            after = piece_gap(kind, number, k, axpy(x, 1.0, way), 0.0)[0] - radius
            unhindered = piece_gap(kind, number, k, axpy(x, 1.0, free), 0.0)[0] - radius if pushed else after
            gap, k, piece = max(before - radius, 0.0), following, piece + 1
            # Paths from farther away reach the wall with a probability below exp(-40).
            if after > 0.0 and gap * min(after, unhindered) > 20.0 * variance:
                continue
            normal = inward_normal(kind, number, nearest, x, 0.0)
            share = min(gap / (gap - after), 1.0) if after < 0.0 else 0.5
            foot = axpy(axpy(x, share, way), -radius if after < 0.0 else -0.5 * (gap + after) - radius, normal)
            if hole_at(hole, part, number, nearest, (foot, 0.0)) >= 0:
                # The path may touch the opening between the ends of the step; the particle then stays in it.
                touched = uniforms(counter_of_pair(i, piece + 2, int(state.step[0]), 0), parameters.seed)[0]
                if after > 0.0 and touched < math.exp(-2.0 * gap * after / variance):
                    way, pushed = axpy(way, -after - 1e-6 * radius, normal), True
                continue
            if not drawn:
                one, other = random_vectors(i, int(state.step[0]), parameters.seed)
                drawn = True
            exponential = 0.5 * (dot(one, normal) ** 2 + dot(other, normal) ** 2)
            end = brownian_motion.reflected_gain(unhindered - gap, variance, exponential)
            if end > after:
                way, pushed = axpy(way, end - after, normal), True
                state.hits[nearest] += 1
        store(scratch.travel, i, scaled(1.0 / h, way))


@compiled_inside
def random_vectors(i: int, step: int, seed: int) -> tuple[Vector, Vector]:
    """Two vectors of normal numbers for the reflections of a particle in a step."""
    first, second = normals(counter_of_pair(i, 0, step, 0), seed)
    third, fourth = normals(counter_of_pair(i, 1, step, 0), seed)
    fifth, sixth = normals(counter_of_pair(i, 2, step, 0), seed)
    return (first, second, third), (fourth, fifth, sixth)


@compiled_inside
def in_corner(sheet: Sheet, x: Vector, drift: Vector, sizes: tuple[Length, Length]) -> bool:
    """Whether a step from x may meet walls that are not at right angles, a curved wall, or two faces of an obstacle.
    `drift` is the displacement by the drift (m); sizes = (radius, standard deviation of the noise).

    False next to openings and sticking walls, and where a drift toward or away from a wall makes a layer that is
    thinner than the noise: the step does not resolve the equilibrium there, and most flights would be rejected.
    """
    radius, spread = sizes
    kind, number, hole = sheet.kind, sheet.number, sheet.hole
    nothing = (0.0, 0.0, 0.0)
    k, one, other, third, found = 0, nothing, nothing, nothing, False
    while k < kind.shape[0]:
        gap, nearest, following = piece_gap(kind, number, k, x, 0.0)
        first, k = k, following
        if gap - radius >= REACH * spread:
            continue
        for face in range(first, following):
            if face != nearest and gap_to(kind, number, face, x, 0.0) - radius < -REACH * spread:
                continue
            normal = inward_normal(kind, number, face, x, 0.0)
            if 2.0 * abs(dot(drift, normal)) > spread or has_hole(hole, face):
                return False
            cosine = abs(dot(normal, one)) + abs(dot(normal, other)) + abs(dot(normal, third))
            found = found or cosine > RIGHT_ANGLE or face != nearest or kind[face, 0] != PLANE
            one, other, third = normal, one, other
    return found


@compiled_inside
def has_hole(hole: Integers, k: int) -> bool:
    """Whether surface k has an opening or is sticky."""
    found = False
    for m in range(hole.shape[0]):
        found = found or hole[m] == k
    return found


@compiled_inside
def acceptance(drift: Vector, way: Vector, mean: Vector, variance: float) -> float:
    """The Metropolis-Hastings probability of accepting a flight that walls reflected: exp(2 b.(y - x - (v + v')
    h/2)/s^2), at most 1.

    b h is the displacement by the drift, y - x that of the flight, (v + v') h/2 that with the mean of the initial and
    the final velocity, and s^2 the variance of the noise along an axis. Flights there and back are then in the ratio
    exp(b.(y - x)/D) of the equilibrium densities. Without collisions, or with a drift along the wall, the probability
    is 1.
    """
    return math.exp(min(2.0 * dot(drift, axpy(way, -1.0, mean)) / variance, 0.0))


@compiled
def accept_flights(parameters: Parameters, state: State, scratch: Workspace) -> None:
    """Return particles to their start if their reflected flight in a corner is rejected (`acceptance`)."""
    h, thermal = parameters.time_step, parameters.fluid.thermal
    for i in range(len(scratch.status)):
        drift = load(scratch.shift, i)
        if scratch.status[i] != 0 or scratch.hits[i] == 0 or dot(drift, drift) == 0.0:
            continue
        x, variance = (
            load(scratch.origin, i),
            2.0 * brownian_motion.diffusivity(thermal, parameters.bodies.friction[i]) * h,
        )
        if not in_corner(parameters.mirroring, x, drift, (scratch.radius[i], math.sqrt(variance))):
            continue
        start = axpy(drift, h, load(scratch.noise, i))
        mean = scaled(0.5, axpy(start, h, load(scratch.travel, i)))
        way = axpy(load(state.position, i), -1.0, x)
        drawn = uniforms(counter_of_pair(i, 0, int(state.step[0]), 0), parameters.seed)[0]
        if drawn > acceptance(drift, way, mean, variance):
            store(state.position, i, x)
