"""What pulls at each sphere, and what resists: right side and matrix of Newton's step."""

from __future__ import annotations

import numpy as np

from ecume._jit import compiled, compiled_inside, composed, prange, shared
from ecume.engine.linear_solvers import block_matrix
from ecume.engine.linear_solvers.block_matrix import Pattern
from ecume.models.soft.cell import flow, largest_strain
from ecume.models.soft.contacts.contact import ROUNDING
from ecume.models.soft.contacts.films import Answers, Pairs
from ecume.models.soft.contacts.rotation import add_torques, fill_quads, hold_spins, load_torques, turn_first
from ecume.models.soft.contacts.walls import push_from_walls, resist_at_walls
from ecume.models.soft.state import Bodies, Step
from ecume.units import Array

CHUNK = 256
"""Spheres or contacts that a thread takes at once."""


def count_pairs(pairs: Pairs, *_: object) -> int:
    """The number of contacts, for the choice between serial and threaded loops."""
    return len(pairs.first)


@composed
def imbalance(step: Step, factor: float, span: float, corrected: bool) -> tuple[float, float, float]:
    """Write the residual force on each sphere into `right`; returns its largest value, the largest force, and the
    rounding error.
    """
    right, position, along = step.bodies.right, step.bodies.position, flow(step.cell)
    load_torques(step.spins, right, factor, (span, -0.5 * along[0, 1]))
    given = (factor, span, 1.0 if corrected else 0.0, largest_strain(step.cell))
    largest, stiffest = pull(step.pairs, step.answers, step.matrix.pattern, step.bodies, along, given)
    most, firmest = push_from_walls(step.walls, position, right, corrected)
    if right.shape[1] > position.shape[1]:
        add_torques(step.pairs, step.answers, position, right, corrected)
    return largest_of(right), float(max(largest, most)), float(ROUNDING * max(stiffest, firmest))


@compiled
def largest_of(right: Array) -> float:
    """The largest magnitude."""
    worst = 0.0
    for i in range(right.shape[0]):
        for k in range(right.shape[1]):
            worst = max(worst, abs(right[i, k]))
    return worst


@shared(count_pairs)
def pull(
    pairs: Pairs,
    answers: Answers,
    pattern: Pattern,
    bodies: Bodies,
    along: Array,
    given: tuple[float, float, float, float],
) -> tuple[float, float]:
    """All forces on each sphere but walls', into `right`; the largest, and the largest of stiffness times place.

    Given are what external forces are multiplied by, the stage's span, what part of the corrections counts, and the
    strain of a box that answers to a stress.
    """
    right, position, count = bodies.right, bodies.position, len(bodies.drag)
    chunks = (count + CHUNK - 1) // CHUNK
    extremes = np.zeros((chunks, 2))
    for chunk in prange(chunks):
        for i in range(chunk * CHUNK, min((chunk + 1) * CHUNK, count)):
            most, firmest = load_sphere(bodies, right, i, along, (given[0], given[1], given[3]))
            extremes[chunk, 0], extremes[chunk, 1] = max(extremes[chunk, 0], most), max(extremes[chunk, 1], firmest)
            most, firmest = pull_sphere((pairs, answers, pattern), (position, right), i, given[2])
            extremes[chunk, 0], extremes[chunk, 1] = max(extremes[chunk, 0], most), max(extremes[chunk, 1], firmest)
    largest, stiffest = 0.0, 0.0
    for chunk in range(chunks):
        largest, stiffest = max(largest, extremes[chunk, 0]), max(stiffest, extremes[chunk, 1])
    return largest, stiffest


@compiled_inside
def load_sphere(
    bodies: Bodies, right: Array, i: int, along: Array, during: tuple[float, float, float]
) -> tuple[float, float]:
    """External force and drag on a sphere, into `right`; the largest force, and of stiffness times place."""
    factor, span, strain = during
    external, weight, drag, position = bodies.force, bodies.weight, bodies.drag, bodies.position
    moved, start = bodies.moved, bodies.start
    largest, stiffest, dimensions = 0.0, 0.0, position.shape[1]
    for k in range(dimensions):
        right[i, k] = factor * external[i, k] + weight[i, k]
        largest = max(largest, abs(right[i, k]))
        if drag[i] > 0.0:
            carried = start[i, k]
            for m in range(dimensions):
                carried += along[k, m] * position[i, m]
            right[i, k] -= drag[i] * (moved[i, k] - carried) / span
            # What is carried is known to the last digits of the box's strain, not to those of its change.
            size = max(abs(moved[i, k]), abs(carried), strain * abs(position[i, k]))
            stiffest = max(stiffest, drag[i] / span * size)
    return largest, stiffest


