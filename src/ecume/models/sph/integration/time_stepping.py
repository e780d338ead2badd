"""The time step of a tank, as a sequence of compiled loops over particles.

A step takes some milliseconds for ten thousand particles, and calling six compiled loops from Python costs less than a
tenth of a millisecond. The schemes are therefore written in Python, and each loop is compiled once for all scenes.
"""

from __future__ import annotations

import math

import numpy as np

from ecume._portable import product
from ecume.laws.time_step_limits import acoustic_limit, advective_limit, force_limit
from ecume.models.model import DIVERGED, DONE, EXCHANGE
from ecume.models.sph.boundaries.driven_bodies import drive_bodies
from ecume.models.sph.boundaries.open_boundaries import exchange_due, set_buffer_pressures
from ecume.models.sph.boundaries.rigid_bodies import (
    at_reference,
    collide,
    displacement_of_sides,
    expel_liquid,
    largest_displacement,
    move_bodies,
    with_moved_solids,
)
from ecume.models.sph.boundaries.walls import add_impulses, expel_from_drawn, reflect_particles
from ecume.models.sph.fields import number
from ecume.models.sph.integration.particle_loops import (
    advance_density,
    correct,
    drift,
    farthest,
    kick,
    largest,
    predict,
)
from ecume.models.sph.integration.passive_particles import move_passive_particles
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.projection import failed, project
from ecume.models.sph.rates.right_hand_side import (
    evaluate_accelerations,
    evaluate_density_rate,
    evaluate_rates,
    take_other_forces,
    take_shift,
)
from ecume.models.sph.rates.shifting import shifts_needed
from ecume.models.sph.report.energy_budget import (
    add_diffusion_work,
    add_work,
    has_work_of_forces,
    periodic_work,
    power_of_base_excitation,
    reflection_work,
)
from ecume.models.sph.solver_loads import add_loads
from ecume.models.sph.state import (
    GUARD_HITS,
    MOST_SUBSTEPS,
    RATE,
    RENEWALS,
    SORT_EVERY,
    SUBSTEPS,
    WORK,
    State,
    Workspace,
    skin_for,
    sort_state,
    workspace_at,
)

MOST_DIVISIONS = 64
"""The largest number of substeps in a step; a state that needs more has diverged."""
CALM = 0.01
"""Approach speed, over the fastest speed of the flow, below which bodies do not rebound."""


