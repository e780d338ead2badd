"""Newton's method for a stage: all spheres, contacts, spins, walls and the box at once."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from ecume._jit import compiled, compiled_inside, composed, inlined, plainly, prange, shared
from ecume.engine import elimination, gradients, sparse
from ecume.engine.sparse import Pattern
from ecume.models.soft.borders import (
    Web,
    border,
    border_walls,
    change_box,
    change_walls,
    close,
    missing_stress,
    moved,
    unknowns,
)
from ecume.models.soft.cell import (
    Goal,
    carry_along,
    deform,
    flow,
    impose,
    place_images,
)
from ecume.models.soft.films import Answers, Films, Pairs, answer, center_distance
from ecume.models.soft.parameters import Contacts
from ecume.models.soft.spins import (
    add_torques,
    fill_quads,
    hold_spins,
    load_torques,
    rolled,
    turn_pairs,
)
from ecume.models.soft.step import Bodies, Step
from ecume.models.soft.turning import turn_first, unturn
from ecume.models.soft.wall_motion import move_walls, shift_at_walls
from ecume.models.soft.walls import Walls, answer_walls, missing_at_walls, push_from_walls, resist_at_walls
from ecume.units import Array

MOST_ITERATIONS = 12
BALANCE = 1e-9
"""The largest force that may be left on a sphere, over the largest there is."""
CHUNK = 256
"""Spheres or contacts that a thread takes at once."""
LONGEST_CHANGE = 0.7
"""Of ln(gap) in one iteration: beyond it the linear answer means nothing, and the update is shortened."""
ROUNDING = 2e-15
"""What rounding leaves of a force, over stiffness times coordinates."""


def count_pairs(pairs: Pairs, *_: object) -> int:
    """How large a crowd of contacts is."""
    return len(pairs.first)


@composed
def imbalance(step: Step, factor: float, span: float, corrected: bool) -> tuple[float, float, float]:
    """What is left on each sphere, into `right`; the largest, the largest force there is, and what rounding leaves."""
    right, position, along = step.bodies.right, step.bodies.position, flow(step.cell)
    load_torques(step.spins, right, factor, (span, -0.5 * along[0, 1]))
    given = (factor, span, 1.0 if corrected else 0.0)
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
    pairs: Pairs, answers: Answers, pattern: Pattern, bodies: Bodies, along: Array, given: tuple[float, float, float]
) -> tuple[float, float]:
    """All forces on each sphere but walls', into `right`; the largest, and the largest of stiffness times place.

    Given are what external forces are multiplied by, the stage's span, and what part of the corrections counts.
    """
    right, position, count = bodies.right, bodies.position, len(bodies.drag)
    chunks = (count + CHUNK - 1) // CHUNK
    extremes = np.zeros((chunks, 2))
    for chunk in prange(chunks):
        for i in range(chunk * CHUNK, min((chunk + 1) * CHUNK, count)):
            most, firmest = load_sphere(bodies, right, i, along, (given[0], given[1]))
            extremes[chunk, 0], extremes[chunk, 1] = max(extremes[chunk, 0], most), max(extremes[chunk, 1], firmest)
            most, firmest = pull_sphere((pairs, answers, pattern), (position, right), i, given[2])
            extremes[chunk, 0], extremes[chunk, 1] = max(extremes[chunk, 0], most), max(extremes[chunk, 1], firmest)
    largest, stiffest = 0.0, 0.0
    for chunk in range(chunks):
        largest, stiffest = max(largest, extremes[chunk, 0]), max(stiffest, extremes[chunk, 1])
    return largest, stiffest


@compiled_inside
def load_sphere(bodies: Bodies, right: Array, i: int, along: Array, during: tuple[float, float]) -> tuple[float, float]:
    """External force and drag on a sphere, into `right`; the largest force, and of stiffness times place."""
    factor, span = during
    external, weight, drag, position, start = bodies.force, bodies.weight, bodies.drag, bodies.position, bodies.start
    largest, stiffest, dimensions = 0.0, 0.0, position.shape[1]
    for k in range(dimensions):
        right[i, k] = factor * external[i, k] + weight[i, k]
        largest = max(largest, abs(right[i, k]))
        if drag[i] > 0.0:
            carried = start[i, k]
            for m in range(dimensions):
                carried += along[k, m] * position[i, m]
            right[i, k] -= drag[i] * (position[i, k] - carried) / span
            stiffest = max(stiffest, drag[i] / span * abs(position[i, k]))
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
    for i in range(len(position)):
        x = moved(by, (position[i, 0], position[i, 1], position[i, 2] if dimensions == 3 else 0.0))
        for k in range(dimensions):
            position[i, k] += part * (change[i, k] + x[k])
        for k in range(turn.shape[1]):
            turn[i, k] += part * change[i, dimensions + k]


@composed
def resist(step: Step, span: float) -> None:
    """The matrix of Newton's step: what resists a displacement of each sphere."""
    bodies, spins, pattern, blocks = step.bodies, step.spins, step.matrix.pattern, step.matrix.blocks
    dimensions, width = bodies.position.shape[1], bodies.diagonal.shape[1]
    hold_back(bodies, spins.drag, span)
    if width > dimensions:
        fill_quads(step.pairs, step.answers, spins, bodies.position)
        sparse.assemble_quads(step.matrix, spins.quads, bodies.diagonal)
        hold_spins(step.matrix, spins, is_free(step))
        turn_first(step.matrix, spins, step.borders.right)
    else:
        fill_matrix(pattern, blocks, step.answers.stiffness, bodies.diagonal)
    resist_at_walls(step.walls, blocks, pattern.diagonal, dimensions)


