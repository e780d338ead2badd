"""A square that rounds off, a disc that swings, the pressure inside: both models of surface tension in a plane."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.optimize import curve_fit

from ecume.laws.tension import drop_period, laplace_pressure
from ecume.scenes.load import load_scene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume.validation.rows import Row, below, within

SCENE = Path(__file__).with_name("scene.toml")
SWING = "fluid[0].velocity_gradient=[[0.5, 0.0], [0.0, -0.5]]"
CSF = ("method.surface_tension_model=csf", "method.artificial_viscosity=0.1")
ROUND = np.sqrt(4.0 / np.pi)
"""Radius of a disc as large as a square of half the side 1."""


def rows() -> list[Row]:
    """All subjects."""
    return [*square(), *swinging(), *pressed(), *fed()]


def frames_of(*changes: str) -> list[Frame]:
    """The run of the scene with these changes."""
    return list(simulate(load_scene(SCENE, list(changes))))


def axes(frame: Frame) -> float:
    """The logarithm of the ratio of the axes."""
    wide, high = frame.arrays["position"].std(axis=0)
    return float(np.log(wide / high))


def square() -> list[Row]:
    """The corners are drawn in."""
    template = Path(__file__).parents[2] / "templates" / "rounding-drop.toml"
    frames = list(simulate(load_scene(template, [])))
    place = frames[-1].arrays["position"]
    half = float(np.ptp(frames[0].arrays["position"][:, 0]) / 2.0 + 0.5e-4)
    farthest = float(np.linalg.norm(place - place.mean(axis=0), axis=1).max()) / half
    mass = float(frames[-1].arrays["mass"].sum())
    drift = abs(frames[-1].numbers["momentum_x"]) / mass / frames[-1].numbers["largest_speed"]
    return [
        within("cohesion, square: farthest particle over half the side", farthest, ROUND, 0.05 * ROUND),
        within("cohesion, square: logarithm of the ratio of the axes", axes(frames[-1]), 0.0, 0.03),
        below("cohesion, square: mean velocity over the largest", drift, 1e-9),
    ]


def swing_of(frames: list[Frame]) -> tuple[float, float]:
    """The period, and the rate at which the swing dies."""
    time, ratio = np.array([f.time for f in frames]), np.array([axes(f) for f in frames])

    def damped(t: Array, a: float, b: float, w: float, rate: float) -> Array:
        swung: Array = np.exp(-rate * t) * (a * np.cos(w * t) + b * np.sin(w * t))
        return swung

    late = time > 0.5
    found, _ = curve_fit(damped, time[late], ratio[late], p0=(0.0, 0.3, 2.4, 0.2))
    return float(2.0 * np.pi / abs(found[2])), float(found[3])


def swinging() -> list[Row]:
    """Cohesion's period."""
    frames = frames_of(SWING)
    period, _ = swing_of(frames)
    exact = drop_period(1.0, 1.0, 1.0, 2, 2)
    energy = np.array([frame.numbers["total_energy"] for frame in frames])
    rise = float(energy.max() - energy[0]) / frames[0].numbers["kinetic_energy"]
    return [
        within("cohesion, disc: period of a wide swing", period, exact, 0.05 * exact),
        below("cohesion, disc: rise of the total energy over that of the motion", rise, 0.01),
    ]


def pressure_inside(frame: Frame) -> float:
    """The mean of the inner half."""
    inner = np.linalg.norm(frame.arrays["position"], axis=1) < 0.5
    return float(frame.arrays["pressure"][inner].mean())


def pressed() -> list[Row]:
    """The pressure by the continuum surface force."""
    found, exact = [], laplace_pressure(1.0, 1.0, 2)
    for count in (10, 20):
        frames = frames_of(*CSF, f"spacing={1.0 / count}", "duration=3 s")
        name = f"csf, disc of {count} spacings: pressure over sigma/R, mean over time"
        found.append(within(name, np.mean([pressure_inside(frame) for frame in frames[1:]]).item() / exact, 1.0, 0.15))
    return found


def fed() -> list[Row]:
    """What it does wrong."""
    frames = frames_of(*CSF, SWING)
    period, rate = swing_of(frames)
    exact = drop_period(1.0, 1.0, 1.0, 2, 2)
    place = frames[-1].arrays["position"]
    moved = float(np.linalg.norm(np.average(place, axis=0, weights=frames[-1].arrays["mass"])))
    return [
        within("csf, disc: period of a wide swing", period, exact, 0.15 * exact),
        below("csf, disc: rate at which the swing grows, times its period", -rate * period, 0.5),
        below("csf, disc: drift over the radius", moved, 0.1),
    ]