def advance(parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """Integrate over this number of steps; each is divided if speeds or forces require it."""
    step = INTEGRATORS[parameters.integrator]
    # A particle with a NaN position has no neighbors, so the error would not be detected later.
    if not np.isfinite(state.position).all():
        return DIVERGED
    status, crossed = DONE, bool(parameters.open_boundaries) or bool(np.isfinite(parameters.bounds).any())
    works = has_work_of_forces(parameters)
    for ahead in reversed(range(steps)):
        workspace.records_loads = ahead == 0
        divisions = divisions_needed(parameters, state)
        if divisions > MOST_DIVISIONS:
            return DIVERGED
        state.struck[...] = 0.0
        for _ in range(divisions):
            if parameters.open_boundaries:
                set_buffer_pressures(parameters, state)
            began = power_of_base_excitation(parameters, state) + float(state.budget[RATE]), bool(state.ready[0])
            step(parameters, state, workspace, parameters.time_step / divisions)
            if works:
                add_work(parameters, state, workspace, began, parameters.time_step / divisions)
            if parameters.projection is not None and failed(parameters.projection, state):
                return DIVERGED
            if parameters.passive_tracers.start[-1]:
                move_passive_particles(
                    with_moved_solids(parameters, state), state, workspace, parameters.time_step / divisions
                )
        state.step[0] += 1
        state.clock[0] = int(state.step[0]) * parameters.time_step
        state.tally[SUBSTEPS] += divisions
        state.tally[MOST_SUBSTEPS] = max(state.tally[MOST_SUBSTEPS], divisions)
        if crossed and exchange_due(parameters, state):
            status = EXCHANGE
            break
    # A state that became invalid in the last step must not be recorded.
    return status if divisions_needed(parameters, state) <= MOST_DIVISIONS else DIVERGED


def divisions_needed(parameters: Parameters, state: State) -> int:
    """The number of substeps that sound and forces require; very large if a value is not finite."""
    h = float(number(parameters.constants, "smoothing_length"))
    speed, force = largest(state.velocity), largest(state.acceleration)
    if not (math.isfinite(speed) and math.isfinite(force)):
        return MOST_DIVISIONS + 1
    sound = max(each.sound_speed for each in parameters.materials)
    if math.isfinite(sound):
        longest = min(acoustic_limit(h, sound, speed, parameters.courant), force_limit(h, force))
    else:
        longest = min(advective_limit(h, speed, parameters.courant), force_limit(h, force))
    return min(max(1, math.ceil(parameters.time_step / longest * (1.0 - 1e-9) - 0.1)), MOST_DIVISIONS + 1)


def symplectic_step(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Kick, drift half, density, drift half, kick (Adami et al. 2012, eqs. 28-31)."""
    if not state.ready[0]:
        renew(parameters, state, workspace)
        if parameters.bulk_viscosity > 0.0:
            evaluate_density_rate(parameters, state, workspace)
        evaluate_accelerations(parameters, state, workspace, time)
    kick_all(state, 0.5 * time)
    move(parameters, state, workspace, 0.5 * time)
    evaluate_density_rate(parameters, state, workspace)
    add_diffusion_work(parameters, state, workspace, time)
    advance_density(state.density, state.density_rate, time)
    move(parameters, state, workspace, 0.5 * time)
    evaluate_accelerations(parameters, state, workspace, time)
    kick_all(state, 0.5 * time)
    state.ready[0] = 1


def verlet_step(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Velocity Verlet with one evaluation per step, at the new positions and at predicted velocities and densities,
    followed by a correction with the mean of both rates. A pressure from densities half a step earlier would amplify
    sound waves.
    """
    if not state.ready[0]:
        renew(parameters, state, workspace)
        if parameters.bulk_viscosity > 0.0:
            evaluate_rates(parameters, state, workspace, time)
        evaluate_rates(parameters, state, workspace, time)
    kick_all(state, 0.5 * time)
    move(parameters, state, workspace, time)
    moved = state.velocity, state.acceleration, state.density, state.density_rate
    bodies_before = state.body_acceleration.copy()
    predict(*moved, workspace.before, time)
    state.motion[...] += 0.5 * time * bodies_before
    evaluate_rates(parameters, state, workspace, time)
    add_diffusion_work(parameters, state, workspace, time)
    correct(*moved, workspace.before, time)
    state.motion[...] += 0.5 * time * (state.body_acceleration - bodies_before)
    state.ready[0] = 1


def projection_step(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Kick by all forces except the pressure, kick by the pressure that conserves the density, drift: the symplectic
    Euler scheme (Ihmsen et al. 2014, algorithm 1; Bender and Koschier 2015). The drift is divided if a single shift of
    the particles would overshoot. [ihmsen2014, bender2015]
    """
    if not state.ready[0]:
        renew(parameters, state, workspace)
    shifts = shifts_needed(parameters, state, time)
    take_other_forces(parameters, state, workspace, time / shifts, time)
    kick_all(state, time)
    solved = project(parameters, state, workspace, time)
    if workspace.records_loads:
        add_loads(with_moved_solids(parameters, state), state, workspace, solved)
    move(parameters, state, workspace, time / shifts)
    for _ in range(shifts - 1):
        take_shift(parameters, state, workspace, time / shifts)
        move(parameters, state, workspace, time / shifts)
    state.ready[0] = 1


def kick_all(state: State, time: float) -> None:
    """Update the velocities of the liquid and of the bodies."""
    kick(state.velocity, state.acceleration, time)
    state.motion[...] += time * state.body_acceleration


def move(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Drift with the velocity and the transport velocity, reflect particles at walls, renew the lists when due."""
    drift(state.position, state.velocity, time)
    if parameters.transports:
        drift(state.position, state.transport, time)
    state.clock[0] += time
    if parameters.bodies.shapes:
        move_bodies(state.pose, state.motion, time)
        drive_bodies(parameters, state)
    now = with_moved_solids(parameters, state)
    resolve_collisions(now, state, time)
    if farthest(state.position, state.reference) + displacement_of_solids(parameters, state) > 0.5 * state.skin[0]:
        renew(parameters, state, workspace)


def resolve_collisions(now: Parameters, state: State, time: float) -> None:
    """Resolve collisions of bodies, and reflect the liquid at walls, obstacles and bodies."""
    guard, bodies = now.boundary.guard, now.bodies
    if bodies.shapes:
        calm = CALM * now.material.fastest
        state.budget[WORK] += collide(bodies, guard.sheet, (state.pose, state.motion), calm)[1]
        liquid = state.position, state.velocity, state.mass
        expelled = expel_liquid(bodies, state.pose, state.motion, liquid)
        state.tally[GUARD_HITS] += expelled.hits
        state.budget[WORK] += expelled.work
        if expelled.hits and state.struck.size:
            state.struck[len(state.struck) - len(bodies.shapes) :] += expelled.impulse / now.time_step
    expel_from_drawn(now, state)
    before = state.velocity.copy() if now.drives else state.velocity
    met = reflect_particles(guard, state.position, state.velocity, state.transport, time)
    if not len(met.who):
        return
    np.add.at(state.hits, guard.owner, met.hits)
    state.tally[GUARD_HITS] += met.hits.sum()
    add_impulses(now, state, met)
    if now.drives and met.hits.any():
        state.budget[WORK] += reflection_work(now, state, before)


def displacement_of_solids(parameters: Parameters, state: State) -> float:
    """The largest displacement of bodies and sides since the lists were made."""
    return largest_displacement(parameters.bodies, state.pose, state.pose_reference) + displacement_of_sides(
        parameters, state
    )


def renew(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Renew the lists at the present positions, after moving particles across periodic sides; at regular intervals,
    sort the particles into cells first.
    """
    wrap(parameters, state)
    if int(state.tally[RENEWALS]) % SORT_EVERY == 0:
        sort_state(parameters, state)
    state.tally[RENEWALS] += 1
    state.reference[...] = state.position
    state.skin[0] = skin_for(parameters, state)
    state.pose_reference[...] = state.pose
    state.clock[1] = state.clock[0]
    workspace.take(workspace_at(at_reference(parameters, state), state, workspace))


def wrap(parameters: Parameters, state: State) -> None:
    """Move particles beyond a periodic side to the opposite one, and count it in their image numbers."""
    sides = parameters.boundary.sides
    for side in np.flatnonzero(sides.mirrors == 0):
        out = product(sides.normal[side], state.position - sides.point[side][:, None]) < 0.0
        state.budget[WORK] += periodic_work(parameters, state, out, sides.shift[side])
        state.position[:, out] += sides.shift[side][:, None]
        if state.image.size:
            state.image[:, out] -= np.sign(sides.shift[side]).astype(np.int64)[:, None]


INTEGRATORS = {"symplectic": symplectic_step, "verlet": verlet_step, "projection": projection_step}
"""The integrators by name."""
LATE = frozenset({"verlet"})
"""Integrators whose acoustic damping uses the density rate of the previous step: see
`time_step_limits.late_damping_limit`.
"""
