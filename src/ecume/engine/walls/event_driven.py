"""Event-driven motion of particles between walls: each flies from collision to collision until its step is used up.

First the parts of one flight: the next event, the rebound, rest on surfaces and sliding along them. Then the step of
all particles, over threads, and the record of who hit what, when and where.
"""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import compiled, compiled_inside, prange, threaded
from ecume.engine.cells import Integers
from ecume.engine.walls.sheets import (
    NEVER,
    RESTITUTION,
    SIZE,
    TANGENTIAL,
    Sheet,
    Vector,
    cross,
    dot,
    eased,
    flown,
    from_center,
    gap_to,
    grain_at,
    hole_at,
    inward_normal,
    length,
    place_of,
    plus,
    put,
    row,
    scaled,
    time_to_plane,
    time_to_sphere,
    wall_velocity,
    worst_gap,
)
from ecume.engine.walls.surfaces import PLANE
from ecume.units import Array

STAYED, CAPPED, STARTED_OUTSIDE = 0, -1, -2
"""Fates; a particle that left through opening m has the fate m + 1."""
MOST_EVENTS = 10_000
"""Events in one step, after which a particle is left where it is, and flagged."""
CALM = 1e-8
"""A rebound slower than this part of the step's own speeds is rest: bounces end, as Zeno's do, in a finite time."""
ULPS = 1e-15
"""What rounding may do to a velocity's part."""
ARC = 0.02
"""Along a curved wall a particle slides in pieces of this angle, or this part of sqrt(radius / acceleration)."""
NOTHING = -1
Held = tuple[int, int, int]
Course = tuple[Vector, Vector, Vector]
"""Position, velocity and acceleration."""
Moment = tuple[float, float, float]
"""The time since the step began, what is left of the step, and the particle's radius."""
State = tuple[Vector, Vector, Vector, float, Held]
"""Position, velocity, the push from outside, time, and what it rests on."""
NOBODY = (-1, -1, -1)
CHUNK = 256
"""Particles that one thread takes at a time."""
FEW = 2000
"""Starting threads for fewer particles takes longer than they save."""
SETTLED = 64
"""In a corner rounding keeps a particle astir: after so many events with next to no speed it is at rest."""
Log = tuple[Integers, Integers, Array, Array]
"""Where a particle's record begins (empty: no record); surface, time and place of each hit."""


@compiled_inside
def undisturbed(course: Course, moment: Moment, kind: Integers, number: Array) -> bool:
    """Whether no collision is possible: a bound that needs no roots, sufficient for nearly all particles."""
    k = 0
    while k < kind.shape[0]:
        free, stop = False, max(int(kind[k, 2]), k + 1)
        for other in range(k, stop):
            free = free or least_gap(course, moment, kind, number, other) > 0.0
        if not free:
            return False
        k = stop
    return True


@compiled_inside
def least_gap(course: Course, moment: Moment, kind: Integers, number: Array, k: int) -> float:
    """A lower bound of the gap to surface k during the rest of the step."""
    x, v, a = course
    time, left, radius = moment
    gap = gap_to(kind, number, k, x, time) - radius
    q = plus(v, -1.0, wall_velocity(number, k))
    if kind[k, 0] == PLANE:
        n = place_of(number, k)
        return gap + left * (min(dot(q, n), 0.0) + 0.5 * left * min(dot(a, n), 0.0))
    return gap - left * (length(q) + 0.5 * left * length(a))


@compiled_inside
def time_to_surface(course: Course, moment: Moment, kind: Integers, number: Array, k: int) -> float:
    """The time from now until surface k is crossed from inside to outside."""
    x, v, a = course
    time, left, radius = moment
    q = plus(v, -1.0, wall_velocity(number, k))
    if kind[k, 0] == PLANE:
        n = place_of(number, k)
        gap = gap_to(kind, number, k, x, time) - radius
        if kind[k, 2] == 0 or gap > -grain_at(number, k, x):
            gap = max(gap, 0.0)
        return time_to_plane(gap, dot(q, n), dot(a, n))
    side = float(kind[k, 0])
    shape = (number[k, SIZE] - side * radius, side, left)
    return time_to_sphere(from_center(number, k, x, time), q, a, shape)


