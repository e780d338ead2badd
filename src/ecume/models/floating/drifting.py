"""What a scene says of flow and of chance."""

from __future__ import annotations

import math

import numpy as np

from ecume.laws import brownian
from ecume.models.floating.parameters import DRAG_LAWS, Drift, Sway
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import FloatingScene, NodesSpec
from ecume.units import Array


def drift_of(scene: FloatingScene) -> Drift:
    """The flow and the chance that a scene asks for; both need drag."""
    flow, liquid = scene.flow, liquid_of(scene)
    fast = scene.hydrodynamics.drag == DRAG_LAWS[1]
    rates = np.zeros(6)
    if flow is not None:
        turning, apart = flow.rotation_rate, flow.extension_rate
        rates = np.array([*flow.velocity, apart, flow.shear_rate - turning, turning, -apart])
    nodes, frame = _nodes_of(flow.nodes) if flow is not None and flow.nodes is not None else NO_NODES
    slowing = liquid.density / liquid.viscosity if fast else 0.0
    thermal = brownian.thermal_energy(scene.liquid.temperature) if scene.hydrodynamics.brownian else 0.0
    flows = bool(np.any(rates)) or bool(np.any(nodes))
    return Drift(rates, nodes, frame, flows, thermal, scene.seed, slowing, 0.0, sway_of(scene))


def sway_of(scene: FloatingScene) -> Sway:
    """How the dish is moved."""
    moved = scene.dish.motion if scene.dish is not None else None
    if moved is None:
        return Sway(False, np.zeros(2), np.zeros(2), 0.0, 0.0)
    heading = np.array([math.cos(moved.direction), math.sin(moved.direction)])
    turning = 2.0 * math.pi * moved.frequency
    return Sway(True, np.array(moved.velocity), moved.amplitude * heading, turning, 1.0 - moved.entrainment)


NO_NODES = np.zeros((2, 0, 0)), np.zeros(4)


def _nodes_of(nodes: NodesSpec) -> tuple[Array, Array]:
    """A table's velocities, and where they stand."""
    table, low, high = np.array([nodes.vx, nodes.vy]), np.array(nodes.low), np.array(nodes.high)
    return table, np.concatenate([low, (np.array(table.shape[1:]) - 1.0) / (high - low)])
