"""The periodic box in a step: how it is sheared and sized, by what is imposed and by what answers to a stress.

Its copies above lie a `tilt` further along x; kept in box widths, it grows by height/width times the shear. So a
strain is always that of the box as it stands: its rate is the upper copy's speed over the height, however that
changes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume._portable import exp
from ecume.engine.array_copies import clear_rows
from ecume.engine.cells import Integers
from ecume.models.soft.contacts.films import Pairs
from ecume.models.soft.integration.dirk_schemes import Scheme
from ecume.models.soft.protocol import Drive
from ecume.units import Array

TILT, WIDTH, HEIGHT, DEPTH, STRAIN = range(5)
"""Places in a shape: tilt over width, ln of what the sides are multiplied by, strain so far."""
MORE = 5
"""Place in a slope: how much faster the tilt grows than with the box as it was at the step's beginning."""


class Cell(NamedTuple):
    """The box in a step; sides of zero without a box."""

    sides: Array
    """(3,) m at the start"""
    rules: Integers
    """(4,) what of it answers to a stress: `protocol.Rules`"""
    shape: Array
    """(5,) of the stage"""
    before: Array
    """(5,) at the step's beginning"""
    start: Array
    """(6,) where the stage starts from"""
    slope: Array
    """(S, 6) of the stages (1/s)"""
    past: Array
    """(5,) slope at the end of the last step"""
    change: Array
    """(3, 3) gradient of the displacement in one of Newton's steps"""


class StageTarget(NamedTuple):
    """The target values of a stage."""

    drive: Drive
    origin: Drive
    """what was imposed at the step's beginning"""
    span: float
    """s: how long a time the stage treats implicitly"""
    fine: float
    """the last change, of ln(gap) and directions, with which it is met"""


class Box(NamedTuple):
    """The box as it stands, for the energy budget."""

    sides: Array
    """(d,) m; zero without a box"""
    tilt: float
    """m"""


def box_of(sides: Array, shape: Array, dimensions: int) -> Box:
    """The box of a shape."""
    now = sides[:dimensions] * exp(shape[WIDTH : WIDTH + dimensions])
    return Box(now, float(shape[TILT] * now[0]))


def shape_at(sides: Array, drive: Drive) -> Array:
    """The shape at the start, as it is imposed."""
    shape = np.zeros(5)
    shape[[WIDTH, HEIGHT, DEPTH]] = math.log(drive.scale)
    if sides[:2].all():
        shape[[TILT, STRAIN]] = drive.strain * sides[1] / sides[0], drive.strain
    return shape


def make_cell(sides: Array, shape: Array, past: Array, stages: int) -> Cell:
    """Room for a step."""
    return Cell(
        sides,
        np.zeros(4, np.int64),
        shape.copy(),
        shape.copy(),
        np.zeros(6),
        np.zeros((stages, 6)),
        past.copy(),
        np.zeros((3, 3)),
    )


@compiled_inside
def is_stressed(cell: Cell) -> bool:
    """Whether the strain answers to a shear stress; otherwise it is imposed."""
    return bool(cell.rules[0] != 0)


@compiled_inside
def is_pressed(cell: Cell) -> bool:
    """Whether any side answers to a normal stress; otherwise all are imposed."""
    return bool(cell.rules[WIDTH] != 0 or cell.rules[HEIGHT] != 0 or cell.rules[DEPTH] != 0)


@compiled
def unknowns(cell: Cell) -> int:
    """The number of unknowns that respond to a stress: the shear, then the size."""
    return int(is_stressed(cell)) + int(is_pressed(cell))


@compiled
def height_over_width(cell: Cell, shape: Array) -> float:
    """Height over width; 1 of a box that is not periodic along both."""
    if cell.sides[0] == 0.0 or cell.sides[1] == 0.0:
        return 1.0
    return float(cell.sides[1] / cell.sides[0] * math.exp(shape[HEIGHT] - shape[WIDTH]))


