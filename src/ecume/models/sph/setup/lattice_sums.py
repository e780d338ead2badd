"""Sums over the neighbors of a particle in a lattice, and over waves of the lattice: constants of the pressure solver
for incompressible liquids, and the limit of particle shifting.
"""

from __future__ import annotations

import itertools

import numpy as np

from ecume._portable import length
from ecume.laws.shifting import tensile_weight
from ecume.models.sph.setup.choices import kernel_of, smoothing_of
from ecume.scenes.sph import SphScene
from ecume.units import Array

DISORDER = 0.1
"""Gradients of disordered liquid, over those at a surface."""
WAVES = 33
"""Wave numbers along an axis, for the largest eigenvalue."""


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
    phases = wave_vectors(scene, WAVES) @ points.T
    exact = ((volume * np.sin(phases) @ gradient) ** 2).sum(axis=1)
    compact = 2.0 * volume * (1.0 - np.cos(phases)) @ steepness
    own = float(volume**2 * (gradient**2).sum() + 2.0 * volume * steepness.sum())
    return float((exact + compact).max()) / own


def wave_vectors(scene: SphScene, count: int) -> Array:
    """(W, d) 1/m: waves along the axes and between them, up to the shortest that the lattice resolves."""
    dimension = kernel_of(scene).dim
    return np.array(list(itertools.product(np.linspace(0.0, np.pi / scene.spacing, count), repeat=dimension)))


def shifting_limit(scene: SphScene) -> float:
    """m^2: the largest product of the shifting coefficient and time that moves no wave of small displacements in the
    lattice beyond rest: the inverse of the largest eigenvalue of minus the change of the concentration gradient.
    """
    kernel, h, points = kernel_of(scene), smoothing_of(scene), lattice(scene)
    volume, usual = scene.spacing**kernel.dim, kernel.value(scene.spacing, h)

    def pull(places: Array) -> Array:
        value = np.asarray(kernel.value(np.sqrt((places**2).sum(axis=1)), h))
        found: Array = volume * tensile_weight(value / usual)[:, None] * kernel.gradient(places, h)
        return found

    little = 1e-5 * scene.spacing
    steps = little * np.eye(kernel.dim)
    change = np.stack([(pull(points + step) - pull(points - step)) / (2.0 * little) for step in steps], axis=2)
    waves = wave_vectors(scene, WAVES if kernel.dim == 2 else WAVES // 2 + 1)
    response = np.tensordot(1.0 - np.cos(waves @ points.T), change, axes=1)
    return 1.0 / float(np.linalg.eigvalsh(0.5 * (response + response.transpose(0, 2, 1))).max())
