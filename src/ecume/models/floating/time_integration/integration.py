"""The time step: contacts, drift and forces in their order; and the loop over steps.

Kick, contacts, drift, forces, kick, contacts: velocity Verlet with unilateral constraints, as RATTLE is velocity Verlet
with bilateral ones. The first contact solve acts on the midstep velocity, so that no float overlaps another after the
step; the second acts on the velocity at its end, so that touching floats remain at rest if no force moves them. Other
schemes define their own midstep velocity and kick.

The chosen parts of a scene are in `Parts`: an integrator, interactions, resistances and contacts. The types of these
parts select the functions of their rows when the step is compiled.
"""

from __future__ import annotations

from operator import attrgetter
from typing import cast

import numpy as np

from ecume._jit import compiled, compiled_inside, composed, plainly
from ecume.engine.contact.contacts import Candidates
from ecume.engine.neighbors import NeighborLists, build, farthest_move
from ecume.models.floating.contacts.candidates import list_candidates
from ecume.models.floating.contacts.contact_models import (
    contacts_after_drift,
    contacts_at_end,
    contacts_before_drift,
    contacts_of,
    find_contacts,
)
from ecume.models.floating.forces.flow_and_noise import set_clock, varies
from ecume.models.floating.forces.interactions import (
    BY_CONSTANTS,
    RESISTANCES_BY_CONSTANTS,
    add_work_of_forces,
    apply_resistances,
    evaluate,
    interactions_of,
    kick_spins,
    sort_parts,
)
from ecume.models.floating.parameters import (
    ClockedScratch,
    Parameters,
    Parts,
    Scratch,
    State,
    Workspace,
    compiled_state,
    copy_rows,
)
from ecume.models.floating.time_integration.integrators import (
    INTEGRATORS_BY_CONSTANTS,
    add_heat,
    add_work,
    begin,
    bound_travel,
    finish,
    highest_speed,
    move,
    predict,
    store,
)
from ecume.models.model import CROWDED, DIVERGED, DONE
from ecume.units import Array


@compiled
def build_all(
    lists: NeighborLists, candidates: Candidates, position: Array, radius: Array, reach: float, skin: float
) -> bool:
    """Build neighbor lists and candidates. Returns False if the capacity is exceeded."""
    if not build(lists, position, reach):
        return False
    if not list_candidates(candidates, lists, radius, skin):
        lists.valid[0] = 0
        return False
    return True


WIDEST = 64.0
"""The widest skin over that of the parameters, a power of two: a float that moves farther has diverged."""
USED = 0.25
"""The part of the skin that floats use up before new lists are made, without the displacement by contacts."""


@compiled
def skin_of(parameters: Parameters, state: State) -> float:
    """The skin of the lists (m): that of the parameters, or a wider one that fast floats required."""
    return max(parameters.skin, float(state.skin[0]))


@compiled_inside
def skin_for(skin: float, ahead: float) -> float:
    """The skin of new lists (m) for floats that move by at most `ahead` in the next step: by default `skin`, the best
    value for floats as fast as the time step assumes; otherwise doubled until the lists are valid for two steps.
    """
    widest = WIDEST * skin
    if ahead <= USED * skin:
        return skin
    while 2.0 * ahead > USED * skin and skin < widest:
        skin *= 2.0
    return skin


OUTDATED = -1
"""The status of a step that needs new neighbor lists."""


@compiled_inside
def list_validity(parameters: Parameters, state: State, workspace: Workspace, speed: float) -> int:
    """Return DONE if the lists hold for another step at this highest speed, `OUTDATED` if new ones are needed, and
    DIVERGED if no list can hold. The skin covers all motion: by velocities, forces, noise and a moving dish.
    """
    ahead = parameters.time_step * speed + parameters.drift.jump
    moved = farthest_move(state.position, state.reference)
    workspace.travel[0] = ahead
    if not ahead <= USED * WIDEST * parameters.skin:
        return DIVERGED
    return OUTDATED if moved + ahead > USED * skin_of(parameters, state) else DONE


