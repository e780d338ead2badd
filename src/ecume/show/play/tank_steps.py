"""Steps of a 2D tank in the order of `ecume.models.sph.integration.time_stepping`, with all arrays in place.

Python runs these functions and calls the compiled loops of the model, with the same bits as the model; for pages all
functions are compiled. Choices that the model makes from the scene in each step are fixed here: see
`ecume.show.play.tank_alone`, which also lists the parts that pages omit.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.engine.cells import Integers, Sides, behind, distance_before
from ecume.engine.neighbor_rows import (
    SLICES,
    STRIDE,
    Grid,
    Lists,
    Slots,
    Sorted,
    _counting_sort,
    _longest_run,
    _search,
)
from ecume.engine.vectors import Vector2
from ecume.engine.walls import reflect_all
from ecume.engine.walls.sheets import SIZE, SPEED, Sheet, worst_gap
from ecume.engine.walls.surfaces import PLANE
from ecume.laws.time_step_limits import acoustic_limit, force_limit
from ecume.laws.water_waves import wave_frequency
from ecume.models.model import CROWDED, DIVERGED, DONE, EXCHANGE
from ecume.models.sph.boundaries.walls import _move_inside, brake, flag_outside, repel
from ecume.models.sph.fields import FIELD, FIELDS, Constants, Floats, Tait
from ecume.models.sph.integration.particle_loops import advance_density, drift, farthest, kick, largest
from ecume.models.sph.integration.time_stepping import MOST_DIVISIONS
from ecume.models.sph.parameters import Guard
from ecume.models.sph.rates.fill_fields import fill_images, fill_liquid, fill_weights, read_liquid
from ecume.models.sph.rates.kernel_loops import WendlandC2
from ecume.models.sph.rates.neighbor_sums import fill_records
from ecume.models.sph.rates.sums import CONTINUITY, PRESSURE, store_acceleration, store_density_rate
from ecume.models.sph.state import GUARD_HITS, RENEWALS, SORT_EVERY, SUBSTEPS, skin_for
from ecume.units import Array

sum_continuity, sum_pressure = CONTINUITY[FIELD.enthalpy].loop, PRESSURE.loop
OF_CONTINUITY, OF_PRESSURE = range(2)
"""Rows of `Tank.rows`."""
PIECES = 8
"""Straight lines between two looks at the hand: jumps of a wall's speed are bangs in the liquid."""
MOST_LINES = 80
"""Room for the lines of a path since the lists were made."""


class Path(NamedTuple):
    """The path of the left wall, linear between given times: see `tank.Push`."""

    row: int
    """the side that mirrors there; -1: it stays"""
    surface: int
    """the surface that reflects there"""
    rest: Array
    """(3,) where the side and its row of the table are at rest, and the size of the surface"""
    lines: Array
    """(2, MOST_LINES) times (s), and displacements (m) then"""
    count: Integers  # type: ignore[assignment]  # tuples have a method of this name
    """(1,) the number of those that count"""
    speed: Array
    """(1,) m/s, at the end"""


class Walls(NamedTuple):
    """Everything that confines the liquid."""

    sides: Sides
    table: Array
    """the same as `fill_fields.fill_images` reads it, from the origin of tables on"""
    guard: Guard
    position: Array
    """(2, D) of dummies"""
    volume: Array
    """(D,) of dummies"""
    path: Path


class Basin(NamedTuple):
    """The constants of a step. The fields have the names of those of `Parameters`."""

    time_step: float
    support: float
    courant: float
    bulk_viscosity: float
    by_mass: bool
    per_volume: bool
    walls_clip: bool
    repulsion: float
    """m/s, `walls.speed_of`"""
    equation_of_state: Tait
    constants: Constants
    kernel: WendlandC2
    like: Vector2
    gravity: Array
    """at present"""
    upright: Array
    """the gravity of a tank that does not lean"""
    rise: Array
    """(2,) the gradient of the diffusing field at rest, then"""
    spring: float
    """its change over that of gravity, `DensityDiffusion.rise`"""
    bounds: Array
    origin: Array
    """of the positions in tables"""
    rows: Integers
    """(2, 8) `NeighborSum.rows`"""
    walls: Walls


