"""Time integration of tracers.

With inertia, the flight of a step is exact without walls, and a parabola between collisions. Without inertia and noise,
a step is two halves of a drift that stops at walls. With noise it is drift and diffusion together, reflected at walls
by Lepingle's scheme, which is exact for flat walls and a constant drift, however long the step: the layer of settling
particles is right from contact on [lepingle1995].

The work of the liquid and of openings on tracers. Their energy minus this work never increases.

The power of the drag force G on a particle is G.v = G.u - (dissipation), with the liquid's velocity u; a flowing
liquid does at most the work of G.u, where u is constant during a step, as in the flight. In a step with a collision the
drag continues as in free flight and may do more work in a flow, G.v, which then counts. A liquid at rest does no work:
energy gained from drag after a bounce is an error, and is detected as one. Thermal noise adds heat, the difference of
the energies with and without it. Particles that enter or leave carry their energy. Tracers without inertia have no
kinetic energy: their velocity in a frame is that of the liquid.
"""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import admit, compiled, compiled_inside, selection
from ecume._portable import dot
from ecume.engine.cells import Integers
from ecume.engine.philox import counter_of, counter_of_pair, normals, uniforms
from ecume.engine.walls import Sheet, reflect_all
from ecume.engine.walls.sheets import hole_at, inward_normal, piece_gap, plus, put, row, scaled
from ecume.laws import diffusion, drag
from ecume.models.model import DIVERGED, DONE, EXCHANGE, codes
from ecume.models.tracers import parameters
from ecume.models.tracers.parameters import CAPPED, DRAGS, DragChoice, Parameters, State, Workspace, came
from ecume.units import Array

NOT_NOW = 1 << 40
"""The fate of particles that a passage excludes."""


@compiled
def has_budget(parameters: Parameters) -> bool:
    """Whether the liquid flows or has thermal noise, or particles may leave."""
    return bool(stirred(parameters) or len(parameters.bouncing.hole) > 0)


@compiled
def stirred(parameters: Parameters) -> bool:
    """Whether the liquid flows or kicks."""
    flow, fluid = parameters.fluid.flow, parameters.fluid
    return bool(fluid.thermal > 0.0 or fluid.shear_rate != 0.0 or flow[0] != 0.0 or flow[1] != 0.0 or flow[2] != 0.0)


@compiled
def flow_at(parameters: Parameters, height: float, axis: int) -> float:
    """A component of the liquid's velocity (m/s)."""
    fluid = parameters.fluid
    speed: float = fluid.flow[axis] + (fluid.shear_rate * height if axis == 0 else 0.0)
    return speed


@compiled
def work_of_flights(parameters: Parameters, state: State, scratch: Workspace) -> float:
    """Work on tracers with inertia in their step (J)."""
    total, bodies, moved = 0.0, parameters.bodies, stirred(parameters)
    for i in range(len(scratch.fate)):
        if scratch.fate[i] <= 0:
            if moved:
                carried = carry_of_flight(parameters, state, scratch, i)
                total += bodies.mass[i] * (carried + heat_of_flight(parameters, state, scratch, i))
        elif scratch.fate[i] < NOT_NOW:
            total -= bodies.mass[i] * energy_before(parameters, scratch, i)
    return total


@compiled
def energy_before(parameters: Parameters, scratch: Workspace, i: int) -> float:
    """Energy of a tracer with inertia at the start of the step, per mass (J/kg)."""
    last = scratch.origin.shape[1] - 1
    energy: float = parameters.bodies.push[i] * scratch.origin[i, last]
    for axis in range(last + 1):
        energy += 0.5 * scratch.travel[i, axis] ** 2
    return energy


@compiled
def carry_of_flight(parameters: Parameters, state: State, scratch: Workspace, i: int) -> float:
    """The impulse of the steady drag times the liquid's velocity, or its force along the way, per mass (J/kg)."""
    h, last, by_flow, along = parameters.time_step, scratch.origin.shape[1] - 1, 0.0, 0.0
    height = scratch.origin[i, last] + 0.5 * h * scratch.travel[i, last]
    for axis in range(last + 1):
        impulse = h * scratch.push[i, axis] - 2.0 * scratch.shift[i, axis] / h + scratch.kick[i, axis]
        impulse -= h * scratch.external[i, axis]
        if axis == last:
            impulse += h * parameters.bodies.push[i]
        by_flow += impulse * flow_at(parameters, height, axis)
        along += impulse / h * (state.position[i, axis] - scratch.origin[i, axis])
    return max(by_flow, along) if scratch.hits[i] > 0 else by_flow


