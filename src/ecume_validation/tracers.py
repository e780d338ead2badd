"""Tracers between walls and in a liquid: the cases `reflection` and `settling`."""

from __future__ import annotations

import math

import numpy as np

from ecume.engine import walls
from ecume.engine.walls import Surfaces
from ecume.laws import brownian_motion, drag
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
from ecume.units import Array
from ecume_validation.runner import Row, below, case_scene, within

WEDGES = (90, 60, 45, 30, 10, 7)
RESTITUTIONS = (0.5, 0.8, 0.9)
KEEPS_SCENE_ORDER = 100_000
ROUNDS = 17
"""Steps of each system; with six systems about ten million particle steps."""
FALL = (0.0, -9.81)


def reflection_rows() -> list[Row]:
    """Compare billiards, a bouncing ball, wedges, a circle, reversibility and containment."""
    return [*billiards(), *bouncing(), *wedges(), *circle(), *reversal(), *nobody_outside()]


def folded(way: Array, width: Array) -> Array:
    """A straight path, folded into [0, width]."""
    inside = np.mod(way, 2.0 * width)
    return np.where(inside > width, 2.0 * width - inside, inside)


def billiards() -> list[Row]:
    """Compare billiards in 2D and 3D, without and with gravity."""
    sides, start = np.array([1.0, 0.7, 0.4]), np.array([[0.3, 0.2, 0.1]])
    speed = np.array([[1.234567, 0.87654321, -0.7654321]])
    found = []
    for d in (2, 3):
        room = walls.box([0.0] * d, sides[:d].tolist())
        position, _, hits = walls.reflect(start[:, :d], speed[:, :d], 1000.0, room)
        off = float(np.abs(position - folded(start[:, :d] + 1000.0 * speed[:, :d], sides[:d])).max())
        found.append(below(f"billiard in {d}D, {hits[0]} bounces: error of the position (m)", off, 1e-9))
    room, begin = walls.box((0.0, 0.0), (1.0, 9.0)), np.array([[0.3, 0.5]])
    position, velocity, hits = walls.reflect(begin, [[1.1, 0.0]], 1000.0, room, acceleration=FALL)
    energy = 0.5 * float((velocity**2).sum()) + 9.81 * float(position[0, 1]) - 0.5 * 1.21 - 9.81 * 0.5
    found.append(below(f"gravity billiard, {hits[0]} bounces: change of energy (J/kg)", abs(energy), 1e-10))
    _, velocity, _ = walls.reflect([[0.5, 0.5]], [[0.3, -2.0]], 0.3, walls.planes([(0, 0)], [(0, 1)]), 0.6, 0.9)
    lost = 0.5 * (0.09 + 4.0) - 0.5 * float((velocity**2).sum())
    expected = 0.5 * (1.0 - 0.36) * 4.0 + 0.5 * (1.0 - 0.81) * 0.09
    return [*found, within("energy of one hit, C_R = 0.6, C_T = 0.9 (J/kg)", lost, expected, 1e-15)]


def bouncing() -> list[Row]:
    """Compare the times of a ball dropped from 1 m."""
    floor, found = walls.planes([(0.0, 0.0)], [(0.0, 1.0)]), []
    first = math.sqrt(2.0 / 9.81)
    for e in RESTITUTIONS:
        traced = walls.trace([(0.0, 1.0)], [(0.0, 0.0)], 10.0, floor, e, acceleration=FALL)
        exact = first * (1.0 + 2.0 * np.cumsum(e ** np.arange(1.0, 20.0)))
        off = float(np.abs(traced.time[1:20] - exact).max())
        found.append(below(f"bouncing ball, e = {e:g}: error of the first 20 hits (s)", off, 1e-12))
        whole = first * (1.0 + e) / (1.0 - e)
        found.append(within(f"bouncing ball, e = {e:g}: at rest after (s)", float(traced.time[-1]), whole, 1e-5))
    return found


def wedges() -> list[Row]:
    """Compare the largest number of bounces of 3000 random paths."""
    found = []
    for degrees in WEDGES:
        rng, angle = np.random.default_rng(degrees), math.radians(degrees)
        place, way = rng.uniform(-0.5, 0.5, 3000) * angle, rng.uniform(0.0, 2.0 * math.pi, 3000)
        start, speed = (np.column_stack([np.cos(turn), np.sin(turn)]) for turn in (place, way))
        _, _, hits = walls.reflect(start, speed, 100.0, walls.wedge((0.0, 0.0), (1.0, 0.0), angle))
        found.append(
            within(f"wedge of {degrees} degrees: most bounces", int(hits.max()), math.ceil(180 / degrees), 0.0)
        )
    return found


def circle() -> list[Row]:
    """Compare a thousand chords of a circle, and chords that become shorter."""
    traced = walls.trace([(0.3, 0.1)], [(0.7, 0.6)], 3000.0, walls.disc((0.0, 0.0), 1.0))
    spin = 0.3 * 0.6 - 0.1 * 0.7
    angle = np.arctan2(traced.place[:, 1], traced.place[:, 0])
    exact = angle[0] + 2.0 * math.acos(spin / math.hypot(0.7, 0.6)) * np.arange(len(angle))
    off = float(np.abs(np.mod(angle - exact + math.pi, 2.0 * math.pi) - math.pi).max())
    x, v = traced.position[0], traced.velocity[0]
    kept = abs(float(x[0] * v[1] - x[1] * v[0]) - spin)
    slow = walls.trace([(0.3, 0.1)], [(0.7, 0.6)], 300.0, walls.disc((0.0, 0.0), 1.0), 0.7)
    chords = np.linalg.norm(np.diff(slow.place, axis=0), axis=1)
    out = slow.place[0]
    normal = 0.7 * float(np.array([0.7, 0.6]) @ out) * 0.7 ** np.arange(len(chords))
    along = spin
    expected = 2.0 * np.cos(np.arctan2(along, normal))
    short = float(np.abs(chords - expected).max())
    return [
        below(f"circle, {len(angle)} chords: error of the angle (rad)", off, 1e-9),
        below("circle: change of the angular momentum (m^2/s)", kept, 1e-12),
        below(f"circle, e = 0.7: error of {len(chords)} chords (m)", short, 1e-9),
    ]


