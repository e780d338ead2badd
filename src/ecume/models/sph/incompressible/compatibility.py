"""Constants of the solver, and what an incompressible liquid needs from other options of a scene."""

from __future__ import annotations

import itertools

import numpy as np

from ecume.errors import Fault, SceneError
from ecume.models.sph.parameters import Projection
from ecume.models.sph.rates.methods import PressureMethod
from ecume.models.sph.setup.choices import kernel_of, smoothing_of
from ecume.scenes.sph import SphScene
from ecume.units import Array

TOLERANCE, ITERATIONS = 1e-5, 500
WAVES = 33
"""Wave numbers along an axis, for the largest eigenvalue."""


def projection_of(scene: SphScene, free_surface: bool) -> Projection:
    """The solver's constants."""
    given = scene.integration
    points = lattice(scene)
    return Projection(
        tolerance=TOLERANCE if given.pressure_tolerance is None else given.pressure_tolerance,
        iterations=ITERATIONS if given.pressure_iterations is None else given.pressure_iterations,
        lattice_sum=lattice_sum(scene, points),
        step=1.0 / largest_eigenvalue(scene, points),
        free_surface=free_surface,
        full=lattice_coupling(scene, points),
    )


def lattice(scene: SphScene) -> Array:
    """(n, d) m: the points of a lattice within the support of the one at the origin, which is excluded."""
    kernel, h = kernel_of(scene), smoothing_of(scene)
    reach = int(np.ceil(kernel.support * h / scene.spacing))
    line = range(-reach, reach + 1)
    points = np.array(list(itertools.product(line, repeat=kernel.dim))) * scene.spacing
    away = np.sqrt((points**2).sum(axis=1))
    return points[(away > 0.0) & (away < kernel.support * h)]


def lattice_sum(scene: SphScene, points: Array) -> float:
    """The sum of volumes times kernel at a point of the lattice."""
    kernel, h = kernel_of(scene), smoothing_of(scene)
    away = np.concatenate([[0.0], np.sqrt((points**2).sum(axis=1))])
    return float(scene.spacing**kernel.dim * np.sum(kernel.value(away, h)))


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
    faults = list(_faults(scene, method))
    if faults:
        raise SceneError(faults)


def _faults(scene: SphScene, method: PressureMethod) -> list[Fault]:
    return []
