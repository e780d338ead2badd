"""Loops over tracers in a flow that varies: the velocity of the liquid at each tracer, its path with the liquid, and
gradients.

They are compiled for one velocity function and cached on disk, so that a scene compiles only its flow.
"""

from __future__ import annotations

import math
import typing
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import admit, compiled_inside
from ecume.engine.cells import Integers
from ecume.engine.walls.sheets import axpy, load, store
from ecume.laws import carrier_flows
from ecume.models.gridded_flows import GRIDDED_VELOCITIES
from ecume.models.tracers.named_flows import NAMED_FLOWS, OTHER_VELOCITIES
from ecume.models.tracers.obstacle_flows import ChannelFlow, obstacle_velocity
from ecume.models.tracers.obstacle_flows_3d import SolidFlow, solid_obstacle_velocity
from ecume.models.user_laws import compiled_for_laws
from ecume.units import Array

admit(carrier_flows)

Vector = tuple[float, float, float]
Pulse = tuple[float, float, float]
"""Amplitude, angular frequency and rate of decay of `carrier_flows.time_factor`."""


class Current(NamedTuple):
    """A flow that varies: a shape times a factor in time, and a uniform shear flow."""

    shape: Any
    pulse: Pulse
    uniform: tuple[float, float, float, float]
    """velocity (m/s) and shear rate (1/s)"""
    spacing: float
    """m: step of the finite differences for gradients"""
    low: tuple[float, ...]
    """m: the lower corner of the tank, in the order of positions"""
    periods: tuple[float, ...]
    """m: of a periodic tank along each axis; 0 without"""


class Loops(NamedTuple):
    """The compiled loops of a flow."""

    velocities: Callable[..., None]
    """velocities(position, time, current, found)"""
    velocities_then: Callable[..., None]
    """velocities_then(position, times, current, found): each at a separate time"""
    midways: Callable[..., None]
    """midways(position, velocity, status, (time, step), current, flow): velocities of the liquid in the middle of the
    step
    """
    paths: Callable[..., None]
    """paths(position, status, (time, step), current, drift, flow, travel): the mean velocity of the liquid along each
    path, and that of the particle"""
    noisy_paths: Callable[..., None]
    """noisy_paths(position, status, (time, step), current, drift, noise, flow): the same with random displacements"""
    gradients: Callable[..., None]
    """gradients(position, velocity, status, (time, step), current, found): gradients and accelerations"""


def _velocity_functions() -> dict[type, Callable[..., Vector]]:
    named = {typing.get_type_hints(row.shape)["return"]: row.velocity for row in NAMED_FLOWS.values()}
    solved = {ChannelFlow: obstacle_velocity, SolidFlow: solid_obstacle_velocity}
    return {**named, **OTHER_VELOCITIES, **GRIDDED_VELOCITIES, **solved}


def loops_for(current: Current, dimensions: int) -> Loops:
    """The loops of a flow, by the type of its shape."""
    return loops_of(_velocity_functions()[type(current.shape)], dimensions)


@cache
def loops_of(velocity: Callable[..., Vector], dimensions: int) -> Loops:
    """The loops of a flow with this velocity(shape, x, y, z, time), in two or three dimensions."""
    at = _velocity_at(velocity, dimensions)
    return Loops(
        _velocities(at), _velocities_then(at), _midways(at), _paths(at), _noisy_paths(at), _gradients(at, dimensions)
    )


Instant = tuple[float, float]
"""A time, and the factor of all velocities at it."""


@compiled_inside
def instant_at(current: Current, time: float) -> Instant:
    """The instant that belongs to a time."""
    pulse = current.pulse
    return time, carrier_flows.time_factor(time, pulse[0], pulse[1], pulse[2])


@compiled_inside
def within_period(value: float, low: float, period: float) -> float:
    """The coordinate wrapped into the tank. Paths of a step may cross its periodic sides, where fields from files
    end.
    """
    return value - period * math.floor((value - low) / period) if period > 0.0 else value


def _velocity_at(velocity: Callable[..., Vector], dimensions: int) -> Callable[[Current, Vector, Instant], Vector]:
    """The velocity of the whole flow at a point, from coordinates in the order of positions. The function is inlined at
    each call, since a call would take a quarter of the time of the interpolation on a grid.
    """

    def velocity_in_3d(current: Current, place: Vector, instant: Instant) -> Vector:
        x = within_period(place[0], current.low[0], current.periods[0])
        y = within_period(place[1], current.low[1], current.periods[1])
        z = within_period(place[2], current.low[2], current.periods[2])
        found = velocity(current.shape, x, y, z, instant[0])
        scale, uniform = instant[1], current.uniform
        return (
            scale * found[0] + uniform[0] + uniform[3] * place[2],
            scale * found[1] + uniform[1],
            scale * found[2] + uniform[2],
        )

    def velocity_in_2d(current: Current, place: Vector, instant: Instant) -> Vector:
        x = within_period(place[0], current.low[0], current.periods[0])
        z = within_period(place[1], current.low[1], current.periods[1])
        found = velocity(current.shape, x, 0.0, z, instant[0])
        scale, uniform = instant[1], current.uniform
        return scale * found[0] + uniform[0] + uniform[3] * place[1], scale * found[2] + uniform[1], 0.0

    return compiled_for_laws(velocity_in_2d if dimensions == 2 else velocity_in_3d, compiled_inside)


def _velocities(at: Callable[..., Vector]) -> Callable[..., None]:
    @compiled_for_laws
    def velocities(position: Array, time: float, current: Current, found: Array) -> None:
        instant = instant_at(current, time)
        for i in range(len(position)):
            store(found, i, at(current, load(position, i), instant))

    return velocities