def reversal() -> list[Row]:
    """Compare a path and its reversal in a heptagon under gravity."""
    rng = np.random.default_rng(5)
    heptagon = walls.polygon([(math.cos(a), math.sin(a)) for a in 2.0 * math.pi * np.arange(7) / 7])
    start, speed = rng.uniform(-0.5, 0.5, (1000, 2)), rng.normal(size=(1000, 2))
    there, back, _ = walls.reflect(start, speed, 3.0, heptagon, acceleration=(0.0, -1.0))
    again, _, _ = walls.reflect(there, -back, 3.0, heptagon, acceleration=(0.0, -1.0))
    return [below("flown backwards: largest distance from the start (m)", float(np.abs(again - start).max()), 1e-8)]


def nobody_outside() -> list[Row]:
    """Compare the smallest clearance of many particles in three tanks, with and without restitution."""
    heptagon = walls.polygon([(math.cos(a), math.sin(a)) for a in 2.0 * math.pi * np.arange(7) / 7])
    obstacle = walls.outside(walls.polygon([(-0.3, -0.3), (0.4, -0.2), (0.0, 0.3)]))
    tanks = {
        "cluttered heptagon": walls.together(heptagon, obstacle),
        "box in 3D": walls.box((-0.7, -0.7, -0.7), (0.7, 0.7, 0.7)),
        "circle": walls.disc((0.0, 0.0), 1.0),
    }
    found = []
    for name, tank in tanks.items():
        for e in (0.0, 0.9):
            worst = max(0.0, -crowded(tank, e))
            found.append(below(f"{name}, C_R = {e:g}: farthest outside ever (m)", worst, 1e-15))
    return found


def crowded(tank: Surfaces, restitution: float) -> float:
    """The smallest clearance of many particles that are agitated and fall."""
    rng, d = np.random.default_rng(11), tank.dimension
    candidates = rng.uniform(-0.69, 0.69, (2 * KEEPS_SCENE_ORDER, d))
    position = candidates[walls.clearance(candidates, tank)[0] > 0.0][:KEEPS_SCENE_ORDER]
    velocity, fall, least = np.zeros_like(position), (*(0.3,) * (d - 1), -3.0), math.inf
    for _ in range(ROUNDS):
        velocity = velocity + rng.normal(size=velocity.shape)
        position, velocity, _ = walls.reflect(position, velocity, 0.3, tank, restitution, acceleration=fall)
        least = min(least, float(walls.clearance(position, tank)[0].min()))
    return least


SPEEDS = {
    20: (3.2700e-4, 3.254636e-4),
    50: (2.04375e-3, 1.982957e-3),
    100: (8.175e-3, 7.294103e-3),
    200: (3.27e-2, 2.291683e-2),
}
"""Diameter (um): terminal speeds by Stokes, and by Schiller and Naumann, m/s."""
GRAINS = 4000
GRAIN = 0.5e-6
"""The radius of diffusing particles, m."""
FRICTION = drag.stokes_friction(GRAIN, 1e-3, 1.0)
THERMAL = brownian_motion.thermal_energy(293.15)


def settling_rows() -> list[Row]:
    """Compare terminal speeds, relaxation, diffusion and equilibrium."""
    return [*terminal_speeds(), *from_rest(), *spreading(), *equilibrium()]


def _last(scene: Scene) -> Frame:
    *_, frame = simulate(scene)
    return frame


def terminal_speeds() -> list[Row]:
    """Compare the terminal speeds of four particles under two drag laws."""
    found = []
    for diameter, expected in SPEEDS.items():
        for law, speed in zip(("stokes", "schiller-naumann"), expected, strict=True):
            scene = case_scene("settling", [f"particles[0].radius={diameter / 2} um", f"hydrodynamics.drag={law}"])
            computed = -float(_last(scene).arrays["velocity"][0, 1])
            found.append(within(f"quartz of {diameter} um, {law}: terminal speed (m/s)", computed, speed, 1e-6 * speed))
    return found


def from_rest() -> list[Row]:
    """Compare the height after one, two and three relaxation times."""
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


def spreading() -> list[Row]:
    """Compare the mean square displacement along an axis with 2 D t."""
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
        exact = 2.0 * brownian_motion.diffusivity(THERMAL, FRICTION) * (frame.time - late)
        computed = float((frame.arrays["position"] ** 2).mean()) / exact
        found.append(within(f"{regime}: <x^2> / 2 D t", computed, 1.0, 4.0 * math.sqrt(2.0 / (3 * GRAINS))))
    return found


def equilibrium() -> list[Row]:
    """Compare the profile of particles that settle and diffuse in a tank of three sedimentation lengths."""
    weight = 4.0 / 3.0 * math.pi * GRAIN**3 * 100.0 * 9.81
    layer = brownian_motion.sedimentation_length(THERMAL, weight)
    tall = 3.0 * layer
    settled = tall**2 / brownian_motion.diffusivity(THERMAL, FRICTION)
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
