"""The integrators beside one another: how errors fall with the step, and what becomes of the energy in the long run.

Two heavy spheres on water orbit each other without drag; what is drawn is what the model itself does with each scheme.
"""

from __future__ import annotations

import dataclasses
import math
import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ecume.analysis.series import number, series
from ecume.laws.capillarity import pair_force, pair_strength
from ecume.laws.flotation import Sphere, capillary_charge
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import (
    FloatingScene,
    FloatSpec,
    HydrodynamicsSpec,
    IntegrationSpec,
    InteractionSpec,
)
from ecume.show.style import PALETTE, figure, save, scale_for, style
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array

INTEGRATORS = {
    "explicit-euler": "explicit Euler",
    "semi-implicit-euler": "semi-implicit Euler",
    "velocity-verlet": "velocity Verlet",
    "stormer-verlet": "Störmer–Verlet",
    "rk4": "Runge–Kutta 4",
}
LINES = dict(zip(INTEGRATORS, ("-", "-", "-", (0, (4, 2)), "-"), strict=True))
COLORS = dict(zip(INTEGRATORS, (PALETTE[0], PALETTE[4], PALETTE[1], PALETTE[5], PALETTE[2]), strict=True))

RADIUS, DENSITY, CONTACT_ANGLE = 1e-3, 2000.0, math.pi / 2
DISTANCE = 5e-3
"""Of the centers at the start, m: twice the capillary length, 1.5 diameters of free water between the spheres."""
LESS_THAN_CIRCULAR = 0.9
"""The speed at the start, over that of a circular orbit: the spheres come nearer, and do not touch."""

STEPS = (160, 320, 640, 1280, 2560, 5120)
"""Steps an orbit, for the errors after a quarter of one."""
REFERENCE_STEPS = 20480
LONG_STEPS, ORBITS, LOOKS = 320, 60, 16
"""Steps an orbit, orbits, and frames an orbit, for the energy."""
QUARTER = LOOKS // 4


ROUNDING = 1e-14
"""Errors below this (m) are no longer the scheme's."""


class Orbit(NamedTuple):
    """The circular orbit that the spheres nearly go through."""

    period: float
    speed: float


class Comparison(NamedTuple):
    """What the integrators did."""

    steps: Array
    """s"""
    errors: Mapping[str, Array]
    """m: distance from the reference after a quarter of an orbit, for each step"""
    times: Array
    """s"""
    drifts: Mapping[str, Array]
    """largest change of the energy in each orbit, over the kinetic energy at the start"""


def integrator_comparison(out: str | os.PathLike[str]) -> Path:
    """Draw the comparison of all integrators into `out`. Returns the file that was written."""
    return save(integrators_beside_one_another(comparison()), Path(out))


def comparison() -> Comparison:
    """Let each integrator go through part of an orbit in ever smaller steps, and through many in steps of one size."""
    orbit = _orbit()
    (*_, exact) = _travel("rk4", orbit, REFERENCE_STEPS, QUARTER)
    errors = {name: np.array([_error(name, orbit, steps, exact) for steps in STEPS]) for name in INTEGRATORS}
    drifts = {name: _drift(_travel(name, orbit, LONG_STEPS, ORBITS * LOOKS)) for name in INTEGRATORS}
    return Comparison(
        orbit.period / np.array(STEPS, dtype=np.float64), errors, orbit.period * np.arange(1.0, ORBITS + 1), drifts
    )


def orders(found: Comparison) -> dict[str, float]:
    """The order of each integrator: the slope of its error over the step, where the error is well above round-off."""
    slopes = {}
    for name, error in found.errors.items():
        good = error > ROUNDING
        slopes[name] = float(np.polyfit(np.log(found.steps[good][-3:]), np.log(error[good][-3:]), 1)[0])
    return slopes


def integrators_beside_one_another(found: Comparison) -> Figure:
    """Errors over the step, and energies over time."""
    with style():
        drawn = figure(9.0, 4.4)
        left, right = drawn.subplots(1, 2)
        _errors(left, found)
        _drifts(right, found)
        drawn.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return drawn


