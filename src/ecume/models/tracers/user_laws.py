"""External user laws for tracers: accelerations that depend on position, velocity and time.

User laws are evaluated at the midpoint of each step and constant during it, like gravity; drag is integrated exactly.
The work of an acceleration a is m a.dx, without thermal displacements; it is injected work.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.errors import BadInput, Fault, SceneError
from ecume.models.actions import with_injected_work
from ecume.models.costs import within_steps
from ecume.models.model import DONE, Model
from ecume.models.tracers import flow_steps
from ecume.models.tracers.check_report import summary_in
from ecume.models.tracers.flow_loops import loops_of
from ecume.models.tracers.liquid_flow import OwnFlow, own_velocity, varying_flow
from ecume.models.tracers.parameters import TRACERS as ACCESS
from ecume.models.tracers.parameters import Bodies, Parameters, State, Workspace, parameters_of
from ecume.models.tracers.tank import bounds
from ecume.models.user_laws import (
    EXTERNAL,
    FLOW,
    BoundLaw,
    called,
    compiled_for_laws,
    flags_of,
    require_acceleration,
    require_kinds,
    row_as_tuple,
    sum_of_external_laws,
)
from ecume.scenes.tracers import TracersScene
from ecume.trajectories.frame import Frame
from ecume.units import Array

COARSE = 0.5
"""The longest accurate time step, over the shortest time scale of a law."""
FINE = 1e-6
"""The step of finite differences over the radius."""


class Tracer(NamedTuple):
    """The properties of a particle that user laws receive, in addition to position, velocity and time."""

    radius: float
    density: float
    mass: float
    """kg, with the added mass of the liquid"""
    friction: float
    """N s/m, Stokes friction"""
    constants: tuple[float, ...]


class Own(NamedTuple):
    """The properties of a particle without the constants of a law."""

    radius: float
    density: float
    mass: float
    friction: float


@compiled_for_laws
def joined(own: Own, constants: Any) -> Tracer:
    """The properties of a particle together with the constants of a law."""
    return Tracer(own.radius, own.density, own.mass, own.friction, constants)


def extended(model: Model, laws: Sequence[BoundLaw]) -> Model:
    """The model of tracers with user laws: external accelerations, and the flow of the liquid. Raises BadInput for
    unsuitable functions.
    """
    require_kinds("tracers", laws, [EXTERNAL, FLOW])
    currents = [law for law in laws if law.arguments == FLOW]
    if len(currents) > 1:
        names = " and ".join(law.name for law in currents)
        raise BadInput(f"extra_laws: got the flows {names}, of three arguments; expected one")
    model = with_flow(model, currents[0]) if currents else model
    external = [law for law in laws if law.arguments == EXTERNAL]
    return with_external_laws(model, external) if external else model


def with_flow(model: Model, law: BoundLaw) -> Model:
    """The model of tracers in a user-defined flow, law(position, time, constants) -> velocity."""
    made: dict[int, OwnFlow] = {}

    def own(dimensions: int) -> OwnFlow:
        if dimensions not in made:
            loops = loops_of(own_velocity(law.function, dimensions), dimensions)
            made[dimensions] = OwnFlow(loops, law.constants)
        return made[dimensions]

    def parameters_with_flow(scene: TracersScene) -> Parameters:
        require_velocity(law, (1e-3,) * scene.dimensions)
        return within_steps(scene, parameters_of(scene, own(scene.dimensions)))

    def advance(parameters: Parameters, state: State, scratch: Workspace, steps: int) -> int:
        return flow_steps.advance(parameters, state, scratch, steps, own(parameters.dimensions).loops)

    def summary(scene: TracersScene) -> list[tuple[str, str, str]]:
        flow = varying_flow(scene, bounds(scene), own(scene.dimensions))
        return summary_in(scene, parameters_with_flow(scene), flow)

    return dataclasses.replace(model, parameters=parameters_with_flow, advance=advance, summary=summary)


def require_velocity(law: BoundLaw, position: tuple[float, ...]) -> None:
    """Evaluate a flow at one position. Raises BadInput for an invalid result."""
    found = called(law, position, 0.0, law.constants)
    good = isinstance(found, tuple) and len(found) == len(position)
    if not good or not all(isinstance(value, float) and math.isfinite(value) for value in found):
        raise BadInput(
            f"extra_laws: {law.name}: got {found!r}; expected a velocity in m/s, a tuple of {len(position)} numbers "
            "with decimal points"
        )


def with_external_laws(model: Model, laws: Sequence[BoundLaw]) -> Model:
    """The tracers with external laws."""
    total = sum_of_external_laws(laws, joined)
    loops: dict[int, Callable[..., None]] = {}

    def accelerate(parameters: Parameters, state: State, external: Array, time: float) -> None:
        loop = loops.setdefault(parameters.dimensions, _midpoint_loop(total, parameters.dimensions))
        flags = flags_of(laws, int(parameters.bodies.species.max(initial=0)) + 1)
        now = int(state.step[0]) * parameters.time_step
        loop(state.position, state.velocity, parameters.bodies, flags, (now, time), external)

    def parameters_with_laws(scene: TracersScene) -> Parameters:
        if scene.hydrodynamics.wall_drag:
            cause = "got it beside laws of the user, whose drift near walls it does not change; expected one of both"
            raise SceneError([Fault("hydrodynamics.wall_drag", cause)])
        parameters: Parameters = model.parameters(scene)
        for law in laws:
            require_acceleration(law, (1e-3,) * scene.dimensions, Tracer(1e-3, 2e3, 1e-5, 1e-5, law.constants))
        _require_step(parameters, model.start(scene, parameters), accelerate)
        return parameters

    def advance(parameters: Parameters, state: State, scratch: Workspace, steps: int) -> int:
        for _ in range(steps):
            accelerate(parameters, state, scratch.external, parameters.time_step)
            before = state.position.copy()
            status = model.advance(parameters, state, scratch, 1)
            state.work[0] += work_of_laws(parameters, state, scratch, before)
            if status != DONE:
                return status
        return DONE

    def observe(parameters: Parameters, state: State, scratch: Workspace) -> Frame:
        return with_injected_work(model.observe(parameters, state, scratch), ACCESS, state)

    return dataclasses.replace(model, parameters=parameters_with_laws, advance=advance, observe=observe)


def _midpoint_loop(total: Callable[..., None], dimensions: int) -> Callable[..., None]:
    """The loop over particles that evaluates the acceleration at the predicted position and velocity in the middle of
    the step.
    """
    row = row_as_tuple(dimensions)

    @compiled_for_laws
    def loop(
        position: Array, velocity: Array, bodies: Bodies, flags: Integers, when: tuple[float, float], external: Array
    ) -> None:
        time, step = when
        place, speed = np.zeros((1, position.shape[1])), np.zeros((1, position.shape[1]))
        for i in range(len(position)):
            own = Own(bodies.radius[i], bodies.density[i], bodies.mass[i], bodies.friction[i])
            mask = flags[bodies.species[i]]
            for axis in range(position.shape[1]):
                place[0, axis] = position[i, axis] + 0.5 * step * velocity[i, axis]
                external[i, axis] = 0.0
            total(row(place, 0), row(velocity, i), time + 0.5 * step, own, mask, external[i])
            for axis in range(position.shape[1]):
                speed[0, axis] = velocity[i, axis]
                if bodies.overdamped[i] == 0:
                    speed[0, axis] += 0.5 * step * external[i, axis]
                external[i, axis] = 0.0
            total(row(place, 0), row(speed, 0), time + 0.5 * step, own, mask, external[i])

    return loop


def work_of_laws(parameters: Parameters, state: State, scratch: Workspace, before: Array) -> float:
    """The work of the laws in the last step on particles in the tank (J)."""
    inside, count = state.left < 0, len(state.left)
    mass, overdamped = parameters.bodies.mass[:count], parameters.bodies.overdamped[:count] == 1
    by_noise = np.where((scratch.hits == 0)[:, None], scratch.shift, 0.0)
    way = np.where(overdamped[:, None], parameters.time_step * state.velocity, state.position - before - by_noise)
    power = np.sum(scratch.external * way, axis=1)
    return float(np.sum((mass * power)[inside]))


def _require_step(parameters: Parameters, state: State, accelerate: Callable[..., None]) -> None:
    """Raise SceneError if the time step is too long for the stiffness of the laws at the initial positions."""
    stiffest = 0.0
    step = FINE * float(parameters.bodies.radius.min())
    for axis in range(parameters.dimensions):
        sides = []
        for side in (-step, step):
            external, moved = np.zeros_like(state.position), state.position.copy()
            moved[:, axis] += side
            accelerate(parameters, state._replace(position=moved), external, 0.0)
            sides.append(external)
        slope = np.abs(sides[1] - sides[0]).sum(axis=1) / (2.0 * step)
        count = len(slope)
        bodies = parameters.bodies
        relaxing = bodies.friction[:count] / bodies.mass[:count] * (bodies.overdamped[:count] == 1)
        rate = np.where(relaxing > 0.0, slope / np.maximum(relaxing, 1e-300), np.sqrt(slope))
        stiffest = max(stiffest, float(rate.max(initial=0.0)))
    if parameters.time_step * stiffest > COARSE:
        message = (
            f"got {parameters.time_step:.3g} s; expected at most {COARSE / stiffest:.2g} s: the user-defined laws "
            f"change within {1.0 / stiffest:.2g} s at the initial positions"
        )
        raise SceneError([Fault("integration.time_step", message)])
