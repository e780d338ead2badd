"""One time step: the successive implicit stages of a DIRK scheme, and its error estimate."""

from __future__ import annotations

from collections.abc import Callable

from ecume._jit import compiled, compiled_inside, composed, inlined, plainly
from ecume.engine.array_copies import clear_rows, copy_line, copy_rows
from ecume.models.soft.cell import (
    STRAIN,
    WIDTH,
    Cell,
    StageTarget,
    begin_cell,
    cell_error,
    end_cell,
    first_cell,
    place_images,
)
from ecume.models.soft.contacts.films import contact_response
from ecume.models.soft.contacts.rotation import begin_spins, carry, end_spins, turn_pairs
from ecume.models.soft.contacts.walls import (
    accept_walls,
    begin_walls,
    end_walls,
    first_walls,
    slopes_at_walls,
    wall_error,
    wall_response,
)
from ecume.models.soft.integration.dirk_schemes import Scheme
from ecume.models.soft.integration.newton import imbalance, newton_dense
from ecume.models.soft.parameters import Contacts
from ecume.models.soft.protocol import Drive
from ecume.models.soft.report.energy_budget import add_stage
from ecume.models.soft.state import Step, StepRequest
from ecume.units import Array

FAILED = -1.0
BEGIN, BALANCE, STEP = range(3)
"""Tasks of a solver: compute the rates at the start of a step, find the positions where forces and stresses balance at
constant gaps, or compute a step.
"""


@compiled
def begin_stage(step: Step, scheme: Scheme, stage: int, time_step: float) -> None:
    """Set the start of a stage, from the start of the step and the slopes of the stages before."""
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
                value = 0.0
                for earlier in range(stage):
                    value += time_step * rows[stage, earlier] * bodies.slope[earlier, i, k]
                bodies.start[i, k] = value
    begin_spins(step.spins, rows[stage, :stage], time_step)
    begin_cell(step.cell, scheme, stage, time_step)
    begin_walls(step.walls, scheme, stage, time_step)


@compiled
def end_stage(step: Step, goal: StageTarget, stage: int) -> None:
    """Compute the slopes of a solved stage from its difference to its start, which does not amplify rounding errors."""
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
                bodies.slope[stage, i, k] = (bodies.moved[i, k] - bodies.start[i, k]) / span
    end_spins(step.spins, stage, span)


@compiled
def background_velocity(cell: Cell, position: Array, i: int, k: int) -> float:
    """A component of the velocity of the liquid at a sphere, from the deformation rate of the box at the start of the
    step.
    """
    slope = cell.slope[0]
    speed = slope[WIDTH + k] * position[i, k]
    return float(speed + slope[STRAIN] * position[i, 1] if k == 0 else speed)


@composed
def first_stage(contacts: Contacts, step: Step, drive: Drive) -> None:
    """Compute the slopes at the start of the step."""
    reset_to_start(step, drive)
    contact_response(contacts, step.pairs, step.films, step.bodies.position, 0.0, step.responses)
    wall_response(step.walls, contacts, step.bodies.position, step.spins.turn, 0.0)
    imbalance(step, drive.load, 1.0, False)
    first_slopes(step)


@compiled
def reset_to_start(step: Step, drive: Drive) -> None:
    """Reset all positions to the start of the step."""
    films, bodies = step.films, step.bodies
    copy_line(films.log_gap, step.log_gap)
    copy_rows(films.direction, step.direction)
    copy_line(films.log_gap_start, step.log_gap)
    copy_rows(films.direction_start, step.direction)
    copy_rows(bodies.position, bodies.before)
    clear_rows(bodies.moved)
    clear_rows(bodies.start)
    clear_rows(step.spins.turn)
    clear_rows(step.spins.start)
    turn_pairs(step.pairs, step.spins)
    first_cell(step.cell, drive)
    first_walls(step.walls)
    place_images(step.pairs, step.cell)


@compiled
def first_slopes(step: Step) -> None:
    """Compute the rates of contacts, walls, and of spheres with drag at the start of the step."""
    bodies = step.bodies
    copy_rows(step.slope[0], step.responses.slope)
    slopes_at_walls(step.walls)
    for i in range(len(bodies.drag)):
        if bodies.drag[i] > 0.0:
            for k in range(bodies.start.shape[1]):
                bodies.slope[0, i, k] = bodies.right[i, k] / bodies.drag[i] + background_velocity(
                    step.cell, bodies.position, i, k
                )
    first_spins(step)


@compiled
def first_spins(step: Step) -> None:
    """Compute the spins at the start of a step with drag: half the vorticity of the liquid, plus torque over drag."""
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
    """The drive of one stage, from its row of numbers."""
    return Drive(row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9])


@inlined
def try_step(newton: Callable[..., bool], contacts: Contacts, step: Step, scheme: Scheme, during: StepRequest) -> float:
    """Compute all stages of a step. Returns the estimated error, or FAILED.

    The new state is in `step.films` and `step.bodies.position`.
    """
    span = scheme.diagonal * during.length
    origin = drive_of(during.drives[0])
    add_stage(contacts, step, scheme, during, 0)
    for stage in range(1, len(scheme.times)):
        begin_stage(step, scheme, stage, during.length)
        goal = StageTarget(drive_of(during.drives[stage]), origin, span, 1e-3 * during.tolerance)
        if not newton(contacts, step, goal):
            return FAILED
        end_stage(step, goal, stage)
        if scheme.weights[0, stage] != 0.0:
            add_stage(contacts, step, scheme, during, stage)
    of_walls = float(wall_error(step.walls, scheme, during.length))
    return max(error_of(step, scheme, during.length), cell_error(step.cell, scheme, during.length), of_walls)


@compiled
def step_dense(contacts: Contacts, step: Step, scheme: Scheme, during: StepRequest, task: int) -> float:
    """Do any task for few spheres: BEGIN, BALANCE over a time `during.length`, or a STEP. One function instead of
    three, each of which would take as long to compile.
    """
    origin = drive_of(during.drives[0])
    first_stage(contacts, step, origin)
    if task == STEP:
        return try_step(newton_dense, contacts, step, scheme, during)
    goal = StageTarget(drive_of(during.drives[1]), origin, during.length, during.tolerance)
    return 0.0 if task == BEGIN or newton_dense(contacts, step, goal) else FAILED


def step_many(
    newton: Callable[..., bool], contacts: Contacts, step: Step, scheme: Scheme, during: StepRequest, task: int
) -> float:
    """Do any task for many spheres, with each loop over them compiled separately."""
    origin = drive_of(during.drives[0])
    first_stage(contacts, step, origin)
    if task == STEP:
        return plainly(try_step)(newton, contacts, step, scheme, during)
    goal = StageTarget(drive_of(during.drives[1]), origin, during.length, during.tolerance)
    return 0.0 if task == BEGIN or newton(contacts, step, goal) else FAILED


@compiled
def accept(step: Step) -> None:
    """Copy the end of a step to the start of the next one."""
    carry(step.pairs, step.films.direction)
    accept_walls(step.walls, step.spins.turn)
    copy_line(step.log_gap, step.films.log_gap)
    copy_rows(step.direction, step.films.direction)
    copy_rows(step.bodies.before, step.bodies.position)
    copy_line(step.cell.before, step.cell.shape)
    copy_line(step.cell.past, step.cell.slope[-1])
