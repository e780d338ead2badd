"""A step of time: implicit stages, each solved by Newton's method for all spheres and contacts at once."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside, inlined, plainly
from ecume.engine import elimination, gradients, sparse
from ecume.engine.gradients import Gradients
from ecume.engine.sparse import Matrix
from ecume.models.soft.borders import (
    Borders,
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
    STRAIN,
    WIDTH,
    Cell,
    Goal,
    begin_cell,
    carry_along,
    cell_error,
    deform,
    end_cell,
    first_cell,
    flow,
    impose,
    place_images,
)
from ecume.models.soft.films import Answers, Films, Pairs, answer, center_distance
from ecume.models.soft.parameters import Contacts
from ecume.models.soft.protocol import Drive
from ecume.models.soft.schemes import Scheme
from ecume.models.soft.spins import (
    Spins,
    add_torques,
    begin_spins,
    carry,
    end_spins,
    fill_quads,
    hold_spins,
    load_torques,
    rolled,
    still,
    turn_pairs,
)
from ecume.models.soft.walls import (
    Walls,
    accept_walls,
    answer_walls,
    begin_walls,
    end_walls,
    first_walls,
    missing_at_walls,
    move_walls,
    push_from_walls,
    resist_at_walls,
    shift_at_walls,
    wall_error,
)
from ecume.units import Array

MOST_ITERATIONS = 12
BALANCE = 1e-9
"""The largest force that may be left on a sphere, over the largest there is."""
LONGEST_CHANGE = 0.7
"""Of ln(gap) in one iteration: beyond it the linear answer means nothing, and the update is shortened."""
ROUNDING = 2e-15
"""What rounding leaves of a force, over stiffness times coordinates."""
FAILED = -1.0


class Bodies(NamedTuple):
    """The spheres in a step."""

    position: Array
    """(N, d) m, of the stage"""
    before: Array
    """(N, d) at the step's beginning"""
    start: Array
    """(N, d) where the stage starts from; means something with drag only"""
    slope: Array
    """(S, N, d) m/s of the stages, with drag only"""
    drag: Array
    """(N,) N s/m"""
    force: Array
    """(N, d) N external, at factor 1"""
    weight: Array
    """(N, d) N external, always"""
    right: Array
    """(N, d + s) N that is left on each, and at its equator"""
    change: Array
    """(N, d + s) m, of places and of spins"""
    diagonal: Array
    """(N, d + s) N/m"""


class During(NamedTuple):
    """What a step is to do."""

    length: float
    """s"""
    drives: Array
    """(S, 9) what is imposed at each stage, as the fields of a `Drive`"""
    tolerance: float


class Step(NamedTuple):
    """All that a step works with."""

    pairs: Pairs
    films: Films
    answers: Answers
    slope: Array
    """(S, C, 4) of the stages"""
    log_gap: Array
    direction: Array
    """where the contacts are at the step's beginning"""
    bodies: Bodies
    spins: Spins
    walls: Walls
    matrix: Matrix
    cell: Cell
    borders: Borders
    gradients: Gradients


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


@compiled
def begin_stage(step: Step, scheme: Scheme, stage: int, time_step: float) -> None:
    """Where a stage starts from: the beginning, and the slopes of the stages before."""
    films, slope, bodies = step.films, step.slope, step.bodies
    log_gap, direction, rows = step.log_gap, step.direction, scheme.rows
    for c in range(len(log_gap)):
        films.log_gap_start[c] = log_gap[c]
        for k in range(3):
            films.direction_start[c, k] = direction[c, k]
        for earlier in range(stage):
            weight = time_step * rows[stage, earlier]
            films.log_gap_start[c] += weight * slope[earlier, c, 0]
            for k in range(3):
                films.direction_start[c, k] += weight * slope[earlier, c, 1 + k]
    for i in range(len(bodies.drag)):
        if bodies.drag[i] > 0.0:
            for k in range(bodies.start.shape[1]):
                value = bodies.before[i, k]
                for earlier in range(stage):
                    value += time_step * rows[stage, earlier] * bodies.slope[earlier, i, k]
                bodies.start[i, k] = value
    begin_spins(step.spins, rows[stage, :stage], time_step)
    begin_cell(step.cell, scheme, stage, time_step)
    begin_walls(step.walls, scheme, stage, time_step)


@compiled
def end_stage(step: Step, goal: Goal, stage: int) -> None:
    """The slopes of a solved stage, from what it added to its start: nothing is amplified so."""
    films, slope, bodies, span = step.films, step.slope, step.bodies, goal.span
    end_cell(step.cell, goal, stage)
    end_walls(step.walls, stage, span)
    for c in range(len(step.log_gap)):
        slope[stage, c, 0] = (films.log_gap[c] - films.log_gap_start[c]) / span
        lean = 0.0
        for k in range(3):
            lean += films.direction[c, k] * films.direction_start[c, k]
        for k in range(3):
            slope[stage, c, 1 + k] = (lean * films.direction[c, k] - films.direction_start[c, k]) / span
    for i in range(len(bodies.drag)):
        if bodies.drag[i] > 0.0:
            for k in range(bodies.start.shape[1]):
                bodies.slope[stage, i, k] = (bodies.position[i, k] - bodies.start[i, k]) / span
    end_spins(step.spins, stage, span)