@compiled
def volume(cell: Cell, dimensions: int) -> float:
    """m^3; m^2 of a layer."""
    product = 1.0
    for k in range(dimensions):
        product *= cell.sides[k] * math.exp(cell.shape[WIDTH + k])
    return product


@compiled
def impose(cell: Cell, goal: StageTarget) -> None:
    """Set the imposed values of the shape."""
    drive, origin, span = goal.drive, goal.origin, goal.span
    shape, before, start = cell.shape, cell.before, cell.start
    grown = math.log(drive.scale / origin.scale)
    if not is_pressed(cell):
        for k in (WIDTH, HEIGHT, DEPTH):
            shape[k] = before[k] + grown
        shape[HEIGHT] += drive.height - origin.height
    if not is_stressed(cell):
        sheared, usual = drive.strain - origin.strain, height_over_width(cell, before)
        shape[STRAIN] = before[STRAIN] + sheared
        shape[TILT] = before[TILT] + usual * sheared + start[MORE]
        shape[TILT] += span * (height_over_width(cell, shape) - usual) * drive.rate


@compiled
def first_cell(cell: Cell, drive: Drive) -> None:
    """The shape at the step's beginning, and its slopes: as imposed, or as the last step left them."""
    clear_rows(cell.change)
    for k in range(5):
        cell.shape[k] = cell.start[k] = cell.before[k]
        cell.slope[0, k] = cell.past[k]
    cell.start[MORE] = cell.slope[0, MORE] = 0.0
    if not is_pressed(cell):
        for k in (WIDTH, HEIGHT, DEPTH):
            cell.slope[0, k] = drive.growth
        cell.slope[0, HEIGHT] += drive.height_rate
    if not is_stressed(cell):
        cell.slope[0, TILT] = height_over_width(cell, cell.shape) * drive.rate
        cell.slope[0, STRAIN] = drive.rate


@compiled
def begin_cell(cell: Cell, scheme: Scheme, stage: int, time_step: float) -> None:
    """Set the start of a stage, from the start of the step and the slopes of the stages before."""
    for k in range(6):
        cell.start[k] = cell.before[k] if k < 5 else 0.0
        for earlier in range(stage):
            cell.start[k] += time_step * scheme.rows[stage, earlier] * cell.slope[earlier, k]


@compiled
def end_cell(cell: Cell, goal: StageTarget, stage: int) -> None:
    """The slopes of a solved stage."""
    shape, slope = cell.shape, cell.slope
    here, usual = height_over_width(cell, shape), height_over_width(cell, cell.before)
    for k in range(4):
        slope[stage, k] = (shape[k] - cell.start[k]) / goal.span
    if is_stressed(cell):
        slope[stage, STRAIN] = slope[stage, TILT] / here
        shape[STRAIN] = cell.start[STRAIN] + goal.span * slope[stage, STRAIN]
    else:
        slope[stage, STRAIN] = goal.drive.rate
        slope[stage, MORE] = (here - usual) * goal.drive.rate


@compiled
def flow_gradient(cell: Cell) -> Array:
    """Gradient of what the box's deformation does in the stage's span: displacements of the liquid far away."""
    shape, start = cell.shape, cell.start
    gradient = np.zeros((3, 3))
    for k in range(3):
        gradient[k, k] = shape[WIDTH + k] - start[WIDTH + k]
    gradient[0, 1] = (shape[TILT] - start[TILT]) / height_over_width(cell, shape)
    return gradient


@compiled
def largest_strain(cell: Cell) -> float:
    """The largest component of the shape, in whose last digits a box is known that answers to a stress; otherwise 0."""
    largest = 0.0
    if unknowns(cell) > 0:
        for k in range(len(cell.shape)):
            largest = max(largest, abs(cell.shape[k]))
    return largest