def _velocities_then(at: Callable[..., Vector]) -> Callable[..., None]:
    @compiled_for_laws
    def velocities_then(position: Array, times: Array, current: Current, found: Array) -> None:
        for i in range(len(position)):
            store(found, i, at(current, load(position, i), instant_at(current, times[i])))

    return velocities_then


def _midways(at: Callable[..., Vector]) -> Callable[..., None]:
    @compiled_for_laws
    def midways(
        position: Array, velocity: Array, status: Integers, when: tuple[float, float], current: Current, flow: Array
    ) -> None:
        half = 0.5 * when[1]
        instant = instant_at(current, when[0] + half)
        for i in range(len(status)):
            if status[i] == 0:
                place = axpy(load(position, i), half, load(velocity, i))
                store(flow, i, at(current, place, instant))

    return midways


BLOCK = 256
"""Particles that take a stage of a step together: the processor overlaps the work on independent particles, where the
stages of one particle wait for one another.
"""


def _paths(at: Callable[..., Vector]) -> Callable[..., None]:
    """The loop of the fourth-order Runge-Kutta method: the particle moves with the liquid and with `drift`. Until the
    last stage `flow` contains the weighted sum of velocities, and `travel` the position of the next stage.
    """

    @compiled_for_laws
    def paths(
        position: Array,
        status: Integers,
        when: tuple[float, float],
        current: Current,
        drift: Array,
        flow: Array,
        travel: Array,
    ) -> None:
        time, h = when
        begin, middle = instant_at(current, time), instant_at(current, time + 0.5 * h)
        end = instant_at(current, time + h)
        stages = ((begin, 0.5 * h, 1.0), (middle, 0.5 * h, 2.0), (middle, h, 2.0), (end, h, 1.0))
        for low in range(0, len(status), BLOCK):
            for stage in range(4):
                instant, reach, weight = stages[stage]
                for i in range(low, min(low + BLOCK, len(status))):
                    if status[i] != 0:
                        continue
                    start, own = load(position, i), load(drift, i)
                    found = at(current, start if stage == 0 else load(travel, i), instant)
                    total = found if stage == 0 else axpy(load(flow, i), weight, found)
                    if stage < 3:
                        store(flow, i, total)
                        store(travel, i, axpy(axpy(start, reach, found), reach, own))
                    else:
                        mean = (total[0] / 6.0, total[1] / 6.0, total[2] / 6.0)
                        store(flow, i, mean)
                        store(travel, i, axpy(mean, 1.0, own))

    return paths


def _noisy_paths(at: Callable[..., Vector]) -> Callable[..., None]:
    """The loop of Heun's method, of weak order two, for noise that is independent of position."""

    @compiled_for_laws
    def noisy_paths(
        position: Array,
        status: Integers,
        when: tuple[float, float],
        current: Current,
        drift: Array,
        noise: Array,
        flow: Array,
    ) -> None:
        time, h = when
        begin, end = instant_at(current, time), instant_at(current, time + h)
        for i in range(len(status)):
            if status[i] != 0:
                continue
            start = load(position, i)
            first = at(current, start, begin)
            place = axpy(axpy(axpy(start, h, first), h, load(drift, i)), h, load(noise, i))
            second = at(current, place, end)
            store(flow, i, (0.5 * (first[0] + second[0]), 0.5 * (first[1] + second[1]), 0.5 * (first[2] + second[2])))

    return noisy_paths


VORTICITY, CURVATURE, ACCELERATION = 0, 3, 6
"""First columns of `gradients`: curl u, Laplacian of u, and Du/Dt, both the local and the convective part."""


def _gradients(at: Callable[..., Vector], dimensions: int) -> Callable[..., None]:
    """The loop for vorticity, Laplacian and acceleration of the liquid, by central differences, in the middle of the
    step.
    """
    axes = dimensions

    @compiled_for_laws
    def gradients(
        position: Array, velocity: Array, status: Integers, when: tuple[float, float], current: Current, found: Array
    ) -> None:
        time, d, late = when[0] + 0.5 * when[1], current.spacing, 1e-3 * when[1]
        now, earlier, later = (
            instant_at(current, time),
            instant_at(current, time - late),
            instant_at(current, time + late),
        )
        slope = np.zeros((3, 3))
        for i in range(len(status)):
            if status[i] != 0:
                continue
            place = axpy(load(position, i), 0.5 * when[1], load(velocity, i))
            here = at(current, place, now)
            for column in range(9):
                found[i, column] = 0.0
            for axis in range(axes):
                shift = (d if axis == 0 else 0.0, d if axis == 1 else 0.0, d if axis == 2 else 0.0)
                upper, lower = at(current, axpy(place, 1.0, shift), now), at(current, axpy(place, -1.0, shift), now)
                for part in range(3):
                    slope[part, axis] = (upper[part] - lower[part]) / (2.0 * d)
                    found[i, 3 + part] += (upper[part] - 2.0 * here[part] + lower[part]) / (d * d)
            after, before = at(current, place, later), at(current, place, earlier)
            for part in range(3):
                rate = (after[part] - before[part]) / (2.0 * late)
                for axis in range(axes):
                    rate += slope[part, axis] * here[axis]
                found[i, 6 + part] = rate
            found[i, 0] = slope[2, 1] - slope[1, 2]
            found[i, 1] = slope[0, 2] - slope[2, 0]
            found[i, 2] = slope[1, 0] - slope[0, 1]

    return gradients