@compiled_inside
def on_face(course: Course, moment: Moment, kind: Integers, number: Array, k: int) -> bool:
    """Whether a point of the plane is on the obstacle's face: inside of its other planes, and not just leaving."""
    x, v, a = course
    time, _, radius = moment
    for j in range(kind[k, 1], kind[k, 2]):
        gap, grain = gap_to(kind, number, j, x, time) - radius, grain_at(number, j, x)
        n = place_of(number, j)
        away = dot(plus(v, -1.0, wall_velocity(number, j)), n)
        if j != k and (gap > grain or (gap > -grain and (away > 0.0 or (away == 0.0 and dot(a, n) > 0.0)))):
            return False
    return True


@compiled_inside
def time_to_rim(course: Course, moment: Moment, kind: Integers, number: Array, k: int) -> float:
    """The time until a particle that slides on face k of an obstacle leaves it."""
    x, v, a = course
    time, _, radius = moment
    soonest = NEVER
    for j in range(kind[k, 1], kind[k, 2]):
        if j != k:
            n = place_of(number, j)
            depth = radius - gap_to(kind, number, j, x, time)
            away = dot(plus(v, -1.0, wall_velocity(number, j)), n)
            soonest = min(soonest, time_to_plane(max(depth, 0.0), -away, -dot(a, n)))
    return soonest


@compiled
def next_event(course: Course, moment: Moment, held: Held, kind: Integers, number: Array) -> tuple[float, int]:
    """The next event in the rest of the step: the surface hit, or -2 - k for leaving face k.

    Simultaneous hits, up to rounding, follow one another, in the order of the surfaces.
    """
    time, left, radius = moment
    soonest, what = left, NOTHING
    for k in range(kind.shape[0]):
        on = k == held[0] or k == held[1] or k == held[2]
        wait = time_to_rim(course, moment, kind, number, k) if on else time_to_surface(course, moment, kind, number, k)
        if wait < soonest - 4e-16 * left:
            x, v, a = flown(course[0], course[1], course[2], wait), plus(course[1], wait, course[2]), course[2]
            if on:
                soonest, what = wait, -2 - k
            elif kind[k, 2] == 0 or on_face((x, v, a), (time + wait, 0.0, radius), kind, number, k):
                soonest, what = wait, k
    return soonest, what


@compiled_inside
def supports(held: Held, kind: Integers, number: Array, x: Vector, time: float) -> tuple[Vector, Vector, Vector]:
    """The normals of what a particle rests on; 0 for nothing."""
    none = (0.0, 0.0, 0.0)
    first = inward_normal(kind, number, held[0], x, time) if held[0] >= 0 else none
    second = inward_normal(kind, number, held[1], x, time) if held[1] >= 0 else none
    third = inward_normal(kind, number, held[2], x, time) if held[2] >= 0 else none
    return first, second, third


@compiled_inside
def without(held: Held, k: int) -> Held:
    """All but k."""
    return (
        held[0] if held[0] != k else -1,
        held[1] if held[1] != k else -1,
        held[2] if held[2] != k else -1,
    )


@compiled_inside
def holding(held: Held, k: int) -> Held:
    """k, and the two latest others."""
    rest = without(held, k)
    return k, rest[0] if rest[0] >= 0 else rest[1], rest[2] if rest[0] < 0 else (rest[1] if rest[1] >= 0 else rest[2])


@compiled_inside
def curved_one(held: Held, kind: Integers) -> int:
    """The sphere a particle rests on, or -1."""
    for k in held:
        if k >= 0 and kind[k, 0] != PLANE:
            return k
    return -1


@compiled_inside
def snapped(x: Vector, moment: Moment, kind: Integers, number: Array, k: int) -> Vector:
    """Onto the surface: a hit point is off by rounding, which must not add up to a leak."""
    time, _, radius = moment
    gap = gap_to(kind, number, k, x, time) - radius
    return plus(x, -gap, inward_normal(kind, number, k, x, time))


@compiled_inside
def curvature(kind: Integers, number: Array, k: int, radius: float) -> float:
    """1 over the radius on which a center slides along the surface; negative over a ball, 0 on a plane."""
    return 0.0 if kind[k, 0] == PLANE else kind[k, 0] / (number[k, SIZE] - kind[k, 0] * radius)


