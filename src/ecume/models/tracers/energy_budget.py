"""The energy budget of tracers: the work of the liquid and of openings. Energy minus this work never increases.

The power of the drag force G on a particle is G.v = G.u - (dissipation), with the velocity u of the liquid. A flowing
liquid does at most the work of G.u, where u is constant during a step, as in the flight. In a step with a collision the
drag continues as in free flight and may do more work, that of G.v, which then counts. A liquid at rest does no work:
energy gained from drag after a bounce is detected as an error. Thermal noise adds heat, the difference of the energies
with and without it. Particles that enter or leave carry their energy. Tracers without inertia have no kinetic energy:
their velocity in a frame is that of the liquid.
"""

from __future__ import annotations

import numpy as np

from ecume._jit import compiled
from ecume._portable import dot
from ecume.models.tracers.parameters import Parameters, State, Workspace, entered_count

INACTIVE = 1 << 40
"""Status of particles that do not take part in a step."""


@compiled
def has_budget(parameters: Parameters) -> bool:
    """Whether the liquid flows, there is thermal noise, or particles may leave."""
    return bool(is_driven(parameters) or len(parameters.bouncing.hole) > 0)


@compiled
def is_driven(parameters: Parameters) -> bool:
    """Whether the liquid flows or there is thermal noise."""
    flow, fluid = parameters.fluid.flow, parameters.fluid
    moves = fluid.shear_rate != 0.0 or flow[0] != 0.0 or flow[1] != 0.0 or flow[2] != 0.0 or fluid.varies
    return bool(fluid.thermal > 0.0 or moves)


@compiled
def work_of_flights(parameters: Parameters, state: State, scratch: Workspace) -> float:
    """Work on tracers with inertia in a step (J)."""
    total, bodies, moved = 0.0, parameters.bodies, is_driven(parameters)
    for i in range(len(scratch.status)):
        if scratch.status[i] <= 0:
            if moved:
                carried = carry_of_flight(parameters, state, scratch, i)
                total += bodies.mass[i] * (carried + heat_of_flight(parameters, state, scratch, i))
        elif scratch.status[i] < INACTIVE:
            total -= bodies.mass[i] * energy_before(parameters, scratch, i)
    return total


@compiled
def energy_before(parameters: Parameters, scratch: Workspace, i: int) -> float:
    """The energy per mass (J/kg) at the start of the step of a tracer with inertia."""
    last = scratch.origin.shape[1] - 1
    energy: float = parameters.bodies.apparent_gravity[i] * scratch.origin[i, last]
    for axis in range(last + 1):
        energy += 0.5 * scratch.travel[i, axis] ** 2
    return energy


@compiled
def carry_of_flight(parameters: Parameters, state: State, scratch: Workspace, i: int) -> float:
    """Work of the flow per mass (J/kg): the impulse of the steady drag times the velocity of the liquid; after a
    collision at least the work of this drag along the path.
    """
    h, last, by_flow, along = parameters.time_step, scratch.origin.shape[1] - 1, 0.0, 0.0
    for axis in range(last + 1):
        impulse = h * scratch.acceleration[i, axis] - 2.0 * scratch.shift[i, axis] / h + scratch.kick[i, axis]
        impulse -= h * scratch.external[i, axis]
        if axis == last:
            impulse += h * parameters.bodies.apparent_gravity[i]
        by_flow += impulse * scratch.flow[i, axis]
        along += impulse / h * (state.position[i, axis] - scratch.origin[i, axis])
    return max(by_flow, along) if scratch.hits[i] > 0 else by_flow


@compiled
def heat_of_flight(parameters: Parameters, state: State, scratch: Workspace, i: int) -> float:
    """The work of thermal noise per mass (J/kg): exact in free flight; after wall collisions, the work along the
    parabola.
    """
    h, last, heat = parameters.time_step, scratch.origin.shape[1] - 1, 0.0
    for axis in range(last + 1):
        shift, kicked = scratch.shift[i, axis], scratch.noise[i, axis]
        if scratch.hits[i] > 0:
            heat += 2.0 * shift / (h * h) * (state.position[i, axis] - scratch.origin[i, axis])
        else:
            kicked += 2.0 * shift / h
            heat += parameters.bodies.apparent_gravity[i] * shift if axis == last else 0.0
        heat += kicked * (state.velocity[i, axis] - 0.5 * kicked)
    return heat


@compiled
def work_of_drifts(parameters: Parameters, state: State, scratch: Workspace, time: float) -> float:
    """Work on tracers without inertia during a time (J): drag times the velocity of the liquid."""
    total, bodies, last = 0.0, parameters.bodies, state.position.shape[1] - 1
    for i in range(len(scratch.status)):
        start, weight = scratch.origin[i, last], bodies.mass[i] * bodies.apparent_gravity[i]
        if scratch.status[i] <= 0:
            friction = weight / bodies.settling[i] if bodies.settling[i] != 0.0 else bodies.friction[i]
            for axis in range(last + 1):
                flow = scratch.flow[i, axis]
                behind = time * flow - (state.position[i, axis] - scratch.origin[i, axis])
                total += friction * behind * flow
        elif scratch.status[i] < INACTIVE:
            total -= weight * start
    return total


@compiled
def work_of_noise(parameters: Parameters, state: State, scratch: Workspace, time: float) -> float:
    """Work on tracers without inertia in a step with thermal noise (J): the change of potential energy, plus the
    dissipation by settling in a time.
    """
    total, bodies, last = 0.0, parameters.bodies, state.position.shape[1] - 1
    for i in range(len(scratch.status)):
        start, weight = scratch.origin[i, last], bodies.mass[i] * bodies.apparent_gravity[i]
        if scratch.status[i] <= 0:
            total += weight * (state.position[i, last] - start + time * bodies.settling[i])
        elif scratch.status[i] < INACTIVE:
            total -= weight * start
    return total


def has_external_work(parameters: Parameters) -> bool:
    """Whether any process may add or remove energy."""
    return bool(has_budget(parameters) or np.any(parameters.bodies.overdamped))


def overdamped_kinetic_energy(parameters: Parameters, state: State) -> float:
    """The kinetic energy (J) of the velocities that frames contain for tracers without inertia."""
    some = (state.left < 0) & (parameters.bodies.overdamped[: len(state.left)] == 1)
    mass = parameters.bodies.mass[: len(state.left)][some]
    return 0.5 * float(np.sum(mass * (state.velocity[some] ** 2).sum(axis=1)))


def exchange(parameters: Parameters, state: State) -> State:
    """The state with all particles that have entered so far, and with their energy in the budget."""
    arrivals, first, bodies = parameters.arrivals, entered_count(parameters, state), parameters.bodies
    last = int(np.searchsorted(arrivals.step, int(state.step[0]), side="right"))
    position, velocity = arrivals.position[first:last], arrivals.velocity[first:last]
    here = slice(len(state.left), len(state.left) + last - first)
    moving = 0.5 * (velocity**2).sum(axis=1) * (bodies.overdamped[here] == 0)
    brought = dot(bodies.mass[here], moving + bodies.apparent_gravity[here] * position[:, -1])
    return state._replace(
        position=np.concatenate([state.position, position]),
        velocity=np.concatenate([state.velocity, velocity]),
        left=np.concatenate([state.left, np.full(last - first, -1, np.int64)]),
        work=state.work + brought,
        image=np.concatenate([state.image, np.zeros_like(position, np.int64)]) if len(state.image) else state.image,
    )
