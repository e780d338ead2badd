"""One of Newton's changes, put in: box, spheres, walls and contacts move by as much of it as can be believed."""

from __future__ import annotations

import math

import numpy as np

from ecume._jit import compiled, compiled_inside, composed, prange, shared
from ecume.models.soft.borders import moved
from ecume.models.soft.cell import Goal, deform, place_images
from ecume.models.soft.films import Answers, Films, Pairs, center_distance
from ecume.models.soft.pulling import CHUNK, count_pairs, largest_line
from ecume.models.soft.spins import rolled, turn_pairs
from ecume.models.soft.step import Bodies, Step
from ecume.models.soft.wall_motion import move_walls, shift_at_walls
from ecume.units import Array

LONGEST_CHANGE = 0.7
"""Of ln(gap) in one iteration: beyond it the linear answer means nothing, and the update is shortened."""


@composed
def move(step: Step, goal: Goal) -> float:
    """Add the solved change to box, spheres and contacts, shortened where it is too long; how large it was."""
    bodies, films, answers, by = step.bodies, step.films, step.answers, step.cell.change
    largest = shift_contacts(step.pairs, answers, bodies, by)
    largest = max(largest, largest_change(by, bodies.change, bodies.position.shape[1], step.spins.radius))
    largest = max(largest, shift_at_walls(step.walls, bodies.change, bodies.position.shape[1]))
    if not math.isfinite(largest):
        return math.inf
    part = min(1.0, LONGEST_CHANGE / max(largest, 1e-300))
    displace(bodies, step.spins.turn, by, part)
    turn_pairs(step.pairs, step.spins)
    deform(step.cell, goal, part)
    move_walls(step.walls, part)
    place_images(step.pairs, step.cell)
    move_contacts(films, answers, part)
    return float(largest)


@shared(count_pairs)
def shift_contacts(pairs: Pairs, answers: Answers, bodies: Bodies, by: Array) -> float:
    """What Newton's change does to the contacts; how much at most."""
    first, second, offset, radius_sum = pairs.first, pairs.second, pairs.offset, pairs.radius_sum
    position, change, shift, response = bodies.position, bodies.change, answers.shift, answers.response
    count, dimensions = len(first), position.shape[1]
    extremes = np.zeros((count + CHUNK - 1) // CHUNK)
    for chunk in prange(len(extremes)):
        largest = 0.0
        for c in range(chunk * CHUNK, min((chunk + 1) * CHUNK, count)):
            x = center_distance(position, offset, first[c], second[c], c)
            u, v = rolled(x, radius_sum[c], (first[c], second[c]), change, dimensions), moved(by, x)
            u = (u[0] + v[0], u[1] + v[1], u[2] + v[2])
            for k in range(4):
                shift[c, k] += response[c, k, 0] * u[0] + response[c, k, 1] * u[1] + response[c, k, 2] * u[2]
                largest = max(largest, abs(shift[c, k]))
        extremes[chunk] = largest
    return largest_line(extremes)


def count_films(films: Films, *_: object) -> int:
    """How large a crowd of contacts is."""
    return len(films.log_gap)


@shared(count_films)
def move_contacts(films: Films, answers: Answers, part: float) -> None:
    """Add a part of their change."""
    log_gap, direction, shift = films.log_gap, films.direction, answers.shift
    for c in prange(len(log_gap)):
        move_contact(log_gap, direction, shift, part, c)


@compiled_inside
def move_contact(log_gap: Array, direction: Array, shift: Array, part: float, c: int) -> None:
    """Add a part of a contact's change."""
    log_gap[c] += part * shift[c, 0]
    length = 0.0
    for k in range(3):
        direction[c, k] += part * shift[c, 1 + k]
        length += direction[c, k] ** 2
    length = math.sqrt(length)
    for k in range(3):
        direction[c, k] /= length


@compiled
def largest_change(by: Array, change: Array, dimensions: int, radius: Array) -> float:
    """Of the box, relative, and of spins (rad), in one of Newton's steps."""
    largest = 0.0
    for k in range(3):
        for m in range(3):
            largest = max(largest, abs(by[k, m]))
    for i in range(len(change)):
        for k in range(dimensions, change.shape[1]):
            largest = max(largest, abs(change[i, k]) / radius[i])
    return largest


@compiled
def displace(bodies: Bodies, turn: Array, by: Array, part: float) -> None:
    """Add a part of Newton's change to places and spins."""
    position, change, dimensions = bodies.position, bodies.change, bodies.position.shape[1]
    moved_by = bodies.moved
    for i in range(len(position)):
        x = moved(by, (position[i, 0], position[i, 1], position[i, 2] if dimensions == 3 else 0.0))
        for k in range(dimensions):
            position[i, k] += part * (change[i, k] + x[k])
            moved_by[i, k] += part * (change[i, k] + x[k])
        for k in range(turn.shape[1]):
            turn[i, k] += part * change[i, dimensions + k]
