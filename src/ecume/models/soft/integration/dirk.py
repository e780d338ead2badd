"""One time step: the successive implicit stages of a DIRK scheme, and its error estimate."""

from __future__ import annotations

from collections.abc import Callable

from ecume._jit import compiled, compiled_inside, composed, inlined, plainly
from ecume.engine.array_copies import clear_rows, copy_line, copy_rows
from ecume.models.soft.cell import (
    STRAIN,
    WIDTH,
    StageTarget,
    begin_cell,
    cell_error,
    end_cell,
    first_cell,
    place_images,
)
from ecume.models.soft.contacts.films import Films, contact_response
from ecume.models.soft.contacts.rotation import carry, turn_pairs
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
from ecume.models.soft.permeation import (
    accept_layers,
    begin_layers,
    end_layers,
    first_layers,
    layer_error,
    permeation_response,
)
from ecume.models.soft.protocol import Drive
from ecume.models.soft.report.energy_budget import add_stage
from ecume.models.soft.state import Step, StepRequest
from ecume.units import Array

FAILED = -1.0
BEGIN, BALANCE, STEP = range(3)
"""Tasks of a solver: compute the rates at the start of a step, balance forces and stresses at constant gaps, or compute
a step.
"""


@composed
def begin_stage(step: Step, scheme: Scheme, stage: int, time_step: float) -> None:
    """Set the start of a stage, from the start of the step and the slopes of the previous stages."""
    films, bodies, spins, row = step.films, step.bodies, step.spins, scheme.rows[stage, :stage]
    begin_contacts(films.log_gap_start, step.log_gap, films.direction_start, step.direction, step.slope, row, time_step)
    begin_motion(bodies.start, bodies.slope, bodies.drag, row, time_step)
    begin_motion(spins.start, spins.slope, spins.drag, row, time_step)
    begin_cell(step.cell, row, time_step)
    begin_walls(step.walls, scheme, stage, time_step)
    begin_layers(step.permeation, row, time_step)


@compiled
def begin_contacts(
    log_gap_start: Array,
    log_gap: Array,
    direction_start: Array,
    direction: Array,
    slope: Array,
    row: Array,
    time_step: float,
) -> None:
    """Set ln(gap) and direction of all contacts at the start of a stage."""
    for c in range(len(log_gap)):
        log_gap_start[c] = log_gap[c]
        for k in range(3):
            direction_start[c, k] = direction[c, k]
        for earlier in range(len(row)):
            weight = time_step * row[earlier]
            log_gap_start[c] += weight * slope[earlier, c, 0]
            for k in range(3):
                direction_start[c, k] += weight * slope[earlier, c, 1 + k]


@compiled
def begin_motion(start: Array, slope: Array, drag: Array, row: Array, time_step: float) -> None:
    """Set the displacements, or rotations, of spheres with drag at the start of a stage."""
    for i in range(len(drag)):
        if drag[i] > 0.0:
            for k in range(start.shape[1]):
                value = 0.0
                for earlier in range(len(row)):
                    value += time_step * row[earlier] * slope[earlier, i, k]
                start[i, k] = value


@composed
def end_stage(step: Step, goal: StageTarget, stage: int) -> None:
    """Compute the slopes of a solved stage from its difference to its start, a form that does not amplify rounding
    errors.
    """
    films, bodies, spins, span = step.films, step.bodies, step.spins, goal.span
    end_cell(step.cell, goal, stage)
    end_walls(step.walls, stage, span)
    end_layers(step.permeation, bodies.moved, stage, span)
    end_contacts(films, step.slope[stage], span)
    end_motion(bodies.slope[stage], bodies.moved, bodies.start, bodies.drag, span)
    end_motion(spins.slope[stage], spins.turn, spins.start, spins.drag, span)


@compiled
def end_contacts(films: Films, slope: Array, span: float) -> None:
    """Compute the rates of ln(gap) and direction of all contacts in a solved stage."""
    for c in range(len(slope)):
        slope[c, 0] = (films.log_gap[c] - films.log_gap_start[c]) / span
        lean = 0.0
        for k in range(3):
            lean += films.direction[c, k] * films.direction_start[c, k]
        for k in range(3):
            slope[c, 1 + k] = (lean * films.direction[c, k] - films.direction_start[c, k]) / span


@compiled
def end_motion(slope: Array, moved: Array, start: Array, drag: Array, span: float) -> None:
    """Compute the velocities, or spins, of spheres with drag in a solved stage."""
    for i in range(len(drag)):
        if drag[i] > 0.0:
            for k in range(start.shape[1]):
                slope[i, k] = (moved[i, k] - start[i, k]) / span


