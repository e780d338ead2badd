"""Flow of the surface, thermal noise and motion of the dish: their constants, and the drag of the flow."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from ecume._jit import by_type, compiled, compiled_inside, selected
from ecume.errors import BadInput
from ecume.laws import brownian_motion
from ecume.models.field_files import grid_of
from ecume.models.floating.options import scene_error
from ecume.models.floating.parameters import (
    DRAG_LAWS,
    ClockedScratch,
    Drift,
    Parameters,
    Scratch,
    Sway,
    VaryingDrift,
)
from ecume.models.gridded_flows import GRIDDED_VELOCITIES, fitted, velocities_at_nodes
from ecume.models.liquids import inertia_over_viscosity, liquid_of
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.fields import FieldSpec
    from ecume.scenes.floating import FloatingScene, NodesSpec


def _driven(scene: FloatingScene) -> bool:
    """Whether forces without a potential act: active forces, waves, a magnetic field, a surfactant or a barrier."""
    barrier = scene.dish.barrier if scene.dish is not None else None
    driven = scene.activity, scene.waves, scene.magnetic_field, scene.surfactant, barrier
    return any(each is not None for each in driven)


def drift_of(scene: FloatingScene) -> Drift:
    """The flow and the noise of a scene; both need drag."""
    flow, liquid = scene.flow, liquid_of(scene)
    fast = scene.drag == DRAG_LAWS[1]
    rates = np.zeros(6)
    if flow is not None:
        turning, apart = flow.rotation_rate, flow.extension_rate
        rates = np.array([*flow.velocity, apart, flow.shear_rate - turning, turning, -apart])
    nodes, frame = _nodes_of(flow.nodes) if flow is not None and flow.nodes is not None else NO_NODES
    slowing = inertia_over_viscosity(liquid) if fast else 0.0
    thermal = brownian_motion.thermal_energy(scene.liquid.temperature) if scene.hydrodynamics.brownian else 0.0
    flows = bool(np.any(rates)) or bool(np.any(nodes))
    drift = Drift(rates, nodes, frame, flows, thermal, scene.seed, slowing, 0.0, sway_of(scene), _driven(scene))
    if flow is None or flow.field is None:
        return drift
    # One zero node instead of none, since compiled code first tests whether there are nodes.
    varying = VaryingDrift(*drift._replace(nodes=np.zeros((2, 2, 2)), flows=True), _table_of(flow.field))
    return cast(Drift, varying)


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


def _table_of(field: FieldSpec) -> Any:
    """The velocities of a file, in the form that tracers use; y here corresponds to their height. Raises SceneError."""
    try:
        return fitted(grid_of(field, 2), field.interpolation).shape
    except BadInput as error:
        key = error.args[1] if len(error.args) > 1 else "file"
        raise scene_error(f"flow.field.{key}", str(error.args[0])) from error


def fastest_at_nodes(drift: Drift) -> float:
    """The largest speed at the nodes of a table or a file (m/s)."""
    table = getattr(drift, "table", None)
    along, across = (drift.nodes[0], drift.nodes[1]) if table is None else velocities_at_nodes(table)
    return float(np.hypot(along, across).max(initial=0.0))


def shortest_change(drift: Drift) -> float:
    """The shortest interval between two instants of a file (s)."""
    table = getattr(drift, "table", None)
    return math.inf if table is None else float(np.diff(table.times).min(initial=math.inf))


@compiled_inside
def straight_current(flow: Array, x: float, y: float) -> tuple[float, float]:
    """The velocity (m/s) of a flow that is uniform or linear in the position."""
    return flow[0] + flow[2] * x + flow[3] * y, flow[1] + flow[4] * x + flow[5] * y


gridded_velocity = by_type(GRIDDED_VELOCITIES.__getitem__, 0)


@compiled
def steady_current(drift: Drift, time: float, x: float, y: float) -> tuple[float, float]:
    """The velocity (m/s) of a surface with a steady flow."""
    along, across = straight_current(drift.flow, x, y)
    if drift.nodes.shape[1] > 0:
        more_along, more_across = between_nodes(drift, x, y)
        along, across = along + more_along, across + more_across
    return along, across


@compiled
def varying_current(drift: VaryingDrift, time: float, x: float, y: float) -> tuple[float, float]:
    """The velocity (m/s) of a surface with a flow from a file."""
    along, across = straight_current(drift.flow, x, y)
    more_along, _, more_across = gridded_velocity(drift.table, x, 0.0, y, time)
    return along + more_along, across + more_across


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
def set_time(scratches: ClockedScratch, time: float) -> None:
    """Set the clock."""
    scratches.clock[0] = time


@compiled
def time_now(scratches: ClockedScratch) -> float:
    """The time of the clock (s)."""
    now: float = scratches.clock[0]
    return now


class Timing(NamedTuple):
    """The functions of drift and workspaces, with and without a clock, selected by type."""

    current: Any = None
    """current(drift, time, x, y): the velocity of the surface (m/s)"""
    set_clock: Any = None
    """set_clock(scratches, time)"""
    clock: Any = None
    """clock(scratches): s"""
    varies: bool = False
    """whether the flow depends on time"""


TIMING: dict[type, Timing] = {
    Drift: Timing(current=steady_current),
    VaryingDrift: Timing(current=varying_current, varies=True),
    Scratch: Timing(),
    ClockedScratch: Timing(set_clock=set_time, clock=time_now),
}
current_at = selected(TIMING, "current")
set_clock = selected(TIMING, "set_clock")
clock = selected(TIMING, "clock", 0)


def varies(drift: Drift) -> bool:
    """Whether the flow of the surface depends on time."""
    return TIMING[type(drift)].varies


@compiled
def add_flow(parameters: Parameters, time: float, position: Array, force: Array) -> None:
    """Add the drag of the flowing surface: zeta u, where u is its velocity at the center of the float."""
    mass, relaxation = parameters.floats.mass, parameters.floats.relaxation_time
    for i in range(position.shape[0]):
        friction = mass[i] / relaxation[i]
        along, across = current_at(parameters.drift, time, position[i, 0], position[i, 1])
        force[i, 0] += friction * along
        force[i, 1] += friction * across
