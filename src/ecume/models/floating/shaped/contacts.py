"""Contacts of shapes in one step: as those of discs (`ecume.models.floating.contacts.collisions`), with spins."""

from __future__ import annotations

from ecume._jit import compiled
from ecume.engine.contact import contacts, impulse_solvers
from ecume.engine.contact import torque_contacts as touching
from ecume.engine.contact.contacts import Memory, deepest_overlap
from ecume.engine.contact.torque_contacts import TorqueContacts
from ecume.engine.outlines import Stance
from ecume.models.floating.contacts.collisions import (
    clear_impulses,
    goal_for,
    goal_of,
    require_gaps,
    require_rest,
    require_stops,
    share_restitution,
)
from ecume.models.floating.parameters import Parameters
from ecume.models.floating.shaped.bodies import Outlined, ShapedScratch, solver_bodies, store_angles
from ecume.models.floating.state import COLLISIONS, DEEPEST, SWEEPS, UNCONVERGED, State, Workspace
from ecume.models.model import CROWDED, DONE
from ecume.units import Array


@compiled
def bounce(own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Apply collisions to the midstep velocities: (1 + e) times the impulses that stop all approaches."""
    of_float = workspace.restitution
    levers = own.levers
    touching.normal_velocities(levers, own.before, levers.scratch)
    fastest = require_stops(False, parameters, levers)
    if fastest <= 0.0:
        return
    clear_impulses(levers)
    goal = goal_for(parameters, fastest)
    state.tally[SWEEPS] += touching.solve(levers, own.before, goal)
    share_restitution(parameters, levers, of_float)
    for row in range(levers.total[0]):
        if levers.impulse[row] > 0.0:
            state.tally[COLLISIONS] += 1.0
            levers.impulse[row] *= 1.0 + of_float[levers.first[row]]
    touching.apply_impulses(levers, levers.impulse, own.midstep_velocity)


@compiled
def solve_contacts(parameters: Parameters, state: State, levers: TorqueContacts, velocity: Array) -> None:
    """Solve for impulses on `velocity`, starting from those of the previous solve, and store them."""
    memory = Memory(state.touches, state.touching, state.push)
    contacts.recall(touching.contact_keys(levers), memory)
    touching.normal_velocities(levers, velocity, levers.scratch)
    goal = goal_of(parameters, levers)
    if goal.target > 0.0:
        sweeps = touching.solve(levers, velocity, goal)
        state.tally[SWEEPS] += sweeps
        state.tally[UNCONVERGED] += 1.0 if sweeps > impulse_solvers.MOST_SWEEPS else 0.0
    else:
        clear_impulses(levers)
    contacts.remember(touching.contact_keys(levers), memory)


@compiled
def collide_outlines(
    part: Outlined, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Solve collisions, then a plastic solve for the midstep velocities, so that no float overlaps another."""
    if not part.solved:
        return
    bounce(own, parameters, state, workspace)
    require_gaps(False, parameters, own.levers)
    solve_contacts(parameters, state, own.levers, own.midstep_velocity)


@compiled
def separate_outlines(
    part: Outlined, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """List the contacts at the new positions, and remove deep overlaps without changing velocities."""
    if not part.solved:
        return
    reach = 2.0 * workspace.travel[0] + parameters.slop
    stance = Stance(state.position, own.angle, own.corner)
    bodies, levers = solver_bodies(part, parameters, own), own.levers
    touching.gather(levers, workspace.candidates, stance, bodies, reach)
    deepest = deepest_overlap(levers.total, levers.gap)
    state.tally[DEEPEST] = max(state.tally[DEEPEST], deepest)
    if deepest > parameters.slop:
        touching.separate(levers, workspace.candidates, stance, bodies, parameters.slop)
        touching.gather(levers, workspace.candidates, stance, bodies, reach)
    store_angles(own, state)


@compiled
def constrain_outline_velocities(
    part: Outlined, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Solve contacts for the velocity at the end of the step; `before` is the velocity without the kick.

    A faster approach than by the kick alone is a collision of the next step.
    """
    if not part.solved:
        return
    levers = own.levers
    touching.normal_velocities(levers, own.before, levers.change)
    touching.normal_velocities(levers, own.midstep_velocity, levers.scratch)
    require_rest(parameters, levers)
    solve_contacts(parameters, state, levers, own.midstep_velocity)


@compiled
def find_outline_contacts(
    part: Outlined, own: ShapedScratch, parameters: Parameters, state: State, workspace: Workspace
) -> int:
    """List the contacts that are possible in this step; `CROWDED` if there is no room."""
    if not part.solved:
        return DONE
    stance = Stance(state.position, own.angle, own.corner)
    # Twice the travel for a head-on pair, and twice again for floats that others push.
    reach = 4.0 * workspace.travel[0] + parameters.slop
    room = touching.gather(own.levers, workspace.candidates, stance, solver_bodies(part, parameters, own), reach)
    return DONE if room else CROWDED
