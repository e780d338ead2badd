"""What a scene says of flow and of chance."""

from __future__ import annotations

import math

import numpy as np

from ecume.errors import Fault, SceneError
from ecume.laws import brownian
from ecume.models.floating.parameters import DRAG_LAWS, OVERDAMPED, RARE, SCHEMES, Drift, Sway
from ecume.scenes.floating import FloatingScene, NodesSpec
from ecume.units import Array

FAST = ("velocity-verlet", "semi-implicit-euler", "explicit-euler")
"""Integrators whose kick knows a drag that grows with the speed."""


def drift_of(scene: FloatingScene) -> Drift:
    """The flow and the chance that a scene asks for; both need drag."""
    flow, motion = scene.liquid.flow, scene.motion
    slow = motion.integrator == SCHEMES[OVERDAMPED]
    fast = motion.drag_law == DRAG_LAWS[1]
    needy = [
        ("motion.drag_law", fast, "'schiller-naumann'"),
        ("motion.integrator", slow, "'overdamped'"),
        ("liquid.flow", flow is not None, "a flowing surface"),
    ]
    faults = [
        Fault(path, f"{what} moves floats by drag; it needs motion.drag = true and a liquid.viscosity above zero")
        for path, asked, what in needy
        if asked and (not motion.drag or scene.liquid.viscosity == 0.0)
    ]
    if motion.temperature > 0.0 and not slow:
        faults.append(Fault("motion.temperature", "Brownian motion needs motion.integrator = 'overdamped'"))
    if fast and motion.integrator not in FAST:
        faults.append(Fault("motion.drag_law", f"'schiller-naumann' goes with the integrators {', '.join(FAST)}"))
    faults += _of_the_dish(scene)
    if faults:
        raise SceneError(faults)
    rates = np.zeros(6)
    if flow is not None:
        turning, apart = flow.rotation, flow.stretching
        rates = np.array([*flow.velocity, apart, flow.shear - turning, turning, -apart])
    nodes, frame = _nodes_of(flow.nodes) if flow is not None and flow.nodes is not None else NO_NODES
    slowing = scene.liquid.density / scene.liquid.viscosity if fast else 0.0
    thermal = brownian.thermal_energy(motion.temperature)
    flows = bool(np.any(rates)) or bool(np.any(nodes))
    return Drift(rates, nodes, frame, flows, thermal, scene.seed, slowing, 0.0, sway_of(scene))


def sway_of(scene: FloatingScene) -> Sway:
    """How the dish is moved."""
    moved = scene.dish.motion if scene.dish is not None else None
    if moved is None:
        return Sway(False, np.zeros(2), np.zeros(2), 0.0, 0.0)
    heading = np.array([math.cos(moved.direction), math.sin(moved.direction)])
    turning = 2.0 * math.pi * moved.frequency
    return Sway(True, np.array(moved.velocity), moved.amplitude * heading, turning, 1.0 - moved.carried)


def _of_the_dish(scene: FloatingScene) -> list[Fault]:
    """What does not go with a dish in motion."""
    if scene.dish is None or scene.dish.motion is None:
        return []
    motion = scene.motion
    against = [
        (
            "motion.integrator",
            motion.integrator in [SCHEMES[rare] for rare in RARE],
            "Verlet's velocity form or Euler's",
        ),
        ("motion.drag_law", motion.drag_law != DRAG_LAWS[0], "'stokes'"),
        ("motion.films", motion.films is not None, "no films"),
        ("floats", scene.shaped, "round floats"),
    ]
    return [
        Fault(path, f"a dish in motion (dish.motion) goes with {wanted}") for path, there, wanted in against if there
    ]


NO_NODES = np.zeros((2, 0, 0)), np.zeros(4)


def _nodes_of(nodes: NodesSpec) -> tuple[Array, Array]:
    """A table's velocities, and where they stand."""
    table, low, high = np.array([nodes.vx, nodes.vy]), np.array(nodes.low), np.array(nodes.high)
    return table, np.concatenate([low, (np.array(table.shape[1:]) - 1.0) / (high - low)])
