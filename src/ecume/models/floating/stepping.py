"""One step of floating bodies, and the march of many.

Kick, meet, drift, kick, rest: the velocity Verlet scheme with unilateral constraints, as RATTLE is with
bilateral ones. The first contact solve acts on the velocity with which everyone goes through the step, so that nobody
ends inside another; the second on the velocity at its end, so that touching floats are at rest when nothing moves them.
Other schemes put their own passage and their own kick in place of Verlet's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside, inlined, plainly
from ecume.engine.cells import Integers
from ecume.engine.contact.contacts import Candidates
from ecume.engine.neighbors import NeighborLists, build, farthest_move
from ecume.models.floating.booking import book, book_heat, is_driven
from ecume.models.floating.forces import Sorted, forces, sort_floats
from ecume.models.floating.meeting import meet, rest, settle
from ecume.models.floating.parameters import (
    IMPULSE,
    KICKED_BEFORE,
    NO_CONTACTS,
    RARE,
    SPRINGS,
    STORMER_VERLET,
    VELOCITY_VERLET,
    Kick,
    Parameters,
)
from ecume.models.floating.schemes import clear, copy_rows, drift, kick_floats, predict, predict_rarely_with
from ecume.models.floating.state import State, Workspace
from ecume.models.model import CROWDED, DIVERGED, DONE
from ecume.units import Array


@compiled
def find_pairs(
    lists: NeighborLists, slots: tuple[int, int], radius: Array, skin: float, room: int
) -> tuple[Integers, Integers]:
    """Who of some slots may touch whom of the later ones, while the lists hold: the lower of each pair, and the higher.
    One more than there is room for when there are too many.
    """
    order, rows, widest, found = lists.cells.order, lists.rows, radius.max(), 0
    x, y = rows.sorted_position[0], rows.sorted_position[1]
    first, later, neighbor = rows.first, rows.later, rows.neighbor
    lower, higher = np.empty(room + 1, np.int64), np.empty(room + 1, np.int64)
    for slot in range(slots[0], slots[1]):
        i, own_x, own_y = order[slot], x[slot], y[slot]
        farthest = (radius[i] + widest + skin) ** 2
        for place in range(later[slot], first[slot + 1]):
            other = np.uint64(neighbor[place])
            along, across = x[other] - own_x, y[other] - own_y
            square = along * along + across * across
            if square <= farthest:
                j = order[other]
                within = radius[i] + radius[j] + skin
                if square < within * within:
                    lower[found], higher[found] = min(i, j), max(i, j)
                    found += 1
                    if found > room:
                        return lower, higher
    return lower[:found], higher[:found]


@compiled
def list_candidates(candidates: Candidates, lists: NeighborLists, radius: Array, skin: float) -> bool:
    """Pairs that may touch while the lists hold, ordered by i, then j. False when there is no room."""
    room = len(candidates.partner)
    lower, higher = find_pairs(lists, (0, len(radius)), radius, skin, room)
    if len(lower) > room:
        return False
    sort_pairs(candidates, lower, higher)
    return True


@compiled
def sort_pairs(candidates: Candidates, lower: Integers, higher: Integers) -> None:
    """Write down pairs by the lower, then by the higher."""
    starts, partner, count = candidates.first, candidates.partner, len(candidates.first) - 1
    for i in range(count + 1):
        starts[i] = 0
    for i in lower:
        starts[i + 1] += 1
    for i in range(count):
        starts[i + 1] += starts[i]
    # From the end, so that what a start was moved down by is what was written.
    ends = starts[1:].copy()
    for number in range(len(lower)):
        i, j = lower[number], higher[number]
        ends[i] -= 1
        partner[ends[i]] = j
    for i in range(count):
        _ascend(partner, starts[i], starts[i + 1])


@compiled_inside
def _ascend(values: Integers, begin: int, end: int) -> None:
    """Sort a few."""
    for place in range(begin + 1, end):
        value, spot = values[place], place
        while spot > begin and values[spot - 1] > value:
            values[spot] = values[spot - 1]
            spot -= 1
        values[spot] = value


@compiled
def renew_lists(
    parameters: Parameters, reference: Array, lists: NeighborLists, candidates: Candidates, sorted_floats: Sorted
) -> bool:
    """Neighbor lists and candidates at the reference positions. False when there is no room."""
    if not build(lists, reference, parameters.reach):
        return False
    if not list_candidates(candidates, lists, parameters.floats.radius, parameters.skin):
        lists.valid[0] = 0
        return False
    sort_floats(parameters, lists, sorted_floats)
    return True


@compiled
def farthest_ahead(kick: Kick, velocity: Array, force: Array) -> float:
    """The highest speed with which anyone can go through the next step, contacts aside; NaN if a number is none."""
    fastest = 0.0
    for i in range(velocity.shape[0]):
        # What drag takes at once carries nobody.
        speed = math.sqrt(velocity[i, 0] ** 2 + velocity[i, 1] ** 2) if kick.decay[i] > 0.0 else 0.0
        speed += kick.gain[i] * math.sqrt(force[i, 0] ** 2 + force[i, 1] ** 2)
        # Written so that a NaN is taken, and kept.
        if fastest == fastest and not speed <= fastest:
            fastest = speed
    return fastest


@inlined
def keep_lists_with(renew: Callable[..., bool], parameters: Parameters, state: State, workspace: Workspace) -> int:
    """New lists before anyone leaves the old ones' reach; nothing but the reference positions changes in the state."""
    ahead = parameters.time_step * farthest_ahead(parameters.kick, state.velocity, workspace.force)
    ahead += parameters.drift.jump
    moved = farthest_move(state.position, state.reference)
    workspace.ahead[0] = ahead
    if not ahead <= 0.25 * parameters.skin:
        return DIVERGED
    if moved + ahead > 0.25 * parameters.skin:
        copy_rows(workspace.stages[0], state.reference)
        copy_rows(state.reference, state.position)
        lists, candidates, sorted_floats = workspace.lists, workspace.candidates, workspace.sorted_floats
        if not renew(parameters, state.reference, lists, candidates, sorted_floats):
            copy_rows(state.reference, workspace.stages[0])
            return CROWDED
    return DONE


