"""Newton's method for a stage: one system for all spheres, contacts, spins, walls and the box.

The right side is the residual force on each sphere, the matrix its negative derivative.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from ecume._jit import compiled, compiled_inside, composed, inlined, plainly, prange, shared
from ecume.engine.cells import Integers
from ecume.engine.linear_solvers import block_matrix
from ecume.engine.linear_solvers.block_matrix import Matrix, Pattern
from ecume.models.soft.cell import (
    StageTarget,
    deform,
    deform_positions,
    flow_gradient,
    gradient_of,
    impose,
    largest_strain,
    place_images,
    transformed,
    unknowns,
)
from ecume.models.soft.contacts.contact import ROUNDING
from ecume.models.soft.contacts.films import ContactResponses, Films, Pairs, center_distance, contact_response
from ecume.models.soft.contacts.rotation import (
    Spins,
    add_torques,
    fill_pair_blocks,
    fill_rotation_sides,
    load_torques,
    regularize_spins,
    remove_free_rotation,
    rolled,
    turn_pairs,
)
from ecume.models.soft.contacts.walls import (
    add_wall_forces,
    add_wall_stiffness,
    all_walls,
    move_walls,
    shift_at_walls,
    wall_force_residual,
    wall_response,
)
from ecume.models.soft.integration.bordered_system import (
    ContactNetwork,
    DragTerms,
    border_solution,
    box_stress_residual,
    change_box,
    change_walls,
    fill_all_borders,
    fill_wall_borders,
)
from ecume.models.soft.parameters import Contacts
from ecume.models.soft.permeation import (
    add_seepage,
    change_layers,
    fill_layer_borders,
    flow_residual,
    layer_unknowns,
    move_layers,
    permeation_response,
)
from ecume.models.soft.state import Bodies, Step
from ecume.units import Array

CHUNK = 256
"""Spheres or contacts per task of a thread."""


def count_pairs(pairs: Pairs, *_: object) -> int:
    """The number of contacts, for the choice between serial and threaded loops."""
    return len(pairs.first)


@composed
def imbalance(step: Step, factor: float, span: float, corrected: bool) -> tuple[float, float, float]:
    """Write the residual force on each sphere into `right`. Returns the largest residual, the largest force, and an
    upper bound of the rounding error.
    """
    right, position, along = step.bodies.right, step.bodies.position, flow_gradient(step.cell)
    load_torques(step.spins, right, factor, (span, -0.5 * along[0, 1]))
    given = (factor, span, 1.0 if corrected else 0.0, largest_strain(step.cell))
    largest, stiffest = sum_forces(step.pairs, step.responses, step.matrix.pattern, step.bodies, along, given)
    most, firmest = add_wall_forces(step.walls, position, right, corrected)
    pushed = add_seepage(step.permeation, right)
    if right.shape[1] > position.shape[1]:
        add_torques(step.pairs, step.responses, position, right, corrected)
    return largest_of(right), float(max(largest, most, pushed)), float(ROUNDING * max(stiffest, firmest))


@compiled
def largest_of(right: Array) -> float:
    """The largest magnitude in an array."""
    worst = 0.0
    for i in range(right.shape[0]):
        for k in range(right.shape[1]):
            worst = max(worst, abs(right[i, k]))
    return worst


@shared(count_pairs)
def sum_forces(
    pairs: Pairs,
    responses: ContactResponses,
    pattern: Pattern,
    bodies: Bodies,
    along: Array,
    given: tuple[float, float, float, float],
) -> tuple[float, float]:
    """Write the sum of external forces, drag and contact forces on each sphere into `right`. Returns the largest force,
    and the largest product of stiffness and coordinate.

    `given` contains the factor of external forces, the time span of the stage, the factor of the corrections, and the
    strain of a stress-controlled box.
    """
    right, position, count = bodies.right, bodies.position, len(bodies.drag)
    first_link, link, second = pattern.first_link, pattern.link, pairs.second
    radius_sum, offset = pairs.radius_sum, pairs.offset
    force, correction, stiffness = responses.force, responses.correction, responses.stiffness
    chunks = (count + CHUNK - 1) // CHUNK
    extremes = np.zeros((chunks, 2))
    for chunk in prange(chunks):
        network, reactions = ((first_link, link), (second, radius_sum, offset)), (force, correction, stiffness)
        for i in range(chunk * CHUNK, min((chunk + 1) * CHUNK, count)):
            most, firmest = set_external_forces(bodies, right, i, along, (given[0], given[1], given[3]))
            extremes[chunk, 0], extremes[chunk, 1] = max(extremes[chunk, 0], most), max(extremes[chunk, 1], firmest)
            most, firmest = add_contact_forces(network, reactions, (position, right), i, given[2])
            extremes[chunk, 0], extremes[chunk, 1] = max(extremes[chunk, 0], most), max(extremes[chunk, 1], firmest)
    largest, stiffest = 0.0, 0.0
    for chunk in range(chunks):
        largest, stiffest = max(largest, extremes[chunk, 0]), max(stiffest, extremes[chunk, 1])
    return largest, stiffest


@compiled_inside
def set_external_forces(
    bodies: Bodies, right: Array, i: int, along: Array, during: tuple[float, float, float]
) -> tuple[float, float]:
    """Write external force and drag on a sphere into `right`. Returns the largest force, and the largest product of
    stiffness and coordinate.
    """
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
            # The rounding error of the strain term is that of the strain of the box, not that of its change.
            size = max(abs(moved[i, k]), abs(carried), strain * abs(position[i, k]))
            stiffest = max(stiffest, drag[i] / span * size)
    return largest, stiffest


@compiled_inside
def add_contact_forces(
    network: tuple[tuple[Integers, Integers], tuple[Integers, Array, Array]],
    reactions: tuple[Array, Array, Array],
    bodies: tuple[Array, Array],
    i: int,
    corrected: float,
) -> tuple[float, float]:
    """Add the forces of the contacts of a sphere, in their order. Returns the largest force, and the largest product of
    stiffness and coordinate, of the contacts whose first sphere it is.
    """
    ((first_link, link), (second, radius_sum, offset)), (force, correction, stiffness) = network, reactions
    position, right = bodies
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
def assemble_jacobian(step: Step, span: float) -> None:
    """Assemble the matrix of Newton's method: the negative derivative of forces by displacements."""
    bodies, spins, pattern, numbers = step.bodies, step.spins, step.matrix.pattern, step.matrix.blocks
    dimensions, width = bodies.position.shape[1], bodies.diagonal.shape[1]
    set_diagonal(bodies, spins, span)
    if width > dimensions:
        fill_pair_blocks(step.pairs, step.responses, spins, bodies.position)
        block_matrix.assemble_pair_blocks(step.matrix, spins.pair_blocks, bodies.diagonal)
    else:
        fill_matrix(pattern, numbers, step.responses.stiffness, bodies.diagonal)
    add_wall_stiffness(step.walls, numbers, pattern.diagonal, dimensions)
    if width > dimensions:
        regularize_spins(step.matrix, spins, rotates_freely(step))
        fill_rotation_sides(step.matrix, spins, step.borders.right)


