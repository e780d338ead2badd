"""Constants of the solver for incompressible liquids, and what such a liquid needs from other options of a scene."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ecume._portable import length
from ecume.errors import Fault, SceneError
from ecume.models.sph.parameters import Projection
from ecume.models.sph.rates.methods import (
    BODIES,
    BUFFERS,
    DENSITY_FORCES,
    DENSITY_RATE,
    SOLVER,
    SOUND,
    PressureMethod,
)
from ecume.models.sph.setup.choices import kernel_of, sides_of, smoothing_of
from ecume.scenes.sph import SphScene
from ecume.units import Array

TOLERANCE, ITERATIONS = 1e-5, 500
DISORDER = 0.1
"""Gradients of disordered liquid, over those at a surface."""
WAVES = 33
"""Wave numbers along an axis, for the largest eigenvalue."""


def projection_of(scene: SphScene, free_surface: bool) -> Projection:
    """The solver's constants."""
    given = scene.integration
    points = lattice(scene)
    steepness, missing = surface_rows(scene, points)
    return Projection(
        tolerance=TOLERANCE if given.pressure_tolerance is None else given.pressure_tolerance,
        iterations=ITERATIONS if given.pressure_iterations is None else given.pressure_iterations,
        lattice_sum=lattice_sum(scene, points),
        step=1.0 / largest_eigenvalue(scene, points),
        free_surface=free_surface,
        steepness=steepness,
        missing=missing,
        full=lattice_coupling(scene, points),
    )


def lattice(scene: SphScene) -> Array:
    """(n, d) m: the points of a lattice within the support of the one at the origin, which is excluded."""
    kernel, h = kernel_of(scene), smoothing_of(scene)
    reach = int(np.ceil(kernel.support * h / scene.spacing))
    line = range(-reach, reach + 1)
    points = np.array(list(itertools.product(line, repeat=kernel.dim))) * scene.spacing
    away = np.sqrt((points**2).sum(axis=1))
    near: Array = points[(away > 0.0) & (away < kernel.support * h)]
    return near


def lattice_sum(scene: SphScene, points: Array) -> float:
    """The sum of volumes times kernel at a point of the lattice."""
    kernel, h = kernel_of(scene), smoothing_of(scene)
    away = np.concatenate([[0.0], np.sqrt((points**2).sum(axis=1))])
    return float(scene.spacing**kernel.dim * np.sum(kernel.value(away, h)))


def surface_rows(scene: SphScene, points: Array) -> tuple[Array, Array]:
    """|sum of V grad W| (1/m) and the missing density, over the density, in the rows below the flat surface of a
    lattice, the deepest first. Rows of less than a tenth of the largest gradient count as full, as disorder does.
    """
    kernel, h = kernel_of(scene), smoothing_of(scene)
    volume, total = scene.spacing**kernel.dim, lattice_sum(scene, points)
    gradient, value = kernel.gradient(points, h), np.asarray(kernel.value(np.sqrt((points**2).sum(axis=1)), h))
    rows = []
    for depth in range(int(np.ceil(kernel.support * h / scene.spacing))):
        above = points[:, 1] > (depth + 0.5) * scene.spacing
        rows.append((volume * length(gradient[~above].sum(axis=0)), volume * float(value[above].sum()) / total))
    flat = DISORDER * rows[0][0]
    found = [(flat, 0.0), *[row for row in reversed(rows) if row[0] > flat]]
    return np.array([row[0] for row in found]), np.array([row[1] for row in found])


def lattice_coupling(scene: SphScene, points: Array) -> float:
    """The sum -sum_j V_j F_ij at a point of the lattice, 1/m^2."""
    kernel, h = kernel_of(scene), smoothing_of(scene)
    steepness = np.sqrt((kernel.gradient(points, h) ** 2).sum(axis=1) / (points**2).sum(axis=1))
    return float(scene.spacing**kernel.dim * steepness.sum())


