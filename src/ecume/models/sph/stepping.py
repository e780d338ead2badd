"""One step after another. Python says what comes next; every pass over particles is compiled.

A step is some milliseconds of work for ten thousand particles, and calling six compiled loops from Python costs less
than a tenth of one: so the scheme stands here in words, and each loop is compiled once for all scenes.
"""

from __future__ import annotations

import math

import numpy as np

from ecume.models.model import DIVERGED, DONE, EXCHANGE
from ecume.models.sph.bodies import carry, farthest_way, keep_out, pushed
from ecume.models.sph.carried import take_along
from ecume.models.sph.collisions import collide
from ecume.models.sph.columns import fill_images, fill_liquid, fill_weights
from ecume.models.sph.dummies import read_liquid
from ecume.models.sph.fields import (
    ACC,
    ANTUONO,
    DELTA,
    DIFFUSION,
    ENTHALPY,
    FRICTION,
    HYDROSTATIC,
    MONAGHAN,
    NO_DIFFUSION,
    NO_FRICTION,
    RADIAL,
    RHO,
    SCALE,
    STRESS,
    SUM,
    TRANSPORT,
    H,
    W,
)
from ecume.models.sph.friction import push_transported, rub, rub_radially
from ecume.models.sph.gates import due, feed, still
from ecume.models.sph.gradients import add_gradient_diffusion, fill_density_gradients
from ecume.models.sph.guard import turn_back
from ecume.models.sph.loads import forces_on_dummies, total
from ecume.models.sph.motion import (
    drift,
    farthest,
    kick,
    largest,
    run_ahead,
    store_acceleration,
    store_thickening,
    take_mean,
    thicken,
)
from ecume.models.sph.motions import at_reference, instant, way_of_sides
from ecume.models.sph.parameters import DELTA_PLUS, NO_TENSION, SYMPLECTIC, Parameters
from ecume.models.sph.shifting import shift
from ecume.models.sph.state import (
    GUARD_HITS,
    MOST_SUBSTEPS,
    RENEWALS,
    SORT_EVERY,
    SUBSTEPS,
    State,
    Workspace,
    put_dummies,
    skin_for,
    sort_state,
    workspace_at,
)
from ecume.models.sph.sums import sums_of
from ecume.models.sph.tension import pull
from ecume.models.sph.turbulence import stir
from ecume.units import Array

MOST_DIVISIONS = 64
"""A step that must be divided more often than this will not recover."""
FORCE_COURANT = 0.25
CALM = 0.01
"""What collides more slowly than this part of the fastest speed does not bounce."""


