"""Flow of the surface, thermal noise and motion of the dish: their constants, and the drag of the flow.

Active floats: a random force with a memory, propulsion along a heading that diffuses, and a constant torque.

The random force is an Ornstein-Uhlenbeck process, renewed exactly once per step. The heading of a float turns by its
torque against the drag of the liquid and by rotational diffusion, to which thermal noise adds kT over that drag; if
contacts turn the float, it turns along.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecume._jit import compiled, compiled_inside
from ecume.engine.neighbors import NeighborLists
from ecume.engine.philox import counter_of, normals
from ecume.laws import diffusion
from ecume.models.floating.options import Built, scene_error
from ecume.models.floating.parameters import DRAG_LAWS, WORK, Drift, Parameters, State, Sway, Workspace
from ecume.models.floating.setup.kinds import turning_frictions
from ecume.models.liquids import liquid_of
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene, NodesSpec


def _driven(scene: FloatingScene) -> bool:
    """Whether floats have active forces, or forces by waves or a magnetic field."""
    return scene.activity is not None or scene.waves is not None or scene.magnetic_field is not None


def drift_of(scene: FloatingScene) -> Drift:
    """The flow and the noise of a scene; both need drag."""
    flow, liquid = scene.flow, liquid_of(scene)
    fast = scene.hydrodynamics.drag == DRAG_LAWS[1]
    rates = np.zeros(6)
    if flow is not None:
        turning, apart = flow.rotation_rate, flow.extension_rate
        rates = np.array([*flow.velocity, apart, flow.shear_rate - turning, turning, -apart])
    nodes, frame = _nodes_of(flow.nodes) if flow is not None and flow.nodes is not None else NO_NODES
    slowing = liquid.density / liquid.viscosity if fast else 0.0
    thermal = diffusion.thermal_energy(scene.liquid.temperature) if scene.hydrodynamics.brownian else 0.0
    flows = bool(np.any(rates)) or bool(np.any(nodes))
    return Drift(
        rates,
        nodes,
        frame,
        flows,
        thermal,
        scene.seed,
        slowing,
        0.0,
        sway_of(scene),
        _driven(scene),
    )


def sway_of(scene: FloatingScene) -> Sway:
    """The motion of the dish."""
    moved = scene.dish.motion if scene.dish is not None else None
    if moved is None:
        return Sway(False, np.zeros(2), np.zeros(2), 0.0, 0.0)
    heading = np.array([math.cos(moved.direction), math.sin(moved.direction)])
    turning = 2.0 * math.pi * moved.frequency
    return Sway(True, np.array(moved.velocity), moved.amplitude * heading, turning, 1.0 - moved.entrainment)


NO_NODES = np.zeros((2, 0, 0)), np.zeros(4)


def _nodes_of(nodes: NodesSpec) -> tuple[Array, Array]:
    """The velocities at the nodes of a table, and the frame of the nodes."""
    table, low, high = np.array([nodes.vx, nodes.vy]), np.array(nodes.low), np.array(nodes.high)
    return table, np.concatenate([low, (np.array(table.shape[1:]) - 1.0) / (high - low)])


@compiled_inside
def straight_current(flow: Array, x: float, y: float) -> tuple[float, float]:
    """The velocity of a flow that is uniform, or linear in the position (m/s)."""
    return flow[0] + flow[2] * x + flow[3] * y, flow[1] + flow[4] * x + flow[5] * y


@compiled
def current_at(drift: Drift, x: float, y: float) -> tuple[float, float]:
    """The velocity of the surface (m/s)."""
    along, across = straight_current(drift.flow, x, y)
    if drift.nodes.shape[1] > 0:
        more_along, more_across = between_nodes(drift, x, y)
        along, across = along + more_along, across + more_across
    return along, across


@compiled
def between_nodes(drift: Drift, x: float, y: float) -> tuple[float, float]:
    """The velocity from a table (m/s): bilinear between its nodes, constant beyond its edge."""
    nodes, frame = drift.nodes, drift.frame
    last_x, last_y = nodes.shape[1] - 1.0, nodes.shape[2] - 1.0
    u = min(max((x - frame[0]) * frame[2], 0.0), last_x)
    v = min(max((y - frame[1]) * frame[3], 0.0), last_y)
    i, j = int(min(u, last_x - 1.0)), int(min(v, last_y - 1.0))
    u, v = u - i, v - j
    low, high = (1.0 - u) * (1.0 - v), u * (1.0 - v)
    left, right = (1.0 - u) * v, u * v
    along = low * nodes[0, i, j] + high * nodes[0, i + 1, j] + left * nodes[0, i, j + 1]
    across = low * nodes[1, i, j] + high * nodes[1, i + 1, j] + left * nodes[1, i, j + 1]
    return along + right * nodes[0, i + 1, j + 1], across + right * nodes[1, i + 1, j + 1]


@compiled
def add_flow(parameters: Parameters, position: Array, force: Array) -> None:
    """Add the drag of the flowing surface: zeta u, where u is its velocity at the center of the float."""
    mass, relaxation = parameters.floats.mass, parameters.floats.relaxation_time
    for i in range(position.shape[0]):
        friction, (along, across) = (
            mass[i] / relaxation[i],
            current_at(parameters.drift, position[i, 0], position[i, 1]),
        )
        force[i, 0] += friction * along
        force[i, 1] += friction * across


FORCES, HEADINGS = 2, 3
"""Purposes of random numbers; those of thermal noise are 0 and 1."""

START = 11
"""Separates the random numbers of the first forces and headings from others."""

DEVIATIONS = 5.0
"""Standard deviations of the random force that a time step allows for."""


class Activity(NamedTuple):
    """Constants of active floats."""

    force: Array
    """(N,) N: root mean square of the random force along each axis"""
    persistence: float
    """s: correlation time of the random force"""
    propulsion: Array
    """(N,) N"""
    diffusion: Array
    """(N,) rad^2/s: rotational diffusion coefficient of the headings"""
    turning: Array
    """(N,) rad/s by the torque"""
    seed: int


class ActivityScratch(NamedTuple):
    """What the forces read: the state, and the forces of the step before."""

    active: Array
    """(N, 3) that of the state"""
    turning: Array
    """that of the state"""
    before: Array
    """(N, 2) N"""


def make_activity_scratch(
    part: Activity, parameters: Parameters, state: State, workspace: Workspace
) -> ActivityScratch:
    """Return the workspace."""
    return ActivityScratch(state.active, state.turning, np.zeros((len(state.position), 2)))


def with_activity(part: Activity, state: State) -> State:
    """Return the state with stationary random forces, over their root mean square, and random headings."""
    dice = np.random.default_rng([part.seed, START])
    count = len(state.position)
    heading = dice.uniform(0.0, 2.0 * math.pi, count)
    return state._replace(active=np.column_stack([dice.normal(size=(count, 2)), heading]))


@compiled
def active_force(part: Activity, own: ActivityScratch, i: int) -> tuple[float, float]:
    """The force on one float (N)."""
    heading = own.active[i, 2]
    if own.turning.shape[1] > 0:
        heading += own.turning[i, 0]
    x = part.force[i] * own.active[i, 0] + part.propulsion[i] * math.cos(heading)
    return x, part.force[i] * own.active[i, 1] + part.propulsion[i] * math.sin(heading)


@compiled
def activity_forces(
    part: Activity, own: ActivityScratch, parameters: Parameters, position: Array, lists: NeighborLists, force: Array
) -> None:
    """Add the active forces."""
    for i in range(len(force)):
        x, y = active_force(part, own, i)
        force[i, 0] += x
        force[i, 1] += y


@compiled
def renew_activity(part: Activity, own: ActivityScratch, parameters: Parameters, state: State, first: bool) -> None:
    """Advance random forces and headings by one time step, before it; the forces at its end are the new ones."""
    if not first:
        return
    time, step = parameters.time_step, int(state.step[0])
    kept = math.exp(-time / part.persistence)
    fresh = math.sqrt(1.0 - kept * kept)
    for i in range(len(part.force)):
        own.before[i, 0], own.before[i, 1] = active_force(part, own, i)
        along, across = normals(counter_of(i, step, FORCES), part.seed)
        own.active[i, 0] = kept * own.active[i, 0] + fresh * along
        own.active[i, 1] = kept * own.active[i, 1] + fresh * across
        turned = normals(counter_of(i, step, HEADINGS), part.seed)[0]
        own.active[i, 2] += part.turning[i] * time + math.sqrt(2.0 * part.diffusion[i] * time) * turned


@compiled
def add_work_of_activity(
    part: Activity, own: ActivityScratch, parameters: Parameters, state: State, workspace: Workspace
) -> None:
    """Add the work of the active forces in a step, by the mean of those at its beginning and end (J)."""
    midstep_velocity, power = workspace.midstep_velocity, 0.0
    for i in range(len(part.force)):
        x, y = active_force(part, own, i)
        power += 0.5 * (own.before[i, 0] + x) * midstep_velocity[i, 0]
        power += 0.5 * (own.before[i, 1] + y) * midstep_velocity[i, 1]
    state.tally[WORK] += power * parameters.time_step


def no_activity_energy(
    part: Activity, own: ActivityScratch, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """Return zero: active forces have no potential."""
    return 0.0, 0.0


def activity_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return the activity of a scene."""
    given, floats = scene.activity, parameters.floats
    assert given is not None  # noqa: S101  # for the type checker: the scene has chosen it
    names = [name for name, *_ in scene.kinds]
    if unknown := [name for name in given.species if name not in names]:
        raise scene_error("activity.species", f"got {unknown[0]!r}; expected names among {', '.join(map(repr, names))}")
    active = np.array([not given.species or names[number] in given.species for number in floats.species], np.float64)
    thermal = parameters.drift.thermal
    friction = turning_frictions(scene) if given.torque or thermal > 0.0 else np.ones(len(active))
    spread = np.array([diffusion.diffusivity(thermal, each) for each in friction])
    part = Activity(
        given.force * active / math.sqrt(2.0), given.persistence or 1.0, given.propulsion * active,
        given.rotational_diffusion + spread, given.torque * active / friction, scene.seed,
    )  # fmt: skip
    rates = [1.0 / part.persistence if given.force else 0.0, float(part.diffusion.max())]
    rates.append(float(np.abs(part.turning).max()))
    speed = float(np.max((DEVIATIONS * part.force + part.propulsion) * floats.relaxation_time / floats.mass))
    # A step moves a float by a tenth of the skin at most.
    rates.append(0.5 * parameters.collective * speed / parameters.skin)
    return Built(part, quickest=min(1.0 / rate if rate > 0.0 else math.inf for rate in rates))
