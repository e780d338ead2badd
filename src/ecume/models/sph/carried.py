"""Particles that the liquid carries: tracers, and grains with drag, weight and buoyancy. They do nothing to it.

The liquid's velocity comes from its particles around by Shepard's mean; outside of the liquid a grain falls freely.
Grains move by the exact solution of their step for the drag of its beginning, with the added mass of half the liquid
that they displace. The pressure that accelerates the liquid, other than that which bears weight, is left out.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import admit, compiled, compiled_inside, prange, spread
from ecume._portable import product
from ecume.engine.neighbor_rows import Grid, Sorted, cell_at
from ecume.engine.philox import counter_of, normals
from ecume.laws import brownian, drag
from ecume.models.sph.fields import DIMENSION, INVERSE, KERNEL, LIQUID, MU, RHO, VOLUME, P, V, X
from ecume.models.sph.guard import turn_back
from ecume.models.sph.weights import value_of
from ecume.scenes.sph import SphScene
from ecume.units import Array

admit(brownian, drag)

INSIDE = 0.5
"""The part of a kernel's full surroundings from which on a particle is in the liquid."""
GROUP_RADIUS, GROUP_DENSITY, GROUP_DIFFUSION = 0, 1, 2
"""Places in a group's numbers: radius, density, and eddy diffusivity over viscosity."""
WHOLE, EDDIES, PRESSURE, FLOW, AROUND = 0, 1, 2, 3, 6
"""Rows of surroundings: the liquid's part of them, the eddies' viscosity (m^2/s), pressure (Pa), velocity (3)."""


class Crowd(NamedTuple):
    """Everyone in cells, as they stood when the lists were made."""

    grid: Grid
    sorted: Sorted
    skin: float
    """m; nobody has gone farther than half of it"""


class Carried(NamedTuple):
    """Groups of alike particles, one a table of the scene."""

    position: Array
    """(d, C) at the start"""
    start: tuple[int, ...]
    """where each group begins, and the end"""
    numbers: Array
    """(groups, 3)"""
    regions: int
    """how many species the liquid has: theirs come after those"""
    weight: float
    """the kernel's factor"""
    seed: int


def carried_of(scene: SphScene, weight: float) -> Carried:
    """The groups of a scene; `weight` times the kernel's value is the kernel."""
    generator, places, numbers = np.random.default_rng([scene.seed, 3]), [], []
    for spec in scene.carried:
        if spec.low is not None and spec.high is not None:
            places.append(generator.uniform(spec.low, spec.high, (spec.count or 0, len(spec.low))))
        else:
            places.append(np.array(spec.positions))
        numbers.append((spec.radius, spec.density or 0.0, 1.0 / spec.schmidt if spec.eddy_dispersion else 0.0))
    start = tuple(int(end) for end in np.cumsum([0, *map(len, places)]))
    none = np.zeros((0, len(scene.tank.low)))
    position = np.ascontiguousarray(np.concatenate([none, *places]).T)
    return Carried(position, start, np.array(numbers).reshape(-1, 3), len(scene.fluid), weight, scene.seed)


def take_along(parameters: Any, state: Any, workspace: Any, time: float) -> None:
    """Move all of them through a part of a step, in the flow of its end."""
    carried, guard = parameters.carried, parameters.boundary.guard
    when = int(state.carried_clock[0])
    for group, numbers in enumerate(carried.numbers):
        here = slice(carried.start[group], carried.start[group + 1])
        position, velocity = state.carried_position[:, here].copy(), state.carried_velocity[:, here].copy()
        chance = (carried.seed, when, carried.start[group])
        around = surroundings(parameters, workspace, position)
        liquid = parameters.material.density, parameters.material.viscosity
        move(position, velocity, around, numbers, parameters.gravity, liquid, chance, time)
        turn_back(guard._replace(radius=max(guard.radius, float(numbers[GROUP_RADIUS]))), position, velocity,
                  (position - state.carried_position[:, here]) / time - velocity, time)  # fmt: skip
        wrap(parameters.boundary.sides, position)
        state.carried_position[:, here], state.carried_velocity[:, here] = position, velocity
    state.carried_clock[0] += 1


def surroundings(parameters: Any, workspace: Any, position: Array) -> Array:
    """(AROUND, C) of the liquid at these places: see `WHOLE` and the others."""
    around = np.zeros((AROUND, position.shape[1]))
    crowd = workspace.crowd
    if crowd is None:
        return around
    reach = parameters.support + 0.5 * crowd.skin
    liquid = parameters.carried.weight, parameters.material.viscosity, parameters.support, reach
    look_around(position, around, workspace.fields, parameters.numbers, parameters.choices, parameters.origin,
                liquid, crowd.sorted.order, crowd.sorted.start, *crowd.grid)  # fmt: skip
    return around


def wrap(sides: Any, position: Array) -> None:
    """Who left through a periodic side comes in through the opposite one."""
    for side in np.flatnonzero(sides.mirrors == 0):
        out = product(sides.normal[side], position - sides.point[side][:, None]) < 0.0
        position[:, out] += sides.shift[side][:, None]


