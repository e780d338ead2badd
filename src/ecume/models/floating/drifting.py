"""What a scene says of flow and of chance."""

from __future__ import annotations

import numpy as np

from ecume.errors import Fault, SceneError
from ecume.laws import brownian
from ecume.models.floating.parameters import DRAG_LAWS, OVERDAMPED, SCHEMES, Drift
from ecume.scenes.floating import FloatingScene

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
    if faults:
        raise SceneError(faults)
    rates = np.zeros(6)
    if flow is not None:
        turning, apart = flow.rotation, flow.stretching
        rates = np.array([*flow.velocity, apart, flow.shear - turning, turning, -apart])
    slowing = scene.liquid.density / scene.liquid.viscosity if fast else 0.0
    thermal = brownian.thermal_energy(motion.temperature)
    return Drift(rates, bool(np.any(rates)), thermal, scene.seed, slowing, 0.0)
