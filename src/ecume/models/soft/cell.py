"""The periodic box in a step: its shear and size, imposed or controlled by stresses.

The periodic images above the box are shifted by `tilt` along x. In units of the width, the tilt grows with height/width
times the shear rate: the strain rate is the speed of the upper image over the present height, also while the height
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
from ecume.models.soft.contacts.contact import Vector
from ecume.models.soft.contacts.films import Pairs
from ecume.models.soft.integration.dirk_schemes import Scheme
from ecume.models.soft.protocol import Drive
from ecume.units import Array

TILT, WIDTH, HEIGHT, DEPTH, STRAIN = range(5)
"""Indices of a shape: tilt over width, logarithms of the factors of width, height and depth, and total strain."""
MORE = 5
"""Index of a slope: the growth rate of the tilt, minus that of a box whose aspect ratio stays that at the start of the
step.
"""


class Cell(NamedTuple):
    """The box in a step; sides are zero without a box."""

    sides: Array
    """(3,) m at the start"""
    rules: Integers
    """(4,) the components that stresses control: `protocol.Rules`"""
    shape: Array
    """(5,) at the stage"""
    before: Array
    """(5,) at the start of the step"""
    start: Array
    """(6,) at the start of the stage"""
    slope: Array
    """(S, 6) at each stage (1/s)"""
    past: Array
    """(5,) slope at the end of the last step"""
    change: Array
    """(3, 3) displacement gradient in Newton's step"""


class StageTarget(NamedTuple):
    """The target values of a stage."""

    drive: Drive
    origin: Drive
    """the imposed values at the start of the step"""
    span: float
    """s: the implicit time span of the stage"""
    fine: float
    """the largest last change of ln(gap) and directions of a converged stage"""


class Box(NamedTuple):
    """The sides and the tilt of the box at one time."""

    sides: Array
    """(d,) m; zero without a box"""
    tilt: float
    """m"""


def box_of(sides: Array, shape: Array, dimensions: int) -> Box:
    """The sides and the tilt of a box with this shape."""
    now = sides[:dimensions] * exp(shape[WIDTH : WIDTH + dimensions])
    return Box(now, float(shape[TILT] * now[0]))


def shape_at(sides: Array, drive: Drive) -> Array:
    """The shape at time 0, as imposed by the protocol."""
    shape = np.zeros(5)
    shape[[WIDTH, HEIGHT, DEPTH]] = math.log(drive.scale)
    if sides[:2].all():
        shape[[TILT, STRAIN]] = drive.strain * sides[1] / sides[0], drive.strain
    return shape


def make_cell(sides: Array, shape: Array, past: Array, stages: int) -> Cell:
    """The box at the start of a step."""
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
    """Whether a shear stress controls the strain; otherwise it is imposed."""
    return bool(cell.rules[0] != 0)


@compiled_inside
def is_pressed(cell: Cell) -> bool:
    """Whether a normal stress controls any side; otherwise all are imposed."""
    return bool(cell.rules[WIDTH] != 0 or cell.rules[HEIGHT] != 0 or cell.rules[DEPTH] != 0)


@compiled
def unknowns(cell: Cell) -> int:
    """The number of unknowns of the box: the shear and the size, if stresses control them."""
    return int(is_stressed(cell)) + int(is_pressed(cell))


@compiled
def height_over_width(cell: Cell, shape: Array) -> float:
    """Height over width of the box; 1 if it is not periodic along both."""
    if cell.sides[0] == 0.0 or cell.sides[1] == 0.0:
        return 1.0
    return float(cell.sides[1] / cell.sides[0] * math.exp(shape[HEIGHT] - shape[WIDTH]))


@compiled
def volume(cell: Cell, dimensions: int) -> float:
    """The volume of the box (m^3); in 2D its area (m^2)."""
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
    """Reset the shape to the start of the step. Its slopes are the imposed ones, or those at the end of the previous
    step.
    """
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
def begin_cell(cell: Cell, row: Array, time_step: float) -> None:
    """Set the start of a stage, from the start of the step and the slopes of the previous stages."""
    for k in range(6):
        cell.start[k] = cell.before[k] if k < 5 else 0.0
        for earlier in range(len(row)):
            cell.start[k] += time_step * row[earlier] * cell.slope[earlier, k]


@compiled
def end_cell(cell: Cell, goal: StageTarget, stage: int) -> None:
    """Compute the slopes of a solved stage."""
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
    """The displacement gradient of the liquid by the deformation of the box, in the time span of the stage."""
    shape, start = cell.shape, cell.start
    gradient = np.zeros((3, 3))
    for k in range(3):
        gradient[k, k] = shape[WIDTH + k] - start[WIDTH + k]
    gradient[0, 1] = (shape[TILT] - start[TILT]) / height_over_width(cell, shape)
    return gradient


@compiled
def largest_strain(cell: Cell) -> float:
    """The largest component of the shape of a stress-controlled box, which bounds its rounding error; otherwise 0."""
    largest = 0.0
    if unknowns(cell) > 0:
        for k in range(len(cell.shape)):
            largest = max(largest, abs(cell.shape[k]))
    return largest


@compiled_inside
def transformed(gradient: Array, x: Vector) -> Vector:
    """A gradient times a vector."""
    return (
        gradient[0, 0] * x[0] + gradient[0, 1] * x[1] + gradient[0, 2] * x[2],
        gradient[1, 0] * x[0] + gradient[1, 1] * x[1] + gradient[1, 2] * x[2],
        gradient[2, 0] * x[0] + gradient[2, 1] * x[1] + gradient[2, 2] * x[2],
    )


@compiled
def gradient_of(cell: Cell, unknown: int, goal: StageTarget, row: bool) -> Array:
    """The displacement gradient per unit of an unknown of the box: the shear, if a stress controls it, or else the
    size.

    With `row`, the gradient is that of the virtual work of the stress. The two differ for an imposed strain, whose tilt
    depends on the height.
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
    """The prescribed work of a stress per unit of an unknown of the box (J), positive for tension."""
    space = volume(cell, dimensions)
    if unknown == 0 and is_stressed(cell):
        return space * drive.shear_stress
    sides = 0
    for k in range(dimensions):
        sides += int(cell.rules[WIDTH + k] != 0)
    return -space * drive.normal_stress * sides


@compiled
def deform(cell: Cell, goal: StageTarget, part: float) -> None:
    """Add a fraction of Newton's step to the shape."""
    if is_stressed(cell):
        cell.shape[TILT] += part * cell.change[0, 1] * height_over_width(cell, cell.shape)
        cell.shape[STRAIN] += part * cell.change[0, 1]
    for k in range(3):
        if cell.rules[WIDTH + k] != 0:
            cell.shape[WIDTH + k] += part * cell.change[k, k]
    impose(cell, goal)


@compiled
def deform_positions(cell: Cell, old: Array, position: Array, moved: Array) -> None:
    """Move positions with the box from an old shape to the present one, and add the displacements to `moved`."""
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
    """Compute the displacements of periodic images in the present box."""
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
    """The largest difference from the embedded scheme, of the strain and of the logarithms of the sides, as far as
    stresses control them.
    """
    largest = 0.0
    for k in range(WIDTH, STRAIN + 1):
        value = 0.0
        for stage in range(len(scheme.error)):
            value += scheme.error[stage] * cell.slope[stage, k]
        responds = is_stressed(cell) if k == STRAIN else is_pressed(cell)
        if responds:
            largest = max(largest, abs(time_step * value))
    return largest
