"""Figures without a run: the force law of the floats in a scene, and the orders of the integrators."""

from __future__ import annotations

import dataclasses
import itertools
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
from ecume.errors import BadInput
from ecume.laws import capillarity
from ecume.laws.capillarity import pair_force, pair_strength
from ecume.laws.flotation import Sphere, capillary_charge
from ecume.laws.multipole.solving import forces
from ecume.laws.pair_laws import PAIR_LAWS
from ecume.models.floating.forces import multipoles
from ecume.models.floating.forces.multipoles import bodies_and_charges
from ecume.models.floating.setup.kinds import FloatKind, distinct_kinds
from ecume.models.floating.time_integration.integrators import INTEGRATORS as MODEL_INTEGRATORS
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import (
    FloatingScene,
    FloatSpec,
    HydrodynamicsSpec,
    IntegrationSpec,
    InteractionSpec,
)
from ecume.scenes.load import load_scene
from ecume.show.curves import titled
from ecume.show.style import INK, MUTED, PALETTE, figure, plain, save, scale_for, style
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array

FURTHEST = 4.0
"""The range of forces, in capillary lengths beyond contact."""
PLACES = 40
ORDER = 16
MOST_PAIRS = 6
FORCE_LINES = {"superposition": ":", "pair-corrected": "-", "multipole": "o"}


class Forces(NamedTuple):
    """The forces of one pair of kinds, positive for repulsion (N)."""

    label: str
    distance: Array
    """m, of the centers"""
    by_method: dict[str, Array]


def force_law(path: str | os.PathLike[str], out: str | os.PathLike[str]) -> Path:
    """Draw the forces between all kinds of floats in a scene file into `out`, by each method."""
    scene: Any = load_scene(Path(path))
    if scene.model != "floating" or not PAIR_LAWS[str(scene.interaction.law)].menisci:
        named = [repr(name) for name, row in PAIR_LAWS.items() if row.menisci]
        raise BadInput(f"{os.fspath(path)}: expected a scene of floats with interaction.law = {' or '.join(named)}")
    return save(drawn_forces(scene), Path(out))


def drawn_forces(scene: Any) -> Figure:
    """The forces between all kinds of floats of a scene, by each method."""
    found = pair_forces(scene)
    length = liquid_of(scene).capillary_length
    scale = scale_for(max(float(np.abs(force).max()) for pair in found for force in pair.by_method.values()), "N")
    with style():
        drawn = figure(6.4, 4.6)
        axes = drawn.add_subplot(xlabel="gap, in capillary lengths", title=titled("Force between two floats", scene))
        for pair, color in zip(found, itertools.cycle(PALETTE[1:]), strict=False):
            gap = (pair.distance - pair.distance[0]) / length
            for method, force in pair.by_method.items():
                attracts = force[0] < 0.0
                label = f"{plain(pair.label)}: {'attract' if attracts else 'repel'}"
                size = np.abs(scale.factor * force)
                look = FORCE_LINES[method]
                axes.plot(
                    gap, size, look, color=color, markersize=3, label=label if method == "pair-corrected" else None
                )
        for method, look in FORCE_LINES.items():
            axes.plot([], [], look, color=INK, markersize=3, label=method)
        axes.set(yscale="log", ylabel=f"size of the force ({scale.unit})")
        axes.legend(fontsize=8)
    return drawn


def pair_forces(scene: Any) -> list[Forces]:
    """The forces of each pair of kinds of floats, as in a run. Raises BadInput if menisci are flat."""
    kinds, number = distinct_kinds(scene)
    names = _names(scene, number, len(kinds))
    pairs = list(itertools.combinations_with_replacement(range(len(kinds)), 2))[:MOST_PAIRS]
    charged = [pair for pair in pairs if kinds[pair[0]].charge * kinds[pair[1]].charge != 0.0]
    if not charged:
        raise BadInput("these floats do not deform the surface; no force to draw")
    return [_forces_of(scene, (kinds[i], kinds[j]), f"{names[i]} – {names[j]}") for i, j in charged]


def _names(scene: Any, number: Any, count: int) -> list[str]:
    """The name of each kind: its species, with a number if rows of one species have several kinds."""
    species = [name for given in scene.particles for name in [given.name] * given.count]
    species += [row.species_name for row in scene.rows]
    return [species[int(np.flatnonzero(number == kind)[0])] for kind in range(count)]


def _forces_of(scene: Any, pair: tuple[FloatKind, FloatKind], label: str) -> Forces:
    liquid = liquid_of(scene)
    length, touching = liquid.capillary_length, pair[0].radius + pair[1].radius
    distance = touching + FURTHEST * length * np.linspace(0.0, 1.0, PLACES) ** 2
    strength = capillarity.pair_strength(liquid.surface_tension, pair[0].charge, pair[1].charge)
    summed = np.array([capillarity.pair_force(float(each), strength, length) for each in distance])
    reach = float(distance[-1]) + touching
    bodies, numbers = bodies_and_charges(pair), np.array([0, 1])
    tables = multipoles.make_pair_tables(bodies, numbers, liquid, reach)
    beyond = np.array([multipoles.correction(tables, 0, 1, float(each))[1] for each in distance])
    solved = _by_multipoles(multipoles.make_multipoles(bodies, liquid, ORDER, reach), distance)
    by_method = {"superposition": summed, "pair-corrected": summed + beyond, "multipole": solved}
    return Forces(label, distance, by_method)


def _by_multipoles(both: multipoles.Multipoles, distance: Array) -> Array:
    """The force on the second of two floats, away from the first (N)."""
    orders, force, found = both.rims.response.shape[1], np.zeros((2, 2)), np.zeros_like(distance)
    scratch = multipoles.multipole_scratch(np.zeros((2, 2 * orders)), np.zeros((2, 0)))
    for k in range(len(distance)):
        multipoles.resolve(both, np.array([[0.0, 0.0], [distance[k], 0.0]]), scratch)
        forces(both.rims, scratch.amplitudes, scratch.waves, force)
        found[k] = both.tension * both.length * force[1, 0]
    return found


