"""Contacts of bodies that turn: impulses act at the end of a lever, and solve for spins as well.

The conditions and the solver are those of `contacts`, for velocities (v_x, v_y, spin): each contact is a row J of six
numbers, three for either body, with J w >= bound, and W J is what a unit impulse does to the two. What moves less along
one of its directions than across, in a viscous liquid, has a mobility for each. Impulses act along the line on which
both nearest points lie: they keep momentum and angular momentum to rounding.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled
from ecume.engine.cells import Integers
from ecume.engine.contact.contacts import Candidates
from ecume.engine.contact.projected_gauss_seidel import MOST_SWEEPS, PATIENCE, Goal
from ecume.engine.contact.warm_start import Keyed, Memory, recall_each, remember_each
from ecume.engine.outlines import NEARNESS, Outlines, Stance, bodies_near, turn_corners, wall_near
from ecume.engine.walls import Walls, wall_count
from ecume.units import Array

FEATURES = 4096
"""More than the places at which two bodies can be near."""


class Levers(NamedTuple):
    """Contacts of one step, ordered by i, then j, then feature. A wall number k stands as partner N + k."""

    total: Integers
    """(1,)"""
    first: Integers
    """(capacity,) i"""
    second: Integers
    """(capacity,) j, or N + wall"""
    place: Integers
    """(capacity,) the partner and the feature, which corner on which edge, as one number: j FEATURES + feature"""
    gap: Array
    lever: Array
    """(capacity, 6) J: what velocities and spins of i and j do to the gap"""
    give: Array
    """(capacity, 6) W J: what a unit impulse does to these"""
    bound: Array
    """the least J w allowed"""
    weight: Array
    """impulse per relative velocity"""
    impulse: Array
    change: Array
    direction: Array
    scratch: Array
    near: Array
    """(places, NEARNESS) of one pair"""


class Party(NamedTuple):
    """Who may touch: outlines, walls, and how easily each moves."""

    outlines: Outlines
    radius: Array
    """(N,) of the circle around each"""
    walls: Walls
    mobility: Array
    """(N, 3) velocity per impulse along the body, across it, and spin per angular impulse"""


def make_levers(capacity: int, places: int) -> Levers:
    """Room for `capacity` contacts, and for as many places of one pair."""
    of_row = "gap", "bound", "weight", "impulse", "change", "direction", "scratch"
    return Levers(
        total=np.zeros(1, np.int64),
        first=np.zeros(capacity, np.int64),
        second=np.zeros(capacity, np.int64),
        place=np.zeros(capacity, np.int64),
        lever=np.zeros((capacity, 6)),
        give=np.zeros((capacity, 6)),
        near=np.zeros((places, NEARNESS)),
        **{name: np.zeros(capacity) for name in of_row},
    )


@compiled
def give_way(mobility: Array, angle: float, lever: Array, give: Array) -> float:
    """What a unit impulse at one end of a lever does to its body; the speed at which that end gives way."""
    c, s = math.cos(angle), math.sin(angle)
    along, across = c * lever[0] + s * lever[1], c * lever[1] - s * lever[0]
    fast, slow = mobility[0] * along, mobility[1] * across
    give[0], give[1], give[2] = c * fast - s * slow, s * fast + c * slow, mobility[2] * lever[2]
    return float(fast * along + slow * across + mobility[2] * lever[2] * lever[2])


@compiled
def write_row(levers: Levers, row: int, pair: tuple[int, int], near: Array, stance: Stance, mobility: Array) -> None:
    """A place where two are near, as a contact."""
    i, j = pair
    levers.first[row], levers.second[row], levers.place[row] = i, j, j * FEATURES + int(near[7])
    levers.gap[row] = near[0]
    lever, give = levers.lever[row], levers.give[row]
    to_x, to_y = near[1], near[2]
    lever[0], lever[1], lever[2] = -to_x, -to_y, near[4] * to_x - near[3] * to_y
    way = give_way(mobility[i], stance.angle[i], lever[:3], give[:3])
    lever[3:] = 0.0
    give[3:] = 0.0
    if j < len(stance.angle):
        lever[3], lever[4], lever[5] = to_x, to_y, near[5] * to_y - near[6] * to_x
        way += give_way(mobility[j], stance.angle[j], lever[3:], give[3:])
    levers.weight[row] = 1.0 / way if way > 0.0 else 0.0


@compiled
def gather(levers: Levers, candidates: Candidates, stance: Stance, party: Party, reach: float) -> bool:
    """Write down all places nearer than `reach`. False when there is no room for all."""
    position, near, found, room = stance.position, levers.near, 0, len(levers.first)
    count, walls = len(position), wall_count(party.walls)
    turn_corners(party.outlines, stance)
    for i in range(count):
        pairs = candidates.first[i + 1] - candidates.first[i]
        for place in range(pairs + walls):
            if place < pairs:
                j = candidates.partner[candidates.first[i] + place]
                x, y = position[j, 0] - position[i, 0], position[j, 1] - position[i, 1]
                within = party.radius[i] + party.radius[j] + reach
                here = 0 if x * x + y * y > within * within else bodies_near(
                    party.outlines, stance, i, j, reach, near
                )  # fmt: skip
            else:
                j = count + place - pairs
                here = wall_near(party.outlines, stance, party.walls, (i, place - pairs), reach, near)
            if found + here > room:
                levers.total[0] = found
                return False
            for k in range(here):
                write_row(levers, found, (i, j), near[k], stance, party.mobility)
                found += 1
    levers.total[0] = found
    return True


@compiled
def keyed(levers: Levers) -> Keyed:
    """Who touches whom, and where."""
    return Keyed(levers.total, levers.first, levers.place, levers.impulse)


@compiled
def remember(levers: Levers, memory: Memory) -> None:
    """Keep the impulses of contacts that push."""
    remember_each(keyed(levers), levers.impulse, memory, memory.impulse)


@compiled
def recall(levers: Levers, memory: Memory) -> None:
    """Start from the impulses of the step before."""
    recall_each(keyed(levers), levers.impulse, memory, memory.impulse)


@compiled
def approaches(levers: Levers, velocity: Array, speed: Array) -> None:
    """J w of every contact: negative where the two come closer."""
    first, second, lever = levers.first, levers.second, levers.lever
    for row in range(levers.total[0]):
        i, j = first[row], second[row]
        closing = lever[row, 0] * velocity[i, 0] + lever[row, 1] * velocity[i, 1] + lever[row, 2] * velocity[i, 2]
        closing += lever[row, 3] * velocity[j, 0] + lever[row, 4] * velocity[j, 1] + lever[row, 5] * velocity[j, 2]
        speed[row] = closing


@compiled
def push_all(levers: Levers, impulse: Array, velocity: Array) -> None:
    """Push the two of every contact apart."""
    first, second, give = levers.first, levers.second, levers.give
    for row in range(levers.total[0]):
        i, j, push = first[row], second[row], impulse[row]
        for axis in range(3):
            velocity[i, axis] += give[row, axis] * push
            velocity[j, axis] += give[row, 3 + axis] * push


@compiled
def _sweep(levers: Levers, velocity: Array) -> float:
    """One Gauss-Seidel sweep over all contacts; the largest change in it, as a relative velocity."""
    first, second, lever, give = levers.first, levers.second, levers.lever, levers.give
    impulse, bound, weight, change = levers.impulse, levers.bound, levers.weight, levers.change
    largest = 0.0
    for row in range(levers.total[0]):
        i, j = first[row], second[row]
        speed = lever[row, 0] * velocity[i, 0] + lever[row, 1] * velocity[i, 1] + lever[row, 2] * velocity[i, 2]
        speed += lever[row, 3] * velocity[j, 0] + lever[row, 4] * velocity[j, 1] + lever[row, 5] * velocity[j, 2]
        new = max(impulse[row] + weight[row] * (bound[row] - speed), 0.0)
        step = new - impulse[row]
        impulse[row], change[row] = new, step
        for axis in range(3):
            velocity[i, axis] += give[row, axis] * step
            velocity[j, axis] += give[row, 3 + axis] * step
        if weight[row] > 0.0:
            largest = max(largest, abs(step) / weight[row])
    return largest


@compiled
def residual(levers: Levers, velocity: Array) -> float:
    """By how much the worst contact breaks the conditions (m/s): it lets through, or pushes what leaves."""
    speed, worst = levers.scratch, 0.0
    approaches(levers, velocity, speed)
    for row in range(levers.total[0]):
        if levers.weight[row] > 0.0:
            excess = speed[row] - levers.bound[row]
            worst = max(worst, -excess, min(excess, levers.impulse[row] / levers.weight[row]))
    return worst


@compiled
def _accelerate(levers: Levers, velocity: Array, ratio: float) -> None:
    """Go on along the conjugate direction: see `contacts`."""
    impulse, change, direction, step = levers.impulse, levers.change, levers.direction, levers.scratch
    for row in range(levers.total[0]):
        along, old = ratio * direction[row], impulse[row]
        impulse[row] = max(old + along, 0.0)
        step[row] = impulse[row] - old
        direction[row] = along + change[row]
    if ratio > 0.0:
        push_all(levers, step, velocity)


@compiled
def solve(levers: Levers, velocity: Array, goal: Goal) -> int:
    """Change `velocity` by the contacts' impulses until the residual is as wanted: see `contacts.solve`.

    The impulses that stand there are the start. Returns the number of sweeps, MOST_SWEEPS + 1 if they were not enough.
    """
    push_all(levers, levers.impulse, velocity)
    for row in range(levers.total[0]):
        levers.direction[row] = 0.0
    square_before, residual_before = 0.0, np.inf
    for sweep in range(1, MOST_SWEEPS + 1):
        largest = _sweep(levers, velocity)
        if largest <= goal.wanted and residual(levers, velocity) <= goal.wanted:
            return sweep
        if sweep % PATIENCE == 0:
            left = residual(levers, velocity)
            if left <= goal.tolerable and left > 0.5 * residual_before:
                return sweep
            residual_before = left
        square = 0.0
        for row in range(levers.total[0]):
            square += levers.change[row] ** 2
        ratio = square / square_before if 0.0 < square <= square_before else 0.0
        _accelerate(levers, velocity, ratio)
        square_before = square
    return MOST_SWEEPS + 1


@compiled
def deepest_overlap(levers: Levers) -> float:
    """Of all contacts; zero where none overlaps."""
    deepest = 0.0
    for row in range(levers.total[0]):
        deepest = max(deepest, -levers.gap[row])
    return deepest


@compiled
def separate(levers: Levers, candidates: Candidates, stance: Stance, party: Party, slop: float) -> int:
    """Move and turn overlapping bodies until none overlaps by more than `slop`; velocities stay as they are.

    Each round asks for the least shifts that would open all overlaps if bodies were flat where they touch, by the
    solver of impulses. Returns the number of rounds; contacts are those of the new places afterwards.
    """
    position, angle = stance.position, stance.angle
    shift = np.zeros((len(position) + wall_count(party.walls), 3))
    for turn in range(50):
        if deepest_overlap(levers) <= slop:
            return turn
        shift[:] = 0.0
        for row in range(levers.total[0]):
            levers.impulse[row] = 0.0
            levers.bound[row] = -levers.gap[row] - 0.25 * slop
        solve(levers, shift, Goal(1e-3 * slop, 1e-2 * slop))
        for i in range(len(position)):
            position[i, 0] += shift[i, 0]
            position[i, 1] += shift[i, 1]
            angle[i] += shift[i, 2]
        gather(levers, candidates, stance, party, 4.0 * slop)
    return 50