@compiled
def set_diagonal(bodies: Bodies, spins: Spins, span: float) -> None:
    """Set the diagonal of the matrix to the drag of the liquid, the anchors of free pieces, and the stiffness of
    glue.
    """
    dimensions = bodies.position.shape[1]
    for i in range(len(bodies.drag)):
        for k in range(bodies.diagonal.shape[1]):
            drag, held = (bodies.drag[i], bodies.anchor[i])
            if k >= dimensions:
                drag, held = (spins.drag[i], bodies.spin_anchor[i] + spins.held[i])
            bodies.diagonal[i, k] = held + (drag / span if span > 0.0 else 0.0)


def count_links(pattern: Pattern, *_: object) -> int:
    """The number of contacts, for the choice between serial and threaded loops."""
    return len(pattern.upper)


@shared(count_links)
def fill_matrix(pattern: Pattern, numbers: Array, stiffness: Array, diagonal: Array) -> None:
    """Fill the matrix rows of all spheres."""
    for i in prange(len(diagonal)):
        block_matrix.fill_row(pattern, numbers, stiffness, diagonal, i)


@composed
def rotates_freely(step: Step) -> bool:
    """Whether the spheres can rotate together without resistance."""
    sides = step.cell.sides
    return not (is_anchored(step) or sides[0] > 0.0 or sides[1] > 0.0 or sides[2] > 0.0)


