"""Walls and obstacles: reflection of particles that cross a surface, repulsion of those too close, and impacts.

Reflection (`Guard`): for a particle that is outside after a drift, `ecume.engine.walls` repeats the path, with a
reflection at each surface hit. In a smooth flow this does not occur; the hits are counted. With walls = "reflect" only
reflection confines the liquid.

Repulsion: a particle closer than a tenth of a spacing to a wall, an obstacle or a body is accelerated away from it.
Images and dummies exert no pressure where a particle coincides with its image, and the density from the equation of
continuity does not depend on the distance of a thin layer. Without repulsion, a single layer of particles would rest on
the reflecting surface.

Particles that enter an obstacle other than a box, a ball or a convex polygon are moved to the nearest point of its
surface, as at bodies; such obstacles do not brake impacts.

Impacts: liquid that approaches a wall or an obstacle is braked by the dissipation of the Riemann problem at the wall,
summed over the half-space behind it, which depends on the distance alone. Images complete the sums of liquid that
surrounds a particle; the first particles of a jet have few neighbors and therefore few images, which would brake them
too late and cause a water hammer. Full tanks have no impacts, and incompressible liquids no water hammer.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, compiled_inside, prange, spread
from ecume._portable import dot, product
from ecume.engine.cells import Integers
from ecume.engine.shapes import Flags
from ecume.engine.walls import Sheet, reflect_all
from ecume.engine.walls.sheets import RESTITUTION, SIZE, SPEED, gap_to, inward_normal, piece_gap, worst_gap
from ecume.engine.walls.surfaces import PLANE
from ecume.laws import wall_forces
from ecume.models.sph.boundaries.forces_on_solids import total
from ecume.models.sph.boundaries.rigid_bodies import rotations
from ecume.models.sph.parameters import Guard, Parameters
from ecume.models.sph.state import GUARD_HITS, State
from ecume.units import Array

admit(wall_forces)


@spread
def flag_outside(position: Array, kind: Integers, number: Array, radius: float, out: Flags) -> None:
    """Flag particles behind a surface, or closer to it than the radius."""
    for i in prange(position.shape[1]):
        z = position[2, i] if position.shape[0] == 3 else 0.0
        gap, _ = worst_gap(kind, number, (position[0, i], position[1, i], z), 0.0)
        out[i] = gap < radius


class Repelled(NamedTuple):
    """Particles that a wall, obstacle or body repels."""

    owner: int
    """of the repulsion: a place in `Boundary.names`"""
    who: Integers
    """(n,)"""
    acceleration: Array
    """(d, n) m/s^2"""


class Reflected(NamedTuple):
    """Particles that were outside after a drift."""

    hits: Integers
    """(K,) by surface"""
    who: Integers
    """(n,)"""
    outside: Array
    """(d, n) m, where they were"""
    change: Array
    """(d, n) m/s, of their velocities"""


def reflect_particles(guard: Guard, position: Array, velocity: Array, transport: Array, time: float) -> Reflected:
    """Repeat, in place, the drift of particles that are outside after it, with reflections."""
    hits = np.zeros(len(guard.owner), np.int64)
    out = np.zeros(position.shape[1], np.bool_)
    if len(hits):
        flag_outside(position, guard.sheet.kind, guard.sheet.number, guard.radius, out)
    who = np.flatnonzero(out)
    found = Reflected(hits, who, position[:, who], np.zeros((len(position), len(who))))
    if not len(who):
        return found
    before = velocity[:, out] + transport[:, out]
    x = np.ascontiguousarray((position[:, out] - time * before).T)
    v = before.T.copy()  # always a copy, since selected columns may be stored in the other order
    status = np.zeros(len(x), np.int64)
    tally = (np.zeros_like(status), status, hits)
    earlier = _as_before(guard.sheet, time)
    reflect_all(x, v, np.zeros((1, x.shape[1])), time, earlier, np.array([guard.radius]), tally)
    for i in np.flatnonzero(status < 0):
        x[i] = position[:, np.flatnonzero(out)[i]]
        _move_inside(guard, x[i], v[i], hits)
    position[:, out] = x.T
    velocity[:, out] += v.T - before
    found.change[...] = v.T - before
    return found


def impulses(guard: Guard, met: Reflected) -> list[Repelled]:
    """The velocity changes by each wall or obstacle, as accelerations over one second. In a corner of the tank each
    side receives the component along its normal.
    """
    kind, number, d = guard.sheet.kind, guard.sheet.number, len(met.outside)
    deep = np.zeros((3, len(met.who)))
    deep[:d] = met.outside
    nearest = np.array([worst_gap(kind, number, (x, y, z), 0.0)[1] for x, y, z in deep.T.tolist()], np.int64)
    left, found = met.change.copy(), list[Repelled]()
    for k in np.flatnonzero((kind[:, 0] == PLANE) & (kind[:, 2] == 0)):
        normal = number[k, :d]
        beside = (product(normal, met.outside) - number[k, SIZE] < guard.radius) & (nearest != k)
        part = normal[:, None] * (product(normal, left) * beside)
        left -= part
        found.append(Repelled(int(guard.owner[k]), met.who, part))
    for owner in np.unique(guard.owner[nearest]):
        found.append(Repelled(int(owner), met.who, left * (guard.owner[nearest] == owner)))
    return found


def add_impulses(now: Parameters, state: State, met: Reflected) -> None:
    """Add the force and torque of reflected particles on walls and obstacles, as means over the present step."""
    if now.boundary.guard.reach == 0.0 or not len(met.who):
        return
    for each in impulses(now.boundary.guard, met):
        add_impulse(now, state, each)


def add_impulse(now: Parameters, state: State, change: Repelled) -> None:
    """Add the force and torque of changes of velocity, which count as accelerations over one second, on a wall or
    obstacle, as means over the present step.
    """
    if state.struck.size:
        force, torque = repulsion_load(now, state, change)
        state.struck[change.owner] += np.concatenate([force, torque]) / now.time_step


def _as_before(packed: Sheet, time: float) -> Sheet:
    """The surfaces with moving planes at the start of the drift; `ecume.engine.walls` moves them."""
    number = packed.number.copy()
    flat = packed.kind[:, 0] == PLANE
    way = time * (number[:, :3] * number[:, SPEED : SPEED + 3]).sum(axis=1)
    number[flat, SIZE] -= way[flat]
    return packed._replace(number=number)


def _move_inside(guard: Guard, x: Array, v: Array, hits: Integers) -> None:
    """Move particles that started outside, because a wall moved past them, onto the wall, and stop their approach."""
    kind, number = guard.sheet.kind, guard.sheet.number
    for _ in range(4):
        here = (x[0], x[1], x[2] if len(x) == 3 else 0.0)
        gap, k = worst_gap(kind, number, here, 0.0)
        if gap >= guard.radius:
            return
        normal = np.array(inward_normal(kind, number, k, here, 0.0))[: len(x)]
        x += (guard.radius * (1.0 + 1e-9) - gap_to(kind, number, k, here, 0.0)) * normal
        approach = dot(v - number[k, SPEED : SPEED + len(x)], normal)
        if approach < 0.0:
            v -= (1.0 + number[k, RESTITUTION]) * approach * normal
        hits[k] += 1


FASTEST = 0.1
"""The speed of a particle that just reaches the wall, in sound speeds: the limit of a weakly compressible liquid."""


@spread
def repel(position: Array, kind: Integers, number: Array, reach: float, speed: float, acceleration: Array) -> None:
    """Add the repulsion by walls and obstacles."""
    for i in prange(position.shape[1]):
        k, z = 0, position[2, i] if position.shape[0] == 3 else 0.0
        x = position[0, i], position[1, i], z
        while k < kind.shape[0]:
            gap, nearest, k = piece_gap(kind, number, k, x, 0.0)
            if gap < reach:
                repulsion, normal = (
                    wall_forces.standoff_push(gap, reach, speed),
                    inward_normal(kind, number, nearest, x, 0.0),
                )
                for axis in range(position.shape[0]):
                    acceleration[axis, i] += repulsion * normal[axis]


RESOLVED = 0.5
"""The largest product of the time step and the angular frequency of the repulsion; from 2 on its energy grows."""


def speed_of(parameters: Parameters) -> float:
    """The approach velocity (m/s) that the repulsion just stops; of two liquids, the speed for the one with the higher
    speed of sound. Incompressible liquids take long time steps, which resolve only a weaker repulsion than the speed of
    the flow requires; reflection then stops faster particles.
    """
    reach = parameters.boundary.guard.reach
    sound = max(liquid.sound_speed for liquid in parameters.materials)
    if math.isfinite(sound):
        return FASTEST * sound
    return min(parameters.material.fastest, RESOLVED * reach / parameters.time_step)


def repel_from_walls(parameters: Parameters, state: State) -> None:
    """Add the present repulsion by walls and obstacles to the acceleration of the liquid."""
    guard = parameters.boundary.guard
    if guard.reach > 0.0 and len(guard.owner):
        repel(state.position, *guard.sheet[:2], guard.reach, speed_of(parameters), state.acceleration)


def repel_from_drawn(parameters: Parameters, state: State) -> None:
    """Add the present repulsion by drawn obstacles."""
    for number in parameters.bodies.drawn:
        leaning = repelled_by_drawn(parameters, state, number)
        state.acceleration[:, leaning.who] += leaning.acceleration


def drawn_owner(parameters: Parameters, number: int) -> int:
    """The index of an obstacle in `Boundary.names`."""
    return 2 * parameters.dimension + number


def repelled_by_drawn(parameters: Parameters, state: State, number: int) -> Repelled:
    """Particles repelled by an obstacle without reflecting surfaces."""
    reach = parameters.boundary.guard.reach
    near, gap, normal = close_to(parameters, state, number, reach)
    acceleration = [wall_forces.standoff_push(own, reach, speed_of(parameters)) for own in gap]
    return Repelled(drawn_owner(parameters, number), near, np.array(acceleration) * normal.T)


def close_to(parameters: Parameters, state: State, number: int, reach: float) -> tuple[Integers, Array, Array]:
    """The particles outside an obstacle at less than `reach`: their indices, gaps, and the normals there (n, d)."""
    shape = parameters.bodies.obstacles[number]
    low, high = shape.bounds()
    position = state.position.T
    around = np.flatnonzero(((position > low - reach) & (position < high + reach)).all(axis=1))
    gap, normal = shape.nearest(position[around])
    near = gap < reach
    return around[near], gap[near], normal[near]


def expel_from_drawn(parameters: Parameters, state: State) -> None:
    """Move liquid inside drawn obstacles to their surfaces, stop its approach, and count the particles."""
    guard = parameters.boundary.guard
    for number in parameters.bodies.drawn:
        inside, gap, normal = close_to(parameters, state, number, guard.radius)
        state.position[:, inside] += (guard.radius - gap) * normal.T
        approach = np.minimum((state.velocity[:, inside] * normal.T).sum(axis=0), 0.0)
        state.velocity[:, inside] -= approach * normal.T
        owner = drawn_owner(parameters, number)
        state.hits[owner] += len(inside)
        state.tally[GUARD_HITS] += len(inside)
        if len(inside) and guard.reach > 0.0:
            add_impulse(parameters, state, Repelled(owner, inside, -approach * normal.T))


def repel_from_bodies(parameters: Parameters, state: State) -> tuple[Array, Array]:
    """Add the repulsion by bodies; return the opposite force and torque on each body, (B, 3)."""
    bodies = len(parameters.bodies.shapes)
    force, torque = np.zeros((bodies, 3)), np.zeros((bodies, 3))
    first = len(parameters.boundary.names) - bodies
    for body in range(bodies):
        leaning = repelled_by_body(parameters, state, body)
        state.acceleration[:, leaning.who] += leaning.acceleration
        force[body], torque[body] = repulsion_load(parameters, state, leaning._replace(owner=first + body))
    return force, torque


def repelled_by_body(parameters: Parameters, state: State, body: int) -> Repelled:
    """Particles repelled by a body."""
    bodies, reach = parameters.bodies, parameters.boundary.guard.reach
    shape, d = bodies.shapes[body], len(state.position)
    away = state.position - state.pose[:d, body : body + 1]
    size = float(np.sqrt((bodies.rims[body] ** 2).sum(axis=1).max()))
    close = np.flatnonzero((away**2).sum(axis=0) < (size + reach) ** 2)
    turn = rotations(state.pose[:, body : body + 1])[0][:d, :d]
    gap, normal = shape.nearest(product(away[:, close].T, turn))
    near = gap < reach
    acceleration = [wall_forces.standoff_push(own, reach, speed_of(parameters)) for own in gap[near]]
    owner = len(parameters.boundary.names) - len(bodies.shapes) + body
    return Repelled(owner, close[near], np.array(acceleration) * product(turn, normal[near].T))


def all_repelled(parameters: Parameters, state: State) -> list[Repelled]:
    """Particles repelled by walls and obstacles, followed by those repelled by bodies."""
    guard, found = parameters.boundary.guard, []
    if guard.reach == 0.0:
        return []
    for owner in np.unique(guard.owner):
        found.append(repelled_by_wall(parameters, state, int(owner)))
    found += [repelled_by_drawn(parameters, state, number) for number in parameters.bodies.drawn]
    return found + [repelled_by_body(parameters, state, body) for body in range(len(parameters.bodies.shapes))]


def repelled_by_wall(parameters: Parameters, state: State, owner: int) -> Repelled:
    """Particles repelled by a wall or an obstacle."""
    guard, acceleration = parameters.boundary.guard, np.zeros_like(state.position)
    if guard.reach > 0.0:
        repel(state.position, *sheet_of(guard, owner)[:2], guard.reach, speed_of(parameters), acceleration)
    who = np.flatnonzero(acceleration.any(axis=0))
    return Repelled(owner, who, acceleration[:, who])


def sheet_of(guard: Guard, owner: int) -> Sheet:
    """The surfaces of one wall or obstacle, with the ranges of an obstacle's planes renumbered."""
    mine = np.flatnonzero(guard.owner == owner)
    kind = guard.sheet.kind[mine].copy()
    kind[:, 1:] -= mine[0] * (kind[:, 2:] > 0)
    return guard.sheet._replace(kind=kind, number=guard.sheet.number[mine])


