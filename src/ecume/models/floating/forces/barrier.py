"""A barrier: one or two sides of a rectangular dish that move, or all sides of any dish, and the forces on the sides.

In a step the barrier moves at a constant velocity, which is that of its row in the contact solve: contacts stop floats
relative to it. Its position is a function of the time, and a part of the state, as are the impulses of contacts with
walls since the last frame. Its work on floats is the impulse of contacts times its velocity, and the change of the
energy of its meniscus while it moves: half before the drift of the floats, half after it.

A barrier that presses on a raft of hard floats has no bounded force. It stops permanently where the surface pressure,
averaged over a tenth of a radius of its path, exceeds a limit; a single collision would exceed any limit in a short
step. It also stops if the contacts of a step have no solution: the barrier and all floats in contact, which the step
would compress, keep the positions that they had before this step.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume.engine.cells import Integers
from ecume.engine.contact.impulse_solvers import normal_velocities
from ecume.engine.walls import Walls, surfaces
from ecume.laws import rafts
from ecume.models.floating.dishes import acts, wall_energy, wall_force, wall_law_of, walls_of
from ecume.models.floating.options import Built, scene_error
from ecume.models.floating.parameters import PUSHES, UNCONVERGED, WORK, Parameters, State, Workspace, part_of
from ecume.models.liquids import liquid_of
from ecume.units import Array, duration_text, with_prefix

if TYPE_CHECKING:
    from ecume.scenes.floating import BarrierSpec, DishSpec, FloatingScene

SIDES = ("left", "bottom", "right", "top")
"""The sides of a rectangular dish, in the order of its walls."""
ELAPSED, PLACE, STOPPED, DONE, MEAN, LENGTH = range(6)
"""Numbers of `State.tally`, counted from its entry `numbers_of`: the time since the last frame (s), the distance of the
barrier from its side (m), whether it has stopped, its work (J), the mean pressure (N/m); and their end. Before them are
the impulses (N s) on all sides since the last frame, by contacts and menisci, from the entry `sums_of`, and before
these, from `PUSHES`, those by contacts in this step.
"""
SQUEEZED = 0.01
"""The approach of a contact that has no room, over the speed of the barrier, which a row of a hundred shares."""
JUMP = 0.25
"""The farthest way of a float that is pushed in one step, over the smallest radius."""
LATE = 1.5
"""The largest speed of a barrier that is late, over the highest of its motion."""
SMOOTHING = 0.1
"""The way over which the pressure is averaged, over the smallest radius."""
RADII = 0.2
"""The time scale of the motion of a barrier, in radii over its speed. A time step is a twentieth of it, so that a
barrier stops within a hundredth of a radius of where a raft has no room.
"""
WIDEST_MENISCI = 5.0
"""The least distance of facing walls, in capillary lengths: their menisci change by less than one percent there."""


class Barrier(NamedTuple):
    """Constants of a barrier."""

    walls: Integers
    """(K,) the numbers of the walls that move, one or two"""
    sides: Array
    """(4,) m: the offsets of all walls where the barrier is at its side"""
    times: Array
    """s: when the velocity changes"""
    places: Array
    """m: the distance from the side at these times"""
    rates: Array
    """m/s: the velocity from then on"""
    width: float
    """m: the length of all parts of the barrier at their sides"""
    narrowing: float
    """the decrease of this length over the way of a barrier that closes; zero for straight ones"""
    largest_pressure: float
    """N/m"""
    smoothing: float
    """m: the way over which the pressure is averaged before it is compared with the largest one"""


class BarrierScratch(NamedTuple):
    """The walls in this step, and the rows of walls in the contact solve."""

    offset: Array
    """(4,) m: of the walls at present"""
    step: Array
    """m, m, m/s: the places of the barrier before and after this step, its velocity; and the number of steps before it
    whose contacts did not converge"""
    midstep_velocity: Array
    before: Array
    """(N + walls, 2) m/s: those of the workspace"""
    decay: float
    """the fraction of a velocity that remains after the drag of one kick, the least of all floats"""


@compiled_inside
def sums_of(part: Barrier) -> int:
    """The first entry of `State.tally` with the impulses on the sides since the last frame."""
    return PUSHES + len(part.sides)


@compiled_inside
def numbers_of(part: Barrier) -> int:
    """The first entry of `State.tally` with the numbers of the barrier."""
    return PUSHES + 2 * len(part.sides)


@compiled_inside
def length_at(part: Barrier, place: float) -> float:
    """The length of all parts of the barrier (m) at a distance from their sides."""
    return part.width - part.narrowing * place


@compiled_inside
def place_at(part: Barrier, time: float) -> float:
    """The distance of the barrier from its side (m)."""
    number = max(int(np.searchsorted(part.times, time, side="right")) - 1, 0)
    since = max(time - part.times[number], 0.0)
    return float(max(part.places[number] + part.rates[number] * since, 0.0))


@compiled
def place_after(part: Barrier, here: float, time: float, step: float) -> float:
    """The distance of the barrier from its side at a time (m), after a step from `here`; a barrier that is late moves
    faster only as far as the contacts of floats reach.
    """
    there, fastest = place_at(part, time), 0.0
    for rate in part.rates:
        fastest = max(fastest, abs(rate))
    farthest = LATE * fastest * step
    return here + min(max(there - here, -farthest), farthest) if abs(there - here) > farthest else there


@compiled
def put_walls(part: Barrier, offset: Array, place: float) -> None:
    """Move the walls to a distance from their sides (m)."""
    for number in part.walls:
        offset[number] = part.sides[number] + place


@compiled
def menisci_of_walls(walls: Integers, parameters: Parameters, position: Array) -> float:
    """The energy of all floats in the menisci of these walls (J)."""
    total, strength, charge = 0.0, parameters.wall_strength, parameters.floats.charge
    for number in walls:
        for i in range(len(position)):
            place = position[i, 0], position[i, 1]
            tilted, mirrored = wall_energy(parameters, number, place, strength[number, i], charge[i])
            total += tilted + mirrored
    return total


@compiled
def add_pull_of_menisci(part: Barrier, tally: Array, parameters: Parameters, position: Array) -> None:
    """Add the reactions of menisci on all sides in a step to the impulses on them."""
    strength, charge = parameters.wall_strength, parameters.floats.charge
    for number in range(len(part.sides)):
        for i in range(len(position)):
            place = position[i, 0], position[i, 1]
            away = wall_force(parameters, number, place, strength[number, i], charge[i])[0]
            tally[sums_of(part) + number] += parameters.time_step * away


@compiled
def set_barrier_velocity(part: Barrier, scratch: BarrierScratch, parameters: Parameters, speed: float) -> None:
    """Write the velocity of the barrier into the rows of walls, reduced by drag as that of a float: a float that moves
    with the barrier then does not collide with it in each step.
    """
    scratch.step[2], count = speed, len(parameters.floats.radius)
    for number in part.walls:
        for axis in range(2):
            along = speed * parameters.walls.normal[number, axis]
            scratch.midstep_velocity[count + number, axis] = along
            scratch.before[count + number, axis] = scratch.decay * along


@compiled
def move_barrier(part: Barrier, scratch: BarrierScratch, parameters: Parameters, state: State, first: bool) -> None:
    """Before a step, choose the velocity of the barrier; after it, add the work and the impulses of the step."""
    tally, time, own = state.tally, parameters.time_step, numbers_of(part)
    if not first:
        finish_barrier(part, scratch, parameters, state)
        return
    if state.step[0] % parameters.steps_per_frame == 0:
        tally[own + ELAPSED] = 0.0
        for number in range(len(part.sides)):
            tally[sums_of(part) + number] = 0.0
    for number in range(len(part.sides)):
        tally[PUSHES + number] = 0.0
    here = tally[own + PLACE]
    there = here if tally[own + STOPPED] > 0.0 else place_after(part, here, (state.step[0] + 1) * time, time)
    scratch.step[0], scratch.step[1], scratch.step[3] = here, there, tally[UNCONVERGED]
    set_barrier_velocity(part, scratch, parameters, (there - here) / time)


@compiled
def carry_barrier(
    part: Barrier, scratch: BarrierScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Move the barrier after the contacts before the drift, or stop it if these contacts have no solution."""
    tally, pushed, own = state.tally, 0.0, numbers_of(part)
    for number in part.walls:
        pushed += tally[PUSHES + number]
    unsolved = pushed > 0.0 and scratch.step[2] != 0.0 and tally[UNCONVERGED] > scratch.step[3]
    # Contacts with friction may fail to converge, too, but with smaller approaches.
    if unsolved and fastest_approach(workspace) > SQUEEZED * abs(scratch.step[2]):
        tally[own + STOPPED], scratch.step[1] = 1.0, scratch.step[0]
        tally[UNCONVERGED] = scratch.step[3]
        for number in range(len(part.sides)):
            tally[PUSHES + number] = 0.0
        set_barrier_velocity(part, scratch, parameters, 0.0)
        stop_raft(state, workspace)
    elif pushed > 0.0:
        slow_down(part, scratch, parameters, state, workspace)
    tally[own + PLACE] = scratch.step[1]
    middle = 0.5 * (scratch.step[0] + scratch.step[1])
    add_work_of_menisci(part, scratch, parameters, state, (scratch.step[0], middle))
    put_walls(part, scratch.offset, scratch.step[1])


