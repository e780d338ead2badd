"""Plane walls: their motion, and the contacts of spheres with them.

A wall is the limit of a sphere with infinite radius: R* = R, and its normal never rotates. A contact with a wall
consists of film and surface in series as between spheres, but the gap vector slips along the wall instead of rotating.
Normals point from the spheres to the wall; distances and slips are those of the wall relative to the sphere. The
position of a wall on which a force acts is an unknown of each stage, like the strain of a stress-controlled box.

Spheres that are glued to a wall make it rough. Instead of film and surface they have a linear spring (`glue`), which
opposes changes of the vector to the wall.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside, where_there
from ecume.engine.array_copies import clear_rows, copy_line, copy_rows
from ecume.engine.cells import Integers
from ecume.laws.surfaces import Body
from ecume.models.soft.contacts.contact import (
    ROUNDING,
    Film,
    Frame,
    LinearContact,
    Start,
    Vector,
    contact_energy,
    dot,
    film_of,
    frame_of,
    linearized,
    square_across,
)
from ecume.models.soft.contacts.rotation import axial, cross
from ecume.models.soft.integration.dirk_schemes import Scheme
from ecume.models.soft.parameters import Contacts, Planes
from ecume.units import Array

FAR = 1e12
"""The distance of the center of a wall, as a sphere, in radii of the sphere that touches it."""


class Places(NamedTuple):
    """The positions of walls in a step."""

    normal: Array
    """(W, 3) from the spheres to the wall"""
    velocity: Array
    """(W, 3) m/s, prescribed"""
    force: Array
    """(W, 3) N at load 1 on walls that forces move"""
    free: Integers
    """(A, 2) walls and axes along which forces move them"""
    place: Array
    """(W, 3) m at the stage: the position of the plane on its axis, and displacements along the others"""
    before: Array
    """(W, 3) at the start of the step"""
    start: Array
    """(W, 3) at the start of the stage"""
    slope: Array
    """(S, W, 3) m/s at each stage"""
    past: Array
    """(W, 3) m/s at the end of the last step"""
    change: Array
    """(W, 3) m in Newton's step"""
    lift: Array
    """(W, 3) N: the force of permeating liquid"""


class Touches(NamedTuple):
    """Contacts of spheres with walls."""

    first: Integers
    """(C,) the sphere"""
    wall: Integers
    radius: Array
    modulus: Array
    glue: Array
    """(C,) N/m: the stiffness of the glue; 0 where there is a film"""
    log_gap: Array
    slip: Array
    """(C, 3) tangential displacement of the gap vector, in radii; with glue the whole vector"""
    log_gap_start: Array
    slip_start: Array
    log_gap_before: Array
    slip_before: Array
    rate: Array
    """(S, C, 4) of ln(gap) and of the slip (1/s), in each stage"""
    force: Array
    """(C, 3) N on the sphere"""
    correction: Array
    stiffness: Array
    """(C, 3, 3) N/m: force over the displacement of the wall against the sphere"""
    shift: Array
    """(C, 4)"""
    response: Array
    """(C, 4, 3)"""
    now: Array
    """(C, 4) rates of ln(gap) and of the slip (1/s) at the current state"""


class Walls(NamedTuple):
    """Walls and their contacts in a step."""

    places: Places
    touches: Touches


def no_walls() -> Walls:
    """Empty arrays for a scene without walls."""
    none, no_owners = np.zeros((0, 3)), np.zeros(0, np.int64)
    places = Places(none, none, none, np.zeros((0, 2), np.int64), *(none,) * 3, none[None], none, none, none)
    rates, line = np.zeros((0, 4)), np.zeros(0)
    return Walls(
        places,
        Touches(
            no_owners, no_owners, line, line, line, line, none, line, none, line, none, rates[None], none, none,
            np.zeros((0, 3, 3)), rates, np.zeros((0, 4, 3)), rates,
        ),
    )  # fmt: skip


NO_WALLS = no_walls()


def all_walls(walls: Walls | tuple[()]) -> Walls:
    """The walls of a step; empty arrays where the scene has none."""
    return walls or NO_WALLS


def make_walls(planes: Planes, now: tuple[Array, Array], stages: int) -> Places:
    """The positions of walls in a step; `now` contains their present positions and velocities."""
    (place, past), surfaces = now, planes.surfaces
    return Places(
        0.0 - surfaces.place, surfaces.velocity, planes.force, planes.free, place.copy(), place.copy(), place.copy(),
        np.zeros((stages, *place.shape)), past.copy(), np.zeros_like(place), np.zeros_like(place),
    )  # fmt: skip