@compiled_inside
def pull_sphere(
    web: tuple[Pairs, Answers, Pattern], bodies: tuple[Array, Array], i: int, corrected: float
) -> tuple[float, float]:
    """Add the forces of a sphere's contacts, in their order; the largest force, and of stiffness times place, of those
    that it is the first of.
    """
    (pairs, answers, pattern), (position, right) = web, bodies
    force, correction, stiffness = answers.force, answers.correction, answers.stiffness
    first_link, link = pattern.first_link, pattern.link
    second, radius_sum, offset = pairs.second, pairs.radius_sum, pairs.offset
    largest, stiffest = 0.0, 0.0
    for place in range(first_link[i], first_link[i + 1]):
        c, ahead = link[place] // 2, link[place] % 2 == 0
        for k in range(position.shape[1]):
            value = force[c, k]
            if ahead:
                largest = max(largest, abs(value))
                size = radius_sum[c] + abs(position[i, k]) + abs(position[second[c], k]) + abs(offset[c, k])
                stiffest = max(stiffest, stiffness[c, k, k] * size)
            value += corrected * correction[c, k]
            right[i, k] += value if ahead else -value
    return largest, stiffest


@composed
def resist(step: Step, span: float) -> None:
    """The matrix of Newton's step: what resists a displacement of each sphere."""
    bodies, spins, pattern, numbers = step.bodies, step.spins, step.matrix.pattern, step.matrix.blocks
    dimensions, width = bodies.position.shape[1], bodies.diagonal.shape[1]
    hold_back(bodies, spins.drag, span)
    if width > dimensions:
        fill_quads(step.pairs, step.answers, spins, bodies.position)
        block_matrix.assemble_quads(step.matrix, spins.quads, bodies.diagonal)
        hold_spins(step.matrix, spins, is_free(step))
        turn_first(step.matrix, spins, step.borders.right)
    else:
        fill_matrix(pattern, numbers, step.answers.stiffness, bodies.diagonal)
    resist_at_walls(step.walls, numbers, pattern.diagonal, dimensions)


@compiled
def hold_back(bodies: Bodies, spin_drag: Array, span: float) -> None:
    """Add the drag of the liquid, and what holds loose pieces."""
    dimensions = bodies.position.shape[1]
    for i in range(len(bodies.drag)):
        for k in range(bodies.diagonal.shape[1]):
            drag = bodies.drag[i] if k < dimensions else spin_drag[i]
            bodies.diagonal[i, k] = bodies.anchor[i] + (drag / span if span > 0.0 else 0.0)


def count_links(pattern: Pattern, *_: object) -> int:
    """The number of contacts, for the choice between serial and threaded loops."""
    return len(pattern.upper)


@shared(count_links)
def fill_matrix(pattern: Pattern, numbers: Array, stiffness: Array, diagonal: Array) -> None:
    """The rows of all spheres."""
    for i in prange(len(diagonal)):
        block_matrix.fill_row(pattern, numbers, stiffness, diagonal, i)


@composed
def is_free(step: Step) -> bool:
    """Whether nothing keeps the spheres from circling each other all together."""
    sides = step.cell.sides
    return not (is_held(step) or sides[0] > 0.0 or sides[1] > 0.0 or sides[2] > 0.0)


@composed
def is_held(step: Step) -> bool:
    """Whether walls, or drag or anchors of some spheres, keep them from going away all together."""
    bodies = step.bodies
    return len(step.walls) > 0 or largest_line(bodies.drag) > 0.0 or largest_line(bodies.anchor) > 0.0


@compiled
def largest_line(values: Array) -> float:
    """The largest, or zero."""
    largest = 0.0
    for i in range(len(values)):
        largest = max(largest, values[i])
    return largest