class Drops(NamedTuple):
    """The liquid. The fields have the names of those of `State`."""

    position: Array
    velocity: Array
    acceleration: Array
    transport: Array
    """zero"""
    density: Array
    pressure: Array
    """zero"""
    density_rate: Array
    mass: Array
    identity: Integers
    region: Integers
    reference: Array
    skin: Array
    clock: Array
    step: Integers
    ready: Integers
    tally: Array


class Room(NamedTuple):
    """Scratch: a `Workspace` with room for additional images and neighbors."""

    fields: Floats
    """room for the table of fields, which has a column for each particle, dummy and image: see `table_of`"""
    rates: Floats
    records: Floats
    counts: NDArray[np.int32]
    start: Integers
    neighbor: Slots
    source: Integers
    first: Integers
    """(sides + 1,) the first image of each side"""
    asked: Array
    """(2,) a place (m), a tilt (rad), a width (m), or a displacement (m) and a time (s)"""
    answer: Array
    """(1,) the answer"""


def advance(basin: Basin, drops: Drops, room: Room, steps: int) -> int:
    """Integrate over this number of steps; each is divided if speeds or forces require it. Returns DONE, DIVERGED,
    EXCHANGE if liquid has left the tank, or `CROWDED` if lists have no room.
    """
    for _ in range(steps):
        divisions = divisions_needed(basin, drops)
        if divisions > MOST_DIVISIONS:
            return DIVERGED
        for _ in range(divisions):
            if not take_step(basin, drops, room, basin.time_step / divisions):
                return CROWDED
        drops.step[0] += 1
        drops.clock[0] = int(drops.step[0]) * basin.time_step
        drops.tally[SUBSTEPS] += divisions
        if has_left(basin, drops):
            return EXCHANGE
    return DONE if divisions_needed(basin, drops) <= MOST_DIVISIONS else DIVERGED


def has_left(basin: Basin, drops: Drops) -> bool:
    """Whether a particle is beyond an open side. If all are, they stay, as in `open_boundaries.exchange_due`."""
    gone = 0
    for i in range(drops.position.shape[1]):
        beyond = False
        for axis in range(len(drops.position)):
            x = drops.position[axis, i]
            beyond = beyond or x < basin.bounds[0, axis] or x > basin.bounds[1, axis]
        if beyond:
            gone += 1
    return bool(0 < gone < drops.position.shape[1])


def divisions_needed(basin: Basin, drops: Drops) -> int:
    """The number of substeps that sound and forces require; very large if a value is not finite."""
    speed, force, length = largest(drops.velocity), largest(drops.acceleration), basin.constants[0].smoothing_length
    if not (math.isfinite(speed) and math.isfinite(force)):
        return MOST_DIVISIONS + 1
    sound = basin.equation_of_state.sound_speed
    longest = min(acoustic_limit(length, sound, speed, basin.courant), force_limit(length, force))
    needed = math.ceil(basin.time_step / longest * (1.0 - 1e-9) - 0.1)
    return min(max(1, needed), MOST_DIVISIONS + 1)


def take_step(basin: Basin, drops: Drops, room: Room, time: float) -> bool:
    """Perform the symplectic step: kick, drift half, density, drift half, kick. Returns False if lists have no room."""
    place_wall(basin.walls, drops.clock[0])
    if not drops.ready[0]:
        if not renew(basin, drops, room):
            return False
        if basin.bulk_viscosity > 0.0:
            evaluate_density_rate(basin, drops, room)
        evaluate_accelerations(basin, drops, room)
    kick(drops.velocity, drops.acceleration, 0.5 * time)
    if not move(basin, drops, room, 0.5 * time):
        return False
    evaluate_density_rate(basin, drops, room)
    advance_density(drops.density, drops.density_rate, time)
    if not move(basin, drops, room, 0.5 * time):
        return False
    evaluate_accelerations(basin, drops, room)
    kick(drops.velocity, drops.acceleration, 0.5 * time)
    drops.ready[0] = 1
    return True


