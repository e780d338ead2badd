"""Particles that the liquid carries: tracers, and grains with drag, weight and buoyancy. They do nothing to it.

The liquid's velocity comes from its particles around by Shepard's mean; outside of the liquid a grain falls freely.
Grains move by the exact solution of their step for the drag of its beginning, with the added mass of half the liquid
that they displace. The pressure that accelerates the liquid, other than that which bears weight, is left out.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import admit, compiled, compiled_inside
from ecume.engine.philox import counter_of, normals
from ecume.laws import brownian, drag
from ecume.models.sph.fields import DIMENSION, INVERSE, KERNEL, LIQUID, MU, RHO, VOLUME, V, X
from ecume.models.sph.guard import turn_back
from ecume.models.sph.weights import value_of
from ecume.scenes.sph import SphScene
from ecume.units import Array

admit(brownian, drag)

REACH = 4.0
"""In smoothing lengths: no kernel goes farther."""
INSIDE = 0.5
"""The part of a kernel's full surroundings from which on a particle is in the liquid."""
GROUP_RADIUS, GROUP_DENSITY, GROUP_DIFFUSION = 0, 1, 2
"""Places in a group's numbers: radius, density, and eddy diffusivity over viscosity."""


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
        liquid = (parameters.material.density, parameters.material.viscosity, carried.weight)
        move(workspace.fields, position, velocity, numbers, parameters.numbers, parameters.choices, parameters.gravity,
             parameters.origin, liquid, chance, time)  # fmt: skip
        turn_back(guard._replace(radius=max(guard.radius, float(numbers[GROUP_RADIUS]))), position, velocity,
                  (position - state.carried_position[:, here]) / time - velocity, time)  # fmt: skip
        wrap(parameters.boundary.sides, position)
        state.carried_position[:, here], state.carried_velocity[:, here] = position, velocity
    state.carried_clock[0] += 1


def wrap(sides: Any, position: Array) -> None:
    """Who left through a periodic side comes in through the opposite one."""
    for side in np.flatnonzero(sides.mirrors == 0):
        out = sides.normal[side] @ (position - sides.point[side][:, None]) < 0.0
        position[:, out] += sides.shift[side][:, None]


@compiled
def look_around(fields: Any, place: Any, table: Any, choices: Any, liquid: tuple[float, float, float]) -> Any:
    """The liquid's part of the surroundings of a place, and its velocity there and the eddies' viscosity (m^2/s)."""
    kernel, inverse, dimension = choices[KERNEL], float(table[INVERSE]), choices[DIMENSION]
    whole, eddies, u, v, w = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(fields.shape[1]):
        if fields[LIQUID, j] == 0.0:
            continue
        square = 0.0
        for axis in range(dimension):
            away = (fields[X + axis, j] - place[axis]) * inverse
            square += away * away
        if square < REACH * REACH:
            weight = liquid[2] * value_of(math.sqrt(square), kernel) * fields[VOLUME, j]
            whole += weight
            eddies += weight * (fields[MU, j] - liquid[1]) / fields[RHO, j]
            u += weight * fields[V, j]
            v += weight * fields[V + 1, j]
            w += weight * fields[V + 2, j]
    share = 1.0 / whole if whole > 0.0 else 0.0
    return whole, max(share * eddies, 0.0), (share * u, share * v, share * w)


@compiled_inside
def rate_of(speed: float, radius: float, mass: float, liquid: tuple[float, float, float]) -> float:
    """Drag over speed and mass, by Schiller and Naumann."""
    density, viscosity, _ = liquid
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
    liquid: tuple[float, float, float],
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


@compiled
def move(
    fields: Any,
    position: Any,
    velocity: Any,
    numbers: Any,
    table: Any,
    choices: Any,
    gravity: Any,
    origin: Any,
    liquid: tuple[float, float, float],
    chance: tuple[int, int, int],
    time: float,
) -> None:
    """One group; liquid = (density, viscosity, the kernel's factor), chance = (seed, when, first one's number)."""
    radius, own, dispersion = numbers[GROUP_RADIUS], numbers[GROUP_DENSITY], numbers[GROUP_DIFFUSION]
    for i in range(position.shape[1]):
        whole, eddies, flow = look_around(fields, position[:, i] - origin, table, choices, liquid)
        if radius > 0.0:
            around = liquid[0] if whole >= INSIDE else 0.0
            fall(position[:, i], velocity[:, i], flow, (radius, own, around), liquid, gravity, time)
        else:
            # Where there is no liquid a tracer stays as it is.
            for axis in range(len(gravity)):
                velocity[axis, i] = flow[axis]
                position[axis, i] += time * flow[axis]
        far = math.sqrt(2.0 * dispersion * eddies * time)
        for axis in range(len(gravity)):
            position[axis, i] += far * normals(counter_of(chance[2] + i, chance[1], axis), chance[0])[0]
