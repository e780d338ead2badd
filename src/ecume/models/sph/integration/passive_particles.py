"""Passive particles, which the liquid carries without reaction: tracers, and grains with drag,
weight and buoyancy.

The velocity of the liquid is the Shepard mean over nearby particles; outside the liquid a grain falls freely. The
equation of motion of grains is integrated exactly for the drag coefficient at the start of the step, with an added mass
of half the displaced liquid. The force of the pressure gradient is limited to its hydrostatic part (buoyancy).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, compiled, compiled_inside, prange, spread
from ecume._portable import product
from ecume.engine.cells import Integers, Sides
from ecume.engine.neighbor_rows import cell_at
from ecume.engine.philox import counter_of, normals
from ecume.laws import brownian_motion, drag
from ecume.models.sph.boundaries.walls import reflect_particles
from ecume.models.sph.fields import FIELD, Constants, Floats
from ecume.models.sph.parameters import CarriedGroup, Parameters
from ecume.models.sph.rates.kernel_loops import value_of
from ecume.models.sph.state import CellLists, State, Workspace
from ecume.units import Array

admit(brownian_motion, drag)

INSIDE = 0.5
"""The kernel's sum over the liquid, relative to full surroundings, above which a passive particle is in the liquid."""


class Surroundings(NamedTuple):
    """The state of the liquid around each of C positions."""

    fraction: Array
    """(C,) the kernel's sum over the liquid, relative to full surroundings"""
    eddy_viscosity: Array
    """(C,) m^2/s"""
    pressure: Array
    """(C,) Pa"""
    velocity: Array
    """(3, C) m/s"""