@composed
def is_anchored(step: Step) -> bool:
    """Whether walls, or the drag or anchors of some spheres, prevent a common translation."""
    bodies = step.bodies
    return len(step.walls) > 0 or largest_value(bodies.drag) > 0.0 or largest_value(bodies.anchor) > 0.0


@compiled
def largest_value(values: Array) -> float:
    """The largest value of an array, or zero if it is empty or negative."""
    largest = 0.0
    for i in range(len(values)):
        largest = max(largest, values[i])
    return largest


MOST_ITERATIONS = 24
"""The largest number of iterations. Where films and surfaces change their regime, the first ten to fifteen iterations
find the regime.
"""
BALANCE = 1e-9
"""The largest permitted residual force over the largest force; also that of stresses."""
CLOSE, LIKELY = 1e-10, 0.1
"""Newton's method continues while it halves the residual, until it falls below CLOSE times the largest force plus
LIKELY times an upper bound of the rounding error.
"""

Solve = Callable[[Matrix, Array, Array, int], bool]
"""A solver of `engine.linear_solvers`, with its stored factorization bound."""


@composed
def sides(step: Step) -> int:
    """The number of right-hand sides: the residual, and one for each rotation of freely rotating spheres."""
    return 1 + (step.spins.turn.shape[1] if rotates_freely(step) else 0)


@compiled
def solve_dense(step: Step, goal: StageTarget, null_space_dimension: int) -> bool:
    """Compute Newton's step by dense elimination."""
    several = sides(step)
    return block_matrix.eliminate(
        step.matrix, step.borders.right[:several], step.borders.change[:several], null_space_dimension
    )


def solve_plain(solve: Solve, step: Step, goal: StageTarget, null_space_dimension: int) -> bool:
    """Compute Newton's step where the box and walls have no unknowns."""
    several = sides(step)
    return solve(step.matrix, step.borders.right[:several], step.borders.change[:several], null_space_dimension)


def solve_bordered(solve: Solve, step: Step, goal: StageTarget, null_space_dimension: int) -> bool:
    """Compute Newton's step with unknowns of the box or of walls."""
    count = fill_borders(step, goal)
    if count == 0:
        return solve_plain(solve, step, goal, null_space_dimension)
    found = solve(step.matrix, step.borders.right[: 1 + count], step.borders.change[: 1 + count], null_space_dimension)
    return found and solve_borders(step, goal, count)


def fill_borders(step: Step, goal: StageTarget) -> int:
    """Fill the borders of the system for the unknowns of the box or of walls. Returns their number."""
    walls, bodies, spins = all_walls(step.walls), step.bodies, step.spins
    if count := unknowns(step.cell):
        dragged = DragTerms(bodies.position, bodies.drag, spins.drag, spins.radius)
        fill_all_borders(step.cell, network_of(step), dragged, goal, step.borders)
        return int(count)
    fill_wall_borders(walls, (goal.drive.load, goal.drive.wall_shear), step.borders, bodies.position.shape[1])
    if step.permeation:
        fill_layer_borders(step.permeation, walls.places, bodies.moved, goal.span, step.borders)
    return len(walls.places.free) + layer_unknowns(step.permeation)


def solve_borders(step: Step, goal: StageTarget, count: int) -> bool:
    """Solve for the unknowns of the box or walls, and correct the displacements of spheres. Returns False without a
    solution.
    """
    change = border_solution(step.borders, count)
    if change is None:
        return False
    if unknowns(step.cell):
        change_box(step.cell, goal, change)
    else:
        count = len(all_walls(step.walls).places.free)
        change_walls(all_walls(step.walls), change[:count])
        if step.permeation:
            change_layers(step.permeation, change[count:])
    return True


@composed
def network_of(step: Step) -> ContactNetwork:
    """The contacts of a step, as needed for the borders of the system."""
    return ContactNetwork(step.pairs, step.responses, step.bodies.position)


