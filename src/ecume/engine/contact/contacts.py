"""Contacts between discs and with walls: detection, effective masses, the passes of the solver over them, position
projection, and the warm start.

`ecume.engine.contact.impulse_solvers` solves for the impulses.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume.engine.cells import Integers, nearest
from ecume.engine.contact.active_set import numbered
from ecume.engine.contact.islands import Choice, Islands, islands_among
from ecume.engine.walls import Walls, wall_count
from ecume.engine.walls.rings import wall_distance
from ecume.units import Array

MOST_ROUNDS = 20_000


class Bodies(NamedTuple):
    """The bodies of the solver: discs, and the walls around them."""

    radius: Array
    walls: Walls
    mobility: Array
    """(N + walls,) velocity per impulse: the inverse mass, reduced by drag during the step; zero for fixed bodies"""
    periods: Array
    """(2, 2): see `ecume.engine.cells`"""
    passing: bool = False
    """whether discs pass through one another; walls stop them all the same"""


class Candidates(NamedTuple):
    """Pairs (i < j) that may touch while the neighbor lists are valid, ordered by i, then j."""

    first: Integers
    """(N + 1,)"""
    partner: Integers
    """(capacity,) the j of the pairs of i: partner[first[i]:first[i + 1]]"""


class Contacts(NamedTuple):
    """Contacts of one time step. Wall number k is partner N + k."""

    total: Integers
    """(1,) number of contacts"""
    first: Integers
    """(capacity,) i"""
    second: Integers
    """(capacity,) j, or N + wall"""
    normal: Array
    """(capacity, 2) from i to j, or from i into the wall"""
    gap: Array
    bound: Array
    """lower bound of the relative normal velocity n.(w_j - w_i)"""
    weight: Array
    """effective mass: impulse per relative velocity"""
    impulse: Array
    change: Array
    """of the impulses in the last sweep"""
    direction: Array
    """search direction of the conjugate gradient"""
    scratch: Array


class DiscMotion(NamedTuple):
    """The motion of discs, and of the walls behind them."""

    velocity: Array
    """(N + walls, 2)"""
    mobility: Array
    """(N + walls,) velocity per impulse"""


def make_candidates(count: int, capacity: int) -> Candidates:
    """Empty arrays for `capacity` pairs."""
    return Candidates(np.zeros(count + 1, np.int64), np.zeros(max(capacity, 16), np.int64))


@compiled
def make_contacts(capacity: int) -> Contacts:
    """Empty arrays for `capacity` contacts."""
    return Contacts(
        np.zeros(1, np.int64), np.zeros(capacity, np.int64), np.zeros(capacity, np.int64), np.zeros((capacity, 2)),
        np.zeros(capacity), np.zeros(capacity), np.zeros(capacity), np.zeros(capacity), np.zeros(capacity),
        np.zeros(capacity), np.zeros(capacity),
    )  # fmt: skip


@compiled_inside
def apart(position: Array, i: int, j: int, periods: Array) -> tuple[float, float]:
    """The vector from the center of disc i to that of the nearest image of disc j."""
    x = nearest(position[j, 0] - position[i, 0], periods[0, 0], periods[1, 0])
    return x, nearest(position[j, 1] - position[i, 1], periods[0, 1], periods[1, 1])


@compiled_inside
def pair_gap(apart_x: float, apart_y: float, touching: float) -> tuple[float, float, float]:
    """The gap of two discs whose centers are displaced by (apart_x, apart_y), and the unit vector between them.

    Coincident centers have no direction; the x axis is used, so that the overlap can be resolved.
    """
    distance = math.sqrt(apart_x * apart_x + apart_y * apart_y)
    if distance == 0.0:
        return -touching, 1.0, 0.0
    return distance - touching, apart_x / distance, apart_y / distance


@compiled
def gather(contacts: Contacts, candidates: Candidates, position: Array, bodies: Bodies, reach: float) -> bool:
    """Find all contacts with a gap below `reach`, ordered by i, then j, walls last. Returns False if the capacity is
    too small.
    """
    radius, walls, starts, partner = bodies.radius, bodies.walls, candidates.first, candidates.partner
    first, second, normal, gaps = contacts.first, contacts.second, contacts.normal, contacts.gap
    count, walls_here, found, periods = position.shape[0], wall_count(walls), 0, bodies.periods
    for i in range(count):
        x, y = position[i, 0], position[i, 1]
        pairs = 0 if bodies.passing else starts[i + 1] - starts[i]
        for place in range(pairs + walls_here):
            if place < pairs:
                j = partner[starts[i] + place]
                along, across = apart(position, i, j, periods)
                gap, to_x, to_y = pair_gap(along, across, radius[i] + radius[j])
            else:
                j = count + place - pairs
                distance, in_x, in_y = wall_distance(walls, place - pairs, x, y)
                gap, to_x, to_y = distance - radius[i], -in_x, -in_y
            if gap < reach:
                if found == len(first):
                    return False
                first[found], second[found], gaps[found] = i, j, gap
                normal[found, 0], normal[found, 1] = to_x, to_y
                found += 1
    contacts.total[0] = found
    return True


@compiled
def set_effective_masses(contacts: Contacts, mobility: Array) -> None:
    """Set the effective mass of each contact, 1/(w_i + w_j); zero between fixed bodies."""
    for row in range(contacts.total[0]):
        inverse = mobility[contacts.first[row]] + mobility[contacts.second[row]]
        contacts.weight[row] = 1.0 / inverse if inverse > 0.0 else 0.0


@compiled
def deepest_overlap(total: Integers, gap: Array) -> float:
    """The deepest overlap of `total[0]` contacts (m); zero without overlaps."""
    deepest = 0.0
    for row in range(total[0]):
        deepest = max(deepest, -gap[row])
    return deepest


@compiled
def contact_keys(contacts: Contacts) -> ContactKeys:
    """The bodies of each contact, as keys of the warm start."""
    return ContactKeys(contacts.total, contacts.first, contacts.second, contacts.impulse)


# In the loops below every array has a local name, and none is passed to another function: Numba counts references
# each time an array is passed or taken from a tuple, which makes such loops five to nine times slower. Indexes are
# unsigned because signed ones are tested for being negative.


@compiled
def normal_velocities(contacts: Contacts, velocity: Array, speed: Array) -> None:
    """Relative normal velocity n.(w_j - w_i) of each contact; negative for approach."""
    first, second, normal = contacts.first, contacts.second, contacts.normal
    for row in range(contacts.total[0]):
        i, j = np.uint64(first[row]), np.uint64(second[row])
        along_x = normal[row, 0] * (velocity[j, 0] - velocity[i, 0])
        speed[row] = along_x + normal[row, 1] * (velocity[j, 1] - velocity[i, 1])


@compiled
def apply_impulses(contacts: Contacts, impulse: Array, velocity: Array, mobility: Array) -> None:
    """Apply each contact's impulse to both bodies, equal and opposite, along the normal."""
    first, second, normal = contacts.first, contacts.second, contacts.normal
    for row in range(contacts.total[0]):
        i, j = np.uint64(first[row]), np.uint64(second[row])
        on_i, on_j = mobility[i] * impulse[row], mobility[j] * impulse[row]
        velocity[i, 0] -= on_i * normal[row, 0]
        velocity[i, 1] -= on_i * normal[row, 1]
        velocity[j, 0] += on_j * normal[row, 0]
        velocity[j, 1] += on_j * normal[row, 1]


