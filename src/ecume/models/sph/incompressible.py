"""Constants of the solver for incompressible liquids, and its requirements on other options."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

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
from ecume.models.sph.setup.choices import sides_of
from ecume.models.sph.setup.packing import (
    largest_eigenvalue,
    lattice,
    lattice_coupling,
    lattice_sum,
    surface_rows,
)
from ecume.scenes.sph import SphScene
from ecume.units import Array

TOLERANCE, ITERATIONS = 1e-5, 500


def projection_of(scene: SphScene, free_surface: bool, weight: Array) -> Projection:
    """The constants of the solver; `weight` is the density times the gravity that pressure balances at rest."""
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
        uppermost=0.5 * scene.spacing * float(np.abs(weight).sum()),
    )


def require_suitable(scene: SphScene, method: PressureMethod) -> None:
    """Raise SceneError for options that are incompatible with the pressure method."""
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
    """the option's value in the scene; empty if it is the default"""
    reason: str


def _named(part: str, key: str, *harmless: str) -> Callable[[SphScene], list[str]]:
    """A function that returns the name in a table of the scene, if it is not one of the given names."""

    def given(scene: SphScene) -> list[str]:
        value = getattr(getattr(scene, part), key)
        return [] if value in harmless else [repr(value)]

    return given


def _number(part: str, key: str, default: float | None) -> Callable[[SphScene], list[str]]:
    """A function that returns the number in a table of the scene, if it is not the default."""

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