TITLES = {
    "explicit-euler": "explicit Euler",
    "semi-implicit-euler": "semi-implicit Euler",
    "velocity-verlet": "velocity Verlet",
    "stormer-verlet": "Störmer–Verlet",
    "rk4": "Runge–Kutta 4",
}
_WITH_INERTIA = [name for name, row in MODEL_INTEGRATORS.items() if "keeps inertia" in row.gives]
INTEGRATORS = {name: TITLES.get(name, name) for name in sorted(_WITH_INERTIA, key=[*TITLES, *_WITH_INERTIA].index)}
"""The integrators of the model that orbits can be compared with, and their names in the figure."""
_FURTHER = [name for name in INTEGRATORS if name not in TITLES]
ORDER_LINES: dict[str, Any] = dict(zip(TITLES, ("-", "-", "-", (0, (4, 2)), "-"), strict=True))
ORDER_LINES |= dict.fromkeys(_FURTHER, ":")
COLORS = dict(zip(TITLES, (PALETTE[0], PALETTE[4], PALETTE[1], PALETTE[5], PALETTE[2]), strict=True))
COLORS |= dict(zip(_FURTHER, itertools.cycle((PALETTE[3], INK, MUTED)), strict=False))

RADIUS, DENSITY, CONTACT_ANGLE = 1e-3, 2000.0, math.pi / 2
DISTANCE = 5e-3
"""The initial distance of the centers (m): twice the capillary length, 1.5 diameters of free water
between the spheres.
"""
LESS_THAN_CIRCULAR = 0.9
"""The initial speed over that of a circular orbit: the spheres approach without contact."""

STEPS = (160, 320, 640, 1280, 2560, 5120)
"""The numbers of steps per orbit, for the errors after a quarter of an orbit."""
REFERENCE_STEPS = 20480
LONG_STEPS, ORBITS, LOOKS = 320, 60, 16
"""The numbers of steps per orbit, of orbits, and of frames per orbit, for the energy."""
QUARTER = LOOKS // 4


ROUNDING = 1e-14
"""The error (m) below which rounding dominates."""


class Orbit(NamedTuple):
    """The circle that approximates the orbit of the two spheres."""

    period: float
    speed: float


class Comparison(NamedTuple):
    """The results of the integrators."""

    steps: Array
    """s"""
    errors: Mapping[str, Array]
    """m: distance from the reference after a quarter of an orbit, for each step"""
    times: Array
    """s"""
    drifts: Mapping[str, Array]
    """largest change of the energy in each orbit, over the kinetic energy at the start"""


def integrator_comparison(out: str | os.PathLike[str]) -> Path:
    """Draw the comparison of all integrators into `out`. Returns the written file."""
    return save(integrators_beside_one_another(comparison()), Path(out))


def comparison() -> Comparison:
    """Integrate part of an orbit with decreasing time steps, and many orbits with one time step, by each integrator."""
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
        look: dict[str, Any] = {"color": COLORS[name], "linestyle": ORDER_LINES[name]}
        axes.plot(scale.factor * found.steps, 1e3 * found.errors[name], marker="o", markersize=4, label=label, **look)
    axes.set(
        xscale="log", yscale="log", xlabel=f"time step ({scale.unit})", ylabel="error after a quarter of an orbit (mm)"
    )
    axes.set_xticks(scale.factor * found.steps, [f"{scale.factor * step:.2g}" for step in found.steps])
    axes.minorticks_off()
    axes.set_title("Error and step")


def _drifts(axes: Axes, found: Comparison) -> None:
    for name, drift in found.drifts.items():
        axes.plot(found.times, drift, color=COLORS[name], linestyle=ORDER_LINES[name])
    axes.set(yscale="log", xlabel="time (s)", ylabel="change of energy / first kinetic energy")
    axes.set_title(f"Energy, {LONG_STEPS} steps an orbit")


def _travel(integrator: str, orbit: Orbit, steps: int, looks: int) -> list[Frame]:
    """The frames of a simulation with this number of steps per orbit; there are sixteen frames per orbit."""
    step = orbit.period / steps
    scene = _scene(orbit.speed, IntegrationSpec(integrator=integrator, time_step=step))
    every = steps // LOOKS * step
    scene = dataclasses.replace(scene, frame_every=every, duration=looks * every)
    with warnings.catch_warnings():
        # The comparison needs coarse steps.
        warnings.simplefilter("ignore", UserWarning)
        return list(simulate(scene))


def _error(integrator: str, orbit: Orbit, steps: int, exact: Frame) -> float:
    """The distance of the first sphere from its exact position after a quarter of an orbit (m)."""
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
        # The cutoff must be beyond the orbit: a jump of the force would reduce the order of each integrator.
        interaction=InteractionSpec(accuracy=1e-9),
    )


def _orbit() -> Orbit:
    """A circular orbit of both spheres around their center under their attraction: m v^2 / (l/2) = -F."""
    liquid = liquid_of(_scene(speed=0.0, integration=IntegrationSpec()))
    charge = capillary_charge(Sphere(RADIUS, DENSITY, CONTACT_ANGLE), liquid, "nonlinear")
    strength = pair_strength(liquid.surface_tension, charge, charge)
    mass = 4.0 / 3.0 * math.pi * RADIUS**3 * DENSITY
    speed = math.sqrt(-pair_force(DISTANCE, strength, liquid.capillary_length) * DISTANCE / 2 / mass)
    return Orbit(math.pi * DISTANCE / speed, speed)
