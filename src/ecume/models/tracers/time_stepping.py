"""Time integration of tracers.

With inertia, a step is exact without walls, and a parabola between collisions. Without inertia and noise, a step
consists of two half steps of a drift that stops at walls. With noise, drift and diffusion act together and are
reflected at walls (`noise_at_walls`).
"""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import admit, compiled, compiled_inside, selection
from ecume.engine.cells import Integers
from ecume.engine.philox import counter_of, normals
from ecume.engine.walls import Sheet, reflect_all
from ecume.laws import brownian_motion, drag
from ecume.models.law_codes import codes
from ecume.models.model import DIVERGED, DONE, EXCHANGE
from ecume.models.tracers import drag_laws
from ecume.models.tracers.drag_laws import DRAGS, DragChoice
from ecume.models.tracers.energy_budget import INACTIVE, has_budget, work_of_drifts, work_of_flights, work_of_noise
from ecume.models.tracers.noise_at_walls import accept_flights, reflect_noise
from ecume.models.tracers.parameters import CAPPED, Parameters, State, Workspace
from ecume.units import Array

admit(brownian_motion, drag, drag_laws)


STARTED_OUTSIDE = -2
UNBOUNDED = 1e100
"""A position (m) or speed (m/s) above this counts as diverged; products of larger ones would overflow."""


@compiled
def advance(parameters: Parameters, state: State, scratch: Workspace, steps: int) -> int:
    """Advance by `steps` steps: see `ecume.models.model.Model.advance`."""
    overdamped = parameters.bodies.overdamped
    for _ in range(steps):
        if not all_finite(state.position, state.velocity):
            return DIVERGED
        if select_regime(scratch.status, state.left, overdamped, 0) > 0 and not inertial_step(
            parameters, state, scratch
        ):
            return DIVERGED
        if select_regime(scratch.status, state.left, overdamped, 1) > 0 and not overdamped_step(
            parameters, state, scratch
        ):
            return DIVERGED
        if len(state.image) > 0:
            state.work[0] += wrap(parameters, state)
        state.step[0] += 1
        if inflow_due(parameters, state):
            return EXCHANGE
    return DONE


@compiled
def wrap(parameters: Parameters, state: State) -> float:
    """Wrap particles into the periodic box and count the periods. Returns the work of displacements along the vertical
    (J).
    """
    low, sides, work, last = parameters.periodic.low, parameters.periodic.sides, 0.0, state.position.shape[1] - 1
    for i in range(state.position.shape[0]):
        if state.left[i] >= 0:
            continue
        for axis in range(last + 1):
            if sides[axis] > 0.0:
                away = math.floor((state.position[i, axis] - low[axis]) / sides[axis])
                if away != 0.0:
                    state.position[i, axis] -= away * sides[axis]
                    state.image[i, axis] += int(away)
                    if axis == last:
                        work -= away * sides[axis] * parameters.bodies.mass[i] * parameters.bodies.apparent_gravity[i]
    return work


@compiled
def select_regime(status: Integers, left: Integers, overdamped: Integers, regime: int) -> int:
    """Set the status of particles: 0 for those of a regime that are in the tank, otherwise INACTIVE. Returns their
    number.
    """
    found = 0
    for i in range(status.shape[0]):
        status[i] = 0 if left[i] < 0 and overdamped[i] == regime else INACTIVE
        found += status[i] == 0
    return found


@compiled
def all_finite(position: Array, velocity: Array) -> bool:
    """Whether all positions and velocities are finite and below UNBOUNDED. Positions alone are not sufficient, since
    reflection returns any position to the tank.
    """
    for i in range(position.shape[0]):
        for axis in range(position.shape[1]):
            if not (abs(position[i, axis]) < UNBOUNDED and abs(velocity[i, axis]) < UNBOUNDED):
                return False
    return True


@compiled
def record_status(state: State, status: Integers) -> bool:
    """Record particles that left, and truncated flights. Returns False if a position started outside or is not
    finite.
    """
    left, tally = state.left, state.tally
    for i in range(status.shape[0]):
        if status[i] == STARTED_OUTSIDE:
            return False
        if status[i] < 0:
            tally[CAPPED] += 1
        elif 0 < status[i] < INACTIVE:
            left[i] = status[i] - 1
    return True


@compiled
def fill(target: Array, value: float) -> None:
    """Set all elements of an array."""
    for i in range(target.shape[0]):
        for axis in range(target.shape[1]):
            target[i, axis] = value


@compiled
def copy(target: Array, source: Array) -> None:
    """Copy all elements of an array."""
    for i in range(target.shape[0]):
        for axis in range(target.shape[1]):
            target[i, axis] = source[i, axis]