def move(basin: Basin, drops: Drops, room: Room, time: float) -> bool:
    """Drift, reflect particles at walls, and renew the lists when due."""
    drift(drops.position, drops.velocity, time)
    drops.clock[0] += time
    place_wall(basin.walls, drops.clock[0])
    reflect(basin.walls.guard, drops, time)
    if farthest(drops.position, drops.reference) + wall_moved(basin.walls.path, drops) > 0.5 * drops.skin[0]:
        return renew(basin, drops, room)
    return True


def displaced(path: Path, time: float) -> float:
    """The displacement of the wall (m) at a time."""
    times, places, last = path.lines[0], path.lines[1], path.count[0] - 1
    if time <= times[0]:
        return float(places[0])
    for k in range(last):
        if time < times[k + 1]:
            return float((places[k + 1] - places[k]) / (times[k + 1] - times[k]) * (time - times[k]) + places[k])
    return float(places[last])


def speed_of_wall(path: Path, time: float) -> float:
    """The speed of the wall (m/s) at a time: that of the interval which starts at or before it."""
    times, places = path.lines[0], path.lines[1]
    for k in range(path.count[0] - 1):
        if times[k] <= time < times[k + 1]:
            return float((places[k + 1] - places[k]) / (times[k + 1] - times[k]))
    return 0.0


def wall_moved(path: Path, drops: Drops) -> float:
    """The displacement of the wall since the lists were made: see `rigid_bodies.displacement_of_sides`."""
    return 0.0 if path.row < 0 else abs(displaced(path, drops.clock[0]) - displaced(path, drops.clock[1]))


def place_wall(walls: Walls, time: float) -> None:
    """Move the left wall to its position on its path at this time: see `rigid_bodies.at`."""
    path, dimension, numbers = walls.path, walls.sides.point.shape[1], walls.guard.sheet.number
    if path.row < 0:
        return
    place, speed = displaced(path, time), speed_of_wall(path, time)
    walls.sides.point[path.row, 0] = path.rest[0] + place
    walls.table[path.row, 0] = path.rest[1] + place
    walls.table[path.row, 2 * dimension] = speed
    numbers[path.surface, SIZE] = path.rest[2] + numbers[path.surface, 0] * place
    numbers[path.surface, SPEED] = speed


def push_wall(basin: Basin, drops: Drops, room: Room) -> None:
    """Append a constant acceleration of the wall to the given speed, during the given time: see `tank.Push.then`."""
    path, now, since = basin.walls.path, float(drops.clock[0]), min(float(drops.clock[1]), float(drops.clock[0]))
    speed, seconds, before = float(room.asked[0]), float(room.asked[1]), float(path.speed[0])
    kept, first, here = np.empty((2, MOST_LINES)), displaced(path, since), displaced(path, now)
    count = 0
    if since < now:
        kept[0, 0], kept[1, 0], count = since, first, 1
    for k in range(path.count[0]):
        if since < path.lines[0, k] < now and count < MOST_LINES - PIECES - 2:
            kept[0, count], kept[1, count] = path.lines[0, k], path.lines[1, k]
            count += 1
    for k in range(PIECES + 1):
        passed = seconds * k / PIECES
        kept[0, count] = now + passed
        kept[1, count] = here + (before * passed + 0.5 * (speed - before) * passed**2 / seconds)
        count += 1
    kept[0, count] = now + 2.0 * seconds
    kept[1, count] = kept[1, count - 1] + speed * seconds
    path.count[0], path.speed[0] = count + 1, speed
    for k in range(path.count[0]):
        path.lines[0, k], path.lines[1, k] = kept[0, k], kept[1, k]