@compiled
def gradient_of(cell: Cell, unknown: int, goal: StageTarget, row: bool) -> Array:
    """The displacement gradient of a unit of an unknown: the shear if that responds to a stress, then the size.

    As a row, the conjugate stress. They differ for an imposed strain, whose tilt follows the height.
    """
    gradient = np.zeros((3, 3))
    if unknown == 0 and is_stressed(cell):
        gradient[0, 1] = 1.0
        return gradient
    for k in range(3):
        gradient[k, k] = 1.0 if cell.rules[WIDTH + k] != 0 else 0.0
    if not row and not is_stressed(cell) and cell.rules[HEIGHT] != cell.rules[WIDTH]:
        gradient[0, 1] = goal.span * goal.drive.rate
    return gradient


@compiled
def stress_goal(cell: Cell, unknown: int, drive: Drive, dimensions: int) -> float:
    """The target of the work done by an unknown (J), tension positive."""
    space = volume(cell, dimensions)
    if unknown == 0 and is_stressed(cell):
        return space * drive.shear_stress
    sides = 0
    for k in range(dimensions):
        sides += int(cell.rules[WIDTH + k] != 0)
    return -space * drive.normal_stress * sides


@compiled
def deform(cell: Cell, goal: StageTarget, part: float) -> None:
    """Add a part of Newton's change to the shape."""
    if is_stressed(cell):
        cell.shape[TILT] += part * cell.change[0, 1] * height_over_width(cell, cell.shape)
        cell.shape[STRAIN] += part * cell.change[0, 1]
    for k in range(3):
        if cell.rules[WIDTH + k] != 0:
            cell.shape[WIDTH + k] += part * cell.change[k, k]
    impose(cell, goal)


@compiled
def deform_positions(cell: Cell, old: Array, position: Array, moved: Array) -> None:
    """Carry places along with the box from an old shape to the present one, and tell how far."""
    sides, shape = cell.sides, cell.shape
    same = True
    for k in range(4):
        same = same and shape[k] == old[k]
    if sides[0] == 0.0 or same:
        return
    width, height = math.expm1(shape[WIDTH] - old[WIDTH]), math.expm1(shape[HEIGHT] - old[HEIGHT])
    depth = math.expm1(shape[DEPTH] - old[DEPTH])
    tilted = sides[0] * math.exp(shape[WIDTH]) * (shape[TILT] - old[TILT])
    per_height = tilted / (sides[1] * math.exp(old[HEIGHT]))
    for i in range(len(position)):
        along, up = width * position[i, 0] + per_height * position[i, 1], height * position[i, 1]
        position[i, 0], position[i, 1] = position[i, 0] + along, position[i, 1] + up
        moved[i, 0], moved[i, 1] = moved[i, 0] + along, moved[i, 1] + up
        if position.shape[1] == 3:
            back = depth * position[i, 2]
            position[i, 2], moved[i, 2] = position[i, 2] + back, moved[i, 2] + back


@compiled
def place_images(pairs: Pairs, cell: Cell) -> None:
    """Set the present positions of the periodic images."""
    image, offset, sides, shape = pairs.image, pairs.offset, cell.sides, cell.shape
    tilt = shape[TILT] * sides[0] * math.exp(shape[WIDTH])
    for k in range(3):
        side = sides[k] * math.exp(shape[WIDTH + k])
        for c in range(len(image)):
            offset[c, k] = image[c, k] * side
    for c in range(len(image)):
        offset[c, 0] += image[c, 1] * tilt


@compiled
def cell_error(cell: Cell, scheme: Scheme, time_step: float) -> float:
    """The largest difference from the embedded scheme, of the strain or of ln(a side), if they answer to a stress."""
    largest = 0.0
    for k in range(WIDTH, STRAIN + 1):
        value = 0.0
        for stage in range(len(scheme.error)):
            value += scheme.error[stage] * cell.slope[stage, k]
        responds = is_stressed(cell) if k == STRAIN else is_pressed(cell)
        if responds:
            largest = max(largest, abs(time_step * value))
    return largest
