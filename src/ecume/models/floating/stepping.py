"""One step of floating bodies, and the march of many.

Kick, meet, drift, kick, rest: the velocity Verlet scheme with unilateral constraints, as RATTLE is with
bilateral ones. The first contact solve acts on the velocity with which everyone goes through the step, so that nobody
ends inside another; the second on the velocity at its end, so that touching floats are at rest when nothing moves them.
Other schemes put their own passage and their own kick in place of Verlet's.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from ecume._jit import compiled, inlined
from ecume.engine.contacts import Candidates
from ecume.engine.neighbors import NeighborLists, build, farthest_move
from ecume.models.floating.forces import forces, sort_floats
from ecume.models.floating.meeting import meet, rest, settle
from ecume.models.floating.parameters import (
    EXPLICIT_EULER,
    IMPULSE,
    NO_CONTACTS,
    RK4,
    STORMER_VERLET,
    VELOCITY_VERLET,
    Kick,
    Parameters,
)
from ecume.models.floating.state import State, Workspace
from ecume.models.model import CROWDED, DIVERGED, DONE
from ecume.units import Array


@compiled
def list_candidates(candidates: Candidates, lists: NeighborLists, reference: Array, radius: Array, skin: float) -> bool:
    """Pairs that may touch while the lists hold, ordered by i, then j. False when there is no room."""
    order, first, neighbor, slot_of = lists.cells.order, lists.rows.first, lists.rows.neighbor, lists.cells.cell
    partner, starts = candidates.partner, candidates.first
    for slot in range(len(order)):
        slot_of[order[slot]] = slot
    found = 0
    for i in range(len(order)):
        starts[i] = found
        slot = slot_of[i]
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            x, y = reference[j, 0] - reference[i, 0], reference[j, 1] - reference[i, 1]
            within = radius[i] + radius[j] + skin
            if j > i and x * x + y * y < within * within:
                if found == len(partner):
                    return False
                spot = found
                while spot > starts[i] and partner[spot - 1] > j:
                    partner[spot] = partner[spot - 1]
                    spot -= 1
                partner[spot] = j
                found += 1
    starts[len(order)] = found
    return True


@compiled
def renew_lists(parameters: Parameters, state: State, workspace: Workspace) -> bool:
    """Neighbor lists and candidates at the reference positions. False when there is no room."""
    radius = parameters.floats.radius
    reach = max(parameters.cutoff, 2.0 * radius.max()) + parameters.skin
    lists = workspace.lists
    if not build(lists, state.reference, reach):
        return False
    if not list_candidates(workspace.candidates, lists, state.reference, radius, parameters.skin):
        lists.valid[0] = 0
        return False
    sort_floats(parameters, lists, workspace.sorted_floats)
    return True


@compiled
def farthest_ahead(kick: Kick, velocity: Array, force: Array) -> float:
    """The highest speed with which anyone can go through the next step, contacts aside; NaN if a number is none."""
    fastest = 0.0
    for i in range(velocity.shape[0]):
        speed = math.sqrt(velocity[i, 0] ** 2 + velocity[i, 1] ** 2)
        speed += kick.gain[i] * math.sqrt(force[i, 0] ** 2 + force[i, 1] ** 2)
        # Written so that a NaN is taken, and kept.
        if fastest == fastest and not speed <= fastest:
            fastest = speed
    return fastest


@compiled
def give_kick(kick: Kick, velocity: Array, force: Array) -> None:
    """Drag and a force that stays for the kick's time, solved exactly."""
    decay, gain = kick.decay, kick.gain
    for i in range(force.shape[0]):
        velocity[i, 0] = decay[i] * velocity[i, 0] + gain[i] * force[i, 0]
        velocity[i, 1] = decay[i] * velocity[i, 1] + gain[i] * force[i, 1]


@compiled
def drift(position: Array, velocity: Array, time: float) -> None:
    """Straight on."""
    for i in range(position.shape[0]):
        position[i, 0] += time * velocity[i, 0]
        position[i, 1] += time * velocity[i, 1]


@compiled
def copy_rows(target: Array, source: Array) -> None:
    """The first rows of one become those of the other."""
    for i in range(min(target.shape[0], source.shape[0])):
        target[i, 0], target[i, 1] = source[i, 0], source[i, 1]


@compiled
def accelerate(parameters: Parameters, velocity: Array, force: Array, acceleration: Array) -> None:
    """F/m - v/tau."""
    mass, relaxation = parameters.floats.mass, parameters.floats.relaxation_time
    for i in range(force.shape[0]):
        acceleration[i, 0] = force[i, 0] / mass[i] - velocity[i, 0] / relaxation[i]
        acceleration[i, 1] = force[i, 1] / mass[i] - velocity[i, 1] / relaxation[i]