def measure_wall(basin: Basin, drops: Drops, room: Room) -> None:
    """Measure the displacement of the wall at present (m)."""
    room.answer[0] = displaced(basin.walls.path, drops.clock[0])


def measure_period(basin: Basin, drops: Drops, room: Room) -> None:
    """Measure the period of sloshing of the liquid with a level surface, in a tank of the given width: see
    `tank.Tank.period`.
    """
    width = float(room.asked[0])
    depth = float(np.sum(drops.mass)) / basin.equation_of_state.density / width
    pull = math.sqrt(basin.upright[0] ** 2 + basin.upright[1] ** 2)
    room.answer[0] = 2.0 * math.pi / max(wave_frequency(math.pi / width, depth, pull, 0.0), 1e-9)


def reflect(guard: Guard, drops: Drops, time: float) -> None:
    """Repeat the drift of particles that are outside after it, with reflections: see `walls.reflect_particles`."""
    sheet, dimension = guard.sheet, len(drops.position)
    out = np.zeros(drops.position.shape[1], np.bool_)
    flag_outside(drops.position, sheet.kind, sheet.number, guard.radius, out)
    x, v, hits = np.zeros((1, dimension)), np.zeros((1, dimension)), np.zeros(len(guard.owner), np.int64)
    before = np.zeros(dimension)
    number = sheet.number.copy()
    for k in range(len(number)):
        if sheet.kind[k, 0] == PLANE:  # the positions of moving planes before the drift, as in `walls._as_before`
            way = number[k, 0] * number[k, SPEED] + number[k, 1] * number[k, SPEED + 1]
            number[k, SIZE] -= time * (way + number[k, 2] * number[k, SPEED + 2])
    earlier = Sheet(sheet.kind, number, sheet.hole, sheet.part)
    for i in np.flatnonzero(out):
        status = np.zeros(1, np.int64)
        for axis in range(dimension):
            before[axis] = v[0, axis] = drops.velocity[axis, i]
            x[0, axis] = drops.position[axis, i] - time * before[axis]
        reflect_all(
            x,
            v,
            np.zeros((1, dimension)),
            time,
            earlier,
            np.array([guard.radius]),
            (np.zeros(1, np.int64), status, hits),
        )
        if status[0] < 0:
            for axis in range(dimension):
                x[0, axis] = drops.position[axis, i]
            _move_inside(guard, x[0], v[0], hits)
        for axis in range(dimension):
            drops.position[axis, i] = x[0, axis]
            drops.velocity[axis, i] += v[0, axis] - before[axis]
    drops.tally[GUARD_HITS] += hits.sum()


def renew(basin: Basin, drops: Drops, room: Room) -> bool:
    """Renew the lists at the present positions; at regular intervals, sort the particles into cells first. Returns
    False if the lists have no room.
    """
    if int(drops.tally[RENEWALS]) % SORT_EVERY == 0:
        sort(drops, sorted_in(drops.position, grid_around(drops.position, basin.support)).order)
    drops.tally[RENEWALS] += 1
    drops.reference[...] = drops.position
    drops.skin[0] = skin_for(basin, drops)  # type: ignore[arg-type]  # it reads fields of the same names
    drops.clock[1] = drops.clock[0]
    reach = basin.support + float(drops.skin[0])
    real = np.concatenate((drops.reference, basin.walls.position), axis=1)
    every = with_images(real, basin.walls.sides, reach, room)
    if FIELDS * every.shape[1] > len(room.fields):
        return False
    put_constant_fields(basin, drops, room)
    return find_neighbors(every, drops.position.shape[1], reach, room)


def sort(drops: Drops, order: Slots) -> None:
    """Reorder the particles."""
    for rows in (drops.position, drops.velocity, drops.acceleration):
        for axis in range(len(rows)):
            rows[axis] = rows[axis][order]
    for row in (drops.density, drops.density_rate, drops.mass):
        row[:] = row[order]
    for numbers in (drops.identity, drops.region):
        numbers[:] = numbers[order]


