"""Collisions of Brownian floats within a step: event-driven Brownian dynamics [scala2007; scala2013].

In a step each float moves along a straight line, by the sum of its displacements by forces and by noise. Where two
paths meet, their relative velocity along the normal is reflected, as in elastic collisions of masses that are inversely
proportional to the mobilities. Such billiards conserve the volume of configurations and the distribution of the noise:
without forces every allowed configuration stays equally likely, for any number of floats and any time step. With forces
the gap after a collision is that of a reflected Brownian motion with drift: see `brownian_motion.reflected_gap`. The
density at contact then converges with the first order in the time step, as in schemes that reflect at one wall
[bossy2004], mean gaps with the second.

Forces that press floats together bring them back to contact within a step. Where they are strong, the step therefore
has several intervals, in each of which the paths are straight. The noises of the intervals add up to that of the step,
so that floats without collisions move as without intervals. Floats that are pressed so strongly that they would need
more than `MOST_INTERVALS` are in lasting contact. Lasting contacts, and all floats that collide with them in the same
step, are solved together as impulses, with the gaps of `reflected_gain` for each pair. For simultaneous contacts the
distribution of these gaps is not that of equilibrium: for three mutually bound floats, gaps far below kT over the force
are a quarter too frequent.

Floats that interact through the liquid: a collision moves the two floats with the mobilities of the pair, or the one
at a wall, and the flow moves all others that could touch something in this step, before they collide. Only then are
collisions elastic for all floats together, with the mobility matrix in place of masses. Of more than `MOST_CARRIED`
floats, the flow moves at once only those within `CARRIED_WITHIN` radii of the colliding ones. The mean forces of all
collisions then move the other floats; new contacts among these are solved as impulses at the end of the step.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import admit, compiled
from ecume.engine.cells import Integers
from ecume.engine.contact import contacts as touching
from ecume.engine.contact.contacts import Contacts
from ecume.engine.contact.event_queue import EventQueue, make_event_queue, schedule
from ecume.engine.philox import counter_of, counter_of_pair, normals, uniforms
from ecume.engine.walls import is_circle
from ecume.engine.walls.rings import is_inner, wall_distance
from ecume.laws import brownian_motion, pair_mobility
from ecume.laws.brownian_motion import reflected_gain, reflected_gap
from ecume.laws.pair_mobility import rotne_prager
from ecume.models.floating.parameters import Parameters, State
from ecume.units import Array

admit(brownian_motion, pair_mobility)

MOST_HITS = 12
"""Collisions of a float in one step; with more it is in lasting contact."""

MOST_CARRIED = 1000
"""The largest number of floats of which each collision moves all, by the flow of its force, before others collide."""

CARRIED_WITHIN = 20.0
"""The distance, over the largest radius, up to which a collision moves others of more floats at once. Its two forces
are opposite, and their flow decays with the square of the distance.
"""

LASTING = 1.0
"""Approach by forces in one interval, over the standard deviation of that by noise, above which a contact lasts."""

SOFTLY = 0.35
"""The target of this ratio in the intervals of a step, unless that requires too many of them."""

SIDEWAYS = 3.0
"""The largest displacement along a lasting contact, over the standard deviation of that by noise, that may add to its
gap: forces that press a float between others push it far along its contacts, which stop it.
"""

MOST_INTERVALS = 8
"""The largest number of intervals of a step."""

INTERVALS = 16
"""The first purpose of random numbers of the noise of intervals."""


class Interval(NamedTuple):
    """A part of a step in which paths are straight between collisions."""

    length: float
    """s"""
    end: float
    """s: its end, since the beginning of the step"""


class Paths(NamedTuple):
    """Straight paths of floats since their last collision in this step."""

    since: Array
    """(N,) s: the time of this collision in the step"""
    moved: Array
    """(N, 2) m: the displacement until then"""
    velocity: Array
    """(N, 2) m/s: the velocity from then on"""
    hits: Integers
    """(N,) collisions in this interval"""
    lasting: Integers
    """(N,) 1 for floats in lasting contact"""


class Flow(NamedTuple):
    """The hydrodynamic coupling of floats."""

    radius: Array
    """(N,) m: see `CoupledKicks`; (0,) if they do not"""
    unit: float
    """1/(3 pi viscosity)"""


class Bounces(NamedTuple):
    """The result of all collisions of a step."""

    impulse: Array
    """(N, 2) N: the mean force of collisions on each float; (0, 2) if no floats collide"""
    lasting: Integers
    """(N,) 1 for floats in lasting contact"""


@compiled
def collide_on_paths(
    parameters: Parameters, state: State, contacts: Contacts, motion: tuple[Array, Array], share: Array, flow: Flow
) -> Bounces:
    """Compute the collisions of floats on their paths of this step. `motion`: (N, 2) velocities with and without noise
    (m/s); `share`: (rows, 2) the velocities of both floats of a contact by opposite unit forces along its normal (m/(N
    s)).
    """
    count = len(parameters.floats.radius)
    number = intervals_of(parameters, contacts, motion[1], share) if len(flow.radius) == 0 else 1
    noise = noise_of_intervals(parameters, state, contacts, number)
    paths, meetings, collided = paths_of(count), meetings_of(contacts, count), False
    for k in range(number):
        interval = Interval(parameters.time_step / number, parameters.time_step * (k + 1) / number)
        begin_interval(paths, interval, motion[0], noise[k])
        given = motion[1], share
        if collide_in_interval(parameters, state, contacts, paths, interval, meetings, given, flow):
            collided = True
    if not collided:
        return Bounces(np.zeros((0, 2)), paths.lasting)
    spread_lasting(contacts, meetings.met, paths.lasting)
    for i in range(count):
        if paths.lasting[i] > 0:
            meetings.impulse[i, 0], meetings.impulse[i, 1] = 0.0, 0.0
    return Bounces(meetings.impulse, paths.lasting)


@compiled
def paths_of(count: int) -> Paths:
    """Return the paths of floats at the beginning of a step."""
    none, lasting = np.zeros(count, np.int64), np.zeros(count, np.int64)
    return Paths(np.zeros(count), np.zeros((count, 2)), np.zeros((count, 2)), none, lasting)


@compiled
def begin_interval(paths: Paths, interval: Interval, velocity: Array, noise: Array) -> None:
    """Move all floats to the beginning of an interval; their velocity is then the velocity of the step plus the noise
    of the interval.
    """
    for i in range(len(paths.since)):
        advance_path(paths, i, interval.end - interval.length)
        paths.hits[i] = 0
        for axis in range(2):
            paths.velocity[i, axis] = velocity[i, axis] + (noise[i, axis] if len(noise) > 0 else 0.0)


class Meetings(NamedTuple):
    """Workspace of the collisions of a step."""

    queue: EventQueue
    first: Integers
    rows: Integers
    """see `contacts_of_floats`"""
    changed: Integers
    """(N,) the floats that a collision moves"""
    last: Integers
    """(N,) the last collision that moved each float"""
    met: Integers
    """(rows,) 1 for contacts that collided in this step"""
    impulse: Array
    """(N, 2) N: the mean force of collisions in this step"""


@compiled
def meetings_of(contacts: Contacts, count: int) -> Meetings:
    """Return a workspace for the contacts of a step."""
    total, (first, rows) = contacts.total[0], contacts_of_floats(contacts, count)
    changed, last, met = np.empty(count, np.int64), np.zeros(count, np.int64), np.zeros(total, np.int64)
    return Meetings(make_event_queue(total), first, rows, changed, last, met, np.zeros((count, 2)))


@compiled
def intervals_of(parameters: Parameters, contacts: Contacts, driven: Array, share: Array) -> int:
    """The number of intervals of a step, from the largest force that does not yet press two bodies into lasting
    contact.
    """
    strongest, time, count = 0.0, parameters.time_step, len(parameters.floats.radius)
    for row in range(contacts.total[0]):
        if contacts.bound[row] > -np.inf:
            spread = 2.0 * parameters.drift.thermal * (share[row, 0] + share[row, 1]) * time
            pressed = approach_by_forces(contacts, row, driven, count) * time / math.sqrt(spread)
            if pressed <= LASTING * math.sqrt(MOST_INTERVALS):
                strongest = max(strongest, pressed)
    return max(1, min(MOST_INTERVALS, math.ceil((strongest / SOFTLY) ** 2)))


@compiled
def noise_of_intervals(parameters: Parameters, state: State, contacts: Contacts, number: int) -> Array:
    """The noise velocities in each interval minus that of the step (m/s): normal numbers with the variance of an
    interval, minus their mean, so that the mean velocity of the step is unchanged. Zero for floats without contacts.
    """
    count = len(parameters.floats.radius) if number > 1 else 0
    noise, touching_one, step = np.zeros((number, count, 2)), np.zeros(count, np.int64), int(state.step[0])
    for row in range(contacts.total[0] if number > 1 else 0):
        touching_one[contacts.first[row]] = 1
        if contacts.second[row] < count:
            touching_one[contacts.second[row]] = 1
    for i in range(count):
        if touching_one[i] > 0:
            far = math.sqrt(2.0 * parameters.drift.thermal * parameters.kick.gain[i] * number / parameters.time_step)
            mean_x, mean_y = 0.0, 0.0
            for k in range(number):
                x, y = normals(counter_of(i, step, INTERVALS + k), parameters.drift.seed)
                noise[k, i, 0], noise[k, i, 1] = far * x, far * y
                mean_x, mean_y = mean_x + far * x / number, mean_y + far * y / number
            for k in range(number):
                noise[k, i, 0] -= mean_x
                noise[k, i, 1] -= mean_y
    return noise


@compiled
def collide_in_interval(
    parameters: Parameters,
    state: State,
    contacts: Contacts,
    paths: Paths,
    interval: Interval,
    meetings: Meetings,
    given: tuple[Array, Array],
    flow: Flow,
) -> bool:
    """Compute the collisions until the end of an interval. Returns whether any occurred."""
    queue, count, (driven, share) = meetings.queue, len(parameters.floats.radius), given
    number, around = 0, (meetings.first, meetings.rows)
    for i in range(count):
        meetings.last[i] = 0
    for row in range(contacts.total[0]):
        # Two discs stay apart if they do not cross the plane between them.
        if contacts.bound[row] > -np.inf and (contacts.second[row] >= count or crosses(contacts, paths, row, interval)):
            schedule(queue, row, meeting_time(parameters, state, contacts, paths, row, interval.end))
    while queue.size[0] > 0:
        row = queue.heap[0]
        when = queue.time[row]
        meetings.met[row], number = 1, number + 1
        moved = meetings.changed, meetings.last
        changes = bodies_of(contacts, row, moved, number)
        if len(flow.radius) > 0:
            reach = np.inf if len(flow.radius) <= MOST_CARRIED else CARRIED_WITHIN * flow.radius.max()
            changes = add_bodies_within(reach, state.position, contacts, row, around, moved, number, changes)
        if lasts(parameters, contacts, paths, row, given, interval.length):
            for place in range(2 if contacts.second[row] < count else 1):
                paths.lasting[meetings.changed[place]] = 1
        else:
            event = row, when, interval
            force = reflect_pair(parameters, state, contacts, paths, event, (driven, share, meetings.impulse))
            if len(flow.radius) > 0:
                others = meetings.changed[2 if contacts.second[row] < count else 1 : changes]
                carry(flow, state.position, contacts, paths, row, when, force, others)
        for spot in range(changes):
            for place in range(meetings.first[meetings.changed[spot]], meetings.first[meetings.changed[spot] + 1]):
                other = meetings.rows[place]
                schedule(queue, other, meeting_time(parameters, state, contacts, paths, other, interval.end))
    return number > 0


@compiled
def crosses(contacts: Contacts, paths: Paths, row: int, interval: Interval) -> bool:
    """Whether two floats together move along their normal by more than their gap until the end of an interval."""
    i, j, gap, time = contacts.first[row], contacts.second[row], contacts.gap[row], interval.length
    for axis in range(2):
        moved = paths.moved[j, axis] - paths.moved[i, axis]
        gap += contacts.normal[row, axis] * (moved + time * (paths.velocity[j, axis] - paths.velocity[i, axis]))
    return bool(gap < 0.0)


@compiled
def bodies_of(contacts: Contacts, row: int, found: tuple[Integers, Integers], meetings: int) -> int:
    """List the two floats of a contact, or the one at a wall. Returns their number. `found` contains the list, and for
    each float the last collision that listed it.
    """
    (changed, last), i, j = found, contacts.first[row], contacts.second[row]
    changed[0], last[i] = i, meetings
    if j >= len(changed):
        return 1
    changed[1], last[j] = j, meetings
    return 2


@compiled
def add_bodies_within(
    reach: float,
    position: Array,
    contacts: Contacts,
    row: int,
    around: tuple[Integers, Integers],
    found: tuple[Integers, Integers],
    meetings: int,
    total: int,
) -> int:
    """Add all floats that have a contact and whose centers are within `reach` of those of this one to the list of
    `bodies_of`. Returns their number.
    """
    (changed, last), first, count = found, around[0], len(found[0])
    for other in range(count):
        if last[other] == meetings or first[other + 1] == first[other]:
            continue
        for one in (contacts.first[row], contacts.second[row]):
            if one < count and last[other] != meetings:
                x, y = position[other, 0] - position[one, 0], position[other, 1] - position[one, 1]
                if x * x + y * y < reach * reach:
                    changed[total], last[other] = other, meetings
                    total += 1
    return total


@compiled
def carry(
    flow: Flow,
    position: Array,
    contacts: Contacts,
    paths: Paths,
    row: int,
    when: float,
    force: tuple[float, float],
    others: Integers,
) -> None:
    """Change the velocities of other floats by the flow that the force of a collision causes; the force acts on the
    second body, and with opposite sign on the first. A force on a wall moves no liquid.
    """
    for k in others:
        advance_path(paths, k, when)
        for one, sign in ((contacts.first[row], -1.0), (contacts.second[row], 1.0)):
            if one >= len(flow.radius):
                continue
            x, y = position[k, 0] - position[one, 0], position[k, 1] - position[one, 1]
            distance = math.sqrt(x * x + y * y)
            across, along = rotne_prager(distance, flow.radius[one], flow.radius[k])
            x, y = x / distance, y / distance
            normal_force = x * force[0] + y * force[1]
            for axis, towards in ((0, x), (1, y)):
                moved = across * force[axis] + (along - across) * normal_force * towards
                paths.velocity[k, axis] += sign * flow.unit * moved


@compiled
def contacts_of_floats(contacts: Contacts, count: int) -> tuple[Integers, Integers]:
    """The contacts of each float: those of float i are rows[first[i]:first[i + 1]]."""
    total, one, other = contacts.total[0], contacts.first, contacts.second
    first, rows = np.zeros(count + 2, np.int64), np.empty(2 * total, np.int64)
    for row in range(total):
        first[one[row] + 2] += 1
        if other[row] < count:
            first[other[row] + 2] += 1
    for i in range(count):
        first[i + 2] += first[i + 1]
    for row in range(total):
        rows[first[one[row] + 1]] = row
        first[one[row] + 1] += 1
        if other[row] < count:
            rows[first[other[row] + 1]] = row
            first[other[row] + 1] += 1
    return first[: count + 1], rows


@compiled
def meeting_time(parameters: Parameters, state: State, contacts: Contacts, paths: Paths, row: int, end: float) -> float:
    """The time (s) at which the two bodies of a contact meet on their paths; infinite if that is after `end`, or for a
    lasting contact.
    """
    i, j, radius = contacts.first[row], contacts.second[row], parameters.floats.radius
    if paths.lasting[i] > 0 or contacts.bound[row] == -np.inf:
        return math.inf
    if j >= len(radius):
        when = time_of_wall(parameters, state, paths, i, j - len(radius))
    elif paths.lasting[j] > 0:
        return math.inf
    else:
        begin = max(paths.since[i], paths.since[j])
        x, y = pair_at(contacts, paths, row, radius[i] + radius[j], begin)
        u, v = paths.velocity[j, 0] - paths.velocity[i, 0], paths.velocity[j, 1] - paths.velocity[i, 1]
        closing, beyond = x * u + y * v, x * x + y * y - (radius[i] + radius[j]) ** 2
        when = begin + first_root(closing, beyond, u * u + v * v)
    return when if when < end else math.inf


@compiled
def first_root(half: float, last: float, square: float) -> float:
    """The smallest positive root t of square t^2 + 2 half t + last at which the polynomial decreases; zero if `last` is
    negative.
    """
    if half >= 0.0:
        return math.inf
    if last <= 0.0:
        return 0.0
    root = half * half - square * last
    return last / (math.sqrt(root) - half) if root > 0.0 else math.inf


@compiled
def time_of_wall(parameters: Parameters, state: State, paths: Paths, i: int, number: int) -> float:
    """The time at which a float meets a wall on its path (s)."""
    walls, u, v = parameters.walls, paths.velocity[i, 0], paths.velocity[i, 1]
    x, y = state.position[i, 0] + paths.moved[i, 0], state.position[i, 1] + paths.moved[i, 1]
    if is_circle(walls, number):
        outward, room = x * u + y * v, (walls.disc_radius - parameters.floats.radius[i]) ** 2 - x * x - y * y
        square = u * u + v * v
        if square == 0.0 or (room < 0.0 and outward <= 0.0):
            return math.inf
        ahead = (math.sqrt(max(outward * outward + square * room, 0.0)) - outward) / square
        return float(paths.since[i] + max(ahead, 0.0))
    if is_inner(walls, number):
        touch = walls.offset[-1] + parameters.floats.radius[i]
        return float(paths.since[i] + first_root(x * u + y * v, x * x + y * y - touch**2, u * u + v * v))
    distance, in_x, in_y = wall_distance(walls, number, x, y)
    closing = -(u * in_x + v * in_y)
    return (
        float(paths.since[i] + max(distance - parameters.floats.radius[i], 0.0) / closing)
        if closing > 0.0
        else math.inf
    )


@compiled
def pair_at(contacts: Contacts, paths: Paths, row: int, touch: float, when: float) -> tuple[float, float]:
    """The vector between the centers of two floats at the time `when` of the step (m)."""
    i, j, apart = contacts.first[row], contacts.second[row], touch + contacts.gap[row]
    since_i, since_j, moved, velocity = when - paths.since[i], when - paths.since[j], paths.moved, paths.velocity
    x = apart * contacts.normal[row, 0] + moved[j, 0] + since_j * velocity[j, 0]
    y = apart * contacts.normal[row, 1] + moved[j, 1] + since_j * velocity[j, 1]
    return x - moved[i, 0] - since_i * velocity[i, 0], y - moved[i, 1] - since_i * velocity[i, 1]


@compiled
def lasts(
    parameters: Parameters, contacts: Contacts, paths: Paths, row: int, given: tuple[Array, Array], time: float
) -> bool:
    """Whether forces press two bodies together for longer than noise can separate them in this time."""
    i, j, count = contacts.first[row], contacts.second[row], len(parameters.floats.radius)
    driven, share = given
    approach, mobility = approach_by_forces(contacts, row, driven, count), share[row, 0] + share[row, 1]
    most = max(paths.hits[i], paths.hits[j] if j < count else 0)
    return bool(
        most >= MOST_HITS or approach * time > LASTING * math.sqrt(2.0 * parameters.drift.thermal * mobility * time)
    )


@compiled
def approach_by_forces(contacts: Contacts, row: int, driven: Array, count: int) -> float:
    """The speed at which forces bring two bodies together (m/s)."""
    i, j, x, y = contacts.first[row], contacts.second[row], contacts.normal[row, 0], contacts.normal[row, 1]
    speed = x * driven[i, 0] + y * driven[i, 1]
    if j < count:
        speed -= x * driven[j, 0] + y * driven[j, 1]
    return float(speed)


@compiled
def reflect_pair(
    parameters: Parameters,
    state: State,
    contacts: Contacts,
    paths: Paths,
    event: tuple[int, float, Interval],
    given: tuple[Array, Array, Array],
) -> tuple[float, float]:
    """Reflect the velocities of two bodies; `event` consists of a contact, the time and its interval. Returns the force
    on the second body until the end of the interval (N).
    """
    (row, when, interval), (driven, share, impulse), radius = event, given, parameters.floats.radius
    i, j, time, thermal = contacts.first[row], contacts.second[row], interval.length, parameters.drift.thermal
    advance_path(paths, i, when)
    velocity, left, count = paths.velocity, interval.end - when, len(radius)
    if j < count:
        advance_path(paths, j, when)
        x, y = pair_at(contacts, paths, row, radius[i] + radius[j], when)
        apart = math.sqrt(x * x + y * y)
        x, y = x / apart, y / apart
        speed = x * (velocity[j, 0] - velocity[i, 0]) + y * (velocity[j, 1] - velocity[i, 1])
        forced = x * (driven[j, 0] - driven[i, 0]) + y * (driven[j, 1] - driven[i, 1])
    else:
        place_x, place_y = state.position[i, 0] + paths.moved[i, 0], state.position[i, 1] + paths.moved[i, 1]
        _, in_x, in_y = wall_distance(parameters.walls, j - count, place_x, place_y)
        x, y = -in_x, -in_y
        speed, forced = -x * velocity[i, 0] - y * velocity[i, 1], -x * driven[i, 0] - y * driven[i, 1]
    mobility = share[row, 0] + share[row, 1]
    turn = round(interval.end / time)
    draw = uniforms(counter_of_pair(int(i), int(j), int(state.step[0]), turn), parameters.drift.seed)[0]
    variance = 2.0 * thermal * mobility * time
    end = reflected_gap(-speed * left, (forced - speed) * time, forced * time, variance, draw)
    force = (end / left - speed) / mobility
    for axis, along in ((0, x), (1, y)):
        velocity[i, axis] -= share[row, 0] * force * along
        impulse[i, axis] -= force * along * left / parameters.time_step
        if j < count:
            velocity[j, axis] += share[row, 1] * force * along
            impulse[j, axis] += force * along * left / parameters.time_step
    paths.hits[i] += 1
    if j < count:
        paths.hits[j] += 1
    return force * x, force * y


@compiled
def advance_path(paths: Paths, i: int, when: float) -> None:
    """Move a float along its path to this time of the step."""
    for axis in range(2):
        paths.moved[i, axis] += (when - paths.since[i]) * paths.velocity[i, axis]
    paths.since[i] = when


@compiled
def spread_lasting(contacts: Contacts, met: Integers, lasting: Integers) -> None:
    """Mark all floats that are connected to lasting contacts by collisions in this step."""
    spreads = lasting.max() > 0
    while spreads:
        spreads = False
        for row in range(contacts.total[0]):
            i, j = contacts.first[row], contacts.second[row]
            if met[row] > 0 and j < len(lasting) and lasting[i] != lasting[j]:
                lasting[i], lasting[j], spreads = 1, 1, True


@compiled
def require_distances(
    parameters: Parameters, state: State, contacts: Contacts, velocity: Array, share: Array, lasting: Integers
) -> None:
    """Set the bounds of the relative velocities of all contacts, from the velocities after the collisions. In lasting
    contacts they lead to the gaps of reflected motions; in others, the floats do not overlap at the end.
    """
    time, radius, count = parameters.time_step, parameters.floats.radius, len(parameters.floats.radius)
    touching.normal_velocities(contacts, velocity, contacts.scratch)
    for row in range(contacts.total[0]):
        i, j, gap = contacts.first[row], contacts.second[row], max(contacts.gap[row], 0.0)
        if contacts.bound[row] == -np.inf:
            continue
        pressed = lasting[i] > 0 or (j < count and lasting[j] > 0)
        variance = 2.0 * parameters.drift.thermal * (share[row, 0] + share[row, 1]) * time
        after, ahead, across = free_gap(parameters, state, contacts, row, velocity)
        moved = time * contacts.scratch[row]
        if pressed and j < count:
            across = min(abs(across), SIDEWAYS * math.sqrt(variance))
            after = (math.hypot(ahead, across) if ahead > 0.0 else ahead) - radius[i] - radius[j]
        # Beyond this, paths meet with a probability below exp(-40).
        if pressed and (after <= 0.0 or gap * after < 20.0 * variance):
            draw = uniforms(counter_of_pair(int(i), int(j), int(state.step[0]), 0), parameters.drift.seed)[0]
            end = reflected_gain(after - gap, variance, -math.log(draw))
        elif after < 0.0:
            end = -after
        else:
            contacts.bound[row] = min(contacts.bound[row], contacts.scratch[row])
            continue
        if j < count:
            # The displacement along the normal that leads to this gap, given the tangential displacement.
            target = end + ahead - moved - contacts.gap[row]
            contacts.bound[row] = (math.sqrt(max(target**2 - across**2, 0.0)) - ahead + moved) / time
        else:
            contacts.bound[row] = (moved + end - after) / time


@compiled
def free_gap(
    parameters: Parameters, state: State, contacts: Contacts, row: int, velocity: Array
) -> tuple[float, float, float]:
    """The gap that a contact would have at the end of the step without contact forces, and the final vector between the
    centers of two floats: its components along and across the normal (m), zero at walls.
    """
    i, j, time, radius = contacts.first[row], contacts.second[row], parameters.time_step, parameters.floats.radius
    if j >= len(radius):
        x, y = state.position[i, 0] + time * velocity[i, 0], state.position[i, 1] + time * velocity[i, 1]
        return wall_distance(parameters.walls, j - len(radius), x, y)[0] - radius[i], 0.0, 0.0
    x, y = contacts.normal[row, 0], contacts.normal[row, 1]
    across = time * (x * (velocity[j, 1] - velocity[i, 1]) - y * (velocity[j, 0] - velocity[i, 0]))
    touch = radius[i] + radius[j]
    ahead = touch + contacts.gap[row] + time * contacts.scratch[row]
    return math.sqrt(ahead**2 + across**2) - touch, ahead, across
