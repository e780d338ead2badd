"""The smooth part of a time step, scheme by scheme: what kick, drag and drift do when nothing touches."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ecume._jit import admit, compiled, compiled_inside, composed, selected
from ecume.engine.philox import counter_of, normals
from ecume.laws import brownian, dish_motion, drag
from ecume.laws.brownian import diffusivity
from ecume.laws.dish_motion import left_behind, sway_acceleration, sway_velocity
from ecume.laws.drag import schiller_naumann_factor
from ecume.models.floating.currents import current_at
from ecume.models.floating.interactions import evaluate
from ecume.models.floating.options import Option
from ecume.models.floating.parameters import Kick, Parameters, Parts, Scheme, Scratch
from ecume.models.floating.rows import clear, copy_rows, drift
from ecume.models.floating.shaped.bodies import RigidKicks
from ecume.models.floating.shaped.marching import (
    begin_rigid,
    finish_rigid,
    foresee_rigid,
    move_rigid,
    predict_rigid,
    store_rigid,
)
from ecume.models.floating.state import State, Workspace
from ecume.models.model import DONE
from ecume.units import Array

admit(brownian, drag, dish_motion)


@compiled
def give_kick(kick: Kick, velocity: Array, force: Array) -> None:
    """Drag and a force that stays for the kick's time, solved exactly."""
    decay, gain = kick.decay, kick.gain
    for i in range(force.shape[0]):
        velocity[i, 0] = decay[i] * velocity[i, 0] + gain[i] * force[i, 0]
        velocity[i, 1] = decay[i] * velocity[i, 1] + gain[i] * force[i, 1]


@compiled_inside
def kick_floats(parameters: Parameters, state: State, force: Array, ahead: float) -> None:
    """`give_kick`, with the drag of the scene's law and a dish in motion, `ahead` steps from now."""
    if parameters.drift.thickness > 0.0:
        give_fast_kick(parameters, state, force)
    else:
        give_kick(parameters.kick, state.velocity, force)
    if parameters.drift.sway.moves:
        leave_behind(parameters, state, (state.step[0] + ahead) * parameters.time_step)


@compiled
def leave_behind(parameters: Parameters, state: State, time: float) -> None:
    """What the motion of the dish does to velocities as seen from it; what has no inertia feels its velocity only."""
    sway, floats, gain, velocity = parameters.drift.sway, parameters.floats, parameters.kick.gain, state.velocity
    for axis in range(2):
        speed = sway.velocity[axis] + sway_velocity(sway.amplitude[axis], sway.turning, time)
        change = sway_acceleration(sway.amplitude[axis], sway.turning, time)
        change = change if parameters.scheme.inertia else 0.0
        for i in range(velocity.shape[0]):
            friction = floats.mass[i] / floats.relaxation_time[i]
            velocity[i, axis] += gain[i] * left_behind(floats.mass[i], friction, change, speed, sway.slip)


@compiled
def give_fast_kick(parameters: Parameters, state: State, force: Array) -> None:
    """A drag that grows with the speed through the liquid: that of the kick's beginning, then as in `give_kick`."""
    floats, velocity = parameters.floats, state.velocity
    time = 0.5 * parameters.time_step if parameters.scheme.half_kicks else parameters.time_step
    for i in range(force.shape[0]):
        friction = floats.mass[i] / floats.relaxation_time[i]
        along, across = current_at(parameters.drift, state.position[i, 0], state.position[i, 1])
        speed = math.sqrt((velocity[i, 0] - along) ** 2 + (velocity[i, 1] - across) ** 2)
        faster = schiller_naumann_factor(2.0 * floats.radius[i] * speed * parameters.drift.thickness)
        decay = math.exp(-time * faster / floats.relaxation_time[i])
        # The speed that the force and the flow would lead to; the force holds Stokes's part of the flow.
        last_x = along + (force[i, 0] - friction * along) / (friction * faster)
        last_y = across + (force[i, 1] - friction * across) / (friction * faster)
        velocity[i, 0] = last_x + decay * (velocity[i, 0] - last_x)
        velocity[i, 1] = last_y + decay * (velocity[i, 1] - last_y)


@compiled
def accelerate(parameters: Parameters, velocity: Array, force: Array, acceleration: Array) -> None:
    """F/m - v/tau."""
    mass, relaxation = parameters.floats.mass, parameters.floats.relaxation_time
    for i in range(force.shape[0]):
        acceleration[i, 0] = force[i, 0] / mass[i] - velocity[i, 0] / relaxation[i]
        acceleration[i, 1] = force[i, 1] / mass[i] - velocity[i, 1] / relaxation[i]