def _errors(axes: Axes, found: Comparison) -> None:
    scale = scale_for(float(found.steps.max()), "s")
    for name, slope in orders(found).items():
        label = f"{INTEGRATORS[name]} (order {slope:.1f})"
        look: dict[str, Any] = {"color": COLORS[name], "linestyle": LINES[name]}
        axes.plot(scale.factor * found.steps, 1e3 * found.errors[name], marker="o", markersize=4, label=label, **look)
    axes.set(
        xscale="log", yscale="log", xlabel=f"time step ({scale.unit})", ylabel="error after a quarter of an orbit (mm)"
    )
    axes.set_xticks(scale.factor * found.steps, [f"{scale.factor * step:.2g}" for step in found.steps])
    axes.minorticks_off()
    axes.set_title("Error and step")


def _drifts(axes: Axes, found: Comparison) -> None:
    for name, drift in found.drifts.items():
        axes.plot(found.times, drift, color=COLORS[name], linestyle=LINES[name])
    axes.set(yscale="log", xlabel="time (s)", ylabel="change of energy / first kinetic energy")
    axes.set_title(f"Energy, {LONG_STEPS} steps an orbit")


def _travel(integrator: str, orbit: Orbit, steps: int, looks: int) -> list[Frame]:
    """The frames of a journey with that many steps an orbit; sixteen looks are an orbit."""
    step = orbit.period / steps
    scene = _scene(orbit.speed, IntegrationSpec(integrator=integrator, time_step=step))
    every = steps // LOOKS * step
    scene = dataclasses.replace(scene, frame_every=every, duration=looks * every)
    with warnings.catch_warnings():
        # The comparison needs coarse steps.
        warnings.simplefilter("ignore", UserWarning)
        return list(simulate(scene))


def _error(integrator: str, orbit: Orbit, steps: int, exact: Frame) -> float:
    """How far the first sphere is from where it should be after a quarter of an orbit (m)."""
    (*_, last) = _travel(integrator, orbit, steps, QUARTER)
    return float(np.linalg.norm(last.arrays["position"][0] - exact.arrays["position"][0]))


def _drift(frames: list[Frame]) -> Array:
    """The largest change of the energy in each orbit."""
    total, kinetic = series(frames, number("total_energy"), number("kinetic_energy"))
    largest: Array = np.abs(total[1:] - total[0]).reshape(-1, LOOKS).max(axis=1) / kinetic[0]
    return largest


def _scene(speed: float, integration: IntegrationSpec) -> FloatingScene:
    """Two spheres side by side on open water, thrown in opposite directions."""
    half, throw = DISTANCE / 2, LESS_THAN_CIRCULAR * speed
    starts = {"left": (-half, -throw), "right": (half, throw)}
    sphere: dict[str, Any] = {"radius": RADIUS, "density": DENSITY, "contact_angle": CONTACT_ANGLE}
    return FloatingScene(
        duration=1.0,
        frame_every=1.0,
        particles=tuple(
            FloatSpec(name=name, positions=((x, 0.0),), velocity=(0.0, v), **sphere) for name, (x, v) in starts.items()
        ),
        integration=integration,
        hydrodynamics=HydrodynamicsSpec(drag="none"),
        # The force must not end within the orbit's reach: a jump there would spoil every order.
        interaction=InteractionSpec(accuracy=1e-9),
    )


def _orbit() -> Orbit:
    """Each sphere goes round the middle of both, held by their attraction: m v^2 / (l/2) = -F."""
    liquid = liquid_of(_scene(speed=0.0, integration=IntegrationSpec()))
    charge = capillary_charge(Sphere(RADIUS, DENSITY, CONTACT_ANGLE), liquid, "nonlinear")
    strength = pair_strength(liquid.surface_tension, charge, charge)
    mass = 4.0 / 3.0 * math.pi * RADIUS**3 * DENSITY
    speed = math.sqrt(-pair_force(DISTANCE, strength, liquid.capillary_length) * DISTANCE / 2 / mass)
    return Orbit(math.pi * DISTANCE / speed, speed)