def grid_around(position: Array, reach: float) -> Grid:
    """The grid of cells as in `neighbor_rows.grid_around`, but with wider cells if single particles are far away."""
    most = 2.0 * position.shape[1] + 64.0
    low, wide = np.empty(len(position)), np.empty(len(position))
    for axis in range(len(position)):
        low[axis] = position[axis].min()
        wide[axis] = position[axis].max() - low[axis]
    size = reach
    while np.prod(wide / size + 1.0) > most:
        size *= 1.25
    edge = np.full(len(low), size)
    edge[-1] /= SLICES
    return Grid(low, edge, (wide / edge).astype(np.int64) + 1)


def sorted_in(position: Array, grid: Grid) -> Sorted:
    """The particles in the order of their cells."""
    count, cells = position.shape[1], int(np.prod(grid.shape))
    found = Sorted(np.empty_like(position), np.empty(count, np.int32), np.empty(cells + 1, np.int64))
    tally, cell = np.empty((1, cells), np.int32), np.empty(count, np.int32)
    _counting_sort(
        position, grid.low, grid.edge, grid.shape, cell, tally, found.position, found.order, found.start
    )  # fmt: skip
    return found


def with_images(real: Array, sides: Sides, reach: float, room: Room) -> Array:
    """The positions of all particles and of their images; the sources of the images are stored in `room`, as far as
    there is space.
    """
    here, room.first[0] = real, 0
    for side in range(len(sides.normal)):
        distance = distance_before(here, sides, side)
        near = np.flatnonzero((distance >= 0.0) & (distance < reach))
        begin = room.first[side]
        room.first[side + 1] = begin + len(near)
        if begin + len(near) <= len(room.source):
            room.source[begin : begin + len(near)] = near
        here = np.concatenate((here, behind(here[:, near], sides, side)), axis=1)
    return here


def find_neighbors(position: Array, liquid: int, reach: float, room: Room) -> bool:
    """Fill the lists as `neighbor_rows.neighbor_lists` does. Returns whether they had room."""
    grid, real = grid_around(position, reach), len(room.counts)
    cells = sorted_in(position, grid)
    longest = _longest_run(cells.start, 2 * math.ceil(reach / grid.edge[-1]) + 2)
    limits = np.array([liquid, real, longest])
    for fills in (False, True):
        if fills:
            for i in range(real):
                room.start[i + 1] = room.start[i] + (room.counts[i] + STRIDE - 1) // STRIDE * STRIDE
            if room.start[real] > len(room.neighbor):
                return False
        _search(
            cells.position, cells.order, cells.start, grid.low, grid.edge, grid.shape, reach, limits,
            room.counts, room.start, room.neighbor, fills,
        )  # fmt: skip
    return True


def table_of(room: Room) -> Floats:
    """The table of fields, (fields, liquid and dummies and images). It has no column without a particle, since loops
    of the model fill and read all columns.
    """
    columns = len(room.counts) + int(room.first[-1])
    found: Floats = room.fields[: FIELDS * columns].reshape((FIELDS, columns))
    return found


def evaluate_density_rate(basin: Basin, drops: Drops, room: Room) -> None:
    """Evaluate the rate of density at the present positions."""
    table = table_of(room)
    fill(basin, drops, room, table)
    lists = Lists(room.counts, room.start, room.neighbor)
    fill_records(table, room.records, basin.rows[OF_CONTINUITY], True)
    sum_continuity(
        room.rates, table, room.records, table[0], lists, basin.constants, basin.kernel, basin.like, ()
    )  # fmt: skip
    store_density_rate(drops.density_rate, room.rates, drops.density, basin.by_mass)


