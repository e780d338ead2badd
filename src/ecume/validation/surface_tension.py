"""Drops in 2D: a square that becomes round, oscillating and resting discs, with both models of surface tension."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ecume.laws.flows import drop_decay, drop_period
from ecume.laws.tension import laplace_pressure
from ecume.scenes.load import load_scene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.validation.drops import axes_of_liquid, longest_rise, swing_of
from ecume.validation.rows import Row, below, within
from ecume.validation.runner import frames_of

WIDE = "fluid[0].velocity_gradient=[[0.5, 0.0], [0.0, -0.5]]"
SMALL = "fluid[0].velocity_gradient=[[0.1, 0.0], [0.0, -0.1]]"
COHESION = "method.surface_tension_model=cohesion"
VISCOSITY = 0.02
ROUND = np.sqrt(4.0 / np.pi)
"""Radius of a disc as large as a square of half the side 1."""


def rows() -> list[Row]:
    """Compare all subjects."""
    return [*square(), *small(), *fading(), *resting(), *wide()]


def drop_frames(*changes: str) -> list[Frame]:
    """The frames of the scene with these changes."""
    return list(frames_of("surface_tension", changes))


def square() -> list[Row]:
    """The corners are drawn in."""
    template = Path(__file__).parents[1] / "templates" / "rounding-drop.toml"
    frames = list(simulate(load_scene(template, [])))
    place = frames[-1].arrays["position"]
    half = float(np.ptp(frames[0].arrays["position"][:, 0]) / 2.0 + 0.5e-4)
    farthest = float(np.linalg.norm(place - place.mean(axis=0), axis=1).max()) / half
    mass = float(frames[-1].arrays["mass"].sum())
    drift = abs(frames[-1].numbers["momentum_x"]) / mass / frames[-1].numbers["largest_speed"]
    return [
        within("square: farthest particle over half the side", farthest, ROUND, 0.05 * ROUND),
        within("square: logarithm of the ratio of the axes", axes_of_liquid(frames[-1]), 0.0, 0.03),
        below("square: mean velocity over the largest", drift, 1e-9),
        below("square: rise of the total energy over that of the surface", longest_rise(frames), 1e-6),
    ]


def small() -> list[Row]:
    """A small swing, at two resolutions."""
    found, exact = [], drop_period(1.0, 1.0, 2, 2)
    for count in (10, 14):
        frames = drop_frames(SMALL, f"spacing={1.0 / count}", "duration=3 s")
        name = f"disc of {count} spacings: period of a small swing"
        found.append(within(name, swing_of(frames).period, exact, 0.04 * exact))
        found.append(below(f"disc of {count} spacings: rise of the total energy", longest_rise(frames), 1e-6))
    return found


def fading() -> list[Row]:
    """A small swing in a viscous liquid."""
    exact = drop_decay(1.0, VISCOSITY, 1.0, 2, 2)
    swing = swing_of(drop_frames(SMALL, f"liquid.viscosity={VISCOSITY}"))
    return [
        within("disc: frequency in a viscous liquid", swing.frequency, exact.frequency, 0.04 * exact.frequency),
        within("disc: decay in a viscous liquid", swing.rate, exact.rate, 0.3 * exact.rate),
    ]


def resting() -> list[Row]:
    """The pressure inside, and what still moves."""
    frames = drop_frames("duration=6 s", "frame_every=0.1 s")
    late = frames[len(frames) // 2 :]
    pressure = float(np.mean([pressure_inside(frame) for frame in late]))
    restless = [frame.numbers["kinetic_energy"] / frame.numbers["surface_energy"] for frame in late]
    half = len(restless) // 2
    return [
        within("disc at rest: pressure over sigma/R", pressure / laplace_pressure(1.0, 1.0, 2), 1.0, 0.06),
        below("disc at rest: energy of the motion over that of the surface", max(restless), 2e-3),
        below("disc at rest: the same, later over earlier", max(restless[half:]) / max(restless[:half]), 1.0),
    ]


def pressure_inside(frame: Frame) -> float:
    """The mean of the inner half."""
    inner = np.linalg.norm(frame.arrays["position"], axis=1) < 0.5
    return float(frame.arrays["pressure"][inner].mean())


def wide() -> list[Row]:
    """Wide swings, in which particles change places, by both models."""
    found, exact = [], drop_period(1.0, 1.0, 2, 2)
    for name, changes in (("csf", [WIDE]), ("cohesion", [WIDE, COHESION])):
        frames = drop_frames(*changes)
        late = [frame for frame in frames if frame.time > 0.5]
        found.append(within(f"{name}, disc: period of a wide swing", swing_of(late).period, exact, 0.06 * exact))
        found.append(below(f"{name}, disc: rise of the total energy", longest_rise(frames), 1e-2))
    return found
