"""Newton's method for a stage: all spheres, contacts, spins, walls and the box at once."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from ecume._jit import compiled, inlined, plainly
from ecume.engine import elimination, gradients, sparse
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
from ecume.models.soft.films import answer, center_distance
from ecume.models.soft.parameters import Contacts
from ecume.models.soft.spins import (
    add_torques,
    fill_quads,
    hold_spins,
    load_torques,
    rolled,
    still,
    turn_pairs,
)
from ecume.models.soft.step import Step
from ecume.models.soft.wall_motion import move_walls, shift_at_walls
from ecume.models.soft.walls import answer_walls, missing_at_walls, push_from_walls, resist_at_walls

MOST_ITERATIONS = 12
BALANCE = 1e-9
"""The largest force that may be left on a sphere, over the largest there is."""
LONGEST_CHANGE = 0.7
"""Of ln(gap) in one iteration: beyond it the linear answer means nothing, and the update is shortened."""
ROUNDING = 2e-15
"""What rounding leaves of a force, over stiffness times coordinates."""


@compiled
def imbalance(step: Step, factor: float, span: float, corrected: bool) -> tuple[float, float, float]:
    """What is left on each sphere, into `right`; the largest, the largest force there is, and what rounding leaves."""
    bodies, answers, first, second = step.bodies, step.answers, step.pairs.first, step.pairs.second
    right, force, correction, stiffness = bodies.right, answers.force, answers.correction, answers.stiffness
    external, drag, position, start = bodies.force, bodies.drag, bodies.position, bodies.start
    along, weight = flow(step.cell), bodies.weight
    radius_sum, offset = step.pairs.radius_sum, step.pairs.offset
    count, dimensions = position.shape
    largest, stiffest, worst = 0.0, 0.0, 0.0
    for i in range(count):
        for k in range(dimensions):
            right[i, k] = factor * external[i, k] + weight[i, k]
            largest = max(largest, abs(right[i, k]))
            if drag[i] > 0.0:
                carried = start[i, k]
                for m in range(dimensions):
                    carried += along[k, m] * position[i, m]
                right[i, k] -= drag[i] * (position[i, k] - carried) / span
                stiffest = max(stiffest, drag[i] / span * abs(position[i, k]))
    load_torques(step.spins, right, factor, (span, -0.5 * along[0, 1]))
    for c in range(len(first)):
        i, j = first[c], second[c]
        for k in range(dimensions):
            value = force[c, k]
            largest = max(largest, abs(value))
            size = radius_sum[c] + abs(position[i, k]) + abs(position[j, k]) + abs(offset[c, k])
            stiffest = max(stiffest, stiffness[c, k, k] * size)
            if corrected:
                value += correction[c, k]
            right[i, k] += value
            right[j, k] -= value
    if len(step.walls.touches.first) > 0:
        most, firmest = push_from_walls(step.walls, position, right, corrected)
        largest, stiffest = max(largest, most), max(stiffest, firmest)
    if right.shape[1] > dimensions:
        add_torques(step.pairs, answers, position, right, corrected)
    for i in range(count):
        for k in range(right.shape[1]):
            worst = max(worst, abs(right[i, k]))
    return worst, largest, ROUNDING * stiffest


@compiled
def move(step: Step, goal: Goal) -> float:
    """Add the solved change to box, spheres and contacts, shortened where it is too long; how large it was."""
    films, answers, bodies = step.films, step.answers, step.bodies
    shift, response, change, position = answers.shift, answers.response, bodies.change, bodies.position
    log_gap, direction, turn = films.log_gap, films.direction, step.spins.turn
    dimensions = position.shape[1]
    by, offset = step.cell.change, step.pairs.offset
    largest = float(np.abs(by).max())
    for c in range(len(log_gap)):
        u = rolled(step.pairs, (position, change), c)
        x = moved(by, center_distance(position, offset, step.pairs.first[c], step.pairs.second[c], c))
        u = (u[0] + x[0], u[1] + x[1], u[2] + x[2])
        for k in range(4):
            shift[c, k] += response[c, k, 0] * u[0] + response[c, k, 1] * u[1] + response[c, k, 2] * u[2]
            largest = max(largest, abs(shift[c, k]))
    for i in range(len(turn)):
        for k in range(turn.shape[1]):
            largest = max(largest, abs(change[i, dimensions + k]) / step.spins.radius[i])
    largest = max(largest, shift_at_walls(step.walls, change, dimensions))
    if not math.isfinite(largest):
        return math.inf
    part = min(1.0, LONGEST_CHANGE / max(largest, 1e-300))
    for i in range(len(position)):
        x = moved(by, (position[i, 0], position[i, 1], position[i, 2] if dimensions == 3 else 0.0))
        for k in range(dimensions):
            position[i, k] += part * (change[i, k] + x[k])
        for k in range(turn.shape[1]):
            turn[i, k] += part * change[i, dimensions + k]
    turn_pairs(step.pairs, step.spins)
    deform(step.cell, goal, part)
    move_walls(step.walls, part)
    place_images(step.pairs, step.cell)
    for c in range(len(log_gap)):
        log_gap[c] += part * shift[c, 0]
        length = 0.0
        for k in range(3):
            direction[c, k] += part * shift[c, 1 + k]
            length += direction[c, k] ** 2
        length = math.sqrt(length)
        for k in range(3):
            direction[c, k] /= length
    return largest


@compiled
def resist(step: Step, span: float) -> None:
    """The matrix of Newton's step: what resists a displacement of each sphere."""
    bodies, spins = step.bodies, step.spins
    dimensions, width = bodies.position.shape[1], bodies.diagonal.shape[1]
    for i in range(len(bodies.drag)):
        for k in range(width):
            drag = bodies.drag[i] if k < dimensions else spins.drag[i]
            bodies.diagonal[i, k] = drag / span if span > 0.0 else 0.0
    if width > dimensions:
        fill_quads(step.pairs, step.answers, spins, bodies.position)
        sparse.assemble_quads(step.matrix, spins.quads, bodies.diagonal)
        hold_spins(step.matrix, spins, is_free(step))
    else:
        sparse.assemble(step.matrix, step.answers.stiffness, bodies.diagonal)
    resist_at_walls(step.walls, step.matrix.blocks, step.matrix.pattern.diagonal, dimensions)