@compiled_inside
def flattened(film: Film, far: float) -> Film:
    """The contact with a sphere of infinite radius, whose normal is constant: a slip only shears the surface."""
    return Film(
        film.gap, far, far, film.shear, film.stretch, film.surface, film.resistance, film.faded, film.fade_slope,
        film.remote_force, film.remote_slope, film.draw, film.held, film.slide_by_pull, film.slide_by_limit,
        film.limit_by_normal, film.limit_by_gap,
    )  # fmt: skip


@compiled_inside
def normal_of(places: Places, w: int) -> Vector:
    """The normal from the spheres to a wall."""
    normal = places.normal
    return (normal[w, 0], normal[w, 1], normal[w, 2])


@compiled_inside
def wall_distance(walls: Walls, position: Array, turn: Array, c: int) -> Vector:
    """The vector from a sphere to the material point of its wall at the foot of the normal; spins roll the sphere along
    the wall.
    """
    i, w, places = walls.touches.first[c], walls.touches.wall[c], walls.places
    x = places.place[w, 0] - position[i, 0]
    y = places.place[w, 1] - position[i, 1]
    z = places.place[w, 2] - position[i, 2] if position.shape[1] == 3 else 0.0
    if turn.shape[1] == 0:
        return x, y, z
    rolled = cross(axial(turn, i), normal_of(places, w))
    return x - rolled[0], y - rolled[1], z - rolled[2]


@where_there()
def wall_response(walls: Walls, contacts: Contacts, position: Array, turn: Array, span: float) -> None:
    """Linearize each contact with a wall over the implicit time span of its stage."""
    touches, places = walls.touches, walls.places
    slip, slip_start = touches.slip, touches.slip_start
    for c in range(len(touches.first)):
        n, radius = normal_of(places, touches.wall[c]), touches.radius[c]
        x = wall_distance(walls, position, turn, c)
        pull = dot(x, n)
        apart = (x[0] - radius * slip[c, 0], x[1] - radius * slip[c, 1], x[2] - radius * slip[c, 2])
        if touches.glue[c] > 0.0:
            store_glue_response(touches, apart, c)
            continue
        frame = frame_of(apart, n, position.shape[1] == 2)
        body = Body(radius, radius, touches.modulus[c], 0.0, 0.0)
        film = film_of(contacts, body, touches.log_gap[c], pull, dot(apart, frame.t))
        b = (
            (slip_start[c, 0] - slip[c, 0]) / FAR,
            (slip_start[c, 1] - slip[c, 1]) / FAR,
            (slip_start[c, 2] - slip[c, 2]) / FAR,
        )
        missing = touches.log_gap_start[c] - touches.log_gap[c]
        begin = Start(span, missing, 1.0, dot(frame.t, b), dot(frame.s, b))
        store_wall_response(linearized(flattened(film, FAR * radius), begin), frame, touches, c)


@compiled_inside
def store_glue_response(touches: Touches, apart: Vector, c: int) -> None:
    """Store the force of the glue for the displacement of the wall from its initial position relative to the sphere."""
    stiffness, shift, now = touches.glue[c], touches.shift, touches.now
    for k in range(3):
        touches.force[c, k] = stiffness * (apart[0] if k == 0 else apart[1] if k == 1 else apart[2])
        touches.correction[c, k] = 0.0
        for m in range(3):
            touches.stiffness[c, k, m] = stiffness if k == m else 0.0
    for k in range(4):
        shift[c, k] = now[c, k] = 0.0
        for m in range(3):
            touches.response[c, k, m] = 0.0


@compiled_inside
def store_wall_response(linear: LinearContact, frame: Frame, touches: Touches, c: int) -> None:
    """Store the response of a contact in the fixed frame."""
    n, t, s = frame
    shift, now, response = touches.shift, touches.now, touches.response
    shift[c, 0], now[c, 0] = linear.dq, linear.opening
    for k in range(3):
        touches.force[c, k] = linear.force_n * n[k] + linear.force_t * t[k]
        touches.correction[c, k] = linear.correction_n * n[k] + linear.correction_t * t[k] + linear.correction_s * s[k]
        shift[c, 1 + k] = FAR * (linear.turn_t * t[k] + linear.turn_s * s[k])
        now[c, 1 + k] = FAR * linear.sliding * t[k]
        response[c, 0, k] = linear.q_n * n[k] + linear.q_t * t[k]
        by_pull, by_shear = linear.nn * n[k] + linear.tn * t[k], linear.nt * n[k] + linear.tt * t[k]
        for m in range(3):
            touches.stiffness[c, k, m] = by_pull * n[m] + by_shear * t[m] + linear.ss * s[k] * s[m]
            turns = t[k] * (linear.t_n * n[m] + linear.t_t * t[m]) + linear.s_s * s[k] * s[m]
            response[c, 1 + k, m] = FAR * turns


