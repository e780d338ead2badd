"""How walls move through the stages of a step, and the contacts at them with the spheres."""

from __future__ import annotations

from ecume._jit import where_there
from ecume.engine.array_copies import clear_rows, copy_line, copy_rows
from ecume.models.soft.schemes import Scheme
from ecume.models.soft.spins import axial, cross
from ecume.models.soft.walls import Walls, displaced, normal_of
from ecume.units import Array


@where_there(0.0)
def shift_at_walls(walls: Walls, change: Array, dimensions: int) -> float:
    """What Newton's change does to the contacts with walls; how much at most."""
    touches, places = walls.touches, walls.places
    shift, response, largest = touches.shift, touches.response, 0.0
    for c in range(len(touches.first)):
        i, w = touches.first[c], touches.wall[c]
        n = normal_of(places, w)
        x, y, z = places.change[w, 0], places.change[w, 1], places.change[w, 2]
        for k in range(change.shape[1]):
            by = displaced(k, dimensions, n)
            x, y, z = x + change[i, k] * by[0], y + change[i, k] * by[1], z + change[i, k] * by[2]
        for k in range(4):
            shift[c, k] += response[c, k, 0] * x + response[c, k, 1] * y + response[c, k, 2] * z
            largest = max(largest, abs(shift[c, k]))
    return largest


@where_there()
def move_walls(walls: Walls, part: float) -> None:
    """Add a part of Newton's change to walls and their contacts."""
    touches, places = walls.touches, walls.places
    for w in range(len(places.place)):
        for k in range(3):
            places.place[w, k] += part * places.change[w, k]
    for c in range(len(touches.first)):
        touches.log_gap[c] += part * touches.shift[c, 0]
        for k in range(3):
            touches.slip[c, k] += part * touches.shift[c, 1 + k]


@where_there()
def first_walls(walls: Walls) -> None:
    """Walls and contacts at the step's beginning."""
    touches, places = walls.touches, walls.places
    copy_rows(places.place, places.before)
    copy_rows(places.start, places.before)
    clear_rows(places.change)
    copy_rows(places.slope[0], places.past)
    copy_line(touches.log_gap, touches.log_gap_before)
    copy_rows(touches.slip, touches.slip_before)
    copy_line(touches.log_gap_start, touches.log_gap_before)
    copy_rows(touches.slip_start, touches.slip_before)


@where_there()
def slopes_at_walls(walls: Walls) -> None:
    """How fast contacts and walls go at the step's beginning."""
    copy_rows(walls.touches.rate[0], walls.touches.now)


@where_there()
def begin_walls(walls: Walls, scheme: Scheme, stage: int, time_step: float) -> None:
    """Where a stage starts from, and where walls that move as they are told will be at its end."""
    touches, places, rows = walls.touches, walls.places, scheme.rows
    for c in range(len(touches.first)):
        touches.log_gap_start[c] = touches.log_gap_before[c]
        for k in range(3):
            touches.slip_start[c, k] = touches.slip_before[c, k]
        for earlier in range(stage):
            touches.log_gap_start[c] += time_step * rows[stage, earlier] * touches.rate[earlier, c, 0]
            for k in range(3):
                touches.slip_start[c, k] += time_step * rows[stage, earlier] * touches.rate[earlier, c, 1 + k]
    for w in range(len(places.place)):
        for k in range(3):
            places.start[w, k] = places.before[w, k]
            for earlier in range(stage):
                places.start[w, k] += time_step * rows[stage, earlier] * places.slope[earlier, w, k]
            if places.velocity[w, k] != 0.0:
                places.place[w, k] = places.before[w, k] + scheme.times[stage] * time_step * places.velocity[w, k]


@where_there()
def end_walls(walls: Walls, stage: int, span: float) -> None:
    """The slopes of a solved stage."""
    touches, places = walls.touches, walls.places
    for c in range(len(touches.first)):
        touches.rate[stage, c, 0] = (touches.log_gap[c] - touches.log_gap_start[c]) / span
        for k in range(3):
            touches.rate[stage, c, 1 + k] = (touches.slip[c, k] - touches.slip_start[c, k]) / span
    for w in range(len(places.place)):
        for k in range(3):
            moved = places.velocity[w, k]
            places.slope[stage, w, k] = moved if moved != 0.0 else (places.place[w, k] - places.start[w, k]) / span


@where_there(0.0)
def wall_error(walls: Walls, scheme: Scheme, time_step: float) -> float:
    """The largest difference from the embedded scheme, of ln(gap) or of a slip in radii."""
    touches, weights = walls.touches, scheme.error
    largest = 0.0
    for c in range(len(touches.first)):
        for k in range(4):
            value = 0.0
            for stage in range(len(weights)):
                value += weights[stage] * touches.rate[stage, c, k]
            largest = max(largest, abs(time_step * value))
    return largest


@where_there()
def accept_walls(walls: Walls, turn: Array) -> None:
    """The end of a step is the next one's beginning, from where spins are counted anew: slips keep what was rolled."""
    touches, places = walls.touches, walls.places
    for c in range(len(touches.first)):
        touches.log_gap_before[c] = touches.log_gap[c]
        rolled = (0.0, 0.0, 0.0)
        if turn.shape[1] > 0:
            rolled = cross(axial(turn, touches.first[c]), normal_of(places, touches.wall[c]))
        radius = touches.radius[c]
        touches.slip[c, 0] += rolled[0] / radius
        touches.slip[c, 1] += rolled[1] / radius
        touches.slip[c, 2] += rolled[2] / radius
        for k in range(3):
            touches.slip_before[c, k] = touches.slip[c, k]
    copy_rows(places.before, places.place)
    copy_rows(places.past, places.slope[-1])
