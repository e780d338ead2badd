"""Event-driven motion of particles between walls: each particle moves from collision to collision until the end of the
step.

The first part treats one flight: the next event, the rebound, rest on surfaces and sliding along them. The second part
is the step of all particles, with threads, and the record of hits.
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
    axpy,
    ballistic,
    cross,
    dot,
    from_center,
    gap_to,
    hole_at,
    inward_normal,
    length,
    load,
    place_of,
    projected_on_cone,
    rounding_at,
    scaled,
    store,
    time_to_plane,
    time_to_sphere,
    wall_velocity,
    worst_gap,
)
from ecume.engine.walls.surfaces import PLANE
from ecume.units import Array

STAYED, CAPPED, STARTED_OUTSIDE = 0, -1, -2
"""Status values after a step; a particle that left through opening m has status m + 1."""
MOST_EVENTS = 10_000
"""The largest number of events in a step; then the particle stops where it is, and is flagged."""
CALM = 1e-8
"""A rebound slower than this fraction of the speeds of the step counts as rest, so that a decaying series of bounces
ends.
"""
ULPS = 1e-15
"""The relative rounding error of a velocity component."""
ARC = 0.02
"""Sliding along a curved wall is divided into arcs of this angle (rad), or this fraction of sqrt(radius /
acceleration).
"""
NOTHING = -1
Held = tuple[int, int, int]
Motion = tuple[Vector, Vector, Vector]
"""Position, velocity and acceleration."""
Moment = tuple[float, float, float]
"""The time since the start of the step, the remaining time of the step, and the radius of the particle."""
State = tuple[Vector, Vector, Vector, float, Held]
"""Position, velocity, acceleration by external forces, calm speed, and supports."""
NO_SUPPORTS = (-1, -1, -1)
CHUNK = 256
"""Particles per task of a thread."""
FEW = 2000
"""The number of particles from which threads are used."""
SETTLED = 64
"""The number of events at nearly zero speed after which a particle is at rest: rounding may cause endless small motion
in a corner.
"""
Log = tuple[Integers, Integers, Array, Array]
"""The index of a particle's record (empty: no record); surface, time and position of each hit."""


@compiled_inside
def undisturbed(motion: Motion, moment: Moment, kind: Integers, number: Array) -> bool:
    """Whether a collision is excluded by a sufficient bound, without computing roots."""
    k = 0
    while k < kind.shape[0]:
        free, stop = False, max(int(kind[k, 2]), k + 1)
        for other in range(k, stop):
            free = free or least_gap(motion, moment, kind, number, other) > 0.0
        if not free:
            return False
        k = stop
    return True


@compiled_inside
def least_gap(motion: Motion, moment: Moment, kind: Integers, number: Array, k: int) -> float:
    """A lower bound of the gap to surface k during the rest of the step."""
    x, v, a = motion
    time, left, radius = moment
    gap = gap_to(kind, number, k, x, time) - radius
    q = axpy(v, -1.0, wall_velocity(number, k))
    if kind[k, 0] == PLANE:
        n = place_of(number, k)
        return gap + left * (min(dot(q, n), 0.0) + 0.5 * left * min(dot(a, n), 0.0))
    return gap - left * (length(q) + 0.5 * left * length(a))


@compiled_inside
def time_to_surface(motion: Motion, moment: Moment, kind: Integers, number: Array, k: int) -> float:
    """The time from now until surface k is crossed from inside to outside."""
    x, v, a = motion
    time, left, radius = moment
    q = axpy(v, -1.0, wall_velocity(number, k))
    if kind[k, 0] == PLANE:
        n = place_of(number, k)
        gap = gap_to(kind, number, k, x, time) - radius
        if kind[k, 2] == 0 or gap > -rounding_at(number, k, x):
            gap = max(gap, 0.0)
        return time_to_plane(gap, dot(q, n), dot(a, n))
    side = float(kind[k, 0])
    shape = (number[k, SIZE] - side * radius, side, left)
    return time_to_sphere(from_center(number, k, x, time), q, a, shape)