def evaluate_accelerations(basin: Basin, drops: Drops, room: Room) -> None:
    """Evaluate the accelerations at the present positions: by pressure, gravity and walls."""
    table = table_of(room)
    fill(basin, drops, room, table)
    lists = Lists(room.counts, room.start, room.neighbor)
    fill_records(table, room.records, basin.rows[OF_PRESSURE], True)
    sum_pressure(
        room.rates, table, room.records, table[0], lists, basin.constants, basin.kernel, basin.like, ()
    )  # fmt: skip
    density: Any = table[FIELD.density, : len(drops.density)]
    store_acceleration(drops.acceleration, room.rates, density, basin.gravity, basin.per_volume)
    guard, sound = basin.walls.guard, basin.equation_of_state.sound_speed
    kind, number = guard.sheet.kind, guard.sheet.number
    repel(drops.position, kind, number, guard.reach, basin.repulsion, drops.acceleration)
    brake(drops.position, drops.velocity, kind, number, guard.support, guard.weights, sound, drops.acceleration)


def fill(basin: Basin, drops: Drops, room: Room, table: Floats) -> None:
    """Fill the fields of the liquid, of the dummies, and of the images of both."""
    liquid, count, real = basin.equation_of_state, len(drops.density), len(room.counts)
    fill_liquid(
        table, drops.position, drops.velocity, drops.density, drops.density_rate, drops.pressure, drops.mass,
        basin.origin, basin.by_mass, basin.bulk_viscosity, liquid,
    )  # fmt: skip
    source = room.source[: room.first[-1]]
    fill_images(source, table, real, room.first, basin.walls.table, basin.gravity, liquid)
    if real > count:
        pulls = np.empty((len(basin.gravity), real - count))
        for axis in range(len(basin.gravity)):
            pulls[axis] = basin.gravity[axis]
        lists = Lists(room.counts, room.start, room.neighbor)
        read_liquid(table, count, lists, basin.constants, pulls, basin.walls_clip, liquid)
        fill_images(source, table, real, room.first, basin.walls.table, basin.gravity, liquid)
    fill_weights(table, count, basin.by_mass)


def lean(basin: Basin, drops: Drops, room: Room) -> None:
    """Rotate gravity relative to the tank by the given angle, as `rigid_bodies.at` does for the acceleration of a
    tank.
    """
    more = tilted(basin.upright[0], basin.upright[1], room.asked[0])
    for axis in range(len(basin.gravity)):
        basin.gravity[axis] = basin.upright[axis] + more[axis]
    constants = basin.constants[0]
    constants.rise_x, constants.rise_y = basin.rise[0] + basin.spring * more[0], basin.rise[1] + basin.spring * more[1]


def tilted(x: float, y: float, angle: float) -> tuple[float, float]:
    """The additional acceleration (m/s^2) in a tank tilted by an angle (rad): rotated gravity minus gravity.

    >>> tilted(0.0, -9.81, 0.0)
    (0.0, 0.0)
    """
    cosine, sine = math.cos(angle), math.sin(angle)
    return x * (cosine - 1.0) - y * sine, x * sine + y * (cosine - 1.0)


def measure_gap(basin: Basin, drops: Drops, room: Room) -> None:
    """Measure the distance (m) of the given position from the nearest wall or solid, negative inside."""
    place_wall(basin.walls, drops.clock[0])
    sheet = basin.walls.guard.sheet
    room.answer[0] = worst_gap(sheet.kind, sheet.number, (room.asked[0], room.asked[1], 0.0), 0.0)[0]


def put_constant_fields(basin: Basin, drops: Drops, room: Room) -> None:
    """Fill the fields of liquid and dummies that do not change, in a table for the present number of images."""
    walls, count, table = basin.walls, len(drops.density), table_of(room)
    for row in range(len(table)):
        for i in range(table.shape[1]):
            table[row, i] = 0.0
    for i in range(table.shape[1]):  # to avoid a division by zero in dummies that have not been filled
        table[FIELD.density, i] = 1.0
    for i in range(count):
        table[FIELD.liquid, i] = 1.0
    for k in range(len(walls.volume)):
        for axis in range(len(walls.position)):
            table[FIELD.position + axis, count + k] = walls.position[axis, k] - basin.origin[axis]
        table[FIELD.volume, count + k] = walls.volume[k]