@compiled
def heat_of_flight(parameters: Parameters, state: State, scratch: Workspace, i: int) -> float:
    """Work of thermal noise per mass (J/kg): exact in free flight; with wall collisions, that along the parabola."""
    h, last, heat = parameters.time_step, scratch.origin.shape[1] - 1, 0.0
    for axis in range(last + 1):
        shift, kicked = scratch.shift[i, axis], scratch.noise[i, axis]
        if scratch.hits[i] > 0:
            heat += 2.0 * shift / (h * h) * (state.position[i, axis] - scratch.origin[i, axis])
        else:
            kicked += 2.0 * shift / h
            heat += parameters.bodies.push[i] * shift if axis == last else 0.0
        heat += kicked * (state.velocity[i, axis] - 0.5 * kicked)
    return heat


@compiled
def work_of_drifts(parameters: Parameters, state: State, scratch: Workspace, time: float) -> float:
    """Work on tracers without inertia during a time (J): the drag times the velocity of the liquid."""
    total, bodies, last = 0.0, parameters.bodies, state.position.shape[1] - 1
    for i in range(len(scratch.fate)):
        start, weight = scratch.origin[i, last], bodies.mass[i] * bodies.push[i]
        if scratch.fate[i] <= 0:
            friction = weight / bodies.settling[i] if bodies.settling[i] != 0.0 else bodies.friction[i]
            height = start - 0.5 * time * bodies.settling[i]
            for axis in range(last + 1):
                flow = flow_at(parameters, height, axis)
                behind = time * flow - (state.position[i, axis] - scratch.origin[i, axis])
                total += friction * behind * flow
        elif scratch.fate[i] < NOT_NOW:
            total -= weight * start
    return total


@compiled
def work_of_noise(parameters: Parameters, state: State, scratch: Workspace) -> float:
    """Work on tracers without inertia during a step with thermal noise (J): their gain of potential energy, and what
    the liquid dissipates while they settle.
    """
    total, bodies, last = 0.0, parameters.bodies, state.position.shape[1] - 1
    for i in range(len(scratch.fate)):
        start, weight = scratch.origin[i, last], bodies.mass[i] * bodies.push[i]
        if scratch.fate[i] <= 0:
            total += weight * (state.position[i, last] - start + parameters.time_step * bodies.settling[i])
        elif scratch.fate[i] < NOT_NOW:
            total -= weight * start
    return total


def brings(parameters: Parameters) -> bool:
    """Whether there is anything that may bring energy, or take it away."""
    return bool(has_budget(parameters) or np.any(parameters.bodies.overdamped))


def lent(parameters: Parameters, state: State) -> float:
    """The energy of motion of those inside who have no inertia (J)."""
    some = (state.left < 0) & (parameters.bodies.overdamped[: len(state.left)] == 1)
    mass = parameters.bodies.mass[: len(state.left)][some]
    return 0.5 * float(np.sum(mass * (state.velocity[some] ** 2).sum(axis=1)))


def exchange(parameters: Parameters, state: State) -> State:
    """The state with all particles that have entered by now, and their energy in the budget."""
    arrivals, first, bodies = parameters.arrivals, came(parameters, state), parameters.bodies
    last = int(np.searchsorted(arrivals.step, int(state.step[0]), side="right"))
    position, velocity = arrivals.position[first:last], arrivals.velocity[first:last]
    here = slice(len(state.left), len(state.left) + last - first)
    moving = 0.5 * (velocity**2).sum(axis=1) * (bodies.overdamped[here] == 0)
    brought = dot(bodies.mass[here], moving + bodies.push[here] * position[:, -1])
    return state._replace(
        position=np.concatenate([state.position, position]),
        velocity=np.concatenate([state.velocity, velocity]),
        left=np.concatenate([state.left, np.full(last - first, -1, np.int64)]),
        work=state.work + brought,
    )