@compiled_inside
def on_face(motion: Motion, moment: Moment, kind: Integers, number: Array, k: int) -> bool:
    """Whether a point of the plane is on the face of the obstacle: inside its other planes, and not leaving them."""
    x, v, a = motion
    time, _, radius = moment
    for j in range(kind[k, 1], kind[k, 2]):
        gap, rounding = gap_to(kind, number, j, x, time) - radius, rounding_at(number, j, x)
        n = place_of(number, j)
        away = dot(axpy(v, -1.0, wall_velocity(number, j)), n)
        if j != k and (gap > rounding or (gap > -rounding and (away > 0.0 or (away == 0.0 and dot(a, n) > 0.0)))):
            return False
    return True


@compiled_inside
def time_to_rim(motion: Motion, moment: Moment, kind: Integers, number: Array, k: int) -> float:
    """The time after which a particle that slides on face k of an obstacle leaves the face."""
    x, v, a = motion
    time, _, radius = moment
    soonest = NEVER
    for j in range(kind[k, 1], kind[k, 2]):
        if j != k:
            n = place_of(number, j)
            depth = radius - gap_to(kind, number, j, x, time)
            away = dot(axpy(v, -1.0, wall_velocity(number, j)), n)
            soonest = min(soonest, time_to_plane(max(depth, 0.0), -away, -dot(a, n)))
    return soonest


@compiled
def next_event(motion: Motion, moment: Moment, held: Held, kind: Integers, number: Array) -> tuple[float, int]:
    """The next event in the rest of the step: the surface hit, or -2 - k for leaving face k.

    Hits that are simultaneous up to rounding are processed in the order of the surfaces.
    """
    time, left, radius = moment
    soonest, what = left, NOTHING
    for k in range(kind.shape[0]):
        on = k == held[0] or k == held[1] or k == held[2]
        wait = time_to_rim(motion, moment, kind, number, k) if on else time_to_surface(motion, moment, kind, number, k)
        if wait < soonest - 4e-16 * left:
            x, v, a = ballistic(motion[0], motion[1], motion[2], wait), axpy(motion[1], wait, motion[2]), motion[2]
            if on:
                soonest, what = wait, -2 - k
            elif kind[k, 2] == 0 or on_face((x, v, a), (time + wait, 0.0, radius), kind, number, k):
                soonest, what = wait, k
    return soonest, what


@compiled_inside
def supports(held: Held, kind: Integers, number: Array, x: Vector, time: float) -> tuple[Vector, Vector, Vector]:
    """The normals of the surfaces on which a particle rests; zero vectors for missing supports."""
    none = (0.0, 0.0, 0.0)
    first = inward_normal(kind, number, held[0], x, time) if held[0] >= 0 else none
    second = inward_normal(kind, number, held[1], x, time) if held[1] >= 0 else none
    third = inward_normal(kind, number, held[2], x, time) if held[2] >= 0 else none
    return first, second, third


@compiled_inside
def without_support(held: Held, k: int) -> Held:
    """The supports without surface k."""
    return (
        held[0] if held[0] != k else -1,
        held[1] if held[1] != k else -1,
        held[2] if held[2] != k else -1,
    )


@compiled_inside
def with_support(held: Held, k: int) -> Held:
    """The supports consisting of k and the two most recent others."""
    rest = without_support(held, k)
    return k, rest[0] if rest[0] >= 0 else rest[1], rest[2] if rest[0] < 0 else (rest[1] if rest[1] >= 0 else rest[2])


@compiled_inside
def curved_support(held: Held, kind: Integers) -> int:
    """The sphere on which a particle rests, or -1."""
    for k in held:
        if k >= 0 and kind[k, 0] != PLANE:
            return k
    return -1


@compiled_inside
def projected(x: Vector, moment: Moment, kind: Integers, number: Array, k: int) -> Vector:
    """The position projected onto surface k. Hit points are off by rounding, which would otherwise accumulate."""
    time, _, radius = moment
    gap = gap_to(kind, number, k, x, time) - radius
    return axpy(x, -gap, inward_normal(kind, number, k, x, time))