@compiled
def hold_back(bodies: Bodies, spin_drag: Array, span: float) -> None:
    """What the liquid resists."""
    dimensions = bodies.position.shape[1]
    for i in range(len(bodies.drag)):
        for k in range(bodies.diagonal.shape[1]):
            drag = bodies.drag[i] if k < dimensions else spin_drag[i]
            bodies.diagonal[i, k] = drag / span if span > 0.0 else 0.0


def count_links(pattern: Pattern, *_: object) -> int:
    """How large a crowd of contacts is."""
    return len(pattern.upper)


@shared(count_links)
def fill_matrix(pattern: Pattern, blocks: Array, stiffness: Array, diagonal: Array) -> None:
    """The rows of all spheres."""
    for i in prange(len(diagonal)):
        sparse.fill_row(pattern, blocks, stiffness, diagonal, i)


@composed
def is_free(step: Step) -> bool:
    """Whether nothing keeps the spheres from circling each other all together."""
    sides = step.cell.sides
    return not (is_held(step) or sides[0] > 0.0 or sides[1] > 0.0 or sides[2] > 0.0)


@composed
def is_held(step: Step) -> bool:
    """Whether walls, or drag on all spheres or some, keep them from going away all together."""
    return len(step.walls) > 0 or largest_line(step.bodies.drag) > 0.0


@compiled
def largest_line(values: Array) -> float:
    """The largest, or zero."""
    largest = 0.0
    for i in range(len(values)):
        largest = max(largest, values[i])
    return largest


@composed
def sides(step: Step) -> int:
    """How many right sides there are: what is left over, and what turns the first of free spheres."""
    return 1 + (step.spins.turn.shape[1] if is_free(step) else 0)


@compiled
def eliminated(step: Step, goal: Goal, loose: int) -> bool:
    """Newton's step by dense elimination."""
    several = sides(step)
    return elimination.eliminate(step.matrix, step.borders.right[:several], step.borders.change[:several], loose)


def descended(step: Step, goal: Goal, loose: int) -> bool:
    """Newton's step by biconjugate gradients."""
    several = sides(step)
    right, change = step.borders.right[:several], step.borders.change[:several]
    return gradients.follow_gradients(step.matrix, right, change, step.gradients, loose)


def factorized(step: Step, goal: Goal, loose: int) -> bool:
    """Newton's step by a sparse factorization."""
    several = sides(step)
    return elimination.factorize(step.matrix, step.borders.right[:several], step.borders.change[:several], loose)


