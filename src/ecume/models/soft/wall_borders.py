"""Walls that yield to forces, in Newton's step: their places border the spheres' system, like a box's shear."""

from __future__ import annotations

from ecume._jit import compiled, compiled_inside, where_there
from ecume.models.soft.links import ROUNDING, dot
from ecume.models.soft.spins import cross
from ecume.models.soft.walls import Places, Walls, add_wrench, displaced, normal_of, pressed
from ecume.units import Array


@compiled
def column_of_wall(walls: Walls, to: tuple[Array, Array], unknown: int, dimensions: int) -> None:
    """The forces on spheres that a wall's displacement changes, and how its own force changes with the spheres'."""
    (column, rows), touches = to, walls.touches
    wall, axis = walls.places.free[unknown]
    along = (1.0 if axis == 0 else 0.0, 1.0 if axis == 1 else 0.0, 1.0 if axis == 2 else 0.0)
    column[:] = 0.0
    rows[:] = 0.0
    for c in range(len(touches.first)):
        if touches.wall[c] == wall:
            i, n = touches.first[c], normal_of(walls.places, wall)
            f = pressed(touches.stiffness, c, along)
            add_wrench(column, i, dimensions, (f, cross(n, f)))
            for k in range(rows.shape[1]):
                rows[i, k] += dot(pressed(touches.stiffness, c, displaced(k, dimensions, n)), along)


@compiled_inside
def wanted_force(places: Places, unknown: int, load: tuple[float, float]) -> float:
    """What pushes or pulls a wall that yields (N); what shears it goes by the shear of walls, too."""
    wall, axis = places.free[unknown]
    along = 1.0 if axis == places.axis[wall] else load[1]
    return float(load[0] * along * places.force[wall, axis])


@compiled
def corner_of_walls(walls: Walls, load: tuple[float, float], borders: tuple[Array, Array]) -> None:
    """What is missing of the force on each wall that yields, and how it changes with the walls."""
    (left, corner), touches, free = borders, walls.touches, walls.places.free
    for one in range(len(free)):
        wall, axis = free[one]
        left[one] = -wanted_force(walls.places, one, load)
        corner[one, :] = 0.0
        for c in range(len(touches.first)):
            if touches.wall[c] == wall:
                left[one] += touches.force[c, axis] + touches.correction[c, axis]
                for other in range(len(free)):
                    if free[other, 0] == wall:
                        corner[one, other] += touches.stiffness[c, axis, free[other, 1]]


@where_there(0.0)
def missing_at_walls(walls: Walls, position: Array, load: tuple[float, float]) -> float:
    """The largest part of a force on a wall that is missing, less rounding."""
    touches, worst = walls.touches, 0.0
    for unknown in range(len(walls.places.free)):
        wall, axis = walls.places.free[unknown]
        wanted = wanted_force(walls.places, unknown, load)
        total, whole, rounding = -wanted, abs(wanted), 0.0
        for c in range(len(touches.first)):
            if touches.wall[c] == wall:
                total += touches.force[c, axis]
                whole += abs(touches.force[c, axis])
                size = abs(walls.places.place[wall, axis]) + abs(position[touches.first[c], axis])
                rounding += ROUNDING * abs(touches.stiffness[c, axis, axis]) * size
        if whole > 0.0:
            worst = max(worst, (abs(total) - rounding) / whole)
    return worst