@compiled_inside
def curvature(kind: Integers, number: Array, k: int, radius: float) -> float:
    """The inverse radius of the path of a center along the surface; negative outside a sphere, 0 on a plane."""
    return 0.0 if kind[k, 0] == PLANE else kind[k, 0] / (number[k, SIZE] - kind[k, 0] * radius)


@compiled_inside
def rebound(state: State, moment: Moment, kind: Integers, number: Array, k: int) -> tuple[Vector, Held, bool]:
    """The velocity after a collision with surface k, the supports after it, and whether it counts as a hit.

    In the frame of the wall v_n -> -C_R v_n and v_t -> C_T v_t. A particle that would rebound more slowly than `calm`,
    while an external force presses it onto the surface, stays there and slides without friction.
    """
    x, v, push, calm, held = state
    n = inward_normal(kind, number, k, x, moment[0])
    w = wall_velocity(number, k)
    relative = axpy(v, -1.0, w)
    normal = dot(relative, n)
    along = axpy(relative, -normal, n)
    back, real = -number[k, RESTITUTION] * normal, normal < -calm
    if real:
        along = scaled(number[k, TANGENTIAL], along)
    bend = curvature(kind, number, k, moment[2])
    if back <= calm and bend * dot(along, along) >= dot(push, n):
        held = with_support(held, k)
        on = supports(held, kind, number, x, moment[0])
        if held[2] < 0 <= held[1] and abs(dot(along, on[1])) <= calm and dot(push, on[1]) < 0.0:
            # In a valley rounding would cause endless bounces between its sides.
            edge = cross(on[0], on[1])
            along = scaled(dot(along, edge) / max(dot(edge, edge), 1e-24), edge)
        return axpy(w, 1.0, projected_on_cone(along, on[0], on[1], on[2])), held, real
    # Rounding must not leave a velocity into the wall, which would cause endless collisions at one time.
    return axpy(axpy(w, 1.0, along), max(back, ULPS * length(relative)), n), NO_SUPPORTS, real


@compiled_inside
def calm_speed(v: Vector, push: Vector, span: float, bounce: tuple[float, float]) -> float:
    """The speed below which a particle does not rebound; bounce = (restitution, rounding error of a position).

    Without dissipation only an external force causes small bounces; with dissipation any speed decays. Falling through
    the rounding error of a position also produces a small speed.
    """
    strength = length(push)
    lost = length(v) if bounce[0] < 1.0 else 0.0
    return CALM * (span * strength + lost) + math.sqrt(1e-2 * bounce[1] * strength)


@compiled_inside
def rolled(state: State, moment: Moment, kind: Integers, number: Array, k: int) -> tuple[Vector, Vector, float]:
    """Slide along the curved wall k for part of the step; return position, velocity, and the time used.

    Velocity Verlet on the sphere: half a kick, a great circle, half a kick; exact without a push.
    """
    x, v, push, _, held = state
    time, left, radius = moment
    w = wall_velocity(number, k)
    rho = number[k, SIZE] - kind[k, 0] * radius
    on = supports(held, kind, number, x, time)
    pull = projected_on_cone(push, on[0], on[1], on[2])
    speed, strength = length(axpy(v, -1.0, w)), length(push)
    piece = min(left, ARC * rho / speed) if speed > 0.0 else left
    piece = min(piece, ARC * math.sqrt(rho / strength)) if strength > 0.0 else piece
    half = axpy(axpy(v, -1.0, w), 0.5 * piece, pull)
    pace = length(half)
    if pace == 0.0:
        return axpy(x, left, w), v, left
    out, ahead = scaled(1.0 / rho, from_center(number, k, x, time)), scaled(1.0 / pace, half)
    cosine, sine = math.cos(pace * piece / rho), math.sin(pace * piece / rho)
    new = axpy(scaled(cosine, out), sine, ahead)
    x = axpy(axpy(axpy(x, rho, new), -rho, out), piece, w)
    half = scaled(pace, axpy(scaled(cosine, ahead), -sine, out))
    on = supports(held, kind, number, x, time + piece)
    half = axpy(half, 0.5 * piece, projected_on_cone(push, on[0], on[1], on[2]))
    return x, axpy(w, 1.0, projected_on_cone(half, on[0], on[1], on[2])), piece