admit(diffusion, drag, parameters)

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
    """Mark particles that left, and flights that were truncated. False if a position is outside or not finite."""
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
        scratch.push, scratch.kick, scratch.noise, scratch.shift, scratch.external, numbers,
    )  # fmt: skip
    copy(scratch.origin, state.position)
    copy(scratch.travel, state.velocity)
    tally = (scratch.hits, scratch.fate, state.hits)
    reflect_all(state.position, state.velocity, scratch.push, h, parameters.bouncing, scratch.radius, tally)
    land(
        state.position, state.velocity, scratch.origin, scratch.travel, scratch.push, scratch.kick, scratch.noise,
        scratch.fate, h,
    )  # fmt: skip
    if has_budget(parameters):
        state.work[0] += work_of_flights(parameters, state, scratch)
    return note_fates(state, scratch.fate)


@compiled
def creep(parameters: Parameters, state: State, scratch: Workspace) -> bool:
    """One step of those without inertia."""
    bodies, fluid, h = parameters.bodies, parameters.fluid, parameters.time_step
    flow = (fluid.flow[0], fluid.flow[1], fluid.flow[2], fluid.shear_rate)
    if fluid.thermal > 0.0:
        return diffuse(parameters, state, scratch, flow)
    plan_drifts(state.position, bodies.settling, scratch.fate, 0.5 * h, flow, scratch.travel)
    add_drifts(bodies.mass, bodies.friction, scratch.fate, scratch.external, scratch.travel)
    well, budget = passed(parameters, state, scratch, 0.5 * h, parameters.stopping), has_budget(parameters)
    if budget:
        state.work[0] += work_of_drifts(parameters, state, scratch, 0.5 * h)
    choose(scratch.fate, state.left, bodies.overdamped, 1)
    plan_drifts(state.position, bodies.settling, scratch.fate, 0.5 * h, flow, scratch.travel)
    add_drifts(bodies.mass, bodies.friction, scratch.fate, scratch.external, scratch.travel)
    well = passed(parameters, state, scratch, 0.5 * h, parameters.stopping) and well
    if budget:
        state.work[0] += work_of_drifts(parameters, state, scratch, 0.5 * h)
    keep_drifts(state, scratch)
    return well


@compiled
def keep_drifts(state: State, scratch: Workspace) -> None:
    """The velocity of particles without inertia is that of their drift."""
    for i in range(len(scratch.fate)):
        if scratch.fate[i] == 0:
            for axis in range(state.velocity.shape[1]):
                state.velocity[i, axis] = scratch.travel[i, axis]


@compiled
def diffuse(parameters: Parameters, state: State, scratch: Workspace, flow: tuple[float, float, float, float]) -> bool:
    """One step of those without inertia, with thermal noise."""
    bodies, fluid, h = parameters.bodies, parameters.fluid, parameters.time_step
    chance, last = (parameters.seed, state.step[0], fluid.thermal), state.position.shape[1] - 1
    plan_drifts(state.position, bodies.settling, scratch.fate, h, flow, scratch.travel)
    add_drifts(bodies.mass, bodies.friction, scratch.fate, scratch.external, scratch.travel)
    plan_steps(bodies.friction, scratch.fate, chance, h, scratch.noise)
    for i in range(len(scratch.fate)):
        if scratch.fate[i] == 0:
            # The shear at the middle of the step, noise included.
            scratch.travel[i, 0] += flow[3] * 0.5 * h * scratch.noise[i, last]
            for axis in range(last + 1):
                scratch.travel[i, axis] += scratch.noise[i, axis]
    reflect_noise(parameters, state, scratch)
    well = passed(parameters, state, scratch, h, parameters.mirroring)
    state.work[0] += work_of_noise(parameters, state, scratch)
    choose(scratch.fate, state.left, bodies.overdamped, 1)
    plan_drifts(state.position, bodies.settling, scratch.fate, 0.0, flow, scratch.travel)
    add_drifts(bodies.mass, bodies.friction, scratch.fate, scratch.external, scratch.travel)
    keep_drifts(state, scratch)
    return well