@compiled
def keep_lists(parameters: Parameters, state: State, workspace: Workspace) -> int:
    """`keep_lists_with` lists of everyone's neighbors."""
    return keep_lists_with(renew_lists, parameters, state, workspace)


@inlined
def step_with(
    predict: Callable[..., None],
    evaluate: Callable[..., None],
    meet: Callable[..., None],
    rest: Callable[..., None],
    law: Any,
    parameters: Parameters,
    state: State,
    workspace: Workspace,
) -> None:
    """One time step."""
    copy_rows(workspace.before, state.velocity)
    predict(law, parameters, state, workspace)
    if parameters.contact_law != NO_CONTACTS:
        meet(parameters, state, workspace)
    driven = is_driven(parameters)
    if driven:
        book(parameters, state, workspace.passage)
        book_heat(parameters, state, workspace)
    drift(state.position, workspace.passage, parameters.time_step)
    if parameters.contact_law == IMPULSE:
        settle(parameters, state, workspace)
    if parameters.scheme != STORMER_VERLET:
        evaluate(law, parameters, state.position, workspace.lists, (workspace.sorted_floats, workspace.force))
    if driven:
        book_heat(parameters, state, workspace)
    if parameters.scheme == VELOCITY_VERLET:
        kick_floats(parameters, state, workspace.force, 1.0)
    if parameters.contact_law in (IMPULSE, SPRINGS) and parameters.scheme not in KICKED_BEFORE:
        rest(parameters, state, workspace)
    state.step[0] += 1


@inlined
def march_touching_with(
    predict: Callable[..., None],
    evaluate: Callable[..., None],
    meet: Callable[..., None],
    rest: Callable[..., None],
    law: Any,
    parameters: Parameters,
    state: State,
    workspace: Workspace,
    steps: int,
) -> int:
    """March: see `ecume.models.model.Model.advance`. `evaluate` works out all forces at given positions; `meet` and
    `rest` are what contacts do on the way and at the end.
    """
    # Stoermer's scheme looks at no force between its steps.
    if workspace.ready[0] == 0 and parameters.scheme != STORMER_VERLET:
        evaluate(law, parameters, state.position, workspace.lists, (workspace.sorted_floats, workspace.force))
    workspace.ready[0] = 1
    for _ in range(steps):
        status = keep_lists(parameters, state, workspace)
        if status != DONE:
            return status
        step_with(predict, evaluate, meet, rest, law, parameters, state, workspace)
        if parameters.scheme == STORMER_VERLET:
            clear(workspace.force)
        if not farthest_move(state.position, state.reference) <= 0.5 * parameters.skin:
            return DIVERGED
    return DONE


@inlined
def march_with(
    predict: Callable[..., None],
    evaluate: Callable[..., None],
    law: Any,
    parameters: Parameters,
    state: State,
    workspace: Workspace,
    steps: int,
) -> int:
    """`march_touching_with` contacts without friction."""
    return march_touching_with(predict, evaluate, meet, rest, law, parameters, state, workspace, steps)


class Parts(NamedTuple):
    """What a march in parts is made of."""

    evaluate: Callable[..., None]
    """works out all forces at given positions"""
    keep: Callable[..., int] = keep_lists
    """makes new lists in time"""
    meet: Callable[..., None] = meet
    rest: Callable[..., None] = rest
    """what contacts do on the way, and at the end"""


def march_in_parts(
    parts: Parts, law: Any, parameters: Parameters, state: State, workspace: Workspace, steps: int
) -> int:
    """The march as Python runs it, of compiled parts: where forces take what cannot be compiled. For schemes that ask
    for no forces on the way.
    """
    if workspace.ready[0] == 0:
        parts.evaluate(law, parameters, state.position, workspace.lists, (workspace.sorted_floats, workspace.force))
    workspace.ready[0] = 1
    for _ in range(steps):
        status = parts.keep(parameters, state, workspace)
        if status != DONE:
            return status
        plainly(step_with)(predict, parts.evaluate, parts.meet, parts.rest, law, parameters, state, workspace)
        if not farthest_move(state.position, state.reference) <= 0.5 * parameters.skin:
            return DIVERGED
    return DONE


@compiled
def march(law: Any, parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """The march of floats by a pair law."""
    return march_with(predict, forces, law, parameters, state, workspace, steps)


@compiled
def predict_rarely(law: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """For schemes that ask for forces on the way."""
    predict_rarely_with(forces, law, parameters, state, workspace)


@compiled
def march_rarely(law: Any, parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """The march for schemes that are seldom asked for: compiled when one is."""
    return march_with(predict_rarely, forces, law, parameters, state, workspace, steps)


def advance(law: Any, parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """See `ecume.models.model.Model.advance`."""
    return (march_rarely if parameters.scheme in RARE else march)(law, parameters, state, workspace, steps)