def largest_eigenvalue(scene: SphScene, points: Array) -> float:
    """The largest eigenvalue of A over its diagonal, in a lattice: among waves along the axes and between them."""
    kernel, h = kernel_of(scene), smoothing_of(scene)
    volume, gradient = scene.spacing**kernel.dim, kernel.gradient(points, h)
    steepness = np.sqrt((gradient**2).sum(axis=1) / (points**2).sum(axis=1))
    waves = np.array(list(itertools.product(np.linspace(0.0, np.pi / scene.spacing, WAVES), repeat=kernel.dim)))
    phases = waves @ points.T
    exact = ((volume * np.sin(phases) @ gradient) ** 2).sum(axis=1)
    compact = 2.0 * volume * (1.0 - np.cos(phases)) @ steepness
    own = float(volume**2 * (gradient**2).sum() + 2.0 * volume * steepness.sum())
    return float((exact + compact).max()) / own


def require_suitable(scene: SphScene, method: PressureMethod) -> None:
    """Refuse options that need what the pressure method lacks. Raises SceneError."""
    faults = [
        Fault(need.path, f"got {got}; {need.reason}")
        for need in NEEDS
        if need.capability not in method.has
        for got in need.given(scene)
    ]
    if faults:
        raise SceneError(faults)


class Need(NamedTuple):
    """An option that needs a capability of the pressure method."""

    path: str
    capability: str
    given: Callable[[SphScene], list[str]]
    """the option as the scene has it; empty where it has its default"""
    reason: str


def _named(part: str, key: str, *harmless: str) -> Callable[[SphScene], list[str]]:
    """A name in a table of the scene, other than these."""

    def given(scene: SphScene) -> list[str]:
        value = getattr(getattr(scene, part), key)
        return [] if value in harmless else [repr(value)]

    return given


def _number(part: str, key: str, default: float | None) -> Callable[[SphScene], list[str]]:
    """A number in a table of the scene, other than the default."""

    def given(scene: SphScene) -> list[str]:
        value = getattr(getattr(scene, part), key)
        return [] if value == default else [f"{value:g}"]

    return given


def _gates(scene: SphScene) -> list[str]:
    kinds = [side.kind for side in sides_of(scene) if side.kind in ("inflow", "outflow")]
    return [repr(kinds[0])] if kinds else []


TAIT = 'use method.pressure = "tait"'
NEEDS = (
    Need("integration.integrator", DENSITY_RATE, _named("integration", "integrator", "automatic", "projection"),
         f"integrates the density by its rate, which is zero in an incompressible liquid; use 'projection', or {TAIT}"),
    Need("integration.integrator", SOLVER,
         lambda scene: ["'projection'"] if scene.integration.integrator == "projection" else [],
         'solves for the pressure, which Tait\'s equation determines; use \'symplectic\', or method.pressure = '
         '"incompressible"'),
    Need("integration.pressure_tolerance", SOLVER, _number("integration", "pressure_tolerance", None),
         'is for method.pressure = "incompressible"; Tait\'s equation has nothing to solve'),
    Need("integration.pressure_iterations", SOLVER, _number("integration", "pressure_iterations", None),
         'is for method.pressure = "incompressible"; Tait\'s equation has nothing to solve'),
    Need("liquid.sound_speed", SOUND, _number("liquid", "sound_speed", None),
         f"an incompressible liquid has no sound waves; remove the key, or {TAIT}"),
    Need("liquid.tait_exponent", SOUND, _number("liquid", "tait_exponent", 7.0),
         f"an incompressible liquid has no equation of state; remove the key, or {TAIT}"),
    Need("method.density_diffusion", DENSITY_RATE, _named("method", "density_diffusion", "automatic", "none"),
         f"smooths densities that are integrated in time; an incompressible liquid has none; use 'none', or {TAIT}"),
    Need("method.pressure_force", DENSITY_FORCES, _named("method", "pressure_force", "sum"),
         "weighs pressures with densities that differ, or completes gradients; only the sum is the adjoint of the "
         f"divergence that is solved for; use 'sum', or {TAIT}"),
    Need("tank", BUFFERS, _gates,
         "the buffer behind it has a separate pressure: the solver knows only pressures at free surfaces and walls; "
         f"{TAIT}"),
    Need("bodies", BODIES, lambda scene: [f"{len(scene.bodies)} bodies"] if scene.bodies else [],
         "the pressure of an incompressible liquid depends on the acceleration of bodies at the same instant, which is "
         f"not part of the equation that is solved; {TAIT}"),
)  # fmt: skip