@composed
def first_stage(contacts: Contacts, step: Step, drive: Drive) -> None:
    """Compute the slopes at the start of the step."""
    reset_to_start(step, drive)
    contact_response(contacts, step.pairs, step.films, step.bodies.position, 0.0, step.responses)
    wall_response(step.walls, contacts, step.bodies.position, step.spins.turn, 0.0)
    permeation_response(step.permeation, step.walls, step.bodies.position)
    imbalance(step, drive.load, 1.0, False)
    first_slopes(step)


@composed
def reset_to_start(step: Step, drive: Drive) -> None:
    """Reset all positions to the start of the step."""
    films, bodies, spins = step.films, step.bodies, step.spins
    copy_line(films.log_gap, step.log_gap)
    copy_rows(films.direction, step.direction)
    copy_line(films.log_gap_start, step.log_gap)
    copy_rows(films.direction_start, step.direction)
    copy_rows(bodies.position, bodies.before)
    clear_rows(bodies.moved)
    clear_rows(bodies.start)
    clear_rows(spins.turn)
    clear_rows(spins.start)
    turn_pairs(step.pairs, spins.turn)
    first_cell(step.cell, drive)
    first_walls(step.walls)
    first_layers(step.permeation)
    place_images(step.pairs, step.cell)


@composed
def first_slopes(step: Step) -> None:
    """Compute the rates of contacts, walls, and of spheres with drag at the start of the step."""
    bodies, spins, rates = step.bodies, step.spins, step.cell.slope[0]
    copy_rows(step.slope[0], step.responses.slope)
    slopes_at_walls(step.walls)
    first_velocities(bodies.slope[0], bodies.right, bodies.drag, bodies.position, rates)
    first_spins(spins.slope[0], bodies.right, spins.drag, spins.radius, rates[STRAIN])


@compiled
def first_velocities(velocity: Array, right: Array, drag: Array, position: Array, rates: Array) -> None:
    """Compute the velocities of spheres with drag at the start of a step: those of the liquid in the box with these
    rates, plus force over drag.
    """
    for i in range(len(drag)):
        if drag[i] > 0.0:
            for k in range(velocity.shape[1]):
                along = rates[WIDTH + k] * position[i, k]
                if k == 0:
                    along += rates[STRAIN] * position[i, 1]
                velocity[i, k] = right[i, k] / drag[i] + along


@compiled
def first_spins(spin: Array, right: Array, drag: Array, radius: Array, strain_rate: float) -> None:
    """Compute the spins at the start of a step with drag: half the vorticity of the liquid, plus torque over drag."""
    width = spin.shape[1]
    begin = right.shape[1] - width
    for i in range(len(drag)):
        if drag[i] > 0.0:
            for k in range(width):
                spin[i, k] = right[i, begin + k] / drag[i]
                if k == width - 1:
                    spin[i, k] -= 0.5 * strain_rate * radius[i]


@compiled
def error_of(slope: Array, weights: Array, time_step: float) -> float:
    """The largest difference from the embedded scheme, of ln(gap) or of a direction."""
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
    of_contacts = error_of(step.slope, scheme.error, during.length)
    of_walls = float(wall_error(step.walls, scheme, during.length))
    of_layers = float(layer_error(step.permeation, scheme, during.length))
    return max(of_contacts, cell_error(step.cell, scheme, during.length), of_walls, of_layers)


@compiled
def step_dense(contacts: Contacts, step: Step, scheme: Scheme, during: StepRequest, task: int) -> float:
    """Perform any task for few spheres: BEGIN, BALANCE over a time `during.length`, or STEP. Each of three separate
    functions would take as long to compile as this one.
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
    """Perform any task for many spheres, with each loop over them compiled separately."""
    origin = drive_of(during.drives[0])
    first_stage(contacts, step, origin)
    if task == STEP:
        return plainly(try_step)(newton, contacts, step, scheme, during)
    goal = StageTarget(drive_of(during.drives[1]), origin, during.length, during.tolerance)
    return 0.0 if task == BEGIN or newton(contacts, step, goal) else FAILED


@composed
def accept(step: Step) -> None:
    """Copy the end of a step to the start of the next one."""
    carry(step.pairs.turn, step.films.direction)
    accept_walls(step.walls, step.spins.turn)
    accept_layers(step.permeation)
    copy_line(step.log_gap, step.films.log_gap)
    copy_rows(step.direction, step.films.direction)
    copy_rows(step.bodies.before, step.bodies.position)
    copy_line(step.cell.before, step.cell.shape)
    copy_line(step.cell.past, step.cell.slope[-1])