@compiled
def move_with(parameters: Parameters, state: State, scratch: Workspace, time: float, sheet: Sheet) -> bool:
    """Move particles without inertia for a time with the velocities in `travel`, reflected at walls."""
    copy(scratch.origin, state.position)
    tally, straight = (scratch.hits, scratch.status, state.hits), np.zeros((1, state.position.shape[1]))
    reflect_all(state.position, scratch.travel, straight, time, sheet, scratch.radius, tally)
    return record_status(state, scratch.status)


@compiled
def inertial_step(parameters: Parameters, state: State, scratch: Workspace) -> bool:
    """Perform one step of particles with inertia in a uniform or sheared flow."""
    fluid, last = parameters.fluid, state.position.shape[1] - 1
    flow, h = fluid.flow, parameters.time_step
    for i in range(len(scratch.status)):
        if scratch.status[i] == 0:
            for axis in range(last + 1):
                scratch.flow[i, axis] = flow[axis]
            scratch.flow[i, 0] += fluid.shear_rate * (state.position[i, last] + 0.5 * h * state.velocity[i, last])
    return fly(parameters, state, scratch)


@compiled
def fly(parameters: Parameters, state: State, scratch: Workspace) -> bool:
    """Perform one step of particles with inertia in a liquid with the velocities `flow` of the workspace."""
    bodies, fluid, h = parameters.bodies, parameters.fluid, parameters.time_step
    numbers = (h, state.step[0], parameters.seed, parameters.drag, fluid.density, fluid.viscosity, fluid.thermal)
    plan_flights(
        state.velocity,
        (bodies.mass, bodies.apparent_gravity, bodies.friction, bodies.radius, bodies.sphericity),
        scratch.status, scratch.acceleration, scratch.kick, scratch.noise, scratch.shift, scratch.external,
        scratch.flow, scratch.hindrance, numbers,
    )  # fmt: skip
    copy(scratch.origin, state.position)
    copy(scratch.travel, state.velocity)
    tally = (scratch.hits, scratch.status, state.hits)
    reflect_all(state.position, state.velocity, scratch.acceleration, h, parameters.bouncing, scratch.radius, tally)
    finish_step(
        state.position, state.velocity, scratch.origin, scratch.travel, scratch.acceleration, scratch.kick,
        scratch.noise, scratch.status, h,
    )  # fmt: skip
    if has_budget(parameters):
        state.work[0] += work_of_flights(parameters, state, scratch)
    return record_status(state, scratch.status)


@compiled
def overdamped_step(parameters: Parameters, state: State, scratch: Workspace) -> bool:
    """Perform one step of particles without inertia."""
    bodies, fluid, h = parameters.bodies, parameters.fluid, parameters.time_step
    flow = (fluid.flow[0], fluid.flow[1], fluid.flow[2], fluid.shear_rate)
    if fluid.thermal > 0.0:
        return diffusive_step(parameters, state, scratch, flow)
    plan_drifts(state.position, bodies.settling, scratch.status, 0.5 * h, flow, scratch.travel, scratch.flow)
    add_drifts(bodies.mass, bodies.friction, scratch.status, scratch.external, scratch.travel)
    well, budget = move_with(parameters, state, scratch, 0.5 * h, parameters.stopping), has_budget(parameters)
    if budget:
        state.work[0] += work_of_drifts(parameters, state, scratch, 0.5 * h)
    select_regime(scratch.status, state.left, bodies.overdamped, 1)
    plan_drifts(state.position, bodies.settling, scratch.status, 0.5 * h, flow, scratch.travel, scratch.flow)
    add_drifts(bodies.mass, bodies.friction, scratch.status, scratch.external, scratch.travel)
    well = move_with(parameters, state, scratch, 0.5 * h, parameters.stopping) and well
    if budget:
        state.work[0] += work_of_drifts(parameters, state, scratch, 0.5 * h)
    store_drift_velocities(state, scratch)
    return well


@compiled
def store_drift_velocities(state: State, scratch: Workspace) -> None:
    """Set the velocities of particles without inertia to those of their drift."""
    for i in range(len(scratch.status)):
        if scratch.status[i] == 0:
            for axis in range(state.velocity.shape[1]):
                state.velocity[i, axis] = scratch.travel[i, axis]