@composed
def stress_residual(step: Step, goal: StageTarget) -> float:
    """The relative residual of the stresses that control the box, or of the forces on walls."""
    if unknowns(step.cell) > 0:
        return box_stress_residual(step.cell, network_of(step), goal)
    load = (goal.drive.load, goal.drive.wall_shear)
    flow = BALANCE * float(flow_residual(step.permeation, step.walls, step.bodies.moved, goal.span))
    return max(float(wall_force_residual(step.walls, step.bodies.position, load)), flow)


@composed
def apply_drive(step: Step, goal: StageTarget) -> None:
    """Impose the drive on the box, and displace the spheres with it."""
    old = step.cell.shape.copy()
    impose(step.cell, goal)
    deform_positions(step.cell, old, step.bodies.position, step.bodies.moved)
    place_images(step.pairs, step.cell)


@composed
def zero_residual(step: Step, goal: StageTarget) -> float:
    """The residual of the stresses where no stress is controlled: zero."""
    return 0.0


@inlined
def newton_with(
    solve: Callable[..., bool], residual: Callable[..., float], contacts: Contacts, step: Step, goal: StageTarget
) -> bool:
    """Solve a stage by Newton's method. Returns whether forces and stresses balance and the last change was small
    enough.
    """
    apply_drive(step, goal)
    bodies, load, span = step.bodies, goal.drive.load, goal.span
    null_space_dimension = 0 if is_anchored(step) else bodies.position.shape[1]
    last, before = math.inf, math.inf
    for _ in range(MOST_ITERATIONS):
        contact_response(contacts, step.pairs, step.films, bodies.position, span, step.responses)
        wall_response(step.walls, contacts, bodies.position, step.spins.turn, span)
        permeation_response(step.permeation, step.walls, bodies.position)
        worst, largest, rounding = imbalance(step, load, span, False)
        done = worst <= CLOSE * largest + LIKELY * rounding or worst > 0.5 * before
        balanced = done and worst <= BALANCE * largest + rounding
        if last <= goal.fine and balanced and residual(step, goal) <= BALANCE:
            return True
        before = worst
        imbalance(step, load, span, True)
        assemble_jacobian(step, span)
        if not solve(step, goal, null_space_dimension):
            return False
        if step.spins.turn.shape[1] > 0 and rotates_freely(step):
            remove_free_rotation(bodies.position, step.spins, step.borders.change, (bodies.force, bodies.weight, load))
        last = move(step, goal)
        if not math.isfinite(last):
            return False
    return False


@compiled
def newton_dense(contacts: Contacts, step: Step, goal: StageTarget) -> bool:
    """Solve a stage of few spheres."""
    return newton_with(solve_dense, zero_residual, contacts, step, goal)


def newton_many(solve: Solve, contacts: Contacts, step: Step, goal: StageTarget) -> bool:
    """Solve a stage of many spheres. Each loop over them is compiled separately: a single function for all took ten
    times as long, since references to arrays in tuples are then counted in the inner loops.
    """
    return plainly(newton_with)(partial(solve_plain, solve), zero_residual, contacts, step, goal)


def newton_bordered(solve: Solve, contacts: Contacts, step: Step, goal: StageTarget) -> bool:
    """Solve a stage with a stress-controlled box, with walls that forces move, or with permeating liquid."""
    return plainly(newton_with)(partial(solve_bordered, solve), stress_residual, contacts, step, goal)


def balance_borders(contacts: Contacts, step: Step, goal: StageTarget) -> bool:
    """Balance the stresses of the box or the forces on walls in zero time.

    Drag prevents any motion of the spheres relative to the liquid: they move with the box, and spin with half of its
    vorticity. The residual forces move them in the next steps.
    """
    apply_drive(step, goal)
    bodies, spins, change, last = step.bodies, step.spins, step.borders.change, math.inf
    spins.turn[:, -1:] -= 0.5 * flow_gradient(step.cell)[0, 1] * spins.radius[:, None]
    turn_pairs(step.pairs, spins.turn)
    for _ in range(MOST_ITERATIONS):
        contact_response(contacts, step.pairs, step.films, bodies.position, 0.0, step.responses)
        wall_response(step.walls, contacts, bodies.position, spins.turn, 0.0)
        count, change[:] = fill_borders(step, goal), 0.0
        if count == 0 or (last <= goal.fine and stress_residual(step, goal) <= BALANCE):
            bodies.right[:] = 0.0
            return True
        for unknown in range(unknowns(step.cell) * (spins.turn.shape[1] > 0)):
            swirl = -0.5 * gradient_of(step.cell, unknown, goal, False)[0, 1]
            change[1 + unknown, :, -1] = swirl * spins.radius
        if not solve_borders(step, goal, count):
            return False
        last = move(step, goal)
    return False