@where_there((0.0, 0.0))
def add_wall_forces(walls: Walls, position: Array, right: Array, corrected: bool) -> tuple[float, float]:
    """Add forces and torques of walls to the residuals of spheres. Returns the largest force, and the largest product
    of stiffness and coordinate.
    """
    touches, places, largest, stiffest = walls.touches, walls.places, 0.0, 0.0
    dimensions = position.shape[1]
    force, correction = touches.force, touches.correction
    for c in range(len(touches.first)):
        i, n = touches.first[c], normal_of(walls.places, touches.wall[c])
        part = 1.0 if corrected else 0.0
        f = (
            force[c, 0] + part * correction[c, 0],
            force[c, 1] + part * correction[c, 1],
            force[c, 2] + part * correction[c, 2],
        )
        for k in range(dimensions):
            largest = max(largest, abs(force[c, k]))
            size = touches.radius[c] + abs(position[i, k]) + abs(places.place[touches.wall[c], k])
            stiffest = max(stiffest, touches.stiffness[c, k, k] * size)
        add_wrench(right, i, dimensions, (f, cross(n, f)))
    return largest, stiffest


@compiled_inside
def add_wrench(right: Array, i: int, dimensions: int, wrench: tuple[Vector, Vector]) -> None:
    """Add a force, and a torque over the radius, to a sphere."""
    f, torque = wrench
    right[i, 0] += f[0]
    right[i, 1] += f[1]
    if dimensions == 3:
        right[i, 2] += f[2]
    if right.shape[1] > dimensions and dimensions == 2:
        right[i, 2] += torque[2]
    elif right.shape[1] > dimensions:
        for k in range(3):
            right[i, 3 + k] += torque[0] if k == 0 else torque[1] if k == 1 else torque[2]


@compiled_inside
def wall_force_change(stiffness: Array, c: int, x: Vector) -> Vector:
    """The change of the force by a displacement of the wall relative to the sphere."""
    return (
        stiffness[c, 0, 0] * x[0] + stiffness[c, 0, 1] * x[1] + stiffness[c, 0, 2] * x[2],
        stiffness[c, 1, 0] * x[0] + stiffness[c, 1, 1] * x[1] + stiffness[c, 1, 2] * x[2],
        stiffness[c, 2, 0] * x[0] + stiffness[c, 2, 1] * x[1] + stiffness[c, 2, 2] * x[2],
    )


@compiled_inside
def distance_derivative(k: int, dimensions: int, n: Vector) -> Vector:
    """The derivative of the distance vector from a wall by an unknown of a sphere: a position or a spin."""
    axis = k if k < dimensions else 2 if dimensions == 2 else k - dimensions
    one = (1.0 if axis == 0 else 0.0, 1.0 if axis == 1 else 0.0, 1.0 if axis == 2 else 0.0)
    if k >= dimensions:
        one = cross(one, n)
    return -one[0], -one[1], -one[2]


@where_there()
def add_wall_stiffness(walls: Walls, blocks: Array, own: Integers, dimensions: int) -> None:
    """Add the stiffness of contacts with walls to the diagonal blocks of the spheres."""
    touches, width = walls.touches, blocks.shape[1]
    for c in range(len(touches.first)):
        place, n = own[touches.first[c]], normal_of(walls.places, touches.wall[c])
        for column in range(width):
            f = wall_force_change(touches.stiffness, c, distance_derivative(column, dimensions, n))
            torque = cross(n, f)
            blocks[place, 0, column] -= f[0]
            blocks[place, 1, column] -= f[1]
            if dimensions == 3:
                blocks[place, 2, column] -= f[2]
            if width == 3 and dimensions == 2:
                blocks[place, 2, column] -= torque[2]
            elif width == 6:
                blocks[place, 3, column] -= torque[0]
                blocks[place, 4, column] -= torque[1]
                blocks[place, 5, column] -= torque[2]


