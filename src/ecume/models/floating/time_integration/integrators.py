"""The table of integrators: kick, drag and drift of a time step without contacts, and the work done from outside.

Energy budget: the work done on floats from outside in each step, by a current, by a moving dish, and by noise. The drag
by a current is zeta (u - v). Its part zeta u does the injected work; -zeta v is the dissipative drag of a liquid at
rest. A float that drifts with the current receives zeta u^2 and dissipates as much. In its frame, a moving dish exerts
an inertial force and the drag of `left_behind`. Noise exchanges heat with the floats: the work of the random force and
of the drag together along a path is -F o dx of all other forces, in the sense of Stratonovich [sekimoto1998]. Contacts
are hard and do no work.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from ecume._jit import admit, compiled, compiled_inside, composed, selected
from ecume._tables import by_constants
from ecume.engine.philox import counter_of, normals
from ecume.laws import brownian_motion, drag, moving_dish
from ecume.laws.brownian_motion import diffusivity, velocity_variance
from ecume.laws.drag import schiller_naumann_factor
from ecume.laws.moving_dish import left_behind, sway_acceleration, sway_velocity
from ecume.models.floating.coupled.hydrodynamics import (
    add_coupled_heat,
    add_coupled_work,
    fastest_coupled,
    predict_coupled,
    scratch_on_grid,
    scratch_with_matrix,
)
from ecume.models.floating.coupled.mobility import (
    CoupledKicks,
    GridKicks,
    coupled_memory,
    coupled_pairs,
    grid_memory,
    grid_pairs,
)
from ecume.models.floating.forces.flow_and_noise import current_at, set_clock, straight_current
from ecume.models.floating.forces.interactions import evaluate
from ecume.models.floating.options import Option
from ecume.models.floating.parameters import (
    DRIVEN,
    WORK,
    Kick,
    Parameters,
    Parts,
    Scheme,
    Scratch,
    State,
    Workspace,
    advance_rows,
    clear,
    copy_rows,
    is_driven,
    is_langevin,
)
from ecume.models.floating.shaped.bodies import (
    RigidKicks,
    add_rigid_heat,
    add_rigid_work,
    begin_rigid,
    bound_rigid_travel,
    fastest_rigid,
    finish_rigid,
    move_rigid,
    predict_rigid,
    store_rigid,
)
from ecume.models.model import DONE
from ecume.units import Array

admit(brownian_motion, drag, moving_dish)


@compiled
def power_of_current(
    parameters: Parameters, state: State, midstep_velocity: Array, ahead: float, moved: float
) -> float:
    """The power of the drag of the current (W), `ahead` steps after the beginning of the step, at the places of floats
    that have yet to move by `moved` steps: 0.5 and 0.5 at its midpoint.
    """
    mass, relaxation, radius = parameters.floats.mass, parameters.floats.relaxation_time, parameters.floats.radius
    drift, position, velocity, yet = parameters.drift, state.position, state.velocity, moved * parameters.time_step
    flow, thickness, tabled, power = drift.flow, drift.thickness, drift.nodes.shape[1] > 0, 0.0
    time = (state.step[0] + ahead) * parameters.time_step
    for i in range(len(position)):
        x, y = position[i, 0] + yet * midstep_velocity[i, 0], position[i, 1] + yet * midstep_velocity[i, 1]
        # Passing the whole of `drift` is slow.
        along, across = current_at(drift, time, x, y) if tabled else straight_current(flow, x, y)
        friction = mass[i] / relaxation[i]
        if thickness > 0.0:
            slip = math.sqrt((velocity[i, 0] - along) ** 2 + (velocity[i, 1] - across) ** 2)
            friction *= schiller_naumann_factor(2.0 * radius[i] * slip * thickness)
        power += friction * (along * midstep_velocity[i, 0] + across * midstep_velocity[i, 1])
    return power


@compiled_inside
def motion_of_dish(parameters: Parameters, axis: int, time: float) -> tuple[float, float]:
    """The velocity of the dish along an axis, and its acceleration, which does not act on floats without inertia."""
    sway = parameters.drift.sway
    speed = sway.velocity[axis] + sway_velocity(sway.amplitude[axis], sway.turning, time)
    change = sway_acceleration(sway.amplitude[axis], sway.turning, time)
    return speed, change if parameters.scheme.inertia else 0.0


@compiled
def add_dish_force(parameters: Parameters, time: float, force: Array) -> None:
    """Add the forces on floats in the frame of a moving dish."""
    floats, sway = parameters.floats, parameters.drift.sway
    for axis in range(2 if sway.moves else 0):
        speed, change = motion_of_dish(parameters, axis, time)
        for i in range(len(force)):
            friction = floats.mass[i] / floats.relaxation_time[i]
            force[i, axis] += left_behind(floats.mass[i], friction, change, speed, sway.slip)


@compiled
def power_of_dish(parameters: Parameters, midstep_velocity: Array, time: float) -> float:
    """The power of a moving dish, in its frame (W)."""
    mass, relaxation, slip = parameters.floats.mass, parameters.floats.relaxation_time, parameters.drift.sway.slip
    power = 0.0
    for axis in range(2):
        speed, change = motion_of_dish(parameters, axis, time)
        for i in range(len(mass)):
            pulled = left_behind(mass[i], mass[i] / relaxation[i], change, speed, slip)
            power += midstep_velocity[i, axis] * pulled
    return power


@compiled
def add_work_of_kicks(part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Add the work of one step, by the forces at its midpoint."""
    drift, tally, time, midstep_velocity = (
        parameters.drift,
        state.tally,
        parameters.time_step,
        workspace.midstep_velocity,
    )
    # States of former versions have no such entry.
    if len(tally) <= WORK:
        return
    if drift.flows and not drift.thermal > 0.0:
        tally[WORK] += time * power_of_current(parameters, state, midstep_velocity, 0.5, 0.5)
    if drift.sway.moves and not drift.thermal > 0.0:
        tally[WORK] += time * power_of_dish(parameters, midstep_velocity, (state.step[0] + 0.5) * time)


