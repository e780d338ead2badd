"""All particles through one step, over threads; and the record of who hit what, when and where."""

from __future__ import annotations

import numpy as np

from ecume._jit import compiled, compiled_inside, prange, threaded
from ecume.engine.cells import Integers
from ecume.engine.walls.flight import (
    CALM,
    CAPPED,
    MOST_EVENTS,
    NOBODY,
    NOTHING,
    STARTED_OUTSIDE,
    STAYED,
    Course,
    Held,
    Moment,
    calm_speed,
    curvature,
    curved_one,
    met,
    next_event,
    rolled,
    snapped,
    supports,
    undisturbed,
    without,
)
from ecume.engine.walls.sheets import RESTITUTION, Sheet, grain_at, hole_at, inward_normal, wall_velocity, worst_gap
from ecume.engine.walls.surfaces import PLANE
from ecume.engine.walls.vectors import Vector, dot, eased, flown, length, plus, put, row
from ecume.units import Array

CHUNK = 256
"""Particles that one thread takes at a time."""
FEW = 2000
"""Starting threads for fewer particles takes longer than they save."""
SETTLED = 64
"""In a corner rounding keeps a particle astir: after so many events with next to no speed it is at rest."""
Log = tuple[Integers, Integers, Array, Array]
"""Where a particle's record begins (empty: no record); surface, time and place of each hit."""


@compiled_inside
def note(log: Log, i: int, hit: tuple[int, int, float], place: Vector) -> None:
    """Write down one hit: its number among the particle's, the surface, the time."""
    first, which, when, where = log
    if first.shape[0] > 0:
        spot = first[i] + hit[0]
        which[spot], when[spot] = hit[1], hit[2]
        put(where, spot, place)


@compiled_inside
def kept(x: Vector, start: Vector, moment: Moment, sheet: tuple[Integers, Array]) -> tuple[Vector, bool]:
    """The end point, moved back by what rounding has left outside; and whether it was no more than rounding."""
    kind, number = sheet
    for _ in range(3):
        gap, k = worst_gap(kind, number, x, moment[0])
        gap -= moment[2]
        if k < 0 or gap >= 0.0:
            return x, True
        if gap < -1e3 * (grain_at(number, k, x) + grain_at(number, k, start)):
            return snapped(x, moment, kind, number, k), False
        x = snapped(x, moment, kind, number, k)
    return x, True


@compiled_inside
def passage(
    course: Course, moment: Moment, held: Held, kind: Integers, number: Array
) -> tuple[Vector, Vector, float, int]:
    """To the next event: position and velocity there, how long it took, and what it is."""
    x, v, push = course
    time, _, radius = moment
    curved = curved_one(held, kind)
    if curved >= 0:
        state = (x, v, push, 0.0, held)
        new, fast, piece = rolled(state, moment, kind, number, curved)
        if piece == 0.0:
            return x, v, 0.0, NOTHING
        chord = (x, scaled_between(x, new, piece), (0.0, 0.0, 0.0))
        sooner, what = next_event(chord, (time, piece, radius), held, kind, number)
        if what >= 0:
            new, fast, piece = rolled(state, (time, sooner, radius), kind, number, curved)
        return new, fast, piece, what
    on = supports(held, kind, number, x, time)
    a = eased(push, on[0], on[1], on[2])
    wait, what = next_event((x, v, a), moment, held, kind, number)
    return flown(x, v, a, wait), plus(v, wait, a), wait, what


@compiled_inside
def scaled_between(x: Vector, new: Vector, time: float) -> Vector:
    """The velocity that leads from one point to another."""
    return (new[0] - x[0]) / time, (new[1] - x[1]) / time, (new[2] - x[2]) / time


@compiled_inside
def lifted(held: Held, course: Course, moment: Moment, kind: Integers, number: Array) -> Held:
    """Without what the particle moves away from, or is pulled away from by the others, or no longer presses on."""
    x, v, push = course
    on = supports(held, kind, number, x, moment[0])
    a = eased(push, on[0], on[1], on[2])
    for place in range(3):
        k = held[place]
        if k >= 0:
            q = plus(v, -1.0, wall_velocity(number, k))
            lift = dot(push if kind[k, 0] != PLANE else a, on[place])
            bend = curvature(kind, number, k, moment[2]) * dot(q, q)
            if dot(q, on[place]) > CALM * length(q) or lift - bend > CALM * length(push):
                held = without(held, k)
    return held