@compiled
def slow_down(
    part: Barrier, scratch: BarrierScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Let the barrier and all floats go a part of their way in a step in which a float that is pushed would jump, as
    where a nearly straight chain snaps aside: beyond a quarter of a radius its contacts cannot be predicted. No gap
    closes on a part of a way on the whole of which none does. Without inertia, forces are in proportion to the ways.
    """
    contacts, velocity, count, fastest = workspace.contacts, workspace.midstep_velocity, len(state.position), 0.0
    for row in range(contacts.total[0]):
        for i in (contacts.first[row], contacts.second[row]):
            if contacts.impulse[row] > 0.0 and i < count:
                fastest = max(fastest, math.hypot(velocity[i, 0], velocity[i, 1]))
    farthest = JUMP * parameters.floats.radius.min()
    if fastest * parameters.time_step <= farthest:
        return
    share = farthest / (fastest * parameters.time_step)
    for i in range(count):
        for axis in range(velocity.shape[1]):
            velocity[i, axis] *= share
        # Without inertia the velocities in frames are those of the motion; inertia keeps what contacts have left.
        for axis in range(0 if parameters.scheme.inertia else 2):
            state.velocity[i, axis] *= share
    scratch.step[1] = scratch.step[0] + share * (scratch.step[1] - scratch.step[0])
    scratch.step[2] *= share
    for number in range(len(part.sides)):
        state.tally[PUSHES + number] *= 1.0 if parameters.scheme.inertia else share


@compiled
def fastest_approach(workspace: Workspace) -> float:
    """The highest speed at which contacts still close more than their gaps after their solve (m/s)."""
    contacts, fastest = workspace.contacts, 0.0
    normal_velocities(contacts, workspace.midstep_velocity, contacts.scratch)
    for row in range(contacts.total[0]):
        fastest = max(fastest, contacts.bound[row] - contacts.scratch[row])
    return fastest


@compiled
def stop_raft(state: State, workspace: Workspace) -> None:
    """Stop all floats that touch, in a step in which contacts have no solution: they keep their positions."""
    contacts, count = workspace.contacts, len(state.position)
    for row in range(contacts.total[0]):
        if contacts.impulse[row] > 0.0:
            for i in (contacts.first[row], contacts.second[row]):
                if i < count:
                    state.velocity[i, 0], state.velocity[i, 1] = 0.0, 0.0
                    for axis in range(workspace.midstep_velocity.shape[1]):
                        workspace.midstep_velocity[i, axis] = 0.0


@compiled
def add_work_of_menisci(
    part: Barrier, scratch: BarrierScratch, parameters: Parameters, state: State, way: tuple[float, float]
) -> None:
    """Add the change of the energy of the barrier's meniscus on a part of its path, with the floats at rest."""
    if not acts(parameters) or way[0] == way[1]:
        return
    put_walls(part, scratch.offset, way[0])
    before = menisci_of_walls(part.walls, parameters, state.position)
    put_walls(part, scratch.offset, way[1])
    work = menisci_of_walls(part.walls, parameters, state.position) - before
    state.tally[WORK] += work
    state.tally[numbers_of(part) + DONE] += work


@compiled
def finish_barrier(part: Barrier, scratch: BarrierScratch, parameters: Parameters, state: State) -> None:
    """Add the work and the impulses of a step to the totals."""
    tally, there, own = state.tally, scratch.step[1], numbers_of(part)
    add_work_of_menisci(part, scratch, parameters, state, (0.5 * (scratch.step[0] + there), there))
    if acts(parameters):
        add_pull_of_menisci(part, tally, parameters, state.position)
    for number in range(len(part.sides)):
        tally[sums_of(part) + number] += tally[PUSHES + number]
    pushed = 0.0
    for number in part.walls:
        pushed += tally[PUSHES + number]
    tally[own + DONE] += scratch.step[2] * pushed
    tally[WORK] += scratch.step[2] * pushed
    tally[own + ELAPSED] += parameters.time_step
    moved = abs(scratch.step[1] - scratch.step[0])
    pressure = pushed / (parameters.time_step * length_at(part, there))
    tally[own + MEAN] += moved / (moved + part.smoothing) * (pressure - tally[own + MEAN])
    if tally[own + MEAN] > part.largest_pressure:
        tally[own + STOPPED] = 1.0


def no_barrier_energy(
    part: Barrier, scratch: Any, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """Return zero: the energy of wall menisci belongs to the pair law, also where walls move."""
    return 0.0, 0.0


def with_barrier(part: Barrier, state: State) -> State:
    """Return the state with the barrier at its initial position."""
    tally = np.zeros(numbers_of(part) + LENGTH)
    tally[: WORK + 1] = state.tally[: WORK + 1]
    tally[numbers_of(part) + PLACE] = place_at(part, 0.0)
    return state._replace(tally=tally)


def make_barrier_scratch(part: Barrier, parameters: Parameters, state: State, workspace: Workspace) -> BarrierScratch:
    """Return the workspace, with the walls at their positions in the state."""
    offset, place = part.sides.copy(), float(state.tally[numbers_of(part) + PLACE])
    put_walls(part, offset, place)
    decay = float(parameters.kick.decay.min())
    return BarrierScratch(
        offset, np.array([place, place, 0.0, 0.0]), workspace.midstep_velocity, workspace.before, decay
    )


def moved_walls(scratch: BarrierScratch, walls: Walls) -> Walls:
    """The walls at the positions to which steps have moved them; later steps change these arrays."""
    return walls._replace(offset=scratch.offset)


def with_walls_of(parameters: Parameters, state: State) -> Parameters:
    """The parameters with the walls at their positions in this state."""
    part = part_of(parameters, Barrier)
    if part is None:
        return parameters
    offset = part.sides.copy()
    put_walls(part, offset, float(state.tally[numbers_of(part) + PLACE]))
    return parameters._replace(walls=parameters.walls._replace(offset=offset))


def barrier_numbers(part: Barrier, state: State) -> dict[str, tuple[float, str]]:
    """The place of the barrier, the mean forces on all sides since the last frame, outward, and the work so far."""
    own, count = numbers_of(part), len(part.sides)
    time, place, stopped, work = state.tally[own : own + DONE + 1].tolist()
    force = [each / time if time > 0.0 else 0.0 for each in state.tally[sums_of(part) : own].tolist()]
    pushed = sum(force[number] for number in part.walls)
    forces = dict(zip(SIDES, force, strict=True)) if count == len(SIDES) else {"wall": pushed}
    return {
        "barrier_position": (place, "m"),
        "surface_pressure": (pushed / length_at(part, place), "N/m"),
        "barrier_work": (work, "J"),
        "barrier_stopped": (stopped, "1"),
        **{f"force_on_{side}": (each, "N") for side, each in forces.items()},
    }


# --- From a scene


def motion_of(barrier: BarrierSpec) -> tuple[Array, Array, Array]:
    """The times (s) at which the velocity changes, the positions at these times (m), and the velocities after them
    (m/s).
    """
    if barrier.velocity is None:
        times, places = np.array(barrier.times), np.array(barrier.positions)
        return times, places, np.append(np.diff(places) / np.diff(times), 0.0)
    speed = barrier.velocity
    stop = 0.0 if barrier.stop is None and speed < 0.0 else barrier.stop
    if stop is None or speed == 0.0:
        return np.zeros(1), np.array([barrier.start]), np.array([speed])
    end = (stop - barrier.start) / speed
    if end == 0.0:
        return np.zeros(1), np.array([stop]), np.zeros(1)
    return np.array([0.0, end]), np.array([barrier.start, stop]), np.array([speed, 0.0])


def fastest_barrier(dish: DishSpec | None) -> float:
    """The highest speed of a barrier (m/s)."""
    if dish is None or dish.barrier is None:
        return 0.0
    return float(np.abs(motion_of(dish.barrier)[2]).max())


def _moving(barrier: BarrierSpec, count: int) -> list[int]:
    """The numbers of the walls that move, of this many."""
    if barrier.closes:
        return list(range(count))
    number = SIDES.index(barrier.side)
    return sorted({number, (number + 2) % count}) if barrier.both else [number]


def walls_at_start(walls: Walls, dish: DishSpec | None) -> Walls:
    """The walls at the start of a scene, from those of its dish: the largest region, from which the ranges of forces
    are chosen.
    """
    if dish is None or dish.barrier is None:
        return walls
    offset = walls.offset.copy()
    offset[_moving(dish.barrier, len(offset))] += motion_of(dish.barrier)[1][0]
    return walls._replace(offset=offset)


def barrier_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """The barrier of a scene. Raises SceneError if it leaves too little room."""
    dish = scene.dish
    assert dish is not None  # noqa: S101  # for the type checker: the scene has chosen it
    assert dish.barrier is not None  # noqa: S101
    barrier, walls, limit = dish.barrier, walls_of(dish), dish.barrier.largest_pressure
    moving = _moving(barrier, len(walls.offset))
    if scene.shaped and wall_law_of(scene):
        raise scene_error(
            "dish.law", "got a meniscus on a barrier, and floats with a shape; expected dish.law = 'none': its work is "
            "known on one charge of each float, not on all points of a contact line"
        )  # fmt: skip
    if limit is None:
        limit = rafts.buckling_pressure(liquid_of(scene), 2.0 * float(parameters.floats.radius.max()))
    smoothing = SMOOTHING * float(parameters.floats.radius.min())
    lengths, narrowing = _lengths(walls)
    part = Barrier(
        np.array(moving), walls.offset.copy(), *motion_of(barrier), sum(lengths[number] for number in moving),
        narrowing if barrier.closes else 0.0, limit, smoothing,
    )  # fmt: skip
    if barrier.closes:
        _require_room_around(barrier, parameters, walls, farthest_place(part, scene.duration))
    else:
        across = SIDES.index(barrier.side) + 1  # a side that the barrier meets
        _require_room(part, parameters, scene, lengths[across % len(SIDES)])
    fastest = fastest_barrier(dish)
    return Built(part, RADII * float(parameters.floats.radius.min()) / fastest if fastest > 0.0 else math.inf)


def _lengths(walls: Walls) -> tuple[list[float], float]:
    """The lengths (m) of the sides of an enclosure by lines, in their order, and the decrease of their sum as all sides
    move inward, over the way.
    """
    lengths = np.diff(surfaces.side_ends(walls), axis=1)[:, 0]
    around = np.sort(np.arctan2(walls.normal[:, 1], walls.normal[:, 0]))
    turns = np.diff(around, append=around[0] + 2.0 * np.pi)
    return lengths.tolist(), 2.0 * float(np.sum(np.tan(0.5 * turns)))


def _require_room_around(barrier: BarrierSpec, parameters: Parameters, walls: Walls, farthest: float) -> None:
    """Raise SceneError if the floats cannot fit into what a wall that closes leaves at its farthest place (m), or if it
    loses a side.
    """
    radius, key = parameters.floats.radius, f"dish.barrier.{_key_of_place(barrier, farthest)}"
    ends = surfaces.side_ends(walls._replace(offset=walls.offset + farthest + float(radius.max())))
    fits = bool(np.all(ends[:, 1] > ends[:, 0]))
    covered = math.pi * float(np.sum(radius**2))
    if not fits or surfaces.area(walls._replace(offset=walls.offset + farthest)) < covered:
        got = f"the wall closes by {with_prefix(farthest, 'm', 3)}"
        raise scene_error(key, f"{got}, where the floats do not fit or a side vanishes; expected a shorter way")


def farthest_place(part: Barrier, duration: float) -> float:
    """The farthest place of the barrier until this time (m)."""
    reached = part.places[part.times <= duration]
    return float(max(reached.max(initial=0.0), place_at(part, duration)))


def _key_of_place(barrier: BarrierSpec, place: float) -> str:
    """The key that determines how far the barrier moves."""
    if barrier.velocity is None:
        return "positions"
    return "start" if place <= barrier.start else "stop"


def _require_room(part: Barrier, parameters: Parameters, scene: FloatingScene, length: float) -> None:
    """Raise SceneError if the floats cannot fit between the barrier and the other side, or if menisci overlap."""
    farthest, largest = farthest_place(part, scene.duration), 2.0 * float(parameters.floats.radius.max())
    key = f"dish.barrier.{_key_of_place(scene.dish.barrier, farthest)}"  # type: ignore[union-attr,arg-type]
    left, covered = length - len(part.walls) * farthest, math.pi * float(np.sum(parameters.floats.radius**2))
    got = f"the barrier leaves {with_prefix(max(left, 0.0), 'm', 3)} of the dish's {with_prefix(length, 'm', 3)}"
    width = part.width / len(part.walls)
    most = (length - max(covered / width, largest)) / len(part.walls)
    if left * width < covered or left < largest:
        at_most = with_prefix(max(most, 0.0), "m", 3)
        raise scene_error(key, f"{got}, where the floats do not fit; expected at most {at_most} from its side")
    apart = WIDEST_MENISCI * float(liquid_of(scene).capillary_length)
    if wall_law_of(scene) and left < apart:
        least = with_prefix(apart, "m", 3)
        raise scene_error(
            key, f"{got}, where the menisci of both sides would be one; expected at least {least} "
            f"({WIDEST_MENISCI:g} capillary lengths), or dish.law = 'none'"
        )  # fmt: skip


def barrier_lines(part: Barrier, parameters: Parameters) -> list[tuple[str, str, str]]:
    """The rows of `ecume check`: the motion of the barrier, and the pressure at which it stops."""
    names = "the whole wall" if part.narrowing > 0.0 else " and ".join(SIDES[number] for number in part.walls)
    fastest, last = float(np.abs(part.rates).max()), float(part.times[-1])
    start, end = (with_prefix(float(place), "m", 3) for place in part.places[[0, -1]])
    until = f"to {end} at {duration_text(last)}" if len(part.times) > 1 else "to the end"
    return [
        ("barrier", names, f"at most {with_prefix(fastest, 'm/s', 3)}; from {start} {until}"),
        ("largest pressure", with_prefix(part.largest_pressure, "N/m", 3), "where the barrier stops for good"),
    ]