@compiled
def is_free(step: Step) -> bool:
    """Whether nothing keeps the spheres from circling each other all together."""
    return not (np.any(step.bodies.drag > 0.0) or np.any(step.cell.sides > 0.0) or len(step.walls.places.place) > 0)


@compiled
def eliminated(step: Step, goal: Goal, loose: int) -> bool:
    """Newton's step by dense elimination."""
    return elimination.eliminate(step.matrix, step.borders.right[:1], step.borders.change[:1], loose)


@compiled
def descended(step: Step, goal: Goal, loose: int) -> bool:
    """Newton's step by biconjugate gradients."""
    right, change = step.borders.right[:1], step.borders.change[:1]
    return gradients.follow_gradients(step.matrix, right, change, step.gradients, loose)


def factorized(step: Step, goal: Goal, loose: int) -> bool:
    """Newton's step by a sparse factorization."""
    return elimination.factorize(step.matrix, step.borders.right[:1], step.borders.change[:1], loose)


def bordered(way: str, step: Step, goal: Goal, loose: int) -> bool:
    """Newton's step with what all spheres share, by one of these ways."""
    boxed = unknowns(step.cell)
    if boxed:
        border(step.cell, web_of(step), goal, step.borders)
    else:
        border_walls(step.walls, goal.drive.load, step.borders, step.bodies.position.shape[1])
    count = boxed or len(step.walls.places.free)
    right, change = step.borders.right[: 1 + count], step.borders.change[: 1 + count]
    if way == "gradients":
        found = gradients.follow_gradients(step.matrix, right, change, step.gradients, loose)
    else:
        solve = elimination.eliminate if way == "dense" else elimination.factorize
        found = solve(step.matrix, right, change, loose)
    answer = close(step.borders, count) if found else None
    if answer is None:
        return False
    if boxed:
        change_box(step.cell, goal, answer)
    else:
        change_walls(step.walls, answer)
    return True


@compiled
def web_of(step: Step) -> Web:
    """What the borders of the system are made of."""
    return Web(step.pairs, step.answers, step.bodies.position)


@compiled
def unmet(step: Step, goal: Goal) -> float:
    """What is missing of the stresses that rule the box, or of the forces on walls."""
    if unknowns(step.cell) > 0:
        return missing_stress(step.cell, web_of(step), goal)
    return missing_at_walls(step.walls, step.bodies.position, goal.drive.load)


@compiled
def enter(step: Step, goal: Goal) -> None:
    """Put in what is imposed, and carry the spheres along with the box."""
    old = step.cell.shape.copy()
    impose(step.cell, goal)
    carry_along(step.cell, old, step.bodies.position)
    place_images(step.pairs, step.cell)


@inlined
def newton_with(solve: Callable[..., bool], contacts: Contacts, step: Step, goal: Goal, fine: float) -> bool:
    """Solve a stage: whether forces and stresses balance and the last change was below `fine`."""
    enter(step, goal)
    bodies, load, span = step.bodies, goal.drive.load, goal.span
    held = np.any(bodies.drag > 0.0) or len(step.walls.places.place) > 0
    loose = 0 if held else bodies.position.shape[1]
    last = math.inf
    for _ in range(MOST_ITERATIONS):
        answer(contacts, step.pairs, step.films, bodies.position, span, step.answers)
        answer_walls(contacts, step.walls, bodies.position, step.spins.turn, span)
        worst, largest, rounding = imbalance(step, load, span, False)
        if last <= fine and worst <= BALANCE * largest + rounding and unmet(step, goal) <= BALANCE:
            return True
        imbalance(step, load, span, True)
        resist(step, span)
        if not solve(step, goal, loose):
            return False
        if step.spins.turn.shape[1] > 0 and is_free(step):
            still(bodies.position, step.spins.radius, bodies.change)
        last = move(step, goal)
        if not math.isfinite(last):
            return False
    return False


@compiled
def newton_dense(contacts: Contacts, step: Step, goal: Goal, fine: float) -> bool:
    """A stage of few spheres."""
    return newton_with(eliminated, contacts, step, goal, fine)


def newton_gradients(contacts: Contacts, step: Step, goal: Goal, fine: float) -> bool:
    """A stage of many spheres. Each pass over them is compiled by itself: all in one took ten times as long, since
    arrays that are reached through tuples are then counted in the inner loops.
    """
    return plainly(newton_with)(descended, contacts, step, goal, fine)


def newton_direct(contacts: Contacts, step: Step, goal: Goal, fine: float) -> bool:
    """A stage of many spheres, however stiff."""
    return plainly(newton_with)(factorized, contacts, step, goal, fine)


def newton_bordered(way: str, contacts: Contacts, step: Step, goal: Goal, fine: float) -> bool:
    """A stage whose box answers to stresses."""
    return plainly(newton_with)(partial(bordered, way), contacts, step, goal, fine)