@compiled
def start(contacts: Contacts, motion: DiscMotion) -> int:
    """Change the velocities by the initial impulses; return the number of contacts."""
    apply_impulses(contacts, contacts.impulse, motion.velocity, motion.mobility)
    return int(contacts.total[0])


@compiled_inside
def span_of(some: Integers) -> tuple[Any, Any]:
    """The first of some successive contacts, and one after the last: discs have no others (see `packed`)."""
    begin = some[0] if len(some) > 0 else 0
    return np.uint64(begin), np.uint64(begin + len(some))


@compiled_inside
def sweep(contacts: Contacts, motion: DiscMotion, some: Integers, relaxation: float) -> float:
    """Perform one projected Gauss-Seidel sweep over some contacts. Returns the largest change, as a
    relative velocity.
    """
    begin, end = span_of(some)
    first, second, normal = contacts.first, contacts.second, contacts.normal
    impulse, bound, weight, change = contacts.impulse, contacts.bound, contacts.weight, contacts.change
    velocity, mobility = motion
    largest = 0.0
    for row in range(begin, end):
        i, j = np.uint64(first[row]), np.uint64(second[row])
        x, y = normal[row, 0], normal[row, 1]
        speed = x * (velocity[j, 0] - velocity[i, 0]) + y * (velocity[j, 1] - velocity[i, 1])
        new = max(impulse[row] + weight[row] * (bound[row] - speed), 0.0)
        step = new - impulse[row]
        impulse[row], change[row] = new, step
        on_i, on_j = mobility[i] * step, mobility[j] * step
        velocity[i, 0] -= on_i * x
        velocity[i, 1] -= on_i * y
        velocity[j, 0] += on_j * x
        velocity[j, 1] += on_j * y
        largest = max(largest, abs(on_i) + abs(on_j))
    return largest