@spread
def look_around(
    position: Any, around: Any, fields: Any, table: Any, choices: Any, origin: Any,
    liquid: tuple[float, float, float, float], order: Any, start: Any, low: Any, edge: Any, shape: Any,
) -> None:  # fmt: skip
    """Shepard's means at each place, over the cells around it; liquid = (the kernel's factor, viscosity, the kernel's
    support, how far away its cells may be).
    """
    kernel, inverse, dimension = choices[KERNEL], float(table[INVERSE]), choices[DIMENSION]
    deep, last = dimension == 3, dimension - 1
    weighs, viscosity, support, reach = liquid
    farthest = (support * inverse) ** 2
    for i in prange(position.shape[1]):
        whole, eddies, pressure, u, v, w = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        x, y, z = position[last, i], position[last - 1, i], position[0, i]
        row = cell_at((y - low[last - 1]) / edge[last - 1], shape[last - 1])
        layer = cell_at((z - low[0]) / edge[0], shape[0]) if deep else 0
        layers = shape[0] if deep else 1
        for k in range(max(layer - 1, 0), min(layer + 2, layers)):
            for m in range(max(row - 1, 0), min(row + 2, shape[last - 1])):
                line = (k * shape[last - 1] + m) * shape[last]
                begin = start[line + cell_at((x - reach - low[last]) / edge[last], shape[last])]
                end = start[line + cell_at((x + reach - low[last]) / edge[last], shape[last]) + 1]
                for n in range(begin, end):
                    j = order[n]
                    if fields[LIQUID, j] == 0.0:
                        continue
                    square = 0.0
                    for axis in range(dimension):
                        away = (fields[X + axis, j] + origin[axis] - position[axis, i]) * inverse
                        square += away * away
                    if square < farthest:
                        weight = weighs * value_of(math.sqrt(square), kernel) * fields[VOLUME, j]
                        whole += weight
                        eddies += weight * (fields[MU, j] - viscosity) / fields[RHO, j]
                        pressure += weight * fields[P, j]
                        u += weight * fields[V, j]
                        v += weight * fields[V + 1, j]
                        w += weight * fields[V + 2, j]
        share = 1.0 / whole if whole > 0.0 else 0.0
        around[WHOLE, i] = whole
        around[EDDIES, i] = max(share * eddies, 0.0)
        around[PRESSURE, i] = share * pressure
        around[FLOW, i] = share * u
        around[FLOW + 1, i] = share * v
        around[FLOW + 2, i] = share * w


@compiled_inside
def rate_of(speed: float, radius: float, mass: float, liquid: tuple[float, float]) -> float:
    """Drag over speed and mass, by Schiller and Naumann."""
    density, viscosity = liquid
    if viscosity <= 0.0:
        return 0.0
    factor = drag.schiller_naumann_factor(drag.particle_reynolds(speed, radius, density, viscosity))
    return drag.stokes_friction(radius, viscosity, factor) / mass


@compiled
def fall(
    position: Any,
    velocity: Any,
    flow: tuple[float, float, float],
    body: tuple[float, float, float],
    liquid: tuple[float, float],
    gravity: Any,
    time: float,
) -> None:
    """One grain; body = (radius, density, density of what it is in)."""
    radius, own, around = body
    square = 0.0
    for axis in range(len(gravity)):
        square += (velocity[axis] - flow[axis]) ** 2
    inertia = own + 0.5 * around
    volume = 4.0 / 3.0 * math.pi * radius * radius * radius
    rate = rate_of(math.sqrt(square), radius, inertia * volume, liquid) if around > 0.0 else 0.0
    gain, way = brownian.velocity_gain(rate * time), brownian.displacement_gain(rate * time)
    for axis in range(len(gravity)):
        push = (own - around) / inertia * gravity[axis] - rate * (velocity[axis] - flow[axis])
        position[axis] += time * velocity[axis] + 0.5 * time * time * push * way
        velocity[axis] += time * push * gain


@spread
def move(
    position: Any, velocity: Any, around: Any, numbers: Any, gravity: Any, liquid: tuple[float, float],
    chance: tuple[int, int, int], time: float,
) -> None:  # fmt: skip
    """One group; liquid = (density, viscosity), chance = (seed, when, first one's number)."""
    radius, own, dispersion = numbers[GROUP_RADIUS], numbers[GROUP_DENSITY], numbers[GROUP_DIFFUSION]
    for i in prange(position.shape[1]):
        flow = around[FLOW, i], around[FLOW + 1, i], around[FLOW + 2, i]
        if radius > 0.0:
            beside = liquid[0] if around[WHOLE, i] >= INSIDE else 0.0
            fall(position[:, i], velocity[:, i], flow, (radius, own, beside), liquid, gravity, time)
        else:
            # Where there is no liquid a tracer stays as it is.
            for axis in range(len(gravity)):
                velocity[axis, i] = flow[axis]
                position[axis, i] += time * flow[axis]
        far = math.sqrt(2.0 * dispersion * around[EDDIES, i] * time)
        for axis in range(len(gravity)):
            position[axis, i] += far * normals(counter_of(chance[2] + i, chance[1], axis), chance[0])[0]