# --- Update by Newton's step, damped where it is outside the validity of the linearization


LONGEST_CHANGE = 0.7
"""The largest change of ln(gap) in one iteration. Larger ones are outside the validity of the linearization, and the
step is shortened.
"""


@composed
def move(step: Step, goal: StageTarget) -> float:
    """Add Newton's step to box, spheres, walls and contacts, shortened if it is too long. Returns its largest
    component.
    """
    bodies, films, responses, by = step.bodies, step.films, step.responses, step.cell.change
    largest = shift_contacts(step.pairs, responses, bodies, by)
    largest = max(largest, largest_change(by, bodies.change, bodies.position.shape[1], step.spins.radius))
    largest = max(largest, shift_at_walls(step.walls, bodies.change, bodies.position.shape[1]))
    if not math.isfinite(largest):
        return math.inf
    part = min(1.0, LONGEST_CHANGE / max(largest, 1e-300))
    displace(bodies, step.spins.turn, by, part)
    turn_pairs(step.pairs, step.spins.turn)
    deform(step.cell, goal, part)
    move_walls(step.walls, part)
    move_layers(step.permeation, part)
    place_images(step.pairs, step.cell)
    move_contacts(films, responses, part)
    return float(largest)


@shared(count_pairs)
def shift_contacts(pairs: Pairs, responses: ContactResponses, bodies: Bodies, by: Array) -> float:
    """Compute the changes of ln(gap) and direction that follow from Newton's step. Returns the largest."""
    first, second, offset, radius_sum = pairs.first, pairs.second, pairs.offset, pairs.radius_sum
    position, change, shift, response = bodies.position, bodies.change, responses.shift, responses.response
    count, dimensions = len(first), position.shape[1]
    extremes = np.zeros((count + CHUNK - 1) // CHUNK)
    for chunk in prange(len(extremes)):
        largest = 0.0
        for c in range(chunk * CHUNK, min((chunk + 1) * CHUNK, count)):
            x = center_distance(position, offset, first[c], second[c], c)
            u, v = rolled(x, radius_sum[c], (first[c], second[c]), change, dimensions), transformed(by, x)
            u = (u[0] + v[0], u[1] + v[1], u[2] + v[2])
            for k in range(4):
                shift[c, k] += response[c, k, 0] * u[0] + response[c, k, 1] * u[1] + response[c, k, 2] * u[2]
                largest = max(largest, abs(shift[c, k]))
        extremes[chunk] = largest
    return largest_value(extremes)


def count_films(films: Films, *_: object) -> int:
    """The number of contacts, for the choice between serial and threaded loops."""
    return len(films.log_gap)


@shared(count_films)
def move_contacts(films: Films, responses: ContactResponses, part: float) -> None:
    """Add a fraction of the computed changes to ln(gap) and direction of all contacts."""
    log_gap, direction, shift = films.log_gap, films.direction, responses.shift
    for c in prange(len(log_gap)):
        move_contact(log_gap, direction, shift, part, c)


@compiled_inside
def move_contact(log_gap: Array, direction: Array, shift: Array, part: float, c: int) -> None:
    """Add a fraction of the computed changes to a contact, and normalize its direction."""
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
    """The largest relative change of the box and the largest rotation of a sphere (rad) in Newton's step."""
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
    """Add a fraction of Newton's step to positions and spins."""
    position, change, dimensions = bodies.position, bodies.change, bodies.position.shape[1]
    moved_by = bodies.moved
    for i in range(len(position)):
        x = transformed(by, (position[i, 0], position[i, 1], position[i, 2] if dimensions == 3 else 0.0))
        for k in range(dimensions):
            position[i, k] += part * (change[i, k] + x[k])
            moved_by[i, k] += part * (change[i, k] + x[k])
        for k in range(turn.shape[1]):
            turn[i, k] += part * change[i, dimensions + k]