@compiled_inside
def record_hit(log: Log, i: int, hit: tuple[int, int, float], place: Vector) -> None:
    """Record a hit: its number among those of the particle, the surface, the time and the position."""
    first, which, when, where = log
    if first.shape[0] > 0:
        spot = first[i] + hit[0]
        which[spot], when[spot] = hit[1], hit[2]
        store(where, spot, place)


@compiled_inside
def clamped_inside(x: Vector, start: Vector, moment: Moment, sheet: tuple[Integers, Array]) -> tuple[Vector, bool]:
    """The final position, corrected if rounding placed it outside the walls; and whether the correction was only of the
    size of rounding.
    """
    kind, number = sheet
    for _ in range(3):
        gap, k = worst_gap(kind, number, x, moment[0])
        gap -= moment[2]
        if k < 0 or gap >= 0.0:
            return x, True
        if gap < -1e3 * (rounding_at(number, k, x) + rounding_at(number, k, start)):
            return projected(x, moment, kind, number, k), False
        x = projected(x, moment, kind, number, k)
    return x, True


@compiled_inside
def advance_to_event(
    motion: Motion, moment: Moment, held: Held, kind: Integers, number: Array
) -> tuple[Vector, Vector, float, int]:
    """Advance to the next event: position and velocity there, the time until it, and the event."""
    x, v, push = motion
    time, _, radius = moment
    curved = curved_support(held, kind)
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
    a = projected_on_cone(push, on[0], on[1], on[2])
    wait, what = next_event((x, v, a), moment, held, kind, number)
    return ballistic(x, v, a, wait), axpy(v, wait, a), wait, what


@compiled_inside
def scaled_between(x: Vector, new: Vector, time: float) -> Vector:
    """The constant velocity that leads from one point to another in the given time."""
    return (new[0] - x[0]) / time, (new[1] - x[1]) / time, (new[2] - x[2]) / time


@compiled_inside
def released(held: Held, motion: Motion, moment: Moment, kind: Integers, number: Array) -> Held:
    """The supports without those that the particle leaves or no longer presses on."""
    x, v, push = motion
    on = supports(held, kind, number, x, moment[0])
    a = projected_on_cone(push, on[0], on[1], on[2])
    for place in range(3):
        k = held[place]
        if k >= 0:
            q = axpy(v, -1.0, wall_velocity(number, k))
            lift = dot(push if kind[k, 0] != PLANE else a, on[place])
            bend = curvature(kind, number, k, moment[2]) * dot(q, q)
            if dot(q, on[place]) > CALM * length(q) or lift - bend > CALM * length(push):
                held = without_support(held, k)
    return held


@compiled_inside
def flight(
    motion: Motion,
    span: tuple[float, float],
    sheet: tuple[Integers, Array, Integers, Array],
    log: Log,
    own: tuple[int, Integers],
) -> tuple[Vector, Vector, int, int]:
    """Move one particle through a step: position, velocity, number of hits, status."""
    x, v, push = motion
    dt, radius = span
    kind, number, hole, part = sheet
    i, per_surface = own
    time, hits, held, quiet = 0.0, 0, NO_SUPPORTS, 0
    for _ in range(MOST_EVENTS):
        moment = (time, dt - time, radius)
        held = released(held, (x, v, push), moment, kind, number)
        x, v, wait, what = advance_to_event((x, v, push), moment, held, kind, number)
        time = dt if wait >= dt - time else time + wait
        if what == NOTHING and time >= dt:
            x, well = clamped_inside(x, motion[0], (dt, 0.0, radius), (kind, number))
            return x, v, hits, STAYED if well else CAPPED
        if what <= -2:
            held = without_support(held, -2 - what)
        elif what >= 0:
            x = projected(x, (time, dt - time, radius), kind, number, what)
            touch = axpy(x, -radius, inward_normal(kind, number, what, x, time))
            through = hole_at(hole, part, number, what, (touch, time))
            if through >= 0:
                return x, v, hits, through + 1
            moment = (time, dt - time, radius)
            bounce = (number[what, RESTITUTION], rounding_at(number, what, x))
            calm = calm_speed(motion[1], push, dt, bounce)
            v, held, real = rebound((x, v, push, calm, held), moment, kind, number, what)
            if real:
                record_hit(log, i, (hits, what, time), x)
                per_surface[what] += 1
                hits += 1
            wall = wall_velocity(number, what)
            quiet = quiet + 1 if length(axpy(v, -1.0, wall)) <= calm else 0
            if quiet > SETTLED:
                x, well = clamped_inside(axpy(x, dt - time, wall), motion[0], (dt, 0.0, radius), (kind, number))
                return x, wall, hits, STAYED if well else CAPPED
    return x, v, hits, CAPPED