def repulsion_load(parameters: Parameters, state: State, leaning: Repelled) -> tuple[Array, Array]:
    """Force and torque, (3,) each, on the wall or body by the repelled particles."""
    d, who = len(state.position), leaning.who
    force, place = np.zeros((3, len(who))), np.zeros((3, len(who)))
    force[:d], place[:d] = -state.mass[who] * leaning.acceleration, state.position[:, who]
    return total(force, place, parameters.boundary.centers[leaning.owner])


def energy_of(parameters: Parameters, state: State, leaning: Repelled) -> float:
    """Potential energy of the repulsion of these particles (J)."""
    reach, speed = parameters.boundary.guard.reach, speed_of(parameters)
    gap = reach - np.sqrt((leaning.acceleration**2).sum(axis=0)) * (reach / speed) ** 2
    energy = [wall_forces.standoff_energy(own, reach, speed) for own in gap]
    return dot(state.mass[leaning.who], energy)


@compiled_inside
def weight_at(gap: float, support: float, weights: Array) -> float:
    """The kernel summed over a plane at this distance (1/m), interpolated."""
    last = len(weights) - 1
    place = max(gap, 0.0) / support * last
    below = min(int(place), last - 1)
    found: float = weights[below] + (place - below) * (weights[below + 1] - weights[below])
    return found