@compiled_inside
def flight(
    course: Course,
    span: tuple[float, float],
    sheet: tuple[Integers, Array, Integers, Array],
    log: Log,
    own: tuple[int, Integers],
) -> tuple[Vector, Vector, int, int]:
    """One particle through one step: position, velocity, number of hits, fate."""
    x, v, push = course
    dt, radius = span
    kind, number, hole, part = sheet
    i, per_surface = own
    time, hits, held, quiet = 0.0, 0, NOBODY, 0
    for _ in range(MOST_EVENTS):
        moment = (time, dt - time, radius)
        held = lifted(held, (x, v, push), moment, kind, number)
        x, v, wait, what = passage((x, v, push), moment, held, kind, number)
        time = dt if wait >= dt - time else time + wait
        if what == NOTHING and time >= dt:
            x, well = kept(x, course[0], (dt, 0.0, radius), (kind, number))
            return x, v, hits, STAYED if well else CAPPED
        if what <= -2:
            held = without(held, -2 - what)
        elif what >= 0:
            x = snapped(x, (time, dt - time, radius), kind, number, what)
            touch = plus(x, -radius, inward_normal(kind, number, what, x, time))
            through = hole_at(hole, part, number, what, (touch, time))
            if through >= 0:
                return x, v, hits, through + 1
            moment = (time, dt - time, radius)
            bounce = (number[what, RESTITUTION], grain_at(number, what, x))
            calm = calm_speed(course[1], push, dt, bounce)
            v, held, real = met((x, v, push, calm, held), moment, kind, number, what)
            if real:
                note(log, i, (hits, what, time), x)
                per_surface[what] += 1
                hits += 1
            wall = wall_velocity(number, what)
            quiet = quiet + 1 if length(plus(v, -1.0, wall)) <= calm else 0
            if quiet > SETTLED:
                x, well = kept(plus(x, dt - time, wall), course[0], (dt, 0.0, radius), (kind, number))
                return x, wall, hits, STAYED if well else CAPPED
    return x, v, hits, CAPPED


@compiled
def fly_some(
    start: int,
    stop: int,
    position: Array,
    velocity: Array,
    acceleration: Array,
    radius: Array,
    dt: float,
    kind: Integers,
    number: Array,
    hole: Integers,
    part: Array,
    log: Log,
    hits: Integers,
    fate: Integers,
    per_surface: Integers,
) -> None:
    """Particles `start` to `stop` through one step, in place."""
    for i in range(start, stop):
        if fate[i] != STAYED:
            continue
        push = row(acceleration, i if acceleration.shape[0] > 1 else 0)
        course = (row(position, i), row(velocity, i), push)
        own_radius = radius[i if radius.shape[0] > 1 else 0]
        if undisturbed(course, (0.0, dt, own_radius), kind, number):
            put(position, i, flown(course[0], course[1], push, dt))
            put(velocity, i, plus(course[1], dt, push))
            continue
        gap, k = worst_gap(kind, number, course[0], 0.0)
        if not gap - own_radius >= -grain_at(number, k, course[0]):
            fate[i] = STARTED_OUTSIDE
            continue
        x, v, hits[i], fate[i] = flight(course, (dt, own_radius), (kind, number, hole, part), log, (i, per_surface))
        put(position, i, x)
        put(velocity, i, v)


@threaded
def fly_all(
    position: Array,
    velocity: Array,
    acceleration: Array,
    radius: Array,
    dt: float,
    kind: Integers,
    number: Array,
    hole: Integers,
    part: Array,
    first: Integers,
    which: Integers,
    when: Array,
    where: Array,
    hits: Integers,
    fate: Integers,
    per_surface: Integers,
) -> None:
    """Everyone, over threads; bare arrays, since threads write to copies of what is in a tuple."""
    count, surfaces = position.shape[0], kind.shape[0]
    chunks = (count + CHUNK - 1) // CHUNK
    counted = np.zeros((chunks, surfaces), np.int64)
    for chunk in prange(chunks):
        mine = np.zeros(surfaces, np.int64)
        fly_some(
            chunk * CHUNK, min(count, (chunk + 1) * CHUNK), position, velocity, acceleration, radius, dt,
            kind, number, hole, part, (first, which, when, where), hits, fate, mine,
        )  # fmt: skip
        for k in range(surfaces):
            counted[chunk, k] = mine[k]
    for chunk in range(chunks):
        for k in range(surfaces):
            per_surface[k] += counted[chunk, k]


@compiled
def reflect_all(
    position: Array,
    velocity: Array,
    acceleration: Array,
    dt: float,
    sheet: Sheet,
    radius: Array,
    tally: tuple[Integers, Integers, Integers],
) -> int:
    """Fly all particles through one step of `dt` seconds, in place; for compiled code and Python alike.

    position, velocity: (N, 2) or (N, 3), C-contiguous; acceleration: (N, d), or (1, d) for all; radius: (N,) or (1,).
    sheet: `sheet(walls, restitution, tangential)`. tally: hits (N,) is written; fate (N,) is written for those whose
    fate is 0 (others stay where they are): 0 stayed, m + 1 left through opening m, -1 more events than MOST_EVENTS, -2
    started outside and was not moved; hits per surface (K,) are added. Returns how many have a negative fate.
    """
    hits, fate, per_surface = tally
    kind, number, hole, part = sheet.kind, sheet.number, sheet.hole, sheet.part
    nothing, nowhen, nowhere = np.zeros(0, np.int64), np.zeros(0), np.zeros((0, position.shape[1]))
    hits[:] = 0
    if position.shape[0] < FEW:
        fly_some(
            0, position.shape[0], position, velocity, acceleration, radius, dt,
            kind, number, hole, part, (nothing, nothing, nowhen, nowhere), hits, fate, per_surface,
        )  # fmt: skip
    else:
        fly_all(
            position, velocity, acceleration, radius, dt,
            kind, number, hole, part, nothing, nothing, nowhen, nowhere, hits, fate, per_surface,
        )  # fmt: skip
    troubled = 0
    for i in range(fate.shape[0]):
        troubled += fate[i] < 0
    return troubled
