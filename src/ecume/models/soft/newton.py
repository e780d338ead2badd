"""Newton's method for a stage: all spheres, contacts, spins, walls and the box at once."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from ecume._jit import compiled, composed, inlined, plainly
from ecume.engine import elimination
from ecume.engine.blocks import Matrix
from ecume.models.soft.borders import (
    Web,
    border,
    border_walls,
    change_box,
    change_walls,
    close,
    missing_stress,
)
from ecume.models.soft.cell import Goal, carry_along, impose, place_images, unknowns
from ecume.models.soft.films import answer
from ecume.models.soft.moving import move
from ecume.models.soft.parameters import Contacts
from ecume.models.soft.pulling import imbalance, is_free, is_held, resist
from ecume.models.soft.step import Step
from ecume.models.soft.turning import unturn
from ecume.models.soft.wall_borders import missing_at_walls
from ecume.models.soft.walls import all_walls, answer_walls
from ecume.units import Array

MOST_ITERATIONS = 12
BALANCE = 1e-9
"""The largest force that may be left on a sphere, over the largest there is, or what may be missing of a stress."""
CLOSE, LIKELY = 1e-10, 0.1
"""What is left is made less for as long as that halves it, down to this part of the largest force and of what rounding
may leave: that is told from above.
"""

Solve = Callable[[Matrix, Array, Array, int], bool]
"""A solver of `engine.sparse` with what it keeps."""


@composed
def sides(step: Step) -> int:
    """How many right sides there are: what is left over, and what turns the first of free spheres."""
    return 1 + (step.spins.turn.shape[1] if is_free(step) else 0)


@compiled
def eliminated(step: Step, goal: Goal, loose: int) -> bool:
    """Newton's step by dense elimination."""
    several = sides(step)
    return elimination.eliminate(step.matrix, step.borders.right[:several], step.borders.change[:several], loose)


def plain(solve: Solve, step: Step, goal: Goal, loose: int) -> bool:
    """Newton's step, where spheres have nothing in common but their contacts."""
    several = sides(step)
    return solve(step.matrix, step.borders.right[:several], step.borders.change[:several], loose)


def bordered(solve: Solve, step: Step, goal: Goal, loose: int) -> bool:
    """Newton's step with what all spheres share."""
    boxed, walls = unknowns(step.cell), all_walls(step.walls)
    if boxed:
        border(step.cell, web_of(step), goal, step.borders)
    else:
        border_walls(walls, (goal.drive.load, goal.drive.wall_shear), step.borders, step.bodies.position.shape[1])
    count = boxed or len(walls.places.free)
    found = solve(step.matrix, step.borders.right[: 1 + count], step.borders.change[: 1 + count], loose)
    answer = close(step.borders, count) if found else None
    if answer is None:
        return False
    if boxed:
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
    load = (goal.drive.load, goal.drive.wall_shear)
    return float(missing_at_walls(step.walls, step.bodies.position, load))


@composed
def enter(step: Step, goal: Goal) -> None:
    """Put in what is imposed, and carry the spheres along with the box."""
    old = step.cell.shape.copy()
    impose(step.cell, goal)
    carry_along(step.cell, old, step.bodies.position, step.bodies.moved)
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
    last, before = math.inf, math.inf
    for _ in range(MOST_ITERATIONS):
        answer(contacts, step.pairs, step.films, bodies.position, span, step.answers)
        answer_walls(step.walls, contacts, bodies.position, step.spins.turn, span)
        worst, largest, rounding = imbalance(step, load, span, False)
        done = worst <= CLOSE * largest + LIKELY * rounding or worst > 0.5 * before
        balanced = done and worst <= BALANCE * largest + rounding
        if last <= goal.fine and balanced and missing(step, goal) <= BALANCE:
            return True
        before = worst
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


def newton_many(solve: Solve, contacts: Contacts, step: Step, goal: Goal) -> bool:
    """A stage of many spheres. Each pass over them is compiled by itself: all in one took ten times as long, since
    arrays that are reached through tuples are then counted in the inner loops.
    """
    return plainly(newton_with)(partial(plain, solve), met, contacts, step, goal)


def newton_bordered(solve: Solve, contacts: Contacts, step: Step, goal: Goal) -> bool:
    """A stage whose box answers to stresses, or whose walls yield to forces."""
    return plainly(newton_with)(partial(bordered, solve), unmet, contacts, step, goal)