@compiled
def afloat(cell: Cell, position: Array, i: int, k: int) -> float:
    """How fast the box's deformation carries the liquid at a sphere, at the step's beginning."""
    slope = cell.slope[0]
    speed = slope[WIDTH + k] * position[i, k]
    return float(speed + slope[STRAIN] * position[i, 1] if k == 0 else speed)


@compiled
def first_stage(contacts: Contacts, step: Step, drive: Drive) -> None:
    """The slopes at the step's beginning."""
    films, bodies, slope = step.films, step.bodies, step.slope
    films.log_gap[:] = step.log_gap
    films.direction[:] = step.direction
    films.log_gap_start[:] = step.log_gap
    films.direction_start[:] = step.direction
    bodies.position[:] = bodies.before
    step.spins.turn[:] = 0.0
    step.spins.start[:] = 0.0
    turn_pairs(step.pairs, step.spins)
    first_cell(step.cell, drive)
    first_walls(step.walls)
    place_images(step.pairs, step.cell)
    answer(contacts, step.pairs, films, bodies.position, 0.0, step.answers)
    answer_walls(contacts, step.walls, bodies.position, step.spins.turn, 0.0)
    slope[0] = step.answers.slope
    step.walls.touches.rate[0] = step.walls.touches.now
    bodies.start[:] = bodies.position
    imbalance(step, drive.load, 1.0, False)
    for i in range(len(bodies.drag)):
        if bodies.drag[i] > 0.0:
            for k in range(bodies.start.shape[1]):
                bodies.slope[0, i, k] = bodies.right[i, k] / bodies.drag[i] + afloat(step.cell, bodies.position, i, k)
    first_spins(step)


@compiled
def first_spins(step: Step) -> None:
    """How fast spheres spin at the step's beginning, where drag tells: with half the vorticity of the liquid."""
    spins, right, dimensions = step.spins, step.bodies.right, step.bodies.position.shape[1]
    for i in range(len(spins.drag)):
        for k in range(spins.turn.shape[1]):
            spins.slope[0, i, k] = right[i, dimensions + k] / spins.drag[i] if spins.drag[i] > 0.0 else 0.0
        if spins.turn.shape[1] > 0:
            spins.slope[0, i, spins.turn.shape[1] - 1] -= 0.5 * step.cell.slope[0, STRAIN] * spins.radius[i]


@compiled
def error_of(step: Step, scheme: Scheme, time_step: float) -> float:
    """The largest difference from the embedded scheme, of ln(gap) or of a direction."""
    slope, weights = step.slope, scheme.error
    largest = 0.0
    for c in range(slope.shape[1]):
        for k in range(4):
            value = 0.0
            for stage in range(len(weights)):
                value += weights[stage] * slope[stage, c, k]
            largest = max(largest, abs(time_step * value))
    return largest


@compiled_inside
def drive_of(row: Array) -> Drive:
    """What is imposed, from the numbers of one stage."""
    return Drive(row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8])


@inlined
def attempt_with(newton: Callable[..., bool], contacts: Contacts, step: Step, scheme: Scheme, during: During) -> float:
    """Try a step: the estimated error, or FAILED.

    The new places are in `step.films` and `step.bodies.position`.
    """
    span = scheme.diagonal * during.length
    origin = drive_of(during.drives[0])
    first_stage(contacts, step, origin)
    for stage in range(1, len(scheme.times)):
        begin_stage(step, scheme, stage, during.length)
        goal = Goal(drive_of(during.drives[stage]), origin, span)
        if not newton(contacts, step, goal, 1e-3 * during.tolerance):
            return FAILED
        end_stage(step, goal, stage)
    of_walls = wall_error(step.walls, scheme, during.length)
    return max(error_of(step, scheme, during.length), cell_error(step.cell, scheme, during.length), of_walls)


@compiled
def attempt_dense(contacts: Contacts, step: Step, scheme: Scheme, during: During) -> float:
    """A step of few spheres."""
    return attempt_with(newton_dense, contacts, step, scheme, during)


def attempt_gradients(contacts: Contacts, step: Step, scheme: Scheme, during: During) -> float:
    """A step of many spheres."""
    return plainly(attempt_with)(newton_gradients, contacts, step, scheme, during)


def attempt_direct(contacts: Contacts, step: Step, scheme: Scheme, during: During) -> float:
    """A step of many spheres, however stiff."""
    return plainly(attempt_with)(newton_direct, contacts, step, scheme, during)


def attempt_bordered(way: str, contacts: Contacts, step: Step, scheme: Scheme, during: During) -> float:
    """A step whose box answers to stresses."""
    return plainly(attempt_with)(partial(newton_bordered, way), contacts, step, scheme, during)


@compiled
def accept(step: Step) -> None:
    """The end of a step is the next one's beginning."""
    carry(step.pairs, step.films.direction)
    accept_walls(step.walls, step.spins.turn)
    step.log_gap[:] = step.films.log_gap
    step.direction[:] = step.films.direction
    step.bodies.before[:] = step.bodies.position
    step.cell.before[:] = step.cell.shape
    step.cell.past[:] = step.cell.slope[-1, :5]