@spread
def brake(
    position: Array, velocity: Array, kind: Integers, number: Array, support: float, weights: Array, sound_speed: float,
    acceleration: Array,
) -> None:  # fmt: skip
    """Add the braking by walls and obstacles: see `wall_forces.impact_braking`."""
    dimension = position.shape[0]
    for i in prange(position.shape[1]):
        k, z = 0, position[2, i] if dimension == 3 else 0.0
        x = position[0, i], position[1, i], z
        while k < kind.shape[0]:
            gap, nearest, k = piece_gap(kind, number, k, x, 0.0)
            if gap >= support:
                continue
            normal, approach = inward_normal(kind, number, nearest, x, 0.0), 0.0
            for axis in range(dimension):
                approach += (number[nearest, SPEED + axis] - velocity[axis, i]) * normal[axis]
            if approach > 0.0:
                braking = wall_forces.impact_braking(approach, weight_at(gap, support, weights), sound_speed)
                for axis in range(dimension):
                    acceleration[axis, i] += braking * normal[axis]


def add_braking(parameters: Parameters, state: State, guard: Guard, acceleration: Array) -> None:
    """Add the present braking by the surfaces of a guard to an acceleration."""
    if len(guard.weights) and len(guard.owner):
        sheet, sound = guard.sheet, parameters.material.sound_speed
        brake(state.position, state.velocity, *sheet[:2], guard.support, guard.weights, sound, acceleration)


def brake_at_walls(parameters: Parameters, state: State) -> None:
    """Add the present braking by walls and obstacles to the acceleration of the liquid."""
    add_braking(parameters, state, parameters.boundary.guard, state.acceleration)


def braked_by_wall(parameters: Parameters, state: State, owner: int) -> Repelled:
    """Particles braked by a wall or an obstacle."""
    guard, acceleration = parameters.boundary.guard, np.zeros_like(state.position)
    mine = guard._replace(sheet=sheet_of(guard, owner), owner=guard.owner[guard.owner == owner])
    add_braking(parameters, state, mine, acceleration)
    who = np.flatnonzero(acceleration.any(axis=0))
    return Repelled(owner, who, acceleration[:, who])


def all_braked(parameters: Parameters, state: State) -> list[Repelled]:
    """Particles braked by walls and obstacles, for each of these."""
    guard = parameters.boundary.guard
    if not len(guard.weights):
        return []
    return [braked_by_wall(parameters, state, int(owner)) for owner in np.unique(guard.owner)]
