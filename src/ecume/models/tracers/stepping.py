"""One step of the tracers, and the march of many.

With inertia: the flight of the step is exact without walls, and a parabola between them. Without: half a drift, whole
diffusion, half a drift, each turned back by the walls in the way that is exact for it alone (a drift stops there, a
diffusing particle is mirrored).
"""

from __future__ import annotations

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.engine.walls import Sheet, reflect_all
from ecume.models.model import DIVERGED, DONE, EXCHANGE
from ecume.models.tracers.flights import land, plan_drifts, plan_flights, plan_steps
from ecume.models.tracers.parameters import Parameters
from ecume.models.tracers.state import CAPPED, State, Workspace
from ecume.models.tracers.work import NOT_NOW, booked, work_of_drifts, work_of_flights, work_of_steps
from ecume.units import Array

STARTED_OUTSIDE = -2
NOWHERE = 1e100
"""m, m/s: farther and faster than anybody gets; products of such numbers are no numbers any more."""


@compiled
def choose(fate: Integers, left: Integers, overdamped: Integers, regime: int) -> int:
    """Mark who takes part: those of a regime that are still in the tank. How many they are."""
    found = 0
    for i in range(fate.shape[0]):
        fate[i] = 0 if left[i] < 0 and overdamped[i] == regime else NOT_NOW
        found += fate[i] == 0
    return found


@compiled
def all_somewhere(position: Array, velocity: Array) -> bool:
    """Whether places and velocities are numbers, and not larger than can be: walls would put anybody back inside."""
    for i in range(position.shape[0]):
        for axis in range(position.shape[1]):
            if not (abs(position[i, axis]) < NOWHERE and abs(velocity[i, axis]) < NOWHERE):
                return False
    return True


@compiled
def note_fates(state: State, fate: Integers) -> bool:
    """Who left, and whose flight was cut short. False when somebody was outside, or nowhere."""
    left, tally = state.left, state.tally
    for i in range(fate.shape[0]):
        if fate[i] == STARTED_OUTSIDE:
            return False
        if fate[i] < 0:
            tally[CAPPED] += 1
        elif 0 < fate[i] < NOT_NOW:
            left[i] = fate[i] - 1
    return True


@compiled
def fill(target: Array, value: float) -> None:
    """All of an array."""
    for i in range(target.shape[0]):
        for axis in range(target.shape[1]):
            target[i, axis] = value


@compiled
def copy(target: Array, source: Array) -> None:
    """All of an array."""
    for i in range(target.shape[0]):
        for axis in range(target.shape[1]):
            target[i, axis] = source[i, axis]


@compiled
def passed(parameters: Parameters, state: State, scratch: Workspace, time: float, sheet: Sheet) -> bool:
    """Those without inertia go on with the velocities of `travel`."""
    fill(scratch.push, 0.0)
    copy(scratch.origin, state.position)
    tally = (scratch.hits, scratch.fate, state.hits)
    reflect_all(state.position, scratch.travel, scratch.push, time, sheet, scratch.radius, tally)
    return note_fates(state, scratch.fate)


@compiled
def fly(parameters: Parameters, state: State, scratch: Workspace) -> bool:
    """One step of those with inertia."""
    bodies, fluid, h = parameters.bodies, parameters.fluid, parameters.time_step
    flow = fluid.flow
    numbers = (
        h, state.step[0], parameters.seed, parameters.drag, fluid.density, fluid.viscosity, fluid.thermal,
        flow[0], flow[1], flow[2], fluid.shear_rate,
    )  # fmt: skip
    plan_flights(
        state.position, state.velocity, bodies.mass, bodies.push, bodies.friction, bodies.radius, scratch.fate,
        scratch.push, scratch.kick, scratch.noise, scratch.shift, numbers,
    )  # fmt: skip
    copy(scratch.origin, state.position)
    copy(scratch.travel, state.velocity)
    tally = (scratch.hits, scratch.fate, state.hits)
    reflect_all(state.position, state.velocity, scratch.push, h, parameters.bouncing, scratch.radius, tally)
    land(
        state.position, state.velocity, scratch.origin, scratch.travel, scratch.push, scratch.kick, scratch.noise,
        scratch.fate, h,
    )  # fmt: skip
    if booked(parameters):
        state.work[0] += work_of_flights(parameters, state, scratch)
    return note_fates(state, scratch.fate)


@compiled
def creep(parameters: Parameters, state: State, scratch: Workspace) -> bool:
    """One step of those without inertia."""
    bodies, fluid, h = parameters.bodies, parameters.fluid, parameters.time_step
    flow = (fluid.flow[0], fluid.flow[1], fluid.flow[2], fluid.shear_rate)
    plan_drifts(state.position, bodies.settling, scratch.fate, 0.5 * h, flow, scratch.travel)
    well, books = passed(parameters, state, scratch, 0.5 * h, parameters.stopping), booked(parameters)
    if books:
        state.work[0] += work_of_drifts(parameters, state, scratch, 0.5 * h)
    if fluid.thermal > 0.0:
        choose(scratch.fate, state.left, bodies.overdamped, 1)
        chance = (parameters.seed, state.step[0], fluid.thermal)
        plan_steps(bodies.friction, scratch.fate, chance, h, scratch.travel)
        well = passed(parameters, state, scratch, h, parameters.mirroring) and well
        state.work[0] += work_of_steps(parameters, state, scratch)
    choose(scratch.fate, state.left, bodies.overdamped, 1)
    plan_drifts(state.position, bodies.settling, scratch.fate, 0.5 * h, flow, scratch.travel)
    well = passed(parameters, state, scratch, 0.5 * h, parameters.stopping) and well
    if books:
        state.work[0] += work_of_drifts(parameters, state, scratch, 0.5 * h)
    for i in range(len(scratch.fate)):
        if scratch.fate[i] == 0:
            for axis in range(state.velocity.shape[1]):
                state.velocity[i, axis] = scratch.travel[i, axis]
    return well


@compiled
def somebody_comes(parameters: Parameters, state: State) -> bool:
    """Whether the next in turn is there at the end of this step."""
    arrives = parameters.arrivals.step
    following = state.position.shape[0] - (len(parameters.bodies.radius) - len(arrives))
    return bool(following < len(arrives) and arrives[following] <= state.step[0])


@compiled
def advance(parameters: Parameters, state: State, scratch: Workspace, steps: int) -> int:
    """March: see `ecume.models.model.Model.advance`."""
    overdamped = parameters.bodies.overdamped
    for _ in range(steps):
        if not all_somewhere(state.position, state.velocity):
            return DIVERGED
        if choose(scratch.fate, state.left, overdamped, 0) > 0 and not fly(parameters, state, scratch):
            return DIVERGED
        if choose(scratch.fate, state.left, overdamped, 1) > 0 and not creep(parameters, state, scratch):
            return DIVERGED
        state.step[0] += 1
        if somebody_comes(parameters, state):
            return EXCHANGE
    return DONE