@compiled_inside
def met(state: State, moment: Moment, kind: Integers, number: Array, k: int) -> tuple[Vector, Held, bool]:
    """The velocity after surface k has been met, what supports the particle then, and whether it was a real hit.

    In the wall's frame the normal velocity turns, v_n -> -C_R v_n, and the tangential one becomes C_T v_t. What would
    rebound slower than `calm` while pressed on stays on the surface, and slides without friction.
    """
    x, v, push, calm, held = state
    n = inward_normal(kind, number, k, x, moment[0])
    w = wall_velocity(number, k)
    relative = plus(v, -1.0, w)
    normal = dot(relative, n)
    along = plus(relative, -normal, n)
    back, real = -number[k, RESTITUTION] * normal, normal < -calm
    if real:
        along = scaled(number[k, TANGENTIAL], along)
    bend = curvature(kind, number, k, moment[2])
    if back <= calm and bend * dot(along, along) >= dot(push, n):
        held = holding(held, k)
        on = supports(held, kind, number, x, moment[0])
        if held[2] < 0 <= held[1] and abs(dot(along, on[1])) <= calm and dot(push, on[1]) < 0.0:
            # In a valley rounding would throw it from side to side for ever.
            edge = cross(on[0], on[1])
            along = scaled(dot(along, edge) / max(dot(edge, edge), 1e-24), edge)
        return plus(w, 1.0, eased(along, on[0], on[1], on[2])), held, real
    # Rounding must not leave it moving through the wall, or it would collide endlessly at one instant.
    return plus(plus(w, 1.0, along), max(back, ULPS * length(relative)), n), NOBODY, real


@compiled_inside
def calm_speed(v: Vector, push: Vector, span: float, bounce: tuple[float, float]) -> float:
    """Rebounds slower than this are rest; bounce = (restitution, grain of a position).

    Without loss only a push makes small bounces; with loss any speed dies out. A fall through the rounding of a
    position makes a speed, too.
    """
    strength = length(push)
    lost = length(v) if bounce[0] < 1.0 else 0.0
    return CALM * (span * strength + lost) + math.sqrt(1e-2 * bounce[1] * strength)


@compiled_inside
def rolled(state: State, moment: Moment, kind: Integers, number: Array, k: int) -> tuple[Vector, Vector, float]:
    """Slide along the curved wall k for a piece of the step: position, velocity, and how long it took.

    Velocity Verlet on the sphere: half a kick, a great circle, half a kick; exact without a push.
    """
    x, v, push, _, held = state
    time, left, radius = moment
    w = wall_velocity(number, k)
    rho = number[k, SIZE] - kind[k, 0] * radius
    on = supports(held, kind, number, x, time)
    pull = eased(push, on[0], on[1], on[2])
    speed, strength = length(plus(v, -1.0, w)), length(push)
    piece = min(left, ARC * rho / speed) if speed > 0.0 else left
    piece = min(piece, ARC * math.sqrt(rho / strength)) if strength > 0.0 else piece
    half = plus(plus(v, -1.0, w), 0.5 * piece, pull)
    pace = length(half)
    if pace == 0.0:
        return plus(x, left, w), v, left
    out, ahead = scaled(1.0 / rho, from_center(number, k, x, time)), scaled(1.0 / pace, half)
    cosine, sine = math.cos(pace * piece / rho), math.sin(pace * piece / rho)
    new = plus(scaled(cosine, out), sine, ahead)
    x = plus(plus(plus(x, rho, new), -rho, out), piece, w)
    half = scaled(pace, plus(scaled(cosine, ahead), -sine, out))
    on = supports(held, kind, number, x, time + piece)
    half = plus(half, 0.5 * piece, eased(push, on[0], on[1], on[2]))
    return x, plus(w, 1.0, eased(half, on[0], on[1], on[2])), piece


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
    """Advance to the next event: position and velocity there, the time it took, and the event."""
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
    """`held` without the surfaces that the particle leaves, or from which the others pull it, or on which it no longer
    presses.
    """
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
    """All particles, in chunks over threads. The arguments of `fly_some` are repeated as single arrays, because in a
    threaded loop Numba writes to copies of arrays that come out of a tuple.
    """
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