@inlined
def runge_kutta_with(evaluate: Callable[..., None], parameters: Parameters, state: State, workspace: Workspace) -> None:
    """The classical scheme of fourth order, drag included: passage and velocity change by the weighted means of four
    stages.
    """
    time, passage, stages = parameters.time_step, workspace.passage, workspace.stages
    position, velocity, rate, slope, push = stages[0], stages[1], stages[2], stages[3], stages[4]
    passage[: len(position)] = 0.0
    rate[:] = 0.0
    copy_rows(push, workspace.force)
    copy_rows(velocity, state.velocity)
    for stage in range(4):
        if stage > 0:
            ahead = time if stage == 3 else 0.5 * time
            copy_rows(position, state.position)
            drift(position, velocity, ahead)
            copy_rows(velocity, state.velocity)
            drift(velocity, slope, ahead)
            evaluate(parameters, position, workspace.lists, (workspace.sorted_floats, push))
        accelerate(parameters, velocity, push, slope)
        weight = 1.0 / 6.0 if stage in (0, 3) else 1.0 / 3.0
        drift(passage[: len(position)], velocity, weight)
        drift(rate, slope, weight)
    drift(state.velocity, rate, time)


@inlined
def predict_with(evaluate: Callable[..., None], parameters: Parameters, state: State, workspace: Workspace) -> None:
    """The smooth part up to the drift: `passage` is the displacement over the time step, and the velocity has its kick.

    Stoermer's scheme is the drift-kick-drift form, whose midpoints obey x(t+dt) = 2 x(t) - x(t-dt) + dt^2 a.
    """
    scheme, passage, kick = parameters.scheme, workspace.passage, parameters.kick
    if scheme == RK4:
        runge_kutta_with(evaluate, parameters, state, workspace)
    elif scheme == STORMER_VERLET:
        middle = workspace.stages[0]
        copy_rows(passage, state.velocity)
        copy_rows(middle, state.position)
        drift(middle, state.velocity, 0.5 * parameters.time_step)
        evaluate(parameters, middle, workspace.lists, (workspace.sorted_floats, workspace.force))
        give_kick(kick, state.velocity, workspace.force)
        for i in range(len(middle)):
            passage[i, 0] = 0.5 * (passage[i, 0] + state.velocity[i, 0])
            passage[i, 1] = 0.5 * (passage[i, 1] + state.velocity[i, 1])
    elif scheme == EXPLICIT_EULER:
        copy_rows(passage, state.velocity)
        give_kick(kick, state.velocity, workspace.force)
    else:
        give_kick(kick, state.velocity, workspace.force)
        copy_rows(passage, state.velocity)


@compiled
def keep_lists(parameters: Parameters, state: State, workspace: Workspace) -> int:
    """New lists before anyone leaves the old ones' reach; nothing but the reference positions changes in the state."""
    ahead = parameters.time_step * farthest_ahead(parameters.kick, state.velocity, workspace.force)
    moved = farthest_move(state.position, state.reference)
    workspace.ahead[0] = ahead
    if not ahead <= 0.25 * parameters.skin:
        return DIVERGED
    if moved + ahead > 0.25 * parameters.skin:
        copy_rows(workspace.stages[0], state.reference)
        copy_rows(state.reference, state.position)
        if not renew_lists(parameters, state, workspace):
            copy_rows(state.reference, workspace.stages[0])
            return CROWDED
    return DONE


@inlined
def step_with(evaluate: Callable[..., None], parameters: Parameters, state: State, workspace: Workspace) -> None:
    """One time step."""
    copy_rows(workspace.before, state.velocity)
    predict_with(evaluate, parameters, state, workspace)
    if parameters.contact_law != NO_CONTACTS:
        meet(parameters, state, workspace)
    drift(state.position, workspace.passage, parameters.time_step)
    if parameters.contact_law == IMPULSE:
        settle(parameters, state, workspace)
    if parameters.scheme != STORMER_VERLET:
        evaluate(parameters, state.position, workspace.lists, (workspace.sorted_floats, workspace.force))
    if parameters.scheme == VELOCITY_VERLET:
        give_kick(parameters.kick, state.velocity, workspace.force)
    if parameters.contact_law == IMPULSE:
        rest(parameters, state, workspace)
    state.step[0] += 1


@inlined
def advance_with(
    evaluate: Callable[..., None], parameters: Parameters, state: State, workspace: Workspace, steps: int
) -> int:
    """March: see `ecume.models.model.Model.advance`. `evaluate` works out all forces at given positions."""
    # Stoermer's scheme looks at no force between its steps.
    if workspace.ready[0] == 0 and parameters.scheme != STORMER_VERLET:
        evaluate(parameters, state.position, workspace.lists, (workspace.sorted_floats, workspace.force))
    workspace.ready[0] = 1
    for _ in range(steps):
        status = keep_lists(parameters, state, workspace)
        if status != DONE:
            return status
        step_with(evaluate, parameters, state, workspace)
        if parameters.scheme == STORMER_VERLET:
            workspace.force[:] = 0.0
        if not farthest_move(state.position, state.reference) <= 0.5 * parameters.skin:
            return DIVERGED
    return DONE


@compiled
def advance(parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """`advance_with` ecume's own laws alone."""
    return advance_with(forces, parameters, state, workspace, steps)
