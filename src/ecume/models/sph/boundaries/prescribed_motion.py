"""What moves beside the liquid, at an instant: sides, bodies, and a tank that is shaken."""

from __future__ import annotations

import math

import numpy as np

from ecume.engine.walls.sheets import SIZE, SPEED
from ecume.models.sph.boundaries.rigid_bodies import placed
from ecume.models.sph.parameters import Boundary, Drive, Parameters
from ecume.models.sph.state import State
from ecume.units import Array


def drive_at(drive: Drive, time: float) -> tuple[Array, Array, Array]:
    """Value, rate and second rate of a drive: of a sine, or on the straight lines of a table."""
    angle = drive.turning * time + drive.phase
    value = drive.amplitude * (math.sin(angle) + drive.start)
    rate = drive.amplitude * drive.turning * math.cos(angle)
    second = -drive.amplitude * drive.turning**2 * math.sin(angle)
    times, rows = drive.times, drive.values
    value = value + np.array([np.interp(time, times, row) for row in rows])
    piece = int(np.searchsorted(times, time, side="right"))
    if 0 < piece < len(times):
        rate = rate + (rows[:, piece] - rows[:, piece - 1]) / (times[piece] - times[piece - 1])
    return value, rate, second


def instant(parameters: Parameters, state: State) -> Parameters:
    """The parameters with everything where it is now."""
    return at(parameters, float(state.clock[0]), state.pose, state.motion)


def at_reference(parameters: Parameters, state: State) -> Parameters:
    """The parameters with everything at its position when the lists were made."""
    return at(parameters, float(state.clock[1]), state.pose_reference, state.motion)


def at(parameters: Parameters, time: float, pose: Array, motion: Array) -> Parameters:
    """The parameters with everything at its position at a time."""
    if not parameters.moves:
        return parameters
    boundary = parameters.boundary
    dummies = placed(parameters.bodies, boundary.dummies, pose, motion)
    centers = boundary.centers.copy()
    centers[len(centers) - pose.shape[1] :] = pose[:3].T
    boundary = boundary._replace(dummies=dummies, centers=centers)
    for number, drive in parameters.drives:
        boundary = _driven(boundary, number, drive_at(drive, time))
    parameters = parameters._replace(boundary=boundary)
    return (
        parameters
        if parameters.base_excitation is None
        else _accelerated(parameters, drive_at(parameters.base_excitation, time)[0])
    )


def _driven(boundary: Boundary, number: int, drive: tuple[Array, Array, Array]) -> Boundary:
    """The boundary with one mirror, and the guard behind it, at the positions of a drive."""
    value, rate, second = (float(part[0]) for part in drive)
    axis, d = number // 2, boundary.sides.normal.shape[1]
    row = boundary.image_owner == number
    point, table = boundary.sides.point.copy(), boundary.table.copy()
    point[row, axis] += value
    table[row, axis] += value
    table[row, 2 * d + axis] += rate
    table[row, 3 * d + 2 + axis] += second
    surface, packed = boundary.guard.owner == number, boundary.guard.sheet
    numbers = packed.number.copy()
    numbers[surface, SIZE] += numbers[surface, axis] * value
    numbers[surface, SPEED + axis] = rate
    guard = boundary.guard._replace(sheet=packed._replace(number=numbers))
    return boundary._replace(sides=boundary.sides._replace(point=point), table=table, guard=guard)


def _accelerated(parameters: Parameters, more: Array) -> Parameters:
    """The parameters with the present apparent gravity, and its hydrostatic gradient; none along periodic sides."""
    sides, constants = parameters.boundary.sides, parameters.constants.copy()
    held = more * (np.abs(sides.normal[sides.mirrors == 0]).sum(axis=0) == 0.0)
    material = parameters.material
    rise = parameters.density_diffusion.rise(material.density, material.sound_speed) * held
    for name, own in zip(("rise_x", "rise_y", "rise_z"), rise, strict=False):
        setattr(constants[0], name, getattr(constants[0], name) + own)
    return parameters._replace(gravity=parameters.gravity + more, constants=constants)


def displacement_of_sides(parameters: Parameters, state: State) -> float:
    """The displacement of sides since the lists were made; their images move twice as far."""
    now, then = (float(time) for time in state.clock)
    ways = (drive_at(drive, now)[0] - drive_at(drive, then)[0] for _, drive in parameters.drives)
    return float(sum(abs(way[0]) for way in ways))