@composed
def step(parts: Parts, scratches: Scratch, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Advance by one time step."""
    kick_spins(parts.interactions, scratches.interactions, parameters, state, True)
    copy_rows(workspace.before, state.velocity)
    predict(parts.integrator, parts, scratches, parameters, state, workspace)
    apply_resistances(parts.resistances, scratches.resistances, parameters, state, workspace, True)
    contacts_before_drift(parts.contacts, scratches.contacts, parameters, state, workspace)
    add_work(parts.integrator, scratches.integrator, parameters, state, workspace)
    add_work_of_forces(parts.interactions, scratches.interactions, parameters, state, workspace)
    add_heat(parts.integrator, scratches.integrator, parameters, state, workspace, 0.0)
    move(parts.integrator, scratches.integrator, parameters, state, workspace)
    contacts_after_drift(parts.contacts, scratches.contacts, parameters, state, workspace)
    set_clock(scratches, (state.step[0] + 1) * parameters.time_step)
    if parameters.scheme.forces_at_end:
        evaluate(parts, scratches, parameters, state.position, workspace.lists, workspace.force)
    add_heat(parts.integrator, scratches.integrator, parameters, state, workspace, 1.0)
    finish(parts.integrator, scratches.integrator, parameters, state, workspace)
    if parameters.scheme.half_kicks:
        apply_resistances(parts.resistances, scratches.resistances, parameters, state, workspace, False)
    if parameters.scheme.contacts_at_end:
        contacts_at_end(parts.contacts, scratches.contacts, parameters, state, workspace)
    store(parts.integrator, scratches.integrator, parameters, state, workspace)
    kick_spins(parts.interactions, scratches.interactions, parameters, state, False)
    state.step[0] += 1


@compiled
def integrate(
    parts: Parts, scratches: Scratch, parameters: Parameters, state: State, workspace: Workspace, steps: int
) -> int:
    """Advance by `steps` steps: see `ecume.models.model.Model.advance`. `parameters` and `workspace` do not contain the
    parts, so that code that is independent of them is compiled once.
    """
    begin(parts.integrator, scratches.integrator, parameters, state)
    set_clock(scratches, state.step[0] * parameters.time_step)
    if workspace.ready[0] == 0 and parameters.scheme.forces_at_end:
        evaluate(parts, scratches, parameters, state.position, workspace.lists, workspace.force)
    workspace.ready[0] = 1
    for _ in range(steps):
        speed = highest_speed(parts.integrator, scratches.integrator, parameters, state, workspace)
        status = list_validity(parameters, state, workspace, speed)
        if status == DONE:
            status = bound_travel(parts.integrator, scratches.integrator, parameters, state, workspace)
        if status == DONE:
            status = find_contacts(parts.contacts, scratches.contacts, parameters, state, workspace)
        if status != DONE:
            return status
        step(parts, scratches, parameters, state, workspace)
        if not farthest_move(state.position, state.reference) <= 0.5 * skin_of(parameters, state):
            return DIVERGED
    return DONE


def bare_parameters(parameters: Parameters, scratches: Scratch) -> Parameters:
    """The parameters for compiled code: without parts, and with walls at the positions to which steps have moved
    them.
    """
    walls = parameters.walls
    for part, own in zip(parameters.parts.interactions, scratches.interactions, strict=True):
        moved = BY_CONSTANTS[type(part)].moved_walls
        walls = walls if moved is None else moved(own, walls)
    return parameters._replace(walls=walls, parts=())


def advance(parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """Advance by `steps` steps: see `ecume.models.model.Model.advance`. Compiled code runs all steps if it can call
    every part; otherwise Python runs the same functions step by step and calls compiled parts.
    """
    parts, bare = parameters.parts, bare_parameters(parameters, workspace.scratch)
    interactions = map(BY_CONSTANTS.__getitem__, map(type, parts.interactions))
    whole = all(map(attrgetter("compiled"), (INTEGRATORS_BY_CONSTANTS[type(parts.integrator)], *interactions)))
    run = integrate if whole else plainly(integrate)
    last, space = int(state.step[0]) + steps, workspace._replace(scratch=())
    state = compiled_state(state)
    while True:
        status = run(parts, workspace.scratch, bare, state, space, last - int(state.step[0]))
        if status != OUTDATED:
            return status
        if not renew_lists(parts, workspace.scratch, bare, state, space):
            return CROWDED


@composed
def renew_lists(parts: Parts, scratches: Scratch, parameters: Parameters, state: State, workspace: Workspace) -> bool:
    """Build new lists at the present positions; of the state only reference positions and skin change. If the capacity
    is exceeded, nothing changes and the result is False. `parameters` and `workspace` have no parts.
    """
    former, skin = state.reference.copy(), state.skin[0]
    copy_rows(state.reference, state.position)
    state.skin[0] = skin_for(parameters.skin, workspace.travel[0])
    if fill_lists(parts, scratches, parameters, state, workspace):
        return True
    copy_rows(state.reference, former)
    state.skin[0] = skin
    return False


def forces_at(parameters: Parameters, position: Array, workspace: Workspace) -> Array:
    """The forces on all floats (N, 2) at these positions, where the lists must be valid; the array belongs to the
    workspace.
    """
    bare = bare_parameters(parameters, workspace.scratch)
    evaluate(parameters.parts, workspace.scratch, bare, position, workspace.lists, workspace.force)
    return workspace.force


def make_scratch(parameters: Parameters, state: State, workspace: Workspace) -> Scratch:
    """Allocate the workspaces of all parts."""
    parts = parameters.parts
    own = tuple(row.scratch(part, parameters, state, workspace) for part, row in interactions_of(parameters))
    moving = INTEGRATORS_BY_CONSTANTS[type(parts.integrator)].scratch(parts.integrator, own)
    touching = contacts_of(parameters).scratch(parts.contacts, parameters, state, workspace, moving)
    slowing = tuple(RESISTANCES_BY_CONSTANTS[type(part)].scratch(moving) for part in parts.resistances)
    if not varies(parameters.drift):
        return Scratch(moving, own, slowing, touching)
    now = np.array([float(state.step[0]) * parameters.time_step])
    return cast(Scratch, ClockedScratch(moving, own, slowing, touching, now))


@composed
def fill_lists(parts: Parts, scratches: Scratch, parameters: Parameters, state: State, workspace: Workspace) -> bool:
    """Build the lists of a workspace at the reference positions. Returns False if the capacity is exceeded."""
    lists, skin = workspace.lists, max(parameters.skin, state.skin[0])
    reach = parameters.reach + (skin - parameters.skin)
    if not build_all(lists, workspace.candidates, state.reference, parameters.floats.radius, reach, skin):
        return False
    sort_parts(parts.interactions, scratches.interactions, parameters, lists)
    return True


def inertia_of(parameters: Parameters) -> Array | None:
    """The moments of inertia of floats that turn (kg m^2), (N,); None if no float turns."""
    by_contacts = contacts_of(parameters).inertia(parameters.parts.contacts)
    found = [by_contacts, *(row.inertia(part) for part, row in interactions_of(parameters))]
    return next((each for each in found if each is not None), None)
