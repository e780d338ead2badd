"""Floats that are not round: their constants and workspace, and the forces and torques on the charges inside their
contact lines, their motion and their contacts.

Translation and rotation in a time step: kicks and drift of three velocities for each body. Drag acts along the axis,
across it and on the spin, each solved exactly for a constant force during the kick. Thermal noise has the variance 2
kT/zeta dt along each of the three; since the frictions depend on the angle alone, and no force on the center turns a
body, the drift kT div M vanishes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, compiled, composed
from ecume.engine.cells import Integers
from ecume.engine.contact import torque_contacts as touching
from ecume.engine.contact.contacts import apart, deepest_overlap
from ecume.engine.contact.separation import separate
from ecume.engine.contact.torque_contacts import OutlinedBodies, TorqueContacts
from ecume.engine.neighbors import NeighborLists
from ecume.engine.outlines import Outlines, Stance
from ecume.engine.philox import counter_of, counter_of_pair, normals, uniforms
from ecume.engine.walls import wall_count
from ecume.laws import brownian_motion, capillarity, contact_lines, moving_dish, special
from ecume.laws.brownian_motion import diffusivity, reflected_gain
from ecume.laws.capillarity import pair_energy, pair_force
from ecume.laws.contact_lines import spin_in_flow
from ecume.laws.moving_dish import sway_acceleration, sway_velocity
from ecume.models.floating.contacts.collisions import (
    Outlined,
    bounce,
    require_gaps,
    require_rest,
    solve_contacts,
    still,
)
from ecume.models.floating.dishes import acts, wall_energy, wall_force
from ecume.models.floating.forces.flow_and_noise import current_at
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    CUTOFF,
    DEEPEST,
    STRENGTH,
    WORK,
    Parameters,
    Parts,
    Scratch,
    State,
    Workspace,
)
from ecume.models.floating.time_integration.step_size import NOISE_DEVIATIONS
from ecume.models.model import CROWDED, DIVERGED, DONE
from ecume.units import Array

admit(special, capillarity, brownian_motion, contact_lines, moving_dish)


class Shaped(NamedTuple):
    """Outlines, charges, inertia and friction of all floats."""

    outlines: Outlines
    place: Array
    """(P, 2) of the charges, in each body's own frame (m)"""
    charge: Array
    """(P,) m"""
    first: Integers
    """(N + 1,) the charges of body i are first[i] to first[i + 1]"""
    wall_strength: Array
    """(walls, P) J"""
    inertia: Array
    """(N,) kg m^2"""
    friction: Array
    """(N, 3) along and across each body (N s/m), against turning (N m s)"""
    elongation: Array
    """(N,) see `contact_lines.elongation`"""
    places: int
    """the largest number of contact points of two bodies"""


class RigidKicks(NamedTuple):
    """The integrator of bodies with three velocities: along their axis, across it, and spin."""

    inertia: Array
    """(N,) kg m^2"""
    friction: Array
    """(N, 3) see `Shaped`"""
    elongation: Array
    """(N,) see `Shaped`"""


class ShapedScratch(NamedTuple):
    """Workspace of all parts of floats with a shape."""

    torque: Array
    """that of the workspace"""
    turning: Array
    """(N, 2) those of the state"""
    at: Array
    """(P, 2) the charges, relative to the centers of their bodies"""
    angle: Array
    """(N,)"""
    corner: Array
    """(V, 2)"""
    mobility: Array
    """(N, 3)"""
    drag: Array
    """(N, 3) forces and torques by the motion of the liquid and of the dish"""
    ahead: Array
    """(N, 3) the change of velocities and spins by that of the flow until the middle of the step"""


def make_shaped_scratch(shaped: Shaped, parameters: Parameters, state: State, workspace: Workspace) -> ShapedScratch:
    """Return the workspace."""
    count = len(state.position)
    return ShapedScratch(
        torque=workspace.torque,
        turning=state.turning,
        at=np.zeros_like(shaped.place),
        angle=np.zeros(count),
        corner=np.zeros_like(shaped.outlines.corner),
        mobility=np.zeros((count, 3)),
        drag=np.zeros((count, 3)),
        ahead=np.zeros((count, 3)),
    )