def bordered(way: str, step: Step, goal: Goal, loose: int) -> bool:
    """Newton's step with what all spheres share, by one of these ways."""
    boxed, walls, count = unknowns(step.cell), step.walls, 0
    if boxed or not isinstance(walls, Walls):
        border(step.cell, web_of(step), goal, step.borders)
    else:
        border_walls(walls, goal.drive.load, step.borders, step.bodies.position.shape[1])
        count = len(walls.places.free)
    count = boxed or count
    right, change = step.borders.right[: 1 + count], step.borders.change[: 1 + count]
    if way == "gradients":
        found = gradients.follow_gradients(step.matrix, right, change, step.gradients, loose)
    else:
        solve = elimination.eliminate if way == "dense" else elimination.factorize
        found = solve(step.matrix, right, change, loose)
    answer = close(step.borders, count) if found else None
    if answer is None:
        return False
    if boxed or not isinstance(walls, Walls):
        change_box(step.cell, goal, answer)
    else:
        change_walls(walls, answer)
    return True


@composed
def web_of(step: Step) -> Web:
    """What the borders of the system are made of."""
    return Web(step.pairs, step.answers, step.bodies.position)


@composed
def unmet(step: Step, goal: Goal) -> float:
    """What is missing of the stresses that rule the box, or of the forces on walls."""
    if unknowns(step.cell) > 0:
        return missing_stress(step.cell, web_of(step), goal)
    return float(missing_at_walls(step.walls, step.bodies.position, goal.drive.load))


@composed
def enter(step: Step, goal: Goal) -> None:
    """Put in what is imposed, and carry the spheres along with the box."""
    old = step.cell.shape.copy()
    impose(step.cell, goal)
    carry_along(step.cell, old, step.bodies.position)
    place_images(step.pairs, step.cell)


@composed
def met(step: Step, goal: Goal) -> float:
    """Nothing is missing where nothing answers to a stress."""
    return 0.0


@inlined
def newton_with(
    solve: Callable[..., bool], missing: Callable[..., float], contacts: Contacts, step: Step, goal: Goal
) -> bool:
    """Solve a stage: whether forces and stresses balance and the last change was fine enough."""
    enter(step, goal)
    bodies, load, span = step.bodies, goal.drive.load, goal.span
    loose = 0 if is_held(step) else bodies.position.shape[1]
    last = math.inf
    for _ in range(MOST_ITERATIONS):
        answer(contacts, step.pairs, step.films, bodies.position, span, step.answers)
        answer_walls(step.walls, contacts, bodies.position, step.spins.turn, span)
        worst, largest, rounding = imbalance(step, load, span, False)
        if last <= goal.fine and worst <= BALANCE * largest + rounding and missing(step, goal) <= BALANCE:
            return True
        imbalance(step, load, span, True)
        resist(step, span)
        if not solve(step, goal, loose):
            return False
        if step.spins.turn.shape[1] > 0 and is_free(step):
            unturn(bodies.position, step.spins, step.borders.change, (bodies.force, bodies.weight, load))
        last = move(step, goal)
        if not math.isfinite(last):
            return False
    return False


@compiled
def newton_dense(contacts: Contacts, step: Step, goal: Goal) -> bool:
    """A stage of few spheres."""
    return newton_with(eliminated, met, contacts, step, goal)


def newton_gradients(contacts: Contacts, step: Step, goal: Goal) -> bool:
    """A stage of many spheres. Each pass over them is compiled by itself: all in one took ten times as long, since
    arrays that are reached through tuples are then counted in the inner loops.
    """
    return plainly(newton_with)(descended, met, contacts, step, goal)


def newton_direct(contacts: Contacts, step: Step, goal: Goal) -> bool:
    """A stage of many spheres, however stiff."""
    return plainly(newton_with)(factorized, met, contacts, step, goal)


def newton_bordered(way: str, contacts: Contacts, step: Step, goal: Goal) -> bool:
    """A stage whose box answers to stresses."""
    return plainly(newton_with)(partial(bordered, way), unmet, contacts, step, goal)