@where_there(0.0)
def wall_energy(walls: Walls, contacts: Contacts, position: Array, turn: Array) -> float:
    """The elastic energy of the deflections at walls (J); `turn` as in `wall_distance`."""
    touches, total = walls.touches, 0.0
    for c in range(len(touches.first)):
        n, radius = normal_of(walls.places, touches.wall[c]), touches.radius[c]
        x = wall_distance(walls, position, turn, c)
        pull, slip = dot(x, n), touches.slip
        apart = (x[0] - radius * slip[c, 0], x[1] - radius * slip[c, 1], x[2] - radius * slip[c, 2])
        if touches.glue[c] > 0.0:
            total += 0.5 * touches.glue[c] * dot(apart, apart)
            continue
        body = Body(radius, radius, touches.modulus[c], 0.0, 0.0)
        gap, square = math.exp(touches.log_gap[c]), square_across(apart, n)
        total += contact_energy(contacts, body, gap, pull - radius - gap, square)
    return total


# --- Motion of walls, and of the contacts with them, through the stages of a step


@where_there(0.0)
def shift_at_walls(walls: Walls, change: Array, dimensions: int) -> float:
    """Compute the changes of the contacts with walls that follow from Newton's step. Returns the largest."""
    touches, places = walls.touches, walls.places
    shift, response, largest = touches.shift, touches.response, 0.0
    for c in range(len(touches.first)):
        i, w = touches.first[c], touches.wall[c]
        n = normal_of(places, w)
        x, y, z = places.change[w, 0], places.change[w, 1], places.change[w, 2]
        for k in range(change.shape[1]):
            by = distance_derivative(k, dimensions, n)
            x, y, z = x + change[i, k] * by[0], y + change[i, k] * by[1], z + change[i, k] * by[2]
        for k in range(4):
            shift[c, k] += response[c, k, 0] * x + response[c, k, 1] * y + response[c, k, 2] * z
            largest = max(largest, abs(shift[c, k]))
    return largest


@where_there()
def move_walls(walls: Walls, part: float) -> None:
    """Add a fraction of Newton's step to walls and their contacts."""
    touches, places = walls.touches, walls.places
    for w in range(len(places.place)):
        for k in range(3):
            places.place[w, k] += part * places.change[w, k]
    for c in range(len(touches.first)):
        touches.log_gap[c] += part * touches.shift[c, 0]
        for k in range(3):
            touches.slip[c, k] += part * touches.shift[c, 1 + k]


@where_there()
def first_walls(walls: Walls) -> None:
    """Reset walls and their contacts to the start of the step."""
    touches, places = walls.touches, walls.places
    copy_rows(places.place, places.before)
    copy_rows(places.start, places.before)
    clear_rows(places.change)
    copy_rows(places.slope[0], places.past)
    copy_line(touches.log_gap, touches.log_gap_before)
    copy_rows(touches.slip, touches.slip_before)
    copy_line(touches.log_gap_start, touches.log_gap_before)
    copy_rows(touches.slip_start, touches.slip_before)


@where_there()
def slopes_at_walls(walls: Walls) -> None:
    """Copy the rates of contacts with walls at the start of the step."""
    copy_rows(walls.touches.rate[0], walls.touches.now)


@where_there()
def begin_walls(walls: Walls, scheme: Scheme, stage: int, time_step: float) -> None:
    """Set the start of a stage, and move walls with prescribed motion to their positions at its end."""
    touches, places, rows = walls.touches, walls.places, scheme.rows
    for c in range(len(touches.first)):
        touches.log_gap_start[c] = touches.log_gap_before[c]
        for k in range(3):
            touches.slip_start[c, k] = touches.slip_before[c, k]
        for earlier in range(stage):
            touches.log_gap_start[c] += time_step * rows[stage, earlier] * touches.rate[earlier, c, 0]
            for k in range(3):
                touches.slip_start[c, k] += time_step * rows[stage, earlier] * touches.rate[earlier, c, 1 + k]
    for w in range(len(places.place)):
        for k in range(3):
            places.start[w, k] = places.before[w, k]
            for earlier in range(stage):
                places.start[w, k] += time_step * rows[stage, earlier] * places.slope[earlier, w, k]
            if places.velocity[w, k] != 0.0:
                places.place[w, k] = places.before[w, k] + scheme.times[stage] * time_step * places.velocity[w, k]


@where_there()
def end_walls(walls: Walls, stage: int, span: float) -> None:
    """Compute the slopes of a solved stage."""
    touches, places = walls.touches, walls.places
    for c in range(len(touches.first)):
        touches.rate[stage, c, 0] = (touches.log_gap[c] - touches.log_gap_start[c]) / span
        for k in range(3):
            touches.rate[stage, c, 1 + k] = (touches.slip[c, k] - touches.slip_start[c, k]) / span
    for w in range(len(places.place)):
        for k in range(3):
            moved = places.velocity[w, k]
            places.slope[stage, w, k] = moved if moved != 0.0 else (places.place[w, k] - places.start[w, k]) / span