@compiled
def solver_bodies(part: Outlined, parameters: Parameters, scratch: ShapedScratch) -> OutlinedBodies:
    """Return the data of shapes and walls for the contact solver."""
    return OutlinedBodies(
        part.outlines, parameters.floats.radius, parameters.walls, scratch.mobility, parameters.passing
    )


@compiled
def stance_of(scratch: ShapedScratch, parameters: Parameters, state: State) -> Stance:
    """The positions and angles of all bodies, which separating them changes."""
    return Stance(state.position, scratch.angle, scratch.corner, parameters.periods)


@compiled
def store_angles(scratch: ShapedScratch, state: State) -> None:
    """Store the angles in the state."""
    for i in range(len(state.turning)):
        state.turning[i, 0] = scratch.angle[i]


@compiled
def turn_charges(shaped: Shaped, turning: Array, at: Array) -> None:
    """Rotate the charges by the angles of their bodies."""
    for i in range(len(turning)):
        c, s = math.cos(turning[i, 0]), math.sin(turning[i, 0])
        for p in range(shaped.first[i], shaped.first[i + 1]):
            x, y = shaped.place[p, 0], shaped.place[p, 1]
            at[p, 0], at[p, 1] = c * x - s * y, s * x + c * y


@compiled
def body_pair_forces(
    shaped: Shaped, parameters: Parameters, at: Array, pair: tuple[int, int], apart: tuple[float, float]
) -> tuple[float, float, float, float]:
    """The force on the first of two bodies (the second is displaced by `apart`), and the torques on both."""
    (i, j), (x, y) = pair, apart
    unit, length = parameters.pair[STRENGTH], parameters.pair[CAPILLARY_LENGTH]
    force_x, force_y, torque_i, torque_j = 0.0, 0.0, 0.0, 0.0
    for p in range(shaped.first[i], shaped.first[i + 1]):
        on_x, on_y = 0.0, 0.0
        for q in range(shaped.first[j], shaped.first[j + 1]):
            to_x, to_y = x + at[q, 0] - at[p, 0], y + at[q, 1] - at[p, 1]
            distance = math.sqrt(to_x * to_x + to_y * to_y)
            pull = -pair_force(distance, unit * shaped.charge[p] * shaped.charge[q], length) / distance
            on_x += pull * to_x
            on_y += pull * to_y
            torque_j -= pull * (at[q, 0] * to_y - at[q, 1] * to_x)
        torque_i += at[p, 0] * on_y - at[p, 1] * on_x
        force_x += on_x
        force_y += on_y
    return force_x, force_y, torque_i, torque_j


@compiled
def add_wall_forces(
    shaped: Shaped, parameters: Parameters, position: Array, scratch: ShapedScratch, force: Array
) -> None:
    """Add the forces of the wall menisci on each charge."""
    for i in range(len(position)):
        for p in range(shaped.first[i], shaped.first[i + 1]):
            place = (position[i, 0] + scratch.at[p, 0], position[i, 1] + scratch.at[p, 1])
            for number in range(wall_count(parameters.walls)):
                away, in_x, in_y = wall_force(
                    parameters, number, place, shaped.wall_strength[number, p], shaped.charge[p]
                )
                force[i, 0] += away * in_x
                force[i, 1] += away * in_y
                scratch.torque[i] += away * (scratch.at[p, 0] * in_y - scratch.at[p, 1] * in_x)