@compiled
def move_range(
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
    status: Integers,
    per_surface: Integers,
) -> None:
    """Move particles `start` to `stop` through one step, in place."""
    for i in range(start, stop):
        if status[i] != STAYED:
            continue
        push = load(acceleration, i if acceleration.shape[0] > 1 else 0)
        motion = (load(position, i), load(velocity, i), push)
        own_radius = radius[i if radius.shape[0] > 1 else 0]
        if undisturbed(motion, (0.0, dt, own_radius), kind, number):
            store(position, i, ballistic(motion[0], motion[1], push, dt))
            store(velocity, i, axpy(motion[1], dt, push))
            continue
        gap, k = worst_gap(kind, number, motion[0], 0.0)
        if not gap - own_radius >= -rounding_at(number, k, motion[0]):
            status[i] = STARTED_OUTSIDE
            continue
        x, v, hits[i], status[i] = flight(motion, (dt, own_radius), (kind, number, hole, part), log, (i, per_surface))
        store(position, i, x)
        store(velocity, i, v)


@threaded
def move_all(
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
    status: Integers,
    per_surface: Integers,
) -> None:
    """Move all particles through one step, in chunks with threads. The arguments of `move_range` are repeated as single
    arrays, because in a threaded loop Numba writes to copies of arrays in tuples.
    """
    count, surfaces = position.shape[0], kind.shape[0]
    chunks = (count + CHUNK - 1) // CHUNK
    counted = np.zeros((chunks, surfaces), np.int64)
    for chunk in prange(chunks):
        mine = np.zeros(surfaces, np.int64)
        move_range(
            chunk * CHUNK, min(count, (chunk + 1) * CHUNK), position, velocity, acceleration, radius, dt,
            kind, number, hole, part, (first, which, when, where), hits, status, mine,
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
    """Move all particles through one step of `dt` seconds, in place; for compiled code and Python.

    position, velocity: (N, 2) or (N, 3), C-contiguous; acceleration: (N, d), or (1, d) for all; radius: (N,) or (1,).
    sheet: `sheet(walls, restitution, tangential)`. tally: hits (N,) is written; status (N,) is written for particles
    with status 0 (others do not move): 0 stayed, m + 1 left through opening m, -1 more events than MOST_EVENTS, -2
    started outside and was not moved; hits per surface (K,) are added. Returns the number of particles with a negative
    status.
    """
    hits, status, per_surface = tally
    kind, number, hole, part = sheet.kind, sheet.number, sheet.hole, sheet.part
    nothing, nowhen, nowhere = np.zeros(0, np.int64), np.zeros(0), np.zeros((0, position.shape[1]))
    hits[:] = 0
    if position.shape[0] < FEW:
        move_range(
            0, position.shape[0], position, velocity, acceleration, radius, dt,
            kind, number, hole, part, (nothing, nothing, nowhen, nowhere), hits, status, per_surface,
        )  # fmt: skip
    else:
        move_all(
            position, velocity, acceleration, radius, dt,
            kind, number, hole, part, nothing, nothing, nowhen, nowhere, hits, status, per_surface,
        )  # fmt: skip
    troubled = 0
    for i in range(status.shape[0]):
        troubled += status[i] < 0
    return troubled