@compiled
def diffusive_step(
    parameters: Parameters, state: State, scratch: Workspace, flow: tuple[float, float, float, float]
) -> bool:
    """Perform one step of particles without inertia, with thermal noise."""
    bodies, fluid, h = parameters.bodies, parameters.fluid, parameters.time_step
    key, last = (parameters.seed, state.step[0], fluid.thermal), state.position.shape[1] - 1
    plan_drifts(state.position, bodies.settling, scratch.status, h, flow, scratch.travel, scratch.flow)
    add_drifts(bodies.mass, bodies.friction, scratch.status, scratch.external, scratch.travel)
    plan_steps(bodies.friction, scratch.status, key, h, scratch.noise)
    for i in range(len(scratch.status)):
        if scratch.status[i] == 0:
            # The shear flow at the mean height of the step, including noise.
            scratch.travel[i, 0] += flow[3] * 0.5 * h * scratch.noise[i, last]
            for axis in range(last + 1):
                scratch.travel[i, axis] += scratch.noise[i, axis]
    reflect_noise(parameters, state, scratch)
    well = move_with(parameters, state, scratch, h, parameters.mirroring)
    accept_flights(parameters, state, scratch)
    state.work[0] += work_of_noise(parameters, state, scratch, h)
    select_regime(scratch.status, state.left, bodies.overdamped, 1)
    plan_drifts(state.position, bodies.settling, scratch.status, 0.0, flow, scratch.travel, scratch.flow)
    add_drifts(bodies.mass, bodies.friction, scratch.status, scratch.external, scratch.travel)
    store_drift_velocities(state, scratch)
    return well


@compiled
def inflow_due(parameters: Parameters, state: State) -> bool:
    """Whether the next particle enters by the end of this step."""
    arrives = parameters.arrivals.step
    following = state.position.shape[0] - (len(parameters.bodies.radius) - len(arrives))
    return bool(following < len(arrives) and arrives[following] <= state.step[0])


# --- Free flight: exact for linear drag, constant force and thermal noise, for any time step

drag_factor = selection(
    "drag_factor", codes(DRAGS, lambda row: row.factor), __name__, __file__, ("reynolds", "sphericity")
)


@compiled_inside
def friction_at(speed: float, own: tuple[float, float, float], liquid: tuple[DragChoice, float, float]) -> float:
    """The friction at a speed; own = (radius, Stokes friction, sphericity), liquid = (drag law, density, viscosity)."""
    law, density, viscosity = liquid
    if law.linear:
        return own[1]
    reynolds = drag.particle_reynolds(speed, own[0], density, viscosity)
    return float(own[1] * drag_factor(reynolds, own[2], law.code))


@compiled_inside
def relative_speed(velocity: Array, i: int, flow: tuple[float, float, float], change: tuple[float, float]) -> float:
    """The speed relative to the liquid after a time; change = (fraction to which v - u has decayed, added settling
    speed).
    """
    square, last = 0.0, velocity.shape[1] - 1
    for axis in range(last + 1):
        own = change[0] * (velocity[i, axis] - flow[axis])
        if axis == last:
            own -= change[1]
        square += own * own
    return math.sqrt(square)


@compiled_inside
def midway_friction(
    velocity: Array,
    i: int,
    flow: tuple[float, float, float],
    body: tuple[tuple[float, float, float], float, float],
    liquid: tuple[DragChoice, float, float],
) -> float:
    """The friction at the speed in the middle of the step, so that nonlinear drag is of second
    order.

    body = ((radius, Stokes friction, sphericity), mass over half a step, apparent gravity times half a step).
    """
    own, inertia, fall = body
    friction = friction_at(relative_speed(velocity, i, flow, (1.0, 0.0)), own, liquid)
    if not liquid[0].linear:
        ratio = friction / inertia
        change = (math.exp(-ratio), fall * brownian_motion.velocity_gain(ratio))
        friction = friction_at(relative_speed(velocity, i, flow, change), own, liquid)
    return friction


@compiled_inside
def gains_of(ratio: float, mass: float, thermal: float) -> tuple[float, float, float, float, float]:
    """The gains of velocity and displacement by an acceleration, and the amplitudes of thermal noise: of the velocity
    (m/s), and of the displacement over the time step (m/s), in its parts correlated and uncorrelated with the velocity.
    `ratio` is the time step over the relaxation time.
    """
    gain, way = brownian_motion.velocity_gain(ratio), brownian_motion.displacement_gain(ratio)
    if thermal == 0.0 or ratio == 0.0:
        return gain, way, 0.0, 0.0, 0.0
    speed = math.sqrt(thermal / mass)
    fast = math.sqrt(brownian_motion.velocity_variance(ratio))
    both = brownian_motion.covariance(ratio) / fast
    far = math.sqrt(max(brownian_motion.displacement_variance(ratio) - both * both, 0.0))
    return gain, way, speed * fast, speed * both / ratio, speed * far / ratio