@compiled_inside
def residual(contacts: Contacts, motion: DiscMotion, some: Integers) -> float:
    """The largest violation of the complementarity conditions (m/s): penetration, or impulse on separating bodies."""
    begin, end = span_of(some)
    first, second, normal = contacts.first, contacts.second, contacts.normal
    impulse, bound, weight, velocity = contacts.impulse, contacts.bound, contacts.weight, motion.velocity
    worst = 0.0
    for row in range(begin, end):
        i, j = np.uint64(first[row]), np.uint64(second[row])
        along_x = normal[row, 0] * (velocity[j, 0] - velocity[i, 0])
        excess = along_x + normal[row, 1] * (velocity[j, 1] - velocity[i, 1]) - bound[row]
        if weight[row] > 0.0:
            worst = max(worst, -excess, min(excess, impulse[row] / weight[row]))
    return worst


@compiled_inside
def accelerate(contacts: Contacts, motion: DiscMotion, some: Integers, ratio: float) -> None:
    """Step along the conjugate direction: p = max(p + ratio d, 0), then d = ratio d + the change of the last sweep."""
    begin, end = span_of(some)
    first, second, normal = contacts.first, contacts.second, contacts.normal
    impulse, change, direction, step = contacts.impulse, contacts.change, contacts.direction, contacts.scratch
    velocity, mobility = motion
    for row in range(begin, end):
        along, old = ratio * direction[row], impulse[row]
        impulse[row] = max(old + along, 0.0)
        step[row] = impulse[row] - old
        direction[row] = along + change[row]
    if ratio > 0.0:
        for row in range(begin, end):
            i, j = np.uint64(first[row]), np.uint64(second[row])
            on_i, on_j = mobility[i] * step[row], mobility[j] * step[row]
            velocity[i, 0] -= on_i * normal[row, 0]
            velocity[i, 1] -= on_i * normal[row, 1]
            velocity[j, 0] += on_j * normal[row, 0]
            velocity[j, 1] += on_j * normal[row, 1]


@compiled_inside
def restart(contacts: Any, some: Integers) -> None:
    """Set the conjugate direction of some contacts, of discs or other bodies, to zero."""
    direction = contacts.direction
    for row in some:
        direction[row] = 0.0


@compiled_inside
def square(contacts: Any, some: Integers) -> float:
    """The square of the last changes of some impulses."""
    total, change = 0.0, contacts.change
    for row in some:
        total += change[row] ** 2
    return total


@compiled
def islands(contacts: Contacts, motion: DiscMotion) -> Islands:
    """The islands with an impulse or a change."""
    return islands_among(contacts.first, contacts.second, busy_contacts(contacts), motion.mobility)


@compiled
def packed(contacts: Contacts, rows: Integers) -> tuple[Contacts, Integers]:
    """A copy of some contacts, and their indices in the copy: sweeps over successive rows are faster."""
    some = make_contacts(len(rows))
    some.total[0] = len(rows)
    for place in range(len(rows)):
        row = rows[place]
        some.first[place], some.second[place], some.gap[place] = (
            contacts.first[row],
            contacts.second[row],
            contacts.gap[row],
        )
        some.normal[place, 0], some.normal[place, 1] = contacts.normal[row, 0], contacts.normal[row, 1]
        some.bound[place], some.weight[place] = contacts.bound[row], contacts.weight[row]
        some.impulse[place], some.change[place] = contacts.impulse[row], contacts.change[row]
    return some, np.arange(len(rows))


@compiled
def unpack(contacts: Contacts, some: Contacts, rows: Integers) -> None:
    """Copy the impulses of a copy back to their rows."""
    impulse, solved = contacts.impulse, some.impulse
    for place in range(len(rows)):
        impulse[rows[place]] = solved[place]


@compiled
def unpacked(rows: Any, some: Integers) -> tuple[Any, Integers]:
    """The rows without copying, and the indices of some of them."""
    return rows, some


@compiled
def busy_contacts(contacts: Any) -> Choice:
    """Flags of the contacts with an impulse or a change."""
    busy = np.empty(contacts.total[0], np.bool_)
    for row in range(len(busy)):
        busy[row] = contacts.impulse[row] != 0.0 or contacts.change[row] != 0.0
    return busy


@compiled
def unknowns(contacts: Any) -> tuple[Array, Array, Array]:
    """The impulses, the bounds of the relative velocities, and the effective masses."""
    return contacts.impulse, contacts.bound, contacts.weight