@compiled
def add_heat_of_noise(
    part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace, ahead: float
) -> None:
    """Add the heat of half a step, by the forces at its beginning or end (`ahead` is 0 or 1), including a moving dish,
    and the work of the current, whose drag is among them.
    """
    midstep_velocity, force, power = workspace.midstep_velocity, workspace.force, 0.0
    if parameters.drift.thermal > 0.0 and len(state.tally) > WORK:
        for i in range(len(force)):
            power += force[i, 0] * midstep_velocity[i, 0] + force[i, 1] * midstep_velocity[i, 1]
        if parameters.drift.flows:
            power -= power_of_current(parameters, state, midstep_velocity, ahead, 0.0)
        state.tally[WORK] -= 0.5 * parameters.time_step * power


@compiled
def apply_kick(kick: Kick, velocity: Array, force: Array) -> None:
    """Change velocities by drag and a force that is constant during the kick, solved exactly."""
    decay, gain = kick.decay, kick.gain
    for i in range(force.shape[0]):
        velocity[i, 0] = decay[i] * velocity[i, 0] + gain[i] * force[i, 0]
        velocity[i, 1] = decay[i] * velocity[i, 1] + gain[i] * force[i, 1]


@compiled_inside
def kick_floats(part: Any, parameters: Parameters, state: State, force: Array, ahead: float) -> None:
    """Apply a kick with the drag law of the scene and a moving dish, `ahead` steps later."""
    if parameters.drift.thickness > 0.0:
        # The forces are those at the beginning of a step, or at its end after the drift.
        now = (state.step[0] + int(ahead)) * parameters.time_step
        apply_nonlinear_kick(parameters, state.position, state.velocity, force, now)
    else:
        apply_kick(parameters.kick, state.velocity, force)
    move_dish(part, parameters, state, ahead)


@compiled
def add_dish_motion(part: Any, parameters: Parameters, state: State, ahead: float) -> None:
    """Change velocities by the motion of the dish, in its frame; without inertia only the velocity of the dish
    matters.
    """
    if not parameters.drift.sway.moves:
        return
    time = (state.step[0] + ahead) * parameters.time_step
    sway, floats, gain, velocity = parameters.drift.sway, parameters.floats, parameters.kick.gain, state.velocity
    for axis in range(2):
        speed, change = motion_of_dish(parameters, axis, time)
        for i in range(velocity.shape[0]):
            friction = floats.mass[i] / floats.relaxation_time[i]
            velocity[i, axis] += gain[i] * left_behind(floats.mass[i], friction, change, speed, sway.slip)