@compiled
def jiggle(parameters: Parameters, velocity: Array, step: int) -> None:
    """Brownian motion as a velocity of one step: a normal displacement of variance 2 kT/zeta dt along each axis."""
    gain, time = parameters.kick.gain, parameters.time_step
    for i in range(velocity.shape[0]):
        far = math.sqrt(2.0 * diffusivity(parameters.drift.thermal, 1.0 / gain[i]) / time)
        along, across = normals(counter_of(i, step, 0), parameters.drift.seed)
        velocity[i, 0] += far * along
        velocity[i, 1] += far * across


class Kicks(NamedTuple):
    """Schemes that kick and drift; `Parameters.scheme` says in which order."""


class RungeKutta(NamedTuple):
    """The classical scheme of fourth order."""


class Stoermer(NamedTuple):
    """Stoermer's scheme: drift, kick, drift."""


@composed
def predict_kicked(
    part: Kicks, parts: Parts, scratch: Scratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """The smooth part up to the drift: `passage` is the displacement over the time step, and the velocity has its
    kick.
    """
    kick_and_pass(parameters, state, workspace)


@compiled_inside
def kick_and_pass(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """See `predict_kicked`."""
    if parameters.scheme.drifts_first:
        copy_rows(workspace.passage, state.velocity)
        kick_floats(parameters, state, workspace.force, 0.5)
    else:
        kick_floats(parameters, state, workspace.force, 0.0 if parameters.scheme.half_kicks else 0.5)
        if parameters.drift.thermal > 0.0:
            jiggle(parameters, state.velocity, int(state.step[0]))
        copy_rows(workspace.passage, state.velocity)


@composed
def predict_runge_kutta(
    part: RungeKutta, parts: Parts, scratch: Scratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """The classical scheme of fourth order, drag included: passage and velocity change by the weighted means of four
    stages.
    """
    time, passage, stages = parameters.time_step, workspace.passage, workspace.stages
    position, velocity, rate, slope, push = stages[0], stages[1], stages[2], stages[3], stages[4]
    clear(passage)
    clear(rate)
    copy_rows(push, workspace.force)
    copy_rows(velocity, state.velocity)
    for stage in range(4):
        if stage > 0:
            ahead = time if stage == 3 else 0.5 * time
            copy_rows(position, state.position)
            drift(position, velocity, ahead)
            copy_rows(velocity, state.velocity)
            drift(velocity, slope, ahead)
            evaluate(parts, scratch, parameters, position, workspace.lists, push)
        accelerate(parameters, velocity, push, slope)
        weight = 1.0 / 6.0 if stage in (0, 3) else 1.0 / 3.0
        drift(passage, velocity, weight)
        drift(rate, slope, weight)
    drift(state.velocity, rate, time)


@composed
def predict_stoermer(
    part: Stoermer, parts: Parts, scratch: Scratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Drift, kick, drift: the midpoints obey x(t+dt) = 2 x(t) - x(t-dt) + dt^2 a. No force is known between steps."""
    passage, middle = workspace.passage, workspace.stages[0]
    copy_rows(passage, state.velocity)
    copy_rows(middle, state.position)
    drift(middle, state.velocity, 0.5 * parameters.time_step)
    evaluate(parts, scratch, parameters, middle, workspace.lists, workspace.force)
    give_kick(parameters.kick, state.velocity, workspace.force)
    average_rows(passage, state.velocity)


@compiled
def average_rows(rows: Array, others: Array) -> None:
    """Half of each row and half of each other row."""
    for i in range(len(others)):
        rows[i, 0] = 0.5 * (rows[i, 0] + others[i, 0])
        rows[i, 1] = 0.5 * (rows[i, 1] + others[i, 1])


@compiled
def finish_kicked(part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """The second half of a kick, where there are halves."""
    if parameters.scheme.half_kicks:
        kick_floats(parameters, state, workspace.force, 1.0)


@composed
def finish_runge_kutta(part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Nothing: the velocity has changed already."""


@compiled
def finish_stoermer(part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Forget the force in the middle of the step, so that the next step is not foreseen by it."""
    clear(workspace.force)


@compiled
def pass_straight(part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Drift with the velocity through the step."""
    drift(state.position, workspace.passage, parameters.time_step)


@composed
def nothing_to_begin(part: Any, scratch: Any, parameters: Parameters, state: State) -> None:
    """Discs and spheres need no preparation."""


@composed
def as_foreseen(part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> int:
    """Discs and spheres go no farther than their centers."""
    return DONE


@composed
def nothing_to_store(part: Any, scratch: Any, state: State) -> None:
    """The state has its velocities already."""


@dataclass(frozen=True, kw_only=True)
class Integrator(Option):
    """A row of the table of integrators, and everything that depends on it."""

    scheme: Scheme
    constants: type
    """the type of the part, a NamedTuple"""
    predict: Callable[..., None]
    """predict(part, parts, scratch, parameters, state, workspace): velocities and passage up to the drift"""
    finish: Callable[..., None] = finish_kicked
    """finish(part, scratch, parameters, state, workspace): the rest of the kick, with the forces at the end"""
    move: Callable[..., None] = pass_straight
    """move(part, scratch, parameters, state, workspace): the drift"""
    begin: Callable[..., None] = nothing_to_begin
    """begin(part, scratch, parameters, state): what a new workspace lacks"""
    foresee: Callable[..., int] = as_foreseen
    """foresee(part, scratch, parameters, state, workspace): add to `workspace.ahead`; DONE or DIVERGED"""
    store: Callable[..., None] = nothing_to_store
    """store(part, scratch, state): write velocities into the state at the end of a step"""


KICK_CAPABILITIES = frozenset({"kicks at the ends", "fast drag", "sways", "kicks spins", "keeps inertia"})


def _row(name: str, scheme: Scheme, gives: frozenset[str], **rest: Any) -> Integrator:
    given: dict[str, Any] = {"constants": Kicks, "predict": predict_kicked} | rest
    return Integrator(
        slot="integrator", path="integration.integrator", name=repr(name), gives=gives, scheme=scheme, **given
    )


INTEGRATORS = {
    "velocity-verlet": _row(
        "velocity-verlet", Scheme(True, True, False, True, True), KICK_CAPABILITIES | {"springs", "turns bodies"}
    ),
    "explicit-euler": _row("explicit-euler", Scheme(False, True, True, True, True), KICK_CAPABILITIES),
    "stormer-verlet": _row(
        "stormer-verlet", Scheme(False, True, False, True, False), frozenset({"keeps inertia"}),
        constants=Stoermer, predict=predict_stoermer, finish=finish_stoermer,
    ),
    "semi-implicit-euler": _row(
        "semi-implicit-euler", Scheme(False, True, False, False, True),
        KICK_CAPABILITIES | {"springs", "turns bodies", "kicks before the drift"},
    ),
    "rk4": _row(
        "rk4", Scheme(False, True, False, True, True), frozenset({"keeps inertia"}),
        constants=RungeKutta, predict=predict_runge_kutta, finish=finish_runge_kutta,
    ),
    "overdamped": _row(
        "overdamped", Scheme(False, False, False, False, True),
        frozenset({"kicks at the ends", "sways", "kicks spins", "springs", "turns bodies", "kicks before the drift",
                   "no inertia"}),
        needs={"drag": "without inertia, drag alone says how fast a force moves a float"},
    ),
}  # fmt: skip
"""The choices of `integration.integrator`."""
SCHEMES = tuple(INTEGRATORS)
RIGID = Integrator(
    slot="rigid integrator", path="particles", name="a float with a shape",
    scheme=Scheme(True, True, False, True, True),
    constants=RigidKicks, predict=predict_rigid, finish=finish_rigid, move=move_rigid, begin=begin_rigid,
    foresee=foresee_rigid, store=store_rigid,
)  # fmt: skip
"""Takes the place of an integrator's functions for floats with a shape."""
BY_CONSTANTS: dict[type, Integrator] = {row.constants: row for row in (*INTEGRATORS.values(), RIGID)}

predict = selected(lambda kind: BY_CONSTANTS[kind].predict)
finish = selected(lambda kind: BY_CONSTANTS[kind].finish)
move = selected(lambda kind: BY_CONSTANTS[kind].move)
begin = selected(lambda kind: BY_CONSTANTS[kind].begin)
foresee = selected(lambda kind: BY_CONSTANTS[kind].foresee)
store = selected(lambda kind: BY_CONSTANTS[kind].store)
