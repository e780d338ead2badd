"""What moves beside the liquid, at an instant: sides, bodies, and a tank that is shaken."""

from __future__ import annotations

import math

import numpy as np

from ecume.engine.walls.sheets import SIZE, SPEED
from ecume.models.sph.bodies import placed
from ecume.models.sph.parameters import Boundary, Drive, Parameters
from ecume.models.sph.state import State
from ecume.scenes.sph import SIDES, BaseExcitationSpec, MotionSpec, SphScene
from ecume.units import Array


def drives_of(scene: SphScene) -> tuple[tuple[int, Drive], ...]:
    """The sides that move, by their numbers."""
    found = []
    for number, name in enumerate(SIDES[: 2 * len(scene.tank.low)]):
        motion = getattr(scene.tank, name).motion
        if motion is not None:
            found.append((number, _drive(motion, motion.amplitude, motion.positions, -1.0)))
    return tuple(found)


def shake_of(scene: SphScene) -> Drive | None:
    """What a shaken tank adds to gravity."""
    shake = scene.base_excitation
    return None if shake is None else _drive(shake, shake.amplitude, shake.accelerations, 0.0)


def _drive(spec: MotionSpec | BaseExcitationSpec, amplitude: object, values: object, origin: float) -> Drive:
    if spec.frequency is None or amplitude is None:
        return Drive(np.zeros(1), 0.0, 0.0, 0.0, np.array(spec.times), np.atleast_2d(np.array(values).T))
    height = np.atleast_1d(np.array(amplitude, np.float64))
    none = np.zeros((len(height), 1))
    start = origin * math.sin(spec.phase)
    return Drive(height, 2.0 * math.pi * spec.frequency, spec.phase, start, np.zeros(1), none)


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
    """With everything where it was when the lists were made."""
    return at(parameters, float(state.clock[1]), state.pose_reference, state.motion)


def at(parameters: Parameters, time: float, pose: Array, motion: Array) -> Parameters:
    """With everything where it is at a time."""
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
    return parameters if parameters.shake is None else _shaken(parameters, drive_at(parameters.shake, time)[0])


def _driven(boundary: Boundary, number: int, drive: tuple[Array, Array, Array]) -> Boundary:
    """With one mirror, and the guard behind it, where they are."""
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


def _shaken(parameters: Parameters, more: Array) -> Parameters:
    """With what pulls now, and what the pressure of a liquid at rest would hold of it: nothing along periodic sides."""
    sides, constants = parameters.boundary.sides, parameters.constants.copy()
    held = more * (np.abs(sides.normal[sides.mirrors == 0]).sum(axis=0) == 0.0)
    material = parameters.material
    rise = parameters.density_diffusion.rise(material.density, material.sound_speed) * held
    for name, own in zip(("rise_x", "rise_y", "rise_z"), rise, strict=False):
        setattr(constants[0], name, getattr(constants[0], name) + own)
    return parameters._replace(gravity=parameters.gravity + more, constants=constants)


def way_of_sides(parameters: Parameters, state: State) -> float:
    """How far sides moved since the lists were made: their images went twice as far."""
    now, then = (float(time) for time in state.clock)
    ways = (drive_at(drive, now)[0] - drive_at(drive, then)[0] for _, drive in parameters.drives)
    return float(sum(abs(way[0]) for way in ways))


def fastest_drive(scene: SphScene) -> float:
    """The fastest that a side moves, or that a shake alone moves the liquid in a second at its height."""
    speeds = [0.0]
    for _, drive in drives_of(scene):
        speeds.append(float(np.abs(drive.amplitude).max()) * drive.turning)
        if len(drive.times) > 1:
            speeds.append(float(np.abs(np.diff(drive.values[0]) / np.diff(drive.times)).max()))
    return max(speeds)