@compiled
def apply_nonlinear_kick(parameters: Parameters, position: Array, velocity: Array, force: Array, now: float) -> None:
    """Apply a kick with a drag coefficient that depends on the speed at the beginning of the kick; `now` is the time
    of the forces (s).
    """
    floats, along, across = parameters.floats, 0.0, 0.0
    time = 0.5 * parameters.time_step if parameters.scheme.half_kicks else parameters.time_step
    for i in range(force.shape[0]):
        friction = floats.mass[i] / floats.relaxation_time[i]
        if parameters.drift.flows:
            along, across = current_at(parameters.drift, now, position[i, 0], position[i, 1])
        speed = math.sqrt((velocity[i, 0] - along) ** 2 + (velocity[i, 1] - across) ** 2)
        faster = schiller_naumann_factor(2.0 * floats.radius[i] * speed * parameters.drift.thickness)
        decay = math.exp(-time * faster / floats.relaxation_time[i])
        # The terminal velocity by force and flow; the force contains the Stokes drag of the flow.
        last_x = along + (force[i, 0] - friction * along) / (friction * faster)
        last_y = across + (force[i, 1] - friction * across) / (friction * faster)
        velocity[i, 0] = last_x + decay * (velocity[i, 0] - last_x)
        velocity[i, 1] = last_y + decay * (velocity[i, 1] - last_y)


@compiled
def accelerate(parameters: Parameters, velocity: Array, force: Array, acceleration: Array) -> None:
    """Compute accelerations F/m - v/tau."""
    mass, relaxation = parameters.floats.mass, parameters.floats.relaxation_time
    for i in range(force.shape[0]):
        acceleration[i, 0] = force[i, 0] / mass[i] - velocity[i, 0] / relaxation[i]
        acceleration[i, 1] = force[i, 1] / mass[i] - velocity[i, 1] / relaxation[i]


@compiled
def add_noise(parameters: Parameters, velocity: Array, step: int) -> None:
    """Add Brownian motion to the velocities: a normal displacement of variance 2 kT/zeta dt along each axis."""
    gain, time = parameters.kick.gain, parameters.time_step
    for i in range(velocity.shape[0]):
        far = math.sqrt(2.0 * diffusivity(parameters.drift.thermal, 1.0 / gain[i]) / time)
        along, across = normals(counter_of(i, step, 0), parameters.drift.seed)
        velocity[i, 0] += far * along
        velocity[i, 1] += far * across


class Kicks(NamedTuple):
    """Schemes of kicks and drift, in the order of `Parameters.scheme`."""


class DrivenKicks(NamedTuple):
    """Kicks of floats on which noise, a current, a moving dish or other sources do work."""


class LangevinKicks(NamedTuple):
    """Kicks of floats with inertia and thermal noise, without drag, which `thermalize` includes."""


class LangevinStoermer(NamedTuple):
    """Stoermer's scheme of floats with inertia and thermal noise."""


class RungeKutta(NamedTuple):
    """The classical scheme of fourth order."""


class Stoermer(NamedTuple):
    """Stoermer's scheme: drift, kick, drift."""