@compiled
def shaped_forces(
    shaped: Shaped, scratch: ShapedScratch, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
) -> None:
    """Add the forces on all bodies, and compute the torques; each pair once, so that they cancel to rounding."""
    cutoff = parameters.pair[CUTOFF]
    turn_charges(shaped, scratch.turning, scratch.at)
    scratch.torque[:] = 0.0
    order, first, neighbor = lists.cells.order, lists.rows.first, lists.rows.neighbor
    for slot in range(len(order) if parameters.pair[STRENGTH] != 0.0 else 0):
        i = order[slot]
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            x, y = apart(position, i, j, lists.rows.periods)
            if i < j and x * x + y * y < cutoff * cutoff:
                force_x, force_y, torque_i, torque_j = body_pair_forces(shaped, parameters, scratch.at, (i, j), (x, y))
                force[i, 0] += force_x
                force[i, 1] += force_y
                force[j, 0] -= force_x
                force[j, 1] -= force_y
                scratch.torque[i] += torque_i
                scratch.torque[j] += torque_j
    if acts(parameters):
        add_wall_forces(shaped, parameters, position, scratch, force)


@compiled
def energy_of_pair(
    shaped: Shaped, parameters: Parameters, at: Array, pair: tuple[int, int], apart: tuple[float, float]
) -> float:
    """The energy of two bodies (J), minus that of their charges at the cutoff."""
    (i, j), (x, y) = pair, apart
    unit, length, cutoff = parameters.pair[STRENGTH], parameters.pair[CAPILLARY_LENGTH], parameters.pair[CUTOFF]
    total = 0.0
    for p in range(shaped.first[i], shaped.first[i + 1]):
        for q in range(shaped.first[j], shaped.first[j + 1]):
            distance = math.sqrt((x + at[q, 0] - at[p, 0]) ** 2 + (y + at[q, 1] - at[p, 1]) ** 2)
            strength = unit * shaped.charge[p] * shaped.charge[q]
            total += pair_energy(distance, strength, length) - pair_energy(cutoff, strength, length)
    return total