@compiled
def reflect_noise(parameters: Parameters, state: State, scratch: Workspace) -> None:
    """Add to the velocities what turns them back at walls and obstacles: see `diffusion.reflected_gain`."""
    sheet, h, thermal = parameters.mirroring, parameters.time_step, parameters.fluid.thermal
    kind, number, hole, part = sheet.kind, sheet.number, sheet.hole, sheet.part
    for i in range(len(scratch.fate)):
        if scratch.fate[i] != 0:
            continue
        variance, radius = 2.0 * diffusion.diffusivity(thermal, parameters.bodies.friction[i]) * h, scratch.radius[i]
        x, way = row(state.position, i), scaled(h, row(scratch.travel, i))
        k, piece = 0, 0
        while k < kind.shape[0]:
            before, nearest, following = piece_gap(kind, number, k, x, 0.0)
            after = piece_gap(kind, number, k, plus(x, 1.0, way), 0.0)[0] - radius
            gap, k, piece = max(before - radius, 0.0), following, piece + 1
            # Beyond this, paths meet with a probability below exp(-40).
            if after > 0.0 and gap * after > 20.0 * variance:
                continue
            normal = inward_normal(kind, number, nearest, x, 0.0)
            share = min(gap / (gap - after), 1.0) if after < 0.0 else 0.5
            foot = plus(plus(x, share, way), -radius if after < 0.0 else -0.5 * (gap + after) - radius, normal)
            if hole_at(hole, part, number, nearest, (foot, 0.0)) >= 0:
                continue
            draw = uniforms(counter_of_pair(i, piece, int(state.step[0]), 0), parameters.seed)[0]
            end = diffusion.reflected_gain(after - gap, variance, -math.log(draw))
            if end > after:
                way = plus(way, end - after, normal)
                state.hits[nearest] += 1
        put(scratch.travel, i, scaled(1.0 / h, way))


@compiled
def somebody_comes(parameters: Parameters, state: State) -> bool:
    """Whether the next in turn is there at the end of this step."""
    arrives = parameters.arrivals.step
    following = state.position.shape[0] - (len(parameters.bodies.radius) - len(arrives))
    return bool(following < len(arrives) and arrives[following] <= state.step[0])


@compiled
def advance(parameters: Parameters, state: State, scratch: Workspace, steps: int) -> int:
    """Integrate: see `ecume.models.model.Model.advance`."""
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


# --- What a step would be without walls: exact for linear drag, a constant push and the liquid's kicks, however long

drag_factor = selection("drag_factor", codes(DRAGS, lambda row: row.factor), __name__, __file__, ("reynolds",))


@compiled_inside
def slowed(speed: float, own: tuple[float, float], liquid: tuple[DragChoice, float, float]) -> float:
    """The friction at a speed; own = (radius, Stokes's friction), liquid = (drag law, density, viscosity)."""
    law, density, viscosity = liquid
    if law.linear:
        return own[1]
    return float(own[1] * drag_factor(drag.particle_reynolds(speed, own[0], density, viscosity), law.code))


@compiled_inside
def relative_speed(velocity: Array, i: int, flow: tuple[float, float, float], change: tuple[float, float]) -> float:
    """Against the liquid, after v - u has shrunk to a part and the fall has gained a speed; change = (part, gain)."""
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
    body: tuple[float, float, float, float],
    liquid: tuple[DragChoice, float, float],
) -> float:
    """The friction at the speed in the middle of the step, so that a drag that is no line is of second order.

    body = (radius, Stokes's friction, mass over half a step, push times half a step).
    """
    radius, stokes, inertia, fall = body
    friction = slowed(relative_speed(velocity, i, flow, (1.0, 0.0)), (radius, stokes), liquid)
    if not liquid[0].linear:
        ratio = friction / inertia
        change = (math.exp(-ratio), fall * diffusion.velocity_gain(ratio))
        friction = slowed(relative_speed(velocity, i, flow, change), (radius, stokes), liquid)
    return friction