@compiled
def normal_velocity(contacts: Contacts, motion: DiscMotion, row: int) -> float:
    """Relative normal velocity of a contact."""
    i, j, velocity = contacts.first[row], contacts.second[row], motion.velocity
    along_x = contacts.normal[row, 0] * (velocity[j, 0] - velocity[i, 0])
    return float(along_x + contacts.normal[row, 1] * (velocity[j, 1] - velocity[i, 1]))


@compiled
def add_impulse(contacts: Contacts, motion: DiscMotion, row: int, impulse: float) -> None:
    """Change the velocities by an impulse of one contact."""
    (velocity, mobility), i, j = motion, contacts.first[row], contacts.second[row]
    for axis in range(2):
        velocity[i, axis] -= mobility[i] * impulse * contacts.normal[row, axis]
        velocity[j, axis] += mobility[j] * impulse * contacts.normal[row, axis]


@compiled
def columns(contacts: Contacts, motion: DiscMotion, rows: Integers) -> Array:
    """The responses to unit impulses in the norm of kinetic energy, one column each; the last row is empty."""
    first, second, mobility = contacts.first, contacts.second, motion.mobility
    place, bodies = numbered(np.append(first[rows], second[rows]), len(mobility))
    matrix = np.zeros((2 * bodies + 1, len(rows)))
    for k in range(len(rows)):
        i, j = first[rows[k]], second[rows[k]]
        for axis in range(2):
            matrix[2 * place[i] + axis, k] = -np.sqrt(mobility[i]) * contacts.normal[rows[k], axis]
            matrix[2 * place[j] + axis, k] = np.sqrt(mobility[j]) * contacts.normal[rows[k], axis]
    return matrix


@compiled
def separate(contacts: Contacts, position: Array, bodies: Bodies, slop: float) -> int:
    """Position projection: move overlapping bodies apart, in proportion to their mobilities, until no overlap exceeds
    `slop`. Velocities do not change.

    Returns the number of sweeps. Gaps and normals in `contacts` are not updated.
    """
    first, second, weight = contacts.first, contacts.second, contacts.weight
    radius, mobility, count, periods = bodies.radius, bodies.mobility, position.shape[0], bodies.periods
    for rounds in range(MOST_ROUNDS):
        deepest = 0.0
        for row in range(contacts.total[0]):
            i, j = first[row], second[row]
            if j < count:
                along, across = apart(position, i, j, periods)
                gap, to_x, to_y = pair_gap(along, across, radius[i] + radius[j])
            else:
                distance, in_x, in_y = wall_distance(bodies.walls, j - count, position[i, 0], position[i, 1])
                gap, to_x, to_y = distance - radius[i], -in_x, -in_y
            deepest = max(deepest, -gap)
            if gap < -0.5 * slop:
                share = gap * weight[row]
                position[i, 0] += mobility[i] * share * to_x
                position[i, 1] += mobility[i] * share * to_y
                if j < count:
                    position[j, 0] -= mobility[j] * share * to_x
                    position[j, 1] -= mobility[j] * share * to_y
        if deepest <= slop:
            return rounds
    return MOST_ROUNDS


class Memory(NamedTuple):
    """Impulses stored from step to step. They are a part of the state, since warm starts affect the last bits."""

    total: Integers
    pair: Integers
    """(capacity, 2)"""
    impulse: Array


class ContactKeys(NamedTuple):
    """Contacts identified by two integers, in ascending order: by the first, then by the second."""

    total: Integers
    """(1,) number of contacts"""
    first: Integers
    second: Integers
    impulse: Array
    """contacts with a positive impulse are kept, all others dropped"""


@compiled
def remember(keys: ContactKeys, value: Array, memory: Memory, kept: Array) -> None:
    """Store a value of each contact with a positive impulse, with its keys."""
    found = 0
    for row in range(keys.total[0]):
        if keys.impulse[row] > 0.0 and found < len(kept):
            memory.pair[found, 0], memory.pair[found, 1] = keys.first[row], keys.second[row]
            kept[found] = value[row]
            found += 1
    memory.total[0] = found


@compiled
def recall(keys: ContactKeys, value: Array, memory: Memory, kept: Array) -> None:
    """Set each contact's value to that of the previous step, or zero. Both lists are sorted, so one pass suffices."""
    place, last = 0, memory.total[0]
    for row in range(keys.total[0]):
        i, j = keys.first[row], keys.second[row]
        while place < last and (
            memory.pair[place, 0] < i or (memory.pair[place, 0] == i and memory.pair[place, 1] < j)
        ):
            place += 1
        found = place < last and memory.pair[place, 0] == i and memory.pair[place, 1] == j
        value[row] = kept[place] if found else 0.0