def move_passive_particles(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Move all passive particles through one substep, with the flow at its end."""
    tracers, guard = parameters.passive_tracers, parameters.boundary.guard
    when = int(state.passive_clock[0])
    for number, group in enumerate(tracers.groups):
        here = slice(tracers.start[number], tracers.start[number + 1])
        position, velocity = state.passive_position[:, here].copy(), state.passive_velocity[:, here].copy()
        random_numbers = (tracers.seed, when, tracers.start[number])
        around = surroundings(parameters, workspace, position)
        liquid = parameters.material.density, parameters.material.viscosity
        move(position, velocity, around, group, parameters.gravity, liquid, random_numbers, time)
        reflect_particles(guard._replace(radius=max(guard.radius, group.radius)), position, velocity,
                  (position - state.passive_position[:, here]) / time - velocity, time)  # fmt: skip
        image = state.passive_image[:, here] if state.passive_image.size else np.zeros(position.shape, np.int64)
        wrap(parameters.boundary.sides, position, image)
        state.passive_position[:, here], state.passive_velocity[:, here] = position, velocity
    state.passive_clock[0] += 1


def surroundings(parameters: Parameters, workspace: Workspace, position: Array) -> Surroundings:
    """The velocity, pressure and eddy viscosity of the liquid at these places."""
    count = position.shape[1]
    around = Surroundings(np.zeros(count), np.zeros(count), np.zeros(count), np.zeros((3, count)))
    cells = workspace.cells
    if cells is None:
        return around
    reach = parameters.support + 0.5 * cells.skin
    liquid = parameters.passive_tracers.weight, parameters.material.viscosity, parameters.support, reach
    look_around(position, around, workspace.fields.table, parameters.constants, parameters.origin,
                liquid, cells)  # fmt: skip
    return around


def wrap(sides: Sides, position: Array, image: Integers) -> None:
    """Move particles beyond a periodic side to the opposite one, and count it in their image numbers."""
    for side in np.flatnonzero(sides.mirrors == 0):
        out = product(sides.normal[side], position - sides.point[side][:, None]) < 0.0
        position[:, out] += sides.shift[side][:, None]
        image[:, out] -= np.sign(sides.shift[side]).astype(np.int64)[:, None]


@spread
def look_around(
    position: Array, around: Surroundings, fields: Floats, constants: Constants, origin: Array,
    liquid: tuple[float, float, float, float], cells: CellLists,
) -> None:  # fmt: skip
    """Compute Shepard's means at each place, over the cells around it; liquid = (the kernel's factor, viscosity, the
    kernel's support, the width of its cells).
    """
    kernel, inverse, dimension = constants[0].kernel, float(constants[0].inverse_length), constants[0].dimension
    deep, last = dimension == 3, dimension - 1
    weighs, viscosity, support, reach = liquid
    order, start, (low, edge, shape) = cells.sorted.order, cells.sorted.start, cells.grid
    farthest = (support * inverse) ** 2
    fraction, eddy_viscosity, pressures, flow = around.fraction, around.eddy_viscosity, around.pressure, around.velocity
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
                    if fields[FIELD.liquid, j] == 0.0:
                        continue
                    square = 0.0
                    for axis in range(dimension):
                        away = (fields[FIELD.position + axis, j] + origin[axis] - position[axis, i]) * inverse
                        square += away * away
                    if square < farthest:
                        weight = weighs * value_of(math.sqrt(square), kernel) * fields[FIELD.volume, j]
                        whole += weight
                        eddies += weight * (fields[FIELD.viscosity, j] - viscosity) / fields[FIELD.density, j]
                        pressure += weight * fields[FIELD.pressure, j]
                        u += weight * fields[FIELD.velocity, j]
                        v += weight * fields[FIELD.velocity + 1, j]
                        w += weight * fields[FIELD.velocity + 2, j]
        share = 1.0 / whole if whole > 0.0 else 0.0
        fraction[i] = whole
        eddy_viscosity[i] = max(share * eddies, 0.0)
        pressures[i] = share * pressure
        flow[0, i] = share * u
        flow[1, i] = share * v
        flow[2, i] = share * w


@compiled_inside
def rate_of(speed: float, radius: float, mass: float, liquid: tuple[float, float]) -> float:
    """The ratio of drag to momentum (1/s) by Schiller and Naumann."""
    density, viscosity = liquid
    if viscosity <= 0.0:
        return 0.0
    factor = drag.schiller_naumann_factor(drag.particle_reynolds(speed, radius, density, viscosity))
    return drag.stokes_friction(radius, viscosity, factor) / mass


@compiled
def fall(
    position: Array,
    velocity: Array,
    flow: tuple[float, float, float],
    body: tuple[float, float, float],
    liquid: tuple[float, float],
    gravity: Array,
    time: float,
) -> None:
    """Advance one grain; body = (radius, density, density of the liquid or air around it)."""
    radius, own, around = body
    square = 0.0
    for axis in range(len(gravity)):
        square += (velocity[axis] - flow[axis]) ** 2
    inertia = own + 0.5 * around
    volume = 4.0 / 3.0 * math.pi * radius * radius * radius
    rate = rate_of(math.sqrt(square), radius, inertia * volume, liquid) if around > 0.0 else 0.0
    gain, way = brownian_motion.velocity_gain(rate * time), brownian_motion.displacement_gain(rate * time)
    for axis in range(len(gravity)):
        push = (own - around) / inertia * gravity[axis] - rate * (velocity[axis] - flow[axis])
        position[axis] += time * velocity[axis] + 0.5 * time * time * push * way
        velocity[axis] += time * push * gain


@spread
def move(
    position: Array, velocity: Array, around: Surroundings, group: CarriedGroup, gravity: Array,
    liquid: tuple[float, float], random_numbers: tuple[int, int, int], time: float,
) -> None:  # fmt: skip
    """Advance one group; liquid = (density, viscosity), random_numbers = (seed, step, number of the first particle)."""
    radius, own, dispersion = group.radius, group.density, group.dispersion
    for i in prange(position.shape[1]):
        flow = around.velocity[0, i], around.velocity[1, i], around.velocity[2, i]
        if radius > 0.0:
            beside = liquid[0] if around.fraction[i] >= INSIDE else 0.0
            fall(position[:, i], velocity[:, i], flow, (radius, own, beside), liquid, gravity, time)
        else:
            # A tracer outside of the liquid does not move.
            for axis in range(len(gravity)):
                velocity[axis, i] = flow[axis]
                position[axis, i] += time * flow[axis]
        far = math.sqrt(2.0 * dispersion * around.eddy_viscosity[i] * time)
        for axis in range(len(gravity)):
            position[axis, i] += (
                far * normals(counter_of(random_numbers[2] + i, random_numbers[1], axis), random_numbers[0])[0]
            )