@compiled
def shaped_energies(
    shaped: Shaped, scratch: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """The energies of all pairs and of all walls (J)."""
    cutoff = parameters.pair[CUTOFF]
    walls, lists = parameters.walls, workspace.lists
    turn_charges(shaped, state.turning, scratch.at)
    order, first, neighbor = lists.cells.order, lists.rows.first, lists.rows.neighbor
    pairs, at_walls = 0.0, 0.0
    for slot in range(len(order)):
        i = order[slot]
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            x, y = apart(state.position, i, j, lists.rows.periods)
            if i < j and x * x + y * y < cutoff * cutoff and parameters.pair[STRENGTH] != 0.0:
                pairs += energy_of_pair(shaped, parameters, scratch.at, (i, j), (x, y))
        for p in range(shaped.first[i], shaped.first[i + 1]):
            at = (state.position[i, 0] + scratch.at[p, 0], state.position[i, 1] + scratch.at[p, 1])
            for number in range(wall_count(walls) if acts(parameters) else 0):
                at_walls += wall_energy(parameters, number, at, shaped.wall_strength[number, p], shaped.charge[p])[0]
    return pairs, at_walls


ROUNDED = 8.0
"""The largest rounding error of a sum, over that of its terms (r.m.s.) by one unit in the last place."""


def rounding_of_energies(shaped: Shaped, parameters: Parameters) -> float:
    """A bound (J) of the rounding error of `shaped_energies`, a sum of terms that are rounded independently. The
    charges of a contact line cancel: far apart, energies of quadrupoles are smaller than those of their charges by the
    fourth power of their size over the distance.
    """
    unit, length, cutoff = (float(parameters.pair[key]) for key in (STRENGTH, CAPILLARY_LENGTH, CUTOFF))
    nearest = min(2.0 * float(parameters.floats.radius.min()), cutoff)
    of_body = np.add.reduceat(shaped.charge**2, shaped.first[:-1])
    pairs = math.sqrt(0.5 * (float(of_body.sum()) ** 2 - float(np.sum(of_body**2))))
    among = abs(unit) * pairs * (1.0 - pair_energy(nearest, 1.0, length))
    return ROUNDED * float(np.finfo(np.float64).eps) * math.hypot(among, float(np.linalg.norm(shaped.wall_strength)))


FARTHEST_TURN = 0.5
"""rad in one step: beyond it, the predicted contacts are wrong."""


@compiled
def kick_time(parameters: Parameters) -> float:
    """The duration of a kick (s): half a step for velocity Verlet, a whole step for the others."""
    return 0.5 * parameters.time_step if parameters.scheme.half_kicks else parameters.time_step


@compiled
def slowed(part: RigidKicks, parameters: Parameters, i: int, axis: int) -> tuple[float, float]:
    """The factor by which drag reduces the velocity of body i along one of its axes (2: spin) in a kick, and the
    velocity gained per unit force.
    """
    time = kick_time(parameters)
    friction, mass = part.friction[i, axis], part.inertia[i] if axis == 2 else parameters.floats.mass[i]
    if not parameters.scheme.inertia:
        return 0.0, 1.0 / friction
    rate = friction / mass * time
    held = -math.expm1(-rate) / rate if rate > 0.0 else 1.0
    return math.exp(-rate), held * time / mass


@compiled
def kick(
    part: RigidKicks, scratch: ShapedScratch, parameters: Parameters, force: Array, velocity: Array, share: float
) -> None:
    """Change velocities and spins (N, 3) by drag and `share` of the forces during a kick, solved exactly."""
    for i in range(len(force)):
        c, s, drag = math.cos(scratch.angle[i]), math.sin(scratch.angle[i]), scratch.drag[i]
        x, y = force[i, 0] + drag[0], force[i, 1] + drag[1]
        decay, gain = slowed(part, parameters, i, 0)
        along = decay * (c * velocity[i, 0] + s * velocity[i, 1]) + share * gain * (c * x + s * y)
        decay, gain = slowed(part, parameters, i, 1)
        across = decay * (c * velocity[i, 1] - s * velocity[i, 0]) + share * gain * (c * y - s * x)
        decay, gain = slowed(part, parameters, i, 2)
        velocity[i, 0], velocity[i, 1] = c * along - s * across, s * along + c * across
        velocity[i, 2] = decay * velocity[i, 2] + share * gain * (scratch.torque[i] + drag[2])


@compiled
def rotation_of_flow(
    part: RigidKicks, parameters: Parameters, i: int, here: tuple[float, float, float, float]
) -> float:
    """The spin (rad/s) that the flow of the surface gives a body at (x, y), angle and time, if nothing else turns it.
    The gradients are those over the length of the body.
    """
    x, y, angle, time = here
    size = parameters.floats.radius[i]
    right, left = current_at(parameters.drift, time, x + size, y), current_at(parameters.drift, time, x - size, y)
    above, below = current_at(parameters.drift, time, x, y + size), current_at(parameters.drift, time, x, y - size)
    turned, sheared = (right[1] - left[1]) / (2.0 * size), (above[0] - below[0]) / (2.0 * size)
    extended = (right[0] - left[0] - above[1] + below[1]) / (2.0 * size)
    spin: float = spin_in_flow(angle, part.elongation[i], turned - sheared, turned + sheared, extended)
    return spin


@compiled
def drag_along(
    part: RigidKicks, scratch: ShapedScratch, parameters: Parameters, state: State, velocity: Array, ahead: float
) -> None:
    """Compute the forces and torques by the flow of the surface and by a moving dish, `ahead` time steps after those
    counted by the state; the bodies have moved on with these velocities, unless it is the end of the step.
    """
    drift, drag = parameters.drift, scratch.drag
    if not drift.flows and not drift.sway.moves:
        return
    now, drifted = (state.step[0] + ahead) * parameters.time_step, ahead % 1.0 * parameters.time_step
    # A kick of a whole step takes the motion of the dish at its middle.
    swayed = (state.step[0] + (ahead if parameters.scheme.half_kicks else 0.5)) * parameters.time_step
    for i in range(len(drag)):
        x, y = state.position[i, 0] + drifted * velocity[i, 0], state.position[i, 1] + drifted * velocity[i, 1]
        angle, liquid_x, liquid_y, spin = scratch.angle[i] + drifted * velocity[i, 2], 0.0, 0.0, 0.0
        if drift.flows:
            liquid_x, liquid_y = current_at(drift, now, x, y)
            spin = rotation_of_flow(part, parameters, i, (x, y, angle, now))
        sway, mass = drift.sway, parameters.floats.mass[i] if parameters.scheme.inertia else 0.0
        liquid_x -= sway.slip * (sway.velocity[0] + sway_velocity(sway.amplitude[0], sway.turning, swayed))
        liquid_y -= sway.slip * (sway.velocity[1] + sway_velocity(sway.amplitude[1], sway.turning, swayed))
        c, s = math.cos(angle), math.sin(angle)
        along = part.friction[i, 0] * (c * liquid_x + s * liquid_y)
        across = part.friction[i, 1] * (c * liquid_y - s * liquid_x)
        left_x = sway.slip * mass * sway_acceleration(sway.amplitude[0], sway.turning, swayed)
        left_y = sway.slip * mass * sway_acceleration(sway.amplitude[1], sway.turning, swayed)
        drag[i, 0], drag[i, 1] = c * along - s * across - left_x, s * along + c * across - left_y
        drag[i, 2] = part.friction[i, 2] * spin


@compiled
def turn_bodies_with_current(
    part: RigidKicks, scratch: ShapedScratch, parameters: Parameters, state: State, velocity: Array
) -> None:
    """Add to velocities and spins the change of the flow until the middle of the step, as far as drag transmits it in a
    kick: the midpoint rule of round floats (`turn_with_current`). The changes are kept in `scratch.ahead`.
    """
    drift, half, now = parameters.drift, 0.5 * parameters.time_step, state.step[0] * parameters.time_step
    for i in range(len(scratch.ahead)):
        x, y, angle = state.position[i, 0], state.position[i, 1], scratch.angle[i]
        to_x, to_y, turned = x + half * velocity[i, 0], y + half * velocity[i, 1], angle + half * velocity[i, 2]
        u, v = current_at(drift, now, x, y)
        last_u, last_v = current_at(drift, now + half, to_x, to_y)
        spin = rotation_of_flow(part, parameters, i, (x, y, angle, now))
        last_spin = rotation_of_flow(part, parameters, i, (to_x, to_y, turned, now + half))
        c, s = math.cos(angle), math.sin(angle)
        along = (1.0 - slowed(part, parameters, i, 0)[0]) * (c * (last_u - u) + s * (last_v - v))
        across = (1.0 - slowed(part, parameters, i, 1)[0]) * (c * (last_v - v) - s * (last_u - u))
        scratch.ahead[i, 0], scratch.ahead[i, 1] = c * along - s * across, s * along + c * across
        scratch.ahead[i, 2] = (1.0 - slowed(part, parameters, i, 2)[0]) * (last_spin - spin)
        for axis in range(3):
            velocity[i, axis] += scratch.ahead[i, axis]


@compiled
def fastest_rigid(
    part: RigidKicks, scratch: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> float:
    """The highest possible midstep speed of the center of any body, without contacts; NaN if any speed is NaN."""
    drag_along(part, scratch, parameters, state, workspace.midstep_velocity, 0.0)
    kick, velocity, force, drag, fastest = parameters.kick, state.velocity, workspace.force, scratch.drag, 0.0
    for i in range(len(velocity)):
        speed = math.sqrt(velocity[i, 0] ** 2 + velocity[i, 1] ** 2) if kick.decay[i] > 0.0 else 0.0
        speed += kick.gain[i] * math.sqrt((force[i, 0] + drag[i, 0]) ** 2 + (force[i, 1] + drag[i, 1]) ** 2)
        # Written so that a NaN is kept.
        if fastest == fastest and not speed <= fastest:
            fastest = speed
    return fastest


@compiled
def add_rigid_work(
    part: RigidKicks, scratch: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Add the work of the flow and of a moving dish in a step, by their forces at its midpoint. With thermal noise, the
    heat already contains this work.
    """
    velocity, power = workspace.midstep_velocity, 0.0
    if parameters.drift.thermal > 0.0 or len(state.tally) <= WORK:
        return
    drag_along(part, scratch, parameters, state, velocity, 0.5)
    for i in range(len(scratch.drag)):
        for axis in range(3):
            power += scratch.drag[i, axis] * velocity[i, axis]
    state.tally[WORK] += parameters.time_step * power


@compiled
def load(state: State, velocity: Array) -> None:
    """Copy velocities and spins from the state; walls are at rest."""
    for i in range(len(state.velocity)):
        velocity[i, 0], velocity[i, 1], velocity[i, 2] = state.velocity[i, 0], state.velocity[i, 1], state.turning[i, 1]


@compiled
def store(state: State, velocity: Array) -> None:
    """Store velocities and spins in the state."""
    for i in range(len(state.velocity)):
        state.velocity[i, 0], state.velocity[i, 1], state.turning[i, 1] = velocity[i, 0], velocity[i, 1], velocity[i, 2]


@compiled
def copy(target: Array, source: Array, count: int) -> None:
    """Copy the first rows."""
    for i in range(count):
        for axis in range(3):
            target[i, axis] = source[i, axis]


@compiled
def tip_travel(part: RigidKicks, scratch: ShapedScratch, parameters: Parameters, state: State) -> tuple[float, float]:
    """The longest travel of a tip by rotation in this step (m), and the largest rotation (rad); NaN is kept."""
    farthest, widest, time = 0.0, 0.0, parameters.time_step
    for i in range(len(state.turning)):
        decay, gain = slowed(part, parameters, i, 2)
        # Twice, for the second half kick of velocity Verlet.
        turn = time * (decay * abs(state.turning[i, 1]) + 2.0 * gain * abs(scratch.torque[i] + scratch.drag[i, 2]))
        if parameters.drift.thermal > 0.0:
            turn += NOISE_DEVIATIONS * math.sqrt(2.0 * diffusivity(parameters.drift.thermal, 1.0 / gain) * time)
        way = turn * parameters.floats.radius[i]
        if farthest == farthest and not way <= farthest:
            farthest = way
        if widest == widest and not turn <= widest:
            widest = turn
    return farthest, widest


@compiled
def fill_mobility(part: RigidKicks, scratch: ShapedScratch, parameters: Parameters) -> None:
    """Compute velocity per impulse along each body and across it, and spin per angular impulse."""
    time = kick_time(parameters)
    for i in range(len(scratch.mobility)):
        for axis in range(3):
            scratch.mobility[i, axis] = slowed(part, parameters, i, axis)[1] / time


@composed
def predict_rigid(
    part: RigidKicks, parts: Parts, scratches: Scratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Compute the midstep velocities by the first kick; `before` is the velocity without forces."""
    load(state, workspace.midstep_velocity)
    kick_twice(part, scratches.integrator, parameters, workspace)
    if parameters.drift.flows:
        turn_bodies_with_current(part, scratches.integrator, parameters, state, workspace.midstep_velocity)
    if parameters.drift.thermal > 0.0:
        add_rigid_noise(part, scratches.integrator, parameters, int(state.step[0]), workspace.midstep_velocity)


SPINS = 1
"""The purpose of the random numbers of spins; that of velocities is 0."""


@compiled
def add_rigid_noise(
    part: RigidKicks, scratch: ShapedScratch, parameters: Parameters, step: int, velocity: Array
) -> None:
    """Add Brownian motion to velocities and spins: displacements of variance 2 kT/zeta dt along each body, across it
    and of its angle.
    """
    thermal, seed = parameters.drift.thermal, parameters.drift.seed
    for i in range(len(scratch.angle)):
        along, across = normals(counter_of(i, step, 0), seed)
        along *= noise_speed(thermal, slowed(part, parameters, i, 0)[1], parameters.time_step)
        across *= noise_speed(thermal, slowed(part, parameters, i, 1)[1], parameters.time_step)
        c, s = math.cos(scratch.angle[i]), math.sin(scratch.angle[i])
        velocity[i, 0] += c * along - s * across
        velocity[i, 1] += s * along + c * across
        turning = normals(counter_of(i, step, SPINS), seed)[0]
        velocity[i, 2] += turning * noise_speed(thermal, slowed(part, parameters, i, 2)[1], parameters.time_step)


@compiled
def noise_speed(thermal: float, gain: float, time: float) -> float:
    """The standard deviation of the displacement by noise, over the time: of a velocity (m/s), or of a spin (rad/s)."""
    return math.sqrt(2.0 * diffusivity(thermal, 1.0 / gain) / time)


@compiled
def add_rigid_heat(
    part: RigidKicks, scratch: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace, ahead: float
) -> None:
    """Add the heat of half a step, by the forces and torques at its beginning or end."""
    velocity, force, power = workspace.midstep_velocity, workspace.force, 0.0
    if parameters.drift.thermal > 0.0 and len(state.tally) > WORK:
        for i in range(len(force)):
            power += force[i, 0] * velocity[i, 0] + force[i, 1] * velocity[i, 1] + scratch.torque[i] * velocity[i, 2]
        state.tally[WORK] -= 0.5 * parameters.time_step * power


@compiled
def kick_twice(part: RigidKicks, scratch: ShapedScratch, parameters: Parameters, workspace: Workspace) -> None:
    """Compute the midstep velocities after a kick, and the velocities `before` after a kick without forces."""
    copy(workspace.before, workspace.midstep_velocity, len(workspace.force))
    kick(part, scratch, parameters, workspace.force, workspace.before, 0.0)
    kick(part, scratch, parameters, workspace.force, workspace.midstep_velocity, 1.0)


@compiled
def finish_rigid(
    part: RigidKicks, scratch: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Subtract the change of the flow until the middle of the step, which moves bodies with inertia and does not change
    their velocities; apply the second half kick, if the scheme has one.
    """
    if parameters.drift.flows and parameters.scheme.inertia:
        for i in range(len(scratch.ahead)):
            for axis in range(3):
                workspace.midstep_velocity[i, axis] -= scratch.ahead[i, axis]
    if parameters.scheme.half_kicks:
        drag_along(part, scratch, parameters, state, workspace.midstep_velocity, 1.0)
        kick_twice(part, scratch, parameters, workspace)


@compiled
def move_rigid(
    part: RigidKicks, scratch: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Advance positions and angles with the midstep velocities."""
    time = parameters.time_step
    for i in range(len(state.position)):
        state.position[i, 0] += time * workspace.midstep_velocity[i, 0]
        state.position[i, 1] += time * workspace.midstep_velocity[i, 1]
        scratch.angle[i] += time * workspace.midstep_velocity[i, 2]
        state.turning[i, 0] = scratch.angle[i]


@compiled
def begin_rigid(part: RigidKicks, scratch: ShapedScratch, parameters: Parameters, state: State) -> None:
    """Fill in the angles and mobilities of a new workspace."""
    for i in range(len(state.position)):
        scratch.angle[i] = state.turning[i, 0]
    fill_mobility(part, scratch, parameters)


@compiled
def bound_rigid_travel(
    part: RigidKicks, scratch: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> int:
    """Add the travel of tips by rotation; return `DIVERGED` if a body turns too far in a step."""
    tips, turn = tip_travel(part, scratch, parameters, state)
    workspace.travel[0] += tips
    return DONE if turn <= FARTHEST_TURN else DIVERGED


@compiled
def store_rigid(
    part: RigidKicks, scratch: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Store velocities and spins in the state."""
    store(state, workspace.midstep_velocity)


@compiled
def collide_outlines(
    part: Outlined, scratch: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Solve collisions, then a plastic solve for the midstep velocities, so that no float overlaps another."""
    levers, velocities = workspace.contacts, (workspace.before, workspace.midstep_velocity)
    bounce(part, scratch, parameters, state, levers, velocities, workspace.restitution)
    require_gaps(part.overlapping, parameters, levers)
    if parameters.drift.thermal > 0.0:
        require_reflected_gaps(parameters, state, levers, workspace.midstep_velocity)
    solve_contacts(part, scratch, parameters, state, levers, workspace.midstep_velocity)


UNLIKELY = 20.0
"""Gap before times gap after a step, over the variance, beyond which paths meet with a probability below exp(-40)."""


@compiled
def require_reflected_gaps(parameters: Parameters, state: State, levers: TorqueContacts, velocity: Array) -> None:
    """Require the gaps of reflected Brownian motions at the end of the step. This is exact for a single contact of a
    body. With several contacts at once, gaps far below kT over the force are too frequent, as in clusters of lasting
    contacts (`thermal_collisions`).
    """
    time = parameters.time_step
    touching.normal_velocities(levers, velocity, levers.scratch)
    for row in range(levers.total[0]):
        gap, change = max(levers.gap[row], 0.0), time * levers.scratch[row]
        if levers.weight[row] > 0.0:
            # The mobility of a contact is the time over its effective mass.
            variance = 2.0 * parameters.drift.thermal * time * time / levers.weight[row]
            if gap + change <= 0.0 or gap * (gap + change) < UNLIKELY * variance:
                feature = levers.place[row] % touching.FEATURES
                one, other = int(levers.first[row]), int(levers.second[row])
                counter = counter_of_pair(one, other, int(state.step[0]), int(feature))
                draw = uniforms(counter, parameters.drift.seed)[0]
                levers.bound[row] = (reflected_gain(change, variance, -math.log(draw)) - gap) / time


@compiled
def separate_outlines(
    part: Outlined, scratch: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """List the contacts at the new positions, and remove deep overlaps without changing velocities."""
    reach = 2.0 * workspace.travel[0] + parameters.slop
    stance = stance_of(scratch, parameters, state)
    bodies, levers = solver_bodies(part, parameters, scratch), workspace.contacts
    touching.gather(levers, workspace.candidates, stance, bodies, reach)
    deepest = deepest_overlap(levers.total, levers.gap)
    state.tally[DEEPEST] = max(state.tally[DEEPEST], deepest)
    if deepest > parameters.slop:
        separate(levers, workspace.candidates, stance, bodies, parameters.slop)
        touching.gather(levers, workspace.candidates, stance, bodies, reach)
    store_angles(scratch, state)


@compiled
def constrain_outline_velocities(
    part: Outlined, scratch: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Solve contacts for the velocity at the end of the step; `before` is the velocity without the kick.

    A faster approach than by the kick alone is a collision of the next step.
    """
    levers, before = workspace.contacts, workspace.before
    touching.normal_velocities(levers, before, levers.change)
    touching.normal_velocities(levers, workspace.midstep_velocity, levers.scratch)
    require_rest(parameters, levers, float(still(part, parameters, before)))
    solve_contacts(part, scratch, parameters, state, levers, workspace.midstep_velocity)


@compiled
def find_outline_contacts(
    part: Outlined, scratch: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> int:
    """List the possible contacts of this step. Returns `CROWDED` if the capacity is exceeded."""
    stance = stance_of(scratch, parameters, state)
    # Twice the travel for a head-on pair, and twice again for floats that others push.
    reach = 4.0 * workspace.travel[0] + parameters.slop
    room = touching.gather(
        workspace.contacts, workspace.candidates, stance, solver_bodies(part, parameters, scratch), reach
    )
    return DONE if room else CROWDED