def advance(parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """March that many steps; each is divided where speeds or forces ask for it."""
    step = symplectic_step if parameters.integrator == SYMPLECTIC else verlet_step
    # Who is nowhere has no neighbors, and would do no harm that anyone notices.
    if not np.isfinite(state.position).all():
        return DIVERGED
    for _ in range(steps):
        divisions = divisions_needed(parameters, state)
        if divisions > MOST_DIVISIONS:
            return DIVERGED
        for _ in range(divisions):
            feed(parameters, state)
            step(parameters, state, workspace, parameters.time_step / divisions)
            if parameters.carried.start[-1]:
                take_along(instant(parameters, state), state, workspace, parameters.time_step / divisions)
        state.step[0] += 1
        state.clock[0] = int(state.step[0]) * parameters.time_step
        state.tally[SUBSTEPS] += divisions
        state.tally[MOST_SUBSTEPS] = max(state.tally[MOST_SUBSTEPS], divisions)
        if due(parameters, state):
            return EXCHANGE
    return DONE


def divisions_needed(parameters: Parameters, state: State) -> int:
    """How many parts keep a step within what sound and forces allow; very many where something is not a number."""
    h = float(parameters.numbers[H])
    speed, force = largest(state.velocity), largest(state.acceleration)
    if not (math.isfinite(speed) and math.isfinite(force)):
        return MOST_DIVISIONS + 1
    sound = parameters.courant * h / (parameters.material.sound_speed + speed)
    longest = min(sound, FORCE_COURANT * math.sqrt(h / force) if force > 0.0 else math.inf)
    return min(max(1, math.ceil(parameters.time_step / longest * (1.0 - 1e-9) - 0.1)), MOST_DIVISIONS + 1)


def symplectic_step(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Kick, drift half, density, drift half, kick (Adami et al. 2012, eqs. 28-31)."""
    if not state.ready[0]:
        renew(parameters, state, workspace)
        take_forces(parameters, state, workspace, time)
    kick_all(state, 0.5 * time)
    move(parameters, state, workspace, 0.5 * time)
    take_thickening(parameters, state, workspace)
    thicken(state.density, state.thickening, time)
    move(parameters, state, workspace, 0.5 * time)
    take_forces(parameters, state, workspace, time)
    kick_all(state, 0.5 * time)
    state.ready[0] = 1


def verlet_step(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """One evaluation a step, at the new positions and at velocities and densities that go on as they did before; then
    the mean of both rates. Pressure at densities half a step behind would feed sound waves.
    """
    if not state.ready[0]:
        renew(parameters, state, workspace)
        take_both(parameters, state, workspace, time)
    kick_all(state, 0.5 * time)
    move(parameters, state, workspace, time)
    moved = state.velocity, state.acceleration, state.density, state.thickening
    before, bodies_before = np.empty((parameters.dimension + 1, state.position.shape[1])), state.push.copy()
    run_ahead(*moved, before, time)
    state.motion[...] += 0.5 * time * bodies_before
    take_both(parameters, state, workspace, time)
    take_mean(*moved, before, time)
    state.motion[...] += 0.5 * time * (state.push - bodies_before)
    state.ready[0] = 1


def kick_all(state: State, time: float) -> None:
    """Of the liquid and of the bodies."""
    kick(state.velocity, state.acceleration, time)
    state.motion[...] += time * state.push


def move(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Drift with the velocity and the transport, turn back whoever got through a wall, renew the lists when due."""
    drift(state.position, state.velocity, time)
    if parameters.background > 0.0 or parameters.shifting == DELTA_PLUS:
        drift(state.position, state.transport, time)
    state.clock[0] += time
    if parameters.bodies.shapes:
        carry(state.pose, state.motion, time)
    now = instant(parameters, state)
    turn_all_back(now, state, time)
    if farthest(state.position, state.reference) + way_of_solids(parameters, state) > 0.5 * state.skin[0]:
        renew(parameters, state, workspace)


def turn_all_back(now: Parameters, state: State, time: float) -> None:
    """Bodies at whatever they run into, liquid at walls, obstacles and bodies."""
    guard, bodies = now.boundary.guard, now.bodies
    if bodies.shapes:
        calm = CALM * now.material.fastest
        collide(bodies, guard.sheet, (state.pose, state.motion), calm)
        inside = keep_out(bodies, state.pose, state.motion, (state.position, state.velocity, state.mass))
        state.tally[GUARD_HITS] += inside
    hits = turn_back(guard, state.position, state.velocity, state.transport, time)
    np.add.at(state.hits, guard.owner, hits)
    state.tally[GUARD_HITS] += hits.sum()


def way_of_solids(parameters: Parameters, state: State) -> float:
    """How far bodies and sides went since the lists were made."""
    return farthest_way(parameters.bodies, state.pose, state.pose_reference) + way_of_sides(parameters, state)


def renew(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Make the lists anew here; now and then put the particles into cell order before. Periodic sides are passed."""
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
    """Who left through a periodic side comes in through the opposite one."""
    sides = parameters.boundary.sides
    for side in np.flatnonzero(sides.mirrors == 0):
        out = sides.normal[side] @ (state.position - sides.point[side][:, None]) < 0.0
        state.position[:, out] += sides.shift[side][:, None]


def take_thickening(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """The rate of density at the present positions."""
    parameters = instant(parameters, state)
    fill(parameters, state, workspace)
    _sum_stretch(parameters, workspace)
    _store_thickening(parameters, state, workspace)


def take_forces(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """The acceleration at the present positions, and the transport for the next drift."""
    parameters = instant(parameters, state)
    fill(parameters, state, workspace)
    _sum_push(parameters, workspace)
    _store_acceleration(parameters, state, workspace, time)


def take_both(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Both of them; in a single sum where there is neither diffusion nor a wall's dummy."""
    parameters = instant(parameters, state)
    fill(parameters, state, workspace)
    choices, lists = parameters.choices, workspace.lists
    alone = choices[DIFFUSION] == NO_DIFFUSION and len(lists.counts) == state.position.shape[1]
    if alone and choices[STRESS] != TRANSPORT:
        sums = sums_of(choices)
        sums.both(workspace.fields, lists.counts, lists.neighbor, parameters.numbers, choices, workspace.rates)
    else:
        _sum_stretch(parameters, workspace)
        _sum_push(parameters, workspace)
    _store_thickening(parameters, state, workspace)
    _store_acceleration(parameters, state, workspace, time)


def _sum_stretch(parameters: Parameters, workspace: Workspace) -> None:
    lists, choices, numbers = workspace.lists, parameters.choices, parameters.numbers
    soft = ENTHALPY if choices[DIFFUSION] == HYDROSTATIC else RHO
    sums_of(choices).stretch(workspace.fields, lists.counts, lists.neighbor, numbers, choices, soft, workspace.rates)
    if choices[DIFFUSION] == ANTUONO:
        factor = 0.5 * numbers[DELTA] * numbers[SCALE]
        add_gradient_diffusion(
            workspace.fields, lists.counts, lists.neighbor, numbers, choices, factor, workspace.rates
        )


def _sum_push(parameters: Parameters, workspace: Workspace) -> None:
    lists, choices = workspace.lists, parameters.choices
    push = push_transported if choices[STRESS] == TRANSPORT else sums_of(choices).push
    push(workspace.fields, lists.counts, lists.neighbor, parameters.numbers, choices, workspace.rates)


def _store_thickening(parameters: Parameters, state: State, workspace: Workspace) -> None:
    by_mass = parameters.choices[STRESS] == MONAGHAN
    store_thickening(state.thickening, workspace.rates, state.density, by_mass)
    if parameters.gates:
        still(state)


def _store_acceleration(parameters: Parameters, state: State, workspace: Workspace, time: float) -> None:
    """Pressure is per weight, friction per mass; and gravity."""
    choices, lists = parameters.choices, workspace.lists
    per_volume = choices[STRESS] == SUM
    store_acceleration(state.acceleration, workspace.rates, state.density, parameters.gravity, per_volume)
    if parameters.pull_rate > 0.0:
        state.acceleration[...] -= parameters.pull_rate**2 * (state.position - parameters.pull_center[:, None])
    if parameters.turbulence:
        stir(parameters, workspace)
    if choices[FRICTION] != NO_FRICTION:
        rubbing = rub_radially if choices[FRICTION] == RADIAL else rub
        workspace.rates[ACC : ACC + 3] = 0.0
        rubbing(workspace.fields, lists.counts, lists.neighbor, parameters.numbers, choices, workspace.rates)
        state.acceleration[...] += workspace.rates[ACC : ACC + parameters.dimension]
    _push_bodies(parameters, state, workspace)
    if parameters.tension != NO_TENSION:
        pull(parameters, state, workspace)
    if parameters.background > 0.0 or parameters.shifting == DELTA_PLUS:
        shift(parameters, state, workspace, time)
    if parameters.gates:
        still(state)


def _push_bodies(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """What the liquid does to each body's particles, summed in their order."""
    bodies, dummies = parameters.bodies, parameters.boundary.dummies
    if not bodies.shapes:
        return
    force, place = forces_on_dummies(parameters, workspace, bodies.first)
    owner = dummies.owner[bodies.first :]
    names = len(parameters.boundary.names)
    sums = [
        total(force[:, owner == number], place[:, owner == number], state.pose[:3, body])
        for body, number in enumerate(range(names - len(bodies.shapes), names))
    ]
    load = np.array([force for force, _ in sums]), np.array([torque for _, torque in sums])
    state.push[...] = pushed(bodies, state.pose, state.motion, load, parameters.gravity)


def table_of(parameters: Parameters) -> Array:
    """The sides' table, with points from where sums count."""
    table = parameters.boundary.table.copy()
    table[:, : parameters.dimension] -= parameters.origin
    return table


def fill(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """The liquid's columns, its images', the walls', and the images of those."""
    fields, lists = workspace.fields, workspace.lists
    numbers, choices = parameters.numbers, parameters.choices
    count = state.position.shape[1]
    real = len(lists.counts)
    by_mass = bool(choices[STRESS] == MONAGHAN)
    of_liquid = state.position, state.velocity, state.density, state.mass
    fill_liquid(fields, *of_liquid, parameters.constants, parameters.origin, by_mass)
    if parameters.background > 0.0:
        fields[W : W + parameters.dimension, :count] = state.transport
    images = workspace.images
    of_images = fields, real, images.start, table_of(parameters), parameters.gravity, parameters.constants
    if parameters.moves:
        put_dummies(parameters, fields, count)
    if len(images.source):
        fill_images(images.source, *of_images)
    if choices[DIFFUSION] == ANTUONO:
        fill_density_gradients(fields, count, lists.counts, lists.neighbor, numbers, choices)
    if real > count:
        clip, constants = parameters.walls_clip, parameters.constants
        read_liquid(fields, count, lists.counts, lists.neighbor, numbers, choices, parameters.gravity, clip, constants)
    if len(images.source) and (real > count or choices[DIFFUSION] == ANTUONO):
        fill_images(images.source, *of_images)
    if fields.shape[1] > count:
        fill_weights(fields, count, by_mass)
