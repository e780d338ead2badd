"""Terminal speeds, the way to them, diffusion, and the equilibrium of both."""

from __future__ import annotations

import math

import numpy as np

from ecume.laws import brownian, drag
from ecume.scenes.schema import Scene
from ecume.scenes.tracers import (
    ParticleSpec,
    TankSpec,
    TracerHydrodynamicsSpec,
    TracerIntegrationSpec,
    TracersScene,
)
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.validation.rows import Row, within
from ecume.validation.runner import case_scene

SPEEDS = {
    20: (3.2700e-4, 3.254636e-4),
    50: (2.04375e-3, 1.982957e-3),
    100: (8.175e-3, 7.294103e-3),
    200: (3.27e-2, 2.291683e-2),
}
"""Diameter (um): terminal speed by Stokes, and by Schiller and Naumann, m/s."""
GRAINS = 4000
GRAIN = 0.5e-6
"""Radius of what diffuses, m."""
FRICTION = drag.stokes_friction(GRAIN, 1e-3, 1.0)
THERMAL = brownian.thermal_energy(293.15)


def rows() -> list[Row]:
    """Compare all subjects."""
    return [*terminal_speeds(), *from_rest(), *diffusion(), *equilibrium()]


def _last(scene: Scene) -> Frame:
    *_, frame = simulate(scene)
    return frame


def terminal_speeds() -> list[Row]:
    """Compare the terminal speeds of four grains under two laws."""
    found = []
    for diameter, expected in SPEEDS.items():
        for law, speed in zip(("stokes", "schiller-naumann"), expected, strict=True):
            scene = case_scene("settling", [f"particles[0].radius={diameter / 2} um", f"hydrodynamics.drag={law}"])
            computed = -float(_last(scene).arrays["velocity"][0, 1])
            found.append(within(f"quartz of {diameter} um, {law}: terminal speed (m/s)", computed, speed, 1e-6 * speed))
    return found


def from_rest() -> list[Row]:
    """The height after one, two and three relaxation times."""
    scene = case_scene("settling", ["hydrodynamics.drag=stokes"])
    speed = drag.stokes_settling_speed(1e-4, 1500.0, 1e-3, 9.81)
    tau = 4.0 / 3.0 * math.pi * 1e-12 * 3000.0 / drag.stokes_friction(1e-4, 1e-3, 1.0)
    scene = case_scene("settling", ["hydrodynamics.drag=stokes", f"duration={3 * tau!r}", f"frame_every={tau!r}"])
    found = []
    for frame in list(simulate(scene))[1:]:
        fallen = speed * (frame.time - tau * -math.expm1(-frame.time / tau))
        computed = -float(frame.arrays["position"][0, 1])
        name = f"from rest, after {frame.time / tau:.0f} relaxation times: fallen (m)"
        found.append(within(name, computed, fallen, 1e-12 * fallen))
    return found


def diffusion() -> list[Row]:
    """The mean square displacement along an axis, over 2 D t."""
    tau = 4.0 / 3.0 * math.pi * GRAIN**3 * 2500.0 / FRICTION
    found = []
    for regime, steps in (("inertial", 4.0), ("overdamped", 0.1)):
        grains = ParticleSpec(radius=GRAIN, density=2000.0, positions=((0.0, 0.0, 0.0),) * GRAINS)
        forces = TracerHydrodynamicsSpec(drag="stokes", brownian=True)
        integration = TracerIntegrationSpec(integrator=regime, time_step=tau / steps)
        scene = TracersScene(
            duration=100 * tau,
            frame_every=50 * tau,
            gravity=0.0,
            particles=(grains,),
            hydrodynamics=forces,
            integration=integration,
            seed=2,
        )
        frame = _last(scene)
        late = 1.5 * tau if regime == "inertial" else 0.0
        exact = 2.0 * brownian.diffusivity(THERMAL, FRICTION) * (frame.time - late)
        computed = float((frame.arrays["position"] ** 2).mean()) / exact
        found.append(within(f"{regime}: <x^2> / 2 D t", computed, 1.0, 4.0 * math.sqrt(2.0 / (3 * GRAINS))))
    return found


def equilibrium() -> list[Row]:
    """Grains that sink and diffuse in a tank three layers high."""
    weight = 4.0 / 3.0 * math.pi * GRAIN**3 * 100.0 * 9.81
    layer = brownian.sedimentation_length(THERMAL, weight)
    tall = 3.0 * layer
    settled = tall**2 / brownian.diffusivity(THERMAL, FRICTION)
    scene = TracersScene(
        duration=3 * settled,
        frame_every=settled,
        particles=(ParticleSpec(radius=GRAIN, density=1100.0, count=GRAINS),),
        tank=TankSpec(high=(tall, tall + 2 * GRAIN)),
        hydrodynamics=TracerHydrodynamicsSpec(brownian=True),
        seed=3,
    )
    height = (_last(scene).arrays["position"][:, 1] - GRAIN) / layer
    mean = 1.0 - 3.0 / math.expm1(3.0)
    spread = math.sqrt(1.0 - 9.0 * math.exp(3.0) / math.expm1(3.0) ** 2)
    share = math.expm1(-0.3) / math.expm1(-3.0)
    wide = 4.0 * math.sqrt(share * (1.0 - share) / GRAINS)
    low = float(np.mean(height < 0.3))
    return [
        within("equilibrium: mean height over kT/W", float(height.mean()), mean, 4.0 * spread / math.sqrt(GRAINS)),
        within("equilibrium: part in the lowest tenth", low, share, wide),
    ]