@compiled
def predict_kicked(
    part: Any, parts: Parts, scratches: Scratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Compute velocities after their kick, and the midstep velocities."""
    if parameters.scheme.drifts_first:
        copy_rows(workspace.midstep_velocity, state.velocity)
        kick_floats(part, parameters, state, workspace.force, 0.5)
    else:
        kick_floats(part, parameters, state, workspace.force, 0.0 if parameters.scheme.half_kicks else 0.5)
        copy_rows(workspace.midstep_velocity, state.velocity)
        disturb(part, parameters, state, workspace)


@compiled
def add_flow_and_noise(part: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Add the change of the current until the middle of the step and Brownian displacements to the midstep velocities;
    without inertia these are the velocities. Store the velocities without noise.
    """
    if parameters.drift.flows:
        turn_with_current(parameters, state, workspace.midstep_velocity)
        if not parameters.scheme.inertia:
            copy_rows(state.velocity, workspace.midstep_velocity[: len(state.velocity)])
    if parameters.drift.thermal > 0.0:
        copy_rows(workspace.stages[DRIVEN], state.velocity)
        add_noise(parameters, state.velocity, int(state.step[0]))
        copy_rows(workspace.midstep_velocity, state.velocity)


@compiled
def turn_with_current(parameters: Parameters, state: State, midstep_velocity: Array) -> None:
    """Add the change of the current from the place of each float to that where it is at the middle of the step, as far
    as drag transmits it in a kick: Runge's midpoint rule [runge1895], of second order for floats that go with
    the current. The kick itself used the current at the beginning; in velocity Verlet the errors of its two halves
    cancel, so that the velocities at the ends of a step need no change.
    """
    drift, position, half = parameters.drift, state.position, 0.5 * parameters.time_step
    flow, now, tabled = drift.flow, state.step[0] * parameters.time_step, drift.nodes.shape[1] > 0
    if not (tabled or flow[2] != 0.0 or flow[3] != 0.0 or flow[4] != 0.0 or flow[5] != 0.0):
        return
    for i in range(len(position)):
        carried, x, y = 1.0 - parameters.kick.decay[i], position[i, 0], position[i, 1]
        ahead_x, ahead_y = x + half * midstep_velocity[i, 0], y + half * midstep_velocity[i, 1]
        along, across = current_at(drift, now, x, y) if tabled else straight_current(flow, x, y)
        last_x, last_y = (
            current_at(drift, now + half, ahead_x, ahead_y) if tabled else straight_current(flow, ahead_x, ahead_y)
        )
        midstep_velocity[i, 0] += carried * (last_x - along)
        midstep_velocity[i, 1] += carried * (last_y - across)


@composed
def predict_runge_kutta(
    part: RungeKutta, parts: Parts, scratches: Scratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Compute velocities by the classical scheme of fourth order, including drag: positions and velocities change by
    weighted means of four stages.
    """
    time, midstep_velocity, stages = parameters.time_step, workspace.midstep_velocity, workspace.stages
    position, velocity, rate, slope, push = stages[0], stages[1], stages[2], stages[3], stages[4]
    clear(midstep_velocity)
    clear(rate)
    copy_rows(push, workspace.force)
    add_dish_force(parameters, state.step[0] * time, push)
    copy_rows(velocity, state.velocity)
    for stage in range(4):
        if stage > 0:
            ahead = time if stage == 3 else 0.5 * time
            copy_rows(position, state.position)
            advance_rows(position, velocity, ahead)
            copy_rows(velocity, state.velocity)
            advance_rows(velocity, slope, ahead)
            set_clock(scratches, state.step[0] * time + ahead)
            evaluate(parts, scratches, parameters, position, workspace.lists, push)
            add_dish_force(parameters, state.step[0] * time + ahead, push)
        accelerate(parameters, velocity, push, slope)
        weight = 1.0 / 6.0 if stage in (0, 3) else 1.0 / 3.0
        advance_rows(midstep_velocity, velocity, weight)
        advance_rows(rate, slope, weight)
    advance_rows(state.velocity, rate, time)


@composed
def predict_stoermer(
    part: Stoermer, parts: Parts, scratches: Scratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Compute the midpoint of drift, kick, drift: midpoints obey x(t+dt) = 2 x(t) - x(t-dt) + dt^2 a. There is no force
    between steps.
    """
    midstep_velocity, middle = workspace.midstep_velocity, workspace.stages[0]
    copy_rows(midstep_velocity, state.velocity)
    copy_rows(middle, state.position)
    advance_rows(middle, state.velocity, 0.5 * parameters.time_step)
    now = (state.step[0] + 0.5) * parameters.time_step
    set_clock(scratches, now)
    evaluate(parts, scratches, parameters, middle, workspace.lists, workspace.force)
    add_dish_force(parameters, now, workspace.force)
    if parameters.drift.thickness > 0.0:
        apply_nonlinear_kick(parameters, middle, state.velocity, workspace.force, now)
    else:
        apply_kick(parameters.kick, state.velocity, workspace.force)
    average_rows(midstep_velocity, state.velocity)


@compiled
def average_rows(rows: Array, others: Array) -> None:
    """Replace each row by the mean of it and the row of `others`."""
    for i in range(len(others)):
        rows[i, 0] = 0.5 * (rows[i, 0] + others[i, 0])
        rows[i, 1] = 0.5 * (rows[i, 1] + others[i, 1])


@compiled
def finish_kicked(part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Apply the second half kick, if the scheme has one."""
    if parameters.scheme.half_kicks:
        kick_floats(part, parameters, state, workspace.force, 1.0)


@compiled
def finish_stoermer(part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Clear the force at the midpoint, so that it does not affect the travel bound of the next step."""
    clear(workspace.force)


@compiled
def fastest_kicked(part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> float:
    """The highest possible midstep speed of any float, without contacts; NaN if any speed is NaN."""
    kick, velocity, force, fastest = parameters.kick, state.velocity, workspace.force, 0.0
    for i in range(velocity.shape[0]):
        # A velocity that drag stops at once does not move a float.
        speed = math.sqrt(velocity[i, 0] ** 2 + velocity[i, 1] ** 2) if kick.decay[i] > 0.0 else 0.0
        speed += kick.gain[i] * math.sqrt(force[i, 0] ** 2 + force[i, 1] ** 2)
        # Written so that a NaN is kept.
        if fastest == fastest and not speed <= fastest:
            fastest = speed
    return fastest


@compiled
def thermalize(part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Relax the velocities during one step by drag and thermal noise: Ornstein and Uhlenbeck's process
    [uhlenbeck1930], exact for any step, toward the velocity of the surface. It alternates with steps that contain all
    other forces [bussi2007]; its half steps at the end of one step and at the beginning of the next are one. Add the
    work of drag and noise together.
    """
    drift, velocity, floats, time = parameters.drift, state.velocity, parameters.floats, parameters.time_step
    now, step, gained = (state.step[0] + 1) * time, int(state.step[0]), 0.0
    for i in range(len(velocity)):
        ratio, flow_x, flow_y, x, y = time / floats.relaxation_time[i], 0.0, 0.0, velocity[i, 0], velocity[i, 1]
        if drift.flows:
            flow_x, flow_y = current_at(drift, now, state.position[i, 0], state.position[i, 1])
        kept, spread = math.exp(-ratio), math.sqrt(drift.thermal / floats.mass[i] * velocity_variance(ratio))
        along, across = normals(counter_of(i, step, 0), drift.seed)
        velocity[i, 0] = flow_x + kept * (x - flow_x) + spread * along
        velocity[i, 1] = flow_y + kept * (y - flow_y) + spread * across
        gained += 0.5 * floats.mass[i] * (velocity[i, 0] ** 2 + velocity[i, 1] ** 2 - x * x - y * y)
    if len(state.tally) > WORK:
        state.tally[WORK] += gained


@compiled
def drift_straight(part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Advance positions with the midstep velocities."""
    advance_rows(state.position, workspace.midstep_velocity, parameters.time_step)


@dataclass(frozen=True, kw_only=True)
class Integrator(Option):
    """A row of the table of integrators, and everything that depends on it."""

    scheme: Scheme
    constants: type
    """the type of the part, a NamedTuple"""
    drag_limit: float = math.inf
    """the longest stable time step over the shortest relaxation time of drag; infinite if drag is solved exactly"""
    predict: Callable[..., None]
    """predict(part, parts, scratch, parameters, state, workspace): velocities and midstep velocities"""
    finish: Callable[..., None] | None = finish_kicked
    """finish(part, scratch, parameters, state, workspace): the rest of the kick, with the forces at the end; None if
    `predict` has computed all
    """
    move: Callable[..., None] = drift_straight
    """move(part, scratch, parameters, state, workspace): the drift"""
    begin: Callable[..., None] | None = None
    """begin(part, scratch, parameters, state): complete a new workspace"""
    bound_travel: Callable[..., int] | None = None
    """bound_travel(part, scratch, parameters, state, workspace): add to `workspace.travel`; DONE or DIVERGED. None if
    floats travel as far as their centers
    """
    store: Callable[..., None] | None = None
    """store(part, scratch, parameters, state, workspace): complete the velocities in the state at the end of a step"""
    highest_speed: Callable[..., float] = fastest_kicked
    """highest_speed(part, scratch, parameters, state, workspace): without contacts and noise"""
    add_work: Callable[..., None] | None = add_work_of_kicks
    """add_work(part, scratch, parameters, state, workspace): the work of currents and of a moving dish in a step"""
    add_heat: Callable[..., None] | None = add_heat_of_noise
    """add_heat(part, scratch, parameters, state, workspace, ahead): the heat of half a step with noise, at its
    beginning (`ahead` = 0) and its end (1)
    """
    disturb: Callable[..., None] | None = None
    """disturb(part, parameters, state, workspace): add what the current of the middle of the step and thermal noise
    change to the midstep velocities after a kick
    """
    move_dish: Callable[..., None] | None = None
    """move_dish(part, parameters, state, ahead): change velocities by the motion of the dish"""
    scratch: Callable[[Any, tuple[Any, ...]], Any] = lambda part, interactions: ()
    """scratch(part, workspaces of the interactions): the workspace"""
    compiled: bool = True
    """whether compiled code can call these functions; if not, Python runs the time steps"""
    velocities: int = 2
    """velocities of each float at midstep: two, or three with a spin"""
    pairs_worth: Callable[[Any], float] = lambda part: 0.0
    """pairs_worth(part): work of a time step in addition to lists, in pairs"""
    memory: Callable[[Any], float] = lambda part: 0.0
    """memory(part): bytes in addition to those of each float"""


KICK_CAPABILITIES = frozenset(
    {"takes noise", "kicks at the ends", "fast drag", "sways", "kicks spins", "keeps inertia"}
)


def _row(name: str, scheme: Scheme, gives: frozenset[str], **rest: Any) -> Integrator:
    if "predict" in rest and "constants" not in rest:
        raise TypeError(
            f"integrator {name!r}: got predict without constants; expected the type by which compiled code finds it"
        )
    kicks = {"constants": Kicks, "predict": predict_kicked, "add_work": None, "add_heat": None}
    given: dict[str, Any] = rest if "constants" in rest else kicks | rest
    return Integrator(
        slot="integrator", path="integration.integrator", name=repr(name), gives=gives, scheme=scheme, **given
    )


INTEGRATORS = {
    "velocity-verlet": _row(
        "velocity-verlet",
        Scheme(half_kicks=True, inertia=True, drifts_first=False, contacts_at_end=True, forces_at_end=True),
        KICK_CAPABILITIES | {"springs", "turns bodies"},
    ),
    "explicit-euler": _row(
        "explicit-euler",
        Scheme(half_kicks=False, inertia=True, drifts_first=True, contacts_at_end=True, forces_at_end=True),
        KICK_CAPABILITIES,
    ),
    "stormer-verlet": _row(
        "stormer-verlet",
        Scheme(half_kicks=False, inertia=True, drifts_first=False, contacts_at_end=True, forces_at_end=False),
        frozenset({"keeps inertia", "takes noise", "sways", "fast drag"}),
        constants=Stoermer, predict=predict_stoermer, finish=finish_stoermer,
    ),
    "semi-implicit-euler": _row(
        "semi-implicit-euler",
        Scheme(half_kicks=False, inertia=True, drifts_first=False, contacts_at_end=False, forces_at_end=True),
        KICK_CAPABILITIES | {"springs", "turns bodies"},
    ),
    "rk4": _row(
        "rk4",
        Scheme(half_kicks=False, inertia=True, drifts_first=False, contacts_at_end=True, forces_at_end=True),
        frozenset({"keeps inertia", "sways"}),
        constants=RungeKutta, predict=predict_runge_kutta, finish=None, drag_limit=2.0,
    ),
    "overdamped": _row(
        "overdamped",
        Scheme(half_kicks=False, inertia=False, drifts_first=False, contacts_at_end=False, forces_at_end=True),
        frozenset({"kicks at the ends", "sways", "kicks spins", "springs", "turns bodies", "no inertia"})
        | {"takes noise"},
        needs={"drag": "without inertia, drag alone says how fast a force moves a float"},
    ),
}  # fmt: skip
"""The choices of `integration.integrator`."""

SCHEMES = tuple(INTEGRATORS)
DRIVEN_KICKS = replace(
    INTEGRATORS["velocity-verlet"], slot="driven integrator", constants=DrivenKicks, add_work=add_work_of_kicks,
    add_heat=add_heat_of_noise, disturb=add_flow_and_noise, move_dish=add_dish_motion,
)  # fmt: skip
"""Replaces the functions of schemes with kicks for floats on which something does work: most floats are at rest, and
need not compile them.
"""
LANGEVIN_KICKS = replace(INTEGRATORS["velocity-verlet"], constants=LangevinKicks, store=thermalize)
LANGEVIN_STOERMER = replace(
    INTEGRATORS["stormer-verlet"], constants=LangevinStoermer, store=thermalize, add_work=None, add_heat=None
)
"""Replace schemes with inertia for floats with thermal noise."""

RIGID = Integrator(
    slot="rigid integrator", path="particles", name="a float with a shape",
    scheme=Scheme(half_kicks=True, inertia=True, drifts_first=False, contacts_at_end=True, forces_at_end=True),
    constants=RigidKicks, predict=predict_rigid, finish=finish_rigid, move=move_rigid, begin=begin_rigid,
    bound_travel=bound_rigid_travel, store=store_rigid, add_heat=add_rigid_heat, add_work=add_rigid_work,
    highest_speed=fastest_rigid,
    scratch=lambda part, interactions: interactions[0], velocities=3,
)  # fmt: skip
"""The row that replaces an integrator for floats with a shape."""

COUPLED = Integrator(
    slot="coupled integrator", path="hydrodynamics.interaction", name="hydrodynamic interaction",
    scheme=INTEGRATORS["overdamped"].scheme._replace(drags_along=False),
    constants=CoupledKicks, predict=predict_coupled, finish=None, highest_speed=fastest_coupled,
    add_work=add_coupled_work, add_heat=add_coupled_heat, scratch=scratch_with_matrix,
    pairs_worth=coupled_pairs, memory=coupled_memory,
)  # fmt: skip

COUPLED_ON_GRID = replace(
    COUPLED, constants=GridKicks, scratch=scratch_on_grid, pairs_worth=grid_pairs, memory=grid_memory, compiled=False
)  # fmt: skip
"""The row that replaces the overdamped integrator for floats that interact through the liquid."""

OF_THE_CHOICE = frozenset({"name", "path", "scheme", "gives", "needs", "drag_limit"})
"""Fields that are read from the row that a scene chooses, so that rows with kicks may differ in them."""

INTEGRATORS_BY_CONSTANTS = by_constants(
    (*INTEGRATORS.values(), DRIVEN_KICKS, LANGEVIN_KICKS, LANGEVIN_STOERMER, RIGID, COUPLED, COUPLED_ON_GRID),
    OF_THE_CHOICE,
)

predict = selected(INTEGRATORS_BY_CONSTANTS, "predict")
finish = selected(INTEGRATORS_BY_CONSTANTS, "finish")
move = selected(INTEGRATORS_BY_CONSTANTS, "move")
begin = selected(INTEGRATORS_BY_CONSTANTS, "begin")
bound_travel = selected(INTEGRATORS_BY_CONSTANTS, "bound_travel", DONE)
store = selected(INTEGRATORS_BY_CONSTANTS, "store")
highest_speed = selected(INTEGRATORS_BY_CONSTANTS, "highest_speed")
add_work = selected(INTEGRATORS_BY_CONSTANTS, "add_work")
add_heat = selected(INTEGRATORS_BY_CONSTANTS, "add_heat")
disturb = selected(INTEGRATORS_BY_CONSTANTS, "disturb")
move_dish = selected(INTEGRATORS_BY_CONSTANTS, "move_dish")


def kicks_of(integrator: Integrator, parameters: Parameters) -> Any:
    """The constants of an integrator, in separate types for kicks of floats on which external sources do work, and for
    floats with inertia and thermal noise.
    """
    if is_langevin(parameters):
        return LangevinKicks() if integrator.constants is Kicks else LangevinStoermer()
    return DrivenKicks() if integrator.constants is Kicks and is_driven(parameters) else integrator.constants()