@compiled
def plan_flights(
    velocity: Array,
    bodies: tuple[Array, Array, Array, Array, Array],
    status: Integers,
    acceleration: Array,
    kick: Array,
    noise: Array,
    shift: Array,
    external: Array,
    liquid: Array,
    hindrance: Array,
    numbers: tuple[float, int, int, DragChoice, float, float, float],
) -> None:
    """Set the parabola of each particle with inertia, which has the exact final position.

    bodies = (mass, apparent gravity, Stokes friction, radius, sphericity); liquid: its velocities (m/s); hindrance:
    the friction along each axis over that without walls, or no rows; numbers = (time step, step, seed, drag law,
    density, viscosity, kT).
    """
    (mass, weight, stokes, radius, sphericity), last = bodies, velocity.shape[1] - 1
    h, step, seed, law, density, viscosity, thermal = numbers
    for i in range(velocity.shape[0]):
        if status[i] != 0:
            continue
        flow = (liquid[i, 0], liquid[i, 1], liquid[i, 2] if last > 1 else 0.0)
        body = ((radius[i], stokes[i], sphericity[i]), 2.0 * mass[i] / h, 0.5 * h * weight[i])
        friction = midway_friction(velocity, i, flow, body, (law, density, viscosity)) if stokes[i] > 0.0 else 0.0
        ratio = h * friction / mass[i]
        gain, way, fast, both, far = gains_of(ratio, mass[i], thermal)
        for axis in range(last + 1):
            rate = friction / mass[i]
            if hindrance.shape[0] > 0:
                rate *= hindrance[i, axis]
                gain, way, fast, both, far = gains_of(h * rate, mass[i], thermal)
            start = (flow[axis] - velocity[i, axis]) * rate + external[i, axis]
            if axis == last:
                start -= weight[i]
            acceleration[i, axis] = start * way
            kick[i, axis] = start * (gain - way) * h
            noise[i, axis], shift[i, axis] = 0.0, 0.0
            if fast > 0.0:
                one, other = normals(counter_of(i, step, axis), seed)
                random_displacement = h * (both * one + far * other)
                acceleration[i, axis] += 2.0 * random_displacement / (h * h)
                noise[i, axis], shift[i, axis] = fast * one - 2.0 * random_displacement / h, random_displacement


@compiled
def finish_step(
    position: Array,
    velocity: Array,
    origin: Array,
    travel: Array,
    acceleration: Array,
    kick: Array,
    noise: Array,
    status: Integers,
    time: float,
) -> None:
    """Set the velocities after the flights: the exact velocity for particles without collisions; particles with
    collisions keep their velocity, without thermal noise.
    """
    for i in range(position.shape[0]):
        if status[i] != 0:
            continue
        off, scale = 0.0, 0.0
        for axis in range(position.shape[1]):
            free = origin[i, axis] + time * travel[i, axis] + 0.5 * time * time * acceleration[i, axis]
            off = max(off, abs(position[i, axis] - free))
            scale = max(scale, abs(position[i, axis]) + abs(time * travel[i, axis]))
        for axis in range(position.shape[1]):
            velocity[i, axis] += noise[i, axis]
            if off <= 1e-13 * scale:
                velocity[i, axis] += kick[i, axis]
            else:
                kick[i, axis] = 0.0


@compiled
def plan_drifts(
    position: Array,
    settling: Array,
    status: Integers,
    time: float,
    flow: tuple[float, float, float, float],
    velocity: Array,
    liquid: Array,
) -> None:
    """Compute the velocities of particles without inertia, the sum of flow and settling, and those of the liquid."""
    last = position.shape[1] - 1
    for i in range(position.shape[0]):
        if status[i] == 0:
            height = position[i, last] - 0.5 * time * settling[i]
            for axis in range(last + 1):
                liquid[i, axis] = flow[axis]
            liquid[i, 0] += flow[3] * height
            for axis in range(last + 1):
                velocity[i, axis] = liquid[i, axis]
            velocity[i, last] -= settling[i]


@compiled
def add_drifts(mass: Array, friction: Array, status: Integers, external: Array, velocity: Array) -> None:
    """Add the drift of particles without inertia under external accelerations: the force over Stokes friction."""
    for i in range(velocity.shape[0]):
        if status[i] == 0:
            for axis in range(velocity.shape[1]):
                velocity[i, axis] += mass[i] / friction[i] * external[i, axis]


@compiled
def plan_steps(friction: Array, status: Integers, key: tuple[int, int, float], time: float, velocity: Array) -> None:
    """Set velocities for the diffusion in a time: a normal displacement of variance 2 D t along each axis; key = (seed,
    step, kT).
    """
    seed, step, thermal = key
    for i in range(velocity.shape[0]):
        if status[i] == 0:
            far = math.sqrt(2.0 * brownian_motion.diffusivity(thermal, friction[i]) / time)
            for axis in range(velocity.shape[1]):
                velocity[i, axis] = far * normals(counter_of(i, step, axis), seed)[0]