@where_there(0.0)
def wall_error(walls: Walls, scheme: Scheme, time_step: float) -> float:
    """The largest difference from the embedded scheme, of ln(gap) or of a slip in radii."""
    touches, weights = walls.touches, scheme.error
    largest = 0.0
    for c in range(len(touches.first)):
        for k in range(4):
            value = 0.0
            for stage in range(len(weights)):
                value += weights[stage] * touches.rate[stage, c, k]
            largest = max(largest, abs(time_step * value))
    return largest


@where_there()
def accept_walls(walls: Walls, turn: Array) -> None:
    """Start the next step: the rotation of spheres is added to the slip of their contacts, and reset."""
    touches, places = walls.touches, walls.places
    for c in range(len(touches.first)):
        touches.log_gap_before[c] = touches.log_gap[c]
        rolled = (0.0, 0.0, 0.0)
        if turn.shape[1] > 0:
            rolled = cross(axial(turn, touches.first[c]), normal_of(places, touches.wall[c]))
        radius = touches.radius[c]
        touches.slip[c, 0] += rolled[0] / radius
        touches.slip[c, 1] += rolled[1] / radius
        touches.slip[c, 2] += rolled[2] / radius
        for k in range(3):
            touches.slip_before[c, k] = touches.slip[c, k]
    copy_rows(places.before, places.place)
    copy_rows(places.past, places.slope[-1])


# --- Walls that forces move: their positions border the system of Newton's method, like the shear of a box


@compiled
def column_of_wall(walls: Walls, to: tuple[Array, Array], unknown: int, dimensions: int) -> None:
    """Write the border of a movable wall: the change of forces on spheres by its displacement, and the change of the
    force on the wall by displacements of spheres.
    """
    (column, rows), touches = to, walls.touches
    wall, axis = walls.places.free[unknown]
    along = (1.0 if axis == 0 else 0.0, 1.0 if axis == 1 else 0.0, 1.0 if axis == 2 else 0.0)
    column[:] = 0.0
    rows[:] = 0.0
    for c in range(len(touches.first)):
        if touches.wall[c] == wall:
            i, n = touches.first[c], normal_of(walls.places, wall)
            f = wall_force_change(touches.stiffness, c, along)
            add_wrench(column, i, dimensions, (f, cross(n, f)))
            for k in range(rows.shape[1]):
                rows[i, k] += dot(wall_force_change(touches.stiffness, c, distance_derivative(k, dimensions, n)), along)


@compiled_inside
def target_force(places: Places, unknown: int, load: tuple[float, float]) -> float:
    """The prescribed force on a movable wall (N), including that of permeating liquid, which the spheres balance; the
    factor of wall shear applies to its tangential components.
    """
    wall, axis = places.free[unknown]
    along = 1.0 if places.normal[wall, axis] != 0.0 else load[1]
    return float(load[0] * along * places.force[wall, axis] + places.lift[wall, axis])


@compiled
def corner_of_walls(walls: Walls, load: tuple[float, float], borders: tuple[Array, Array]) -> None:
    """Compute the residual force on each movable wall, and its derivatives by the displacements of walls."""
    (left, corner), touches, free = borders, walls.touches, walls.places.free
    for one in range(len(free)):
        wall, axis = free[one]
        left[one] = -target_force(walls.places, one, load)
        corner[one, :] = 0.0
        for c in range(len(touches.first)):
            if touches.wall[c] == wall:
                left[one] += touches.force[c, axis] + touches.correction[c, axis]
                for other in range(len(free)):
                    if free[other, 0] == wall:
                        corner[one, other] += touches.stiffness[c, axis, free[other, 1]]


@where_there(0.0)
def wall_force_residual(walls: Walls, position: Array, load: tuple[float, float]) -> float:
    """The largest residual of a force on a wall, relative to the sum of magnitudes, minus the rounding error."""
    touches, worst = walls.touches, 0.0
    for unknown in range(len(walls.places.free)):
        wall, axis = walls.places.free[unknown]
        target = target_force(walls.places, unknown, load)
        total, whole, rounding = -target, abs(target), 0.0
        for c in range(len(touches.first)):
            if touches.wall[c] == wall:
                total += touches.force[c, axis]
                whole += abs(touches.force[c, axis])
                size = abs(walls.places.place[wall, axis]) + abs(position[touches.first[c], axis])
                rounding += ROUNDING * abs(touches.stiffness[c, axis, axis]) * size
        if whole > 0.0:
            worst = max(worst, (abs(total) - rounding) / whole)
    return worst