@compiled
def plan_flights(
    position: Array,
    velocity: Array,
    mass: Array,
    weight: Array,
    stokes: Array,
    radius: Array,
    fate: Integers,
    push: Array,
    kick: Array,
    noise: Array,
    shift: Array,
    external: Array,
    numbers: tuple[float, int, int, DragChoice, float, float, float, float, float, float, float],
) -> None:
    """The parabola of each particle with inertia: it ends where the exact motion ends.

    numbers = (time step, step, seed, drag law, liquid's density, viscosity, thermal energy, flow x, y, z, shear rate).
    """
    h, step, seed, law, density, viscosity, thermal, flow_x, flow_y, flow_z, shear = numbers
    last = position.shape[1] - 1
    for i in range(position.shape[0]):
        if fate[i] != 0:
            continue
        height = position[i, last] + 0.5 * h * velocity[i, last]
        flow = (flow_x + shear * height, flow_y, flow_z)
        body = (radius[i], stokes[i], 2.0 * mass[i] / h, 0.5 * h * weight[i])
        friction = midway_friction(velocity, i, flow, body, (law, density, viscosity)) if stokes[i] > 0.0 else 0.0
        ratio = h * friction / mass[i]
        gain, way = diffusion.velocity_gain(ratio), diffusion.displacement_gain(ratio)
        fast, far, both = 0.0, 0.0, 0.0
        if thermal > 0.0 and friction > 0.0:
            fast = math.sqrt(thermal / mass[i] * diffusion.velocity_variance(ratio))
            both = thermal / friction * diffusion.covariance(ratio) / fast
            far = thermal * mass[i] / (friction * friction) * diffusion.displacement_variance(ratio) - both * both
            far = math.sqrt(max(far, 0.0))
        for axis in range(last + 1):
            start = (flow[axis] - velocity[i, axis]) * friction / mass[i] + external[i, axis]
            if axis == last:
                start -= weight[i]
            push[i, axis] = start * way
            kick[i, axis] = start * (gain - way) * h
            noise[i, axis], shift[i, axis] = 0.0, 0.0
            if fast > 0.0:
                one, other = normals(counter_of(i, step, axis), seed)
                way_by_chance = both * one + far * other
                push[i, axis] += 2.0 * way_by_chance / (h * h)
                noise[i, axis], shift[i, axis] = fast * one - 2.0 * way_by_chance / h, way_by_chance


@compiled
def land(
    position: Array,
    velocity: Array,
    origin: Array,
    travel: Array,
    push: Array,
    kick: Array,
    noise: Array,
    fate: Integers,
    time: float,
) -> None:
    """After the flights: a particle without collisions gets the exact velocity; one with collisions keeps its velocity,
    without thermal noise.
    """
    for i in range(position.shape[0]):
        if fate[i] != 0:
            continue
        off, scale = 0.0, 0.0
        for axis in range(position.shape[1]):
            free = origin[i, axis] + time * travel[i, axis] + 0.5 * time * time * push[i, axis]
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
    fate: Integers,
    time: float,
    flow: tuple[float, float, float, float],
    velocity: Array,
) -> None:
    """The velocity of what has no inertia: with the liquid, and down at the terminal speed."""
    last = position.shape[1] - 1
    for i in range(position.shape[0]):
        if fate[i] == 0:
            height = position[i, last] - 0.5 * time * settling[i]
            for axis in range(last + 1):
                velocity[i, axis] = flow[axis]
            velocity[i, 0] += flow[3] * height
            velocity[i, last] -= settling[i]


@compiled
def add_drifts(mass: Array, friction: Array, fate: Integers, external: Array, velocity: Array) -> None:
    """Add the velocity of what has no inertia by an acceleration: the force over Stokes's friction."""
    for i in range(velocity.shape[0]):
        if fate[i] == 0:
            for axis in range(velocity.shape[1]):
                velocity[i, axis] += mass[i] / friction[i] * external[i, axis]


@compiled
def plan_steps(friction: Array, fate: Integers, chance: tuple[int, int, float], time: float, velocity: Array) -> None:
    """Diffusion as a velocity: a normal displacement of variance 2 D t along each axis; chance = (seed, step, kT)."""
    seed, step, thermal = chance
    for i in range(velocity.shape[0]):
        if fate[i] == 0:
            far = math.sqrt(2.0 * diffusion.diffusivity(thermal, friction[i]) / time)
            for axis in range(velocity.shape[1]):
                velocity[i, axis] = far * normals(counter_of(i, step, axis), seed)[0]
